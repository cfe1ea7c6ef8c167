"""From a lab to the instructor's notebook: every exercise becomes an answer cell and a check cell.

Grade ids are an interface: the gradebook and the grader know ``answer-NAME``, ``check-NAME`` and ``question-ID``. Cell
ids follow from them, so that two builds are the same to the byte.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from grader.build_answer import check_names, instructor_answer
from grader.build_lab import Cell, Lab
from uavlab.exercises import Exercise

METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def instructor_notebook(lab: Lab) -> nbformat.NotebookNode:
    """The notebook with answers and rubrics that nbgrader releases the students' version from.

    Raises
    ------
    BadFile
        An answer is missing, has another signature, or uses a name that the lab does not bind.
    """
    answers = {name: instructor_answer(lab, x) for name, x in lab.exercises.items()}
    code = (c for c in lab.cells if c.kind in {"code", "exercise"})
    check_names(lab, [(c, answers.get(c.name, c.source)) for c in code])
    rubrics = {c.name: c.source for c in lab.cells if c.kind == "rubric"}
    cells: list[nbformat.NotebookNode] = []
    for cell in lab.cells:
        if cell.kind == "exercise":
            cells += _exercise(lab.exercises[cell.name], answers[cell.name])
        elif cell.kind == "question":
            cells += _question(cell, rubrics.get(cell.name, "Any sound argument."))
        elif cell.kind != "rubric":
            cells.append(_plain(cell, f"{lab.stem}-{len(cells):03d}"))
    return new_notebook(cells=cells, metadata=METADATA)


def write_notebook(book: nbformat.NotebookNode) -> str:
    """A notebook as text that is the same for the same notebook."""
    nbformat.validate(book)
    return nbformat.writes(book) + "\n"


def _exercise(exercise: Exercise, answer: str) -> Iterator[nbformat.NotebookNode]:
    name = exercise.name
    yield new_code_cell(answer, **_graded(f"answer-{name}", solution=True))
    # A cell that starts with a docstring would count as full marks; a comment does not.
    check = f"# The public checks of {name} ({exercise.points:g} points). The grader has more."
    yield new_code_cell(
        f"{check}\nuavlab.check({name})",
        **_graded(f"check-{name}", grade=True, locked=True, points=float(exercise.points)),
    )


def _question(cell: Cell, rubric: str) -> Iterator[nbformat.NotebookNode]:
    worth = f"*({cell.points:g} points; a person reads your answer in the cell below.)*"
    yield new_markdown_cell(
        f"{cell.source}\n\n{worth}",
        **_graded(f"ask-{cell.name}", locked=True, kind="markdown"),
    )
    # The release replaces the whole text by a placeholder: the rubric stays with the teacher.
    yield new_markdown_cell(
        f"**What a good answer says**\n\n{rubric}",
        **_graded(
            f"question-{cell.name}",
            grade=True,
            solution=True,
            points=cell.points,
            kind="markdown",
        ),
    )


def _plain(cell: Cell, cell_id: str) -> nbformat.NotebookNode:
    new = new_markdown_cell if cell.kind == "text" else new_code_cell
    metadata: dict[str, Any] = {"tags": list(cell.tags)} if cell.tags else {}
    if "hide-input" in cell.tags:  # the book folds by tag, JupyterLab by this
        metadata["jupyter"] = {"source_hidden": True}
    return new(cell.source, id=cell_id, metadata=metadata)


def _graded(
    grade_id: str,
    *,
    grade: bool = False,
    solution: bool = False,
    locked: bool = False,
    points: float | None = None,
    kind: str = "code",
) -> dict[str, Any]:
    """Id and metadata of a cell that nbgrader knows (its schema 3)."""
    mark: dict[str, Any] = {
        "schema_version": 3,
        "grade_id": grade_id,
        "cell_type": kind,
        "grade": grade,
        "solution": solution,
        "locked": locked,
        "task": False,
    }
    if points is not None:
        mark["points"] = points
    return {"id": grade_id, "metadata": {"nbgrader": mark}}
