"""Lab 01, the reference answers: rigid body, rotors, motors, thrust curve.

Papers: MRS is Baca et al. 2021, Spica is Spica et al. 2013. Numbers in comments are their equations.
"""

# canary-5777c5ad8ed067f06b8e038e

from __future__ import annotations

import numpy as np

from uavlab.so3 import exp, hat
from uavlab.types import Array, Mat3, State, StateRate, Vec3


def rigid_body_rate(state: State, force: Vec3, torque: Vec3, *, m: float, J: Mat3) -> StateRate:
    """Time derivative of the state of a rigid body (MRS eq. 1, 2; Spica eq. 3)."""
    R, omega = state.R, state.omega
    v_dot = force / m  # MRS (1): m r̈ = f R e3 − m g e3, the right side summed by the caller
    R_dot = R @ hat(omega)  # MRS (2): Ṙ = R Ω
    gyroscopic = hat(omega) @ J @ omega
    omega_dot = np.linalg.solve(J, torque - gyroscopic)  # Spica (3): J ω̇ + [ω]× J ω = τ
    return StateRate(state.v, v_dot, R_dot, omega_dot)


def step_on_so3(R: Mat3, omega: Vec3, dt: float) -> Mat3:
    """Rotation after `dt` seconds of a constant body rate (MRS eq. 2)."""
    return R @ exp(omega * dt)  # Ṙ = R Ω with constant Ω has the solution R exp(Ω t)


def allocation_matrix(angles: Array, arm: float, torque_ratio: float, spins: Array) -> Array:
    """Rotor thrusts → collective thrust and torque, for any layout (Spica eq. 1)."""
    return np.stack((  # Spica (1): one column for each rotor
        np.ones_like(angles),
        arm * np.sin(angles),  # τ_x = y f
        -arm * np.cos(angles),  # τ_y = −x f
        torque_ratio * spins,
    ))  # fmt: skip


def rotor_thrusts(f: float, tau: Vec3, allocation: Array) -> Array:
    """Least-norm rotor thrusts for a collective thrust and a torque (Spica Sec. 4)."""
    u = np.array((f, *tau))
    return np.linalg.pinv(allocation) @ u  # M⁻¹ u; with n > 4 the pseudo-inverse has least norm


def motor_step(speed: Array, command: Array, tau: float, dt: float) -> Array:
    """Exact first-order lag (Spica Sec. 5.3)."""
    return command + (speed - command) * np.exp(-dt / tau)


def throttle_from_force(f: float, a_t: float, b_t: float) -> float:
    """Thrust force → throttle (MRS eq. 32)."""
    return float(a_t * np.sqrt(max(f, 0.0)) + b_t)  # MRS (32)


def force_from_throttle(T: float, a_t: float, b_t: float) -> float:
    """Throttle → thrust force (MRS eq. 32, inverted)."""
    return (
        max((T - b_t) / a_t, 0.0) ** 2
    )  # MRS (34) without 1/g; below b_t the square would rise again


def apparent_mass(T: float, a_t: float, b_t: float, g: float) -> float:
    """Mass that hovers at this throttle (MRS eq. 34)."""
    return force_from_throttle(T, a_t, b_t) / g  # MRS (34)
