"""Heading, and the 4-DOF maps between the worlds of two estimators."""

from __future__ import annotations

from math import atan2, pi
from typing import Any, NamedTuple, TypeVar

import numpy as np

from uavlab.so3 import about_z
from uavlab.types import Command, Estimate, Fix, Mat3, Pose, Reference, State, Vec3


def heading(R: Mat3) -> float:
    """Heading η: the azimuth of the body x axis in the world (MRS eq. 3).

    Parameters
    ----------
    R : Mat3
        Rotation body → world, shape (3, 3). Valid while the x axis is not vertical.

    Returns
    -------
    float
        Heading [rad], in (−π, π].
    """
    return atan2(R[1, 0], R[0, 0])


def wrap(angle: float) -> float:
    """`angle` [rad] brought into [−π, π)."""
    return (angle + pi) % (2.0 * pi) - pi


class Shift(NamedTuple):
    """Change of world: ``r_new = Rz(heading) r_old + r`` (z stays vertical, so four degrees of freedom)."""

    r: Vec3  # (3,) [m], where the old origin lies in the new world
    heading: float  # [rad], how far the old world is turned in the new one


NO_SHIFT = Shift(np.zeros(3), 0.0)


def inverse(shift: Shift) -> Shift:
    """The shift that undoes `shift`."""
    return Shift(-(about_z(-shift.heading) @ shift.r), -shift.heading)


def compose(second: Shift, first: Shift) -> Shift:
    """`first`, then `second`, as one shift."""
    r = about_z(second.heading) @ first.r + second.r
    return Shift(r, wrap(first.heading + second.heading))


T = TypeVar("T", State, Estimate, Reference, Command, Fix, Pose)


def moved(x: T, shift: Shift) -> T:
    """The same thing, told in the new world: positions, free vectors, rotations and headings.

    Fields are moved by what they are (`uavlab.types`): ``r`` is a point, ``v a j a_d`` are world vectors, ``R`` a
    rotation, ``heading`` an angle; body quantities (``omega f_d accel``) and rates of heading stay.

    Parameters
    ----------
    x : State, Estimate, Reference, Command, Fix or Pose
        Told in the old world.
    shift : Shift
        Old world → new world.

    Raises
    ------
    TypeError
        `x` has a field that this function does not know.
    """
    Rz = about_z(shift.heading)
    new: dict[str, Any] = {}
    value: Any
    for name, value in zip(x._fields, x, strict=True):
        if name == "r":
            new[name] = Rz @ value + shift.r
        elif name in {"v", "a", "j", "a_d", "R"}:
            new[name] = Rz @ value
        elif name == "heading":
            new[name] = wrap(value + shift.heading)
        elif name in {"omega", "omega_d", "f_d", "heading_rate", "t"}:
            new[name] = value
        else:
            raise TypeError(f"moved() does not know how {type(x).__name__}.{name} changes worlds")
    return type(x)(**new)
