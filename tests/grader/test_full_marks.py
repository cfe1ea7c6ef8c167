"""Every lab from its source through the box: the right answers get all points, as a student's would."""

from __future__ import annotations

import copy

import pytest

from grader import mark
from grader.build import find_labs
from grader.build_notebook import instructor_notebook
from grader.steps import steps_of
from uavlab.exercises import STEMS, exercises


@pytest.fixture(scope="module")
def notebooks():
    """The instructor's notebook of each lab, when it is first asked for."""

    class Books(dict):
        def __missing__(self, stem):
            self[stem] = instructor_notebook(find_labs([stem])[0])
            return self[stem]

    return Books()


@pytest.mark.lab
@pytest.mark.parametrize("stem", STEMS)
def test_what_a_lab_imports_runs_before_the_answers(notebooks, stem):
    book = notebooks[stem]
    first = next(i for i, cell in enumerate(book["cells"]) if cell["cell_type"] == "code")
    assert first in {step.cell for step in steps_of(book)}


@pytest.mark.lab
@pytest.mark.slow
@pytest.mark.usefixtures("isolation")
@pytest.mark.parametrize("stem", STEMS)
def test_the_right_answers_of_a_lab_get_all_points_in_the_box(notebooks, stem):
    marks = mark.mark(notebooks[stem], mark.Options())
    short = {x.name: marks.checks[f"check-{x.name}"] for x in exercises(stem)
             if marks.checks[f"check-{x.name}"]["score"] != x.points}  # fmt: skip
    assert short == {}
    assert marks.faults == {}


@pytest.mark.lab
@pytest.mark.slow
@pytest.mark.usefixtures("isolation")
def test_an_answer_that_calls_a_wrong_one_is_told_to_mend_that_first(notebooks):
    book = copy.deepcopy(notebooks["heading"])
    (cell,) = [c for c in book["cells"] if c.get("id") == "answer-heading_rate"]
    cell["source"] += (
        "\n\nright = heading_rate\ndef heading_rate(R, omega):\n    return -right(R, omega)\n"
    )
    checks = mark.mark(book, mark.Options()).checks
    assert (
        "calls heading_rate, which is not right yet" in checks["check-parasitic_yaw_rate"]["text"]
    )
    assert "calls" not in checks["check-heading_rate"]["text"]
