"""Lab 04, the reference answers: complementary filters for attitude, position, height, and the coupled pair.

Papers: Spica is Spica et al. 2013, Bangura is Bangura et al. 2018. Numbers in comments are their equations; where the
errata correct one, the line says so. Bangura tells everything with z down: turned to z up, his e_3 is our −e_3, so the
terms with g change their sign, and −a_z his our +a_z. Velocities, cross products and magnetometer terms stay.
"""

# canary-7d1f3ab04c92e65518d0b7fe

from __future__ import annotations

from dataclasses import dataclass
from math import cos, exp, expm1, inf, isfinite, sin, sqrt

import numpy as np

from uavlab import so3
from uavlab.errors import BadInput
from uavlab.interfaces import Memory, Readings
from uavlab.types import (
    GRAVITY,
    AidedGains,
    Array,
    BodyMemory,
    Command,
    CoupledEstimate,
    CoupledGains,
    CoupledMemory,
    Estimate,
    Field,
    Fix,
    Height,
    Imu,
    InertialMemory,
    Mat3,
    Pull,
    Quat,
    Shift,
    Vec3,
    VerticalGains,
    VerticalMemory,
)

E3 = np.array((0.0, 0.0, 1.0))
THRUST = (
    1.0  # [m/s²] specific force along body z, below which the drag says nothing of the velocity
)
UPRIGHT = 0.2  # R33 below which height and drag give no vertical velocity in the body


# Spica: attitude and position -------------------------------------------------------------------------


def attitude_step(q: Quat, omega: Vec3, q_meas: Quat, gain: float, dt: float) -> Quat:
    """Passive complementary filter on SO(3) (Spica eq. 12), solved exactly: stable at any gain and dt."""
    w, x, y, z = q.tolist()  # on floats: small arrays would take ten times as long
    m_w, m_x, m_y, m_z = q_meas.tolist()
    # δq = q* ⊗ q_meas. By (12) its tangent |δq_v| / δq_s, of half the error, falls like exp(−gain t).
    d_w = w * m_w + x * m_x + y * m_y + z * m_z
    k = exp(-gain * dt)
    d_x = k * (w * m_x - x * m_w - y * m_z + z * m_y)
    d_y = k * (w * m_y - y * m_w - z * m_x + x * m_z)
    d_z = k * (w * m_z - z * m_w - x * m_y + y * m_x)
    # q = q_meas ⊗ δq*, with the error that is left.
    w, x, y, z = _product((m_w, m_x, m_y, m_z), (d_w, -d_x, -d_y, -d_z))
    w, x, y, z = _product((w, x, y, z), _turn(omega.tolist(), dt))
    size = sqrt(w * w + x * x + y * y + z * z)
    return np.array((w / size, x / size, y / size, z / size))


Four = tuple[float, float, float, float]


def _product(p: Four, q: Four) -> Four:
    """Hamilton product p ⊗ q."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def _turn(omega: list[float], dt: float) -> Four:
    """Quaternion of a turn with the rate `omega` [rad/s] for `dt` [s]."""
    x, y, z = omega
    rate = sqrt(x * x + y * y + z * z)
    half = 0.5 * rate * dt
    s = sin(half) / rate if rate > 0.0 else 0.5 * dt
    return cos(half), s * x, s * y, s * z


def position_observer_step(
    r: Vec3, v: Vec3, accel_W: Vec3, r_meas: Vec3 | None, k_p: float, k_v: float, dt: float
) -> tuple[Vec3, Vec3]:
    """Position observer (Spica eq. 11, errata: it is the derivative), exact while r_meas and accel_W stand still."""
    if not (k_p > 0.0 and k_v > 0.0):
        raise BadInput(f"k_p = {k_p}, k_v = {k_v}: to be stable, both must be above 0.")
    if r_meas is None:
        return r + v * dt + accel_W * (0.5 * dt * dt), v + accel_W * dt
    # Where (11) comes to rest: there k_v (r_meas − r) = −accel and v = −k_p (r_meas − r).
    e = accel_W / k_v
    x, y = r - (r_meas + e), v - k_p * e
    # From there (x, y) moves with A = [[−k_p, 1], [−k_v, 0]]: e^{A dt} = e^{−k_p dt/2} (c I + s (A + k_p/2 I)).
    half, square = 0.5 * k_p, 0.25 * k_p * k_p - k_v
    n = sqrt(abs(square))
    if square > 0.0:  # c and s with the fading factor in them
        less, slow = -expm1(-2.0 * n * dt), exp((n - half) * dt)
        c, s = slow * (1.0 - 0.5 * less), slow * less / (2.0 * n)
    else:
        fade = exp(-half * dt)
        c, s = fade * cos(n * dt), fade * (sin(n * dt) / n if n > 0.0 else dt)
    return r_meas + e + (c - s * half) * x + s * y, k_p * e + (c + s * half) * y - s * k_v * x


# Bangura: measurements --------------------------------------------------------------------------------


def drag_velocity(accel: Vec3, c: float) -> Array:
    """Air-relative velocity along body x and y from the rotors' drag (Bangura eq. 3), NaN near free fall."""
    if not c > 0.0:
        raise BadInput(f"c = {c}: the drag coefficient must be above 0.")
    if not accel[2] > THRUST:  # our +a_z is −a_z of the paper
        return np.full(2, np.nan)
    return -accel[:2] / (c * np.sqrt(accel[2]))  # (3)


