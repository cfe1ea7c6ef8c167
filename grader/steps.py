"""What is run of a grafted notebook: the student's cells, and of the lab's own only what these need."""

from __future__ import annotations

import ast
import re

from grader.graft import OWN, Cell, Notebook, is_answer, text
from grader.magics import Translator
from grader.remote import Step

CHECK = "check-"  # how the grade id of a check cell begins; the exercise's name follows
SKIPPED = {"viz", "flight"}  # tags of cells that only draw or fly

_WORD = re.compile(r"\w+")


def is_check(cell: Cell) -> bool:
    """Whether the judge gives this cell's points."""
    nbgrader = cell.get("metadata", {}).get("nbgrader", {})
    graded = nbgrader.get("grade") and not nbgrader.get("solution")
    return bool(graded) and cell["cell_type"] == "code"


def is_students(cell: Cell) -> bool:
    """Whether a cell's source is the student's."""
    return is_answer(cell) or str(cell.get("id")).startswith(OWN)


def exercise_name(cell: Cell) -> str:
    """The exercise that a check cell asks for."""
    return str(cell["metadata"]["nbgrader"]["grade_id"]).removeprefix(CHECK)


def steps_of(notebook: Notebook) -> list[Step]:
    """What is run of a notebook, in order, and where each answer is kept.

    A cell of the lab is run if it makes a name that a later cell needs. One that calls answers is not: an answer that
    hangs must not be waited for twice.
    """
    translate = Translator().python
    cells = notebook["cells"]
    answers = {exercise_name(c) for c in cells if is_check(c)}
    needed: set[str] = set()
    steps: list[Step] = []
    for place in reversed(range(len(cells))):
        cell = cells[place]
        if is_check(cell):
            steps.append(Step(place, keep=exercise_name(cell)))
        elif cell["cell_type"] == "code":
            source = translate(text(cell))
            words = set(_WORD.findall(source))
            if is_students(cell) or _is_needed(cell, source, needed, names_used(source) & answers):
                steps.append(Step(place, source=source))
                needed |= words
    steps.reverse()
    first = next(
        (i for i, x in enumerate(steps) if x.keep or is_students(cells[x.cell])), len(steps)
    )
    return [step._replace(ours=i < first) for i, step in enumerate(steps)]


def _is_needed(cell: Cell, source: str, needed: set[str], calls: set[str]) -> bool:
    if calls or SKIPPED & set(cell["metadata"].get("tags", [])):
        return False
    made = _made(source)
    return "*" in made or bool(made & needed)


def names_used(source: str) -> set[str]:
    """The names that a cell uses, not counting attributes and strings; of one that is not plain Python, all words."""
    try:
        nodes = ast.walk(ast.parse(source))
    except SyntaxError:
        return set(_WORD.findall(source))
    return {x.id for x in nodes if isinstance(x, ast.Name) and isinstance(x.ctx, ast.Load)}


def _made(source: str) -> set[str]:
    """The names that a cell binds; of a cell that is not plain Python, everything."""
    try:
        nodes = list(ast.walk(ast.parse(source)))
    except SyntaxError:
        return {"*"}
    made: set[str] = set()
    for node in nodes:
        if isinstance(node, ast.Import | ast.ImportFrom):
            made |= {(x.asname or x.name).partition(".")[0] for x in node.names}
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            made.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            made.add(node.id)
    return made
