"""Lab 02, right answers written in other ways than the reference: all must get full marks."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from grader.material import variant
from uavlab.exercises.heading import (
    attitude_by_projection,
    attitude_with_heading,
    heading_rate,
    parasitic_yaw_rate,
    with_heading,
    yaw_rate_from_heading_rate,
)

CANARY = "canary-235a4e9cfd38d521cbd8dc55"


@variant(heading_rate)
def closed_form(R, omega):
    return (omega[1] * R[2, 1] + omega[2] * R[2, 2]) / (1.0 - R[2, 0] ** 2)


@variant(heading_rate)
def nose_velocity(R, omega):
    """How fast the tip of the nose moves sideways, over its distance from the vertical."""
    nose = R[:, 0]
    velocity = np.cross(R @ omega, nose)
    return np.float64(
        (nose[0] * velocity[1] - nose[1] * velocity[0]) / np.hypot(nose[0], nose[1]) ** 2
    )


@variant(heading_rate)
def imaginary_part(R, omega):
    """The logarithmic derivative of the nose as a complex number."""
    z_dot = R[:2, 1] * omega[2] - R[:2, 2] * omega[1]
    return (complex(*z_dot) / complex(R[0, 0], R[1, 0])).imag


@variant(with_heading)
def by_complex_product(R_o, heading):
    nose = complex(R_o[0, 0], R_o[1, 0])
    turn = complex(math.cos(heading), math.sin(heading)) * nose.conjugate() / abs(nose)
    flat = (R_o[0] + 1j * R_o[1]) * turn
    return np.array([flat.real, flat.imag, R_o[2]])


@variant(with_heading)
def with_scipy(R_o, heading):
    old = Rotation.from_matrix(R_o)
    x, y, _ = old.apply([1.0, 0.0, 0.0])
    return (
        Rotation.from_euler("z", heading) * Rotation.from_euler("z", -np.arctan2(y, x)) * old
    ).as_matrix()


@variant(attitude_by_projection)
def gram_schmidt(f_d, heading_d):
    if not np.any(f_d):
        raise ValueError("no force")
    z = f_d / math.sqrt(f_d @ f_d)
    x = np.array([math.cos(heading_d), math.sin(heading_d), 0.0])
    x -= (x @ z) * z
    if x @ x < 1e-18:
        raise ValueError("force along the heading")
    x /= math.sqrt(x @ x)
    return np.transpose([x, np.cross(z, x), z])


@variant(attitude_by_projection)
def aligned_by_scipy(f_d, heading_d):
    """The turn that brings z exactly to the force and x as near as it goes to the heading vector."""
    h = np.array([np.cos(heading_d), np.sin(heading_d), 0.0])
    if np.linalg.norm(np.cross(f_d, h)) <= 1e-9 * np.linalg.norm(f_d):
        raise ValueError("nothing to project")
    pairs = np.vstack((f_d, h)), np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    turn, _ = Rotation.align_vectors(*pairs, weights=[np.inf, 1.0])
    return turn.as_matrix()


@variant(attitude_with_heading)
def printed_by_spica(f_d, heading_d):
    """The construction of Spica, with the sign that it lacks upside down."""
    length = np.linalg.norm(f_d)
    if abs(f_d[2]) <= 1e-3 * length:
        raise ArithmeticError("horizontal or zero")
    z = f_d / length
    x = np.cross([-np.sin(heading_d), np.cos(heading_d), 0.0], z) * np.sign(z[2])
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


@variant(attitude_with_heading)
def along_the_vertical(f_d, heading_d):
    """The heading vector, lowered until it is square to the force."""
    if abs(f_d[2]) <= 1e-3 * math.sqrt(sum(f_d**2)):
        raise ValueError("horizontal or zero")
    c, s = math.cos(heading_d), math.sin(heading_d)
    x = np.array([c, s, -(f_d[0] * c + f_d[1] * s) / f_d[2]])
    y = np.cross(f_d, x)
    return np.stack([v / np.linalg.norm(v) for v in (x, y, f_d)], axis=1)


@variant(attitude_with_heading)
def with_the_pseudo_inverse(f_d, heading_d):
    b3 = np.array(f_d) / max(float(np.linalg.norm(f_d)), 1e-300)
    if abs(b3[2]) < 1e-3:
        raise ValueError("horizontal or zero")
    P = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
    O = (np.identity(3) - b3[:, None] * b3)[:, :2]
    b1 = (O @ np.linalg.inv(P.T @ O) @ P.T) @ [np.cos(heading_d), np.sin(heading_d), 0.0]
    b1 /= np.sqrt(np.sum(b1**2))
    return np.c_[b1, np.cross(b3, b1), b3]


@variant(yaw_rate_from_heading_rate)
def ratio(R, heading_rate):
    if abs(R[2, 2]) < 1e-6:
        return 0.0
    return heading_rate * (R[0, 0] ** 2 + R[1, 0] ** 2) / R[2, 2]


@variant(yaw_rate_from_heading_rate)
def minor_of_the_matrix(R, heading_rate):
    """R33 is the cofactor of the upper left corner of a rotation."""
    corner = np.linalg.det(R[:2, :2])
    nose = R[:2, 0]
    return heading_rate * np.dot(nose, nose) / corner if abs(corner) > 1e-6 else 0


@variant(parasitic_yaw_rate)
def what_is_left(R, omega):
    return -omega[1] * R[2, 1] / R[2, 2] if abs(R[2, 2]) >= 1e-6 else 0.0


@variant(parasitic_yaw_rate)
def square_to_the_nose(R, omega):
    """The yaw rate that keeps the sideways velocity of the nose at zero."""
    side = np.cross([0.0, 0.0, 1.0], R[:, 0])
    by_pitch, by_yaw = side @ R[:, 2] * -omega[1], side @ R[:, 1]
    return np.divide(-by_pitch, by_yaw) if abs(R[2, 2]) > 1e-6 else np.float64(0.0)
