"""A sample class: seven students, as every class has them, hand in every lab. For the demo and the tests."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from uavlab.exercises.spec import find

WRONG_SIGN = """
def heading_rate(R, omega):
    # I solved (15) by hand.
    return (omega[2] * R[2, 2] - omega[1] * R[2, 1]) / (1 - R[2, 0] ** 2)
"""

WRONG_PARASITIC = """
def parasitic_yaw_rate(R, omega):
    rate = omega[1] * R[2, 1] / (1 - R[2, 0] ** 2)
    return rate * (1 - R[2, 0] ** 2) / R[2, 2]
"""

WRONG_GYROSCOPIC = """
def rigid_body_rate(state, force, torque, *, m, J):
    spin = np.cross(state.omega, J @ state.omega)
    return StateRate(
        state.v,
        force / m,
        state.R @ so3.hat(state.omega),
        np.linalg.solve(J, torque + spin),
    )
"""

ENDLESS = """
def {name}(*arguments, **more):
    while True:
        pass
"""

CHEAT = """
def {name}(*arguments, **more):
    from uavlab.solutions import {stem}
    return {stem}.{name}(*arguments, **more)


import numpy.testing
import uavlab.exercises.check
numpy.testing.assert_allclose = lambda *a, **k: None
uavlab.exercises.check.failure = lambda *a, **k: None
"""


class Student(NamedTuple):
    """Who hands in what."""

    name: str
    story: str
    write: Callable[
        [dict[str, Any], dict[str, str]], bytes
    ]  # release notebook, right answers → file


def reference_answers(course: Path, lab: str, stem: str) -> dict[str, str]:
    """The right answers of a built lab, by exercise, without the marks of the solution."""
    cells = json.loads((course / "source" / lab / f"{stem}.ipynb").read_text())["cells"]
    marks = re.compile(r"^\s*### (BEGIN|END) SOLUTION\n?", re.MULTILINE)
    return {
        cell["id"].removeprefix("answer-"): marks.sub("", text(cell))
        for cell in cells
        if cell["id"].startswith("answer-")
    }


def text(cell: dict[str, Any]) -> str:
    """A cell's source as one string; files may hold a list of lines."""
    source = cell["source"]
    return source if isinstance(source, str) else "".join(source)


def filled(notebook: dict[str, Any], answers: dict[str, str]) -> bytes:
    """The released notebook with these answers in their cells, as a file."""
    notebook = json.loads(json.dumps(notebook))
    for cell in notebook["cells"]:
        name = cell["id"].removeprefix("answer-")
        if cell["id"].startswith("answer-") and name in answers:
            cell["source"] = answers[name].strip() + "\n"
        elif cell["id"].startswith("question-") and "Write your answer here" in text(cell):
            cell["source"] = "Because the two are not the same angle once the aircraft tilts."
    return json.dumps(notebook, indent=1).encode()


def right(notebook: dict[str, Any], answers: dict[str, str]) -> bytes:
    """Everything as in the reference."""
    return filled(notebook, answers)


def wrong_signs(notebook: dict[str, Any], answers: dict[str, str]) -> bytes:
    """All right but for signs."""
    wrong = {
        "heading_rate": WRONG_SIGN,
        "parasitic_yaw_rate": WRONG_PARASITIC,
        "rigid_body_rate": WRONG_GYROSCOPIC,
    }
    return filled(notebook, answers | {k: v for k, v in wrong.items() if k in answers})


def unfinished(notebook: dict[str, Any], answers: dict[str, str]) -> bytes:
    """The first half answered, the rest as it was handed out."""
    half = list(answers)[: len(answers) // 2]
    return filled(notebook, {name: answers[name] for name in half})


def endless(notebook: dict[str, Any], answers: dict[str, str]) -> bytes:
    """One answer never returns, the others are right."""
    name = list(answers)[1]
    return filled(notebook, answers | {name: ENDLESS.format(name=name)})


def cheat(notebook: dict[str, Any], answers: dict[str, str]) -> bytes:
    """Every answer imports the reference and patches the checks."""
    return filled(
        notebook, {name: CHEAT.format(name=name, stem=find(name).stem) for name in answers}
    )


def damaged(notebook: dict[str, Any], answers: dict[str, str]) -> bytes:
    """A good file, of which the upload lost the second half."""
    whole = filled(notebook, answers)
    return whole[: len(whole) // 2]


def rearranged(notebook: dict[str, Any], answers: dict[str, str]) -> bytes:
    """Right answers; check cells deleted, cells of one's own added, points raised."""
    whole = json.loads(filled(notebook, answers))
    whole["cells"] = [c for c in whole["cells"] if not c["id"].startswith("check-")]
    for cell in whole["cells"]:
        cell["metadata"].get("nbgrader", {})["points"] = 1000
    scratch = {"cell_type": "code", "id": "mine", "metadata": {}, "outputs": []}
    whole["cells"].insert(2, {**scratch, "execution_count": None, "source": "print('my notes')"})
    return json.dumps(whole).encode()


CLASS = (
    Student("ada", "right", right),
    Student("ben", "wrong signs", wrong_signs),
    Student("cleo", "unfinished", unfinished),
    Student("dan", "an endless loop", endless),
    Student("eve", "a cheat", cheat),
    Student("fay", "a damaged file", damaged),
    Student("gil", "right, cells rearranged", rearranged),
)


def hand_in(course: Path, lab: str, stem: str, students: tuple[Student, ...] = CLASS) -> list[Path]:
    """Write what each student hands in for one lab into ``submitted/``, and say where."""
    notebook = json.loads((course / "release" / lab / f"{stem}.ipynb").read_text())
    answers = reference_answers(course, lab, stem)
    paths = []
    for student in students:
        path = course / "submitted" / student.name / lab / f"{stem}.ipynb"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(student.write(notebook, answers))
        paths.append(path)
    return paths
