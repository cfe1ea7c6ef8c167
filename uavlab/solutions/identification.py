"""Lab 05, the reference answers: what an aircraft's sensors, motors, mass, drag and attitude loop are.

Papers: Spica is Spica et al. 2013, Bangura is Bangura et al. 2018, MRS is Baca et al. 2021, Landing is Tzoumanikas
et al. 2019. Numbers in comments are their equations; where the errata correct one, the line says so.
"""

# canary-b0cc7dd2040f259777b197d0

from __future__ import annotations

from typing import Any

import numpy as np

from uavlab.errors import BadInput
from uavlab.types import GRAVITY, Array, InertiaMemory, MassMemory, Mat3, Vec3

Number = float | Array

RANK = 1e-6  # smallest over largest singular value, columns of unit length, below which a fit is not unique
SKEWED = 1e3  # condition of T above which noise, not the orientations, made it
FREE_FALL = 1.0  # [m/s²] along body z, at and below which drag says nothing of the velocity
LOOSE = 0.2  # standard error over value, above which a number is not identified
STILL = 1e-6  # [rad] less than this is no motion of a reference
ROUNDS = 50  # of the iterated fit; it settles in about ten

# Sensors at rest --------------------------------------------------------------------------------------


def gyro_bias(samples: Array, max_std: float) -> Vec3:
    """Mean of the gyro at rest, refused when the aircraft moved (Spica Sec. 5.1)."""
    samples = _finite("samples", samples, (None, 3), 2)
    std = samples.std(axis=0)
    if not np.all(std <= max_std):
        axis = int(np.argmax(std))
        raise BadInput(
            f"the aircraft moved: samples along body {'xyz'[axis]} have a standard deviation of "
            f"{std[axis]:.3g} rad/s; at most {max_std:g} is allowed. Hold it still and take them again."
        )
    return samples.mean(axis=0)


def accelerometer_calibration(samples: Array, attitudes: Array) -> tuple[Mat3, Vec3]:
    """T and b of a = T (a_m − b), by least squares over orientations at rest (Spica Sec. 5.2)."""
    samples = _finite("samples", samples, (None, 3), 4)
    attitudes = _finite("attitudes", attitudes, (len(samples), 3, 3), 4)
    g = np.array((0.0, 0.0, -GRAVITY))  # errata: in this section g is a vector, and points down
    M = np.column_stack((samples, -np.ones(len(samples))))
    Y = -g @ attitudes  # rows −gᵀ R_i
    X = _least_squares(M, Y, "orientations that do not lie in one plane: tilt it about two axes")
    T = X[:3].T
    if not np.linalg.cond(T) < SKEWED:
        raise BadInput(
            f"attitudes do not determine T: its condition is {np.linalg.cond(T):.2g}, allowed {SKEWED:g}. They differ "
            "by turns about the vertical only, or nearly; tilt it about two axes."
        )
    return T, np.linalg.solve(T, X[3])  # X[3] = T b


# Motors and thrust ------------------------------------------------------------------------------------


def motor_time_constant(t: Array, command: Array, speed: Array) -> float:
    """Time constant of a first-order lag, from the integral of its equation (Spica Sec. 5.3)."""
    t, command, speed = _record(t, command=command, speed=speed)
    dt = np.diff(t)
    asked = np.cumsum(dt * command[:-1])  # the command is held from sample to sample
    turned = np.cumsum(dt * (speed[1:] + speed[:-1]) / 2.0)
    gap = np.concatenate(((0.0,), asked - turned))
    # τ ẋ = c − x, integrated: x(t) = x(0) + ∫(c − x) / τ. No derivative, and no logarithm of noise.
    cure = "a step of the command that the speed has to follow"
    (rate, _), error = _fit_and_error(np.column_stack((gap, np.ones_like(gap))), speed, cure)
    if not (rate > 0.0 and error[0] <= LOOSE * rate):
        raise BadInput(
            f"speed does not follow command: 1/tau = {rate:.3g} ± {error[0]:.2g} 1/s; above 0 and an error of at "
            f"most {LOOSE:.0%} are needed. Record a step of the command that is larger than the noise."
        )
    return float(1.0 / rate)


