"""Rotations: the few maps of SO(3) that everything else is written with.

Written on plain floats: for a single 3-vector that is several times faster than small numpy
arrays, and the plant compiles these same functions. ``R`` maps body → world; ``w`` is a rotation
vector [rad], axis times angle.
"""

from __future__ import annotations

from math import acos, atan2, cos, sin, sqrt
from typing import TypeAlias

import numpy as np

from uavlab.errors import BadInput
from uavlab.types import Mat3, Quat, Vec3


def hat(w: Vec3) -> Mat3:
    """Matrix of the cross product: ``hat(w) @ x == cross(w, x)``.

    Parameters
    ----------
    w : Vec3
        Any vector, shape (3,).

    Returns
    -------
    Mat3
        Skew-symmetric matrix, shape (3, 3).
    """
    x, y, z = w[0], w[1], w[2]
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


def vee(W: Mat3) -> Vec3:
    """Inverse of `hat`: the vector of a skew-symmetric matrix, shape (3, 3) → (3,)."""
    return np.array((W[2, 1], W[0, 2], W[1, 0]))


def exp(w: Vec3) -> Mat3:
    """Rotation by the vector `w` (Rodrigues), exact for any angle.

    Parameters
    ----------
    w : Vec3
        Rotation vector [rad], shape (3,).

    Returns
    -------
    Mat3
        Rotation matrix, shape (3, 3).
    """
    return np.array(exp_rows(w))


Row: TypeAlias = tuple[float, float, float]


def exp_rows(w: Vec3 | Row) -> tuple[Row, Row, Row]:
    """The rows of `exp`, as plain floats: the form that the plant compiles.

    Parameters
    ----------
    w : Vec3 or tuple
        Rotation vector [rad], shape (3,).
    """
    x, y, z = w[0], w[1], w[2]
    aa = x * x + y * y + z * z
    if aa < 1e-8:  # Taylor: the next term is below 1e-20
        s, c = 1.0 - aa / 6.0, 0.5 - aa / 24.0
    else:
        a = sqrt(aa)
        half = sin(0.5 * a)
        s, c = sin(a) / a, 2.0 * half * half / aa
    return (
        (1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y),
        (c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x),
        (c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y)),
    )  # fmt: skip


def log(R: Mat3) -> Vec3:
    """Rotation vector of `R`, of length ≤ π; the inverse of `exp`.

    Parameters
    ----------
    R : Mat3
        Rotation matrix, shape (3, 3).

    Returns
    -------
    Vec3
        Rotation vector [rad], shape (3,).
    """
    x, y, z = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    two_sin = sqrt(x * x + y * y + z * z)
    two_cos = R[0, 0] + R[1, 1] + R[2, 2] - 1.0
    a = atan2(two_sin, two_cos)
    if a < 3.0:
        k = 0.5 + a * a / 12.0 if two_sin < 1e-4 else a / two_sin
        return np.array((k * x, k * y, k * z))
    # Near a half turn the skew part fades; the axis is the largest column of R + I.
    S = 0.5 * (R + R.T) + np.eye(3) * (-0.5 * two_cos)  # = (1 − cos a) n nᵀ
    i = int(np.argmax(np.array((S[0, 0], S[1, 1], S[2, 2]))))
    n = S[:, i] / sqrt(S[0, i] ** 2 + S[1, i] ** 2 + S[2, i] ** 2)
    if n[0] * x + n[1] * y + n[2] * z < 0.0:
        n = -n
    return a * n


def project(M: Mat3) -> Mat3:
    """The rotation nearest to `M` (polar decomposition by SVD), shape (3, 3)."""
    U, _, Vt = np.linalg.svd(M)
    if np.linalg.det(U @ Vt) < 0.0:
        U[:, 2] = -U[:, 2]
    return U @ Vt


def angle(R_a: Mat3, R_b: Mat3) -> float:
    """Angle between two rotations, both (3, 3) [rad, 0 to π]."""
    cos_a = 0.5 * (float(np.sum(R_a * R_b)) - 1.0)
    if cos_a < 0.9:
        return acos(max(-1.0, cos_a))
    w = log(R_a.T @ R_b)
    return sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])


def about_z(psi: float) -> Mat3:
    """Rotation about z by `psi` [rad], shape (3, 3) (the matrix of MRS eq. 14)."""
    c, s = cos(psi), sin(psi)
    return np.array(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)))


def quaternion_from_rotation(R: Mat3) -> Quat:
    """Quaternion [w, x, y, z] of a rotation, body → world, with w ≥ 0.

    Divides by the largest of the four, so that it is exact at every angle (Shepperd 1978).

    Parameters
    ----------
    R : Mat3
        Rotation matrix, shape (3, 3).

    Returns
    -------
    Quat
        Unit quaternion, shape (4,).
    """
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    squares = np.array((trace, R[0, 0], R[1, 1], R[2, 2]))
    i = int(np.argmax(squares))
    if i == 0:
        q = np.array((1 + trace, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]))
    else:
        j, k = i % 3 + 1, (i + 1) % 3 + 1
        q = np.zeros(4)
        q[0] = R[k - 1, j - 1] - R[j - 1, k - 1]
        q[i] = 1 + 2 * R[i - 1, i - 1] - trace
        q[j] = R[j - 1, i - 1] + R[i - 1, j - 1]
        q[k] = R[k - 1, i - 1] + R[i - 1, k - 1]
    q = q / sqrt(float(q @ q))
    return -q if q[0] < 0.0 else q


def rotation_from_quaternion(q: Quat) -> Mat3:
    """Rotation matrix of a unit quaternion [w, x, y, z], body → world.

    Parameters
    ----------
    q : Quat
        Unit quaternion, shape (4,), Hamilton.

    Returns
    -------
    Mat3
        Rotation matrix, shape (3, 3).
    """
    w, x, y, z = (float(a) for a in q)
    return np.array((
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    ))


def check_rotation(R: object, name: str = "R", tolerance: float = 1e-6) -> Mat3:
    """`R` as a float64 rotation matrix, or a `BadInput` that says what is wrong with it.

    Parameters
    ----------
    R : array-like
        Shape (3, 3).
    name : str
        What the message calls it.
    tolerance : float
        Largest entry of ``R Rᵀ − I`` that is let through [1].

    Raises
    ------
    BadInput
        Wrong shape, not finite, not orthonormal, or a reflection.
    """
    M = np.asarray(R, dtype=float)
    if M.shape != (3, 3):
        raise BadInput(f"{name} has shape {M.shape}; a rotation matrix has shape (3, 3).")
    if not np.isfinite(M).all():
        raise BadInput(f"{name} has entries that are not finite: {M.tolist()}.")
    worst = float(np.abs(M @ M.T - np.eye(3)).max())
    if worst > tolerance:
        raise BadInput(
            f"{name} is not a rotation: {name} {name}ᵀ differs from the identity by {worst:.3g}, "
            f"allowed {tolerance:.0e}. so3.project({name}) gives the nearest rotation."
        )
    if np.linalg.det(M) < 0.0:
        raise BadInput(f"{name} is a reflection (determinant −1), not a rotation: swap two axes.")
    return M
