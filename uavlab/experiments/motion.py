"""Smooth flights without flying: a path, the attitude that thrust and drag ask for on it, and what instruments say.

The thrust axis follows from the path (flatness, with drag in it), so specific force, rates and attitude fit each other
exactly; no controller is between them. That is all a filter sees of a flight, at a hundredth of its price.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from uavlab.types import GRAVITY, Array, Field, Fix, Height, Imu

FIELD = np.array((
    0.0,
    0.42,
    -0.91,
))  # magnetic field of the earth at 50° north, in units of its size
PAPER_C = 0.0794  # Bangura Sec. V-A, linear
PAPER_PARTS = (0.00209, 0.02586)  # Bangura Sec. V-A, of V|V| and of V


class Motion(NamedTuple):
    """A flight, N ticks."""

    t: Array  # (N,) [s]
    r: Array  # (N, 3) [m], world
    v: Array  # (N, 3) [m/s], world
    R: Array  # (N, 3, 3) body → world
    omega: Array  # (N, 3) [rad/s], body: the mean rate until the next tick
    force: Array  # (N, 3) specific force [m/s²], body
    wind: Array  # (N, 3) [m/s], world

    @property
    def V(self) -> Array:
        """Velocity through the air (N, 3) [m/s], body."""
        return np.einsum("nji,nj->ni", self.R, self.v - self.wind)

    @property
    def dt(self) -> float:
        """Time between ticks [s]."""
        return float(self.t[1] - self.t[0])


class Noise(NamedTuple):
    """What the instruments add. Standard deviations, per sample; biases are drawn once for each flight. All ours."""

    accel: float = 0.05  # [m/s²]
    accel_bias: float = 0.02  # [m/s²], what zeroing in hover (Bangura V-A) leaves
    gyro: float = 0.003  # [rad/s]
    gyro_bias: float = 0.01  # [rad/s]
    field: float = 0.01  # of the earth's field
    height: float = 0.1  # [m], barometer
    velocity: float = 0.02  # [m/s], velocity over ground
    rate: float = 40.0  # [Hz] of the velocity over ground
    slow: float = 50.0  # [Hz] of magnetometer and barometer


QUIET = Noise()


def waves(t: Array, speeds: Array, periods: Array, phases: Array) -> tuple[Array, Array, Array]:
    """Position, velocity, acceleration (N, 3): on each axis one sine of this top speed [m/s] and period [s]."""
    w = 2.0 * np.pi / np.asarray(periods)
    angle = t[:, None] * w + np.asarray(phases)
    speeds = np.asarray(speeds)
    return -speeds / w * np.cos(angle), speeds * np.sin(angle), speeds * w * np.cos(angle)


def motion(
    t: Array, path: tuple[Array, Array, Array], heading: Array, wind: Array, c: float, parasitic: float = 0.0
) -> Motion:  # fmt: skip
    """The flight along a path in air that moves.

    Parameters
    ----------
    t : Array
        (N,) [s], evenly spaced.
    path : three Arrays
        Position [m], velocity [m/s], acceleration [m/s²], each (N, 3), world.
    heading : Array
        (N,) [rad].
    wind : Array
        (N, 3) [m/s], world.
    c : float
        Rotor drag [1/√m], Bangura eq. (3).
    parasitic : float
        Drag of the body [1/m]: acceleration per |v| v of the velocity through the air.
    """
    r, v, a = path
    air = v - wind
    whole = a + np.array((0.0, 0.0, GRAVITY))  # specific force, world
    pull = parasitic * np.linalg.norm(air, axis=1, keepdims=True) * air
    rotors = whole + pull  # what thrust and rotor drag must make
    up, lift = np.tile((0.0, 0.0, 1.0), (len(t), 1)), rotors[:, 2:]
    for _ in range(30):  # lift · up = rotors + c √lift (air − (air · up) up)
        across = air - np.sum(air * up, axis=1, keepdims=True) * up
        b = rotors + c * np.sqrt(lift) * across
        up = b / np.linalg.norm(b, axis=1, keepdims=True)
        lift = np.sum(rotors * up, axis=1, keepdims=True)
    R = _attitudes(up, heading)
    turn = np.einsum("nji,njk->nik", R[:-1], R[1:])
    omega = _small_logs(turn) / (t[1] - t[0])
    return Motion(
        t, r, v, R, np.concatenate((omega, omega[-1:])), np.einsum("nji,nj->ni", R, whole), wind
    )


def instruments(
    flown: Motion, rng: np.random.Generator, noise: Noise = QUIET, off: tuple[float, float] | None = None
) -> Iterator[dict[str, Any]]:  # fmt: skip
    """Readings at each tick: imu always; magnetometer, barometer and gnss at their rates; gnss not within `off` [s]."""
    n = len(flown.t)
    accel = (
        flown.force + rng.normal(0.0, noise.accel_bias, 3) + rng.normal(0.0, noise.accel, (n, 3))
    )
    gyro = flown.omega + rng.normal(0.0, noise.gyro_bias, 3) + rng.normal(0.0, noise.gyro, (n, 3))
    field = np.einsum("nji,j->ni", flown.R, FIELD) + rng.normal(0.0, noise.field, (n, 3))
    height = flown.r[:, 2] + rng.normal(0.0, noise.height, n)
    v = flown.v + rng.normal(0.0, noise.velocity, (n, 3))
    slow, fast = (max(round(1.0 / (f * flown.dt)), 1) for f in (noise.slow, noise.rate))
    for k, t in enumerate(flown.t.tolist()):
        readings: dict[str, Any] = {"imu": Imu(t, accel[k], gyro[k])}
        if k % slow == 0:
            readings["magnetometer"] = Field(t, field[k])
            readings["barometer"] = Height(t, float(height[k]))
        if k % fast == 0 and not (off and off[0] <= t < off[1]):
            readings["gnss"] = Fix(t, flown.r[k], v[k])
        yield readings


def _attitudes(up: Array, heading: Array) -> Array:
    """Attitudes (N, 3, 3) with these thrust axes (N, 3) and headings (N,) (MRS eq. 21-23, closed form)."""
    c, s = np.cos(heading), np.sin(heading)
    forward = np.stack((c, s, -(up[:, 0] * c + up[:, 1] * s) / up[:, 2]), axis=1)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    return np.stack((forward, np.cross(up, forward), up), axis=2)


def _small_logs(R: Array) -> Array:
    """Rotation vectors (N, 3) of turns (N, 3, 3) of less than a right angle."""
    w = 0.5 * np.stack(
        (R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]), axis=1
    )
    sine = np.linalg.norm(w, axis=1, keepdims=True)
    return w * np.where(
        sine > 1e-9, np.arcsin(np.minimum(sine, 1.0)) / np.maximum(sine, 1e-12), 1.0
    )
