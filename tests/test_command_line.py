"""The command line: what it prints, what it writes, and what it says of bad input."""

import os
import subprocess
import sys

import numpy as np
import pytest
from made_flights import circle_log
from real_flights import recording

from uavlab import load_log
from uavlab.__main__ import main


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch):
    """Every test runs in an empty folder."""
    monkeypatch.chdir(tmp_path)


def files(folder):
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())


def python(*words, **environment):
    return subprocess.run(
        [sys.executable, *words], capture_output=True, text=True, check=False, timeout=120,
        env={**os.environ, **environment},
    )  # fmt: skip


# What is there ---------------------------------------------------------------------------------------


def test_list_names_scenarios_airframes_labs_and_datasets(capsys):
    assert main(["list"]) == 0
    said = capsys.readouterr().out
    for word in ("circle", "T650", "01 dynamics", "02 heading", "px4-sample", "CC BY 4.0"):
        assert word in said


def test_list_names_every_instrument_and_what_each_kit_carries(capsys):
    assert main(["list", "instruments"]) == 0
    said = capsys.readouterr().out
    for word in ("rtk", "BeaconCamera", "30 Hz", "velocity along the body's x and y axes"):
        assert word in " ".join(said.split())
    assert main(["list", "kits"]) == 0
    assert "Carries imu, mocap." in " ".join(capsys.readouterr().out.split())


def test_list_of_one_kind_leaves_out_the_others(capsys):
    assert main(["list", "airframes"]) == 0
    said = capsys.readouterr().out
    assert "F550" in said
    assert "lemniscate" not in said


def test_doctor_finds_what_this_environment_has(capsys, monkeypatch):
    monkeypatch.delenv("UAVLAB_DATA", raising=False)
    assert main(["doctor"]) == 0
    said = capsys.readouterr().out
    assert np.__version__ in said
    assert "first flight after" in said


def test_doctor_says_what_is_missing_and_the_cure(capsys, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("UAVLAB_DATA", str(tmp_path))
    assert main(["doctor"]) == 0  # without these the labs still run
    said = " ".join(capsys.readouterr().out.split())
    assert "Cure: apt install bubblewrap" in said
    assert "Cure: apt install chromium" in said
    assert "16 of 16 files missing" in said


def test_doctor_fails_when_a_package_that_flies_is_missing(capsys, monkeypatch):
    from importlib import metadata

    def version(name):
        if name == "pyulog":
            raise metadata.PackageNotFoundError(name)
        return "1"

    monkeypatch.setattr(metadata, "version", version)
    assert main(["doctor"]) == 1
    assert "pyulog" in capsys.readouterr().out


def test_help_and_version_are_there(capsys):
    for words in (["--help"], ["fly", "--help"]):
        with pytest.raises(SystemExit) as done:
            main(words)
        assert done.value.code == 0
    assert "--airframe" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["--version"])
    from uavlab import __version__

    assert capsys.readouterr().out.strip() == f"uavlab {__version__}"


# Flights ---------------------------------------------------------------------------------------------


@pytest.mark.flight
def test_fly_prints_numbers_and_writes_log_plots_and_replay(capsys, tmp_path):
    assert main(["fly", "hover", "--duration", "2", "--airframe", "f550", "--seed", "3"]) == 0
    said = capsys.readouterr().out
    assert "position error, mean [m]" in said
    assert "TiltAxis=stand-in" in said
    folder = tmp_path / "flights" / "hover-f550-seed3"
    assert files(folder) == [
        "flight.png",
        "log.npz",
        "meshcat.js",
        "path.png",
        "replay.html",
        "replay.png",
    ]
    log = load_log(folder / "log.npz")
    assert log.rotors.shape == (200, 6)
    assert log.meta["seed"] == 3


@pytest.mark.flight
def test_controller_tracker_and_gains_are_chosen_by_name(tmp_path, monkeypatch):
    from uavlab.flight import fill
    from uavlab.gains import gain_group
    from uavlab.parts.controllers import TiltAxis
    from uavlab.parts.trackers import CommandFilter

    asked = []

    class Answer(TiltAxis):
        def __init__(self, mass, gains=None):
            asked.append((mass, gains))
            super().__init__(mass)

    answers = {"GeometricController": Answer, "MpcTracker": CommandFilter}
    monkeypatch.setattr(fill, "reference", lambda _stem, name: answers[name])
    words = ["--controller", "GeometricController", "--tracker", "MpcTracker", "--gains", "tight"]
    flight = ["fly", "hover", "--duration", "0.1", "--airframe", "T650", "--out", "named"]
    assert main([*flight, *words]) == 0
    assert asked == [(3.5, gain_group("T650-sim-2020", "tight"))]
    assert load_log(tmp_path / "named" / "log.npz").meta["provenance"] == {
        "AlphaBetaGamma": "stand-in",
        "GeometricController": "reference",
        "MpcTracker": "reference",
    }


@pytest.mark.flight
@pytest.mark.slow
def test_wind_reaches_the_flight_and_the_seed_decides_the_gusts(tmp_path):
    logs = []
    for out, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        main(["fly", "hover", "--duration", "1", "--wind", "6", "--seed", seed, "--out", out])
        logs.append(load_log(tmp_path / out / "log.npz"))
    assert abs(logs[0].wind[:, 0].mean() - 6) < 4
    np.testing.assert_array_equal(logs[0].r, logs[1].r)
    assert (logs[0].wind != logs[2].wind).any()


