"""Closed paths as sums of harmonics, flown with a smooth start: positions and exact derivatives up to jerk."""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple

import numpy as np

from uavlab.types import Array, Vec3


class Path(NamedTuple):
    """``p(θ) = centre + Σ_k (A_k cos kθ + B_k sin kθ)``, once around for θ from 0 to 2π."""

    centre: Vec3  # (3,) [m]
    A: Array  # (K, 3) [m], row k−1 belongs to harmonic k
    B: Array  # (K, 3) [m]


def circle(centre: Vec3, radius: float) -> Path:
    """Level circle, counter-clockwise from the east of its centre."""
    return Path(centre, np.array([[radius, 0, 0]]), np.array([[0, radius, 0]]))


def lemniscate(centre: Vec3, length: float, width: float, rise: float = 0.0) -> Path:
    """Gerono's figure of eight: `length` along x, `width` along y; it climbs and sinks by `rise` [m]."""
    A = np.array([[0, 0, rise], [0, 0, 0]])
    return Path(centre, A, np.array([[length / 2, 0, 0], [0, width / 2, 0]]))


def derivatives(path: Path, theta: float) -> tuple[Vec3, Vec3, Vec3, Vec3]:
    """The point and its first three derivatives with respect to θ, each (3,)."""
    p, d1, d2, d3 = path.centre, 0.0, 0.0, 0.0
    for k, (A, B) in enumerate(zip(path.A, path.B, strict=True), start=1):
        c, s = cos(k * theta), sin(k * theta)
        wave, slope = A * c + B * s, k * (B * c - A * s)
        p = p + wave
        d1 = d1 + slope
        d2 = d2 - k * k * wave
        d3 = d3 - k * k * slope
    return p, d1, d2, d3  # type: ignore[return-value]


def phase(t: float, rate: float, ramp: float) -> tuple[float, float, float, float]:
    """θ(t) and its first three derivatives: from rest to `rate` [rad/s] in `ramp` [s], then uniform.

    The speed is the smooth step 10τ³ − 15τ⁴ + 6τ⁵, so that jerk stays continuous.
    """
    if t >= ramp:
        return rate * (t - 0.5 * ramp), rate, 0.0, 0.0
    x = max(t, 0.0) / ramp
    return (
        rate * ramp * x**4 * (2.5 - 3.0 * x + x * x),
        rate * x**3 * (10.0 - 15.0 * x + 6.0 * x * x),
        rate / ramp * 30.0 * x * x * (1.0 - x) ** 2,
        rate / ramp**2 * 60.0 * x * (1.0 - 3.0 * x + 2.0 * x * x),
    )


def along(path: Path, t: float, rate: float, ramp: float) -> tuple[Vec3, Vec3, Vec3, Vec3]:
    """Position, velocity, acceleration and jerk at time `t` [s] after the start, each (3,)."""
    theta, w, w1, w2 = phase(t, rate, ramp)
    p, d1, d2, d3 = derivatives(path, theta)
    return p, w * d1, w * w * d2 + w1 * d1, w**3 * d3 + 3.0 * w * w1 * d2 + w2 * d1
