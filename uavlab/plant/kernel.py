"""The compiled world: one call per control tick, with the rate loop, motors, body and ground inside."""

from __future__ import annotations

from math import exp, sqrt

import numpy as np

from uavlab.plant.autopilot import mix, rate_loop
from uavlab.plant.constants import Constants
from uavlab.plant.dynamics import acceleration, step_body
from uavlab.plant.jit import entry, kernel
from uavlab.plant.vectors import V, dot, matrix, orthonormal, vector
from uavlab.plant.world import World
from uavlab.types import Array


@kernel
def half_lag(speed: Array, thrust: Array, keep: float, c: Constants) -> None:
    """Move `speed` (n,) [rad/s] towards what gives `thrust` (n,) [N]; `keep` of the distance is left (Spica §5.3)."""
    for i in range(speed.size):
        target = sqrt(thrust[i] / c.thrust_coefficient)
        speed[i] = target + (speed[i] - target) * keep


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
    world: World, f_d: float, omega_d: V, wind: V, c: Constants, dt: float, n: int
) -> World:
    """`world` after `n` inner steps that last `dt` [s] together; see `uavlab.plant.CompiledPlant.advance`.

    One inner step: the rate loop reads ω and commands the motors; the motors lag for half the step; the body moves under
    that thrust and torque; the motors lag for the other half.
    """
    r, v, R, omega = vector(world.r), vector(world.v), matrix(world.R), vector(world.omega)
    J, J_inv, gain = matrix(c.J), matrix(c.J_inv), vector(c.rate_gain)
    speed, asked = world.speed.copy(), np.empty(world.speed.size)
    contact, impact = world.contact, 0.0
    h = dt / n
    keep = exp(-0.5 * h / c.motor_tau)
    zero = (0.0, 0.0, 0.0)
    for _ in range(n):
        mix(f_d, rate_loop(omega, omega_d, gain, J), c, asked)
        half_lag(speed, asked, keep, c)
        f, tau = wrench(speed, c)
        if contact and acceleration(zero, R, f, wind, c)[2] > 0.0:
            contact = False  # thrust carries it: take-off
        if not contact:
            r, v, R, omega = step_body(r, v, R, omega, f, tau, wind, c, J, J_inv, h)
            if r[2] < 0.0:
                impact = max(impact, sqrt(dot(v, v)))
                r, v, omega, contact = (r[0], r[1], 0.0), zero, zero, True
        half_lag(speed, asked, keep, c)
    R = orthonormal(R)
    f, tau = wrench(speed, c)
    a = zero if contact else acceleration(v, R, f, wind, c)
    return World(
        world.t + dt,
        np.array(r),
        np.array(v),
        np.array(R),
        np.array(omega),
        speed,
        np.array(a),
        contact,
        impact,
    )
