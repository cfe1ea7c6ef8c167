"""Errands: steps that follow one another when they are done, not when their time has come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite, sqrt
from typing import Any, ClassVar, NamedTuple, TypeAlias

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import NO_SHIFT, Shift, compose, heading, moved, wrap
from uavlab.interfaces import Goal
from uavlab.orders import (
    ORDERS,
    EmergencyLand,
    Fall,
    In,
    Land,
    LandHome,
    LandThere,
    Order,
    TakeOff,
    Unheard,
    Velocity,
)
from uavlab.parts.trackers import why_not
from uavlab.so3 import about_z
from uavlab.types import Estimate, Reference, Trajectory, Vec3

AGAIN = 1.0  # [s] after which an order that is not done is told again: it may not have been heard
LAST = (Land, LandHome, LandThere, EmergencyLand, Fall)  # orders after which nothing comes


class Wait(NamedTuple):
    """Do nothing new for a while; a velocity before it is flown on."""

    seconds: float


Step: TypeAlias = Goal | Order | Wait


class Doing(NamedTuple):
    """What an errand remembers."""

    k: int  # the step that is done now
    t: float  # [s] since it began
    told: float  # [s] since it was told; inf: not yet
    z: float  # [m] height at which it began
    shift: Shift  # the errand's world → the estimator's world


@dataclass(frozen=True)
class Errand:
    """Steps, each of which begins when the one before is done, as the estimate has it.

    Done is a take-off near its height; a place when the aircraft is ``near`` and ``slow``; a trajectory at its end;
    `Wait` when its time is over; any other order at once. What lands is the last step. A goal is told at every tick,
    and a take-off or a landing every second, for the link may have been down; a trajectory and another part once. Who
    refuses a goal is asked for it all the same, until ``patience`` is over.

    Parameters
    ----------
    steps : sequence of goal, order or Wait
        Told in the world in which the errand begins; of `In` in the one that it names.
    near : float
        [m] from a place, and from the height of a take-off.
    slow : float
        [m/s].
    turned : float
        [rad] from the heading of a place.
    patience : float
        [s] that a step may take; then the next one begins.

    Raises
    ------
    BadInput
        No steps, a step that nobody can do, or one behind a landing.
    """

    slot: ClassVar[str] = "mission"
    steps: Sequence[Step]
    near: float = 0.3
    slow: float = 0.3
    turned: float = 0.2
    patience: float = inf

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", tuple(self.steps))
        if not self.steps:
            raise BadInput("an Errand has no steps; give it goals, orders and Wait(seconds).")
        for k, step in enumerate(self.steps):
            if why := _why_no_step(step):
                raise BadInput(f"steps[{k}]: {why}")
            if isinstance(step, LAST) and k + 1 < len(self.steps):
                said = f"{type(step).__name__} ends an errand; take out what follows it."
                raise BadInput(f"steps[{k}]: {said}")
        for name in ("near", "slow", "turned", "patience"):
            if not getattr(self, name) > 0.0:
                raise BadInput(f"{name} is {getattr(self, name)}; it must be above 0.")

    def init(self, estimate: Estimate) -> Doing:
        """The first step has not been told yet."""
        return Doing(0, 0.0, inf, float(estimate.r[2]), NO_SHIFT)

    def step(
        self, memory: Doing, estimate: Estimate, dt: float
    ) -> tuple[Doing, Goal | Order | None]:
        """What is to be told now; then `dt` [s] pass."""
        m = memory
        while m.k < len(self.steps) and self._done(m, estimate):
            m = Doing(m.k + 1, 0.0, inf, float(estimate.r[2]), m.shift)
        if m.k == len(self.steps):
            return m, None
        said = self._told(m, estimate)
        told = m.told if said is None or isinstance(self.steps[m.k], Wait) else 0.0
        return m._replace(t=m.t + dt, told=told + dt), said

    def _told(self, m: Doing, estimate: Estimate) -> Goal | Order | None:
        """The step of now, if it is to be told in this tick."""
        step = self.steps[m.k]
        if isinstance(step, Wait):
            before = self.steps[m.k - 1] if m.k else None
            return there(before, m.shift) if isinstance(before, Velocity) else None
        again = isinstance(step, Reference | In)
        if isinstance(step, In) and isinstance(step.goal, Trajectory):
            again = m.told == inf and step.world in {estimate.world, *estimate.worlds}
            return step if again else None
        if isinstance(step, TakeOff):
            again = m.told > AGAIN - 1e-9 and float(estimate.r[2]) - m.z < self.near
        elif isinstance(step, LAST):
            again = m.told > AGAIN - 1e-9
        return there(step, m.shift) if again or m.told == inf else None

    def _done(self, m: Doing, estimate: Estimate) -> bool:
        """Whether the step of now is done."""
        step = self.steps[m.k]
        if isinstance(step, Wait):
            return m.t > step.seconds - 1e-9
        if isinstance(step, LAST) or m.told == inf:  # never, or nobody knows of it yet
            return False
        return m.t > self.patience or self._reached(step, m, estimate)

    def _reached(self, step: Goal | Order, m: Doing, x: Estimate) -> bool:
        """Whether a step that was told has come to its end."""
        if isinstance(step, TakeOff):
            low = abs(float(x.r[2]) - m.z - step.height) > self.near
            return not low and abs(float(x.v[2])) < self.slow
        goal, way = step, m.shift
        if isinstance(step, In):
            goal, way = step.goal, x.worlds.get(step.world, NO_SHIFT)
        if isinstance(goal, Trajectory):
            return m.told > float(goal.t[-1]) - 1e-9
        return not isinstance(goal, Reference) or self._there(moved(goal, way), x)

    def _there(self, goal: Reference, x: Estimate) -> bool:
        """Whether it is at a place, and slow."""
        turned = abs(wrap(goal.heading - heading(x.R))) < self.turned
        return _size(goal.r - x.r) < self.near and _size(x.v - goal.v) < self.slow and turned

    def reframe(self, memory: Doing, shift: Shift) -> Doing:
        """What is told from now on is told in the new world."""
        return memory._replace(z=memory.z + float(shift.r[2]), shift=compose(shift, memory.shift))


def there(step: Any, shift: Shift) -> Any:
    """A step, told in another world; what names its own world, or no place, stays."""
    if shift is NO_SHIFT:
        return step
    if isinstance(step, Reference | Trajectory):
        return moved(step, shift)
    if isinstance(step, LandThere):
        r = about_z(shift.heading) @ step.r + shift.r
        return LandThere(r, wrap(step.heading + shift.heading))
    if isinstance(step, Velocity):
        z = None if step.z is None else step.z + float(shift.r[2])
        nose = None if step.heading is None else wrap(step.heading + shift.heading)
        return Velocity(about_z(shift.heading) @ step.v, z, nose, step.heading_rate)
    return step


def _size(x: Vec3) -> float:
    return sqrt(x @ x)


def _why_no_step(step: Any) -> str:
    """Why this is no step; empty if it is one."""
    if isinstance(step, Wait):
        good = isfinite(step.seconds) and step.seconds >= 0.0
        return "" if good else f"it waits for {step.seconds} s; take a finite time of 0 or more."
    if isinstance(step, Reference | Trajectory):
        return why_not(step)
    if isinstance(step, Unheard) or not isinstance(step, ORDERS):
        return f"{step!r} is no goal, no order and no Wait."
    if isinstance(step, In):
        good = isinstance(step.goal, Reference | Trajectory)
        return why_not(step.goal) if good else f"{step.goal!r}, in {step.world!r}, is no goal."
    vectors = {LandThere: "r", Velocity: "v"}
    name = vectors.get(type(step), "")
    if name and not (
        np.shape(getattr(step, name)) == (3,) and np.isfinite(getattr(step, name)).all()
    ):
        return f"{name} is {getattr(step, name)}; it must be three finite numbers."
    return ""
