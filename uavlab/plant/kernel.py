"""The compiled world: one call per control tick, with the rate loop, motors, body and ground inside."""

from __future__ import annotations

from math import exp, sqrt

import numpy as np

from uavlab.plant.autopilot import mix, rate_loop
from uavlab.plant.constants import Constants, unpacked
from uavlab.plant.dynamics import acceleration, step_body
from uavlab.plant.jit import entry, kernel
from uavlab.plant.vectors import ZERO, V, dot, matrix, orthonormal, three
from uavlab.plant.world import SPEED
from uavlab.types import Array


@kernel
def half_lag(speed: Array, thrust: Array, keep: float, c: Constants) -> None:
    """Move `speed` (n,) [rad/s] towards what gives `thrust` (n,) [N]; `keep` of the distance is left (Spica §5.3)."""
    for i in range(speed.size):
        target = sqrt(thrust[i] / c.thrust_coefficient)
        speed[i] = target + (speed[i] - target) * keep


@kernel
def weaken(thrust: Array, asked: Array) -> None:
    """Leave of each rotor's `thrust` (n,) [N] the share that its motor makes; `asked` as in `advance`."""
    for i in range(thrust.size):
        thrust[i] *= asked[7 + i]


@kernel
def wrench(speed: Array, c: Constants) -> tuple[float, V]:
    """Collective thrust [N] and torque [N m], body, of rotors at `speed` (n,) [rad/s] (Spica eq. 1)."""
    f, x, y, z = 0.0, 0.0, 0.0, 0.0
    for i in range(speed.size):
        thrust = c.thrust_coefficient * speed[i] * speed[i]
        f += c.allocation[0, i] * thrust
        x += c.allocation[1, i] * thrust
        y += c.allocation[2, i] * thrust
        z += c.allocation[3, i] * thrust
    return f, (x, y, z)


@entry
def advance(
    r: Array, v: Array, R: Array, omega: Array, speed: Array, contact: bool,
    asked: Array, numbers: Array, allocation: Array, mixer: Array, dt: float, n: int, out: Array,
) -> tuple[bool, float]:  # fmt: skip
    """Write into `out` the world after `n` inner steps that last `dt` [s] together; return contact and impact.

    `asked` (7 + rotors,): thrust, rates, wind, and the share of its thrust that each motor still makes.

    One inner step: the rate loop reads ω and commands the motors; the motors lag for half the step; the body moves
    under that thrust and torque; the motors lag for the other half. Plain arrays, because NamedTuples at this border
    would cost more than the flight inside; see `constants.pack` for `numbers` and `world.unpack` for `out`.
    """
    c = unpacked(numbers, allocation, mixer)
    body = (three(r, 0), three(v, 0), matrix(R), three(omega, 0))
    f_d, omega_d, wind = asked[0], three(asked, 1), three(asked, 4)
    speeds, thrust = out[SPEED:], np.empty(speed.size)
    for i in range(speed.size):
        speeds[i] = speed[i]
    impact, h = 0.0, dt / n
    keep = exp(-0.5 * h / c.motor_tau)
    for _ in range(n):
        mix(f_d, rate_loop(body[3], omega_d, c), c, thrust)
        weaken(thrust, asked)
        half_lag(speeds, thrust, keep, c)
        f, tau = wrench(speeds, c)
        if contact and acceleration(ZERO, body[2], f, wind, c)[2] > 0.0:
            contact = False  # thrust carries it: take-off
        if not contact:
            body = step_body(body, f, tau, wind, c, h)
            if body[0][2] < 0.0:
                impact = max(impact, sqrt(dot(body[1], body[1])))
                body, contact = ((body[0][0], body[0][1], 0.0), ZERO, body[2], ZERO), True
        half_lag(speeds, thrust, keep, c)
    f, tau = wrench(speeds, c)
    r_, v_, R_, omega_ = body[0], body[1], orthonormal(body[2]), body[3]
    a = ZERO if contact else acceleration(v_, R_, f, wind, c)
    for i in range(3):
        out[i], out[3 + i], out[15 + i], out[18 + i] = r_[i], v_[i], omega_[i], a[i]
        for j in range(3):
            out[6 + 3 * i + j] = R_[i][j]
    return contact, impact
