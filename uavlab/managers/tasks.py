"""Take-off and landing, from the order to the motors (MRS Sec. 7.3): the UAV manager."""

from __future__ import annotations

from math import exp, isfinite, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import heading, wrap
from uavlab.managers import fence
from uavlab.managers.goals import BUSY, asked_goal, now, numbers
from uavlab.managers.memory import Piloting, changed, noted, refused
from uavlab.managers.modes import (
    EMERGENCY,
    EVADING,
    FLYING,
    FREE,
    GOING_HOME,
    GROUND,
    LANDED,
    LANDING,
    MANUAL,
    TAKING_OFF,
)
from uavlab.managers.safety import begun
from uavlab.managers.takeover import UP, controller_for, seated, tuned
from uavlab.orders import Land, LandHome, LandThere, TakeOff
from uavlab.parts.landoff import HIGHEST, LOWEST
from uavlab.parts.missions import still
from uavlab.parts.slot import TAKEN
from uavlab.parts.touchdown import Touchdown
from uavlab.types import Command, Estimate, Reference, Vec3

if TYPE_CHECKING:
    from uavlab.managers.pilot import SafePilot

NEAR, TURNED = 0.1, 0.1  # [m], [rad] of the reference from where it has to be (mrs_uav_managers)
CLOSE = 0.2  # [m] of the estimate likewise: it is noisy (ours)
STANDS = 0.01  # [m/s] of the reference: it does not go on (ours)
PATIENCE = 5.0  # [s] after which it goes on though the estimate is farther than that (ours)
LOW = 2.0  # [m] above ground, to which it flies down before it lands (mrs_uav_managers)
SLOW = 1.0  # [m/s] of the reference, below which a lean is one against the wind (ours)
LEANS = 1.0  # [s] over which it is seen (ours)
SHARE = 0.4  # of the mass by which what a controller learned of it is believed (ours)
OFF = Command(0.0, np.zeros(3), np.zeros(3))
for _x in OFF[1:]:
    _x.setflags(write=False)


# Orders -----------------------------------------------------------------------------------------------


def take_off(pilot: SafePilot, m: Piloting, estimate: Estimate, order: TakeOff) -> Piloting:
    """Climb straight up, if it may; told again while it does, nothing changes."""
    if m.mode == TAKING_OFF:
        return m
    top = estimate.r + np.array((0.0, 0.0, 0.0 if not _height(order) else order.height))
    why = _why_no_start(m, estimate, order) or fence.why_not(
        pilot.area, estimate, still(top), estimate.r
    )
    if why:
        return refused(m, order, why)
    here = still(estimate.r, heading(estimate.R))
    name = controller_for(pilot, m._replace(mode=TAKING_OFF))
    try:
        law = seated(pilot.controllers, name, estimate, OFF)
    except NotImplementedError:
        raise  # a stub that somebody has not finished
    except Exception as error:
        return refused(m, order, f"{name} cannot begin: {type(error).__name__}: {error}")
    lift = seated(pilot.trackers, UP, estimate, here)
    lift = lift._replace(memory=lift.memory._replace(top=float(here.r[2]) + order.height))
    m = changed(m, TAKING_OFF, f"to {order.height:g} m")
    for kind, who in (("tracker", UP), ("controller", name)):
        m = m if who == m.controlling.name else noted(m, kind, who, TAKEN)
    return m._replace(
        home=here, reference=here, command=OFF, pending=None, obeyed=None,
        tracking=lift, controlling=law, watch=begun(pilot.safety),
    )  # fmt: skip


def _height(order: TakeOff) -> bool:
    return numbers(order.height, 0) and LOWEST <= float(order.height) <= HIGHEST


def _why_no_start(m: Piloting, estimate: Estimate, order: TakeOff) -> str:
    """Why it may not take off; empty: it may."""
    if m.mode != GROUND:
        return f"it is not on the ground, but {m.mode}."
    if not estimate.reliable:
        return "the estimate is no number, or no measurement of late stands behind it; wait until one does."
    if not _height(order):
        return f"a height of {order.height} m; take {LOWEST:g} to {HIGHEST:g} m."
    return ""


def land(pilot: SafePilot, m: Piloting, estimate: Estimate, order: Land) -> Piloting:
    """Land where it is."""
    if m.mode == LANDING:
        return m
    if why := _why_no_landing(m):
        return refused(m, order, why)
    return _down(pilot, m, estimate, "it was asked for")


def land_home(pilot: SafePilot, m: Piloting, estimate: Estimate, order: LandHome) -> Piloting:
    """Fly to where it took off, and land there."""
    return _go(pilot, m, estimate, order, m.home.r, m.home.heading)


def land_there(pilot: SafePilot, m: Piloting, estimate: Estimate, order: LandThere) -> Piloting:
    """Fly to a place, and land there."""
    flat = (
        numbers(order.r[:2], 2) if np.shape(order.r) == (3,) else False
    )  # its height may be anything
    if not (flat and numbers(order.heading, 0)):
        said = f"r is {order.r} m, heading {order.heading} rad; only numbers can be flown to."
        return refused(m, order, said)
    return _go(pilot, m, estimate, order, np.asarray(order.r), order.heading)


def _why_no_landing(m: Piloting) -> str:
    if m.mode == GROUND:
        return "it stands on the ground already."
    return BUSY.get(m.mode, "") if m.mode in {MANUAL, EVADING, EMERGENCY, LANDING} else ""


