"""Lab 02, the reference answers: heading, heading rate, and attitudes that keep it.

Papers: MRS is Baca et al. 2021. Numbers in comments are its equations; where the errata correct one, the line says so.
"""

# canary-cea73d5d93445ddf07318bfa

from __future__ import annotations

import numpy as np

from uavlab import frames
from uavlab.errors import BadInput
from uavlab.so3 import about_z, hat
from uavlab.types import Mat3, Vec3

E3 = np.array((0.0, 0.0, 1.0))
HORIZONTAL = 1e-3  # vertical share of a unit thrust axis, below which the heading cannot be chosen
PARALLEL = 1e-9  # |b_3d × h_d| below which nothing is left to project
LOST = 1e-6  # |R33| below which no yaw rate turns the heading


def heading_rate(R: Mat3, omega: Vec3) -> float:
    """Heading rate from all body rates (MRS eq. 15); the roll rate turns out not to matter (errata)."""
    R_dot = R @ hat(omega)  # (2)
    x, y = R[0, 0], R[1, 0]
    return float((-y * R_dot[0, 0] + x * R_dot[1, 0]) / (x**2 + y**2))  # (15)


def with_heading(R_o: Mat3, heading: float) -> Mat3:
    """Orientation turned about world z to a heading (MRS eq. 12-14)."""
    heading_o = frames.heading(R_o)  # (12)
    return about_z(heading - heading_o) @ R_o  # (13), (14)


def attitude_by_projection(f_d: Vec3, heading_d: float) -> Mat3:
    """Lee's desired attitude: thrust axis kept, heading not (MRS eq. 17-20)."""
    h_d = _heading_vector(heading_d)  # (17)
    b_3d = _thrust_axis(f_d)  # (19)
    p_2d = np.cross(b_3d, h_d)  # (19)
    length = np.linalg.norm(p_2d)
    if length < PARALLEL:
        raise BadInput(f"f_d = {f_d} lies along the heading vector {h_d}: turn one of them.")
    p_2d = p_2d / length
    p_1d = np.cross(p_2d, b_3d)  # (19)
    return np.column_stack((p_1d, p_2d, b_3d))  # (18)


def attitude_with_heading(f_d: Vec3, heading_d: float) -> Mat3:
    """Oblique projection: thrust axis and heading kept (MRS eq. 21-23, errata: b_1d is a vector)."""
    h_d = _heading_vector(heading_d)  # (17)
    b_3d = _thrust_axis(f_d)  # (19)
    if abs(b_3d[2]) < HORIZONTAL:  # errata of (23): the condition is b3z ≠ 0, not b_3d ∦ h_d
        raise BadInput(f"f_d = {f_d} is horizontal: no attitude along it can choose its heading.")
    P = np.eye(3)[:, :2]
    O = (np.eye(3) - np.outer(b_3d, b_3d))[:, :2]
    b_1d = O @ np.linalg.solve(P.T @ O, P.T @ h_d)  # (22), errata: times h_d, else a matrix
    b_1d = b_1d / np.linalg.norm(b_1d)  # (22)
    b_2d = np.cross(b_3d, b_1d)  # (23)
    return np.column_stack((b_1d, b_2d, b_3d))  # (21)


def yaw_rate_from_heading_rate(R: Mat3, heading_rate: float) -> float:
    """Yaw rate that produces a heading rate (MRS eq. 27-31)."""
    if abs(R[2, 2]) < LOST:
        return 0.0
    h = np.array((R[0, 0], R[1, 0], 0.0))  # (4): b_1 without its height
    h_dot = np.cross(heading_rate * E3, h)  # (27)
    n = np.cross(E3, h / np.linalg.norm(h))
    p = n * (n @ R[:, 1])  # (28), (29): b_2 on the line of h_dot
    k = np.sign(h_dot @ p) * np.linalg.norm(h_dot) / np.linalg.norm(p)  # (30)
    return float(k)  # (31)


def parasitic_yaw_rate(R: Mat3, omega: Vec3) -> float:
    """Yaw rate that undoes the heading rate of roll and pitch (MRS Sec. 5.3, errata: only ω_2 matters)."""
    parasitic = heading_rate(R, np.array((omega[0], omega[1], 0.0)))  # (15) without the yaw rate
    return yaw_rate_from_heading_rate(R, -parasitic)  # (27)-(31)


def _heading_vector(heading: float) -> Vec3:
    """Unit vector of a heading (MRS eq. 17)."""
    return np.array((np.cos(heading), np.sin(heading), 0.0))


def _thrust_axis(f_d: Vec3) -> Vec3:
    """Direction of the desired force (MRS eq. 19)."""
    length = np.linalg.norm(f_d)
    if length == 0.0:
        raise BadInput("f_d is zero: it has no direction. Ask for some thrust, however little.")
    return f_d / length
