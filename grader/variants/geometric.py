"""Lab 07, right answers written in other ways than the reference: all must get full marks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from grader.material import variant
from uavlab.exercises.geometric import (
    GeometricController,
    attitude_error,
    desired_force,
    disturbance_step,
    estimated_mass,
    jerk_feedforward,
    rate_command,
    scale_to_limits,
    torque_command,
    unbiased_acceleration,
)
from uavlab.frames import heading as heading_of
from uavlab.frames import moved
from uavlab.gains import gain_group
from uavlab.parts.controllers import Handover, fading
from uavlab.so3 import about_z, hat
from uavlab.types import Command

CANARY = "canary-18c6e5f0a7d24b6c93b2fe49"


@variant(attitude_error)
def by_quaternion(R, R_d):
    q = (Rotation.from_matrix(R_d).inv() * Rotation.from_matrix(R)).as_quat()
    return 2.0 * q[3] * q[:3]


@variant(attitude_error)
def by_cross_products(R, R_d):
    """Half of what turns each wanted axis into the flown one, told in the body."""
    return R.T @ sum(np.cross(R_d[:, i], R[:, i]) for i in range(3)) / 2


@variant(attitude_error)
def entry_by_entry(R, R_d):
    a, b, c = R.T
    x, y, z = R_d.T
    return [(z @ b - y @ c) / 2, (x @ c - z @ a) / 2, (y @ a - x @ b) / 2]


@variant(desired_force)
def axis_by_axis(estimate, reference, m_e, d_w, d_b, gains):
    f = np.zeros(3)
    eta = math.atan2(estimate.R[1, 0], estimate.R[0, 0])
    c, s = math.cos(eta), math.sin(eta)
    push = [d_w[0] + c * d_b[0] - s * d_b[1], d_w[1] + s * d_b[0] + c * d_b[1], -9.81 * m_e]
    for i in range(3):
        a = reference.a[i] + gains.k_p[i] * (reference.r[i] - estimate.r[i])
        a += gains.k_v[i] * (reference.v[i] - estimate.v[i])
        f[i] = m_e * a - push[i]
    return f


@variant(desired_force)
def term_by_term(estimate, reference, m_e, d_w, d_b, gains):
    K_p, K_v = np.diag(gains.k_p), np.diag(gains.k_v)
    nose = estimate.R[:, 0] * [1, 1, 0]
    nose = nose / np.linalg.norm(nose)
    H = np.column_stack([nose, np.cross([0, 0, 1], nose), [0, 0, 1]])
    feedback = -m_e * K_p @ (estimate.r - reference.r) - m_e * K_v @ (estimate.v - reference.v)
    ahead = m_e * reference.a + np.array([0, 0, m_e * 9.81])
    return feedback + ahead - np.diag([1, 1, 0]) @ (d_w + H @ d_b)


@variant(jerk_feedforward)
def by_the_axes(f_d, m_e, R_d, jerk_d):
    thrust = math.sqrt(f_d @ f_d) / m_e
    if not thrust:
        raise ValueError("no thrust")
    return np.array([-(R_d[:, 1] @ jerk_d) / thrust, R_d[:, 0] @ jerk_d / thrust, 0])


@variant(jerk_feedforward)
def by_the_world(f_d, m_e, R_d, jerk_d):
    """The axis turns in the world by b3 × j over thrust per mass; told in the wanted axes."""
    if not np.any(f_d):
        raise ValueError("f_d is zero")
    return R_d.T @ (m_e * np.cross(f_d, jerk_d) / (f_d @ f_d))


@variant(jerk_feedforward)
def corrected_print(f_d, m_e, R_d, jerk_d):
    along = float(f_d @ R_d[:, 2])
    if along == 0:
        raise ValueError("no force")
    return (m_e / along) * (hat(np.array([0.0, 0.0, 1.0])) @ R_d.T @ jerk_d)


@variant(rate_command)
def by_lab_02(R, R_d, heading_rate_d, omega_j, k_R):
    E = 0.5 * (R_d.T @ R - R.T @ R_d)
    w = np.array(omega_j) - np.array(k_R) * np.array([E[2, 1], E[0, 2], E[1, 0]])
    shadow = R_d[0, 0] ** 2 + R_d[1, 0] ** 2
    ahead = heading_rate_d * shadow / R_d[2, 2] if abs(R_d[2, 2]) > 1e-6 else 0.0
    turned = w[1] * R[2, 1] / (R[0, 0] ** 2 + R[1, 0] ** 2)
    undo = -turned * (R[0, 0] ** 2 + R[1, 0] ** 2) / R[2, 2] if abs(R[2, 2]) > 1e-6 else 0.0
    return w + np.array([0.0, 0.0, ahead + undo])


@variant(rate_command)
def one_yaw_rate(R, R_d, heading_rate_d, omega_j, k_R):
    q = (Rotation.from_matrix(R).inv() * Rotation.from_matrix(R_d)).as_quat()
    roll, pitch, yaw = omega_j + k_R * 2 * q[3] * q[:3]
    if abs(R_d[2, 2]) >= 1e-6:
        yaw += heading_rate_d * (1 - R_d[2, 0] ** 2) / R_d[2, 2]
    if abs(R[2, 2]) >= 1e-6:
        yaw -= pitch * R[2, 1] / R[2, 2]
    return [roll, pitch, yaw]


@variant(disturbance_step)
def number_by_number(d_w, d_b, e_p, heading, dt, gains):
    c, s = math.cos(heading), math.sin(heading)
    seen = (c * e_p[0] + s * e_p[1], c * e_p[1] - s * e_p[0])
    w, b = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
    for i in (0, 1):
        w[i] = max(-gains.d_max, min(gains.d_max, d_w[i] + gains.k_iw * e_p[i] * dt))
        b[i] = max(-gains.d_max, min(gains.d_max, d_b[i] + gains.k_ib * seen[i] * dt))
    return w, b


@variant(disturbance_step)
def as_complex_numbers(d_w, d_b, e_p, heading, dt, gains):
    e = dt * complex(e_p[0], e_p[1])
    w = complex(d_w[0], d_w[1]) + gains.k_iw * e
    b = complex(d_b[0], d_b[1]) + gains.k_ib * e * np.exp(-1j * heading)
    both = np.array([[w.real, w.imag, 0.0], [b.real, b.imag, 0.0]])
    return tuple(np.clip(both, -gains.d_max, gains.d_max))


@variant(estimated_mass)
def with_clip(m_e, e_z, dt, m, gains):
    low = max(m - gains.m_max, m / 10)
    return np.clip(m_e + dt * gains.k_m * -e_z, low, m + gains.m_max)


@variant(estimated_mass)
def by_comparison(m_e, e_z, dt, m, gains):
    extra = m_e - m - gains.k_m * dt * e_z
    if extra > gains.m_max:
        return m + gains.m_max
    if extra < -gains.m_max:
        extra = -gains.m_max
    return m + extra if m + extra > 0.1 * m else 0.1 * m


@variant(unbiased_acceleration)
def as_a_sum(f_d, R, d_w, d_b, m_e):
    d = d_w + about_z(heading_of(R)) @ d_b
    a = f_d / m_e * R @ [0.0, 0.0, 1.0]
    return a + np.array([d[0] / m_e, d[1] / m_e, -9.81])


@variant(unbiased_acceleration)
def printed_with_the_mass(f_d, R, d_w, d_b, m_e):
    x, y = R[0, 0], R[1, 0]
    H = np.array([[x, -y, 0], [y, x, 0], [0, 0, 0]]) / math.hypot(x, y)
    return (f_d * R[:, 2] - [0, 0, m_e * 9.81] + d_w * [1, 1, 0] + H @ d_b) / m_e


@variant(torque_command)
def with_matrices(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    S = R.T @ R_d
    E = (S - S.T) / 2
    W = hat(omega)
    pid = np.diag(gains.k_R) @ [E[2, 1], E[0, 2], E[1, 0]] + np.diag(gains.k_iR) @ integral
    pid = pid + np.diag(gains.k_omega) @ (S @ omega_d - omega)
    return pid + W @ J @ omega + J @ (S @ omega_dot_d - W @ S @ omega_d)


@variant(torque_command)
def by_turning_first(R, R_d, omega, omega_d, omega_dot_d, integral, J, gains):
    """Everything that is wanted, told in the body; the error from a quaternion."""
    Q = Rotation.from_matrix(R).inv() * Rotation.from_matrix(R_d)
    q = Q.as_quat()
    w, a = Q.apply(omega_d), Q.apply(omega_dot_d)
    tau = []
    momentum, wanted = J @ omega, J @ (a + np.cross(w, omega))
    gyro = np.cross(omega, momentum)
    for i in range(3):
        pid = gains.k_R[i] * 2 * q[3] * q[i] + gains.k_iR[i] * integral[i]
        tau.append(pid + gains.k_omega[i] * (w[i] - omega[i]) + gyro[i] + wanted[i])
    return tau


@variant(scale_to_limits)
def rotor_by_rotor(u, u_gravity, allocation, f_min, f_max):
    A = np.linalg.pinv(allocation)
    share = 1.0
    for now, then in zip(A @ u_gravity, A @ u, strict=True):
        if now > f_max + 1e-9 or now < f_min - 1e-9:
            raise ValueError("cannot hover")
        if then > f_max:
            share = min(share, (f_max - now) / (then - now))
        if then < f_min:
            share = min(share, (now - f_min) / (now - then))
    return (1.0 - share) * u_gravity + share * u


@variant(scale_to_limits)
def by_bisection(u, u_gravity, allocation, f_min, f_max):
    """The share at which the rotor that is worst off has no room left."""

    def thrusts(share):
        wish = u_gravity + share * (u - u_gravity)
        return np.linalg.lstsq(allocation, wish)[0]

    def room(share):
        f = thrusts(share)
        return min((f_max - f).min(), (f - f_min).min())

    if room(0.0) < -1e-9:
        raise ValueError("cannot hover")
    share = 1.0 if room(1.0) >= 0.0 else brentq(room, 0.0, 1.0, xtol=1e-14, rtol=1e-14)
    return u_gravity + share * (u - u_gravity)


@variant(GeometricController)
@dataclass(frozen=True)
class PartOfParts:
    """A memory that is a dictionary, the course's own hand-over, and the pieces from above."""

    mass: float
    gains: object = gain_group("now", "soft")

    def init(self, estimate, last):
        return {"m": self.mass, "w": np.zeros(3), "b": np.zeros(3), "hand": Handover(last, None)}

    def step(self, memory, estimate, reference, dt):
        k, R, m = self.gains, estimate.R, memory["m"]
        f = axis_by_axis.run(estimate, reference, m, memory["w"], memory["b"], k)
        f[2] = max(f[2], 1.0)
        lean = math.atan2(math.hypot(f[0], f[1]), f[2])
        if lean > k.tilt_max:
            f[:2] *= math.tan(k.tilt_max) / math.tan(lean)
        b3 = f / np.linalg.norm(f)
        c, s = math.cos(reference.heading), math.sin(reference.heading)
        b1 = np.array([c, s, -(b3[0] * c + b3[1] * s) / b3[2]])
        b1 = b1 / np.linalg.norm(b1)
        R_d = np.column_stack([b1, np.cross(b3, b1), b3])
        ahead = by_the_axes.run(f, m, R_d, reference.j)
        w = by_lab_02.run(R, R_d, reference.heading_rate, ahead, k.k_R)
        w = np.maximum(np.minimum(w, k.rate_max), -np.array(k.rate_max))
        thrust = f @ R[:, 2]
        command = Command(thrust, w, as_a_sum.run(thrust, R, memory["w"], memory["b"], m))
        e = estimate.r - reference.r
        new_w, new_b = number_by_number.run(memory["w"], memory["b"], e, heading_of(R), dt, k)
        hand, command = fading(memory["hand"], command, dt, 0.5)
        new = {"m": by_comparison.run(m, e[2], dt, self.mass, k), "hand": hand}
        return {**new, "w": np.array(new_w), "b": np.array(new_b)}, command

    def reframe(self, memory, shift):
        hand = Handover(*(None if x is None else moved(x, shift) for x in memory["hand"]))
        return {**memory, "w": about_z(shift.heading) @ memory["w"], "hand": hand}


