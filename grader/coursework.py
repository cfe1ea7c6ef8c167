"""A course directory on disk: what was released, what was submitted, and the clean copies that are graded.

nbgrader's layout: ``release/<assignment>``, ``submitted/<student>/<assignment>``, and ours between them and
``autograded/``: ``clean/<student>/<assignment>``, the grafted notebooks. What students submitted is only read.
"""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import NamedTuple

from nbgrader.utils import parse_utc

from grader.graft import Graft, NotANotebook, Notebook, graft_file, read_bytes
from grader.handin import find_notebook
from uavlab.errors import BadFile, UnknownName

CLEAN = "clean"
# Of a student; others would be patterns or paths to nbgrader.
_NAME = re.compile(r"(?!\.+$)[\w.@+-]+", re.ASCII)
_TIME = re.compile(rb"[\d :.TZ+-]{8,40}(?: UTC)?\s*")


class Submission(NamedTuple):
    """One notebook of one student, grafted."""

    student: str
    name: str  # of the notebook, without .ipynb
    graft: Graft
    changed: bool  # since it was last grafted


class Coursework(NamedTuple):
    """One assignment of a course."""

    root: Path
    assignment: str
    released: dict[str, Notebook]  # by the notebook's name, without .ipynb

    @property
    def students(self) -> list[str]:
        """Who has submitted something for this assignment."""
        folders = sorted((self.root / "submitted").glob(f"*/{self.assignment}"))
        return [f.parent.name for f in folders if _NAME.fullmatch(f.parent.name)]

    @property
    def oddly_named(self) -> list[str]:
        """Folders in ``submitted/`` that cannot be a student's."""
        folders = sorted((self.root / "submitted").glob(f"*/{self.assignment}"))
        return [f.parent.name for f in folders if not _NAME.fullmatch(f.parent.name)]

    def folder(self, step: str, student: str) -> Path:
        """Where a student's files of one step of nbgrader's are."""
        return self.root / step / student / self.assignment

    def graft(self, student: str) -> list[Submission]:
        """Write the clean copies of what a student submitted, and return them."""
        clean = self.folder(CLEAN, student)
        made = []
        for name, release in self.released.items():
            path, notes = find_notebook(self.folder("submitted", student), name)
            grafted = graft_file(release, path, self.root / "submitted")
            grafted = grafted._replace(notes=[*notes, *grafted.notes])
            text = json.dumps(grafted.notebook, indent=1, ensure_ascii=False)
            target = clean / f"{name}.ipynb"
            changed = not target.is_file() or target.read_text(encoding="utf-8") != text
            if changed:
                clean.mkdir(parents=True, exist_ok=True)
                target.write_text(text, encoding="utf-8")
            made.append(Submission(student, name, grafted, changed))
        self._timestamp(student)
        return made

    def forget(self, student: str) -> None:
        """Remove what was made of a student's submission before, so that nbgrader makes it again."""
        for step in ("autograded", "feedback"):
            shutil.rmtree(self.folder(step, student), ignore_errors=True)

    def _timestamp(self, student: str) -> None:
        """Copy the time of submission, if it is one."""
        name = "timestamp.txt"
        try:
            said = read_bytes(self.folder("submitted", student) / name, self.root / "submitted")
        except NotANotebook:
            return
        if _is_time(said):
            (self.folder(CLEAN, student) / name).write_bytes(said)


def _is_time(said: bytes) -> bool:
    """Whether nbgrader can read this as a time: it stops at one that it cannot."""
    if not _TIME.fullmatch(said):
        return False
    try:
        parse_utc(said.decode("ascii").strip())
    except (ValueError, OverflowError, AttributeError, TypeError):
        return False
    return True


def open_course(root: Path, assignment: str) -> Coursework:
    """The coursework of one assignment.

    Raises
    ------
    BadFile
        `root` is not a course directory, or a released notebook is damaged.
    UnknownName
        There is no such assignment.
    """
    root = root.resolve()
    if not (root / "release").is_dir() or not (root / "nbgrader_config.py").is_file():
        raise BadFile(
            f"{root} is no course directory: it needs release/ and nbgrader_config.py; make labs writes both."
        )
    known = sorted(p.name for p in (root / "release").iterdir() if p.is_dir())
    if assignment not in known:
        raise UnknownName("assignment", assignment, known)
    paths = sorted((root / "release" / assignment).glob("*.ipynb"))
    try:
        released = {p.stem: json.loads(p.read_text(encoding="utf-8")) for p in paths}
    except ValueError as error:
        raise BadFile(f"a notebook in release/{assignment} is not JSON ({error}).") from None
    if not released:
        raise BadFile(f"release/{assignment} holds no notebook; make labs writes it.")
    return Coursework(root, assignment, released)
