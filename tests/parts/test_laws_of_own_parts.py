"""`broken_laws` says what is wrong with a part, and nothing of one that is right."""

import re
from typing import ClassVar

import numpy as np
import pytest
from test_laws import CONTROLLERS, ESTIMATORS, MISSIONS, TRACKERS

from uavlab.parts.controllers import TiltAxis
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.laws import broken_laws
from uavlab.parts.missions import Waypoints
from uavlab.parts.trackers import CommandFilter

EVERY = [*ESTIMATORS, *TRACKERS, *CONTROLLERS, *MISSIONS]
STOPS = ((0.0, (0.0, 0.0, 2.0), 0.3),)


@pytest.mark.parametrize("part", EVERY, ids=lambda p: type(p).__name__)
def test_no_part_that_comes_with_uavlab_breaks_a_law(part):
    assert broken_laws(part) == []


class Wild:
    """A controller without a memory of its own."""

    slot: ClassVar[str] = "controller"

    def __init__(self, mass=2.0):
        self.law = TiltAxis(mass)

    def init(self, estimate, last):
        return self.law.init(estimate, last)

    def step(self, memory, estimate, reference, dt):
        return self.law.step(memory, estimate, reference, dt)

    def reframe(self, memory, shift):
        return self.law.reframe(memory, shift)


class Counting(Wild):
    calls = 0

    def step(self, memory, estimate, reference, dt):
        self.calls += 1
        memory, command = super().step(memory, estimate, reference, dt)
        return memory, command._replace(f_d=command.f_d + 1e-3 * self.calls)


class Writing(Wild):
    def step(self, memory, estimate, reference, dt):
        estimate.r[2] += 1.0
        return super().step(memory, estimate, reference, dt)


class Northward(Wild):
    def step(self, memory, estimate, reference, dt):
        memory, command = super().step(memory, estimate, reference, dt)
        return memory, command._replace(a_d=command.a_d + np.array((1.0, 0.0, 0.0)))


class Unmoved(Wild):
    def reframe(self, memory, shift):
        return memory


class Abrupt(Wild):
    def init(self, estimate, last):
        return self.law.init(estimate, None)


class Dividing(Wild):
    def step(self, memory, estimate, reference, dt):
        memory, command = super().step(memory, estimate, reference, dt)
        far = np.linalg.norm(reference.r - estimate.r) > 2.0
        return memory, command._replace(f_d=float("inf") if far else command.f_d)


class Hurried(Wild):
    """Its hand-over takes the same number of steps at any rate."""

    def step(self, memory, estimate, reference, dt):
        return super().step(memory, estimate, reference, 0.002)


class Mute(Wild):
    def step(self, memory, estimate, reference, dt):
        return memory, None


class Lonely(Wild):
    def step(self, memory, estimate, reference, dt):
        return super().step(memory, estimate, reference, dt)[1]


class Failing(Wild):
    def step(self, memory, estimate, reference, dt):
        raise RuntimeError("no idea")


class Stepping(CommandFilter):
    """It moves by a tenth of the way in each step, however long that is."""

    def step(self, memory, estimate, goal, dt):
        memory, out = super().step(memory, estimate, goal, dt)
        goal = memory.goal
        new = memory.now._replace(r=memory.now.r + (0.05 * (goal.r - memory.now.r) if goal else 0))
        return memory._replace(now=new), out


class Jumping(AlphaBetaGamma):
    def step(self, memory, readings, command, dt):
        memory, out = super().step(memory, readings, command, dt)
        return memory, out._replace(v=out.v + 0.1)


class Homesick(Waypoints):
    def step(self, memory, estimate, dt):
        memory, goal = super().step(memory, estimate, dt)
        return memory, goal._replace(r=np.zeros(3))


@pytest.mark.parametrize(
    ("part", "law", "said"),
    [
        (Counting(), "1", "the same inputs gives something else"),
        (Writing(), "1", "changes what it was told"),
        (Northward(), "2", "its a_d is not the same thing told there"),
        (Unmoved(), "2", "is not the same thing|another memory"),
        (Abrupt(), "3", "the last command had"),
        (Dividing(), "4", "its f_d is inf"),
        (Mute(), "0", "gave NoneType and not .*Command.*, as a controller must"),
        (Lonely(), "0", "step must give two things"),
        (Failing(), "0", "it raised RuntimeError: no idea"),
        (Stepping(), "5", "within a second, steps of 0.01 s and of 0.005 s differ by"),
        (Jumping(), "3", "the first step after init gives v = .*the last estimate had"),
        (Homesick(STOPS), "2", "its r is not the same thing told there"),
    ],
    ids=lambda x: type(x).__name__ if not isinstance(x, str) else "",
)
def test_a_broken_law_is_named_with_what_was_seen(part, law, said):
    broken = [x for x in broken_laws(part) if x.startswith(f"law {law} ")]
    assert len(broken) == 1
    assert re.search(said, broken[0]), broken


def test_a_part_that_is_none_is_told_what_it_lacks():
    assert "slot None; a part says in its class" in broken_laws(object())[0]
    assert broken_laws(TiltAxis) == ["TiltAxis is a class; make a part of it: TiltAxis(…)."]

    class Half:
        slot = "estimator"

        def init(self, estimate):
            return estimate

    assert broken_laws(Half())[0].startswith("it has no step and no reframe and no hypotheses;")


def test_what_moves_with_the_world_is_no_offence():
    class Honest(Wild):
        def step(self, memory, estimate, reference, dt):
            memory, command = super().step(memory, estimate, reference, dt)
            return memory, command._replace(a_d=command.a_d + estimate.R[:, 0])

    assert [x for x in broken_laws(Honest()) if x.startswith("law 2")] == []