def _go(
    pilot: SafePilot, m: Piloting, estimate: Estimate, order: Any, r: Vec3, nose: float
) -> Piloting:
    """Fly to above `r` (3,) [m] at the height of now, and land there."""
    here = now(m)
    target = still(np.array((r[0], r[1], here.r[2])), nose)
    same = m.target is not None and bool((m.target.r[:2] == r[:2]).all())
    if m.mode in {GOING_HOME, LANDING} and same:
        return m
    why = _why_no_landing(m) or ("it is taking off." if m.mode == TAKING_OFF else "")
    why = why or fence.why_not(pilot.area, estimate, target, here.r)
    if why:
        return refused(m, order, why)
    x, y, _ = target.r
    m = changed(m, GOING_HOME, f"{type(order).__name__}: to ({x:.1f}, {y:.1f}) m")
    return tuned(pilot, m._replace(target=target, goal=target), estimate)


def _down(pilot: SafePilot, m: Piloting, estimate: Estimate, why: str) -> Piloting:
    return tuned(pilot, changed(m, LANDING, why)._replace(goal=None), estimate)


# Progress ---------------------------------------------------------------------------------------------


def progressed(
    pilot: SafePilot, m: Piloting, estimate: Estimate, command: Command, dt: float
) -> tuple[Piloting, Command]:
    """What comes next when a take-off, a way home or a landing has come to its end; and the command, or motors off."""
    if m.mode == TAKING_OFF:
        return _climbed(pilot, m, estimate, dt), command
    if m.mode == GOING_HOME:
        return _arrived(pilot, m, estimate, dt), command
    if m.mode in {LANDING, EMERGENCY}:
        light, down = touchdown(pilot, m.mass).step(m.light, command, dt)
        m = m._replace(light=light)
        return (touched(m, LANDED), OFF) if down else (m, command)
    return m, command


def _climbed(pilot: SafePilot, m: Piloting, estimate: Estimate, dt: float) -> Piloting:
    """Whether the take-off is done. It is, too, when the reference has waited for long: who hangs low still flies."""
    here, top = now(m), float(m.tracking.memory.top)
    z = float(here.r[2])
    there = abs(top - z) < NEAR
    m = m._replace(waited=m.waited + dt if there else 0.0)
    if not there or (abs(top - float(estimate.r[2])) >= NEAR and m.waited < PATIENCE):
        return m
    m = tuned(pilot, changed(m, FLYING, "it is up"), estimate)
    stay = still(np.array((here.r[0], here.r[1], top)), here.heading)
    pending, m = m.pending, m._replace(pending=None, goal=stay)
    return m if pending is None else asked_goal(pilot, m, estimate, pending)


def _arrived(pilot: SafePilot, m: Piloting, estimate: Estimate, dt: float) -> Piloting:
    """Whether it is above the place to land at, and low; if nobody aboard can take it there, it lands here."""
    goal, here = m.target, now(m)
    assert goal is not None
    turned = abs(wrap(goal.heading - here.heading))
    there = _distance(goal.r, here.r) < NEAR and turned < TURNED
    stands = there or float(here.v @ here.v) < STANDS * STANDS
    m = m._replace(waited=m.waited + dt if stands else 0.0)
    close = _distance(goal.r, estimate.r) < CLOSE
    if not there and m.waited > PATIENCE:
        return _down(pilot, m, estimate, "it does not get there")
    if not there or not (close or m.waited > PATIENCE):
        return m
    low = float(m.home.r[2]) + LOW
    if goal.r[2] <= low + NEAR:
        return _down(pilot, m, estimate, "it is there")
    lower = goal._replace(r=np.array((goal.r[0], goal.r[1], low)))
    return m._replace(target=lower, goal=lower, waited=0.0)


def _distance(a: Vec3, b: Vec3) -> float:
    e = a - b
    return sqrt(e @ e)


# Touch-down -------------------------------------------------------------------------------------------


def weighed(pilot: SafePilot, m: Piloting) -> float:
    """The mass as the controller that flies has learned it [kg]; in modes in which it may not, as last believed."""
    m_e = getattr(m.controlling.memory, "m_e", None) if m.mode in FREE else None
    if m_e is None or not isfinite(m_e):
        return m.mass
    most = SHARE * pilot.mass
    return pilot.mass + min(max(float(m_e) - pilot.mass, -most), most)


def leaning(
    m: Piloting, estimate: Estimate, reference: Reference, command: Command, dt: float
) -> Vec3:
    """How the thrust leans against the wind (3,) [m/s²], world, level: what of it no reference asks for.

    Seen while it flies slowly on an estimate that something stands behind; at speed it leans against its own drag.
    """
    v = reference.v
    if not (m.mode in FREE and estimate.reliable and v @ v < SLOW * SLOW):
        return m.lean
    now = (command.f_d / m.mass) * estimate.R[:, 2] - reference.a
    now[2] = 0.0
    return m.lean + (1.0 - exp(-dt / LEANS)) * (now - m.lean)


def touchdown(pilot: SafePilot, mass: float) -> Touchdown:
    """What sees the ground, for an aircraft of this mass [kg]; of the one that was told if that cannot hover."""
    try:
        return Touchdown(mass, pilot.curve)
    except BadInput:
        return Touchdown(pilot.mass, pilot.curve)


def touched(m: Piloting, over: str) -> Piloting:
    """It stands, and the motors go off."""
    m = noted(m, "touchdown", m.mode, f"the rotors carry less than half of {m.mass:.2f} kg")
    if over == LANDED:
        m = changed(m, LANDED, "it stands")
    return m._replace(over=over)


def resting(m: Piloting, estimate: Estimate) -> tuple[Piloting, Reference, Command]:
    """A tick on the ground with motors off."""
    here = still(estimate.r, heading(estimate.R))
    return m._replace(reference=here, command=OFF), here, OFF
