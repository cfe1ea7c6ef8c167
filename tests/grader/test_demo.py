"""The whole product once through: a class of seven, from the labs' text to grades, feedback and flights."""

import csv
import subprocess
import sys

import pytest

from grader import demo
from uavlab import load_log, summary

pytestmark = [pytest.mark.lab, pytest.mark.slow, pytest.mark.usefixtures("isolation")]


@pytest.fixture(scope="module")
def shown(tmp_path_factory, isolation):
    to = tmp_path_factory.mktemp("demo")
    command = [sys.executable, "-m", "grader.demo", "--to", str(to)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return to


@pytest.fixture(scope="module")
def grades(shown):
    with open(shown / "course" / "grades.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return {(r["assignment"], r["student_id"]): float(r["raw_score"]) for r in rows}


AUTOMATIC = {"01_dynamics": 20.0, "02_heading": 21.0}  # the rest is graded by hand


@pytest.mark.parametrize("lab", AUTOMATIC)
def test_the_class_gets_what_it_deserves(grades, lab):
    assert grades[lab, "ada"] == AUTOMATIC[lab]
    assert grades[lab, "gil"] == AUTOMATIC[lab]
    assert 0 < grades[lab, "cleo"] < AUTOMATIC[lab]
    assert 0 < grades[lab, "ben"] < AUTOMATIC[lab]
    assert grades[lab, "dan"] == AUTOMATIC[lab] - 3  # the endless answer's points, and no others
    assert grades[lab, "eve"] == 0
    assert grades[lab, "fay"] == 0


def words(path):
    """The page's text with every gap as one blank: the report breaks its lines."""
    return " ".join(path.read_text().split())


def test_a_wrong_sign_earns_its_own_hint_on_the_feedback_page(shown):
    page = words(shown / "course" / "feedback" / "ben" / "02_heading" / "heading.html")
    assert "The heading rate has the wrong sign when the aircraft is tilted" in page
    assert "here the yaw rate that undoes is asked for" in page
    page = words(shown / "course" / "feedback" / "ben" / "01_dynamics" / "dynamics.html")
    assert "The gyroscopic term has the wrong sign" in page


def test_a_damaged_file_is_named_and_kept_as_it_was(shown):
    page = words(shown / "course" / "feedback" / "fay" / "02_heading" / "heading.html")
    assert "cannot be read as a notebook" in page
    kept = (shown / "course" / "submitted" / "fay" / "02_heading" / "heading.ipynb").read_bytes()
    assert not kept.endswith(b"}")


def test_the_right_answer_flies_and_the_wrong_one_is_seen_to_be_wrong(shown):
    ada, ben = (load_log(shown / "flights" / f"{name}.npz") for name in demo.FLYERS)
    assert set(ada.meta["provenance"].values()) == {"mine", "stand-in"}
    worst = "heading error, worst [deg]"
    assert summary(ben)[worst] > 5 * summary(ada)[worst]
    assert (shown / "flights" / "both.html").stat().st_size > 50_000
