"""Control allocation without the rotors that are known to stand still: thrust and tilt are kept, yaw if it can be.

A hexacopter whose rotors turn left and right by turns cannot hover on five rotors without turning itself, unless the
one opposite the dead one makes no thrust at all. Left to idle, that one turns an F550 by 0.19 rad/s more each second,
and no motor can undo it (tests/plant/test_broken_motors.py asks a linear programme). So it is stopped, too, and yaw is
given up: on four rotors what tilt does to yaw comes back when the tilt does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.plant.airframe import Airframe
from uavlab.types import GRAVITY, Array

TINY = 1e-12  # beside the largest entry: rounding, which the mixer must not take for a rotor that can carry
RANK = 1e-6  # singular values below are none, as `uavlab.plant.airframe.build_airframe` has it


class Reallocation(NamedTuple):
    """What an autopilot does when rotors are dead."""

    mixer: Array  # (n, 4) thrust and torque, body → rotor thrusts; zeros for who stands still, and for yaw given up
    still: tuple[int, ...]  # who gets no thrust: the dead, and whom the autopilot stops


def reallocated(airframe: Airframe, allocation: Array, dead: tuple[int, ...]) -> Reallocation:
    """The least-norm allocation to the rotors that are left.

    Rotors that would have to carry less in hover than they do when they idle are stopped as well. If there are such, or
    the others cannot make yaw by itself, yaw is given up.

    Parameters
    ----------
    airframe : Airframe
        Its weight, and the least thrust of a rotor.
    allocation : Array
        Shape (4, n), rotor thrusts [N] to thrust [N] and torque [N m], body.
    dead : tuple of int
        Rotors that make no thrust.
    """
    n = allocation.shape[1]
    alive = [i for i in range(n) if i not in dead]
    rows = 4 if np.linalg.matrix_rank(allocation[:, alive], tol=RANK) == 4 else 3
    if rows == 4:
        hover = np.linalg.pinv(allocation[:, alive])[:, 0] * airframe.m * GRAVITY
        carry = [i for i, f in zip(alive, hover, strict=True) if f >= airframe.thrust_min]
        rows, alive = (4, alive) if carry == alive else (3, carry)
    mixer = np.zeros((n, 4))
    mixer[alive, :rows] = np.linalg.pinv(allocation[:rows, alive])
    mixer[np.abs(mixer) < TINY * np.abs(mixer).max(initial=0.0)] = 0.0
    return Reallocation(mixer, tuple(i for i in range(n) if i not in alive))
