"""Graft a submission onto the release notebook: only answers, and cells of the student's own, come from the student.

The release notebook is the truth. Its cells, their order, types, points and metadata cannot be changed by a
submission; cells that were damaged, renamed, deleted, doubled or retyped therefore do not matter. A file that is no
notebook becomes the release notebook with a note.
"""

from __future__ import annotations

import copy
import errno
import json
import os
import re
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from grader.markdown import harmless

MAX_FILE = 20 * 2**20  # bytes of a submission
MAX_PARTS = 300_000  # lists and records in it: each costs a hundred times its two bytes
MAX_CELLS = 2000
MAX_CELL = 100_000  # characters of one cell
MAX_EXTRA = 100  # cells of the student's own
MAX_EXTRA_TEXT = 500_000  # characters of these, together
NOTE_ID, OWN = "graft-note", "own-"  # cell ids: the note, and how those of own cells begin
METADATA = "uavlab_graft"  # key of the notebook's metadata: {"readable": bool, "notes": [str]}

Cell = dict[str, Any]
Notebook = dict[str, Any]


class NotANotebook(Exception):
    """The submitted file cannot be read as a notebook; the message says why."""


class Graft(NamedTuple):
    """The notebook that is graded, and what had to be said about the one that was submitted."""

    notebook: Notebook
    notes: list[str]
    readable: bool


# Reading --------------------------------------------------------------------------------------------


def read_bytes(path: Path, root: Path) -> bytes:
    """The contents of a submitted file, if it is one.

    `root` is the folder of all submissions: a link on the way from there to `path` is not followed.
    """
    fd = _open_below(root, path.relative_to(root).parts)
    try:
        found = os.fstat(fd)
        _regular(found)
        if found.st_nlink > 1 and _is_ours(found, root):
            raise NotANotebook("it is a hard link to a file of the course")
        with open(fd, "rb", closefd=False) as file:
            return file.read(MAX_FILE + 1)
    finally:
        os.close(fd)


def _open_below(root: Path, parts: tuple[str, ...]) -> int:
    """Open a file step by step below `root`: a link that is put there in between is not followed either."""
    fd = os.open(root, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        for part in parts[:-1]:
            fd, above = _open(part, os.O_DIRECTORY, fd), fd
            os.close(above)
        # Opening a pipe or a device must not block.
        return _open(parts[-1], os.O_NONBLOCK, fd)
    finally:
        os.close(fd)


def _open(name: str, how: int, folder: int) -> int:
    try:
        return os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC | how, dir_fd=folder)
    except FileNotFoundError:
        raise NotANotebook("there is no such file") from None
    except OSError as error:
        if error.errno in {errno.ELOOP, errno.ENOTDIR}:
            raise NotANotebook("it is a link to another place") from None
        raise NotANotebook(f"it cannot be opened ({error.strerror})") from None


def _regular(found: os.stat_result) -> None:
    if not stat.S_ISREG(found.st_mode):
        raise NotANotebook("it is not a regular file")
    if found.st_size > MAX_FILE:
        size = found.st_size / 2**20
        raise NotANotebook(f"it has {size:.0f} MiB; at most {MAX_FILE // 2**20} are read")


def _is_ours(found: os.stat_result, root: Path) -> bool:
    """Whether a file is also one of the course's: the gradebook, the instructor's notebook."""
    same = (found.st_dev, found.st_ino)
    for folder, folders, files in os.walk(root.parent):
        if Path(folder) == root.parent:
            folders.remove(root.name)
        for name in files:
            status = os.lstat(os.path.join(folder, name))
            if (status.st_dev, status.st_ino) == same:
                return True
    return False


