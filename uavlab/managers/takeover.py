"""Who flies: another part takes over when mode or wishes ask for it; what parts give is looked at (MRS Sec. 7)."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from uavlab.frames import heading
from uavlab.managers.groups import fitting, looks_ahead
from uavlab.managers.memory import Piloting, Wants, noted, refused
from uavlab.managers.modes import EMERGENCY, FREE, LANDING, TAKING_OFF
from uavlab.parts.missions import still
from uavlab.parts.slot import TAKEN, Flying
from uavlab.types import Command, Estimate, Reference

if TYPE_CHECKING:
    from uavlab.managers.pilot import SafePilot

# Parts of a pilot's slots that modes ask for, and nobody else may.
UP, DOWN, SOON = "LandOff up", "LandOff", "LandOff emergency"
SPEED, RESCUER = "SpeedTracker", "Emergency"
MODES_OF = {TAKING_OFF: UP, LANDING: DOWN, EMERGENCY: SOON}
_FIELD = {"tracker": "tracking", "controller": "controlling"}


def reserved(name: str) -> bool:
    """Whether a part of this name is for a mode of its own."""
    return name.split(" ", maxsplit=1)[0] in {"LandOff", SPEED, RESCUER}


def controller_for(pilot: SafePilot, m: Piloting) -> str:
    """The controller that mode and wishes ask for."""
    if m.mode == EMERGENCY:
        return RESCUER
    base = {TAKING_OFF: pilot.lifts, LANDING: pilot.lands}.get(m.mode, "") or m.wants.controller
    return fitting(pilot.controllers.parts, base, m.wants.gains)


def tracker_for(pilot: SafePilot, m: Piloting, controller: str) -> str:
    """The tracker that mode and wishes ask for, beside this controller."""
    if m.mode in MODES_OF:
        return MODES_OF[m.mode]
    base = m.steering.tracker if m.steering else m.wants.tracker
    half = looks_ahead(pilot.controllers.parts[controller])
    return fitting(pilot.trackers.parts, base, m.wants.limits, half)


def tuned(pilot: SafePilot, m: Piloting, estimate: Estimate) -> Piloting:
    """Ask for the parts that should fly now, if they do not."""
    controller = controller_for(pilot, m)
    m = asked_for(pilot, m, "controller", controller, estimate)
    if m.mode in FREE and m.controlling.asked != controller:  # refused, or it flies already
        controller = m.controlling.name
    return asked_for(pilot, m, "tracker", tracker_for(pilot, m, controller), estimate)


def asked_for(pilot: SafePilot, m: Piloting, kind: str, name: str, estimate: Estimate) -> Piloting:
    """Ask part `name` to take over in this tick."""
    slot, field = (pilot.trackers if kind == "tracker" else pilot.controllers), _FIELD[kind]
    memory: Flying = getattr(m, field)
    if name in {memory.asked, "" if memory.asked else memory.name}:
        return m
    if m.mode == EMERGENCY and kind == "tracker":
        # From where it is now: then no error is left. But at the speed that was flown: of an estimate that has jumped
        # the velocity is wrong by metres per second for a while, and it is what one would have to brake.
        here = still(estimate.r, heading(estimate.R))
        memory = memory._replace(last=here._replace(v=m.reference.v))
    after = slot.swap(memory, name, estimate)
    m = m._replace(**{field: after})
    return m if after.asked else noted(m, kind, name, f"refused: {after.said}")


def seated(slot: Any, name: str, estimate: Estimate, last: Any) -> Flying:
    """Part `name` flies at once, and no other is asked: the first of the slot may be the one that is broken."""
    return Flying(name, slot.parts[name].init(estimate, last), last)


def tracked(
    pilot: SafePilot, m: Piloting, estimate: Estimate, dt: float
) -> tuple[Piloting, Reference, str]:
    """The reference of now, and why it cannot be flown; empty: it can.

    A goal with which the tracker fails, but without which it flies, is refused.
    """
    after, out, why = _stepped(pilot.trackers, m.tracking, estimate, m.goal, dt)
    if why and m.goal is not None:
        after, out, still = _stepped(pilot.trackers, m.tracking, estimate, None, dt)
        if not still:
            m, why = refused(m, m.goal, why), ""
    if why:
        return m, m.reference, why
    asked, goal = m.tracking.asked, m.goal or m.obeyed
    m = _outcome(m._replace(tracking=after, goal=None, obeyed=goal), "tracker", asked, after)
    if m.mode in MODES_OF and after.name != MODES_OF[m.mode]:
        why = after.said or f"{after.name} flies, and nobody who lands"
    return m, out, why


def controlled(
    pilot: SafePilot, m: Piloting, estimate: Estimate, reference: Reference, dt: float
) -> tuple[Piloting, Command, str]:
    """The command of now, and why it cannot be flown; empty: it can."""
    after, out, why = _stepped(pilot.controllers, m.controlling, estimate, reference, dt)
    if why:
        return m, m.command, why
    m = _outcome(m._replace(controlling=after), "controller", m.controlling.asked, after)
    if m.mode == EMERGENCY and after.name != RESCUER:
        why = after.said or f"{after.name} flies, and not {RESCUER}"
    return m, out, why


def _stepped(
    slot: Any, memory: Flying, estimate: Estimate, given: Any, dt: float
) -> tuple[Flying, Any, str]:
    """A step of a slot, and what is wrong with it.

    Raises
    ------
    NotImplementedError
        Of a stub that somebody has not finished: that is no failure in flight.
    """
    try:
        after, out = slot.step(memory, estimate, given, dt)
        if memory.asked == after.name and not after.said and planless(slot, after):
            said = f"{memory.asked}: it finds no plan to begin with"
            memory = memory._replace(asked="", waiting=None, said=said, refused=memory.refused + 1)
            after, out = slot.step(memory, estimate, given, dt)
    except NotImplementedError:
        raise
    except Exception as error:  # whatever a part raises: it is flown on without it
        return memory, None, f"{memory.name} raised {type(error).__name__}: {error}"
    return after, out, _unfit(after.name, out)


def planless(slot: Any, memory: Flying) -> int:
    """For how many steps who flies has had no new plan; 0 of one that makes none."""
    count = getattr(slot.parts[memory.name], "failures", None)
    return 0 if count is None else count(memory.memory)


def _unfit(name: str, out: Any) -> str:
    """Why this cannot be flown; empty if it can."""
    if isinstance(out, Command):
        good = isfinite(out.f_d + np.vdot(out.omega_d, out.omega_d) + np.vdot(out.a_d, out.a_d))
    elif isinstance(out, Reference):
        sizes = sum(np.vdot(x, x) for x in out[:4])
        good = isfinite(sizes + out.heading + out.heading_rate)
    else:
        return f"{name} gave {type(out).__name__}"
    if good:
        return ""
    what = f"{out.f_d} N and {out.omega_d} rad/s" if isinstance(out, Command) else f"{out.r} m"
    return f"{name} gave {what}; only numbers can be flown"


def _outcome(m: Piloting, kind: str, asked: str, after: Flying) -> Piloting:
    """What became of whom was asked to take over."""
    if not asked:
        return m
    if after.name == asked and not after.said:
        return noted(m, kind, asked, TAKEN)._replace(switched=True)
    return noted(m, kind, asked, f"refused: {after.said}")


def kept(pilot: SafePilot, m: Piloting, before: Wants, estimate: Estimate) -> Piloting:
    """The wishes of before, for the parts of which a new one was refused."""
    wants = m.wants
    if wants is before or m.mode not in FREE:
        return m
    if m.controlling.name != controller_for(pilot, m):
        wants = wants._replace(controller=before.controller, gains=before.gains)
    if m.tracking.name != tracker_for(pilot, m, m.controlling.name):
        wants = wants._replace(tracker=before.tracker, limits=before.limits)
    if wants is m.wants:
        return m
    return tuned(
        pilot, m._replace(wants=wants), estimate
    )  # a tracker made room for who did not come
