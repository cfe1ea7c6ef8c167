"""Lab 05, right answers written in other ways than the reference: all must get full marks."""

from __future__ import annotations

import math
import statistics

import numpy as np

from grader.material import variant
from uavlab.exercises.identification import (
    accelerometer_calibration,
    attitude_response,
    drag_coefficient,
    gyro_bias,
    inertia_step,
    mass_step,
    motor_time_constant,
    quadratic_drag,
    thrust_curve,
    thrust_polynomial,
)
from uavlab.types import InertiaMemory, MassMemory

CANARY = "canary-05a75a1d5c1d2fe79272369f"


@variant(gyro_bias)
def by_statistics(samples, max_std):
    columns = [list(map(float, x)) for x in samples.T]
    for x in columns:
        if any(map(math.isnan, x)) or statistics.pstdev(x) > max_std:
            raise ValueError("moved")
    return [statistics.fmean(x) for x in columns]


@variant(gyro_bias)
def by_sums(samples, max_std):
    n = len(samples)
    mean = np.einsum("ij->j", samples) / n
    spread = ((samples - mean) ** 2).sum(0) / n
    if np.isnan(samples).any() or spread.max() > max_std**2:
        raise ValueError("moved, or broken")
    return mean


@variant(accelerometer_calibration)
def normal_equations(samples, attitudes):
    M = np.hstack([samples, np.full((len(samples), 1), -1.0)])
    if np.linalg.matrix_rank(M) < 4:
        raise ValueError("rank")
    X = np.linalg.inv(M.T @ M) @ M.T @ (attitudes[:, 2] * 9.81)
    return X[:3].T, np.linalg.inv(X[:3].T) @ X[3]


@variant(accelerometer_calibration)
def twelve_unknowns(samples, attitudes):
    """Every equation of every orientation in one long system."""
    rows, force = [], []
    for a, R in zip(samples, attitudes, strict=True):
        rows.append(np.hstack((np.kron(np.eye(3), a), -np.eye(3))))
        force.append(R.T @ (0.0, 0.0, 9.81))
    x, _, rank, _ = np.linalg.lstsq(np.vstack(rows), np.concatenate(force), rcond=1e-12)
    if rank < 12:
        raise ValueError("rank")
    T = x[:9].reshape(3, 3)
    return T, np.linalg.solve(T, x[9:])


def _rising(t):
    if np.any(t[1:] <= t[:-1]):
        raise ValueError("time")


def _answer(t, command, start, tau):
    said = [start]
    for dt, c in zip(np.diff(t), command, strict=False):
        said.append(c - (c - said[-1]) * math.exp(-dt / tau))
    return np.array(said)


@variant(motor_time_constant)
def by_simulation(t, command, speed):
    """The τ whose simulated answer is nearest, and with it the best first speed."""
    from scipy.optimize import least_squares

    _rising(t)
    if np.allclose(command, speed):
        raise ValueError("no step")
    size, span = np.ptp(speed), t[-1] - t[0]

    def off(x):
        return (_answer(t, command, speed[0] + size * x[1], span * math.exp(x[0])) - speed) / size

    return span * math.exp(least_squares(off, (math.log(0.1), 0.0), diff_step=1e-5).x[0])


@variant(motor_time_constant)
def by_golden_section(t, command, speed):
    from scipy.optimize import minimize_scalar

    _rising(t)
    if np.abs(command - speed).max() < 1e-9:
        raise ValueError("no step")
    span = t[-1] - t[0]

    def cost(tau):
        one, zero = (_answer(t, u, s, tau) for u, s in ((0.0 * command, 1.0), (command, 0.0)))
        start = one @ (speed - zero) / (one @ one)
        return np.sum((zero + start * one - speed) ** 2)

    bounds = (1e-3 * span, span)
    return minimize_scalar(cost, bounds=bounds, method="bounded", options={"xatol": 1e-5 * span}).x


@variant(thrust_polynomial)
def by_polyfit(speed, force):
    if len(set(speed.tolist())) < 3:
        raise ValueError("speeds")
    return np.polyfit(speed, force, 2)[::-1]


@variant(thrust_polynomial)
def by_orthogonal_columns(speed, force):
    size = np.abs(speed).max()
    Q, U = np.linalg.qr(np.vander(speed / size, 3, increasing=True))
    if abs(U[2, 2]) < 1e-9:
        raise ValueError("speeds")
    return np.linalg.solve(U, Q.T @ force) / size ** np.arange(3)