def parse(data: bytes) -> list[Cell]:
    """The cells of a submitted notebook, each with the few fields that are used, as plain text."""
    if not data.strip():
        raise NotANotebook("the file is empty")
    if data.count(b"{") + data.count(b"[") > MAX_PARTS:
        raise NotANotebook(f"it has more than {MAX_PARTS} parts; clear its outputs and save it")
    try:
        notebook = json.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError, MemoryError) as error:
        raise NotANotebook("it is not JSON, or it was cut short") from error
    if not isinstance(notebook, dict) or not isinstance(notebook.get("cells"), list):
        raise NotANotebook("it has no list of cells")
    if len(notebook["cells"]) > MAX_CELLS:
        raise NotANotebook(f"it has {len(notebook['cells'])} cells; at most {MAX_CELLS} are read")
    if notebook.get("nbformat") != 4:
        raise NotANotebook("it is not in notebook format 4: open it in JupyterLab and save it")
    return [c for c in map(_plain, notebook["cells"]) if c is not None]


def _plain(cell: Any) -> Cell | None:
    if not isinstance(cell, dict):
        return None
    source = cell.get("source", "")
    if isinstance(source, list) and all(isinstance(line, str) for line in source):
        source = "".join(source)
    if not isinstance(source, str):
        return None
    source = source.encode("utf-8", "replace").decode()  # lone surrogates cannot be written again
    metadata = cell.get("metadata")
    mark = metadata.get("nbgrader") if isinstance(metadata, dict) else None
    grade_id = mark.get("grade_id") if isinstance(mark, dict) else None
    return {
        "type": "code" if cell.get("cell_type") == "code" else "markdown",
        "source": source,
        "ids": {x for x in (grade_id, cell.get("id")) if isinstance(x, str)},
        "grade_id": grade_id if isinstance(grade_id, str) else "",
    }


# Grafting -------------------------------------------------------------------------------------------


def graft(release: Notebook, submitted: list[Cell]) -> Graft:
    """The release notebook with the answers and the own cells of a submission; its notes are not shown yet."""
    work = _Work(release)
    work.place(submitted)
    work.rescue()
    return Graft(work.result(), work.notes, True)


def graft_file(release: Notebook, path: Path, root: Path) -> Graft:
    """Graft the file at `path`; one that is not a notebook gives the release notebook and a note."""
    try:
        made = graft(release, parse(read_bytes(path, root)))
        if path.lstat().st_nlink > 1:
            made.notes.append("The submitted file has a second name (a hard link): whose is it?")
        return _finish(made.notebook, made.notes, readable=True)
    except (NotANotebook, OSError, MemoryError, RecursionError) as error:
        why = "it takes too much memory" if isinstance(error, MemoryError) else error
        notes = [f"The submitted file {path.name} cannot be read as a notebook: {why}."]
        return _finish(copy.deepcopy(release), notes, readable=False)


def is_answer(cell: Cell) -> bool:
    """Whether a release cell is one that students write."""
    return bool(cell.get("metadata", {}).get("nbgrader", {}).get("solution"))


def text(cell: Cell) -> str:
    """A cell's source; files may hold a list of lines."""
    source = cell["source"]
    return source if isinstance(source, str) else "".join(source)


