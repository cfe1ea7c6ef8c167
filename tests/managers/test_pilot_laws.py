"""A safe pilot obeys the laws of parts: pure, frame-blind, finite; a world that jumps is not felt."""

import copy

import numpy as np
import pytest
from ghost import SQUARE, believing

import uavlab
from uavlab.area import Area
from uavlab.experiments.control_flights import KNOWS, Believes, Knows
from uavlab.experiments.swaps import Jumps
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import Shift, moved
from uavlab.managers.modes import MODES
from uavlab.orders import (
    EmergencyLand,
    Fall,
    In,
    Land,
    LandHome,
    LandThere,
    TakeOff,
    Unheard,
    Use,
    Velocity,
)
from uavlab.parts.errands import Errand, there
from uavlab.parts.missions import Follow, still
from uavlab.parts.paths import circle
from uavlab.plant import CALM
from uavlab.so3 import about_z, exp
from uavlab.types import Attitude, Exit, Imu, Sectors, Sticks, Trajectory

DT = 0.02
SHIFT = Shift(np.array((3.0, -2.0, 0.5)), 0.4)
ZERO = np.zeros(3)
MAP = Shift(np.array((1.0, 1.0, 0.0)), 0.3)
WAY = Trajectory(
    np.arange(4.0), np.array(((0, 0, 2), (1, 0, 2), (2, 1, 2), (2, 2, 3.0))), np.zeros(4)
)
GOAL = still(np.array((2.0, 1.0, 2.5)), 0.3)
NEAR = {"sectors": Sectors(0.0, np.array((0.5, 9.0, 9.0, 9.0)), np.inf, np.inf)}
PUSHED = {"remote": Sticks(0.0, True, np.array((0.7, 0.2, 0.0)), 0.1, False)}
READ = {
    "imu": Imu(0.0, ZERO, np.array((0.1, 0.2, 0.3))),
    "ahrs": Attitude(0.0, exp(np.array((0.1, 0.0, 0.5)))),
}
LOST = believing()._replace(**{
    k: np.full_like(getattr(believing(), k), np.nan) for k in ("r", "v", "R")
})

# What is flown, tick by tick: asked, readings, belief. Each begins in the air but the first.
STORIES = {
    "up and home": [((TakeOff(1.0),), {}, None)] * 420 + [((LandHome(),), {}, None)] * 250,
    "goals": [((GOAL,), {}, None)] * 50 + [((WAY,), {}, None)] + [((), {}, None)] * 100,
    "elsewhere": [((In("map", GOAL), In("moon", GOAL)), {}, None)] * 50,
    "refused": [((still(np.array((20.0, 0.0, 2.0))),), {}, None)] * 50,
    "velocity": [((Velocity(np.array((3.0, 1.0, 0.2)), heading=0.4),), {}, None)] * 150,
    "velocity and height": [((Velocity(np.array((3.0, 1.0, 0.2)), 3.0),), {}, None)] * 100,
    "parts": [((Use("controller", "MpcController"), Use("limits", "fast")), {}, None)]
    + [((GOAL,), {}, None)] * 40 + [((Use("tracker", "LineTracker"), Use("gains", "none")), {}, None)] * 20,
    "there": [((LandThere(np.array((1.0, 2.0, 0.0)), 1.0),), {}, None)] * 250,
    "down": [((Land(),), {}, None)] * 100,
    "emergency": [((GOAL,), {}, None)] * 50 + [((EmergencyLand(),), {}, None)] * 100,
    "fall": [((Fall(),), READ, None)] * 50,
    "lost": [((GOAL,), {}, None)] * 50 + [((), READ, LOST)] * 30,
    "unheard": [((Unheard(),), {}, None)] * 170,
    "near": [((GOAL,), {}, None)] * 50 + [((), NEAR, None)] * 50 + [((), {}, None)] * 60,
    "sticks": [((GOAL,), {}, None)] * 50 + [((), PUSHED, None)] * 100 + [((), {}, None)] * 60,
}  # fmt: skip


def pilot(area=SQUARE, parts=("CommandFilter", "GeometricController")):
    return uavlab.piloted("T650", *parts, area=area).pilot


def told(asked, shift):
    """What is asked, told in the new world."""
    return tuple(x if isinstance(x, In) else there(x, shift) for x in asked)


def read(readings, shift):
    return {k: moved(x, shift) if k in {"ahrs"} else x for k, x in readings.items()}


def same(a, b, atol=0.0):
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k], atol) for k in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y, atol) for x, y in zip(a, b, strict=True))
    if a is None or isinstance(a, str) or not isinstance(a, float | int | np.ndarray | np.number):
        return a == b
    return np.allclose(a, b, rtol=0, atol=atol, equal_nan=True)


