"""Grade a class: ``python -m grader.grade COURSE_DIR ASSIGNMENT [--student S] [--jobs N] [--again]``.

Grafts every submission onto its release notebook, marks them some at a time, and has nbgrader write gradebook,
autograded notebooks, feedback pages and grades.csv. What has not changed since it was graded is left as it is.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from grader import sandbox
from grader.coursework import Coursework, Submission, open_course
from grader.handin import left_out, plain_name
from grader.mark import Options
from grader.pool import Outcome, mark_all
from grader.shell import NOT_GRADED, Row, Shell
from grader.steps import CHECK
from grader.table import class_table
from uavlab.errors import UavlabError, UnknownName

Say = Callable[[str], None]


def say(message: str) -> None:
    """One line of progress."""
    print(f"grade: {message}", flush=True)


def grade(
    root: Path,
    assignment: str,
    *,
    student: str | None = None,
    jobs: int = 2,
    again: bool = False,
    say: Say = say,
) -> list[Row]:
    """Grade one assignment of a course.

    Parameters
    ----------
    root : Path
        The course directory.
    assignment : str
        Its name, as ``01_dynamics``.
    student : str, optional
        Only this one; else everybody who submitted.
    jobs : int
        Submissions that are marked at the same time.
    again : bool
        Mark anew what has not changed.
    say : callable
        Takes the lines of progress.

    Returns
    -------
    list of Row
        The class, from the gradebook.

    Raises
    ------
    BadFile, UnknownName
        No such course, assignment or student.
    SandboxMissing
        Student code cannot be isolated here; nothing has been graded.
    """
    began, before = time.perf_counter(), os.times()
    work = open_course(root, assignment)
    students = _students(work, student)
    sandbox.demand()
    shell = Shell(work)
    submissions = [x for s in students for x in work.graft(s)]
    outcomes = _mark(submissions, shell.options()._replace(again=again), jobs, say)
    for name in students:
        if again or not _done(work, [x for x in outcomes if x.submission.student == name]):
            work.forget(name)
    for what, said in (("autograde", shell.autograde()), ("feedback", shell.feedback())):
        if said:
            say(f"nbgrader {what}: {said}")
    say(f"feedback in {work.root / 'feedback'}, grades in {shell.export()}")
    boxes = sum(x.marks.cpu for x in outcomes if x.marks is not None)
    cpu = sum(os.times()[:4]) - sum(before[:4]) + boxes
    wall = time.perf_counter() - began
    say(
        f"{len(students)} students in {wall:.1f} s, with {cpu:.1f} s CPU, {boxes:.1f} s of it in boxes"
    )
    return [
        shell.row(s, _note([x for x in outcomes if x.submission.student == s])) for s in students
    ]


def not_graded(root: Path, assignment: str) -> list[str]:
    """What lies in ``submitted/`` and has not been graded as this assignment, one sentence each."""
    work = open_course(root, assignment)
    odd = [
        f"submitted/{name!r} is no name of a student: letters, digits and . _ @ + - are; "
        f"rename the folder, for example to {plain_name(name)!r}"
        for name in work.oddly_named
    ]
    graded = {*work.students, *work.oddly_named}
    return odd + left_out(work.root / "submitted", assignment, graded)


def _students(work: Coursework, student: str | None) -> list[str]:
    known = work.students
    if student is not None and student not in known:
        raise UnknownName("student with this assignment", student, known)
    return known if student is None else [student]


def _mark(submissions: list[Submission], options: Options, jobs: int, say: Say) -> list[Outcome]:
    done: list[Outcome] = []
    for outcome in mark_all(submissions, options, jobs):
        done.append(outcome)
        say(f"{len(done):>{len(str(len(submissions)))}}/{len(submissions)} {_progress(outcome)}")
    return done


def _progress(outcome: Outcome) -> str:
    who, marks = outcome.submission, outcome.marks
    if marks is None:
        return f"{who.student} {who.name}: {outcome.error}"
    points = sum(x["score"] for x in marks.checks.values())
    spent = (
        "as before" if marks.kept else f"{marks.seconds:.1f} s, {outcome.cpu + marks.cpu:.2f} s CPU"
    )
    return f"{who.student} {who.name}: {points:g} points ({spent})"


def _done(work: Coursework, outcomes: Sequence[Outcome]) -> bool:
    """Whether nbgrader has all of this already."""
    return all(
        x.marks is not None
        and x.marks.kept
        and not x.submission.changed
        and (
            work.folder("autograded", x.submission.student) / f"{x.submission.name}.ipynb"
        ).exists()
        for x in outcomes
    )


def _note(outcomes: Sequence[Outcome]) -> str:
    """What a teacher should know about a submission, in one line."""
    notes: list[str] = []
    for outcome in outcomes:
        notes += [n.rstrip(".") for n in outcome.submission.graft.notes]
        if outcome.marks is None:
            notes.append(f"{NOT_GRADED} {outcome.error}")
            continue
        for name, mark in outcome.marks.checks.items():
            notes += [f"{name.removeprefix(CHECK)}: {why}" for why in mark["trouble"][:1]]
    return "; ".join(notes[:3]) + ("; …" if len(notes) > 3 else "")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; 0 if all were graded, 1 if some could not be, 2 if the input was wrong."""
    parser = argparse.ArgumentParser(prog="python -m grader.grade", description=__doc__)
    parser.add_argument("course", type=Path, help="the nbgrader course directory")
    parser.add_argument("assignment", help="its name in release/, as 01_dynamics")
    parser.add_argument("--student", help="only this student")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="at the same time")
    parser.add_argument("--again", action="store_true", help="also what has not changed")
    options = parser.parse_args(arguments)
    try:
        rows = grade(
            options.course,
            options.assignment,
            student=options.student,
            jobs=max(1, options.jobs),
            again=options.again,
        )
    except (UavlabError, sandbox.SandboxMissing) as error:
        print(f"grade: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("grade: stopped; nothing is lost: run it again to go on.", file=sys.stderr)
        return 130
    print(f"\n{class_table(rows)}\n" if rows else "grade: nobody has submitted this assignment")
    ignored = not_graded(options.course, options.assignment)
    for said in ignored:
        say(f"NOT GRADED: {said}")
    return 1 if ignored or any(NOT_GRADED in row.note for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
