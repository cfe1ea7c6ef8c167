"""Mark one notebook: run its cells in the box, have every answer judged, and write down what is to be read.

Knows nothing of nbgrader but its cell metadata and how it reads a score: the text of a cell's result is the points.
"""

from __future__ import annotations

import math
import textwrap
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from grader import cache
from grader.graft import METADATA, Cell, Notebook, text
from grader.judge import Verdict, judge
from grader.remote import Remote, Step
from grader.sandbox import Limits
from grader.steps import CHECK, exercise_name, is_check, is_students, names_used, steps_of
from uavlab.errors import BadInput
from uavlab.exercises.spec import Exercise, find

SEED = 20_261_101  # other than any that students see; a course sets its own


class Options(NamedTuple):
    """How a course is marked."""

    seed: int = SEED
    limits: Limits = Limits()
    place: int = 0  # number among the submissions marked at the same time
    cache: Path | None = None
    again: bool = False  # mark anew what is in the cache


Mark = dict[str, Any]  # {"score": float, "text": str, "trouble": [str]}; what a check cell shows


class Marks(NamedTuple):
    """What marking a notebook found."""

    checks: dict[str, Mark]  # by the check cell's grade id
    faults: dict[str, str]  # by cell id: why it did not run through
    seconds: float = 0.0  # of marking
    cpu: float = 0.0  # [s] used in the box
    kept: bool = True  # from before


def mark(notebook: Notebook, options: Options) -> Marks:
    """The marks of a grafted notebook, from the cache if it has been marked before.

    Raises
    ------
    SandboxMissing
        Student code cannot be isolated on this machine.
    BadInput
        A check cell asks for an exercise that does not exist.
    """
    wanted = {_grade_id(c): _exercise(c) for c in notebook["cells"] if is_check(c)}
    steps = steps_of(notebook)
    said = notebook["metadata"].get(METADATA, {})
    readable = said.get("readable", True)
    why = [] if readable else said["notes"]  # all that a student is told of an unreadable file
    name = cache.key(steps, list(wanted), readable, why, options.seed, options.limits)
    kept = None if options.again else cache.load(options.cache, name)
    if kept is not None:
        return Marks(kept["checks"], kept["faults"])
    began = time.monotonic()
    if readable:
        marks = _judge_all(notebook, steps, wanted, options)
    else:
        marks = Marks({k: _nothing(x, why) for k, x in wanted.items()}, {})
    cache.save(options.cache, name, {"checks": marks.checks, "faults": marks.faults})
    return marks._replace(seconds=time.monotonic() - began, kept=False)


def write(notebook: Notebook, marks: Marks) -> None:
    """Put marks into the outputs of a notebook, as nbgrader reads them."""
    for cell in notebook["cells"]:
        if is_check(cell):
            found = marks.checks[_grade_id(cell)]
            points = float(cell["metadata"]["nbgrader"]["points"])
            cell["outputs"] = [_stream(found["text"]), _result(found["score"], points)]
            cell["execution_count"] = 1
        elif cell["cell_type"] == "code" and cell.get("id") in marks.faults:
            cell["outputs"] = [_stream(f"This cell {marks.faults[cell['id']]}.\n")]


def _stream(said: str) -> dict[str, Any]:
    return {"output_type": "stream", "name": "stdout", "text": said}


def _result(score: float, points: float) -> dict[str, Any]:
    safe = min(max(score, 0.0), points) if math.isfinite(score) else 0.0
    data = {"text/plain": f"{safe:g}"}
    return {"output_type": "execute_result", "execution_count": 1, "data": data, "metadata": {}}


# Judging --------------------------------------------------------------------------------------------


def _grade_id(cell: Cell) -> str:
    return str(cell["metadata"]["nbgrader"]["grade_id"])


def _exercise(cell: Cell) -> Exercise:
    grade_id = _grade_id(cell)
    if not grade_id.startswith(CHECK):
        raise BadInput(f"the graded cell {grade_id!r} is not called {CHECK}<exercise>.")
    return find(exercise_name(cell))


def _judge_all(
    notebook: Notebook, steps: list[Step], wanted: dict[str, Exercise], options: Options
) -> Marks:
    cells = notebook["cells"]
    with Remote(steps, options.limits, options.place) as remote:
        stopped = {
            str(cells[place].get("id")): why
            for place, why in remote.faults.items()
            if is_students(cells[place])
        }
        checks = {}
        short: set[str] = set()  # exercises so far that are not right
        for grade_id, exercise in wanted.items():
            answer = remote.answer(exercise.name, exercise.methods)
            verdict = judge(exercise, answer, options.seed)
            if verdict.hint:
                short.add(exercise.name)
                verdict = _blamed(verdict, cells, short)
            why = stopped.get(f"answer-{exercise.name}", "")
            trouble = list(dict.fromkeys(map(str, answer.faults)))
            if why and not verdict.score:  # a mistake of syntax, say: no check has seen an answer
                verdict = verdict._replace(results=(), hint="")
                trouble = [f"the answer cell {why}", *trouble]
            said = report(
                verdict,
                fault=why,
                trouble=[x for x in trouble if not x.startswith("the answer cell")],
            )
            checks[grade_id] = {"score": verdict.score, "text": said, "trouble": trouble}
    return Marks(checks, stopped, cpu=remote.cpu)


def _blamed(verdict: Verdict, cells: Sequence[Cell], short: set[str]) -> Verdict:
    """The verdict, whose hint names another exercise first if the answer calls one that is not right itself."""
    source = next((text(c) for c in cells if c.get("id") == f"answer-{verdict.exercise}"), "")
    calls = sorted(names_used(source) & short - {verdict.exercise})
    if not calls or not verdict.finished:
        return verdict
    said = f"This answer calls {', '.join(calls)}, which is not right yet: mend that first."
    return verdict._replace(hint=said)


# What is read ---------------------------------------------------------------------------------------


def report(verdict: Verdict, fault: str = "", trouble: Sequence[str] = ()) -> str:
    """A verdict as lines for its student: the score, every check, and what to do."""
    lines = [f"{verdict.exercise}: {verdict.score:g} of {verdict.points:g} points"]
    if fault:
        lines += _wrapped(f"The answer cell {fault}.")
    for why in trouble:
        lines += _wrapped(f"While it was called: {why}.")
    for result in verdict.results:
        title = result.name.replace("_", " ")
        lines += _wrapped(f"✓ {title}" if result.passed else f"✗ {title}: {result.sentence}")
    if verdict.hint:
        lines += _wrapped(f"Hint: {verdict.hint}")
    return "\n".join(lines) + "\n"


def _wrapped(said: str) -> list[str]:
    """Lines that fit the feedback page."""
    return textwrap.wrap(said, 96, initial_indent="  ", subsequent_indent="      ")


def _nothing(exercise: Exercise, notes: list[str]) -> Mark:
    said = "\n".join(line for note in notes for line in _wrapped(f"✗ {note}"))
    line = f"{exercise.name}: 0 of {exercise.points:g} points\n{said}\n"
    return {"score": 0.0, "text": line, "trouble": []}
