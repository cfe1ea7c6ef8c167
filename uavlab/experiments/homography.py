"""Pose of a camera from bearings to beacons in a plane (Spica Sec. 6.2).

The reference solver of the experiment on bearings. `pose_from_homography` is an exercise of the landing lab; when that
lab is written, this module moves there.
"""

from __future__ import annotations

import numpy as np

from uavlab import so3
from uavlab.errors import BadInput
from uavlab.types import Array, Mat3, Vec3


def homography(bearings: Array, beacons: Array, n: Vec3, d: float) -> Mat3 | None:
    """The matrix H with bearing ∝ H beacon, scaled and signed so that it is R_BW + t nᵀ/d (four-point algorithm).

    Parameters
    ----------
    bearings : Array
        (k, 3) unit vectors, body; NaN where a beacon was not seen.
    beacons : Array
        (k, 3) places [m], world, on the plane nᵀx = d.
    n : Vec3
        Unit normal of that plane, world, (3,).
    d : float
        Its distance from the world's origin [m], not 0.

    Returns
    -------
    Mat3 or None
        (3, 3); None with fewer than four beacons, or if they do not tell it.
    """
    if abs(d) < 1e-9:
        raise BadInput("d = 0 m: a plane through the world's origin has no H. Move the origin.")
    seen = np.isfinite(bearings).all(axis=1)
    if seen.sum() < 4:
        return None
    across, along = _basis(n)
    # In plane coordinates (x, y, 1) instead of (x, y, d): then all columns are of one size.
    p = np.stack((beacons @ across, beacons @ along, np.ones(len(beacons))), axis=1)[seen]
    b = bearings[seen]
    rows = [
        np.kron(so3.hat(u)[i], x) for u, x in zip(b, p, strict=True) for i in range(3)
    ]  # b × G p = 0
    _, size, Vt = np.linalg.svd(np.array(rows))
    if size[7] < 1e-6 * size[0]:
        return None
    G = Vt[8].reshape(3, 3)
    G = G / (0.5 * (np.linalg.norm(G[:, 0]) + np.linalg.norm(G[:, 1])))  # errata: scale by the mean
    if np.sum(b * (p @ G.T)) < 0.0:  # errata: beacons lie in front
        G = -G
    return np.outer(G[:, 0], across) + np.outer(G[:, 1], along) + np.outer(G[:, 2], n) / d


def pose_from_homography(H: Mat3, n: Vec3, d: float) -> tuple[Mat3, Vec3]:
    """Attitude body → world (3, 3) and position (3,) [m], world, of H = R_BW + t nᵀ/d.

    The paper prints H with the rotation body → world and t = d (H − R); the errata turn both round.

    Parameters
    ----------
    H : Mat3
        (3, 3), scaled and signed.
    n : Vec3
        Unit normal of the plane of the beacons, world, (3,).
    d : float
        Its distance from the world's origin [m].
    """
    across, along = _basis(n)
    m_1, m_2 = H @ across, H @ along
    body = np.stack((m_1, m_2, np.cross(m_1, m_2)), axis=1)
    R_BW = so3.project(body @ np.stack((across, along, n)))
    t = d * (H - R_BW) @ n
    return R_BW.T, -R_BW.T @ t


def pose_from_bearings(bearings: Array, beacons: Array) -> tuple[Mat3, Vec3] | None:
    """Attitude and position of bearings (k, 3), body, to beacons (k, 3) [m] of one height; None if there is none."""
    n, d = np.array((0.0, 0.0, 1.0)), float(beacons[0, 2])
    H = homography(bearings, beacons, n, d)
    return None if H is None else pose_from_homography(H, n, d)


def _basis(n: Vec3) -> tuple[Vec3, Vec3]:
    """Two unit vectors that make a right-handed frame with `n` as the third."""
    e = np.eye(3)[int(np.argmin(np.abs(n)))]
    across = e - (e @ n) * n
    across = across / np.linalg.norm(across)
    return across, np.cross(n, across)
