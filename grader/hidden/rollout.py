"""Small flights for hidden checks: a body is moved by the rates that an answer gives, step by step."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from uavlab.so3 import exp
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