def thrust_polynomial(speed: Array, force: Array) -> Array:
    """Coefficients of force = p_0 + p_1 speed + p_2 speed², by least squares (Spica Sec. 5.3)."""
    speed = _finite("speed", speed, (None,), 3)
    force = _finite("force", force, (len(speed),), 3)
    return _least_squares(np.vander(speed, 3, increasing=True), force, "three different speeds")


def thrust_curve(throttle: Array, mass: Array, g: float) -> tuple[float, float]:
    """Slope and offset of the collective thrust curve, from hover tests (MRS eq. 33)."""
    throttle = _finite("throttle", throttle, (None,), 2)
    mass = _finite("mass", mass, (len(throttle),), 2)
    if not (np.all(mass > 0.0) and g > 0.0):
        raise BadInput(f"mass = {mass.tolist()} and g = {g}: both must be above 0, in kg and m/s².")
    M = np.column_stack((np.sqrt(mass * g), np.ones_like(mass)))
    a_t, b_t = _least_squares(M, throttle, "hovers with two different masses")  # (33)
    return float(a_t), float(b_t)


# Drag -------------------------------------------------------------------------------------------------


def drag_coefficient(accel: Array, v_body: Array) -> tuple[Array, Array, Array]:
    """Linear rotor drag along body x and y: c, offset and R² of each (Bangura Sec. V-A)."""
    V, y = _drag_per_root(accel, v_body)
    fits = [_fit_drag(axis, V[:, axis, None], y[:, axis]) for axis in range(2)]
    c, offset, r2 = np.transpose(fits)
    return c, offset, r2


def quadratic_drag(accel: Array, v_body: Array) -> tuple[Array, Array, Array, Array]:
    """Drag with a part that grows with V|V|: c_2, c, offset and R² of each axis (Bangura Sec. V-A)."""
    V, y = _drag_per_root(accel, v_body)
    parts = np.stack((V * np.abs(V), V), axis=-1)
    c_2, c, offset, r2 = np.transpose([_fit_drag(i, parts[:, i], y[:, i]) for i in range(2)])
    return c_2, c, offset, r2


def _drag_per_root(accel: Array, v_body: Array) -> tuple[Array, Array]:
    """Velocities (n, 2), and −a/√a_z (n, 2) of them, without samples near free fall."""
    accel = _finite("accel", accel, (None, 3), 3)
    v_body = _finite("v_body", v_body, (len(accel), 2), 3)
    lifted = accel[:, 2] > FREE_FALL  # our +a_z is −a_z of the paper
    if lifted.sum() < 3:
        raise BadInput(
            f"accel: {lifted.sum()} samples have a_z above {FREE_FALL:g} m/s², at least 3 are needed. "
            "At rest it is +9.81, body z up: is the sign right?"
        )
    return v_body[lifted], -accel[lifted, :2] / np.sqrt(accel[lifted, 2:])


def _fit_drag(axis: int, parts: Array, y: Array) -> tuple[float, ...]:
    """Coefficients, offset and R² of y = parts · coefficients + offset."""
    M = np.column_stack((parts, np.ones(len(y))))
    x = _least_squares(M, y, f"different speeds along body {'xy'[axis]}: fly to and fro along it")
    left, all_ = ((r**2).sum() for r in (y - M @ x, y - y.mean()))
    return (*x, 1.0 - left / all_ if all_ > 0.0 else 0.0)


# Mass and inertia while it flies ----------------------------------------------------------------------


def mass_step(
    memory: MassMemory, v_z: float, R: Mat3, u_1: float, dt: float, *, a: float, k: float, g: float
) -> MassMemory:
    """Adaptive mass on filtered dynamics, exact for held inputs (Spica eq. 6-10, errata: z̈ + g, z up)."""
    _above_zero(a=a, k=k, dt=dt)
    lift = u_1 * R[2, 2]  # (6): υ = u_1 z_Bᵀ z_W
    keep = np.exp(-a * dt)  # P(s) = a / (s + a), exact while its input is held
    v_f = v_z + keep * (memory.v_z - v_z)
    lift_f = lift + keep * (memory.lift - lift)
    g_f = g + keep * (memory.g - g)
    y = a * (v_z - v_f) + g_f  # (8), (9); errata of (9): + g_fil
    inverse = _adapted(memory.inverse, y, lift_f, k * dt)
    return MassMemory(float(v_f), float(lift_f), float(g_f), float(inverse))


