"""Build the labs: from text, exercises and answers to the instructor's and the students' notebooks.

``python -m grader.build`` builds every lab into build/course; ``--lab STEM`` one; ``--open STEM`` opens the student's
notebook; ``--book`` builds the book.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Sequence
from pathlib import Path

from grader.build_lab import Lab, read_lab
from uavlab.errors import BadFile, UavlabError, UnknownName

ROOT = Path(__file__).resolve().parent.parent
COURSE = ROOT / "build" / "course"


def find_labs(stems: Iterable[str] | None = None, *, root: Path = ROOT) -> list[Lab]:
    """Read the labs with these stems, or all, in the order of the course.

    Parameters
    ----------
    stems : iterable of str, optional
        One word each, as ``dynamics``.
    root : Path
        The checkout.

    Raises
    ------
    UnknownName
        There is no such lab.
    BadFile
        A lab does not hold together; see `grader.build_lab.read_lab`.
    """
    from uavlab.exercises import STEMS, exercises

    paths = {p.stem: p for p in lab_paths(root)}
    wanted = list(stems or (s for s in STEMS if s in paths))
    for stem in wanted:
        if stem not in paths or stem not in STEMS:
            raise UnknownName("lab", stem, set(STEMS) & set(paths))
    if not wanted:
        raise BadFile(
            f"no labs in {root / 'course' / 'labs'}: expected <nn>_<stem>/<stem>.md there."
        )
    solutions = root / "uavlab" / "solutions"
    return [read_lab(paths[s], exercises(s), solutions / f"{s}.py") for s in wanted]


def lab_paths(root: Path = ROOT) -> list[Path]:
    """Where the labs are written: ``course/labs/<nn>_<stem>/<stem>.md``, in order."""
    folders = sorted((root / "course" / "labs").glob("[0-9][0-9]_*"))
    return [f / f"{f.name[3:]}.md" for f in folders if (f / f"{f.name[3:]}.md").is_file()]


def build(course: Path, labs: Sequence[Lab], seed: int | None = None) -> list[Path]:
    """Write both versions of `labs` into the nbgrader course directory `course`.

    Every lab is read and put together before the first file is written, so a mistake in one leaves all as they were.

    Returns
    -------
    list of Path
        The released folders.
    """
    from grader.build_notebook import instructor_notebook, write_notebook
    from grader.build_release import release, write_course

    texts = {
        f"{lab.name}/{lab.stem}.ipynb": write_notebook(instructor_notebook(lab)) for lab in labs
    }
    write_course(course, texts, seed)
    folders = []
    for lab in labs:
        start = time.perf_counter()
        folders.append(release(course, lab.name))
        questions = sum(c.kind == "question" for c in lab.cells)
        say(
            f"{lab.name}: {len(lab.exercises)} exercises, {questions} questions, "
            f"{time.perf_counter() - start:.1f} s"
        )
    return folders


def say(message: str) -> None:
    """One line of progress."""
    print(f"build: {message}", flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; 0 if all went well, 2 if the input was wrong."""
    parser = argparse.ArgumentParser(prog="python -m grader.build", description=__doc__)
    parser.add_argument("--course", type=Path, default=COURSE, help="the nbgrader course directory")
    parser.add_argument("--lab", metavar="STEM", action="append", help="only this lab")
    parser.add_argument("--open", metavar="STEM", help="open the student's notebook in JupyterLab")
    parser.add_argument("--book", action="store_true", help="build the book instead")
    options = parser.parse_args(arguments)
    try:
        if options.book:
            from grader.build_book import build_book

            say(f"the book is {build_book()}")
            return 0
        labs = find_labs([options.open] if options.open else options.lab)
        build(options.course, labs)
        say(
            f"instructor's notebooks in {options.course}/source, students' in {options.course}/release"
        )
        if options.open:
            from grader.build_student import open_lab

            return open_lab(options.course, labs[0])
    except UavlabError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