@variant(thrust_curve)
def by_covariance(throttle, mass, g):
    root = [math.sqrt(m * g) for m in mass]
    if max(root) - min(root) < 1e-9:
        raise ValueError("one mass")
    line = statistics.linear_regression(root, list(map(float, throttle)))
    return line.slope, line.intercept


@variant(thrust_curve)
def by_pseudo_inverse(throttle, mass, g):
    M = np.array([(math.sqrt(m * g), 1.0) for m in mass])
    if np.linalg.matrix_rank(M) < 2:
        raise ValueError("one mass")
    return tuple(np.linalg.pinv(M) @ throttle)


def _lifted(accel, v_body):
    kept = [(v, -a[:2] / math.sqrt(a[2])) for a, v in zip(accel, v_body, strict=True) if a[2] > 1.0]
    return (np.array(x) for x in zip(*kept, strict=True))


@variant(drag_coefficient)
def covariance_over_variance(accel, v_body):
    V, y = _lifted(accel, v_body)
    if np.any(V.std(axis=0) < 1e-9):
        raise ValueError("one speed")
    v, z = V - V.mean(axis=0), y - y.mean(axis=0)
    c = (v * z).sum(axis=0) / (v * v).sum(axis=0)
    return c, y.mean(axis=0) - c * V.mean(axis=0), c * (v * z).sum(axis=0) / (z * z).sum(axis=0)


@variant(drag_coefficient)
def by_scipy(accel, v_body):
    from scipy.stats import linregress

    V, y = _lifted(accel, v_body)
    lines = [linregress(V[:, i], y[:, i]) for i in (0, 1)]
    return (
        [x.slope for x in lines],
        [x.intercept for x in lines],
        np.array([x.rvalue for x in lines]) ** 2,
    )


@variant(quadratic_drag)
def by_normal_equations(accel, v_body):
    V, y = _lifted(accel, v_body)
    said = []
    for v, z in zip(V.T, y.T, strict=True):
        M = np.stack([v * abs(v), v, np.ones(len(v))])
        if np.linalg.matrix_rank(M.T) < 3:
            raise ValueError("speeds")
        x = np.linalg.solve(M @ M.T, M @ z)
        left = z - x @ M
        said.append((*x, 1.0 - left @ left / (len(z) * z.var())))
    return tuple(np.array(said).T)


@variant(quadratic_drag)
def by_signs(accel, v_body):
    V, y = _lifted(accel, v_body)
    sides = np.sign(V) * V**2
    both = []
    for i in (0, 1):
        M = np.column_stack((sides[:, i], V[:, i], np.ones(len(V))))
        U, s, Vt = np.linalg.svd(M, full_matrices=False)
        if s[-1] < 1e-9 * s[0]:
            raise ValueError("speeds")
        x = Vt.T @ (U.T @ y[:, i] / s)
        both.append((*x, np.corrcoef(M @ x, y[:, i])[0, 1] ** 2))
    (c2x, cx, ox, rx), (c2y, cy, oy, ry) = both
    return (c2x, c2y), (cx, cy), (ox, oy), (rx, ry)


@variant(mass_step)
def share_by_share(memory, v_z, R, u_1, dt, *, a, k, g):
    v_z_f, lift_f, g_f, inverse = memory
    closed = -math.expm1(-a * dt)
    lift_f += closed * (u_1 * (R @ (0.0, 0.0, 1.0))[2] - lift_f)
    v_z_f += closed * (v_z - v_z_f)
    g_f += closed * (g - g_f)
    if lift_f != 0.0:
        y = a * (v_z - v_z_f) + g_f
        inverse += -math.expm1(-k * lift_f**2 * dt) * (y / lift_f - inverse)
    return v_z_f, lift_f, g_f, inverse


@variant(mass_step)
def by_ratio_of_what_is_left(memory, v_z, R, u_1, dt, *, a, k, g):
    left = np.exp(-a * dt)
    new = left * np.array(memory[:3]) + (1.0 - left) * np.array((v_z, u_1 * R[2, 2], g))
    y, u = a * (v_z - new[0]) + new[2], new[1]
    goal = y / u if abs(u) > 1e-12 else memory.inverse
    stays = np.exp(-k * u * u * dt)
    return MassMemory(*new, stays * memory.inverse + (1.0 - stays) * goal)


@variant(inertia_step)
def axis_by_axis(memory, omega, torque, dt, *, a, k):
    rows = []
    for w_f, u_f, inverse, w, u in zip(*memory, omega, torque, strict=True):
        w_f, u_f = (x + math.exp(-a * dt) * (was - x) for was, x in ((w_f, w), (u_f, u)))
        if u_f:
            goal = a * (w - w_f) / u_f
            inverse = goal + (inverse - goal) * math.exp(-k * u_f * u_f * dt)
        rows.append((w_f, u_f, inverse))
    return tuple(np.array(rows).T)