def vertical_step(
    memory: VerticalMemory,
    R: Mat3,
    accel: Vec3,
    z_meas: float | None,
    dt: float,
    *,
    gains: VerticalGains,
) -> VerticalMemory:
    """Filter 0: barometer and accelerometer with bias (Bangura eq. 4, errata: hats on v_z and β)."""
    k_1, k_2, k_3 = gains
    if not (k_1 > 0.0 and k_2 > 0.0 and 0.0 < k_3 < k_1 * k_2):
        raise BadInput(
            f"k_1, k_2, k_3 = {k_1}, {k_2}, {k_3}: the filter is stable only if all are above 0 "
            f"and k_3 < k_1 k_2 = {k_1 * k_2:g}."
        )
    z, v_z, b_z = memory
    e = 0.0 if z_meas is None else z - z_meas
    z_dot = v_z - k_1 * e  # (4a)
    v_dot = float(R[2] @ accel) - GRAVITY - b_z - k_2 * e  # (4b)
    b_dot = k_3 * e  # (4c)
    return VerticalMemory(z + dt * z_dot, v_z + dt * v_dot, b_z + dt * b_dot)


# Bangura: the two filters -----------------------------------------------------------------------------


def body_filter_step(
    memory: BodyMemory,
    imu: Imu,
    V_meas: Vec3 | None,
    m_meas: Vec3 | None,
    dt: float,
    *,
    m_W: Vec3,
    gains: AidedGains,
    pull: Pull,
) -> BodyMemory:
    """Filter 1 (Bangura eq. 6, 7; errata: the gyro bias follows in the body, and the magnetometer helps it)."""
    V, R, u, b_a, b_omega = memory
    e = np.zeros(3) if V_meas is None else V - V_meas
    omega = imu.gyro - b_omega
    d_v = gains.k_v * e  # (7a)
    d_r = -GRAVITY / u * _cross(R @ e, E3)  # (7b)
    d_m = _magnetometer(R, u, m_meas, m_W, gains.k_m)  # (7c)
    drive = -u * GRAVITY * R[2] + imu.accel - b_a - d_v + pull.v_dot  # (6a)
    u_dot = gains.k_u * GRAVITY * float(e @ R[2])  # (6d)
    b_a_dot = gains.k_b_a * d_v + pull.b_a_dot  # (6e)
    b_omega_dot = gains.k_b_omega * (R.T @ d_r) - gains.k_b_m * d_m  # (6f), errata: Rᵀ, and − Δ^μ
    return BodyMemory(
        so3.exp(-dt * omega) @ (V + dt * drive),  # (6a): −ω × V turns it
        _turned(R, omega + d_m, pull.turn - gains.k_r * d_r, dt),  # (6c)
        u + dt * u_dot,
        b_a + dt * b_a_dot,
        b_omega + dt * b_omega_dot,
    )