def flown(one, story, shift=None, at=0, watch=lambda *_: None):
    """A story flown by a ghost; told in another world from tick `at` on, if there is a shift."""
    estimate = believing((0.0, 0.0, 0.0 if story == "up and home" else 2.0), worlds={"map": MAP})
    memory, out = one.init(estimate, story == "up and home"), []
    for k, (asked, readings, belief) in enumerate(STORIES[story]):
        if shift is not None and k == at:
            memory, estimate = one.reframe(memory, shift), moved(estimate, shift)
        if belief is not None:
            estimate = estimate._replace(r=belief.r, v=belief.v, R=belief.R)
        elif k:
            last = out[-1][0]
            last = moved(last, shift) if shift is not None and k == at else last
            estimate = estimate._replace(r=last.r, v=last.v, R=about_z(last.heading))
        if shift is not None and k >= at:
            asked, readings = told(asked, shift), read(readings, shift)
        watch(memory, estimate, readings, asked)
        memory, reference, command = one.step(memory, estimate, readings, asked, DT)
        out.append((reference, command))
    return memory, out


@pytest.mark.parametrize("story", STORIES)
def test_a_step_twice_gives_the_same_and_leaves_its_inputs_alone(story):
    one, rng = pilot(), np.random.default_rng(0)

    def watch(*given):
        if rng.random() > 0.1:
            return
        before = copy.deepcopy(given)
        first, again = one.step(*given, DT), one.step(*given, DT)
        assert same(first[1:], again[1:])
        assert same(first[0], again[0])
        assert same(before, given)

    flown(one, story, watch=watch)


@pytest.mark.parametrize("story", STORIES)
def test_a_step_and_a_change_of_world_may_be_swapped(story):
    one, rng = pilot(), np.random.default_rng(1)

    def watch(memory, estimate, readings, asked):
        if rng.random() > 0.1:
            return
        after, reference, command = one.step(memory, estimate, readings, asked, DT)
        inputs = moved(estimate, SHIFT), read(readings, SHIFT), told(asked, SHIFT)
        there, reference_b, command_b = one.step(one.reframe(memory, SHIFT), *inputs, DT)
        assert same(moved(reference, SHIFT), reference_b, 1e-9)
        assert same(moved(command, SHIFT), command_b, 1e-9)
        expected = one.reframe(after, SHIFT)._replace(events=after.events)
        assert same(expected, there, 1e-9)

    flown(one, story, watch=watch)


@pytest.mark.parametrize("story", STORIES)
def test_a_world_that_jumps_in_a_story_leaves_all_decisions_as_they_were(story):
    one = pilot()
    memory, out = flown(one, story)
    at = len(STORIES[story]) // 3
    there, out_there = flown(one, story, SHIFT, at)
    assert [x[:3] for x in memory.events] == [x[:3] for x in there.events]
    for k, (a, b) in enumerate(zip(out, out_there, strict=True)):
        assert same(tuple(moved(x, SHIFT) for x in a) if k >= at else a, b, 1e-9)


def test_the_stories_reach_every_mode_but_the_last():
    modes = {
        x.name for story in STORIES for x in flown(pilot(), story)[0].events if x.kind == "mode"
    }
    assert modes == set(MODES) - {"landed"}


@pytest.mark.parametrize("story", STORIES)
def test_all_that_comes_out_is_finite_and_inside_the_area(story):
    _, out = flown(pilot(), story)
    for reference, command in out:
        assert all(np.isfinite(x).all() for x in (*reference, *command))
        assert (np.abs(reference.r[:2]) <= 10.0).all()


@pytest.mark.flight
@pytest.mark.parametrize("named", ["", "told"])
def test_an_aircraft_in_flight_does_not_feel_its_world_jump(named):
    way = circle(np.array((0.0, 0.0, 2.5)), 3.0)
    square = Area(((-6.0, -6.0), (6.0, -6.0), (6.0, 6.0), (-6.0, 6.0)), 0.5, 6.0)
    scenario = Scenario(
        "jumps", "", "T650", Follow(way, 0.5, 3.0), standing((3.0, 0.0, 2.5)), 9.0, {KNOWS: Knows()},
        wind=CALM._replace(mean=np.array((3.0, 0.0, 0.0))), area=square,
    )  # fmt: skip
    if named:
        steps = (Use("controller", "MpcController"), still(np.array((3.0, 2.0, 3.0))), LandHome())
        scenario = scenario._replace(mission=Errand(steps))
    logs = [
        uavlab.fly(scenario, uavlab.piloted(scenario, x, "CommandFilter"))
        for x in (Jumps(), Believes())
    ]
    assert logs[0].exit is Exit.DONE
    assert np.linalg.norm(logs[0].r - logs[1].r, axis=1).max() < 1e-9
    apart = np.linalg.norm(logs[0].r_e - logs[1].r_e, axis=1)
    assert apart.max() > 1.0