@variant(inertia_step)
def in_a_matrix(memory, omega, torque, dt, *, a, k):
    left = np.exp(-a * dt)
    w_f, u_f = left * np.array(memory[:2]) + (1.0 - left) * np.array((omega, torque))
    share = np.divide(1.0 - np.exp(-k * dt * u_f**2), u_f, out=np.zeros(3), where=u_f != 0.0)
    return InertiaMemory(
        w_f, u_f, memory.inverse + share * (a * (omega - w_f) - memory.inverse * u_f)
    )


def _moves(t, reference):
    _rising(t)
    if np.ptp(reference) < 1e-6:
        raise ValueError("the reference stands still")


@variant(attitude_response)
def output_error(t, reference, measured):
    """The numbers, the first tilt and rate, and the trim with which the simulated tilt is nearest to the measured."""
    from scipy.optimize import least_squares
    from scipy.signal import lfilter

    _moves(t, reference)
    dt, pace = t[1] - t[0], 200.0 / (t[-1] - t[0])
    ref, said = reference - reference.mean(), measured - measured.mean()
    size = said.std()

    def parts(x):
        """Tilt from the reference, from a first tilt, from a first rate, and from a trim, each with gain one."""
        b_0, b_1 = x * (pace**2, pace)
        n, h = np.sqrt(complex(b_0 - 0.25 * b_1 * b_1)), 0.5 * b_1
        c, k = np.cos(n * dt).real, (dt * np.sinc(n * dt / np.pi)).real
        A = np.exp(-h * dt) * np.array(((c + k * h, k), (-k * b_0, c - k * h)))
        rest, ramp = np.array((1.0, 0.0)) / b_0, np.array((-b_1 / b_0, 1.0)) / b_0 / dt
        late, soon = rest + ramp - A @ ramp, A @ (ramp - rest) - ramp
        den = (1.0, -np.trace(A), np.linalg.det(A))
        turned = np.array(((A[1, 1], -A[0, 1]), (-A[1, 0], A[0, 0])))  # adj(z − A) = z − turned
        num = (late[0], soon[0] - (turned @ late)[0], -(turned @ soon)[0])
        forced = lfilter(num, den, ref)
        pulse = np.eye(1, len(ref))[0]
        free = [
            lfilter((1.0, -turned[0, 0]), den, pulse),
            lfilter((0.0, -turned[0, 1]), den, pulse),
        ]
        return np.stack((forced, *free, np.ones(len(ref))), axis=1)

    def off(x):
        M = parts(x)
        return (M @ np.linalg.lstsq(M, said, rcond=None)[0] - said) / size

    x = least_squares(off, (1.0, 1.0), diff_step=1e-4, bounds=(1e-3, 1e3)).x
    b_r = np.linalg.lstsq(parts(x), said, rcond=None)[0][0]
    return x[0] * pace**2, x[1] * pace, b_r


@variant(attitude_response)
def gauss_newton_on_spectra(t, reference, measured):
    """Spectra by sums, a first guess by weighted least squares, and then the slopes of the model."""
    _moves(t, reference)
    dt = (t[-1] - t[0]) / (len(t) - 1)
    omega = 2.0 * np.pi * np.arange(1, len(t) // 10) / (t[-1] - t[0])
    waves = np.exp(-1j * np.outer(omega, t - t[0])) * dt
    waves[:, (0, -1)] /= 2.0
    ref, said = waves @ reference, waves @ measured
    s, one = 1j * omega, np.ones(len(omega), complex)

    def nearest(M, y):
        return np.linalg.lstsq(np.vstack((M.real, M.imag)), np.append(y.real, y.imag), rcond=None)[
            0
        ]

    x, D = np.zeros(5), s**2 + s + 1.0
    for _ in range(10):
        M = np.stack((-said, -s * said, ref, one, s), axis=1) / D[:, None]
        x = nearest(M, s**2 * said / D)
        D = s**2 + x[1] * s + x[0]
    for _ in range(10):
        D = s**2 + x[1] * s + x[0]
        model = (x[2] * ref + x[3] + x[4] * s) / D
        slopes = np.stack((-model, -s * model, ref, one, s), axis=1) / D[:, None]
        x = x + nearest(slopes, said - model)
    return tuple(x[:3])
