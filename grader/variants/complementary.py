"""Lab 04, right answers written in other ways than the reference: all must get full marks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from grader.material import variant
from uavlab import so3
from uavlab.exercises.complementary import (
    CoupledFilter,
    attitude_step,
    body_filter_step,
    drag_velocity,
    inertial_filter_step,
    position_observer_step,
    vertical_step,
)
from uavlab.solutions import complementary as right
from uavlab.types import (
    BodyMemory,
    CoupledEstimate,
    CoupledGains,
    InertialMemory,
    Pull,
    Vec3,
    VerticalMemory,
)

CANARY = "canary-74e8e2b42b40575d9cdbae3a"


@variant(attitude_step)
def with_scipy(q, omega, q_meas, gain, dt):
    est, true = (Rotation.from_quat(x[[1, 2, 3, 0]]) for x in (q, q_meas))
    error = (true.inv() * est).as_rotvec()
    size = np.linalg.norm(error)
    left = 2.0 * math.atan(math.tan(0.5 * size) * math.exp(-gain * dt))
    kept = Rotation.from_rotvec(error * (left / size if size > 1e-12 else 1.0))
    x, y, z, w = (true * kept * Rotation.from_rotvec(omega * dt)).as_quat()
    new = np.array([w, x, y, z])
    return new if new @ q > 0.0 else -new


@variant(attitude_step)
def by_matrices_of_quaternions(q, omega, q_meas, gain, dt):
    """Left and right multiplication as (4, 4) matrices; the error pulled towards ±1 by its vector part."""

    def left(p):
        return p[0] * np.eye(4) + np.block([[0.0, -p[None, 1:]], [p[1:, None], so3.hat(p[1:])]])

    fade = np.diag([1.0, *3 * [np.exp(-gain * dt)]])
    conj = np.diag([1.0, -1.0, -1.0, -1.0])
    new = left(q_meas) @ conj @ fade @ left(conj @ q) @ q_meas
    angle = np.linalg.norm(omega) * dt
    turn = np.append(np.cos(angle / 2), 0.5 * dt * np.sinc(angle / 2 / np.pi) * omega)
    new = left(new) @ turn
    return new / np.sqrt(new @ new)


@variant(position_observer_step)
def by_the_exponential(r, v, accel_W, r_meas, k_p, k_v, dt):
    if k_p <= 0 or k_v <= 0:
        raise ValueError("gains")
    A = np.zeros((4, 4))
    A[0, 1] = A[1, 3] = 1.0
    if r_meas is not None:
        A[0, [0, 2]], A[1, [0, 2]] = (-k_p, k_p), (-k_v, k_v)
    x = np.array([r, v, np.zeros(3) if r_meas is None else r_meas, accel_W])
    return tuple((expm(A * dt) @ x)[:2])


@variant(position_observer_step)
def by_complex_poles(r, v, accel_W, r_meas, k_p, k_v, dt):
    """Sylvester's formula with poles that may be complex; a double pole is split by a hair's breadth."""
    if not min(k_p, k_v) > 0.0:
        raise ValueError("gains")
    if r_meas is None:
        return r + dt * (v + dt / 2 * accel_W), v + dt * accel_W
    root = np.sqrt(complex(k_p**2 / 4 - k_v))
    root = root if abs(root) > 1e-5 else 1e-5
    p, q = -k_p / 2 + root, -k_p / 2 - root
    A = np.array([[-k_p, 1.0], [-k_v, 0.0]])
    E = (np.exp(p * dt) * (A - q * np.eye(2)) - np.exp(q * dt) * (A - p * np.eye(2))) / (p - q)
    rest = -np.linalg.solve(A, np.array([k_p * r_meas, k_v * r_meas + accel_W]))
    x = rest + E.real @ (np.array([r, v]) - rest)
    return x[0], x[1]


@variant(drag_velocity)
def on_floats(accel, c):
    if c <= 0.0:
        raise ValueError(f"c = {c}")
    x, y, z = map(float, accel)
    if z <= 1.0:
        return np.array([math.nan, math.nan])
    return np.array([-x, -y]) / (c * math.sqrt(z))


@variant(drag_velocity)
def by_a_logarithm(accel, c):
    if c <= 0.0:
        raise ArithmeticError
    clear = 1.0 if accel[2] > 1.0 else np.nan
    return -clear * accel[:2] * np.exp(-0.5 * np.log(max(accel[2], 1.0))) / c


@variant(vertical_step)
def as_a_matrix(memory, R, accel, z_meas, dt, *, gains):
    k_1, k_2, k_3 = gains
    if min(gains) <= 0 or k_3 >= k_1 * k_2:
        raise ValueError("the error grows")
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 0.0]])
    drive = np.array([0.0, (R @ accel)[2] - 9.81, 0.0])
    if z_meas is not None:
        K = np.array([-k_1, -k_2, k_3])
        A[:, 0] += K
        drive = drive - K * z_meas
    x = np.array(memory)
    return VerticalMemory(*(x + dt * (A @ x + drive)))


@variant(vertical_step)
def by_the_midpoint(memory, R, accel, z_meas, dt, *, gains):
    k_1, k_2, k_3 = gains
    if not (k_1 > 0 and k_2 > 0 and k_3 > 0 and k_1 * k_2 > k_3):
        raise ValueError("the error grows")
    up = float(np.sum(R[2] * accel)) - 9.81

    def rate(x):
        e = 0.0 if z_meas is None else x[0] - z_meas
        return np.array([x[1] - k_1 * e, up - x[2] - k_2 * e, k_3 * e])

    x = np.array(memory)
    return tuple(x + dt * rate(x + dt / 2 * rate(x)))


# The two filters: (6) and (9) as printed, with matrices, and stepped in two ways --------------------------

G = np.array([0.0, 0.0, -9.81])  # gravity, z up: what g e_3 of the paper becomes


def derivative(x, imu, seen, m, m_W, k, pull):
    """Rates of V or v, of R (an angular velocity, body), of u, b_a and b_omega."""
    body = isinstance(x, BodyMemory)
    R, X = x.R, x.u * x.R
    error = np.zeros(3) if seen is None else x[0] - seen
    in_world, in_body = (R @ error, error) if body else (error, R.T @ error)
    W = so3.hat(imu.gyro - x.b_omega)
    d_r = so3.hat(in_world) @ G / x.u
    d_m = np.zeros(3)
    if m is not None:
        n = X.T @ [0.0, 0.0, 1.0]
        d_m = k.k_m * np.outer(n, n) @ so3.hat(m) @ R.T @ m_W
    if body:
        v_dot = -W @ x.V + X.T @ G + imu.accel - x.b_a - k.k_v * error + pull.v_dot
    else:
        v_dot = X @ (imu.accel - x.b_a) / x.u + x.u * G - k.k_v * error + pull.v_dot
    turn = so3.vee(W) + d_m + R.T @ (pull.turn - k.k_r * d_r)
    u_dot = -k.k_u * in_world @ G
    b_a_dot = k.k_b_a * k.k_v * in_body + pull.b_a_dot
    return v_dot, turn, u_dot, b_a_dot, k.k_b_omega * R.T @ d_r - k.k_b_m * d_m


def ahead(x, rate, h):
    """`x` moved with constant rates."""
    v_dot, turn, u_dot, b_a_dot, b_w_dot = rate
    rest = x.u + h * u_dot, x.b_a + h * b_a_dot, x.b_omega + h * b_w_dot
    return type(x)(x[0] + h * v_dot, x.R @ Rotation.from_rotvec(h * turn).as_matrix(), *rest)


@variant(body_filter_step)
def plain_euler(memory, imu, V_meas, m_meas, dt, *, m_W, gains, pull):
    return ahead(memory, derivative(memory, imu, V_meas, m_meas, m_W, gains, pull), dt)


@variant(body_filter_step)
def two_half_steps(memory, imu, V_meas, m_meas, dt, *, m_W, gains, pull):
    for _ in range(2):
        rate = derivative(memory, imu, V_meas, m_meas, m_W, gains, pull)
        memory = ahead(memory, rate, dt / 2)
    return BodyMemory(*memory)


@variant(inertial_filter_step)
def plain_euler_in_the_world(memory, imu, v_meas, m_meas, dt, *, m_W, gains, pull):
    return tuple(ahead(memory, derivative(memory, imu, v_meas, m_meas, m_W, gains, pull), dt))


@variant(inertial_filter_step)
def two_half_steps_in_the_world(memory, imu, v_meas, m_meas, dt, *, m_W, gains, pull):
    for _ in range(2):
        rate = derivative(memory, imu, v_meas, m_meas, m_W, gains, pull)
        memory = ahead(memory, rate, dt / 2)
    return InertialMemory(*memory)


# The coupled pair -------------------------------------------------------------------------------------


@variant(CoupledFilter)
@dataclass(frozen=True)
class InADictionary:
    """Memory as a dictionary, the last readings as they came, the other half step, the gap told in the body."""

    m_W: Vec3
    c: float
    gains: CoupledGains = CoupledGains()
    patience: float = 0.5
    velocity: str = "gnss"

    def init(self, estimate):
        R, v, o = estimate.R, estimate.v, np.zeros(3)
        return {
            "0": VerticalMemory(estimate.r[2], v[2], 0.0),
            "1": BodyMemory(v @ R, R, 1.0, o, o),
            "2": InertialMemory(v, R, 1.0, o, o),
            "w": o,
            "field": np.array(self.m_W),
            "seen": {},
            "age": 1e9,
        }

    def step(self, memory, readings, command, dt):
        x = dict(memory)
        good = {n: r for n, r in readings.items() if all(np.all(np.isfinite(f)) for f in r)}
        x["seen"] = {**x["seen"], **good}
        x["age"] = 0.0 if self.velocity in good else x["age"] + dt
        if "imu" not in x["seen"]:
            return x, self.told(x)
        seen, k = x["seen"], self.gains
        v = seen[self.velocity].v if x["age"] <= self.patience else None
        m = seen["magnetometer"].m if "magnetometer" in seen else None
        z = seen["barometer"].z if "barometer" in seen else None
        one, two, imu = x["1"], x["2"], seen["imu"]
        gap = one.V - one.R.T @ (two.v - x["w"])
        apart = so3.vee((one.R @ two.R.T - two.R @ one.R.T) / 2)
        bias = one.b_a - two.b_a
        pulls = (
            Pull(-k.k_1_vc * gap, -k.k_1_rc * apart, -k.k_1_b_a * bias),
            Pull(k.k_2_vc * one.R @ gap, k.k_2_rc * apart, k.k_2_b_a * bias),
        )
        V = right.drag_velocity(imu.accel - one.b_a, self.c)
        lean = one.R[2]
        V = np.append(V, (x["0"].v_z - lean[:2] @ V) / lean[2])
        V = V if np.isfinite(V).all() and abs(lean[2]) >= 0.2 else None
        x["0"] = right.vertical_step(x["0"], one.R, imu.accel, z, dt, gains=k.vertical)
        x["1"] = plain_euler.run(one, imu, V, m, dt, m_W=x["field"], gains=k.body, pull=pulls[0])
        x["2"] = right.inertial_filter_step(
            two, imu, v, m, dt, m_W=x["field"], gains=k.inertial, pull=pulls[1]
        )
        x["w"] = x["w"] - dt * k.k_w * (x["w"] if v is None else one.R @ gap)
        return x, self.told(x)

    def told(self, x):
        one, two, imu, o = x["1"], x["2"], x["seen"].get("imu"), np.zeros(3)
        a = o if imu is None else two.R @ (imu.accel - two.b_a) + G
        omega = o if imu is None else imu.gyro - two.b_omega
        said = one.V, two.v, a, x["w"], two.R, omega, x["0"].z, one.u, two.u, two.b_a, two.b_omega
        return CoupledEstimate(*said)

    def reframe(self, memory, shift):
        x, Rz = dict(memory), so3.about_z(shift.heading)
        x["0"] = x["0"]._replace(z=x["0"].z + shift.r[2])
        x["1"] = x["1"]._replace(R=Rz @ x["1"].R)
        x["2"] = x["2"]._replace(R=Rz @ x["2"].R, v=Rz @ x["2"].v)
        x["w"], x["field"] = Rz @ x["w"], Rz @ x["field"]
        seen = dict(x["seen"])
        if self.velocity in seen:
            seen[self.velocity] = seen[self.velocity]._replace(v=Rz @ seen[self.velocity].v)
        if "barometer" in seen:
            seen["barometer"] = seen["barometer"]._replace(z=seen["barometer"].z + shift.r[2])
        return {**x, "seen": seen}


@variant(CoupledFilter)
@dataclass(frozen=True)
class ExactWind(right.CoupledFilter):
    """The wind follows its goal exactly over a step, not by Euler."""

    def step(self, memory, readings, command, dt):
        now, x = super().step(memory, readings, command, dt)
        k = self.gains.k_w
        if k > 0.0:
            more = (1.0 - np.exp(-k * dt)) / (k * dt)
            now = now._replace(w=memory.w + more * (now.w - memory.w))
        return now, x._replace(w=now.w)