def inertia_step(
    memory: InertiaMemory, omega: Vec3, torque: Vec3, dt: float, *, a: float, k: float
) -> InertiaMemory:
    """Adaptive inertia, each body axis by itself (Spica Sec. 5.4, last paragraph: (6)-(10) without gravity)."""
    _above_zero(a=a, k=k, dt=dt)
    keep = np.exp(-a * dt)
    omega_f = omega + keep * (memory.omega - omega)
    torque_f = torque + keep * (memory.torque - torque)
    y = a * (omega - omega_f)  # (8)
    return InertiaMemory(omega_f, torque_f, _adapted(memory.inverse, y, torque_f, k * dt))


def _adapted(inverse: Number, y: Number, u: Number, weight: float) -> Any:
    """Solution of (10), ẋ = k (y − x u) u, after weight/k seconds: stable for any step (errata: (10) is stiff)."""
    u2 = np.square(u)
    share = np.where(u2 > 0.0, -np.expm1(-weight * u2) / np.where(u2 > 0.0, u2, 1.0), weight)
    return inverse + share * u * (y - inverse * u)


# The attitude loop ------------------------------------------------------------------------------------


def attitude_response(t: Array, reference: Array, measured: Array) -> tuple[float, float, float]:
    """b_0, b_1, b_r of θ̈ = −b_0 θ − b_1 θ̇ + b_r θ^r, fitted to the spectra of a flight (Landing eq. 12, Sec. 6.1)."""
    t, reference, measured = _record(t, reference=reference, measured=measured)
    if np.ptp(reference) < STILL:
        raise BadInput(
            f"reference moves by {np.ptp(reference):.1g} rad in all; at least {STILL:g} is needed. Excite the axis."
        )
    s, ref, said = _spectra(t, reference, measured)
    x, error = _iterated_fit(s, ref, said)
    b_0, b_1, b_r = (float(b) for b in x[:3])
    if not (b_0 > 0.0 and b_1 > 0.0 and np.all(error[:3] <= LOOSE * np.abs(x[:3]))):
        raise BadInput(
            f"reference does not excite the loop: b_0, b_1, b_r = {x[:3].round(3).tolist()} ± "
            f"{error[:3].round(3).tolist()}; b_0 and b_1 above 0 and errors of at most {LOOSE:.0%} are needed. "
            "Move the stick further, and at several speeds."
        )
    return b_0, b_1, b_r


