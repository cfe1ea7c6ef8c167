"""Errands in a scenario's file: steps for a pilot; and the example that flies one."""

import pickle
import shutil

import numpy as np
import pytest

from uavlab import scenarios
from uavlab.errors import BadInput
from uavlab.flight.fly import fly
from uavlab.managers.pilot import SafePilot
from uavlab.orders import EmergencyLand, Fall, Land, LandHome, LandThere, TakeOff, Use, Velocity
from uavlab.parts.errands import Errand, Wait
from uavlab.scenarios.files import DATA, load_file
from uavlab.types import Exit, Reference, Trajectory

CAMPUS = DATA / "campus.toml"
LEAST = 'airframe = "F450"\nduration = 1.0\npilot = true\n[mission]\nkind = "errand"\nsteps = [\n{}\n]\n'


def loaded(tmp_path, steps: str, text: str = LEAST):
    path = tmp_path / "mine.toml"
    path.write_text(text.replace("{}", steps), encoding="utf-8")
    return load_file(path)


@pytest.mark.parametrize(
    ("step", "told"),
    [
        ('do = "takeoff"', (TakeOff(),)),
        ('do = "takeoff", height = 3', (TakeOff(3.0),)),
        ('do = "land"', (Land(),)),
        ('do = "land home"', (LandHome(),)),
        ('do = "use", slot = "gains", name = "soft"', (Use("gains", "soft"),)),
        ('do = "wait", time = 2', (Wait(2.0),)),
        ('do = "emergency"', (EmergencyLand(),)),
        ('do = "fall"', (Fall(),)),
    ],
)
def test_each_kind_of_step_is_the_order_that_it_names(tmp_path, step, told):
    assert loaded(tmp_path, f"{{ {step} }}").mission.steps == told


def test_places_ways_and_velocities_are_told_with_what_goes_with_them(tmp_path):
    steps = (
        '{ do = "goto", r = [1, 2, 3], heading = 0.5 },\n'
        '{ do = "follow", t = [0, 1], r = [[0, 0, 2], [1, 0, 2]], heading = [0, 0.1] },\n'
        '{ do = "velocity", v = [1, 0, 0], time = 4, z = 3.0, heading_rate = 0.2 },\n'
        '{ do = "land there", r = [1, 2, 0], heading = -1 }'
    )
    place, way, velocity, wait, there = loaded(tmp_path, steps).mission.steps
    assert isinstance(place, Reference)
    np.testing.assert_array_equal(place.r, (1, 2, 3))
    assert (place.heading, place.heading_rate) == (0.5, 0.0)
    assert isinstance(way, Trajectory)
    np.testing.assert_array_equal(way.r, [[0, 0, 2], [1, 0, 2]])
    np.testing.assert_array_equal(way.heading, (0, 0.1))
    assert isinstance(velocity, Velocity)
    assert velocity[1:] == (3.0, None, 0.2)
    np.testing.assert_array_equal(velocity.v, (1, 0, 0))
    assert wait == Wait(4.0)
    assert isinstance(there, LandThere)
    np.testing.assert_array_equal(there.r, (1, 2, 0))
    assert there.heading == -1.0


def test_when_a_step_is_done_can_be_said(tmp_path):
    text = LEAST.replace("steps", "patience = 9\nnear = 0.2\nsteps")
    mission = loaded(tmp_path, '{ do = "land" }', text).mission
    assert (mission.patience, mission.near, mission.slow) == (9.0, 0.2, Errand((Land(),)).slow)


def test_with_a_pilot_the_safe_one_flies_in_the_area_and_without_whoever_is_named():
    scenario = load_file(CAMPUS)
    pilot = scenario.mind("F450").pilot
    assert isinstance(pilot, SafePilot)
    assert pilot.area is scenario.area
    again = pickle.loads(pickle.dumps(scenario))  # a campaign flies it in other processes
    assert again.mind("F450").pilot.area.told() == scenario.area.told()
    assert load_file(DATA / "courtyard.toml").mind is None


