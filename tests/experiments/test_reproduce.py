"""`uavlab reproduce`: rows beside the paper's, an honest verdict, files that can be read again."""

import json
import sys
from types import ModuleType

import numpy as np
import pytest

from uavlab.__main__ import main
from uavlab.errors import BadFile, BadInput
from uavlab.experiments import Band, Experiment, Line, Outcome, Panel, Row, spec
from uavlab.experiments.record import load_record, record, save_record
from uavlab.experiments.table import band, cells, verdict

X = np.linspace(0.0, 1.0, 20)
PANEL = Panel(
    "A ramp",
    "time [s]",
    "height [m]",
    (
        Line("truth", X, X, "truth"),
        Line("ours", X, X + 0.1),
        Line("3σ", X, X - 0.1, "band", X + 0.3),
        Line("paper", X, 0 * X, "paper"),
        Line("flights", X, X**2, "points"),
    ),
    marks=((0.5, "half way"),),
)


def within(seeds):
    noise = np.random.default_rng(7).normal(size=seeds)
    return Outcome(
        (Row("height [m]", "1.0", 1.0 + 0.01 * noise.mean(), Band(0.9, 1.1), noise.std()),),
        (PANEL,),
        ("Flown on a ramp.",),
    )


def outside(seeds):
    return Outcome((Row("speed [m/s]", "2", 3.0, Band(1.9, 2.1), note="The wind is not known."),))


def missing(seeds):
    raise BadFile("the real flights are not here. Set UAVLAB_DATA.")


@pytest.fixture
def experiments(monkeypatch):
    module = ModuleType("uavlab.experiments.made_up")
    module.EXPERIMENTS = (
        Experiment("000-1", "A ramp that is met", "MRS Fig. 1", within),
        Experiment("000-2", "A speed that is not", "MRS Fig. 2", outside, seeds=1),
        Experiment("real-x", "A flight that is missing", "ours", missing, seeds=1),
    )
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(spec, "MODULES", ("made_up",))


def test_a_number_within_its_band_is_met_and_its_figure_and_record_are_written(
    experiments, tmp_path, capsys
):
    assert main(["reproduce", "000-1", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "000-1  A ramp that is met  (MRS Fig. 1; 20 seeds" in said
    assert "0.9 to 1.1  met" in said
    assert "Flown on a ramp." in said
    assert (tmp_path / "000-1.png").stat().st_size > 10_000
    kept = load_record(tmp_path / "000-1.json")
    assert kept.seeds == 20
    assert kept.met


def test_a_number_outside_its_band_is_said_with_its_reason_and_costs_the_exit_code(
    experiments, tmp_path, capsys
):
    assert main(["reproduce", "000-2", "--out", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    assert "NOT MET" in said
    assert "speed [m/s]: The wind is not known." in said
    assert not load_record(tmp_path / "000-2.json").met


def test_what_cannot_be_run_is_named_and_the_others_are_run_all_the_same(
    experiments, tmp_path, capsys
):
    assert main(["reproduce", "--all", "--seeds", "2", "--out", str(tmp_path)]) == 1
    said = capsys.readouterr().out
    assert "real-x: not run. the real flights are not here. Set UAVLAB_DATA." in said
    assert sorted(p.name for p in tmp_path.iterdir()) == ["000-1.json", "000-1.png", "000-2.json"]
    assert load_record(tmp_path / "000-1.json").seeds == 2


def test_the_same_seeds_give_the_same_record(experiments, tmp_path):
    for folder in ("a", "b"):
        main(["reproduce", "000-1", "--out", str(tmp_path / folder)])
    first, second = (tmp_path / x / "000-1.json" for x in "ab")
    assert first.read_bytes() == second.read_bytes()


def test_the_list_names_each_experiment_with_its_source(experiments, capsys):
    assert main(["reproduce", "--list"]) == 0
    assert "000-2   MRS Fig. 2  A speed that is not" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["reproduce"], "name an experiment, or say --all"),
        (["reproduce", "000-3"], "no experiment named '000-3'. Did you mean"),
        (["reproduce", "000-1", "--seeds", "0"], "--seeds is 0; it must be 1 or more"),
        (["reproduce", "000-1", "--jobs", "0"], "--jobs is 0; it must be 1 or more"),
        (["reproduce", "000-1", "--seeds", "many"], "invalid int value"),
    ],
)
def test_what_cannot_be_meant_is_refused_in_one_line(experiments, words, said, capsys):
    assert main(words) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_file_where_the_folder_should_be_is_refused(experiments, tmp_path, capsys):
    (tmp_path / "out").write_text("mine")
    assert main(["reproduce", "000-1", "--out", str(tmp_path / "out")]) == 2
    assert "Choose another folder with --out" in capsys.readouterr().err
    assert (tmp_path / "out").read_text() == "mine"


@pytest.mark.parametrize(
    ("ours", "limits", "said"),
    [
        (1.0, Band(1.0, 2.0), "met"),
        (2.0, Band(1.0, 2.0), "met"),
        (0.999, Band(1.0, 2.0), "NOT MET"),
        (np.nan, Band(-np.inf, np.inf), "NOT MET"),
        (np.inf, Band(0.0, np.inf), "NOT MET"),
        (5.0, None, "told"),
    ],
)
def test_a_verdict_is_that_of_the_band_and_what_is_not_finite_is_not_met(ours, limits, said):
    assert verdict(Row("x", "1", ours, limits)) == said


def test_bands_are_told_as_one_reads_them():
    assert band(Band(-np.inf, 0.16)) == "≤ 0.16"
    assert band(Band(85.0, np.inf)) == "≥ 85"
    assert band(Band(1e-9, 2.0)) == "1.00e-09 to 2"
    assert cells(Row("x", "", 1 / 3, spread=0.01))[1:3] == ("—", "0.3333 ± 0.01")


def test_a_record_can_be_read_again_with_open_bands_and_numbers_that_are_not_finite(tmp_path):
    rows = (Row("x", "1", np.nan, Band(-np.inf, 1.0), np.inf), Row("y", "—", 2.0))
    kept = record(Experiment("n", "t", "s", within), 3, Outcome(rows))
    back = load_record(save_record(kept, tmp_path / "n.json"))
    assert np.isnan(back.rows[0].ours)
    assert back.rows[0]._replace(ours=0.0) == rows[0]._replace(ours=0.0)
    assert back.rows[1] == rows[1]


@pytest.mark.parametrize("text", ["", "[]", '{"name": "x"}', json.dumps({"rows": [{}]})])
def test_what_is_not_a_record_is_refused(tmp_path, text):
    (tmp_path / "x.json").write_text(text)
    with pytest.raises(BadFile, match="not the record of an experiment"):
        load_record(tmp_path / "x.json")


def test_an_experiment_needs_a_seed():
    with pytest.raises(BadInput, match="0 seeds"):
        Experiment("n", "t", "s", within).outcome(0)
