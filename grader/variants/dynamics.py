"""Lab 01, right answers written in other ways than the reference: all must get full marks."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm, lstsq
from scipy.spatial.transform import Rotation

from grader.material import variant
from uavlab.exercises.dynamics import (
    allocation_matrix,
    apparent_mass,
    force_from_throttle,
    motor_step,
    rigid_body_rate,
    rotor_thrusts,
    step_on_so3,
    throttle_from_force,
)

CANARY = "canary-5fba2d9b0392bea7e6fffc77"


@variant(rigid_body_rate)
def momentum_in_the_world(state, force, torque, *, m, J):
    """Through the angular momentum in the world, as a plain tuple of lists."""
    R, w = state.R, state.omega
    w_world = R @ w
    J_world = R @ J @ R.T
    turning = np.linalg.inv(J_world) @ (R @ torque - np.cross(w_world, J_world @ w_world))
    R_dot = np.column_stack([np.cross(w_world, R[:, k]) for k in range(3)])
    return list(state.v), [x / m for x in force], R_dot.tolist(), (R.T @ turning).tolist()


@variant(rigid_body_rate)
def entry_by_entry(state, force, torque, *, m, J):
    p, q, r = state.omega
    Omega = np.array([[0, -r, q], [r, 0, -p], [-q, p, 0]])
    h = J.dot(state.omega)
    gyro = np.array([q * h[2] - r * h[1], r * h[0] - p * h[2], p * h[1] - q * h[0]])
    return (
        state.v.copy(),
        np.divide(force, m),
        state.R.dot(Omega),
        np.linalg.inv(J).dot(torque - gyro),
    )


@variant(step_on_so3)
def through_scipy(R, omega, dt):
    return (Rotation.from_matrix(R) * Rotation.from_rotvec(omega * dt)).as_matrix()


@variant(step_on_so3)
def matrix_exponential(R, omega, dt):
    x, y, z = omega * dt
    return R @ expm(np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]))


@variant(step_on_so3)
def through_a_quaternion(R, omega, dt):
    half = 0.5 * dt * np.sqrt(omega @ omega)
    x, y, z = 0.5 * dt * np.sinc(half / np.pi) * omega
    w = np.cos(half)
    turn = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip
    return R @ turn


@variant(allocation_matrix)
def crossed_rotor_by_rotor(angles, arm, torque_ratio, spins):
    M = np.zeros((4, len(angles)))
    for k, (angle, spin) in enumerate(zip(angles, spins, strict=True)):
        place = np.array([arm * math.cos(angle), arm * math.sin(angle), 0.0])
        push = np.array([0.0, 0.0, 1.0])
        M[0, k] = 1.0
        M[1:, k] = np.cross(place, push) + spin * torque_ratio * push
    return M


@variant(allocation_matrix)
def by_complex_numbers(angles, arm, torque_ratio, spins):
    places = arm * np.exp(1j * np.asarray(angles))
    return [
        [1.0] * len(angles),
        places.imag.tolist(),
        (-places.real).tolist(),
        list(torque_ratio * spins),
    ]


@variant(rotor_thrusts)
def normal_equations(f, tau, allocation):
    u = np.concatenate(([f], tau))
    return allocation.T @ np.linalg.solve(allocation @ allocation.T, u)


@variant(rotor_thrusts)
def least_squares(f, tau, allocation):
    return lstsq(allocation, np.hstack((f, tau)))[0]


@variant(motor_step)
def share_that_is_closed(speed, command, tau, dt):
    return speed + (command - speed) * -math.expm1(-dt / tau)


@variant(motor_step)
def motor_by_motor(speed, command, tau, dt):
    left = math.exp(-dt / tau)
    return [left * s + (1.0 - left) * c for s, c in zip(speed, command, strict=True)]


@variant(motor_step)
def integrated(speed, command, tau, dt):
    if dt == 0.0:
        return speed
    gap = solve_ivp(
        lambda t, x: -x, (0.0, dt / tau), [1.0], method="DOP853", rtol=1e-13, atol=1e-15
    )
    return command + (speed - command) * gap.y[0, -1]


@variant(throttle_from_force)
def with_math(f, a_t, b_t):
    return b_t if f <= 0 else b_t + a_t * math.sqrt(f)


@variant(throttle_from_force)
def with_a_power(f, a_t, b_t):
    return np.array(b_t + (a_t * a_t * np.clip(f, 0.0, None)) ** 0.5)


@variant(force_from_throttle)
def with_a_branch(T, a_t, b_t):
    above = T - b_t
    if above <= 0:
        return 0
    return math.pow(above, 2) / math.pow(a_t, 2)


@variant(force_from_throttle)
def with_where(T, a_t, b_t):
    x = (T - b_t) / a_t
    return np.where(x > 0, x, 0) * x


@variant(apparent_mass)
def mass_with_a_branch(T, a_t, b_t, g):
    above = T - b_t
    return above**2 / (g * a_t**2) if above > 0 else 0.0


@variant(apparent_mass)
def mass_with_clip(T, a_t, b_t, g):
    return np.square(np.clip(T - b_t, 0.0, None) / a_t / np.sqrt(g))
