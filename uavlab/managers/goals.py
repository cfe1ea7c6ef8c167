"""Goals: whether what is asked may be flown, and what the tracker is told (MRS Sec. 7.2)."""

from __future__ import annotations

from math import inf, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from uavlab.errors import UnknownName
from uavlab.frames import NO_SHIFT, moved
from uavlab.interfaces import Goal
from uavlab.managers import fence
from uavlab.managers.memory import Piloting, Steering, refused
from uavlab.managers.modes import (
    EMERGENCY,
    EVADING,
    GOING_HOME,
    GROUND,
    LANDING,
    MANUAL,
    TAKING_OFF,
)
from uavlab.managers.takeover import SPEED, tuned
from uavlab.orders import In, Velocity
from uavlab.parts import trackers
from uavlab.parts.missions import still
from uavlab.types import Array, Estimate, Reference, Trajectory, Vec3

if TYPE_CHECKING:
    from uavlab.managers.pilot import SafePilot

BUSY = {
    GROUND: "it stands on the ground; let it take off first",
    GOING_HOME: "it is on its way to land",
    LANDING: "it is landing",
    EMERGENCY: "it is landing in an emergency",
    MANUAL: "somebody at the remote control flies",
    EVADING: "it moves away from what is near",
}
REACTION = 0.5  # [s] that it is given to react, before it brakes in front of a border
CLEAR = 0.3  # [m] that it stops away from it
REST = 0.05  # [m/s] below which it has stopped
FRESH = (
    0.25  # [s] for which a moving goal is believed to come from somebody who looks ahead himself
)
BRAKES = 1.0  # [m/s²] of a tracker that does not say its own


def asked_goal(pilot: SafePilot, m: Piloting, estimate: Estimate, goal: Goal) -> Piloting:
    """A goal, told in the world of the estimate."""
    why = BUSY.get(m.mode, "")
    if not why and m.steering is None and m.mode != TAKING_OFF and _same(goal, m.obeyed):
        return m._replace(goal=goal, since=m.t)
    why = why or no_goal(goal)
    if m.mode == TAKING_OFF and not why:
        return m._replace(pending=goal)
    why = why or fence.why_not(pilot.area, estimate, goal, now(m).r)
    if why:
        return refused(m, goal, why)._replace(since=-inf)
    return given(pilot, m, estimate, goal)


def no_goal(goal: Goal) -> str:
    """Why nobody can fly to this, wherever it is; empty: one can."""
    if isinstance(goal, Reference):
        for name in ("r", "v", "a", "j"):
            if np.shape(value := getattr(goal, name)) != (3,):
                return f"{name} of the reference is {value!r}; it must be three numbers."
    try:
        return trackers.why_not(goal)
    except (TypeError, ValueError) as error:
        return f"the {type(goal).__name__.lower()} is not made of numbers: {error}."


def given(pilot: SafePilot, m: Piloting, estimate: Estimate, goal: Goal) -> Piloting:
    """A goal that may be flown goes to the tracker."""
    m = m._replace(goal=goal, since=m.t)
    if m.steering is not None:
        m = tuned(pilot, m._replace(steering=None), estimate)
    return m


def now(m: Piloting) -> Reference:
    """Where the reference is in this tick."""
    return m.tracking.last if m.tracking.last is not None else m.reference


def standing(m: Piloting) -> Reference:
    """The goal to stay where the reference is."""
    here = now(m)
    return still(here.r, here.heading)


def asked_in(pilot: SafePilot, m: Piloting, estimate: Estimate, order: In) -> Piloting:
    """A goal that is told in the world of a hypothesis."""
    goal, worlds = order.goal, dict(estimate.worlds)
    worlds.setdefault(estimate.world, NO_SHIFT)
    if not isinstance(goal, Reference | Trajectory):
        return refused(
            m, order, f"{type(goal).__name__} is no goal; give a Reference or a Trajectory."
        )
    if order.world not in worlds:
        return refused(m, order, str(UnknownName("world", order.world, worlds)))
    if why := no_goal(goal):
        return refused(m, order, why)
    return asked_goal(pilot, m, estimate, moved(goal, worlds[order.world]))


def _same(a: Goal, b: Goal | None) -> bool:
    """Whether both are the same place, asked for again."""
    if a is b:
        return True
    if not (isinstance(a, Reference) and isinstance(b, Reference)):
        return False
    same = np.array_equal(a.r, b.r) and np.array_equal(a.v, b.v)
    return same and a.heading == b.heading


# A goal that moves ------------------------------------------------------------------------------------


def minded(pilot: SafePilot, m: Piloting, estimate: Estimate) -> Piloting:
    """A goal that moves and is not told anew would lead out of the area: it ends before the border."""
    if pilot.area is None or m.goal is not None or m.t - m.since < FRESH:
        return m
    goal = m.tracking.goal
    if not isinstance(goal, Reference) or m.steering is not None or not goal.v.any():
        return m
    here = now(m)
    stop = _stopped(pilot, m, here.r, here.v, goal.v)
    why = fence.why_not(pilot.area, estimate, still(stop, here.heading), here.r)
    if not why:
        return m
    return m._replace(goal=halt(pilot, m, estimate), since=m.t)


def halt(pilot: SafePilot, m: Piloting, estimate: Estimate) -> Reference:
    """The goal to stop as soon as it can, or here if that is outside."""
    here = now(m)
    a = _brakes(pilot, m)[0]
    stop = still(here.r + here.v * (sqrt(here.v @ here.v) / (2.0 * a)), here.heading)
    return standing(m) if fence.why_not(pilot.area, estimate, stop, here.r) else stop


# Velocities -------------------------------------------------------------------------------------------