@pytest.mark.parametrize(
    ("step", "said"),
    [
        ("3", r'mission.steps\[0\] is 3; write a table such as \{ do = "land" \}'),
        ("{ height = 2 }", r"mission.steps\[0\].do is missing; add it"),
        ('{ do = "takeof" }', r"no mission.steps\[0\].do named 'takeof'. Did you mean 'takeoff'"),
        ('{ do = "takeoff", heihgt = 2 }', r"key of mission.steps\[0\] named 'heihgt'. Did you mean 'height'"),
        ('{ do = "takeoff", height = -2 }', r"mission.steps\[0\].height is -2.0; it must be > 0"),
        ('{ do = "goto", r = [1, 2] }', r"mission.steps\[0\].r is \[1, 2\]; it must be a list of 3 numbers"),
        ('{ do = "goto", r = [1, 2, inf] }', r"mission.steps\[0\].r is inf; it must be a finite number"),
        ('{ do = "goto", r = [1, 2, 3], heading = "n" }', r"mission.steps\[0\].heading is 'n'; it must be a finite"),
        ('{ do = "follow", t = [0], r = [1, 2, 3] }', r"mission.steps\[0\].r is .*; it must be places"),
        ('{ do = "follow", t = [0, 1], r = [[1, 2, 3]] }', r"mission.steps\[0\].t is .*; it must be a list of 1 num"),
        ('{ do = "follow", t = [1, 0], r = [[1, 2, 3], [1, 2, 4]] }', r"mission.steps\[0\]: .*t"),
        ('{ do = "velocity", v = [1, 0, 0] }', r"mission.steps\[0\].time is missing"),
        ('{ do = "wait", time = 0 }', r"mission.steps\[0\].time is 0.0; it must be > 0"),
        ('{ do = "use", slot = "gain", name = "soft" }', r"no mission.steps\[0\].slot .*Did you mean 'gains'"),
        ('{ do = "use", slot = "gains" }', r"mission.steps\[0\].name is missing"),
        ('{ do = "land" }, { do = "land" }', r"mission: steps\[0\]: Land ends an errand; take out what follows"),
        ("", r"mission: an Errand has no steps"),
    ],
)  # fmt: skip
def test_a_step_that_cannot_be_is_refused_by_file_and_key(tmp_path, step, said):
    with pytest.raises(BadInput, match=said) as refused:
        loaded(tmp_path, step)
    assert str(refused.value).startswith("mine.toml: ")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("pilot = true\n", ""), r"mission.kind is 'errand', whose orders only a pilot obeys; add pilot = true"),
        (("pilot = true", "pilot = 1"), r"pilot is 1; it must be true or false"),
        (("steps", "patience = 0\nsteps"), r"mission: patience is 0.0; it must be above 0"),
        (("steps", "patient = 3\nsteps"), r"no key of mission named 'patient'. Did you mean 'patience'"),
        (("steps", "stops"), r"no key of mission named 'stops'. Did you mean 'steps'"),
        (('"errand"', '"errant"'), r"no mission.kind named 'errant'. Did you mean 'errand'"),
    ],
)  # fmt: skip
def test_an_errand_that_cannot_be_is_refused_by_file_and_key(tmp_path, change, said):
    with pytest.raises(BadInput, match=said):
        loaded(tmp_path, '{ do = "land" }', LEAST.replace(*change))


@pytest.mark.slow
@pytest.mark.flight
def test_the_example_takes_off_goes_around_the_tower_and_lands_at_home(tmp_path):
    scenario = scenarios.load(str(shutil.copy(CAMPUS, tmp_path / "campus.toml")))
    log = fly(scenario, seed=1)
    assert log.exit is Exit.LANDED, log.reason
    assert np.linalg.norm(log.r[-1]) < 0.3
    events = log.meta["events"]
    modes = [name for _, kind, name, _ in events if kind == "mode"]
    assert modes == ["ground", "taking off", "flying", "going home", "landing", "landed"]
    refused = [said for _, kind, _, said in events if kind == "refused"]
    assert len(refused) == 1
    assert "(9.0, 20.0, 2.0) m, lies 8.5 m outside the margin of the safety area" in refused[0]
    for place in ((9.0, 0.0, 2.0), (9.0, 9.0, 3.0), (0.0, 9.0, 2.0)):
        assert np.linalg.norm(log.r - place, axis=1).min() < 0.3
    assert log.meta["area"] == scenario.area.told()
    assert [x[0] for x in log.meta["faults"]] == ["gust"]
    inside = [not scenario.area.why_not_at(r) for r in log.r[::20] if r[2] > 1.0]
    assert all(inside)
