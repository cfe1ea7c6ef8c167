"""A reference that follows a velocity and leaves the place free, and one that flies straight."""

import numpy as np
import pytest

from uavlab.errors import BadInput
from uavlab.experiments.control_flights import flown, law
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import wrap
from uavlab.gains import gains_for
from uavlab.limits import limit_group
from uavlab.parts.line import LineTracker
from uavlab.parts.missions import still
from uavlab.parts.pace import Pace, closing
from uavlab.parts.speed import SpeedTracker
from uavlab.plant import load_airframe
from uavlab.types import Estimate, Trajectory

DT = 0.01
MEDIUM = limit_group("medium")
WAY = Trajectory(np.zeros(1), np.zeros((1, 3)), np.zeros(1))


def at(r=(0.0, 0.0, 2.0)):
    zero = np.zeros(3)
    return Estimate(np.array(r, float), zero, zero, np.eye(3), zero)


def wish(v, heading=0.0, rate=0.0, z=0.0):
    there = still(np.array((50.0, 50.0, z)), heading)
    return there._replace(v=np.array(v, float), heading_rate=rate)


def followed(part, goals, seconds, start=None, off=(0.0, 0.0, 0.0)):
    """References while the estimate follows with a lasting offset; `goals`(t) or None, each tick."""
    memory = part.init(start or at(), None)
    seen = []
    for k in range(round(seconds / DT)):
        estimate = at(memory.now.r + np.array(off))
        memory, x = part.step(memory, estimate, goals(k * DT), DT)
        seen.append(x)
    return seen


def rows(seen, name):
    return np.array([getattr(x, name) for x in seen])


def test_the_velocity_is_reached_within_the_limits_and_kept():
    seen = followed(SpeedTracker(MEDIUM), lambda t: wish((9.0, 9.0, -9.0)), 8.0)
    v, a, j = (rows(seen, name) for name in "vaj")
    flat = [np.hypot(x[:, 0], x[:, 1]).max() for x in (v, a, j)]
    assert flat[0] == pytest.approx(MEDIUM.horizontal.v, rel=1e-3)
    assert flat[1] <= MEDIUM.horizontal.a * 1.001
    assert flat[2] <= MEDIUM.horizontal.j * 1.001
    assert v[-1] == pytest.approx((4.0 / np.sqrt(2), 4.0 / np.sqrt(2), -2.0), abs=1e-2)
    assert np.abs(a[:, 2]).max() <= MEDIUM.down.a * 1.001


def test_up_and_down_have_limits_of_their_own():
    limits = MEDIUM._replace(up=MEDIUM.up._replace(v=3.0), down=MEDIUM.down._replace(v=1.0))
    part = SpeedTracker(limits)
    assert followed(part, lambda t: wish((0, 0, 9)), 8.0)[-1].v[2] == pytest.approx(3.0, abs=0.01)
    assert followed(part, lambda t: wish((0, 0, -9)), 8.0)[-1].v[2] == pytest.approx(-1.0, abs=0.01)


def test_who_falls_silent_is_flown_for_a_second_and_then_stands():
    part = SpeedTracker(MEDIUM)
    seen = followed(part, lambda t: wish((2.0, 0.0, 0.0)) if t < 3.0 else None, 8.0)
    v, r = rows(seen, "v")[:, 0], rows(seen, "r")
    assert v[395] == pytest.approx(2.0, abs=1e-2)
    assert v[450] < 1.5
    assert abs(v[-1]) < 1e-3
    assert np.ptp(r[-100:], axis=0).max() < 1e-3


def test_nobody_is_obeyed_before_he_has_spoken():
    assert not rows(followed(SpeedTracker(MEDIUM), lambda t: None, 1.0), "v").any()


def test_the_place_goes_along_with_the_aircraft_and_counts_again_once_it_stops():
    part = SpeedTracker(MEDIUM)
    memory = part.init(at(), None)
    for _ in range(300):  # something holds the aircraft
        memory, x = part.step(memory, at(), wish((1.0, 0.0, 0.0)), DT)
    assert x.r[0] == pytest.approx(part.tau * 1.0, rel=0.05)
    for _ in range(300):  # nobody asks any more
        memory, x = part.step(memory, at(), None, DT)
    stands = x.r[0]
    for _ in range(300):  # and then it is blown away
        memory, x = part.step(memory, at((5.0, 0.0, 2.0)), None, DT)
    assert x.r[0] == pytest.approx(stands, abs=1e-3)


def test_a_height_is_kept_where_it_is_asked_for():
    part = SpeedTracker(MEDIUM, keeps_height=True)
    seen = followed(part, lambda t: wish((1.0, 0.0, 7.0), z=4.0), 12.0, off=(0, 0, -0.5))
    assert seen[-1].r[2] == pytest.approx(4.0, abs=0.01)
    assert rows(seen, "r")[:, 2].max() < 4.05