class _Work:
    """One graft: release cells, what was found for each answer, and the extra cells after each."""

    def __init__(self, release: Notebook) -> None:
        self.release = copy.deepcopy(release)
        self.cells: list[Cell] = self.release["cells"]
        self.places = {name: i for i, cell in enumerate(self.cells) for name in _names(cell)}
        self.by_text = {text(cell): i for i, cell in enumerate(self.cells) if text(cell).strip()}
        self.found: dict[int, list[str]] = {}
        self.extra: dict[int, list[Cell]] = {}
        self.notes: list[str] = []

    def place(self, submitted: Iterable[Cell]) -> None:
        """Find the place of every submitted cell: an answer, a release cell, or one after the last known."""
        anchor = -1
        for cell in submitted:
            at = self._home(cell)
            if at is None:
                self.extra.setdefault(anchor, []).append(cell)
                continue
            anchor = at
            if is_answer(self.cells[at]):
                self.found.setdefault(at, []).append(cell["source"])
            elif self._edited(cell, at):
                self.extra.setdefault(at, []).append(cell)

    def _home(self, cell: Cell) -> int | None:
        if cell["grade_id"] in self.places:
            return self.places[cell["grade_id"]]
        for name in sorted(cell["ids"]):
            if name in self.places:
                return self.places[name]
        return self.by_text.get(cell["source"])

    def _edited(self, cell: Cell, at: int) -> bool:
        """A student may add imports to a cell that is not locked: kept as a cell of their own after it."""
        ours = self.cells[at]
        locked = "nbgrader" in ours.get("metadata", {})
        both = cell["type"] == ours["cell_type"] == "code"
        return both and not locked and cell["source"].strip() != text(ours).strip()

    def rescue(self) -> None:
        """Take an answer whose cell is gone from the last own cell that defines it."""
        for at, cell in enumerate(self.cells):
            name = _name(cell).removeprefix("answer-")
            if at in self.found or not is_answer(cell) or cell["cell_type"] != "code":
                continue
            defines = re.compile(rf"^(?:def|class) {re.escape(name)}\b", re.MULTILINE)
            for own in self.extra.values():
                match = [c for c in own if c["type"] == "code" and defines.search(c["source"])]
                if match:
                    own.remove(match[-1])
                    self.found[at] = [match[-1]["source"]]
                    self.notes.append(f"The answer {name} was found in another cell.")
                    break

    def result(self) -> Notebook:
        """The grafted notebook."""
        room = [MAX_EXTRA, MAX_EXTRA_TEXT]
        cells = self._own(-1, room)
        for at, cell in enumerate(self.cells):
            if is_answer(cell):
                self._answer(at, cell)
            cells += [cell, *self._own(at, room)]
        self.release["cells"] = cells
        return self.release

    def _answer(self, at: int, cell: Cell) -> None:
        name, stub = _name(cell), text(cell)
        found = self.found.get(at, [])
        if not found:
            self.notes.append(f"The cell {name} is missing from the submission.")
        changed = [s for s in found if s.strip() != stub.strip()]
        if len(found) > 1:
            self.notes.append(
                f"There are {len(found)} cells {name}; the last that was changed counts."
            )
        source = changed[-1] if changed else stub
        if len(source) > MAX_CELL:
            self.notes.append(
                f"The cell {name} has more than {MAX_CELL} characters and is not read."
            )
            source = stub
        is_ours = source == stub
        cell["source"] = source if cell["cell_type"] == "code" or is_ours else harmless(source)

    def _own(self, at: int, room: list[int]) -> list[Cell]:
        """The student's own cells after a release cell, as long as there is room."""
        made = []
        for cell in self.extra.get(at, []):
            room[0] -= 1
            room[1] -= len(cell["source"])
            if min(room) < 0 or len(cell["source"]) > MAX_CELL:
                if not any(n.startswith("Own cells") for n in self.notes):
                    self.notes.append("Own cells that are too many or too long are left out.")
                continue
            made.append(_own_cell(cell, f"{OWN}{MAX_EXTRA - room[0]}"))
        return made


def _own_cell(cell: Cell, name: str) -> Cell:
    if cell["type"] == "markdown":
        return _markdown(harmless(cell["source"]), name)
    code: Cell = {"cell_type": "code", "id": name, "metadata": {}, "source": cell["source"]}
    return {**code, "execution_count": None, "outputs": []}


def _markdown(source: str, name: str) -> Cell:
    return {"cell_type": "markdown", "id": name, "metadata": {}, "source": source}


def _finish(notebook: Notebook, notes: list[str], *, readable: bool) -> Graft:
    """Drop every output, and show the notes to whoever reads the notebook: grader and student."""
    notebook.setdefault("metadata", {})[METADATA] = {"readable": readable, "notes": notes}
    for cell in notebook["cells"]:
        cell["source"] = text(cell)
        if cell["cell_type"] == "code":
            cell["outputs"], cell["execution_count"] = [], None
    if notes:
        lines = "\n".join(f"- {harmless(note)}" for note in notes)
        notebook["cells"].insert(0, _markdown(f"**About this submission**\n\n{lines}", NOTE_ID))
    return Graft(notebook, notes, readable)


def _name(cell: Cell) -> str:
    return str(cell.get("metadata", {}).get("nbgrader", {}).get("grade_id", cell.get("id", "")))


def _names(cell: Cell) -> set[str]:
    return {x for x in (_name(cell), cell.get("id")) if isinstance(x, str) and x}
