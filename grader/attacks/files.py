"""Links, pipes, device files, path tricks, bombs."""

import io
import os
import zipfile

from grader.attacks import Target, attack, submit


@attack("files")
def link_to_the_gradebook(target: Target) -> None:
    """The notebook is a link to the gradebook, and other links lie beside it."""
    target.file.symlink_to(target.course / "gradebook.db")
    (target.folder / "data.txt").symlink_to(target.course / "gradebook.db")
    (target.folder / "everything").symlink_to("/")


@attack("files")
def link_to_a_classmate(target: Target) -> None:
    """The notebook is a link to a classmate's right one."""
    target.file.symlink_to(
        os.path.join("..", "..", "honest1", target.folder.name, target.file.name)
    )


@attack("files")
def hard_link_to_the_solutions(target: Target) -> None:
    """The notebook is a hard link to the instructor's."""
    os.link(target.course / "source" / target.folder.name / target.file.name, target.file)


@attack("files", deserves=True)
def hard_link_to_a_classmate(target: Target) -> None:
    """The notebook is a hard link to a classmate's: no more than a copy, but the classmate must not pay for it."""
    os.link(
        target.course / "submitted" / "honest1" / target.folder.name / target.file.name, target.file
    )


@attack("files")
def folder_is_a_link(target: Target) -> None:
    """The whole folder is a link to a classmate's."""
    target.folder.rmdir()
    target.folder.symlink_to(target.course / "submitted" / "honest1" / target.folder.name)


@attack("files")
def link_to_the_solutions(target: Target) -> None:
    """The notebook is a link to the instructor's."""
    target.file.symlink_to(target.course / "source" / target.folder.name / target.file.name)


@attack("files")
def endless_pipe(target: Target) -> None:
    """The notebook is a pipe that nobody writes to."""
    os.mkfifo(target.file)


@attack("files")
def endless_device(target: Target) -> None:
    """The notebook is a link to a device that never ends."""
    target.file.symlink_to("/dev/zero")


@attack("files")
def folder_as_notebook(target: Target) -> None:
    """The notebook is a folder."""
    (target.file / "inner").mkdir(parents=True)


@attack("files")
def link_loop(target: Target) -> None:
    """The notebook is a link to itself."""
    target.file.symlink_to(target.file.name)


@attack("files")
def zip_bomb(target: Target) -> bytes:
    """A compressed gigabyte under the notebook's name."""
    store = io.BytesIO()
    with zipfile.ZipFile(store, "w", zipfile.ZIP_DEFLATED) as bomb:
        bomb.writestr("a.ipynb", b"0" * 50_000_000)
    return store.getvalue()


@attack("files")
def sparse_giant(target: Target) -> None:
    """A file of a terabyte, most of it holes."""
    with target.file.open("wb") as file:
        file.write(b"{")
        file.truncate(2**40)


@attack("files", deserves=False)
def other_names(target: Target) -> None:
    """Notebooks under names that lead elsewhere, a time stamp that is a program; none where it belongs."""
    for name in ("..%2f..%2fgradebook.ipynb", "heading (1).ipynb", "*.ipynb", "-rf.ipynb"):
        (target.folder / name).write_bytes(submit(target, target.right))
    (target.folder / "timestamp.txt").write_text("__import__('os').system('touch /tmp/pwned')")
