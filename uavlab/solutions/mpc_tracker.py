"""Lab 06, the reference answers: the tracker, whose virtual model is steered by quadratic programmes (MRS Sec. 4.1).

Paper: MRS is Baca et al. 2021. The programme of one axis stands in `uavlab.solutions.mpc_chain`.
"""

# canary-b83f1c60d2e94a7715c8e0a6

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.frames import NO_SHIFT, Shift, compose, heading, inverse, moved, wrap
from uavlab.interfaces import Memory
from uavlab.limits import Limits
from uavlab.parts.trackers import along, unwrapped, why_not
from uavlab.solutions.mpc_chain import TAU, boxes, chain, machine, slowness, solved
from uavlab.types import Array, Estimate, Reference, Trajectory

REST = 0.05  # [m/s, m/s²] below which x and y share the way that begins
LEAST_SHARE = 0.05  # of its limits, for an axis that has nearly no way to go
HOLD = 0.5  # [s] how long a goal goes on with its jerk ...
FADING = 0.3  # [s] ... and how its acceleration fades then
SLOWEST = 0.3  # [rad/s] turns of a goal that are believed, at least ...
QUICKEST = 3.0  # ... and at most
PULL = 0.25  # [s] by which a far goal is ahead of full speed: more would press the plan against its limits
DIGITS = 9  # a goal is taken to a nanometre: rounding in a change of world does not reach the plan


class Course(NamedTuple):
    """What the tracker remembers, told in the world in which it began: its axes, and their limits, stay there."""

    x: Array  # (4, 4) derivatives (position, velocity, acceleration, jerk) by axes (x, y, z, heading)
    goal: Reference | Trajectory
    age: float  # [s] since the goal was given
    plan: Array  # (N, 4) snaps of the last plan of each axis [m/s⁴], [rad/s⁴]
    old: Array  # (4,) how long ago each was made [s]
    failed: int
    share: Array  # (4,) of its limits that each axis may take on this way
    shift: Shift  # from its world to the one in which it is asked


# Goals ------------------------------------------------------------------------------------------------


def predicted(goal: Reference, t: Array) -> Array:
    """Where a moving goal will be at times t (n,) since it was given: (n, 4 derivatives, 4 axes).

    It goes on with its velocity. If its jerk says that this turns, it turns on, at that rate (a circle is predicted
    exactly); what the turn leaves of acceleration and jerk lasts for HOLD, then fades.
    """
    v, a, j = goal.v, goal.a, goal.j
    vv = float(v @ v)
    w2 = min(max(-float(j @ v) / vv, 0.0), QUICKEST**2) if vv > 1e-9 else 0.0
    w = sqrt(w2)
    turning = w2 / (w2 + SLOWEST**2)
    out = _lasting(a * (1.0 - turning), j + w2 * v, t)
    c, s = np.cos(w * t)[:, None], t[:, None] * np.sinc(w / pi * t)[:, None]  # s: sin(wt)/w
    half = t[:, None] * np.sinc(w / (2.0 * pi) * t)[:, None]
    a = a * turning
    out[:, 0, :3] += goal.r + v * s + a * (half * half / 2.0)  # (1 − cos(wt))/w²
    out[:, 1, :3] += v * c + a * s
    out[:, 2, :3] += a * c - v * (w2 * s)
    out[:, 3, :3] -= a * (w2 * s) + v * (w2 * c)
    out[:, 0, 3] = goal.heading + goal.heading_rate * t
    out[:, 1, 3] = goal.heading_rate
    return out


def _lasting(a: Array, j: Array, t: Array) -> Array:
    """What an acceleration and a jerk (3,) do that last for HOLD, then fade: (n, 4, 4), nothing in the heading."""
    out = np.zeros((len(t), 4, 4))
    h = np.minimum(t, HOLD)[:, None]
    d = t[:, None] - h
    left = np.exp(-d / FADING)
    end = a + j * h
    v = (a + j * (h / 2.0)) * h
    out[:, 0, :3] = (
        (a + j * (h / 3.0)) * (h * h / 2.0) + v * d + end * (FADING * (d - FADING * (1.0 - left)))
    )
    out[:, 1, :3] = v + end * (FADING * (1.0 - left))
    out[:, 2, :3] = end * left
    out[:, 3, :3] = np.where(d > 0.0, -end * left / FADING, j)
    return out


def sampled(way: Trajectory, t: Array, h: float) -> Array:
    """A trajectory at times t (n,), with derivatives from differences over ± h [s]: (n, 4 derivatives, 4 axes)."""
    r, angle = along(way, np.concatenate((t - h, t, t + h)))
    before, here, after = np.split(np.column_stack((r, angle)), 3)
    out = np.zeros((len(t), 4, 4))
    out[:, 0] = here
    out[:, 1] = (after - before) / (2.0 * h)
    out[:, 2] = (after - 2.0 * here + before) / (h * h)
    out[:, 3] = np.gradient(out[:, 2], t, axis=0)
    return out


def near(wanted: Array, x: Array, most: Array) -> Array:
    """`wanted` (n, 4, 4) with headings the short way round, and places no farther than `most` (n, 4) from now."""
    e = wanted[:, 0] - x[0]
    e[:, 3] -= 2.0 * pi * round(float(e[0, 3]) / (2.0 * pi))
    far = np.maximum(1.0, np.abs(e) / most)
    far[:, :2] = far[:, :2].max(axis=1, keepdims=True)  # x and y together: the way stays straight
    wanted[:, 0] = x[0] + e / far
    return wanted


