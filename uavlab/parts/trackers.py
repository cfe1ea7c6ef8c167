"""Trackers: a third-order command filter, the stand-in for the MPC tracker of a later lab."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.frames import Shift, moved, wrap
from uavlab.types import Array, Estimate, Reference, Trajectory, Vec3


class Filter(NamedTuple):
    """A tracker's memory: the reference of now, and the goal that it is drawn to."""

    now: Reference
    goal: Reference | Trajectory | None  # a trajectory's times count from now


@dataclass(frozen=True)
class CommandFilter:
    """A point that is drawn to the goal by a critically damped third-order filter, within a speed.

    Between the mission's ticks the goal is carried on along its own derivatives, so a moving goal
    is followed without lag; so is a trajectory, whose corners it rounds. Stand-in: it looks at no
    limit but speed.
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
        self,
        memory: Filter,
        estimate: Estimate,
        goal: Reference | Trajectory | None,
        dt: float,
    ) -> tuple[Filter, Reference]:
        """The reference of now; then the filter moves on by `dt` [s]."""
        x = memory.now
        if isinstance(goal, Trajectory):
            goal = unwrapped(goal)
        goal = goal or memory.goal
        if goal is None:
            return memory, x
        if isinstance(goal, Trajectory):
            wanted, later = on_the_way(goal, dt), goal._replace(t=goal.t - dt)
        else:
            wanted, later = goal, carried(goal, dt)
        j = self._jerk(x, wanted)
        rate = wanted.heading_rate + self.bandwidth * wrap(wanted.heading - x.heading)
        rate = min(max(rate, -self.heading_rate_max), self.heading_rate_max)

        out = x._replace(j=j, heading_rate=rate)
        return Filter(carried(out, dt), later), out

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
        goal = memory.goal
        if isinstance(goal, Trajectory):
            goal = unwrapped(moved(goal, shift))
        elif goal is not None:
            goal = moved(goal, shift)
        return Filter(moved(memory.now, shift), goal)


def carried(x: Reference, dt: float) -> Reference:
    """The reference after `dt` [s] of its own jerk and heading rate."""
    a = x.a + x.j * dt
    v = x.v + (x.a + x.j * (dt / 2)) * dt
    r = x.r + (x.v + (x.a + x.j * (dt / 3)) * (dt / 2)) * dt
    return Reference(r, v, a, x.j, wrap(x.heading + x.heading_rate * dt), x.heading_rate)


def along(way: Trajectory, t: Array) -> tuple[Array, Array]:
    """Places (n, 3) [m] and headings (n,) [rad] of a trajectory at times `t` (n,) [s]: linear between its points.

    The first point holds before its time, the last one after it. Headings go through as they stand: see `unwrapped`.
    """
    r = np.column_stack([np.interp(t, way.t, way.r[:, i]) for i in range(3)])
    return r, np.interp(t, way.t, way.heading)


def unwrapped(way: Trajectory) -> Trajectory:
    """The same trajectory, its heading without jumps of a whole turn: each point the short way from the one before."""
    return way._replace(heading=np.unwrap(way.heading))


def on_the_way(way: Trajectory, dt: float) -> Reference:
    """The point of a trajectory (`unwrapped`) for time 0, and its speeds over the next `dt` [s]."""
    r, angle = along(way, np.array((0.0, dt)))
    zero = np.zeros(3)
    rate = float(angle[1] - angle[0]) / dt
    return Reference(r[0], (r[1] - r[0]) / dt, zero, zero, wrap(float(angle[0])), rate)


def why_not(goal: Reference | Trajectory) -> str:
    """Why nobody can follow this goal: the culprit, its value and the cure; empty if one can."""
    kind = type(goal).__name__.lower()
    for name, value in zip(goal._fields, goal, strict=True):
        bad = ~np.isfinite(np.asarray(value, dtype=float))
        if bad.any():
            at = tuple(int(i) for i in np.argwhere(bad)[0])
            where = f"{name}{list(at) or ''} of the {kind}"
            return f"{where} is {np.asarray(value)[at]}; only numbers can be flown to."
    if isinstance(goal, Trajectory):
        return _why_no_way(goal)
    return ""


def _why_no_way(way: Trajectory) -> str:
    t, r, heading = (np.asarray(x) for x in way)
    K = t.size
    if t.ndim != 1 or K == 0 or r.shape != (K, 3) or heading.shape != (K,):
        return (
            f"the trajectory has times {t.shape}, places {r.shape} and headings {heading.shape}; "
            "K points are (K,), (K, 3) and (K,), K at least 1."
        )
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if back.size:
        i = int(back[0])
        return (
            f"a trajectory that runs backwards in time: t[{i}] = {t[i]:g} s, t[{i + 1}] = {t[i + 1]:g} s. "
            "Sort its points, and keep one for each time."
        )
    return ""
