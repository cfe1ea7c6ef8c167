"""Control allocation without the rotors that are known to stand still: tilt and thrust first, yaw with what is left.

A hexacopter whose rotors turn left and right by turns cannot hover on five rotors without turning unless the rotor
opposite the dead one stands still, too. Thrust and tilt are therefore shared out as if nobody cared for yaw; what yaw
torque that makes (the leak) is taken back within what changes neither, as far as the rotors' limits let it.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from uavlab.types import Array, Vec3

TINY = 1e-12  # beside the largest entry: rounding, which the mixer must not take for a rotor that can carry
SPENT = 1e-9  # of the yaw row: so little of it is free of thrust and tilt that yaw is given up


def reallocated(allocation: Array, dead: Collection[int]) -> tuple[Array, Vec3]:
    """The mixer without the rotors in `dead`.

    Parameters
    ----------
    allocation : Array
        Shape (4, n), rotor thrusts [N] to thrust [N] and torque [N m], body.
    dead : collection of int
        Rotors that get no thrust.

    Returns
    -------
    Array
        Shape (n, 4): thrust and tilt torque → least-norm rotor thrusts, whatever they do to yaw; and yaw torque →
        least-norm rotor thrusts that change neither thrust nor tilt. Zeros where yaw cannot be had so.
    Vec3
        Shape (3,), the leak: body yaw torque per thrust [m] and per tilt torque [1] that the first three columns make.
    """
    n = allocation.shape[1]
    alive = [i for i in range(n) if i not in dead]
    carry, yaw = allocation[:3, alive], allocation[3, alive]
    P = np.linalg.pinv(carry)
    free = yaw - P @ (carry @ yaw)  # the part of the yaw row that moves neither thrust nor tilt
    reach = float(free @ free)
    column = free / reach if reach > SPENT * float(yaw @ yaw) else np.zeros(len(alive))
    mixer = np.zeros((n, 4))
    mixer[alive] = np.column_stack((P, column))
    mixer[np.abs(mixer) < TINY * np.abs(mixer).max(initial=0.0)] = 0.0
    return mixer, yaw @ P