# The tracker ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class MpcTracker:
    """A model that follows any goal within limits, steered by a programme for each axis (MRS Sec. 4.1, eq. 16)."""

    slot: ClassVar[str] = "tracker"
    limits: Limits
    N: int = 40
    dt: float = 0.2

    def init(self, estimate: Estimate, last: Reference | None) -> Memory:
        """Continue from the last reference, else from the estimate; come to rest until there is a goal."""
        x = np.zeros((4, 4))
        if last is None:
            x[0, :3], x[1, :3], x[0, 3] = estimate.r, estimate.v, heading(estimate.R)
        else:
            x[:, :3] = last.r, last.v, last.a, last.j
            x[:2, 3] = last.heading, last.heading_rate
        tau = np.array([slowness(box) for box in boxes(self.limits)])
        most = boxes(self.limits)[:, :, 1].min(axis=1)
        slow = np.maximum(
            2.0 * tau, tau + np.abs(x[1]) / (2.0 * most)
        )  # it needs v²/(2 a) to brake
        stop = (x[0] + slow * x[1] + tau**2 * x[2]).round(DIGITS)
        zero, one = np.zeros(3), np.ones(4)
        goal = Reference(stop[:3], zero, zero, zero, float(stop[3]), 0.0)
        return Course(x, goal, 0.0, np.zeros((self.N, 4)), np.zeros(4), 0, one, NO_SHIFT)

    def step(
        self, memory: Memory, estimate: Estimate, goal: Reference | Trajectory | None, dt: float
    ) -> tuple[Memory, Reference]:
        """The reference of now; then the model moves on by the first snap of a new plan."""
        bad = goal is not None and bool(why_not(goal))
        if goal is not None and not bad:
            memory = _given(memory, goal)
        out = _told(memory)
        plan, old, new = self._plans(memory, dt)
        t = machine(self.N, self.dt, dt, TAU).t
        snaps = np.array([_now(plan[:, i], t, old[i]) for i in range(4)])
        A, b = chain(dt)
        return memory._replace(
            x=A @ memory.x + b[:, None] * snaps, age=memory.age + dt,
            plan=plan, old=old + dt, failed=memory.failed + (bad or not new),
        ), out  # fmt: skip

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """Its own world stays; the way from there is another one."""
        return memory._replace(shift=compose(shift, memory.shift))

    def failures(self, memory: Memory) -> int:
        """How many steps had no new plan for an axis, or a goal that was not finite."""
        return memory.failed

    def _plans(self, memory: Course, dt: float) -> tuple[Array, Array, bool]:
        """Snaps of the axes (N, 4), how long ago each was planned (4,) [s], and whether all are new."""
        box, x = boxes(self.limits), memory.x
        plan, old, new = memory.plan.copy(), memory.old.copy(), True
        each = [machine(self.N, self.dt, dt, slowness(one)) for one in box]
        t = each[0].t
        ahead = np.array([2.0 * m.tau + PULL for m in each]) + t[:, None]
        wanted = near(_wanted(memory, t, self.dt), x, box[:, :, 0].max(axis=1) * ahead)
        for i, m in enumerate(each):
            found = solved(m, x[:, i], wanted[:, :, i], box[i] * memory.share[i])
            if found.ok:
                plan[:, i], old[i] = found.z / m.root, 0.0
            new = new and found.ok
        return plan, old, new


def _now(plan: Array, t: Array, old: float) -> float:
    """The snap of a plan (N,) that was made `old` [s] ago; none after its end."""
    k = int(np.searchsorted(t, old + 1e-9, side="right"))
    return float(plan[k]) if k < len(t) else 0.0


def _given(memory: Course, goal: Reference | Trajectory) -> Course:
    """A new goal, told in the world in which the tracker began.

    From rest to rest, x and y get limits in proportion to their ways: the way is then straight.
    """
    home = None if memory.shift is NO_SHIFT else inverse(memory.shift)
    if isinstance(goal, Trajectory):
        goal = goal if home is None else moved(goal, home)
        goal = unwrapped(Trajectory(*(np.round(x, DIGITS) for x in goal)))
        return memory._replace(goal=goal, age=0.0, share=np.ones(4))
    goal = goal if home is None else moved(goal, home)
    r, v, a, j = (np.round(x, DIGITS) for x in goal[:4])
    goal = Reference(r, v, a, j, round(goal.heading, DIGITS), round(goal.heading_rate, DIGITS))
    before, share = memory.goal, memory.share
    if v.any() or not isinstance(before, Reference) or (before.r != r).any():
        share = np.ones(4)
        way = np.abs(r[:2] - memory.x[0, :2])
        still = not v.any() and np.abs(memory.x[1:3, :2]).max() < REST
        if still and way.any():
            share[:2] = np.maximum(way / way.max(), LEAST_SHARE)
    return memory._replace(goal=goal, age=0.0, share=share)


def _wanted(memory: Course, t: Array, dt: float) -> Array:
    """The goal at times t (n,) from now, as (n, 4 derivatives, 4 axes)."""
    if isinstance(memory.goal, Trajectory):
        return sampled(memory.goal, memory.age + t, dt / 2.0)
    return predicted(memory.goal, memory.age + t)


def _told(memory: Course) -> Reference:
    """The model as a reference, in the world in which it is asked."""
    r, v, a, j = memory.x[:, :3].copy()
    angle, rate = float(memory.x[0, 3]), float(memory.x[1, 3])
    if not -pi <= angle <= pi:
        angle = wrap(angle)
    out = Reference(r, v, a, j, angle, rate)
    return out if memory.shift is NO_SHIFT else moved(out, memory.shift)
