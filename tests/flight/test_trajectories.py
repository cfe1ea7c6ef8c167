"""Trajectories: given once by a mission, followed by trackers, refused where nobody could."""

import numpy as np
import pytest

import uavlab
from uavlab.errors import BadInput
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import NO_SHIFT, Shift, moved
from uavlab.interfaces import Stack
from uavlab.limits import limit_group
from uavlab.parts.controllers import HeadingController
from uavlab.parts.missions import Fly, InWorld
from uavlab.parts.trackers import CommandFilter, along, unwrapped, why_not
from uavlab.scenarios import load
from uavlab.solutions.mpc import MpcTracker
from uavlab.types import Estimate, Reference, Trajectory

T = np.arange(0.0, 4.1, 0.5)
WAY = Trajectory(T, np.column_stack((T, np.sin(T), 2.0 + 0 * T)), np.linspace(2.5, 4.0, len(T)))
ZERO = np.zeros(3)
HERE = Estimate(np.array((0.0, 0.0, 2.0)), ZERO, ZERO, np.eye(3), ZERO)
MEDIUM = limit_group("medium")


def given(mission, ticks, estimate=HERE, dt=0.01):
    memory, goals = mission.init(estimate), []
    for _ in range(ticks):
        memory, goal = mission.step(memory, estimate, dt)
        goals.append(goal)
    return memory, goals


def test_a_trajectory_is_given_once_when_its_time_has_come():
    _, goals = given(Fly(WAY, at=0.03), 6)
    assert [type(goal) for goal in goals] == [Reference] * 3 + [Trajectory] + [type(None)] * 2
    assert goals[0].r == pytest.approx(WAY.r[0])
    assert goals[3].r == pytest.approx(WAY.r)


def test_a_change_of_world_reaches_a_trajectory_that_is_still_to_come():
    mission, shift = Fly(WAY), Shift(np.array((1.0, 2.0, 3.0)), 0.5)
    memory = mission.reframe(mission.init(HERE), shift)
    _, goal = mission.step(memory, HERE, 0.01)
    assert goal.r == pytest.approx(moved(WAY, shift).r)


def test_a_trajectory_waits_until_its_world_is_known():
    mission = InWorld(Fly(WAY), "map")
    memory, goals = given(mission, 3)
    assert all(isinstance(goal, Reference) for goal in goals)
    shift = Shift(np.array((5.0, 0.0, 0.0)), 0.3)
    memory, goal = mission.step(memory, HERE._replace(worlds={"map": shift}), 0.01)
    assert goal.r == pytest.approx(moved(WAY, shift).r)
    assert mission.step(memory, HERE, 0.01)[1] is None


def test_a_trajectory_is_linear_between_its_points_and_stays_at_its_ends():
    r, heading = along(WAY, np.array((-1.0, 0.25, 99.0)))
    assert r[0] == pytest.approx(WAY.r[0])
    assert r[1] == pytest.approx((WAY.r[0] + WAY.r[1]) / 2)
    assert r[2] == pytest.approx(WAY.r[-1])
    assert heading[2] == WAY.heading[-1]
    jumping = WAY._replace(heading=(WAY.heading + np.pi) % (2 * np.pi) - np.pi)
    assert np.diff(unwrapped(jumping).heading) == pytest.approx(np.diff(WAY.heading))


BAD = {
    "nan": (WAY._replace(r=np.where(WAY.r == WAY.r[3, 1], np.nan, WAY.r)), r"r\[3, 1\] .* nan"),
    "backwards": (WAY._replace(t=WAY.t[::-1]), "backwards in time: .* Sort"),
    "twice": (WAY._replace(t=np.zeros(len(T))), "backwards in time"),
    "shape": (WAY._replace(r=WAY.r[:, :2]), r"places \(9, 2\)"),
    "headings": (WAY._replace(heading=WAY.heading[:3]), r"headings \(3,\)"),
    "empty": (Trajectory(np.zeros(0), np.zeros((0, 3)), np.zeros(0)), "at least 1"),
    "words": (WAY._replace(t="soon"), "arrays of numbers"),
    "none": (None, "Trajectory"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_trajectory_that_nobody_can_fly_is_refused(name):
    way, said = BAD[name]
    with pytest.raises(BadInput, match=said):
        Fly(way)


def test_a_time_before_the_start_is_refused():
    for at in (-1.0, np.nan, np.inf):
        with pytest.raises(BadInput, match="0 s or later"):
            Fly(WAY, at=at)
    assert why_not(WAY) == ""
    assert "only numbers" in why_not(Reference(ZERO, ZERO, ZERO, ZERO, np.nan, 0.0))


@pytest.mark.parametrize(("tracker", "lag"), [(CommandFilter(), 0.7), (MpcTracker(MEDIUM), 0.3)])
def test_a_tracker_follows_a_trajectory_through_a_change_of_world(tracker, lag):
    memory, worst = tracker.init(HERE, None), 0.0
    shift, way = NO_SHIFT, WAY
    for k in range(700):
        if k == 200:
            shift = Shift(np.array((5.0, -3.0, 1.0)), 1.0)
            memory, way = tracker.reframe(memory, shift), unwrapped(moved(WAY, shift))
        memory, out = tracker.step(memory, HERE, WAY if k == 0 else None, 0.01)
        r, heading = along(way, np.array((0.01 * k,)))
        if k > 200:  # it had to start first
            worst = max(worst, float(np.linalg.norm(out.r - r[0])))
    assert worst < lag
    assert out.r == pytest.approx(r[0], abs=0.1)
    assert np.cos(out.heading - heading[0]) > 0.999


def test_an_aircraft_flies_along_a_trajectory():
    scenario = Scenario(
        "way", "", "T650", Fly(WAY, at=0.5), standing((0, 0, 2)), 6.0, load("hover").sensors
    )
    base = uavlab.stack("T650", HeadingController)
    log = uavlab.fly(scenario, Stack(base.estimator, MpcTracker(MEDIUM), base.controller))
    r, _ = along(WAY, log.t - 0.5)
    assert log.exit.name == "DONE", log.reason
    assert np.linalg.norm(log.r_d - r, axis=1).max() < 0.9  # it starts at 1.4 m/s at once
    assert np.linalg.norm(log.r - log.r_d, axis=1)[200:].max() < 0.3
