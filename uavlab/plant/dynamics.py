"""The rigid body in air, compiled: forces, and one step of a fourth-order method on SO(3)."""

from __future__ import annotations

from math import sqrt
from typing import TypeAlias

from uavlab.plant.constants import Constants
from uavlab.plant.jit import kernel
from uavlab.plant.vectors import (
    ZERO,
    M,
    V,
    apply,
    apply_transposed,
    cross,
    dot,
    exp,
    plus,
    times,
    weighted,
)
from uavlab.types import GRAVITY

Body: TypeAlias = tuple[V, V, M, V]  # r, v, R, ω as in `uavlab.types.State`


@kernel
def acceleration(v: V, R: M, f: float, wind: V, c: Constants) -> V:
    """v̇ [m/s²], world: thrust, gravity, and the drag of body and rotors in moving air (MRS eq. 1).

    Rotors drag across their axis with the root of thrust (Bangura eq. 3), the body with the square of airspeed.
    """
    air = plus(v, -1.0, wind)
    V_B = apply_transposed(R, air)
    k = c.drag_rotor * sqrt(c.m * max(f, 0.0))
    F = apply(R, (-k * V_B[0], -k * V_B[1], f))
    q = c.drag_body * sqrt(dot(air, air))
    return (
        (F[0] - q * air[0]) / c.m,
        (F[1] - q * air[1]) / c.m,
        (F[2] - q * air[2]) / c.m - GRAVITY,
    )


@kernel
def spin_up(omega: V, tau: V, c: Constants) -> V:
    """ω̇ [rad/s²], body, from J ω̇ + ω × J ω = τ (Spica eq. 3)."""
    return apply(c.J_inv, plus(tau, -1.0, cross(omega, apply(c.J, omega))))


@kernel
def step_body(x: Body, f: float, tau: V, wind: V, c: Constants, dt: float) -> Body:
    """Position, velocity, rotation and body rates after `dt` [s] of constant thrust f [N] and torque τ [N m].

    Runge-Kutta of fourth order for r, v and ω; for R its commutator-free companion (Celledoni, Marthinsen, Owren 2003),
    which only turns R by constant rates and so never leaves SO(3).
    """
    r, v, R, omega = x
    h, k = dt / 2.0, dt / 12.0
    a1, b1 = acceleration(v, R, f, wind, c), spin_up(omega, tau, c)

    v2, o2 = plus(v, h, a1), plus(omega, h, b1)
    R2 = times(R, exp(plus(ZERO, h, omega)))
    a2, b2 = acceleration(v2, R2, f, wind, c), spin_up(o2, tau, c)

    v3, o3 = plus(v, h, a2), plus(omega, h, b2)
    R3 = times(R, exp(plus(ZERO, h, o2)))
    a3, b3 = acceleration(v3, R3, f, wind, c), spin_up(o3, tau, c)

    v4, o4 = plus(v, dt, a3), plus(omega, dt, b3)
    R4 = times(R2, exp(plus(plus(ZERO, dt, o3), -h, omega)))
    a4, b4 = acceleration(v4, R4, f, wind, c), spin_up(o4, tau, c)

    mean = (2.0 * k, 4.0 * k, 4.0 * k, 2.0 * k)
    early = weighted((3.0 * k, 2.0 * k, 2.0 * k, -k), omega, o2, o3, o4)
    late = weighted((-k, 2.0 * k, 2.0 * k, 3.0 * k), omega, o2, o3, o4)
    return (
        plus(r, 1.0, weighted(mean, v, v2, v3, v4)),
        plus(v, 1.0, weighted(mean, a1, a2, a3, a4)),
        times(times(R, exp(early)), exp(late)),
        plus(omega, 1.0, weighted(mean, b1, b2, b3, b4)),
    )
