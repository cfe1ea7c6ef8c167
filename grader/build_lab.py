"""A lab as its author writes it: a MyST Markdown notebook, read into cells that know their line.

Three kinds of cell are marked. ``%exercise NAME`` is where the answer and its check go. A text cell after
``+++ {"question": "id", "points": 2}`` is a question that a person grades. One after ``+++ {"rubric": "id"}`` says what
the teacher looks for. Everything else is kept as it stands.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jupytext.myst
import nbformat

from uavlab.errors import BadFile
from uavlab.exercises import Exercise

EXERCISE = re.compile(r"%exercise\s+(\w+)\s*\Z")
IDENTIFIER = re.compile(r"[a-z][a-z0-9-]{0,40}\Z")
# What only Sphinx understands would be shown raw by JupyterLab.
SPHINX_ONLY = re.compile(r"^(?:`{3,}|:{3,})\{|\{[a-z:]+\}`", re.MULTILINE)


@dataclass(frozen=True)
class Cell:
    """One cell of a lab and what it is for."""

    kind: str  # text, code, exercise, question or rubric
    line: int  # where it starts in the file, counted from 1
    source: str
    name: str = ""  # of the exercise, or the id of the question
    points: float = 0.0  # of a question
    tags: tuple[str, ...] = ()


@dataclass(frozen=True)
class Lab:
    """One lab: its text, the exercises that it must ask for, and the file with their answers."""

    path: Path  # <nn>_<stem>/<stem>.md
    exercises: Mapping[str, Exercise]
    solutions: Path
    cells: tuple[Cell, ...] = field(default=(), compare=False)

    @property
    def stem(self) -> str:
        """The one word that names everything of this lab."""
        return self.path.stem

    @property
    def name(self) -> str:
        """The name of the assignment: number and stem."""
        return self.path.parent.name

    def wrong(self, line: int, message: str) -> BadFile:
        """An error that says where: raise it."""
        return BadFile(f"{self.path}:{line}: {message}")


def read_lab(path: Path, exercises: Iterable[Exercise], solutions: Path) -> Lab:
    """Read a lab and hold it against its exercises.

    Parameters
    ----------
    path : Path
        ``<nn>_<stem>/<stem>.md``.
    exercises : iterable of Exercise
        What the lab must ask for, each exactly once.
    solutions : Path
        The Python file with the reference answers.

    Raises
    ------
    BadFile
        The file is missing or no MyST notebook, a marker names nothing, or an exercise is missing or asked twice. The
        message says file, line and cure.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BadFile(f"{path} cannot be read as a lab: {error}.") from None
    lab = Lab(path, {x.name: x for x in exercises}, solutions)
    cells = tuple(_cells(lab, text))
    _check_exercises(lab, cells)
    _check_questions(lab, cells)
    return Lab(path, lab.exercises, solutions, cells)


def _cells(lab: Lab, text: str) -> Iterable[Cell]:
    try:
        book = jupytext.myst.myst_to_notebook(text, add_source_map=True)
    except Exception as error:  # the reader raises what its YAML parser raises
        raise lab.wrong(1, f"this is not a MyST notebook: {error}") from None
    name = book.metadata.get("kernelspec", {}).get("name")
    if name != "python3":
        raise lab.wrong(1, f"the front matter names the kernel {name!r}; a lab has 'python3'.")
    for raw, line in zip(book.cells, book.metadata.source_map, strict=True):
        # The map counts code cells from 1 and text from 0.
        yield _cell(lab, raw, line if raw.cell_type == "code" else line + 1)


def _cell(lab: Lab, raw: nbformat.NotebookNode, line: int) -> Cell:
    meta: Mapping[str, Any] = raw.metadata
    tags = meta.get("tags", [])
    if not isinstance(tags, list) or not all(isinstance(t, str) for t in tags):
        raise lab.wrong(line, f"tags are {tags!r}; write them as a list: [viz, flight].")
    if raw.cell_type == "code":
        return _code_cell(lab, raw.source, line, tuple(tags))
    if raw.cell_type != "markdown":
        raise lab.wrong(line, f"a lab has text and code cells, not {raw.cell_type!r}.")
    if found := SPHINX_ONLY.search(raw.source):
        raise lab.wrong(
            line + raw.source.count("\n", 0, found.start()),
            f"{found.group()!r} is shown raw by JupyterLab; labs are written in plain Markdown.",
        )
    for kind in ("question", "rubric"):
        if kind in meta:
            return _asked(lab, raw, line, kind)
    return Cell("text", line, raw.source, tags=tuple(tags))


def _code_cell(lab: Lab, source: str, line: int, tags: tuple[str, ...]) -> Cell:
    if "%exercise" in source:
        found = EXERCISE.match(source.strip())
        if found is None:
            raise lab.wrong(
                line, "an exercise cell has the one line '%exercise NAME' and nothing else."
            )
        return Cell("exercise", line, source, name=found[1], tags=tags)
    if "BEGIN SOLUTION" in source:
        raise lab.wrong(
            line, f"answers are written in {lab.solutions}, not in the lab: use '%exercise NAME'."
        )
    try:
        ast.parse(plain_python(source))
    except SyntaxError as error:
        at = line + (error.lineno or 1)
        raise lab.wrong(at, f"this code cell is not Python: {error.msg}.") from None
    return Cell("code", line, source, tags=tags)


def _asked(lab: Lab, raw: nbformat.NotebookNode, line: int, kind: str) -> Cell:
    name, points = raw.metadata[kind], raw.metadata.get("points", 0)
    if not isinstance(name, str) or not IDENTIFIER.match(name):
        raise lab.wrong(line, f"the {kind} id {name!r} is not lower-case words joined by hyphens.")
    if kind == "question" and not (isinstance(points, (int, float)) and 0 < points <= 100):
        raise lab.wrong(
            line, f"question {name!r} has {points!r} points; allowed is 0 < points ≤ 100."
        )
    return Cell(kind, line, raw.source, name, float(points))


def _check_exercises(lab: Lab, cells: Iterable[Cell]) -> None:
    seen: dict[str, int] = {}
    for cell in cells:
        if cell.kind != "exercise":
            continue
        if cell.name not in lab.exercises:
            raise lab.wrong(
                cell.line,
                f"no exercise {cell.name!r} in uavlab.exercises.{lab.stem}; it has "
                f"{', '.join(lab.exercises)}.",
            )
        if cell.name in seen:
            raise lab.wrong(
                cell.line, f"{cell.name} is asked twice, first in line {seen[cell.name]}; keep one."
            )
        seen[cell.name] = cell.line
    if missing := [x for x in lab.exercises if x not in seen]:
        raise lab.wrong(
            1,
            f"the lab does not ask for {', '.join(missing)}: add a code cell '%exercise {missing[0]}'.",
        )


def _check_questions(lab: Lab, cells: Iterable[Cell]) -> None:
    seen: dict[tuple[str, str], int] = {}
    for cell in cells:
        key = (cell.kind, cell.name)
        if cell.kind not in {"question", "rubric"}:
            continue
        if key in seen:
            raise lab.wrong(
                cell.line, f"{cell.kind} {cell.name!r} stands in line {seen[key]} already."
            )
        if cell.kind == "rubric" and ("question", cell.name) not in seen:
            raise lab.wrong(
                cell.line, f"a rubric for {cell.name!r}, but no such question above it."
            )
        seen[key] = cell.line


def plain_python(source: str) -> str:
    """The cell without IPython's own lines (``%magic``, ``!command``), line numbers kept."""
    lines = source.splitlines()
    return "\n".join("" if s.lstrip().startswith(("%", "!")) else s for s in lines)
