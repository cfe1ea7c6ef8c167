"""What a safe pilot remembers: all of it in the open, all of it told in the world of the estimate."""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

from uavlab.frames import Shift, moved
from uavlab.interfaces import Event, Goal, Memory
from uavlab.managers import reckoning
from uavlab.managers.reckoning import Reckoned
from uavlab.managers.remote import Held
from uavlab.managers.safety import Watch, reframed
from uavlab.parts.slot import Flying
from uavlab.so3 import about_z
from uavlab.types import Command, Estimate, Reference, Vec3

AGAIN = 0.5  # [s] after which what is refused again is told again
NEAR = 0.5  # [m] between two goals that are refused as one


class Wants(NamedTuple):
    """Which parts fly when nothing forbids it."""

    tracker: str  # without its group
    controller: str
    limits: str  # the group
    gains: str


class Steering(NamedTuple):
    """A velocity that is flown."""

    goal: Reference  # for a speed tracker
    tracker: str  # that obeys as much of it as was asked for
    age: float  # [s] since it was asked for
    against: Reference | None = None  # such a goal as it was when it had to stop before a border


class Evading(NamedTuple):
    """What the bumper does."""

    before: str  # the mode in which it began
    age: float  # [s] since something was near


class Refusal(NamedTuple):
    """What was refused last."""

    t: float  # [s]
    name: str
    said: str
    goal: Reference | None  # if it was a place


class Piloting(NamedTuple):
    """Memory of a `SafePilot`."""

    t: float  # [s] since init
    mode: str
    wants: Wants
    tracking: Flying
    controlling: Flying
    watch: Watch
    estimate: Estimate  # the last one that was finite
    reference: Reference  # of the tick before
    command: Command  # likewise
    home: Reference  # where it took off, at the height of the ground
    mass: float  # [kg], as last believed
    lean: Vec3  # (3,) [m/s²] of the thrust against the wind, as last seen; level
    reckoned: Reckoned  # velocity, for when the estimate has none
    events: tuple[Event, ...] = ()
    held: Held = Held()
    goal: Goal | None = None  # what the tracker is told in this tick
    obeyed: Goal | None = None  # what it was told last
    since: float = 0.0  # [s] when that was; −inf: something else was refused meanwhile
    pending: Goal | None = None  # what was asked during the take-off
    steering: Steering | None = None
    target: Reference | None = None  # where it will land
    waited: float = 0.0  # [s] since the reference is where this mode takes it
    evading: Evading | None = None
    light: float = 0.0  # [s], of the touch-down
    falling: Memory = None  # of the failsafe
    law: Any = None  # the failsafe itself, for the mass that was believed
    fell: str = ""  # why it falls: the trigger
    due: float = inf  # [s] into the fall, when it should stand
    switched: bool = False  # whether another part or estimator began in this tick
    refusal: Refusal | None = None
    over: str = ""


def noted(m: Piloting, kind: str, name: str, said: str) -> Piloting:
    """The same memory with one event more."""
    return m._replace(events=(*m.events, Event(round(m.t, 9), kind, name, said)))


def changed(m: Piloting, mode: str, why: str) -> Piloting:
    """In another mode, and what goes with the old one forgotten."""
    m = m._replace(mode=mode, waited=0.0, light=0.0, steering=None, evading=None)
    return noted(m, "mode", mode, why)


def refused(m: Piloting, asked: Any, why: str) -> Piloting:
    """An event; but a mission that asks for the same thing in each of its ticks is answered once."""
    name = type(asked).__name__
    last, again = m.refusal, False
    if last is not None and last.name == name and m.t - last.t < AGAIN:
        again = last.said == why or _alike(last.goal, asked)
    goal = asked if isinstance(asked, Reference) else None
    m = m._replace(refusal=Refusal(m.t, name, why, goal))
    return m if again else noted(m, "refused", name, why)


def _alike(a: Reference | None, b: Any) -> bool:
    """Whether two goals are so near that they are one that moves."""
    if a is None or not isinstance(b, Reference):
        return False
    e = a.r - b.r
    return bool(e @ e < NEAR * NEAR)


def told(m: Piloting, shift: Shift) -> Piloting:
    """All but the memories of the parts, in the new world."""

    def there(x: Any) -> Any:
        return None if x is None else moved(x, shift)

    s = m.steering
    steering = s and s._replace(goal=there(s.goal), against=there(s.against))
    return m._replace(
        watch=reframed(m.watch, shift), estimate=there(m.estimate), reference=there(m.reference),
        command=there(m.command), lean=about_z(shift.heading) @ m.lean,
        reckoned=reckoning.reframed(m.reckoned, shift), home=there(m.home),
        goal=there(m.goal), obeyed=there(m.obeyed), pending=there(m.pending), steering=steering,
        target=there(m.target), refusal=m.refusal and m.refusal._replace(goal=there(m.refusal.goal)),
    )  # fmt: skip
