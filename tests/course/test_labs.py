"""The labs as their readers run them: with answers, without, and without the recorded flights."""

import base64
import io
import os
import re
import subprocess
import sys
import time
import warnings
from itertools import compress
from pathlib import Path

import nbformat
import numpy as np
import pytest
from needed import for_files

from grader.build import ROOT, build, find_labs
from uavlab.exercises import STEMS, exercises

LIMIT = 120.0  # [s] for one lab with its answers
DATA = Path(os.environ.get("UAVLAB_DATA", ROOT.parent / "shared" / "data"))
CI = os.environ.get("CI", "").lower() == "true"


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """Both versions of all labs."""
    folder = tmp_path_factory.mktemp("course")
    build(folder, find_labs())
    return folder


@pytest.fixture(scope="module")
def answered(course, tmp_path_factory):
    """Each lab with its answers, run when it is first asked for, and how long that took [s]."""
    if not DATA.is_dir() and not CI:
        pytest.skip(f"the recorded flights are not in {DATA}: set UAVLAB_DATA")

    class Runs(dict):
        def __missing__(self, stem):
            start = time.perf_counter()
            book = executed(course, "source", stem, tmp_path_factory.mktemp(stem), data=DATA)
            self[stem] = book, time.perf_counter() - start
            return self[stem]

    return Runs()


