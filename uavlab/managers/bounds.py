"""The limits of a safe flight, each with where it stands, and the aircraft's own if they are others.

The figures are those of mrs_uav_managers (its control manager, 8ce5cb6) unless it says "ours".
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, pi, radians
from typing import NamedTuple

from uavlab.errors import BadInput
from uavlab.parts.throttle import ThrustCurve


class Bounds(NamedTuple):
    """What is borne under one kind of control law; inf: anything."""

    error: float  # [m] between reference and estimate: beyond, it lands
    lost: float  # [m] likewise: beyond, it falls
    jump: float  # [m] of the estimate in one tick, against its own motion


# kind of control law → its bounds (mrs_uav_managers; of the MPC, those of 2020 were 2 and 3 m)
BOUNDS: Mapping[str, Bounds] = {
    "se3": Bounds(1.5, 2.5, 1.5),
    "mpc": Bounds(3.5, 4.5, 2.5),
    "emergency": Bounds(3.0, 4.0, 3.0),
}


class Safety(NamedTuple):
    """The limits. With inf, what it bounds is not watched."""

    bounds: Mapping[str, Bounds] = BOUNDS
    heading_jump: float = pi / 2  # [rad] of the estimate in one tick
    heading_error: float = pi / 2  # [rad] between reference and estimate
    tilt: float = radians(75.0)  # [rad]
    tilt_error: float = radians(20.0)  # [rad] between the wanted axis of thrust and the one that is
    tilt_error_time: float = 0.5  # [s]
    k_R: float = 5.0  # [1/s] rate for an error of the axis, as in all laws of mrs_uav_controllers
    missing_time: float = 0.1  # [s] an estimate may be no number
    unreliable_time: float = (
        0.2  # [s] it may stand on no measurement: ours; who waits flies on a guess
    )
    throttle: float = 0.8  # of 1
    throttle_time: float = 1.0  # [s]
    unsolved_time: float = 0.5  # [s] without a new plan: ours
    unheard_time: float = 3.0  # [s] who commands may be silent: ours
    mute: float = 1.0  # [s] after another part began
    curve: ThrustCurve | None = None  # of this aircraft; None: its throttle is not watched


def checked(limits: Safety) -> Safety:
    """The same limits, if they can be watched.

    Raises
    ------
    BadInput
        A limit is not a number above 0 (inf: not watched), a mute or k_R is not finite, or there are no bounds "se3",
        by which every law flies that has none of its own.
    """
    if "se3" not in limits.bounds:
        raise BadInput(f"bounds has {', '.join(limits.bounds) or 'nothing'}; it must have 'se3'.")
    given = {
        f"bounds[{k!r}].{n}": x for k, b in limits.bounds.items() for n, x in b._asdict().items()
    }
    given |= {n: x for n, x in limits._asdict().items() if n not in {"bounds", "curve", "mute"}}
    for name, value in given.items():
        if not (isinstance(value, int | float) and value > 0.0):
            raise BadInput(f"{name} is {value!r}; it must be a number above 0 (inf: not watched).")
    if not (isfinite(limits.mute) and limits.mute >= 0.0):
        raise BadInput(f"mute is {limits.mute} s; it must be finite, 0 or more.")
    if not isfinite(limits.k_R):
        raise BadInput(
            f"k_R is {limits.k_R} 1/s; it must be finite: inf of tilt_error is not watched."
        )
    for kind, bounds in limits.bounds.items():
        if bounds.lost < bounds.error:
            raise BadInput(
                f"bounds[{kind!r}] falls at {bounds.lost} m and lands at {bounds.error} m; lost must not be less."
            )
    return limits
