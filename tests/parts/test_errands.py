"""Errands: a step begins when the one before is done, as the estimate has it."""

import numpy as np
import pytest

from uavlab.errors import BadInput
from uavlab.frames import Shift, moved
from uavlab.orders import In, Land, LandThere, TakeOff, Unheard, Use, Velocity
from uavlab.parts.errands import Errand, Wait
from uavlab.parts.missions import still
from uavlab.so3 import about_z
from uavlab.types import Estimate, Trajectory

DT, ZERO = 0.1, np.zeros(3)
A, B = still(np.array((1.0, 0.0, 2.0))), still(np.array((1.0, 2.0, 2.0)), 1.0)
SHIFT = Shift(np.array((3.0, -2.0, 0.5)), 0.4)
WAY = Trajectory(np.array((0.0, 2.0)), np.zeros((2, 3)), np.zeros(2))


def at(r=(0.0, 0.0, 0.0), v=(0.0, 0.0, 0.0), heading=0.0, **more):
    return Estimate(np.array(r, float), np.array(v, float), ZERO, about_z(heading), ZERO, **more)


class Runs:
    """An errand, stepped where an aircraft is."""

    def __init__(self, *steps, start=None, **more):
        self.part = Errand(steps, **more)
        self.memory = self.part.init(start or at())

    def at(self, x, ticks=1):
        told = []
        for _ in range(ticks):
            self.memory, out = self.part.step(self.memory, x, DT)
            told.append(out)
        return told[0] if ticks == 1 else told


def test_a_place_is_told_until_the_aircraft_is_there_and_slow_and_turned():
    runs = Runs(A, B)
    assert runs.at(at()) is A
    assert runs.at(at(A.r - 0.4)) is A
    assert runs.at(at(A.r, (1.0, 0.0, 0.0))) is A
    assert runs.at(at(A.r, heading=0.5)) is A
    assert runs.at(at(A.r + 0.1)) is B
    assert runs.at(at(B.r, heading=1.0), 3) == [None] * 3


def test_a_take_off_is_told_again_each_second_until_the_aircraft_leaves_the_ground():
    runs = Runs(TakeOff(2.0), A)
    told = runs.at(at(), 21)
    assert [k for k, x in enumerate(told) if x == TakeOff(2.0)] == [0, 10, 20]
    assert runs.at(at((0.0, 0.0, 1.0)), 20) == [None] * 20
    assert runs.at(at((0.0, 0.0, 1.9), (0.0, 0.0, 1.0))) is None
    assert runs.at(at((0.0, 0.0, 1.9))) is A


def test_a_height_counts_from_where_the_take_off_began():
    runs = Runs(TakeOff(2.0), A, start=at((0.0, 0.0, 5.0)))
    runs.at(at((0.0, 0.0, 5.0)))
    assert runs.at(at((0.0, 0.0, 2.0))) is None
    assert runs.at(at((0.0, 0.0, 7.0))) is A


def test_a_trajectory_is_told_once_and_done_when_its_time_is_over():
    runs = Runs(WAY, A)
    assert runs.at(at()) is WAY
    assert runs.at(at(), 19) == [None] * 19
    assert runs.at(at()) is A


def test_another_part_is_asked_for_once_and_waiting_takes_its_time():
    runs = Runs(Use("limits", "slow"), Wait(0.5), A)
    assert runs.at(at()) == Use("limits", "slow")
    assert runs.at(at(), 5) == [None] * 5
    assert runs.at(at()) is A


def test_a_velocity_is_told_again_and_again_while_the_errand_waits_behind_it():
    go = Velocity(np.array((1.0, 0.0, 0.0)))
    told = Runs(go, Wait(0.5), A).at(at(), 8)
    assert all(isinstance(x, Velocity) for x in told[:6])
    assert told[-1] is A


def test_a_landing_is_the_end_and_told_again_each_second():
    told = Runs(Land()).at(at(), 25)
    assert [k for k, x in enumerate(told) if x is not None] == [0, 10, 20]


def test_what_takes_longer_than_the_patience_is_left_undone():
    runs = Runs(A, B, patience=1.0)
    assert runs.at(at(), 11)[-1] is A
    assert runs.at(at(), 2)[-1] is B


def test_a_goal_of_another_world_is_done_there():
    goal, world = In("map", A), {"map": SHIFT}
    runs = Runs(goal, B)
    assert runs.at(at(A.r, worlds=world)) is goal
    there = moved(A, SHIFT)
    assert runs.at(at(there.r, heading=SHIFT.heading, worlds=world)) is B


def test_a_trajectory_of_another_world_waits_until_that_is_known():
    runs = Runs(In("map", WAY), B)
    assert runs.at(at(), 3) == [None] * 3
    assert runs.memory.k == 0
    assert runs.at(at(worlds={"map": SHIFT})) == In("map", WAY)


@pytest.mark.parametrize(
    "step", [A, WAY, LandThere(np.array((1.0, 2.0, 0.0)), 0.5), TakeOff(1.0), Land(),
             Velocity(np.array((1.0, 0.5, 0.0)), 2.0, 0.3), Use("gains", "soft"), In("map", A)],
)  # fmt: skip
def test_a_world_that_changes_moves_what_is_told_and_nothing_else(step):
    part = Errand((step,))
    x = at((4.0, 1.0, 1.0), heading=0.2, worlds={"map": Shift(ZERO, 0.0)})
    memory, told = part.step(part.init(at()), x, DT)
    other, told_there = part.step(part.reframe(part.init(at()), SHIFT), moved(x, SHIFT), DT)
    assert part.reframe(memory, SHIFT)[:3] == other[:3]
    if isinstance(step, type(A) | Trajectory):
        expected = moved(told, SHIFT)
    elif isinstance(step, LandThere):
        expected = LandThere(moved(still(step.r), SHIFT).r, step.heading + SHIFT.heading)
    elif isinstance(step, Velocity):
        v = about_z(SHIFT.heading) @ step.v
        expected = Velocity(v, 2.5, 0.3 + SHIFT.heading, 0.0)
    else:
        expected = told
    for a, b in zip(told_there, expected, strict=True):
        assert a == b if isinstance(a, str | tuple) else np.allclose(a, b, atol=1e-12)


@pytest.mark.parametrize(
    ("steps", "said"),
    [
        ((), "no steps"),
        ((Land(), A), r"steps\[0\]: Land ends an errand"),
        ((A, "up"), r"steps\[1\]: 'up' is no goal"),
        ((Unheard(),), "no goal, no order"),
        ((Wait(-1.0),), "waits for -1.0 s"),
        ((still(ZERO * np.nan),), r"r\[0\] of the reference is nan"),
        ((In("map", "up"),), "is no goal"),
        ((LandThere((0.0, np.nan, 0.0), 0.0),), "three finite numbers"),
        ((Velocity(np.zeros(2)),), "three finite numbers"),
    ],
)
def test_steps_that_nobody_can_do_are_refused_by_their_place(steps, said):
    with pytest.raises(BadInput, match=said):
        Errand(steps)


def test_figures_that_are_none_are_refused():
    with pytest.raises(BadInput, match="near is 0"):
        Errand((A,), near=0.0)