def inertial_filter_step(
    memory: InertialMemory,
    imu: Imu,
    v_meas: Vec3 | None,
    m_meas: Vec3 | None,
    dt: float,
    *,
    m_W: Vec3,
    gains: AidedGains,
    pull: Pull,
) -> InertialMemory:
    """Filter 2 (Bangura eq. 9, 10; errata: u weighs g, its error drives it, and both biases follow in the body)."""
    v, R, u, b_a, b_omega = memory
    e = np.zeros(3) if v_meas is None else v - v_meas
    omega = imu.gyro - b_omega
    d_v = gains.k_v * e  # (10b)
    d_r = -GRAVITY / u * _cross(e, E3)  # (10a)
    d_m = _magnetometer(R, u, m_meas, m_W, gains.k_m)  # (10c)
    v_dot = R @ (imu.accel - b_a) - u * GRAVITY * E3 - d_v + pull.v_dot  # (9a), errata: u g
    u_dot = gains.k_u * GRAVITY * float(e[2])  # (9d), errata: the error, not the measurement
    b_a_dot = gains.k_b_a * (R.T @ d_v) + pull.b_a_dot  # (9f), errata: Rᵀ
    b_omega_dot = gains.k_b_omega * (R.T @ d_r) - gains.k_b_m * d_m  # (9g), errata: Rᵀ, and − Δ^μ
    return InertialMemory(
        v + dt * v_dot,
        _turned(R, omega + d_m, pull.turn - gains.k_r * d_r, dt),  # (9c)
        u + dt * u_dot,
        b_a + dt * b_a_dot,
        b_omega + dt * b_omega_dot,
    )


def _turned(R: Mat3, rate_B: Vec3, rate_W: Vec3, dt: float) -> Mat3:
    """`R` after `dt` [s] of turning with both rates [rad/s], one told in the body and one in the world."""
    return so3.exp(dt * rate_W) @ R @ so3.exp(dt * rate_B)


def _magnetometer(R: Mat3, u: float, m_meas: Vec3 | None, m_W: Vec3, k_m: float) -> Vec3:
    """Heading innovation Δ^μ [rad/s], body, along the vertical: 0 without a magnetometer (Remark 1)."""
    if m_meas is None:
        return np.zeros(3)
    up = u * R[2]  # X^T e_3
    return k_m * float(_cross(m_meas, R.T @ m_W) @ up) * up  # (7c), (10c)


def _cross(a: Vec3, b: Vec3) -> Vec3:
    """Cross product a × b; numpy's own takes twenty times as long for two vectors."""
    x, y, z = a.tolist()
    p, q, r = b.tolist()
    return np.array((y * r - z * q, z * p - x * r, x * q - y * p))


# Bangura: the coupled pair ----------------------------------------------------------------------------


