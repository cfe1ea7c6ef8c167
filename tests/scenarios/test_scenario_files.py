"""Scenarios from files: what they say is what flies, and what they may not say is refused by file and key."""

import argparse
import shutil

import numpy as np
import pytest

from uavlab import scenarios
from uavlab.commands import fly as fly_command
from uavlab.errors import BadFile, BadInput
from uavlab.flight.fly import fly
from uavlab.flight.scenario import Swap
from uavlab.scenarios.files import DATA, load_file
from uavlab.sensors import INSTRUMENTS, Jump, Outage, Outliers

EXAMPLE = DATA / "courtyard.toml"
LEAST = 'airframe = "F450"\nduration = 1.0\n[mission]\nkind = "waypoints"\nstops = [{ t = 0.0, r = [0, 0, 2] }]\n'


def written(tmp_path, text: str):
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_example_says_what_flies():
    scenario = scenarios.load(str(EXAMPLE))
    gnss = scenario.sensors["gnss"]
    assert (scenario.name, scenario.airframe, scenario.duration) == ("courtyard", "F450", 20.0)
    assert (gnss.rate, gnss.outages) == (5.0, (Outage(6.0, 9.0),))
    assert gnss.outliers == Outliers(0.02, 8.0)
    assert isinstance(gnss.jumps[0], Jump)
    np.testing.assert_array_equal(gnss.jumps[0].by, (3, 0, 0))
    assert scenario.sensors["mocap"].noise == 0.002
    assert scenario.sensors["mocap"].rate == INSTRUMENTS["mocap"]().rate
    assert set(scenario.sensors) == {"imu", "mocap", "gnss"}
    np.testing.assert_allclose(scenario.mission.goal(0.0).r, (3, 0, 3))
    np.testing.assert_array_equal(scenario.wind.mean, (2, 0, 0))


def test_what_a_file_leaves_out_is_as_usual(tmp_path):
    scenario = load_file(written(tmp_path, LEAST))
    assert set(scenario.sensors) == {"imu", "mocap"}
    assert (scenario.rate, scenario.physics) == (100.0, 1000.0)
    np.testing.assert_array_equal(scenario.start.r, 0.0)


def test_a_scenario_from_a_file_flies():
    log = fly(load_file(EXAMPLE)._replace(duration=1.0), seed=3)
    assert log.exit.name == "DONE"


def test_the_command_takes_the_path_of_a_file(tmp_path):
    path = shutil.copy(EXAMPLE, tmp_path / "yard.toml")
    asked = argparse.Namespace(scenario=str(path), seed=0, airframe=None, duration=0.5, wind=None)
    scenario = fly_command.asked(asked)
    assert (scenario.name, scenario.duration) == ("yard", 0.5)


@pytest.mark.parametrize(
    ("sensor", "figure", "value"),
    [
        ("rtk", "corrections_lost = [[3, 5]]", (Outage(3.0, 5.0),)),
        ("flow", "dark = [[1.0, 2.0]]", (Outage(1.0, 2.0),)),
        ("slam", "closures = [4, 8]", (4.0, 8.0)),
        ("rtk", "silent = true", True),
    ],
)
def test_every_kind_of_figure_can_be_written(tmp_path, sensor, figure, value):
    path = written(tmp_path, LEAST + f"[sensors.{sensor}]\n{figure}\n")
    assert getattr(load_file(path).sensors[sensor], figure.split()[0]) == value


def test_worlds_and_disturbances_can_be_written(tmp_path):
    text = LEAST + (
        "[sensors.slam]\nworld = { r = [1, 2, 3], heading = 0.5 }\n"
        "[sensors.magnetometer]\ndisturbances = [{ m = [0.3, 0, 0], start = 2, end = 4 }]\n"
    )
    carried = load_file(written(tmp_path, text)).sensors
    assert carried["slam"].world.heading == 0.5
    assert carried["magnetometer"].disturbances[0].end == 4.0


SWAP = '[[swap]]\nt = 0.2\nslot = "controller"\nname = "TiltAxis"\n'


