"""A class from submitted to graded, by our command and by nbgrader's own."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from grader import channel, sandbox
from grader.attacks import Target, filled
from grader.grade import grade, main
from grader.shell import Row
from grader.table import class_table
from uavlab.errors import BadFile, UnknownName

STEM, LAB = "heading", "02_heading"
FULL = 21.0

pytestmark = [pytest.mark.lab, pytest.mark.slow, pytest.mark.usefixtures("isolation")]


def _quiet(_: str) -> None:
    pass


def _write(course: Path, student: str, notebook: dict | bytes) -> Path:
    path = course / "submitted" / student / LAB / f"{STEM}.ipynb"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(notebook if isinstance(notebook, bytes) else json.dumps(notebook).encode())
    return path


@pytest.fixture
def course(tmp_path, release_course) -> Path:
    """A released course that nobody has submitted to."""
    shutil.copytree(release_course, tmp_path / "course")
    return tmp_path / "course"


@pytest.fixture(scope="module")
def notebooks(release, right) -> dict[str, dict | bytes]:
    """What a small class hands in."""
    target = Target(release, right, Path(), Path(), STEM)
    noisy = {
        k: f"import sys, warnings\n{v}\nwarnings.warn('careful')\nprint('to', file=sys.stderr)\n_real_{k} = {k}\n"
        f"def {k}(*a, **more):\n    warnings.warn('careful')\n    return _real_{k}(*a, **more)\n"
        for k, v in right.items()
    }
    half = {"with_heading": "def with_heading(R_o, heading):\n    return R_o\n"}
    whole = filled(target, right)
    return {
        "right": whole,
        "noisy": filled(target, noisy),
        "wrong": filled(target, right | half),
        "stub": release,
        "cut": json.dumps(whole).encode()[:5000],
    }


@pytest.fixture(scope="module")
def graded(tmp_path_factory, release_course, notebooks) -> tuple[Path, dict[str, Row]]:
    """The class after ``grade``."""
    course = tmp_path_factory.mktemp("graded") / "course"
    shutil.copytree(release_course, course)
    for student, notebook in notebooks.items():
        _write(course, student, notebook)
    rows = grade(course, LAB, jobs=2, say=_quiet)
    return course, {row.student: row for row in rows}


def test_right_answers_get_full_marks_also_with_warnings_and_noise(graded):
    _, rows = graded
    assert rows["right"].total == FULL
    assert rows["noisy"].total == FULL


def test_a_wrong_answer_costs_its_own_exercise_only_and_a_stub_gets_nothing(graded):
    _, rows = graded
    scores = rows["wrong"].scores
    assert 0 <= scores["with_heading"][0] < scores["with_heading"][1]
    assert rows["wrong"].total == FULL - scores["with_heading"][1] + scores["with_heading"][0]
    assert rows["stub"].total == 0


def test_a_damaged_file_gets_zero_and_a_note_and_stays_as_it_was(graded, notebooks):
    course, rows = graded
    assert rows["cut"].total == 0
    assert "cannot be read as a notebook" in rows["cut"].note
    path = course / "submitted" / "cut" / LAB / f"{STEM}.ipynb"
    assert path.read_bytes() == notebooks["cut"]
    page = (course / "feedback" / "cut" / LAB / f"{STEM}.html").read_text()
    assert "cannot be read as a notebook" in page


def test_feedback_shows_each_check_a_hint_and_the_score(graded):
    course, _ = graded
    page = (course / "feedback" / "wrong" / LAB / f"{STEM}.html").read_text()
    assert re.search(r"with_heading: [\d.]+ of 3 points", page)
    assert "✗" in page
    assert "✓" in page
    assert "Hint: " in page


def test_a_feedback_page_asks_no_other_host_for_anything(graded):
    course, _ = graded
    page = (course / "feedback" / "right" / LAB / f"{STEM}.html").read_text()
    assert not re.findall(r"""(?:src|href)=["']?(?:https?:)?//[^"'> ]+""", page)
    assert "@import" not in page


def test_grades_csv_has_a_line_for_each_student(graded):
    course, rows = graded
    lines = (course / "grades.csv").read_text().splitlines()
    assert len(lines) == 1 + len(rows)
    assert [line.split(",")[7] for line in lines if ",right," in line] == ["21.0"]


def test_the_table_names_every_exercise_and_every_student(graded):
    _, rows = graded
    said = class_table(list(rows.values()))
    assert all(name in said for name in ("heading_rate (4)", "right", "21/25", "cut"))


def test_grading_again_starts_no_process_and_gives_the_same(graded, monkeypatch):
    course, rows = graded
    monkeypatch.setattr(channel.sandbox, "start", None)
    again = {row.student: row for row in grade(course, LAB, jobs=1, say=_quiet)}
    assert again == rows


def test_only_what_has_changed_is_graded_again(graded, tmp_path):
    source, _ = graded
    course = tmp_path / "course"
    shutil.copytree(source, course)
    shutil.copy(source / "gradebook.db", course / "gradebook.db")
    right = course / "submitted" / "right" / LAB / f"{STEM}.ipynb"
    _write(course, "stub", right.read_bytes())
    page = course / "feedback" / "wrong" / LAB / f"{STEM}.html"
    before = page.stat().st_mtime_ns
    rows = {row.student: row.total for row in grade(course, LAB, jobs=1, say=_quiet)}
    assert rows["stub"] == FULL
    assert page.stat().st_mtime_ns == before


def test_nbgrader_s_own_command_gives_the_same_scores(graded, course, notebooks):
    """Also with links beside the notebook, which nbgrader alone would copy into the feedback."""
    _, rows = graded
    for student, notebook in notebooks.items():
        path = _write(course, student, notebook)
        (path.parent / "data.txt").symlink_to(course / "gradebook.db")
    _write(course, "link", b"").unlink()
    (course / "submitted" / "link" / LAB / f"{STEM}.ipynb").symlink_to(course / "gradebook.db")
    command = [sys.executable, "-m", "nbgrader", "autograde", LAB]
    run = subprocess.run(
        command, cwd=course, capture_output=True, text=True, timeout=300, check=False
    )
    assert run.returncode == 0, run.stderr
    scores = _scores(course)
    assert scores.pop("link") == 0
    assert scores == {s: rows[s].total for s in notebooks}
    assert not list((course / "autograded").rglob("data.txt"))


def _scores(course: Path) -> dict[str, float]:
    from nbgrader.api import Gradebook

    with Gradebook(f"sqlite:///{course}/gradebook.db") as book:
        return {s.student.id: s.score for s in book.assignment_submissions(LAB)}


def test_an_unknown_course_assignment_or_student_is_said_and_nothing_is_written(
    course, tmp_path, capsys
):
    _write(course, "ada", b"{}")
    before = sorted(course.rglob("*"))
    with pytest.raises(BadFile, match="no course directory"):
        grade(tmp_path, LAB, say=_quiet)
    with pytest.raises(UnknownName, match=r"Did you mean '02_heading'\?"):
        grade(course, "2_heading", say=_quiet)
    with pytest.raises(UnknownName, match="Did you mean 'ada'"):
        grade(course, LAB, student="adda", say=_quiet)
    assert main([str(course), "2_heading"]) == 2
    assert "02_heading" in capsys.readouterr().err
    assert sorted(course.rglob("*")) == before


def test_without_isolation_the_command_refuses_and_writes_nothing(course, monkeypatch, capsys):
    _write(course, "ada", b"{}")
    before = sorted(course.rglob("*"))
    monkeypatch.setattr(sandbox, "available", lambda: "bubblewrap (bwrap) is not installed.")
    assert main([str(course), LAB]) == 2
    assert "bubblewrap" in capsys.readouterr().err
    assert sorted(course.rglob("*")) == before