@dataclass(frozen=True)
class CoupledFilter:
    """The coupled filters (Bangura eq. 8, 11, 9e, Sec. II-E)."""

    m_W: Vec3
    c: float
    gains: CoupledGains = CoupledGains()
    patience: float = 0.5
    velocity: str = "gnss"

    def init(self, estimate: Estimate) -> Memory:
        """Everything from `estimate`; no wind, no bias."""
        r, v, R, zero = estimate.r, estimate.v, estimate.R, np.zeros(3)
        vertical = VerticalMemory(float(r[2]), float(v[2]), 0.0)
        body = BodyMemory(R.T @ v, R, 1.0, zero, zero)
        inertial = InertialMemory(v, R, 1.0, zero, zero)
        return CoupledMemory(
            vertical, body, inertial, zero, self.m_W, None, None, inf, None, None, 0
        )

    def step(
        self, memory: Memory, readings: Readings, command: Command | None, dt: float
    ) -> tuple[Memory, CoupledEstimate]:
        """Hold what was measured, pull the filters towards each other, step all three, then the wind."""
        now = self._read(memory, readings, dt)
        k, one, two, w = self.gains, now.body, now.inertial, now.w
        if now.imu is None:
            return now, _estimate(now)
        gap = two.v - w - one.R @ one.V  # between the two air-relative velocities, world
        apart = _half_vee(one.R @ two.R.T)  # axis of R_1 R_2ᵀ, world, times the sine of its angle
        bias = one.b_a - two.b_a
        pull_1 = Pull(k.k_1_vc * (one.R.T @ gap), -k.k_1_rc * apart, -k.k_1_b_a * bias)  # (8), (6e)
        pull_2 = Pull(-k.k_2_vc * gap, k.k_2_rc * apart, k.k_2_b_a * bias)  # (11), (9f)
        seen, m, m_W = now.imu, now.m_meas, now.m_W
        vertical = vertical_step(now.vertical, one.R, seen.accel, now.z_meas, dt, gains=k.vertical)
        V_meas = self._air_velocity(now, seen)
        body = body_filter_step(one, seen, V_meas, m, dt, m_W=m_W, gains=k.body, pull=pull_1)
        inertial = inertial_filter_step(
            two, seen, now.v_meas, m, dt, m_W=m_W, gains=k.inertial, pull=pull_2
        )
        w_dot = k.k_w * gap if now.v_meas is not None else -k.k_w * w  # (9e), Sec. II-E
        now = now._replace(vertical=vertical, body=body, inertial=inertial, w=w + dt * w_dot)
        return now, _estimate(now)

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """World quantities turned, the height raised."""
        Rz, dz = so3.about_z(shift.heading), float(shift.r[2])
        return memory._replace(
            vertical=memory.vertical._replace(z=memory.vertical.z + dz),
            body=memory.body._replace(R=Rz @ memory.body.R),
            inertial=memory.inertial._replace(v=Rz @ memory.inertial.v, R=Rz @ memory.inertial.R),
            w=Rz @ memory.w,
            m_W=Rz @ memory.m_W,
            v_meas=None if memory.v_meas is None else Rz @ memory.v_meas,
            z_meas=None if memory.z_meas is None else memory.z_meas + dz,
        )

    def _read(self, memory: CoupledMemory, readings: Readings, dt: float) -> CoupledMemory:
        """The memory with the new readings in it; those that are not numbers are counted only."""
        new: dict[str, object] = {"age": memory.age + dt}
        rejected = memory.rejected
        for name, reading in readings.items():
            if not all(isfinite(x) for field in reading for x in np.ravel(field).tolist()):
                rejected += 1
            elif isinstance(reading, Imu):
                new["imu"] = reading
            elif isinstance(reading, Height):
                new["z_meas"] = reading.z
            elif isinstance(reading, Field):
                new["m_meas"] = reading.m
            elif isinstance(reading, Fix) and name == self.velocity:
                new |= {"v_meas": reading.v, "age": 0.0}
        now = memory._replace(rejected=rejected, **new)
        return now if now.age <= self.patience else now._replace(v_meas=None)

    def _air_velocity(self, now: CoupledMemory, imu: Imu) -> Vec3 | None:
        """Velocity through the air [m/s], body, from drag (3) and Filter 0; None where there is none."""
        R = now.body.R
        V_x, V_y = drag_velocity(imu.accel - now.body.b_a, self.c)
        if not isfinite(V_x) or abs(R[2, 2]) < UPRIGHT:
            return None
        V_z = (now.vertical.v_z - R[2, 0] * V_x - R[2, 1] * V_y) / R[2, 2]
        return np.array((V_x, V_y, V_z))


def _half_vee(M: Mat3) -> Vec3:
    """Vector of the antisymmetric part P_a(M) = (M − Mᵀ) / 2 (Bangura eq. 5)."""
    return 0.5 * so3.vee(M - M.T)


def _estimate(memory: CoupledMemory) -> CoupledEstimate:
    """What is told to others."""
    one, two, imu = memory.body, memory.inertial, memory.imu
    still = imu is None
    a = np.zeros(3) if still else two.R @ (imu.accel - two.b_a) - GRAVITY * E3
    omega = np.zeros(3) if still else imu.gyro - two.b_omega
    return CoupledEstimate(
        one.V,
        two.v,
        a,
        memory.w,
        two.R,
        omega,
        memory.vertical.z,
        one.u,
        two.u,
        two.b_a,
        two.b_omega,
    )