def _spectra(t: Array, reference: Array, measured: Array) -> tuple[Array, Array, Array]:
    """Laplace variable s = iω and both spectra, from one turn in the record to half of Nyquist; no mean, no trim."""
    n = len(t) - 1
    even = np.linspace(t[0], t[-1], n + 1)
    joined = np.array([np.interp(even, t, x) for x in (reference, measured)])
    joined[:, 0] = (
        joined[:, 0] + joined[:, -1]
    ) / 2.0  # the trapezoid rule, as a sum over n samples
    ref, said = np.fft.rfft(joined[:, :-1])[:, 1 : n // 4 + 1] * (even[1] - even[0])
    omega = 2.0 * np.pi * np.arange(1, n // 4 + 1) / (t[-1] - t[0])
    return 1j * omega, ref, said


def _iterated_fit(s: Array, ref: Array, said: Array) -> tuple[Array, Array]:
    """b_0, b_1, b_r and two numbers of the record's ends, with their standard errors.

    Over a record of length T, the transform of θ̇ is sΘ + θ(T) − θ(0): what the ends leave is a polynomial p + q s. So

        s² Θ = −b_0 Θ − b_1 s Θ + b_r Θ^r + p + q s .

    Divided by D = s² + b_1 s + b_0 of the last round its error is that of Θ itself, and multiplied by the slopes of the
    model, which are free of noise, noise in Θ does not draw the answer: the fixed point is the least squares fit of Θ.
    """
    one = np.ones_like(s)
    D = s**2 + s + one  # of the first round only
    model, x, H = said, np.zeros(5), np.eye(5)
    for _ in range(ROUNDS):
        known = np.stack((-said, -s * said, ref, one, s)) / D
        slopes = np.stack((-model, -s * model, ref, one, s)) / D
        H = (slopes.conj() @ known.T).real
        was, x = x, _solve(H, (slopes.conj() @ (s**2 * said / D)).real)
        D = s**2 + x[1] * s + x[0]
        model = (x[2] * ref + x[3] + x[4] * s) / D
        if np.allclose(x[:3], was[:3], rtol=1e-8, atol=0.0):
            break
    spread = np.sum(np.abs(said - model) ** 2) / max(2 * len(s) - 5, 1)
    slopes = np.stack((-model, -s * model, ref, one, s)) / D
    curvature = (slopes.conj() @ slopes.T).real
    return x, np.sqrt(spread * np.abs(np.diag(np.linalg.pinv(curvature))))


def _solve(H: Array, y: Array) -> Array:
    """Solution of H x = y, its columns told in their own sizes."""
    size = np.sqrt(np.abs(np.diag(H)))
    size[size == 0.0] = 1.0
    scaled = H / np.outer(size, size)
    if np.linalg.cond(scaled) > 1.0 / RANK**2:
        raise BadInput(
            "reference moves at too few frequencies to tell b_0, b_1 and b_r apart (condition above "
            f"{1.0 / RANK**2:g}). Move the stick at several speeds, for longer than one swing."
        )
    return np.linalg.solve(scaled, y / size) / size


# Least squares, and what may go into it ---------------------------------------------------------------


def _least_squares(M: Array, y: Array, cure: str) -> Array:
    """The x that brings M x nearest to y; refused when more than one does."""
    size = np.linalg.norm(M, axis=0)
    scaled = M / np.where(size > 0.0, size, 1.0)
    values = np.linalg.svd(scaled, compute_uv=False)
    rank = int(np.sum(values > RANK * values[0]))
    if rank < M.shape[1]:
        raise BadInput(
            f"{len(M)} samples determine {rank} of {M.shape[1]} unknowns; all are needed. Add {cure}."
        )
    x = np.linalg.lstsq(scaled, y, rcond=None)[0]
    return (x.T / size).T


def _fit_and_error(M: Array, y: Array, cure: str) -> tuple[Array, Array]:
    """Least squares, and the standard error of each number."""
    x = _least_squares(M, y, cure)
    spread = np.sum((y - M @ x) ** 2) / max(len(y) - M.shape[1], 1)
    return x, np.sqrt(spread * np.diag(np.linalg.pinv(M.T @ M)))


def _record(t: Array, **signals: Array) -> tuple[Array, ...]:
    """Times that run forwards, and signals of the same length, all finite."""
    t = _finite("t", t, (None,), 10)
    if not np.all(np.diff(t) > 0.0):
        i = int(np.flatnonzero(~(np.diff(t) > 0.0))[0])
        raise BadInput(
            f"t runs backwards or stands still: t[{i}] = {t[i]:g} s, t[{i + 1}] = {t[i + 1]:g} s. Sort the "
            "samples by time and drop repeated ones."
        )
    return (t, *(_finite(name, x, (len(t),), 10) for name, x in signals.items()))


def _finite(name: str, x: Array, shape: tuple[int | None, ...], least: int) -> Array:
    """`x` as float64 of this shape (None: any length), with at least so many rows, all finite."""
    x = np.asarray(x, dtype=float)
    fits = x.ndim == len(shape) and all(w in (None, h) for w, h in zip(shape, x.shape, strict=True))
    if not fits:
        asked = "(" + ", ".join("n" if w is None else str(w) for w in shape) + ")"
        raise BadInput(f"{name} has shape {x.shape}; {asked} is needed, a row for each sample.")
    if len(x) < least:
        raise BadInput(f"{name} has {len(x)} samples; at least {least} are needed.")
    bad = np.flatnonzero(~np.isfinite(x.reshape(len(x), -1)).all(axis=1))
    if len(bad):
        raise BadInput(
            f"{name}[{bad[0]}] is {x[bad[0]].tolist()}, and {len(bad)} of {len(x)} samples are not finite; "
            "all must be. Drop these rows."
        )
    return x


def _above_zero(**values: float) -> None:
    """Refuse what must be above zero and is not."""
    for name, value in values.items():
        if not 0.0 < value < np.inf:
            raise BadInput(f"{name} is {value}; it must be finite and above 0.")
