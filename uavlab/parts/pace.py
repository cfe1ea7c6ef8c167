"""Pace: how fast and how briskly a reference moves, and the two laws that trackers of this kind share."""

from __future__ import annotations

from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import heading
from uavlab.types import Estimate, Reference, Vec3


class Pace(NamedTuple):
    """The speed at which a reference travels, and the acceleration with which it gets there and stops."""

    v: float  # [m/s]
    a: float  # [m/s²]


def checked(pace: Pace, name: str) -> Pace:
    """The same pace, or a `BadInput` that calls it `name`.

    Raises
    ------
    BadInput
        It is no Pace, or a number of it is not finite and above 0.
    """
    if not isinstance(pace, Pace):
        raise BadInput(f"{name} is {pace!r}; it takes a Pace(v, a) in m/s and m/s².")
    for field, value in zip(pace._fields, pace, strict=True):
        if not (isfinite(value) and value > 0.0):
            raise BadInput(f"{name}.{field} is {value}; it must be a finite number above 0.")
    return pace


def closing(e: float, most: float, k: float) -> float:
    """Rate of `e` with which it can still be brought to zero: the root of what is left, and a straight line near zero.

    At constant deceleration the rate is √(2 · most · e), whose slope at zero has no bound; no step of time could
    follow it. So below most/k² the law is k e instead, and the root starts where both agree in value and in slope.

    Parameters
    ----------
    e : float
        What is left to close: a distance [m] or a difference of velocities [m/s]; ≥ 0.
    most : float
        Largest rate of the rate: a deceleration [m/s²] or a jerk [m/s³].
    k : float
        Slope near zero [1/s]; 1/k is the time in which the last of it fades.
    """
    corner = most / (k * k)
    return k * e if e <= corner else sqrt(2.0 * most * (e - corner / 2.0))


def towards(x: Vec3, wanted: Vec3, step: float) -> Vec3:
    """`x` moved towards `wanted`, both (n,), by no more than `step`, straight: the same in any frame."""
    way = wanted - x
    size = sqrt(way @ way)
    return wanted if size <= step else x + way * (step / size)


def stepped(x: Reference, v: Vec3, dt: float) -> Reference:
    """The reference `dt` [s] later, when its velocity has changed evenly to `v` (3,) [m/s]; its heading stays."""
    r, a = x.r + (x.v + v) * (dt / 2.0), (v - x.v) / dt
    return Reference(r, v, a, np.zeros(3), x.heading, 0.0)


def beginning(estimate: Estimate, last: Reference | None) -> Reference:
    """Where a tracker that takes over begins: at the last reference, else at the estimate and its velocity."""
    if last is not None:
        return last
    zero = np.zeros(3)
    return Reference(estimate.r, estimate.v, zero, zero, heading(estimate.R), 0.0)