def executed(course, version, stem, folder, *, data, first="", of_files=False):
    """A copy of a built notebook after all of its cells have run; errors stand in its outputs.

    With `of_files` only those run that ask for recorded files, live without them, or make what these need.
    """
    from nbclient import NotebookClient

    (path,) = (course / version).glob(f"*_{stem}/{stem}.ipynb")
    book = nbformat.read(path, as_version=4)
    if of_files:
        book.cells = [c for c in book.cells if c.cell_type == "code"]
        book.cells = list(compress(book.cells, for_files([c.source for c in book.cells])))
    if first:
        book.cells.insert(0, nbformat.v4.new_code_cell(first))
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "UAVLAB_DATA": str(data)}
    environment.pop("MPLBACKEND", None)  # pictures go into the notebook
    client = NotebookClient(
        book,
        timeout=300,
        allow_errors=True,
        kernel_name="python3",
        resources={"metadata": {"path": str(folder)}},
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the notebook client's own, of its event loops
        client.execute(env=environment)
    return book


def errors(book):
    """First line of a cell, name and message of the error, for every cell that raised."""
    return [
        (cell.source.split("\n", 1)[0], out.ename, out.evalue)
        for cell in book.cells
        if cell.cell_type == "code"
        for out in cell.outputs
        if out.output_type == "error"
    ]


def printed(book):
    """Everything that the cells printed."""
    return "".join(
        out.text
        for cell in book.cells
        if cell.cell_type == "code"
        for out in cell.outputs
        if out.output_type == "stream" and out.name == "stdout"
    )


def pictures(cell):
    """The pictures of a cell as arrays (height, width, channels)."""
    from matplotlib.image import imread

    return [
        imread(io.BytesIO(base64.b64decode(out.data["image/png"])))
        for out in cell.outputs
        if "image/png" in out.get("data", {})
    ]


def numbers(pattern, text):
    """The numbers in the first line that matches a pattern with groups."""
    found = re.search(pattern, text)
    assert found, f"nothing like {pattern!r} was printed"
    return [float(x) for x in found.groups()]


# Before anything runs ---------------------------------------------------------------------------------


@pytest.mark.parametrize("stem", STEMS)
def test_a_lab_asks_two_questions_with_a_rubric_each(stem):
    (lab,) = find_labs([stem])
    asked = [c.name for c in lab.cells if c.kind == "question"]
    assert len(asked) == 2
    assert {c.name for c in lab.cells if c.kind == "rubric"} == set(asked)


@pytest.mark.parametrize("stem", STEMS)
def test_something_is_seen_after_each_exercise(stem):
    (lab,) = find_labs([stem])
    since = None
    for cell in lab.cells:
        if cell.kind == "exercise":
            assert since != 0, f"nothing is drawn or computed before {cell.name}"
            since = 0
        elif cell.kind == "code" and since is not None:
            since += 1
    assert since


@pytest.mark.lab
def test_the_cells_of_the_labs_are_clean_code(course):
    # F401: the first cell imports what an answer may need, whether or not the reference does.
    ignored = "F401,D,ANN,PLR,PLW2901,C901"
    command = [sys.executable, "-m", "ruff", "check", "--config", ROOT / "pyproject.toml"]
    for path in sorted((course / "source").glob("*/*.ipynb")):
        done = subprocess.run(
            [*command, "--output-format", "concise", "--ignore", ignored, path],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout + done.stderr


# With the answers -------------------------------------------------------------------------------------


@pytest.mark.lab
@pytest.mark.parametrize("stem", STEMS)
def test_with_the_answers_a_lab_runs_in_two_minutes_and_raises_nothing(answered, stem):
    book, seconds = answered[stem]
    assert errors(book) == []
    assert seconds < LIMIT


@pytest.mark.lab
@pytest.mark.parametrize("stem", STEMS)
def test_every_cell_that_draws_shows_a_picture_with_something_in_it(answered, stem):
    book, _ = answered[stem]
    drawing = [c for c in book.cells if c.cell_type == "code" and "plt.show()" in c.source]
    drawing += [c for c in book.cells if c.cell_type == "code" and "views.show(" in c.source]
    assert len(drawing) > len(exercises(stem))
    for cell in drawing:
        shown = pictures(cell)
        assert shown, f"no picture below {cell.source[:60]!r}"
        for image in shown:
            ink = np.any(image[..., :3] < 0.9, axis=-1)
            colours = np.unique((255 * image[..., :3]).astype(int) @ (65536, 256, 1))
            assert ink.mean() > 0.005, f"almost blank below {cell.source[:60]!r}"
            assert len(colours) > 50, f"only {len(colours)} colours below {cell.source[:60]!r}"


@pytest.mark.lab
@pytest.mark.parametrize("stem", STEMS)
def test_a_flight_can_be_replayed_in_3d_and_says_whose_functions_flew(answered, stem):
    book, _ = answered[stem]
    frames = [
        out.data["text/html"]
        for cell in book.cells
        if cell.cell_type == "code" and "views.show(" in cell.source
        for out in cell.outputs
        if "text/html" in out.get("data", {})
    ]
    assert frames
    assert all("<iframe" in frame for frame in frames)
    said = re.search(r"who wrote what: (.*)", printed(book))
    assert said
    # What is identified is flown by one part only; in the last labs the parts themselves are the answers.
    least = {"identification": 1, "mpc": 2, "geometric": 1}.get(stem, 3)
    assert said[1].count(": mine") >= least
    assert ": reference" not in said[1]


@pytest.mark.lab
def test_lab_01_shows_the_physics_that_its_text_promises(answered):
    said = printed(answered["dynamics"][0])
    energy, momentum = numbers(r"energy off by (\S+), momentum by (\S+),", said)
    assert max(energy, momentum) < 1e-6
    (euler,) = numbers(r"Euler, 1 kHz\s+after 60 s: R Rᵀ − I is (\S+),", said)
    (exact,) = numbers(r"your step, 50 Hz\s+after 60 s: R Rᵀ − I is (\S+),", said)
    assert exact < 1e-11 < 0.5 < euler
    touch, light = numbers(r"on the ground at (\S+) s, apparent mass below half at (\S+) s", said)
    assert touch < light < touch + 1.0
    (apart,) = numbers(r"flown for \d+ s: (\S+) m apart", said)
    assert apart < 1e-9
    (alike,) = numbers(r"correlation of your acceleration with the track: (\S+)", said)
    drag, _ = numbers(r"drag: (\S+) m/s² per m/s; the constant: \[\s*(\S+)", said)
    assert alike > 0.9
    assert 0.2 < drag < 0.35


@pytest.mark.lab
def test_lab_02_loses_the_heading_with_lee_and_keeps_it_with_the_oblique_attitude(answered):
    said = printed(answered["heading"][0])
    for tilt, lost in ((20, 3.6), (30, 8.2), (45, 19.5), (60, 36.9)):
        lee, oblique = numbers(rf"{tilt}°\s+(\d\S*)°\s+(\S+)°", said)
        # Along the worst direction: atan(sin² / (2 cos)), worked out in the book's chapter.
        a = np.radians(tilt)
        worst = np.degrees(np.arctan(np.sin(a) ** 2 / (2 * np.cos(a))))
        assert lee == pytest.approx(worst, abs=0.06)
        assert lee == pytest.approx(lost, abs=0.06)
        assert oblique < 1e-9


@pytest.mark.lab
def test_lab_02_flies_best_with_the_compensation_and_the_oblique_attitude(answered):
    said = printed(answered["heading"][0])
    error = r"\s+heading error\s+(\S+)° rms"
    (mine,) = numbers("your functions" + error, said)
    (bare,) = numbers("without compensation" + error, said)
    (lee,) = numbers("with Lee's attitude" + error, said)
    assert mine < 5.0
    assert bare > 2 * mine
    assert lee > 2 * mine


@pytest.mark.lab
def test_lab_02_tells_the_right_formula_from_the_wrong_one_on_a_real_log(answered):
    said = printed(answered["heading"][0])
    (logged,) = numbers(r"heading of the logged attitude: (\S+)° rms", said)
    (mine,) = numbers(r"integral of your heading rate: (\S+)° rms", said)
    (naive,) = numbers(r"integral of the yaw rate: (\S+)° rms", said)
    assert logged < 0.2
    assert mine < 1.0
    assert naive > 5.0


@pytest.mark.lab
def test_lab_03_changes_worlds_without_a_push_and_one_filter_for_all_does_not(answered):
    said = printed(answered["kalman_bank"][0])
    (bank,) = numbers(r"your bank\s+: from 6 to 9.5 s the aircraft really moved by (\S+) m", said)
    (naive,) = numbers(
        r"one filter for all: from 6 to 9.5 s the aircraft really moved by (\S+) m", said
    )
    assert bank < 0.4
    assert naive > 2 * bank


@pytest.mark.lab
def test_lab_03_tells_an_honest_filter_from_one_that_believes_too_much(answered):
    said = printed(answered["kalman_bank"][0])
    (honest,) = numbers(r"told the truth\s+: mean NIS (\S+)", said)
    (proud,) = numbers(r"told a quarter of the noise\s+: mean NIS (\S+)", said)
    assert 0.85 < honest < 1.15
    assert proud > 2.0


@pytest.mark.lab
def test_lab_03_holds_the_heading_of_a_real_log_with_the_magnetometer_and_loses_it_without(
    answered,
):
    said = printed(answered["kalman_bank"][0])
    (gyro,) = numbers(r"gyro alone\s+: (\S+)° rms", said)
    (both,) = numbers(r"gyro and magnetometer\s+: (\S+)° rms", said)
    assert both < 0.5
    assert gyro > 3.0


@pytest.mark.lab
def test_lab_04_diverges_as_printed_at_heading_180_and_converges_as_corrected(answered):
    said = printed(answered["complementary"][0])
    (printed_,) = numbers(r"heading 180°, as printed: (\S+) rad/s", said)
    (mine,) = numbers(r"heading 180°, yours     : (\S+) rad/s", said)
    assert printed_ > 1.0
    assert mine < 1e-4


@pytest.mark.lab
def test_lab_04_comes_near_a_real_autopilot_with_its_raw_sensors(answered):
    said = printed(answered["complementary"][0])
    (tilt,) = numbers(r"your filter, K = 1: tilt (\S+)° rms", said)
    (attitude,) = numbers(r"your filter, K = 1: attitude (\S+)° rms", said)
    assert tilt < 0.3
    assert attitude < 2.0


@pytest.mark.lab
def test_lab_05_finds_the_drag_of_a_real_aircraft_where_it_was_flown_to_both_sides(answered):
    said = printed(answered["identification"][0])
    along_y = re.findall(r"phantom4-horizontal-\d+: .* c = \[\S+\s+(\S+?)\s*\]", said)
    assert len(along_y) == 3
    assert all(0.07 < float(c) < 0.11 for c in along_y)


@pytest.mark.lab
def test_lab_05_flies_at_its_height_once_it_has_weighed_itself(answered):
    said = printed(answered["identification"][0])
    (mine,) = numbers(r"your mass_step\s*: hangs\s+(\S+) cm", said)
    (told,) = numbers(r"as told\s*: hangs\s+(\S+) cm", said)
    assert abs(mine) < 5.0
    assert told > 40.0
    (fit,) = numbers(r"validation\s*: fit (\S+) %", said)
    assert fit > 85.0


@pytest.mark.lab
def test_lab_06_keeps_the_slew_that_the_paper_forgot_and_looks_far_with_one_weight(answered):
    said = printed(answered["mpc"][0])
    speed, jerk = numbers(r"yours           : fastest (\S+) m/s, largest jerk (\S+) m/s³", said)
    assert speed < 2.01
    assert jerk < 5.1
    (paper,) = numbers(r"\(50\) as printed : fastest \S+ m/s, largest jerk (\S+) m/s³", said)
    assert paper > 100
    short, endless = numbers(
        r"N =  2: slowest mode keeps (\S+) in 50 ms; with a terminal cost (\S+)", said
    )
    assert endless < 0.9 < 0.99 < short


@pytest.mark.lab
def test_lab_06_walks_where_the_estimate_leaps_and_makes_references_within_limits(answered):
    said = printed(answered["mpc"][0])
    speed, lean = numbers(r"yours                     : fastest (\S+) m/s, tilt up to (\d+)°", said)
    assert speed < 2.1
    assert lean <= 15
    (leap,) = numbers(r"stand-in, without a plan  : fastest \S+ m/s, tilt up to (\d+)°", said)
    assert leap > 40
    v, a = numbers(r"yours    : v up to (\S+) m/s, a (\S+) m/s²", said)
    assert max(v, a) < 1.02


@pytest.mark.lab
def test_lab_07_flies_each_misprint_beside_what_is_right(answered):
    said = printed(answered["geometric"][0])
    mine, paper = numbers(r"yours is off by (\S+) rad/s; as printed by (\S+) rad/s", said)
    assert mine < 1e-6
    assert paper > 100
    assert re.search(r"\(26\) as printed\s+: lost", said)
    (found,) = numbers(r"yours           : after 30 s height\s+\S+ m, mass (\S+) kg", said)
    assert found == pytest.approx(3.5, abs=0.02)
    (lost,) = numbers(r"\(37\) as printed : after \d+ s height\s+(\S+) m", said)
    assert lost < -15


@pytest.mark.lab
def test_lab_07_shows_that_the_jerk_pays_once_drag_is_gone(answered):
    said = printed(answered["geometric"][0])
    (known,) = numbers(r"yours, no drag            : (\S+) m;", said)
    (unknown,) = numbers(r"without the jerk, no drag : (\S+) m;", said)
    assert unknown > 2 * known
    (payload,) = numbers(
        r"yours             : off by\s+\S+ cm along the wind,\s+(\S+) cm in height", said
    )
    assert abs(payload) < 1.0


# Without ----------------------------------------------------------------------------------------------


@pytest.mark.lab
@pytest.mark.parametrize("stem", STEMS)
def test_without_answers_a_lab_raises_nothing_but_its_unfinished_exercises(course, stem, tmp_path):
    # As a student has it: the wheel without the solutions.
    hide = "import sys\nsys.modules['uavlab.solutions'] = None"
    book = executed(course, "release", stem, tmp_path, data=DATA, first=hide)
    raised = errors(book)
    assert {name for _, name, _ in raised} == {"NotImplementedError"}
    assert {message for _, _, message in raised} <= {x.unfinished for x in exercises(stem)}
    checks = [x for x in raised if x[0].startswith("# The public checks of")]
    assert len(checks) == len(exercises(stem))
    assert "stand-in" in printed(book)  # the flight flew all the same


@pytest.mark.lab
@pytest.mark.parametrize("stem", STEMS)
def test_without_the_recorded_flights_a_lab_says_so_and_goes_on(course, stem, tmp_path):
    book = executed(course, "source", stem, tmp_path, data=tmp_path, of_files=True)
    assert errors(book) == []
    asking = [c for c in book.cells if "needs the recorded" in c.source]
    assert asking
    assert printed(book).count("needs the recorded") >= len(asking)
    assert "UAVLAB_DATA" in printed(book)
