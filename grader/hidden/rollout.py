"""Small flights for hidden checks: a body is moved by the rates that an answer gives, step by step."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from uavlab.so3 import about_z, exp
from uavlab.types import Mat3, State, StateRate, Vec3

CANARY = "canary-44547d215bbbd8975cfedb58"

BodyRate = Callable[[float, Mat3], Vec3]  # time [s], rotation → angular velocity [rad/s], body


def turn(R: Mat3, rate: BodyRate, *, dt: float, steps: int) -> Iterator[tuple[float, Mat3]]:
    """Times and rotations of a body that turns with `rate`, by the midpoint rule: two calls a step."""
    for k in range(steps):
        t = k * dt
        halfway = R @ exp(0.5 * dt * rate(t, R))
        R = R @ exp(dt * rate(t + 0.5 * dt, halfway))
        yield t + dt, R


def wave(rng: np.random.Generator, size: float) -> Callable[[float], float]:
    """A smooth signal of time: a sine of about `size`, around one hertz."""
    amplitude, pace, phase = (
        size * rng.uniform(0.8, 1.2),
        rng.uniform(6.0, 9.0),
        rng.uniform(0.0, 6.0),
    )
    return lambda t: float(amplitude * np.sin(pace * t + phase))


class Swing:
    """A wild flight whose thrust axis leans 20 to 60 degrees, so that the heading is defined all along."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.pace, self.phase = rng.uniform(4.0, 7.0), rng.uniform(0.0, 6.0)
        self.start, self.round = (
            rng.uniform(0.0, 6.0),
            rng.uniform(1.0, 2.0) * rng.choice((-1.0, 1.0)),
        )
        self.R = self._lean(0.0) @ about_z(rng.uniform(0.0, 6.0))  # where it begins

    def _lean(self, t: float) -> Mat3:
        lean = np.radians(40.0 + 20.0 * np.sin(self.pace * t + self.phase))
        return about_z(self.start + self.round * t) @ exp(np.array((0.0, lean, 0.0)))

    def rate(self, t: float, R: Mat3) -> Vec3:
        """Angular velocity [rad/s], body, without yaw, that keeps the thrust axis of `R` on its way."""
        h = 1e-4
        velocity = (self._lean(t + h)[:, 2] - self._lean(t - h)[:, 2]) / (2.0 * h)
        return R.T @ np.cross(self._lean(t)[:, 2], velocity)


def runge_kutta(rate: Callable[[State], StateRate], x: State, dt: float) -> State:
    """One classical step of a rigid body, four calls. R leaves the group by dt⁵ only: small steps stay near."""

    def ahead(k: StateRate, h: float) -> State:
        return State(*(a + h * b for a, b in zip(x, k, strict=True)))

    k1 = rate(x)
    k2 = rate(ahead(k1, dt / 2))
    k3 = rate(ahead(k2, dt / 2))
    k4 = rate(ahead(k3, dt))
    slopes = zip(k1, k2, k3, k4, strict=True)
    return ahead(StateRate(*((a + 2 * b + 2 * c + d) / 6 for a, b, c, d in slopes)), dt)