@variant(GeometricController)
class Plain:
    """No dataclass, a memory that is a list of numbers, and the disturbances kept as complex ones."""

    def __init__(self, mass, gains=None):
        self.mass, self.k = mass, gains or gain_group("now", "soft")

    def init(self, estimate, last):
        start = None if last is None else np.concatenate(([last.f_d], last.omega_d, last.a_d))
        return [self.mass, 0j, 0j, start, np.zeros(7)]

    def step(self, memory, estimate, reference, dt):
        m, w, b, start, rest = memory
        k, R = self.k, estimate.R
        turn = complex(R[0, 0], R[1, 0])
        turn /= abs(turn)
        push = w + turn * b
        d = np.array([push.real, push.imag, 0.0])
        f = term_by_term.run(estimate, reference, m, d, np.zeros(3), k)
        f[2] = max(f[2], 1.0)
        flat, most = np.linalg.norm(f[:2]), f[2] * np.tan(k.tilt_max)
        if flat > most:
            f[:2] *= most / flat
        y = np.cross(f, [np.cos(reference.heading), np.sin(reference.heading), 0.0])
        side = np.array([-np.sin(reference.heading), np.cos(reference.heading), 0.0])
        x = np.cross(side, f)
        R_d = np.column_stack([v / np.linalg.norm(v) for v in (x, np.cross(f, x), f)])
        assert y @ R_d[:, 1] > 0
        rates = one_yaw_rate.run(
            R,
            R_d,
            reference.heading_rate,
            by_the_world.run(f, m, R_d, reference.j),
            np.array(k.k_R),
        )
        rates = np.sign(rates) * np.minimum(np.abs(rates), k.rate_max)
        thrust = float(R[:, 2] @ f)
        a = (thrust * R[:, 2] + d) / m - [0, 0, 9.81]
        own = np.concatenate(([thrust], rates, a))
        rest = rest * np.exp(-2.0 * dt) if start is None else start - own
        said = own + rest
        e = estimate.r - reference.r
        step = dt * complex(e[0], e[1])
        w, b = self.boxed(w + k.k_iw * step), self.boxed(b + k.k_ib * step / turn)
        m = with_clip.run(m, e[2], dt, self.mass, k)
        return [m, w, b, None, rest], Command(said[0], said[1:4], said[4:])

    def boxed(self, z):
        high = self.k.d_max
        return complex(max(min(z.real, high), -high), max(min(z.imag, high), -high))

    def reframe(self, memory, shift):
        m, w, b, start, rest = memory
        turned = [
            None if x is None else np.concatenate((x[:4], about_z(shift.heading) @ x[4:]))
            for x in (start, rest)
        ]
        return [m, w * np.exp(1j * shift.heading), b, *turned]
