"""Orders: what a mission may ask of a pilot, beside a goal (MRS Sec. 7). Each is a value; a log can hold it."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from uavlab.types import Reference, Trajectory, Vec3


class TakeOff(NamedTuple):
    """Climb straight up from the ground, and hover there."""

    height: float = 1.5  # [m] above where it stands


class Land(NamedTuple):
    """Land where it is."""


class LandHome(NamedTuple):
    """Fly to where it took off, and land there."""


class LandThere(NamedTuple):
    """Fly to a place, and land there."""

    r: Vec3  # (3,) [m], world of the estimate; its height is not looked at
    heading: float  # [rad]


class Velocity(NamedTuple):
    """Fly at a velocity; what is None is left free (a partial reference, MRS Sec. 4.3)."""

    v: Vec3  # (3,) [m/s], world; the vertical one does not count if there is a height
    z: float | None = None  # [m] height to keep
    heading: float | None = None  # [rad] to turn to
    heading_rate: float = 0.0  # [rad/s]


class In(NamedTuple):
    """A goal told in the world of one hypothesis, whichever one flies (MRS Sec. 3.5)."""

    world: str
    goal: Reference | Trajectory


class Use(NamedTuple):
    """Another part, other gains or other limits."""

    slot: str  # estimator, tracker, controller, gains or limits
    name: str


class EmergencyLand(NamedTuple):
    """Come down now, with what can still be trusted."""

    why: str = "it was asked for"


class Fall(NamedTuple):
    """The failsafe: come down without knowing where."""

    why: str = "it was asked for"


class Unheard(NamedTuple):
    """The link to who commands is down in this tick."""


Order: TypeAlias = (
    TakeOff | Land | LandHome | LandThere | Velocity | In | Use | EmergencyLand | Fall | Unheard
)
ORDERS = (TakeOff, Land, LandHome, LandThere, Velocity, In, Use, EmergencyLand, Fall, Unheard)