def test_swaps_can_be_written_and_the_command_finds_the_parts_and_says_who_flew(tmp_path, capsys):
    path = written(
        tmp_path, LEAST + SWAP.replace("TiltAxis", "MpcController") + SWAP.replace("0.2", "0.4")
    )
    asked = argparse.Namespace(
        scenario=str(path), seed=0, airframe=None, duration=0.5, wind=None,
        controller=None, tracker=None, gains=None,
    )  # fmt: skip
    scenario = fly_command.asked(asked)
    assert scenario.swaps == (
        Swap(0.2, "controller", "MpcController"),
        Swap(0.4, "controller", "TiltAxis"),
    )
    log = fly(scenario, fly_command.named(asked, scenario))
    assert [x[2:] for x in log.meta["swaps"]] == [
        ["TiltAxis", "first"], ["MpcController", "taken over"], ["TiltAxis", "taken over"],
    ]  # fmt: skip
    fly_command.show(log)
    assert "0.20 s: controller MpcController: taken over" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("t = 0.2", "t = -1"), r"swap\[0\].t is -1.0 s; it must be ≥ 0"),
        (("t = 0.2", 't = "soon"'), r"swap\[0\].t is 'soon'; it must be a finite number"),
        (("t = 0.2\n", ""), r"swap\[0\].t is missing; add it"),
        (('"controller"', '"controllerr"'), r"no swap\[0\].slot named 'controllerr'.*'controller'"),
        (("name =", "nname ="), r"key of swap\[0\] named 'nname'. Did you mean 'name'"),
        (('"TiltAxis"', "3"), r"swap\[0\].name is 3; write a text in quotes"),
        (("[[swap]]", "[swap]"), r"swap is {.*; it must be tables \[\[swap\]\]"),
    ],
)
def test_a_swap_that_cannot_be_is_refused_by_file_and_key(tmp_path, change, said):
    assert change[0] in SWAP
    with pytest.raises(BadInput, match=said) as refused:
        load_file(written(tmp_path, LEAST + SWAP.replace(*change)))
    assert str(refused.value).startswith("mine.toml: ")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("duration = 1.0\n", ""), "duration is missing"),
        (("duration = 1.0", "duration = -1.0"), "duration is -1.0; it must be > 0"),
        (("duration = 1.0", 'duration = "long"'), "duration is 'long'; it must be a finite number"),
        (("duration = 1.0", "duration = 1.0\nspeed = 3"), "'speed'.*Known: airframe"),
        (('"F450"', '"F451"'), "no airframe named 'F451'.*F450"),
        (('"waypoints"', '"waypoint"'), "mission.kind.*Did you mean 'waypoints'"),
        (("r = [0, 0, 2]", "r = [0, 2]"), r"mission.stops\[0\].r is \[0, 2\]; it must be a list of 3"),
        (("t = 0.0", "at = 0.0"), "'at'.*Known: heading, r, t"),
        (("[mission]", "[start]\nr = [0, 0, -1]\n[mission]"), "start.r .*z must be ≥ 0"),
        (("[mission]", "[wind]\nmean = [1, 2]\n[mission]"), "wind.mean"),
        (("[mission]", "[wind]\nsigma = [1, -2, 0]\n[mission]"), "wind: sigma"),
        (("[mission]", '[sensors]\nkit = "outdor"\n[mission]'), "Did you mean 'outdoor'"),
        (("[mission]", "[sensors.gps]\n[mission]"), "no instrument named 'gps'"),
        (("[mission]", "[sensors.gnss]\nrat = 3\n[mission]"), "sensors.gnss.*Did you mean 'rate'"),
        (("[mission]", "[sensors.gnss]\nrate = [1, 2]\n[mission]"), "sensors.gnss.rate is"),
        (("[mission]", "[sensors.gnss]\nrate = 0\n[mission]"), "rate is 0.0 Hz; it must be > 0"),
        (("[mission]", "[sensors.gnss]\noutages = [[1, 2, 3]]\n[mission]"), r"outages is \[1, 2, 3\]"),
        (("[mission]", "[sensors.gnss]\njumps = [{ by = 3 }]\n[mission]"), "jumps: t is missing"),
        (("[mission]", "[sensors.gnss]\nnoise = nan\n[mission]"), "noise is nan"),
        (("[mission]", "[sensors.rtk]\nsilent = 1\n[mission]"), "silent is 1; it must be true or false"),
    ],
)  # fmt: skip
def test_what_a_file_may_not_say_is_refused_by_file_and_key(tmp_path, change, said):
    assert change[0] in LEAST
    with pytest.raises(BadInput, match=said) as refused:
        load_file(written(tmp_path, LEAST.replace(*change)))
    assert str(refused.value).startswith("mine.toml: ")


def test_a_file_that_is_not_there_or_not_toml_is_said_so(tmp_path):
    with pytest.raises(BadFile, match="cannot read"):
        scenarios.load("nowhere.toml")
    with pytest.raises(BadFile, match="not TOML"):
        load_file(written(tmp_path, "airframe = \n"))
