"""Made-up test benches and flights for the checks of lab 05: what was measured, when the truth is known."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from uavlab import so3
from uavlab.exercises import draw
from uavlab.types import Array, Mat3, Vec3

FOUR = ((0.0, 0.0, 0.0), (1.4, 0.0, 0.0), (0.0, 1.4, 0.0), (-1.6, 0.0, 0.0))  # turns [rad]
DOWN = np.array((0.0, 0.0, -9.81))  # gravity [m/s²], world


class Sensor(NamedTuple):
    """An accelerometer as it is mounted: true specific force = T (reading − b)."""

    T: Mat3  # (3, 3) scale and mounting
    b: Vec3  # (3,) offset [m/s²], in the sensor's own axes


def sensor(rng: np.random.Generator) -> Sensor:
    """An accelerometer that is scaled, skewed, mounted askew, and offset."""
    T = so3.exp(draw.vector(rng, 0.15)) @ (np.eye(3) + rng.uniform(-0.06, 0.06, size=(3, 3)))
    return Sensor(T, draw.vector(rng, 0.4))


def attitudes(rng: np.random.Generator, n: int) -> Array:
    """Orientations body → world, shape (n, 3, 3), all around: the first four suffice."""
    R = draw.rotation(rng)
    first = [so3.exp(turn) @ R for turn in np.array(FOUR)]
    return np.array([*first, *(draw.rotation(rng) for _ in range(n - 4))])


def at_rest(made: Sensor, R: Array) -> Array:
    """Readings [m/s²], shape (n, 3), of an accelerometer that stands still in the orientations `R`, (n, 3, 3)."""
    force = -DOWN @ R
    return np.linalg.solve(made.T, force.T).T + made.b


def lag(t: Array, command: Array, tau: float, start: float) -> Array:
    """Speed of a first-order lag at the times `t` [s]; each command is held until the next sample."""
    x = [start]
    for dt, c in zip(np.diff(t), command[:-1], strict=True):
        x.append(c + (x[-1] - c) * np.exp(-dt / tau))
    return np.array(x)


def stick(rng: np.random.Generator, t: Array) -> Array:
    """A reference [rad] at the times `t` [s] that moves at several speeds, up to 2 Hz and some 10 degrees."""
    paces = 2.0 * np.pi * np.array((0.15, 0.35, 0.6, 1.0, 1.5, 2.0)) * rng.uniform(0.9, 1.1, size=6)
    turns = np.outer(t - t[0], paces) + rng.uniform(-np.pi, np.pi, size=6)
    return np.sin(turns) @ (np.array((0.08, 0.06, 0.05, 0.05, 0.04, 0.03)))


def loop(t: Array, reference: Array, b_0: float, b_1: float, b_r: float) -> Array:
    """Tilt [rad] of θ̈ = −b_0 θ − b_1 θ̇ + b_r θ^r from rest at even times `t`, the reference joined by lines."""
    dt, half = float(t[1] - t[0]), 0.5 * b_1
    # Around the ramp θ = (b_r / b_0) (θ^r − b_1 / b_0 θ̇^r) the tilt swings freely: with e^{A dt}, exactly.
    n = np.sqrt(complex(b_0 - half * half))
    fade, c, s = np.exp(-half * dt), np.cos(n * dt).real, (dt * np.sinc(n * dt / np.pi)).real
    gain, x, v, said = b_r / b_0, 0.0, 0.0, [0.0]
    for r, r_next in pairwise(reference.tolist()):
        pace = gain * (r_next - r) / dt
        off, slip = x - gain * r + pace * b_1 / b_0, v - pace
        x = gain * r_next - pace * b_1 / b_0 + fade * ((c + s * half) * off + s * slip)
        v = pace + fade * ((c - s * half) * slip - s * b_0 * off)
        said.append(x)
    return np.array(said)


def closed_loop(rng: np.random.Generator) -> tuple[float, float, float]:
    """Numbers (b_0, b_1, b_r) of an attitude loop: 4 to 9 rad/s, well or badly damped, gain near one."""
    pace, damping, gain = rng.uniform(4.0, 9.0), rng.uniform(0.4, 1.0), rng.uniform(0.85, 1.15)
    return float(pace**2), float(2.0 * damping * pace), float(gain * pace**2)


def sweep(rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Velocities (n, 2) [m/s] to and fro along both body axes, and vertical specific forces (n,) [m/s²]."""
    return rng.uniform(-9.0, 9.0, size=(n, 2)), rng.uniform(6.0, 15.0, size=n)