def asked_velocity(pilot: SafePilot, m: Piloting, estimate: Estimate, order: Velocity) -> Piloting:
    """A velocity, some of which may be left free."""
    why = {**BUSY, TAKING_OFF: "it is taking off"}.get(m.mode, "") or _bad(order)
    if why:
        return refused(m, order, why)
    return steer(pilot, m, estimate, order)


def steer(pilot: SafePilot, m: Piloting, estimate: Estimate, order: Velocity) -> Piloting:
    """Fly at a velocity; one that leads out of the area is refused, or ends before the border."""
    here, z = now(m), order.z
    goal = Reference(
        here.r if z is None else np.array((here.r[0], here.r[1], z)),
        np.asarray(order.v, dtype=float), np.zeros(3), np.zeros(3),
        here.heading if order.heading is None else order.heading, order.heading_rate,
    )  # fmt: skip
    free = "".join((" z" if z is not None else "", " heading" if order.heading is not None else ""))
    name = SPEED + free
    before = m.steering
    if before is None and (why := _leaves(pilot, m, estimate, goal, name)):
        return refused(m, order, why)
    against = None if before is None else before.against
    m = m._replace(steering=Steering(goal, name, 0.0, against))
    if before is None or before.tracker != name:
        m = tuned(pilot, m, estimate)
    return m


def steered(pilot: SafePilot, m: Piloting, estimate: Estimate, dt: float) -> Piloting:
    """One tick of flying at a velocity: what the tracker is told, and whether it must brake."""
    s = m.steering
    if s is None:
        return m
    here = now(m)
    if s.age > pilot.unsteered and sqrt(here.v @ here.v) < REST:  # nobody says anything any more
        return tuned(
            pilot, m._replace(steering=None, goal=halt(pilot, m, estimate), since=m.t), estimate
        )
    against = s.against if s.against is not None and _alike(s.goal.v, s.against.v) else None
    if against is None and (why := _leaves(pilot, m, estimate, s.goal, s.tracker)):
        m, against = refused(m, Velocity(s.goal.v), why), s.goal
    goal = s.goal
    if against is not None:
        goal = goal._replace(v=np.zeros(3), r=_level(s, here))
    tell = s.age == 0.0 or against is not None
    s = s._replace(age=s.age + dt, against=against)
    return m._replace(steering=s, goal=goal if tell else None)


def _alike(v: Vec3, w: Vec3) -> bool:
    """Whether `v` is still much the same as `w`, both (3,) [m/s]."""
    e = v - w
    return bool(e @ e < 0.25 * (w @ w))


def _level(s: Steering, here: Reference) -> Vec3:
    """Where a brake keeps the height: at the one that was asked for."""
    return np.array((here.r[0], here.r[1], s.goal.r[2]))


def _leaves(pilot: SafePilot, m: Piloting, estimate: Estimate, goal: Reference, name: str) -> str:
    """Why this velocity may not be flown on: where it would stop if it braked a moment from now; empty: it may."""
    if pilot.area is None:
        return ""
    here = now(m)
    stop = _stopped(pilot, m, here.r, here.v, goal.v)
    if " z" in name:
        stop[2] = goal.r[2]
    return fence.why_not(pilot.area, estimate, still(stop, here.heading), here.r)


def _stopped(pilot: SafePilot, m: Piloting, r: Vec3, v: Vec3, wish: Vec3) -> Vec3:
    """Where it stands if it goes on towards a velocity for a moment, and brakes then (3,) [m]."""
    a, a_z, most, most_z = _brakes(pilot, m)
    flat = _sooner(v[:2], wish[:2], a, most)
    up = float(_sooner(v[2:], wish[2:], a_z, most_z)[0])
    way = np.append(
        flat * (REACTION + sqrt(flat @ flat) / (2.0 * a)), up * (REACTION + abs(up) / (2.0 * a_z))
    )
    size = sqrt(way @ way)
    return r + way * (1.0 + CLEAR / size) if size > 1e-9 else r.copy()


def _sooner(v: Array, wish: Array, a: float, most: float) -> Array:
    """The velocity (n,) [m/s] that `v` may have become before it brakes."""
    change = wish - v
    size, now_ = sqrt(change @ change), sqrt(v @ v)
    later = wish if size <= a * REACTION else v + change * (a * REACTION / size)
    size = sqrt(later @ later)
    if size < now_:  # it may not have begun to brake
        return v
    most = max(most, now_)
    return later * (most / size) if size > most else later


def _brakes(pilot: SafePilot, m: Piloting) -> tuple[float, float, float, float]:
    """Deceleration of the tracker, level and upright [m/s²], and its speeds [m/s]."""
    part: Any = pilot.trackers.parts[m.tracking.asked or m.tracking.name]
    limits = getattr(part, "limits", None)
    if limits is None:
        return BRAKES, BRAKES, inf, inf
    up, down = limits.up, limits.down
    return limits.horizontal.a, min(up.a, down.a), limits.horizontal.v, max(up.v, down.v)


def _bad(order: Velocity) -> str:
    """Why nobody can fly at this; empty: one can."""
    if not numbers(order.v, 3):
        return f"v is {order.v} m/s; only three finite numbers can be flown."
    for name in ("z", "heading", "heading_rate"):
        value = getattr(order, name)
        if value is not None and not numbers(value, 0):
            return f"{name} is {value}; only numbers can be flown."
    return ""


def numbers(x: Any, n: int) -> bool:
    """Whether these are `n` finite numbers; 0: one alone."""
    try:
        value = np.asarray(x, dtype=float)
    except (TypeError, ValueError):
        return False
    return value.shape == ((n,) if n else ()) and bool(np.isfinite(value).all())
