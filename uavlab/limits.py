"""Limits of motion: how fast, how suddenly, how far aside; named groups of them that the MRS has flown.

A tracker keeps its reference within `Limits`; the force MPC keeps its plan within `ForceLimits`.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import NamedTuple, TypeAlias

import numpy as np

from uavlab.errors import BadInput, UnknownName

INF = float("inf")


class AxisLimits(NamedTuple):
    """The largest size of each derivative along one axis; each > 0, inf where there is no limit.

    Of a heading, read rad for m.
    """

    v: float  # speed [m/s]
    a: float  # acceleration [m/s²]
    j: float  # jerk [m/s³]
    s: float  # snap [m/s⁴]


class Limits(NamedTuple):
    """What a reference keeps to, axis by axis of the world (MRS Sec. 4.1): x and y may both be at their limit."""

    horizontal: AxisLimits  # along x, and along y
    up: AxisLimits  # along z, upwards: speeds > 0, accelerations > 0, ...
    down: AxisLimits  # along z, downwards
    heading: AxisLimits  # [rad/s], [rad/s²], [rad/s³], [rad/s⁴]
    rates: tuple[float, float, float]  # body rates that a controller may command [rad/s]
    tilt: float  # that a controller may command [rad]
    source: str  # where the numbers stand


class ForceLimits(NamedTuple):
    """What the plan of the force MPC keeps to (MRS Sec. 5.7.2; the numbers are those of mrs_uav_controllers).

    The vertical axis has no slew limit. No axis has a limit of snap: the input is an acceleration.
    """

    horizontal: AxisLimits = AxisLimits(2.0, 2.0, 5.0, INF)
    vertical: AxisLimits = AxisLimits(2.0, 2.0, INF, INF)


TILT = pi / 3.0  # [rad], all groups
_FAST_RATES = (60.0, 60.0, 10.0)  # [rad/s]
_NOW = "mrs_uav_managers 8ce5cb6, constraint group {}"
_2020 = "mrs_uav_managers of December 2020, constraint group {}"


_Four: TypeAlias = tuple[float, float, float, float]


def _group(
    horizontal: _Four,
    vertical: _Four,
    heading: _Four,
    source: str,
    rates: tuple[float, float, float] = _FAST_RATES,
) -> Limits:
    z = AxisLimits(*vertical)  # these groups let an aircraft sink as they let it climb
    return Limits(AxisLimits(*horizontal), z, z, AxisLimits(*heading), rates, TILT, source)


GROUPS: Mapping[str, Limits] = {
    "slow": _group((1, 1, 20, 20), (1, 1, 20, 20), (0.5, 1, 10, 10), _NOW.format("slow")),
    "medium": _group((4, 2, 40, 40), (2, 1, 40, 40), (1, 1, 20, 20), _NOW.format("medium")),
    "fast": _group((8, 4, 60, 60), (4, 2, 60, 60), (2, 2, 40, 40), _NOW.format("fast")),
    "slow-2020": _group(
        (2, 1, 20, 20), (1, 1, 2, 2), (0.5, 0.5, 10, 10), _2020.format("slow"), (10.0, 10.0, 1.0)
    ),
    "medium-2020": _group((5, 2.5, 20, 20), (2, 1, 3, 5), (1, 1, 10, 10), _2020.format("medium")),
    "fast-2020": _group((9, 4, 20, 20), (2, 2, 5, 3), (2, 2, 10, 10), _2020.format("fast")),
}


def limit_group(name: str) -> Limits:
    """The limits that go by this name.

    Raises
    ------
    UnknownName
        There is no such group; the message says which there are.
    """
    if name not in GROUPS:
        raise UnknownName("constraint group", name, GROUPS)
    return GROUPS[name]


def half_of(force: ForceLimits, limits: Limits) -> Limits:
    """`limits`, with speeds and accelerations of no more than half of what the force MPC may do (MRS Sec. 5.7.2).

    So the plan of the controller has something left with which it catches up.
    """

    def cut(axis: AxisLimits, most: AxisLimits) -> AxisLimits:
        return axis._replace(v=min(axis.v, most.v / 2.0), a=min(axis.a, most.a / 2.0))

    return limits._replace(
        horizontal=cut(limits.horizontal, force.horizontal),
        up=cut(limits.up, force.vertical),
        down=cut(limits.down, force.vertical),
    )


def checked(limits: Limits) -> Limits:
    """`limits`, if an aircraft can move within them.

    Parameters
    ----------
    limits : Limits
        SI units, radians.

    Raises
    ------
    BadInput
        A limit is not a number, or not above 0; the message says which.
    """
    if not isinstance(limits, Limits):
        raise BadInput(
            f"limits are {limits!r}, which is no Limits; take a group of uavlab.limits.limit_group, "
            "or limit_group(...)._replace(...)."
        )
    for name in ("horizontal", "up", "down", "heading"):
        axis = getattr(limits, name)
        if not isinstance(axis, AxisLimits):
            raise BadInput(f"limits.{name} is {axis!r}; it takes an AxisLimits(v, a, j, s).")
        for field, value in zip(axis._fields, axis, strict=True):
            _check_positive(f"limits.{name}.{field}", value)
    if np.shape(limits.rates) != (3,):
        raise BadInput(f"limits.rates is {limits.rates!r}; it takes three body rates [rad/s].")
    for axis, rate in zip("xyz", limits.rates, strict=True):
        _check_positive(f"limits.rates about {axis}", rate)
    _check_positive("limits.tilt", limits.tilt)
    return limits


def _check_positive(name: str, value: float) -> None:
    if not isinstance(value, float | int | np.floating | np.integer) or not value > 0:
        raise BadInput(f"{name} is {value!r}; it must be a number above 0 (inf: no limit).")
