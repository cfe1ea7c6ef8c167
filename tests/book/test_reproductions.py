"""The page of reproductions: complete, and as honest as the records it is made of."""

import pytest

from grader import build_reproductions
from grader.build import ROOT
from grader.build_reproductions import MARK, reproductions_page
from uavlab.experiments import Band, Experiment, Outcome, Row, all_experiments
from uavlab.experiments.record import load_record, record, save_record

FOLDER = ROOT / "book" / "reproductions"
KNOWN = [x.name for x in all_experiments()]


@pytest.fixture
def page(tmp_path, monkeypatch):
    rows = (
        Row("height | up [m]", "1.0", 1.0, Band(0.9, 1.1)),
        Row("speed [m/s]", "2", 3.0, Band(1, 2), note="Gusts."),
    )
    made = Experiment("000-1", "A ramp", "MRS Fig. 1", lambda seeds: Outcome(rows))
    absent = made._replace(name="000-2")
    monkeypatch.setattr(build_reproductions, "all_experiments", lambda: iter((made, absent)))
    save_record(record(made, 20, Outcome(rows, remarks=("It flew.",))), tmp_path / "000-1.json")
    return reproductions_page(f"# Title\n\n{MARK}\n", tmp_path)


def test_a_number_outside_its_band_is_shown_as_such_with_its_reason(page):
    assert "1 of 2 numbers lie within their bands" in page
    assert "| speed [m/s] | 2 | 3 | 1 to 2 | **not met** |" in page
    assert "- speed [m/s]: Gusts." in page


def test_an_experiment_that_was_not_run_is_named(page):
    assert "Not run yet: 000-2." in page


def test_a_bar_in_a_name_does_not_break_the_table(page):
    assert "| height \\| up [m] | 1.0 | 1 | 0.9 to 1.1 | met |" in page


@pytest.mark.parametrize("name", KNOWN)
def test_every_experiment_has_a_record_of_enough_seeds_and_a_figure(name):
    (experiment,) = (x for x in all_experiments() if x.name == name)
    kept = load_record(FOLDER / f"{name}.json")
    assert (kept.title, kept.source, kept.seeds) == (
        experiment.title,
        experiment.source,
        experiment.seeds,
    )
    assert (FOLDER / f"{name}.png").stat().st_size > 10_000


def test_no_record_is_left_of_an_experiment_that_is_gone():
    assert {p.stem for p in FOLDER.iterdir()} <= set(KNOWN)