@pytest.mark.slow
def test_a_flight_that_ends_badly_is_written_and_gives_exit_code_1(capsys, tmp_path, monkeypatch):
    from uavlab.types import Exit

    fall = circle_log(1.0, exit_=Exit.CRASH, reason="hit the ground at 4.2 m/s")
    monkeypatch.setattr("uavlab.flight.fly.fly", lambda *_args, **_options: fall)
    assert main(["fly", "hover", "--out", "fall"]) == 1
    assert "CRASH: hit the ground at 4.2 m/s" in capsys.readouterr().out
    assert (tmp_path / "fall" / "replay.html").exists()


# Replays ---------------------------------------------------------------------------------------------


def test_replay_shows_logs_of_ours_beside_each_other(capsys, tmp_path):
    circle_log(1.0).save("a.npz")
    circle_log(2.0).save("b.npz")
    assert main(["replay", "a.npz", "b.npz", "--out", "both.html"]) == 0
    assert capsys.readouterr().out.strip() == "both.html"
    assert files(tmp_path) == ["a.npz", "b.npz", "both.html", "meshcat.js"]


@pytest.mark.parametrize("name", ["px4-sample", "phantom4-vertical-1"])
def test_replay_shows_real_flights_by_name_and_cites_them(capsys, name):
    recording(name)
    assert main(["replay", name]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith(("BSD-3-Clause: ", "CC BY 4.0: "))
    assert os.path.exists(said[-1])


def test_replay_shows_real_flights_by_path():
    for name in ("px4-sample", "phantom4-line-1"):
        assert main(["replay", str(recording(name)), "--out", f"{name}.html"]) == 0


# Bad input -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["fyl"], "no command named 'fyl'. Did you mean 'fly'?"),
        (["list", "airframe"], "Did you mean 'airframes'?"),
        (["fly"], "required: NAME"),
        (["fly", "cirlce"], "no scenario named 'cirlce'. Did you mean 'circle'?"),
        (["fly", "hover", "--airframe", "T65"], "Did you mean 'T650'?"),
        (["fly", "hover", "--airframe", "none.toml"], "none.toml"),
        (["fly", "hover", "--seed", "x"], "invalid int value: 'x'"),
        (["fly", "hover", "--seed", "-1"], "must be 0 or more"),
        (["fly", "hover", "--wind", "nan"], "between −30 and 30"),
        (["fly", "hover", "--duration", "-3"], "duration"),
        (["fly", "hover", "--duration", "nan"], "duration"),
        (["fly", "hover", "--sed", "1"], "Try: uavlab"),
        (["fly", "hover", "--tracker", "MpcTraker"], "Did you mean 'MpcTracker'?"),
        (["fly", "hover", "--tracker", "GeometricController"], "give it as --controller"),
        (["fly", "hover", "--controller", "MpcTracker"], "give it as --tracker"),
        (["fly", "hover", "--gains", "tight"], "needs --controller GeometricController"),
        (["replay", "none.npz"], "no file at none.npz"),
        (["replay", "px4-sampel"], "Did you mean 'px4-sample'?"),
        (["replay", "."], "not a file"),
    ],
)
def test_bad_input_is_one_line_on_stderr_exit_code_2_and_nothing_written(
    capsys, tmp_path, words, why
):
    assert main(words) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("uavlab: ")
    assert said.err.count("\n") == 1
    assert why in said.err
    assert files(tmp_path) == []


@pytest.mark.parametrize("keep", [0, 100, 3000])
def test_a_log_cut_short_is_one_line_and_nothing_written(capsys, tmp_path, keep):
    path = circle_log(1.0).save("cut.npz")
    path.write_bytes(path.read_bytes()[:keep])
    assert main(["replay", "cut.npz", "--out", "cut.html"]) == 2
    assert capsys.readouterr().err.startswith("uavlab: cut.npz is not a whole uavlab log")
    assert files(tmp_path) == ["cut.npz"]


def test_a_px4_log_cut_short_is_one_line(capsys, tmp_path):
    (tmp_path / "cut.ulg").write_bytes(recording("px4-sample").read_bytes()[:100_001])
    assert main(["replay", "cut.ulg"]) == 2
    assert "cut short" in capsys.readouterr().err
    assert files(tmp_path) == ["cut.ulg"]


def test_a_folder_that_is_a_file_is_refused_and_left_alone(capsys, tmp_path):
    (tmp_path / "taken").write_text("mine")
    assert main(["fly", "hover", "--duration", "1", "--out", "taken"]) == 2
    assert "taken" in capsys.readouterr().err
    assert (tmp_path / "taken").read_text() == "mine"
    assert files(tmp_path) == ["taken"]


@pytest.mark.slow
def test_a_write_that_fails_in_the_middle_leaves_nothing(tmp_path, monkeypatch, capsys):
    from uavlab import views
    from uavlab.errors import BadFile

    def no_room(*_args, **_options):
        raise BadFile("no room on the disk.")

    monkeypatch.setattr(views, "replay", no_room)
    assert main(["fly", "hover", "--duration", "1", "--out", "out"]) == 2
    assert capsys.readouterr().err == "uavlab: no room on the disk.\n"
    assert list(tmp_path.iterdir()) == []


# As a process ----------------------------------------------------------------------------------------


def test_importing_uavlab_and_its_command_line_starts_nothing_heavy():
    code = (
        "import sys, uavlab, uavlab.__main__; "
        "print([m for m in ('numba', 'matplotlib', 'scipy', 'meshcat', 'pyulog') if m in sys.modules])"
    )
    assert python("-c", code).stdout.strip() == "[]"


def test_the_module_runs_as_a_program_and_prints_no_traceback():
    done = python("-m", "uavlab", "fly", "cirlce")
    assert done.returncode == 2
    assert done.stderr.startswith("uavlab: no scenario named 'cirlce'")
    assert "Traceback" not in done.stderr


def test_without_words_it_says_what_it_can_do(capsys):
    assert main([]) == 0
    assert "doctor" in capsys.readouterr().out
