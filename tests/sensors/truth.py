"""Something true for an instrument to look at."""

from typing import Any, NamedTuple

import numpy as np

from uavlab import so3


class Seen(NamedTuple):
    """The fields of a world that can be sensed."""

    t: float
    r: np.ndarray
    v: np.ndarray
    R: np.ndarray
    omega: np.ndarray
    a: np.ndarray


def at_rest(t: float = 0.0) -> Seen:
    """Standing at the origin."""
    return Seen(t, np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))


def drifting(t: float) -> Seen:
    """Turned, accelerating, and somewhere else at each time."""
    r, v, a = np.array((t, 2 * t, -t)), np.array((1.0, 2.0, -1.0)), np.array((1.0, -2.0, 3.0))
    return Seen(t, r, v, so3.exp(np.array((0.3, -0.2, t))), np.array((0.1, 0.2, t)), a)


def watch(sensor: Any, ticks: int, *, seed: int = 0, dt: float = 0.01, see: Any = at_rest) -> list:
    """What arrives in each tick, or None."""
    rng = np.random.default_rng(seed)
    memory, arrived = sensor.init(rng), []
    t = 0.0
    for _ in range(ticks):
        memory, reading = sensor.step(memory, see(t), dt, rng)
        arrived.append(reading)
        t += dt  # as a flight counts: rounding included
    return arrived


def spread(n: int) -> float:
    """How far the standard deviation of `n` independent samples may lie off, as a share: four of its own."""
    return 4.0 / np.sqrt(2.0 * n)


def kept(arrived: list) -> list:
    """Only the ticks in which something arrived."""
    return [x for x in arrived if x is not None]
