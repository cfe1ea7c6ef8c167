"""Safety: what must not be while an aircraft flies, and for how long it may be (MRS Sec. 7.2).

The limits are those of `uavlab.managers.bounds`. All is told in the open: what was seen of the last ticks is a `Watch`,
what must be done is a `Verdict`, and who obeys it is the pilot.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import acos, degrees, isfinite, sqrt
from typing import Any, NamedTuple

import numpy as np

from uavlab.frames import Shift, heading, moved, wrap
from uavlab.managers.bounds import BOUNDS, Bounds, Safety, checked
from uavlab.types import Command, Estimate, Reference, Vec3

__all__ = [
    "BOUNDS", "EMERGENCY", "FAILSAFE", "NOTHING", "TRIGGERS", "Bounds", "Play", "Safety", "Verdict", "Watch", "begun",
    "checked", "kind_of", "reframed", "watched",
]  # fmt: skip

EMERGENCY, FAILSAFE = "emergency", "failsafe"
_KINDS = {"MpcController": "mpc", "Emergency": "emergency"}


class Play(NamedTuple):
    """What else a pilot knows in this tick."""

    kind: str = "se3"  # of control law, a key of `Safety.bounds`; see `kind_of`
    switched: bool = False  # whether another part, or another estimator, began in this tick
    failures: int = 0  # ticks without a new plan until now, of tracker and controller together
    heard: bool = True  # whether the link to who commands is up
    emergency: bool = False  # whether it is landing in an emergency already


class Watch(NamedTuple):
    """What the watch remembers. All times in [s], for how long it has been so."""

    expected: Estimate | None  # the estimate of this tick, if it went on as in the last one
    mute: float  # until when most of it is not looked at
    missing: float = 0.0
    unreliable: float = 0.0
    leaning: float = 0.0
    straining: float = 0.0
    unsolved: float = 0.0
    unheard: float = 0.0
    failures: int = 0  # as of the last tick


class Verdict(NamedTuple):
    """What must be done."""

    level: str = ""  # "emergency": land now; "failsafe": fall; empty: fly on
    trigger: str = ""  # one of `TRIGGERS`
    said: str = ""  # why: a sentence with the value and its bound


# trigger → what it asks for: while all was well, and while an emergency landing is under way already
TRIGGERS: Mapping[str, tuple[str, str]] = {
    "state missing": (FAILSAFE, FAILSAFE),
    "unreliable": (FAILSAFE, FAILSAFE),  # no estimator is healthy: mrs_uav_managers falls, too
    "lost": (FAILSAFE, FAILSAFE),
    "tilt error": (FAILSAFE, FAILSAFE),  # mrs_uav_managers switches the motors off
    "tracker": (EMERGENCY, FAILSAFE),
    "controller": (EMERGENCY, FAILSAFE),
    "control error": (EMERGENCY, ""),
    "jump": (EMERGENCY, FAILSAFE),
    "heading error": (EMERGENCY, FAILSAFE),
    "tilt": (EMERGENCY, FAILSAFE),
    "throttle": (EMERGENCY, ""),  # a lander that works hard is still better than a fall
    "solver": (EMERGENCY, ""),
    "link": (EMERGENCY, ""),
}
NOTHING = Verdict()


def kind_of(controller: Any) -> str:
    """The kind of a control law, for `Play.kind`: "mpc" or "emergency"; "se3" for all others."""
    return _KINDS.get(type(controller).__name__, "se3")


def begun(limits: Safety) -> Watch:
    """The memory of a watch that begins now; it is mute at first, as after a switch."""
    return Watch(None, limits.mute)


def reframed(memory: Watch, shift: Shift) -> Watch:
    """The same memory, told in the new world."""
    return memory._replace(expected=memory.expected and moved(memory.expected, shift))


def watched(
    limits: Safety,
    memory: Watch,
    estimate: Estimate,
    reference: Reference | None,
    command: Command | None,
    play: Play,
    dt: float,
) -> tuple[Watch, Verdict]:
    """Look at one tick, and say what must be done.

    Call it in the air only: what stands on the ground may lag as it likes.

    Parameters
    ----------
    limits : Safety
        See `checked`.
    memory : Watch
        From `begun`, or the tick before; after a change of world from `reframed`.
    estimate : Estimate
        Of this tick.
    reference, command : Reference and Command, or None
        The newest that there are, told in the world of the estimate: of this tick, or of the one before if neither
        tracker nor controller has been asked yet. None: nothing to look at.
    play : Play
        What else the pilot knows.
    dt : float
        [s] since the tick before.

    Returns
    -------
    Watch, Verdict
        The verdict is repeated as long as its cause is there. Of several causes the gravest speaks. For ``limits.mute``
        after a switch only an estimate, reference or command that is missing has a voice. While the estimate is no
        number, nobody else is blamed; who flies then must see to it that a command is one.
    """
    known = _finite(estimate.r, estimate.v, estimate.R, estimate.omega)
    memory = _counted(limits, memory, estimate if known else None, command, play, dt)
    found = _missing(limits, memory)
    if known:  # else it is no fault of theirs
        found |= _no_numbers(reference, command)
    if known and memory.mute <= 0.0:
        bounds = limits.bounds.get(play.kind, limits.bounds["se3"])
        jump = _jumped(bounds, limits, memory.expected, estimate)
        found |= jump or _apart(bounds, estimate, reference)
        found |= _aside(limits, estimate, reference)
        found |= _for_long(limits, memory, estimate, command)
    memory = memory._replace(expected=_later(estimate if known else memory.expected, dt))
    return memory, _gravest(found, play.emergency)


def _gravest(found: Mapping[str, str], emergency: bool) -> Verdict:
    """Of what was found, by trigger, the one that asks for most."""
    asks = [(TRIGGERS[x][emergency], x) for x in TRIGGERS if x in found]
    for level in (FAILSAFE, EMERGENCY):
        for asked, trigger in asks:
            if asked == level:
                return Verdict(level, trigger, found[trigger])
    return NOTHING


def _counted(
    limits: Safety, m: Watch, known: Estimate | None, command: Command | None, play: Play, dt: float
) -> Watch:
    """For how long what may not last has been so."""
    mute = limits.mute if play.switched else m.mute - dt
    mute = mute if mute > 1e-9 else 0.0
    leans, strains = False, False
    if known is not None and command is not None:
        leans = _wanted_turn(known, command) > limits.k_R * limits.tilt_error
        strains = _strains(limits, command)
    speaks = not mute

    def since(so: bool, time: float) -> float:
        return time + dt if so else 0.0

    return Watch(
        m.expected,
        mute,
        missing=since(known is None, m.missing),
        unreliable=since(known is not None and not known.reliable, m.unreliable),
        leaning=since(speaks and leans, m.leaning),
        straining=since(speaks and strains, m.straining),
        unsolved=since(speaks and play.failures > m.failures, m.unsolved),
        unheard=since(not play.heard, m.unheard),
        failures=play.failures,
    )


def _wanted_turn(estimate: Estimate, command: Command) -> float:
    """By how much the thrust axis is told to turn faster than it does [rad/s].

    The axis that a control law wants is not told to anybody: ``a_d`` of some laws is along it, of others along the axis
    that is (MRS eq. 53). But the law asks for a rate of k_R for each radian between the two, beside the rate at which
    the wanted one moves. Of an aircraft that follows both are gone a moment later; what stays is the error.
    """
    x, y, _ = command.omega_d - estimate.omega
    return sqrt(x * x + y * y)


def _strains(limits: Safety, command: Command) -> bool:
    """Whether the throttle is above its limit: MRS (32), in which it is a straight line of the root of the force."""
    if limits.curve is None:
        return False
    a_t, b_t = limits.curve
    return sqrt(max(command.f_d, 0.0)) > (limits.throttle - b_t) / a_t


def _missing(limits: Safety, m: Watch) -> dict[str, str]:
    """Whether there is an estimate, and measurements behind it; never muted."""
    found = {}
    if _lasts(m.missing, limits.missing_time):
        found["state missing"] = (
            f"the estimate has been no number for {m.missing:.2f} s; bound {limits.missing_time:g} s"
        )
    if _lasts(m.unreliable, limits.unreliable_time):
        found["unreliable"] = (
            f"no measurement has stood behind the estimate for {m.unreliable:.2f} s; "
            f"bound {limits.unreliable_time:g} s"
        )
    return found


def _no_numbers(reference: Reference | None, command: Command | None) -> dict[str, str]:
    """Whether tracker and controller give anything; never muted."""
    found = {}
    if reference is not None and not _finite(reference.r, reference.v, reference.heading):
        found["tracker"] = (
            f"the reference is at {reference.r} m, heading {reference.heading} rad; only numbers can be flown"
        )
    if command is not None and not _finite(command.f_d, command.omega_d):
        found["controller"] = (
            f"the command is {command.f_d} N and {command.omega_d} rad/s; only numbers can be flown"
        )
    return found


def _apart(bounds: Bounds, estimate: Estimate, reference: Reference | None) -> dict[str, str]:
    """How far the aircraft is from where it should be.

    Nobody asks in the tick of a jump. It is the estimate that went away then, not the aircraft: who lands from where it
    is now believed to be has no error left, and need not fall.
    """
    if reference is None:
        return {}
    e = _length(reference.r - estimate.r)
    said = f"the reference is {e:.2f} m from the estimate; bound"
    if e > bounds.lost:
        return {"lost": f"{said} {bounds.lost:g} m"}
    return {"control error": f"{said} {bounds.error:g} m"} if e > bounds.error else {}


def _aside(limits: Safety, estimate: Estimate, reference: Reference | None) -> dict[str, str]:
    """How the aircraft is turned."""
    found = {}
    tilt = acos(min(max(float(estimate.R[2, 2]), -1.0), 1.0))
    if tilt > limits.tilt:
        found["tilt"] = f"the aircraft is tilted by {_degrees(tilt)}; bound {_degrees(limits.tilt)}"
    if reference is None:
        return found
    turned = abs(wrap(reference.heading - heading(estimate.R)))
    if turned > limits.heading_error:
        found["heading error"] = (
            f"the heading is {_degrees(turned)} off its reference; bound {_degrees(limits.heading_error)}"
        )
    return found


def _jumped(
    bounds: Bounds, limits: Safety, expected: Estimate | None, estimate: Estimate
) -> dict[str, str]:
    """How far the estimate is from where its own motion has led; worlds apart, nothing can be said."""
    if expected is None or not _one_world(expected, estimate):
        return {}
    jump = _length(estimate.r - expected.r)
    if jump > bounds.jump:
        return {
            "jump": f"the estimate jumped by {jump:.2f} m against its own motion; bound {bounds.jump:g} m"
        }
    turn = abs(wrap(heading(estimate.R) - heading(expected.R)))
    if turn > limits.heading_jump:
        said = f"the heading of the estimate jumped by {_degrees(turn)}; bound {_degrees(limits.heading_jump)}"
        return {"jump": said}
    return {}


def _for_long(
    limits: Safety, m: Watch, estimate: Estimate, command: Command | None
) -> dict[str, str]:
    """What may be so for a moment only."""
    found = {}
    if command is not None and _lasts(m.leaning, limits.tilt_error_time):
        off = _wanted_turn(estimate, command) / limits.k_R
        found["tilt error"] = (
            f"the axis of thrust has been off the wanted one for {m.leaning:.2f} s, now by {_degrees(off)}; "
            f"bound {_degrees(limits.tilt_error)} for {limits.tilt_error_time:g} s"
        )
    if command is not None and _lasts(m.straining, limits.throttle_time):
        found["throttle"] = (
            f"{command.f_d:.1f} N and more have been asked for {m.straining:.2f} s; "
            f"bound: throttle {limits.throttle:g} for {limits.throttle_time:g} s"
        )
    if _lasts(m.unsolved, limits.unsolved_time):
        found["solver"] = (
            f"there has been no new plan for {m.unsolved:.2f} s; bound {limits.unsolved_time:g} s"
        )
    if _lasts(m.unheard, limits.unheard_time):
        found["link"] = (
            f"nobody has been heard for {m.unheard:.2f} s; bound {limits.unheard_time:g} s"
        )
    return found


def _one_world(a: Estimate, b: Estimate) -> bool:
    """Whether both are told in the same world."""
    if a.world != b.world:
        return False
    if a.shift is b.shift:
        return True
    turned = abs(wrap(a.shift.heading - b.shift.heading))
    return turned < 1e-6 and _length(a.shift.r - b.shift.r) < 1e-6


def _later(estimate: Estimate | None, dt: float) -> Estimate | None:
    """The estimate `dt` [s] later, if it goes on."""
    return estimate and estimate._replace(r=estimate.r + estimate.v * dt)


def _lasts(time: float, bound: float) -> bool:
    return time > bound - 1e-9


def _length(x: Vec3) -> float:
    return sqrt(x @ x)


def _degrees(angle: float) -> str:
    return f"{degrees(angle):.1f}°"


def _finite(*given: Any) -> bool:
    """Whether all of it is finite."""
    return all(isfinite(x if isinstance(x, float) else np.vdot(x, x)) for x in given)