def test_the_nose_goes_to_a_heading_the_short_way_or_turns_at_a_rate():
    nose = followed(SpeedTracker(MEDIUM), lambda t: wish((0, 0, 0), heading=-3.0), 8.0)
    assert wrap(nose[-1].heading + 3.0) == pytest.approx(0.0, abs=0.02)
    assert np.abs(rows(nose, "heading_rate")).max() <= MEDIUM.heading.v + 1e-9
    assert np.abs(np.diff(rows(nose, "heading_rate"))).max() <= MEDIUM.heading.a * DT + 1e-9
    turns = SpeedTracker(MEDIUM, keeps_heading=False)
    spun = followed(turns, lambda t: wish((0, 0, 0), heading=1.0, rate=0.5), 4.0)
    assert spun[-1].heading_rate == pytest.approx(0.5)


def test_trackers_of_speeds_and_of_lines_refuse_a_trajectory():
    for part in (SpeedTracker(MEDIUM), LineTracker()):
        with pytest.raises(BadInput, match="not a Trajectory"):
            part.step(part.init(at(), None), at(), WAY, DT)
    with pytest.raises(BadInput, match="timeout is 0"):
        SpeedTracker(MEDIUM, timeout=0.0)


class Ask:
    """A mission that asks for a velocity for a while, then for nothing."""

    slot = "mission"

    def init(self, estimate):
        return 0.0

    def step(self, memory, estimate, dt):
        return memory + dt, wish((2.0, 0.0, 0.0)) if memory < 4.0 else None

    def reframe(self, memory, shift):
        return memory


@pytest.mark.flight
def test_an_aircraft_flies_the_velocity_and_then_stands():
    scenario = Scenario("", "", "T650", Ask(), standing((0.0, 0.0, 3.0)), 9.0, {})
    part = SpeedTracker(MEDIUM)
    controller = law(load_airframe("T650").m, gains_for("T650", "soft"))
    log = flown(scenario, controller, tracker=part)
    assert 1.8 < log.v[400, 0] < 2.0  # no place pulls against the drag
    assert np.linalg.norm(log.v[-1]) < 0.05
    assert np.abs(log.r[:, 2] - 3.0).max() < 0.1


# The line ---------------------------------------------------------------------------------------------


def test_from_rest_the_way_is_a_line_and_its_speed_a_trapezoid():
    part, goal = LineTracker(), still(np.array((12.0, -6.0, 5.0)), 1.0)
    seen = followed(part, lambda t: goal if t == 0.0 else None, 14.0)
    way, r, v = goal.r - at().r, rows(seen, "r") - at().r, rows(seen, "v")
    along = way / np.linalg.norm(way)
    assert np.linalg.norm(np.cross(r, along), axis=1).max() < 1e-9
    assert (r @ along).max() < np.linalg.norm(way) + 1e-3
    assert np.hypot(v[:, 0], v[:, 1]).max() == pytest.approx(3.0, rel=1e-6)
    assert np.linalg.norm(np.diff(v, axis=0), axis=1).max() <= 1.05 * DT
    assert np.linalg.norm(seen[-1].r - goal.r) < 0.1
    assert seen[-1].heading == pytest.approx(1.0, abs=0.02)


def test_the_slower_axis_sets_the_pace():
    up = followed(LineTracker(), lambda t: still(np.array((1.0, 0.0, 12.0))), 6.0)
    assert rows(up, "v")[:, 2].max() == pytest.approx(1.0, rel=1e-6)


def test_it_has_arrived_within_a_tenth_of_a_metre():
    part = LineTracker()
    memory = part.init(at(), None)
    assert not part.arrived(memory)
    goal = still(np.array((1.0, 0.0, 2.0)))
    for _ in range(400):
        memory, _ = part.step(memory, at(), goal, DT)
        assert part.arrived(memory) == (np.linalg.norm(memory.now.r - goal.r) < 0.1)
    assert part.arrived(memory)


def test_a_motion_that_goes_elsewhere_is_turned_into_the_line_with_the_same_acceleration():
    part = LineTracker()
    last = still(np.array((0.0, 0.0, 2.0)))._replace(v=np.array((0.0, 2.0, 0.0)))
    memory, seen = part.init(at(), last), []
    for _ in range(1500):
        memory, x = part.step(memory, at(), still(np.array((8.0, 0.0, 2.0))), DT)
        seen.append(x)
    assert np.linalg.norm(rows(seen, "a"), axis=1).max() < 1.0 + 1e-6
    assert np.linalg.norm(seen[-1].r - (8.0, 0.0, 2.0)) < 0.1


def test_what_is_left_is_closed_at_the_deceleration_and_never_faster():
    e = np.linspace(0.0, 2.0, 2001)
    v = np.array([closing(x, 0.5, 4.0) for x in e])
    assert (v * np.gradient(v, e) <= 0.5 * 1.01).all()
    assert np.abs(np.diff(v)).max() < 4.0 * 1e-3 + 1e-9


@pytest.mark.parametrize("wrong", [Pace(np.inf, 1.0), Pace(1.0, -1.0), 3.0])
def test_a_pace_is_two_numbers_above_zero(wrong):
    with pytest.raises(BadInput, match="horizontal"):
        LineTracker(horizontal=wrong)
