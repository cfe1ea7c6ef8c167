"""What is run of a notebook: the student's cells, and of the lab's own only what these need."""

from __future__ import annotations

from grader.steps import steps_of


def _cell(source: str, name: str = "lab", *, tags: list[str] | None = None, **mark) -> dict:
    metadata = {"nbgrader": {"grade_id": name, **mark}} if mark else {"tags": tags or []}
    return {"cell_type": "code", "id": name, "metadata": metadata, "source": source}


ANSWER = _cell("def f(x):\n    return helper(np.sin(x))", "answer-f", solution=True)
CHECK = _cell("check(f)", "check-f", grade=True, points=1)


def _run(*cells: dict) -> list[str]:
    return [s.keep or s.source for s in steps_of({"cells": list(cells)})]


def test_answers_are_run_and_kept_in_order():
    assert _run(ANSWER, CHECK) == [ANSWER["source"], "f"]


def test_a_cell_of_the_lab_is_run_if_an_answer_needs_a_name_of_it():
    imports, helper, other = "import numpy as np", "def helper(x):\n    return base * x", "z = 1"
    assert _run(*map(_cell, (imports, "base = 2", helper, other)), ANSWER) == [
        imports, "base = 2", helper, ANSWER["source"],
    ]  # fmt: skip


def test_cells_that_show_answers_draw_or_fly_are_not_run():
    shows = [
        _cell("helper = f(3)"),
        _cell("helper = 1", tags=["viz"]),
        _cell("helper = 1", tags=["flight"]),
    ]
    assert _run(*shows, ANSWER, CHECK) == [ANSWER["source"], "f"]


def test_a_word_that_is_an_answer_s_name_calls_no_answer_in_an_attribute_or_a_string():
    tools = _cell("def helper(x):\n    'Not f.'\n    return Solver(x).f(x)")
    assert _run(tools, ANSWER, CHECK) == [tools["source"], ANSWER["source"], "f"]


def test_every_cell_of_the_student_s_own_is_run():
    assert _run(_cell("unused = f(1)", "own-1"), ANSWER) == ["unused = f(1)", ANSWER["source"]]


def test_only_what_runs_before_anything_of_the_student_s_is_not_their_time():
    imports, later = _cell("import numpy as np"), _cell("def helper(x):\n    return base")
    cells = [imports, _cell("base = 3", "own-1"), later, ANSWER, CHECK]
    assert [step.ours for step in steps_of({"cells": cells})] == [True, False, False, False, False]
