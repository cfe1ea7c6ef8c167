"""The reference tracker of lab 06: it keeps every limit, arrives, follows, and flies on when a plan is missing."""

import numpy as np
import pytest

from uavlab.frames import Shift, inverse, moved
from uavlab.limits import AxisLimits, limit_group
from uavlab.parts.missions import still
from uavlab.parts.paths import along, circle
from uavlab.qp import LATE
from uavlab.solutions import mpc_tracker
from uavlab.solutions.mpc import MpcTracker
from uavlab.solutions.mpc_chain import boxes, chain, machine
from uavlab.types import Estimate, Reference, Trajectory

ZERO, DT = np.zeros(3), 0.01
HERE = Estimate(ZERO, ZERO, ZERO, np.eye(3), ZERO)
MEDIUM = limit_group("medium")
PRINTED = AxisLimits(9.0, 12.0, 50.0, 50.0)  # MRS Sec. 8.1
STEEP = MEDIUM._replace(horizontal=PRINTED, up=PRINTED, down=AxisLimits(3.0, 2.0, 20.0, 30.0))


def followed(tracker, goal, seconds, last=None):
    """Derivatives (n, 5, 4) of the reference, position to snap; its headings; and the memory at the end."""
    memory, rows, headings = tracker.init(HERE, last), [], []
    for k in range(round(seconds / DT)):
        x = memory.x
        memory, out = tracker.step(memory, HERE, goal(k), DT)
        rows.append(np.vstack((x, (memory.x[3] - x[3]) / DT)))
        headings.append(out.heading)
    return np.array(rows), np.array(headings), memory


def once(goal):
    return lambda k: goal if k == 0 else None


def worst(x, limits):
    """Largest share of each limit that was used: speed, acceleration, jerk, snap."""
    box = boxes(limits).transpose(1, 2, 0)
    return np.maximum(x[:, 1:] / box[0], -x[:, 1:] / box[1]).max(axis=(0, 2))


@pytest.mark.parametrize("limits", [MEDIUM, STEEP, limit_group("fast-2020")])
def test_no_limit_is_exceeded_on_any_axis_whenever_another_goal_comes(limits):
    rng = np.random.default_rng(1)

    def goal(k):
        return still(rng.normal(size=3) * 15, rng.uniform(-3, 3)) if k % 130 == 0 else None

    x, _, memory = followed(MpcTracker(limits), goal, 6.5)
    assert worst(x, limits).max() < 1.01
    assert MpcTracker(limits).failures(memory) == 0


def test_a_far_goal_is_reached_fast_straight_and_without_going_beyond():
    place = np.array((30.0, -12.0, 5.0))
    x, headings, _ = followed(MpcTracker(STEEP), once(still(place, 3.0)), 7.0)
    r = x[:, 0, :3]
    assert np.linalg.norm((r[550:] - place)[:, :2], axis=1).max() < 0.05
    assert np.linalg.norm(r[-1] - place) < 0.06  # upwards it brakes with no more than 2 m/s²
    assert ((r - place) * np.sign(place)).max() < 0.05
    assert np.abs(r[:, 0] * place[1] - r[:, 1] * place[0]).max() / 32.3 < 1e-3
    assert worst(x, STEEP)[0] > 0.98  # it does use its speed
    assert headings[-1] == pytest.approx(3.0, abs=1e-3)
    assert np.ptp(headings) < 3.1  # the short way round would be another


def test_up_and_down_have_their_own_limits():
    up, _, _ = followed(MpcTracker(STEEP), once(still(np.array((0.0, 0.0, 30.0)))), 4.0)
    down, _, _ = followed(MpcTracker(STEEP), once(still(np.array((0.0, 0.0, -30.0)))), 4.0)
    assert up[:, 1, 2].max() > 8.0
    assert -3.03 < down[:, 1, 2].min() < -2.9


def test_the_heading_goes_the_short_way_and_is_told_within_half_a_turn():
    last = still(ZERO, 3.0)
    _, headings, memory = followed(MpcTracker(MEDIUM), once(still(ZERO, -3.0)), 4.0, last)
    assert np.abs(headings).max() <= np.pi
    assert memory.x[0, 3] == pytest.approx(2 * np.pi - 3.0, abs=1e-3)


def test_a_circle_is_followed_with_little_lag_also_by_few_goals():
    path = circle(ZERO, 5.0)

    def goal(k):
        return Reference(*along(path, k * DT, 0.5, 3.0), 0.1 * k * DT, 0.1) if k % 10 == 0 else None

    x, _, _ = followed(MpcTracker(MEDIUM), goal, 8.0, still(along(path, 0.0, 0.5, 3.0)[0]))
    there = np.array([along(path, k * DT, 0.5, 3.0)[0] for k in range(800)])
    assert np.linalg.norm(x[:, 0, :3] - there, axis=1).max() < 0.1


