"""Trackers: a third-order command filter, the stand-in for the MPC tracker of a later lab."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.frames import Shift, moved, wrap
from uavlab.types import Estimate, Reference, Vec3


class Filter(NamedTuple):
    """A tracker's memory: the reference of now, and the goal that it is drawn to."""

    now: Reference
    goal: Reference | None


@dataclass(frozen=True)
class CommandFilter:
    """A point that is drawn to the goal by a critically damped third-order filter, within a speed.

    Between the mission's ticks the goal is carried on along its own derivatives, so a moving goal
    is followed without lag. Stand-in: it looks at no limit but speed.
    """

    slot: ClassVar[str] = "tracker"
    bandwidth: float = 2.0  # [rad/s] of the triple real pole
    v_max: float = 4.0  # [m/s], how fast it closes a distance
    heading_rate_max: float = 1.5  # [rad/s]

    def init(self, estimate: Estimate, last: Reference | None) -> Filter:
        """Continue from the last reference; with none, stand where the estimate is."""
        if last is not None:
            return Filter(last, None)
        zero, b1 = np.zeros(3), estimate.R[:, 0]
        heading = float(np.arctan2(b1[1], b1[0]))
        return Filter(Reference(estimate.r, estimate.v, zero, zero, heading, 0.0), None)

    def step(
        self, memory: Filter, estimate: Estimate, goal: Reference | None, dt: float
    ) -> tuple[Filter, Reference]:
        """The reference of now; then the filter moves on by `dt` [s]."""
        x = memory.now
        goal = goal or memory.goal
        if goal is None:
            return memory, x
        j = self._jerk(x, goal)
        rate = goal.heading_rate + self.bandwidth * wrap(goal.heading - x.heading)
        rate = min(max(rate, -self.heading_rate_max), self.heading_rate_max)

        out = x._replace(j=j, heading_rate=rate)
        return Filter(carried(out, dt), carried(goal, dt)), out

    def _jerk(self, x: Reference, goal: Reference) -> Vec3:
        w = self.bandwidth
        e = goal.r - x.r
        far = 3.0 * self.v_max / w  # beyond this the pull would ask for more than v_max
        distance = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2])
        if distance > far:
            e = e * (far / distance)
        return goal.j + (3 * w) * (goal.a - x.a) + (3 * w * w) * (goal.v - x.v) + w**3 * e

    def reframe(self, memory: Filter, shift: Shift) -> Filter:
        """The same filter, told in the new world."""
        goal = None if memory.goal is None else moved(memory.goal, shift)
        return Filter(moved(memory.now, shift), goal)


def carried(x: Reference, dt: float) -> Reference:
    """The reference after `dt` [s] of its own jerk and heading rate."""
    a = x.a + x.j * dt
    v = x.v + (x.a + x.j * (dt / 2)) * dt
    r = x.r + (x.v + (x.a + x.j * (dt / 3)) * (dt / 2)) * dt
    return Reference(r, v, a, x.j, wrap(x.heading + x.heading_rate * dt), x.heading_rate)
