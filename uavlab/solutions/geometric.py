"""Lab 07, the reference answers: the controller that flies on SE(3), and a torque loop below it.

Papers: MRS is Baca et al. 2021, Spica is Spica et al. 2013. Numbers in comments are their equations; where the errata
correct one, the line says so. Errors are measured minus wanted here, as in MRS; Spica counts the other way.
"""

# canary-2f71c0be94d8a3561e07bb42

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab import frames
from uavlab.errors import BadInput
from uavlab.gains import GROUPS, GeometricGains, TorqueGains
from uavlab.interfaces import Memory
from uavlab.parts.controllers import Handover, fading, limited_tilt
from uavlab.so3 import about_z, hat, vee
from uavlab.types import GRAVITY, Array, Command, Estimate, Mat3, Reference, Shift, Vec3

E3 = np.array((0.0, 0.0, 1.0))
LIGHTEST = 0.1  # of the nominal mass: the software's limit exceeds the mass of a small aircraft
LOST = 1e-6  # |R33| below which no yaw rate turns the heading
FADE = 0.5  # [s] with which the difference to the command before us fades

# Attitude ---------------------------------------------------------------------------------------------


def attitude_error(R: Mat3, R_d: Mat3) -> Vec3:
    """Rotation error of Lee (MRS eq. 24)."""
    return vee(0.5 * (R_d.T @ R - R.T @ R_d))  # (24)


def jerk_feedforward(f_d: Vec3, m_e: float, R_d: Mat3, jerk_d: Vec3) -> Vec3:
    """Attitude rate that a jerk asks for (MRS eq. 26)."""
    size = float(np.linalg.norm(f_d))
    if size == 0.0:
        raise BadInput("f_d is zero: without thrust no attitude makes a jerk.")
    # (26), errata: m_e over ‖f_d‖, and no transpose
    return m_e / size * (hat(E3) @ (R_d.T @ jerk_d))


def rate_command(R: Mat3, R_d: Mat3, heading_rate_d: float, omega_j: Vec3, k_R: Vec3) -> Vec3:
    """Body rates: feedback, jerk, heading rate, and what roll and pitch make of the heading (MRS eq. 25)."""
    omega = -np.asarray(k_R) * attitude_error(R, R_d) + omega_j  # (25), first two terms
    omega[2] += _yaw_rate(R_d, heading_rate_d)  # (31), errata: missing in (25)
    parasitic = (omega[1] * R[2, 1]) / (1.0 - R[2, 0] ** 2)  # (15) of roll and pitch alone
    omega[2] += _yaw_rate(R, -parasitic)  # (25): −ω_c of Sec. 5.3
    return omega


def _yaw_rate(R: Mat3, heading_rate: float) -> float:
    """Yaw rate that makes a heading rate (MRS eq. 27-31, closed form); none where the nose is told nothing by it."""
    return heading_rate * (1.0 - R[2, 0] ** 2) / R[2, 2] if abs(R[2, 2]) > LOST else 0.0


def _attitude(f: Vec3, heading: float) -> Mat3:
    """Thrust along `f`, which points up, and the nose above the heading (MRS eq. 21-23, closed form)."""
    b3 = f / np.linalg.norm(f)
    nose = np.array((np.cos(heading), np.sin(heading), 0.0))
    b1 = nose - E3 * (nose @ b3) / b3[2]
    b1 = b1 / np.linalg.norm(b1)
    return np.array((b1, hat(b3) @ b1, b3)).T


# Force, disturbances and mass -------------------------------------------------------------------------


def desired_force(
    estimate: Estimate,
    reference: Reference,
    m_e: float,
    d_w: Vec3,
    d_b: Vec3,
    gains: GeometricGains,
) -> Vec3:
    """Force that closes position and velocity errors (MRS eq. 38)."""
    e_p, e_v = estimate.r - reference.r, estimate.v - reference.v
    a = reference.a - np.multiply(gains.k_p, e_p) - np.multiply(gains.k_v, e_v)
    return m_e * (a + GRAVITY * E3) - _pushed(estimate.R, d_w, d_b)  # (38), errata: d in N


def disturbance_step(
    d_w: Vec3, d_b: Vec3, e_p: Vec3, heading: float, dt: float, gains: GeometricGains
) -> tuple[Vec3, Vec3]:
    """Integrators of the disturbances, in the world and turning with the heading (MRS eq. 35)."""
    flat = np.array((e_p[0], e_p[1], 0.0))  # the height belongs to the mass
    seen = about_z(-heading) @ flat
    d_w = d_w + gains.k_iw * dt * flat  # (35)
    d_b = d_b + gains.k_ib * dt * seen  # (35), errata: no H in front of the sum
    return d_w.clip(-gains.d_max, gains.d_max), d_b.clip(-gains.d_max, gains.d_max)


def estimated_mass(m_e: float, e_z: float, dt: float, m: float, gains: GeometricGains) -> float:
    """One step of the mass that the height error tells (MRS eq. 37)."""
    m_e = m_e - gains.k_m * e_z * dt  # (37), errata: who is heavy sags, e_z < 0, and must gain mass
    return float(min(max(m_e, m - gains.m_max, LIGHTEST * m), m + gains.m_max))