def test_a_goal_that_was_given_once_with_a_speed_is_caught_up_with():
    goal = still(np.array((3.0, 0.0, 0.0)))._replace(v=np.array((1.0, 0.5, 0.0)))
    x, _, _ = followed(MpcTracker(MEDIUM), once(goal), 8.0)
    assert x[-1, 0, :3] == pytest.approx(goal.r + 7.99 * goal.v, abs=0.02)
    assert x[-1, 1, :3] == pytest.approx(goal.v, abs=0.02)


def test_a_trajectory_is_followed_and_its_end_is_held():
    t = np.arange(0.0, 5.1, 0.2)
    way = Trajectory(t, np.column_stack((t, np.sin(t), 0.1 * t)), 0.2 * t)
    x, _, _ = followed(MpcTracker(MEDIUM), once(way), 8.0)
    there = np.array([np.interp(np.arange(800) * DT, t, way.r[:, i]) for i in range(3)]).T
    e = np.linalg.norm(x[:, 0, :3] - there, axis=1)
    assert e[250:].max() < 0.25
    assert e[-1] < 0.01


def test_the_model_is_integrated_exactly():
    A, b = chain(0.3)
    t, s, x = 0.3, 7.0, np.array((1.0, -2.0, 3.0, 4.0))
    p = x[0] + x[1] * t + x[2] * t**2 / 2 + x[3] * t**3 / 6 + s * t**4 / 24
    a = x[2] + x[3] * t + s * t**2 / 2
    assert (A @ x + b * s)[[0, 2]] == pytest.approx([p, a])
    half, push = chain(0.15)
    assert half @ (half @ x + push * s) + push * s == pytest.approx(A @ x + b * s)


def test_a_state_far_beyond_its_limits_comes_back():
    last = still(ZERO)._replace(v=np.array((6.0, 0, 0)), a=np.array((3.0, 0, 0)))
    x, _, memory = followed(MpcTracker(MEDIUM), once(None), 6.0, last)
    assert memory.failed == 0
    assert (np.abs(x[200:, 1, 0]) < 4.04).all()
    assert x[300:, 1, 0].min() > -1.0  # it stops rather than comes back


def test_without_a_plan_the_last_one_flies_on_and_is_counted(monkeypatch):
    tracker, goal = MpcTracker(MEDIUM), still(np.array((4.0, 1.0, 0.0)))
    whole, _, _ = followed(tracker, once(goal), 3.0)
    real = mpc_tracker.solved

    def lost(m, x, wanted, box):
        plan = real(m, x, wanted, box)
        return plan._replace(z=np.full_like(plan.z, np.nan), status=LATE)

    memory = tracker.init(HERE, None)
    for k in range(300):
        monkeypatch.setattr(mpc_tracker, "solved", lost if 100 <= k < 150 else real)
        memory, out = tracker.step(memory, HERE, goal if k == 0 else None, DT)
    assert tracker.failures(memory) == 50
    assert out.r == pytest.approx(whole[-1, 0, :3], abs=0.1)


def test_a_goal_that_is_not_finite_is_passed_over_and_counted():
    tracker, good = MpcTracker(MEDIUM), still(np.ones(3))
    memory, _ = tracker.step(tracker.init(HERE, None), HERE, good, DT)
    same, _ = tracker.step(memory, HERE, None, DT)
    for bad in (good._replace(heading=np.nan), good._replace(r=np.array((0.0, np.inf, 0.0)))):
        after, out = tracker.step(memory, HERE, bad, DT)
        assert tracker.failures(after) == 1
        assert after.x == pytest.approx(same.x)
        assert np.isfinite(out.r).all()


def test_a_change_of_world_is_not_felt():
    tracker, goal = MpcTracker(MEDIUM), still(np.array((4.0, 1.0, 2.0)), 2.0)
    shift = Shift(np.array((10.0, -3.0, 1.0)), 2.0)
    plain, _, _ = followed(tracker, once(goal), 1.0)
    memory = tracker.reframe(tracker.init(HERE, None), shift)
    for k in range(100):
        memory, out = tracker.step(memory, HERE, moved(goal, shift) if k == 0 else None, DT)
    assert moved(out, inverse(shift)).r == pytest.approx(plain[-1, 0, :3], abs=1e-12)


def test_a_programme_is_factored_once_for_all_axes_and_ticks():
    assert machine(40, 0.2, DT, 0.5) is machine(40, 0.2, DT, 0.5)
