"""Speed: a reference that follows a velocity and lets the place be what it is (MRS Sec. 4.3)."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, isfinite, sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import Shift, moved, wrap
from uavlab.interfaces import Goal
from uavlab.limits import Limits, checked
from uavlab.parts.pace import beginning, closing, towards
from uavlab.parts.trackers import carried
from uavlab.types import Array, Estimate, Reference, Trajectory, Vec3

SLOPE = 8.0  # [1/s], how the last of a difference of velocities fades
TURN = 2.0  # [1/s], heading rate for an error of the heading
STILL = np.zeros(3)
STILL.setflags(write=False)


class Wish(NamedTuple):
    """What the tracker remembers."""

    now: Reference  # of this tick
    goal: Reference | None  # None: nobody has asked for anything yet
    age: float  # [s] since the goal was given


@dataclass(frozen=True)
class SpeedTracker:
    """Follow the velocity of the goal: within the limits of speed, acceleration and jerk, the place left free.

    Of a goal, ``v`` counts; ``r[2]`` in place of ``v[2]`` if the height is to be kept; ``heading`` with
    ``heading_rate``, or the rate alone. Everything else of it is not looked at. Horizontal limits hold for the length
    of the vector, so it turns with the world; the vertical ones may differ up and down.

    A reference without a place would need controllers that can do without. Here its place is drawn to the estimate
    instead, with time constant ``tau``: only an error of the velocity keeps them apart, by tau times that error. A
    goal is obeyed for ``timeout``; whoever commands velocities and falls silent must not be flown on. Then the
    reference stops, and its place counts again.

    Raises `BadInput` on limits that are none, or a time that is not above 0; in flight on a trajectory.
    """

    slot: ClassVar[str] = "tracker"
    limits: Limits
    keeps_height: bool = False  # the height of the goal, not its vertical velocity
    keeps_heading: bool = True  # the heading of the goal and its rate, not its rate alone
    timeout: float = 1.0  # [s]
    tau: float = 0.3  # [s]

    def __post_init__(self) -> None:
        checked(self.limits)
        for name in ("timeout", "tau"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise BadInput(f"{name} is {value} s; it must be a finite number above 0.")

    def init(self, estimate: Estimate, last: Reference | None) -> Wish:
        """Continue from the last reference, else from the estimate and its velocity; stop until told otherwise."""
        return Wish(beginning(estimate, last), None, 0.0)

    def step(
        self, memory: Wish, estimate: Estimate, goal: Goal | None, dt: float
    ) -> tuple[Wish, Reference]:
        """The reference of now; then it moves on by `dt` [s]."""
        if isinstance(goal, Trajectory):
            raise BadInput(
                "SpeedTracker follows velocities; give it a Reference, not a Trajectory."
            )
        now, age = memory.now, 0.0 if goal is not None else memory.age
        goal = goal if goal is not None else memory.goal
        told = None if age > self.timeout + 1e-9 else goal
        j = self._jerk(now, told, dt)
        out = now._replace(j=j, heading_rate=self._turn(now, told, dt))
        later = carried(out, dt)
        if told is not None:
            later = later._replace(r=self._drawn(later.r, estimate.r, dt))
        return Wish(later, goal, age + dt), out

    def _jerk(self, now: Reference, told: Reference | None, dt: float) -> Vec3:
        flat, wish = self.limits.horizontal, STILL if told is None else told.v
        level = _shortened(wish[:2], flat.v)
        a = _wanted(level - now.v[:2], flat.a, flat.j)
        rise = self._rise(now, told)
        brisk = self.limits.up if rise > now.v[2] else self.limits.down
        a_z = _wanted(np.array((rise - now.v[2],)), brisk.a, brisk.j)
        next_a = towards(now.a[:2], a, flat.j * dt)
        next_z = towards(now.a[2:], a_z, brisk.j * dt)
        return np.append(next_a - now.a[:2], next_z - now.a[2:]) / dt

    def _rise(self, now: Reference, told: Reference | None) -> float:
        """The vertical velocity that is wanted [m/s]."""
        if told is None:
            return 0.0
        v = float(told.v[2])
        if self.keeps_height:
            e = float(told.r[2] - now.r[2])
            v = closing(abs(e), min(self.limits.up.a, self.limits.down.a) / 2.0, 1.0)
            v = v if e > 0.0 else -v
        return min(max(v, -self.limits.down.v), self.limits.up.v)

    def _turn(self, now: Reference, told: Reference | None, dt: float) -> float:
        """Heading rate of the coming tick [rad/s], within its limits of speed and acceleration."""
        most = self.limits.heading
        rate = 0.0 if told is None else told.heading_rate
        if told is not None and self.keeps_heading:
            rate += TURN * wrap(told.heading - now.heading)
        rate = min(max(rate, -most.v), most.v)
        step = most.a * dt
        return min(max(rate, now.heading_rate - step), now.heading_rate + step)

    def _drawn(self, r: Vec3, estimate: Vec3, dt: float) -> Vec3:
        """The place `r` (3,) [m], world, nearer to the estimate; its height stays where a height is kept."""
        share = np.full(3, 1.0 - exp(-dt / self.tau))
        if self.keeps_height:
            share[2] = 0.0
        return r + share * (estimate - r)

    def reframe(self, memory: Wish, shift: Shift) -> Wish:
        """The same wish, told in the new world."""
        goal = memory.goal and moved(memory.goal, shift)
        return memory._replace(now=moved(memory.now, shift), goal=goal)


def _shortened(v: Array, most: float) -> Array:
    """`v` (n,), no longer than `most` [m/s]."""
    size = sqrt(v @ v)
    return v * (most / size) if size > most else v


def _wanted(e: Array, most: float, jerk: float) -> Array:
    """Acceleration (n,) [m/s²] that closes a difference of velocities `e` (n,) [m/s] and can still be taken back."""
    size = sqrt(e @ e)
    if size == 0.0:
        return np.zeros_like(e)
    return e * (min(closing(size, jerk, SLOPE), most) / size)