def unbiased_acceleration(f_d: float, R: Mat3, d_w: Vec3, d_b: Vec3, m_e: float) -> Vec3:
    """What thrust and disturbances together do to the aircraft (MRS eq. 53)."""
    return (f_d * R[:, 2] + _pushed(R, d_w, d_b)) / m_e - GRAVITY * E3  # (53), errata: m_e g, not g


def _pushed(R: Mat3, d_w: Vec3, d_b: Vec3) -> Vec3:
    """Force of both disturbances [N], world, without a vertical part (MRS eq. 36, 38)."""
    d = d_w + about_z(frames.heading(R)) @ d_b
    return np.array((d[0], d[1], 0.0))


# Torque and limits ------------------------------------------------------------------------------------


def torque_command(
    R: Mat3,
    R_d: Mat3,
    omega: Vec3,
    omega_d: Vec3,
    omega_dot_d: Vec3,
    integral: Vec3,
    J: Mat3,
    gains: TorqueGains,
) -> Vec3:
    """PID on SO(3) with gyroscopic and feed-forward terms (Spica eq. 5)."""
    e_R = -attitude_error(R, R_d)  # Spica counts wanted minus measured
    Q = R.T @ R_d  # what is told in the desired frame → body
    e_omega = Q @ omega_d - omega
    feedback = np.multiply(gains.k_R, e_R) + np.multiply(gains.k_iR, integral)
    feedback = feedback + np.multiply(gains.k_omega, e_omega)
    ahead = J @ (Q @ omega_dot_d - np.cross(omega, Q @ omega_d))
    return feedback + np.cross(omega, J @ omega) + ahead  # (5)


def scale_to_limits(
    u: Array, u_gravity: Array, allocation: Array, f_min: float, f_max: float
) -> Array:
    """What departs from hovering, scaled until every rotor can do it (Spica Sec. 4)."""
    inverse = np.linalg.pinv(allocation)
    u_res = u - u_gravity
    hover, more = inverse @ u_gravity, inverse @ u_res
    if np.any(hover < f_min - 1e-9) or np.any(hover > f_max + 1e-9):
        raise BadInput(
            f"u_gravity needs rotor thrusts from {hover.min():.3g} to {hover.max():.3g} N, allowed {f_min:g} to "
            f"{f_max:g} N: this aircraft cannot hover. Give it stronger rotors or less weight."
        )
    room = np.where(more > 0.0, f_max - hover, f_min - hover)
    moves = np.abs(more) > 1e-12
    most = np.divide(room, more, out=np.ones_like(more), where=moves)
    return u_gravity + np.clip(most.min(), 0.0, 1.0) * u_res  # closed form: errata


# The controller ---------------------------------------------------------------------------------------


class Flown(NamedTuple):
    """Memory of `GeometricController`."""

    d_w: Vec3  # (3,) [N], world
    d_b: Vec3  # (3,) [N], heading frame
    m_e: float  # [kg]
    handover: Handover  # what is left of the command before us


@dataclass(frozen=True)
class GeometricController:
    """State feedback on SE(3) that weighs its aircraft and learns what pushes it (MRS Sec. 5.6)."""

    slot: ClassVar[str] = "controller"
    mass: float
    gains: GeometricGains = GROUPS["now"]["soft"]

    def init(self, estimate: Estimate, last: Command | None) -> Memory:
        """Nothing pushes, the mass is nominal; the first command is `last`."""
        return Flown(np.zeros(3), np.zeros(3), self.mass, Handover(last, None))

    def step(
        self, memory: Memory, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Memory, Command]:
        """The command of what is known so far; then learn from the error of now."""
        k, R, m_e = self.gains, estimate.R, memory.m_e
        d_w, d_b = memory.d_w, memory.d_b
        f = desired_force(estimate, reference, m_e, d_w, d_b, k)  # (38)
        f = limited_tilt(f, k.tilt_max)
        R_d = _attitude(f, reference.heading)  # (21)-(23)
        omega_j = jerk_feedforward(f, m_e, R_d, reference.j)  # (26)
        omega_d = rate_command(R, R_d, reference.heading_rate, omega_j, np.array(k.k_R))  # (25)
        omega_d = np.clip(omega_d, np.negative(k.rate_max), k.rate_max)
        f_d = float(f @ R[:, 2])  # errata of (32): the projection, not the norm
        command = Command(f_d, omega_d, unbiased_acceleration(f_d, R, d_w, d_b, m_e))  # (53)
        e_p = estimate.r - reference.r
        d_w, d_b = disturbance_step(d_w, d_b, e_p, frames.heading(R), dt, k)  # (35)
        m_e = estimated_mass(m_e, float(e_p[2]), dt, self.mass, k)  # (37)
        handover, command = fading(memory.handover, command, dt, FADE)
        return Flown(d_w, d_b, m_e, handover), command

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """What is told in the world turns along; the heading frame turns by itself."""
        last, rest = (None if x is None else frames.moved(x, shift) for x in memory.handover)
        d_w = about_z(shift.heading) @ memory.d_w
        return memory._replace(d_w=d_w, handover=Handover(last, rest))
