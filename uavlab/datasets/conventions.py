"""From the frames in which logs are written (world north-east-down, body forward-right-down) to ours.

Our world is east-north-up, our body forward-left-up: z up in both. So

* body vectors change the sign of y and z;
* ``r_ENU = (r_E, r_N, −r_D)``;
* ``R_ENU_FLU = T R_NED_FRD F``: ``T`` swaps the first two axes and turns the third, ``F = diag(1, −1, −1)``;
* heading, counter-clockwise from east, is π/2 less compass heading, which is clockwise from north.
"""

from __future__ import annotations

import numpy as np

from uavlab.types import Array

_T = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # NED → ENU
_F = np.array([1.0, -1.0, -1.0])  # FRD → FLU, and back


def flu_from_frd(x: Array) -> Array:
    """Body vectors (N, 3), forward-right-down → forward-left-up; any unit."""
    return np.asarray(x, dtype=float) * _F


def enu_from_ned(x: Array) -> Array:
    """World vectors (N, 3), north-east-down → east-north-up; any unit."""
    return np.asarray(x, dtype=float) @ _T.T


def attitude_from_ned_frd(R: Array) -> Array:
    """Attitudes (N, 3, 3), FRD → NED, told as FLU → ENU."""
    return _T @ np.asarray(R, dtype=float) * _F


def heading_from_compass(compass: Array) -> Array:
    """Heading [rad] in [−π, π) from compass heading [rad], clockwise from north; (N,)."""
    return (1.5 * np.pi - np.asarray(compass, dtype=float)) % (2 * np.pi) - np.pi


def matrices_from_quaternions(q: Array) -> Array:
    """Rotation matrices (N, 3, 3) of unit quaternions (N, 4) ``[w, x, y, z]``; normalised first."""
    q = np.asarray(q, dtype=float)
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=-1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=-1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], axis=-1),
        ],
        axis=1,
    )


def quaternion_from_ned_frd(q: Array) -> Array:
    """Quaternions (N, 4) ``[w, x, y, z]``, FRD → NED, told as FLU → ENU."""
    w, x, y, z = np.asarray(q, dtype=float).T
    # q_T ⊗ q ⊗ q_F, with q_T = (0, 1, 1, 0)/√2 and q_F = (0, 1, 0, 0), up to a sign
    return np.stack([w + z, x + y, x - y, w - z], axis=1) / np.sqrt(2.0)


def matrices_from_tait_bryan(yaw: Array, pitch: Array, roll: Array) -> Array:
    """``Rz(yaw) Ry(pitch) Rx(roll)`` [rad], each (N,) → (N, 3, 3). Only to read logs that store angles."""
    (ca, sa), (cb, sb), (cc, sc) = ((np.cos(x), np.sin(x)) for x in (yaw, pitch, roll))
    return np.stack(
        [
            np.stack([ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc], axis=-1),
            np.stack([sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc], axis=-1),
            np.stack([-sb, cb * sc, cb * cc], axis=-1),
        ],
        axis=1,
    )
