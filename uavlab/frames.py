"""Heading, and the 4-DOF maps between the worlds of two estimators."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, pi
from typing import Any, TypeVar

from uavlab.so3 import about_z
from uavlab.types import (
    NO_SHIFT,
    Array,
    Attitude,
    Command,
    Estimate,
    Fix,
    Height,
    Mat3,
    Pose,
    Reference,
    Shift,
    State,
    Trajectory,
)

__all__ = ["NO_SHIFT", "Shift", "compose", "heading", "inverse", "moved", "wrap"]

# What is told in the body, or is a rate or a time, is the same in every world.
_STAYS = {
    "omega",
    "omega_d",
    "f_d",
    "heading_rate",
    "t",
    "std",
    "accel",
    "gyro",
    "m",
    "d",
    "v_B",
    "b",
}
_STAYS |= {"world", "reliable"}
_STAYS |= {"down", "up", "engaged", "push", "turn", "failsafe"}


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


Angle = TypeVar("Angle", float, Array)


def wrap(angle: Angle) -> Angle:
    """`angle` [rad], or each of an array of them, brought into [−π, π)."""
    return (angle + pi) % (2.0 * pi) - pi


def inverse(shift: Shift) -> Shift:
    """The shift that undoes `shift`."""
    return Shift(-(about_z(-shift.heading) @ shift.r), -shift.heading)


def compose(second: Shift, first: Shift) -> Shift:
    """`first`, then `second`, as one shift."""
    r = about_z(second.heading) @ first.r + second.r
    return Shift(r, wrap(first.heading + second.heading))


T = TypeVar(
    "T",
    bound=State | Estimate | Reference | Trajectory | Command | Fix | Pose | Attitude | Height,
)


def moved(x: T, shift: Shift) -> T:
    """The same thing, told in the new world: positions, free vectors, rotations and headings.

    Fields are moved by what they are (`uavlab.types`): ``r`` is a point, ``v a j a_d`` are world vectors, ``R`` a
    rotation, ``heading`` an angle, ``z`` a height; body quantities (``omega f_d accel``) and rates of heading stay. The
    ``shift`` and ``worlds`` of an `Estimate` say where its world lies, and go along.

    Parameters
    ----------
    x : State, Estimate, Reference, Trajectory, Command or a reading
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
    for name, value in zip(x._fields, x, strict=True):
        if name in _STAYS:
            new[name] = value
        elif name in _MOVES:
            new[name] = _MOVES[name](value, shift, Rz)
        else:
            raise TypeError(f"moved() does not know how {type(x).__name__}.{name} changes worlds")
    return type(x)(**new)


def _turned(x: Array, _shift: Shift, Rz: Mat3) -> Array:
    return Rz @ x


_MOVES: dict[str, Callable[[Any, Shift, Mat3], Any]] = {
    "r": lambda x, shift, Rz: (Rz @ x if x.ndim == 1 else x @ Rz.T) + shift.r,  # a place, or (K, 3)
    **dict.fromkeys(("v", "a", "j", "a_d", "R"), _turned),
    "heading": lambda x, shift, _: wrap(x + shift.heading),
    "z": lambda x, shift, _: x + shift.r[2],
    "shift": lambda x, shift, _: compose(shift, x),
    "worlds": lambda x, shift, _: {name: compose(shift, one) for name, one in x.items()},
}
