"""Wind: a mean, and Dryden gusts of MIL-F-8785C that pass the aircraft as frozen turbulence.

Along the mean wind the gust has spectrum 2σ²L/(πV) / (1 + (Lω/V)²), across it and upwards
σ²L/(πV) (1 + 3(Lω/V)²) / (1 + (Lω/V)²)². With T = L/V their autocorrelations are σ² e^(−τ/T) and
σ² e^(−τ/T) (1 − τ/2T). The steps below are exact for any dt.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import exp, hypot, sqrt
from typing import NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.plant.world import vector
from uavlab.types import Vec3

_B = 1.0 - sqrt(3.0)  # couples the two states of a gust across the wind
_P = ((0.5, 0.25 * (1.0 + sqrt(3.0))), (0.25 * (1.0 + sqrt(3.0)), 1.0))  # their covariance / σ²


class Gust(NamedTuple):
    """Memory of the air: along the mean wind, across it, and up."""

    along: float  # [m/s]
    across: tuple[float, float]  # filter state and gust [m/s]
    up: tuple[float, float]  # [m/s]


class Wind(NamedTuple):
    """What the air does. Standard deviations and lengths are told along the mean wind, across it, and up.

    MIL-F-8785C at low altitude, for the wind W at 6 m and height h [ft]: σ_up = 0.1 W, σ_along = σ_across =
    σ_up / (0.177 + 0.000823 h)^0.4, L_up = h, L_along = L_across = h / (0.177 + 0.000823 h)^1.2; see `low_altitude`.
    """

    mean: Vec3 = np.zeros(3)  # (3,) [m/s], world
    sigma: Vec3 = np.zeros(3)  # (3,) standard deviation of the gusts [m/s]
    length: Vec3 = np.array((50.0, 50.0, 10.0))  # (3,) scale of the gusts [m]
    passing: float = 0.0  # [m/s], speed with which gusts pass; 0: that of the mean wind, at least 1

    def init(self, rng: np.random.Generator) -> Gust:
        """Air as it is found: drawn from the gusts' own distribution.

        Raises
        ------
        BadInput
            A wrong shape, not finite, a negative sigma, or a length that is not positive.
        """
        vector(self.mean, "wind.mean")
        sigma, length = vector(self.sigma, "wind.sigma"), vector(self.length, "wind.length")
        if (sigma < 0.0).any() or not (length > 0.0).all() or not self.passing >= 0.0:
            raise BadInput(
                f"wind: sigma {sigma.tolist()} m/s must be ≥ 0, length {length.tolist()} m > 0, "
                f"passing {self.passing} m/s ≥ 0."
            )
        along, *pairs = rng.standard_normal(5).tolist()
        across, up = (
            _pair((0.0, 0.0), 0.0, float(s), pairs[i : i + 2])
            for s, i in ((sigma[1], 0), (sigma[2], 2))
        )
        return Gust(float(sigma[0]) * along, across, up)

    def step(self, gust: Gust, dt: float, rng: np.random.Generator) -> tuple[Gust, Vec3]:
        """The gust after `dt` [s] and the velocity of the air then (3,) [m/s], world."""
        speed = self.passing or max(float(np.linalg.norm(self.mean)), 1.0)
        xi = rng.standard_normal(5).tolist()
        s, x = self.sigma, [dt * speed / float(L) for L in self.length]
        keep = exp(-x[0])
        new = Gust(
            keep * gust.along + float(s[0]) * sqrt(1.0 - keep * keep) * xi[0],
            _pair(gust.across, x[1], float(s[1]), xi[1:3]),
            _pair(gust.up, x[2], float(s[2]), xi[3:5]),
        )
        return new, self.velocity(new)

    def velocity(self, gust: Gust) -> Vec3:
        """Velocity of the air (3,) [m/s], world: the mean, and the gust turned into its axes."""
        mx, my = float(self.mean[0]), float(self.mean[1])
        flat = hypot(mx, my)
        c, s = (mx / flat, my / flat) if flat > 0.0 else (1.0, 0.0)
        u, v, w = gust.along, gust.across[1], gust.up[1]
        return np.array((mx + c * u - s * v, my + s * u + c * v, float(self.mean[2]) + w))


CALM = Wind()


def low_altitude(mean: Vec3, height: float) -> Wind:
    """The gusts that MIL-F-8785C gives for this wind at this height (10 to 1000 ft, 3 to 305 m).

    Parameters
    ----------
    mean : Vec3
        Mean wind [m/s], world, (3,); taken as the wind at 6 m.
    height : float
        Above the ground [m].

    Raises
    ------
    BadInput
        The height is outside what the formula covers.
    """
    if not 3.0 <= height <= 305.0:
        raise BadInput(f"low_altitude: height is {height} m; MIL-F-8785C covers 3 to 305 m.")
    W = float(np.linalg.norm(vector(mean, "mean")))
    shape = 0.177 + 0.000823 * height / 0.3048
    side, up = 0.1 * W / shape**0.4, 0.1 * W
    L = height / shape**1.2
    return Wind(np.array(mean, dtype=float), np.array((side, side, up)), np.array((L, L, height)))


def gusts(wind: Wind, rng: np.random.Generator, dt: float) -> Iterator[Vec3]:
    """The velocity of the air (3,) [m/s], world, at 0, dt, 2 dt …; without end."""
    gust = wind.init(rng)
    air = wind.velocity(gust)
    while True:
        yield air
        gust, air = wind.step(gust, dt, rng)


def _pair(
    state: tuple[float, float], x: float, sigma: float, xi: list[float]
) -> tuple[float, float]:
    """Exact step of T ż = −z + n, T ẏ = −y + z + √3 (n − z) over x = dt / T; x = 0 from nothing draws the start.

    The noise of a step has covariance P − A P Aᵀ, because the gust's own covariance P must not change.
    """
    if x > 0.0:
        e = exp(-x)
        A = ((e, 0.0), (_B * x * e, e))
    else:
        A = ((0.0, 0.0), (0.0, 0.0))
    p00, p01, p11 = _P[0][0], _P[0][1], _P[1][1]
    q00 = p00 - A[0][0] ** 2 * p00
    q01 = p01 - A[0][0] * (A[1][0] * p00 + A[1][1] * p01)
    q11 = p11 - (A[1][0] ** 2 * p00 + 2.0 * A[1][0] * A[1][1] * p01 + A[1][1] ** 2 * p11)
    l00 = sqrt(q00)
    l10 = q01 / l00
    l11 = sqrt(max(q11 - l10 * l10, 0.0))
    z, y = state
    return (
        A[0][0] * z + sigma * l00 * xi[0],
        A[1][0] * z + A[1][1] * y + sigma * (l10 * xi[0] + l11 * xi[1]),
    )
