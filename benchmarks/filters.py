"""Filters side by side: a bank of 16 aircraft states, an attitude step, and a mixture that one library gets wrong.

What flies in the labs is compared as it stands, in CPU time, with answers checked against the peer's in the same run.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from math import sqrt
from statistics import median
from typing import NamedTuple

import numpy as np

from uavlab.solutions.complementary import attitude_step
from uavlab.solutions.kalman_bank import _corrected, _predicted, heading_model, translation_model
from uavlab.types import GRAVITY, Array, Quat, Vec3

Work = Callable[[], object]

# A bank -----------------------------------------------------------------------------------------------

MEMBERS, PERIOD, P_MODEL = 16, 0.01, 0.9
SIZES = (3, 3, 3, 2)  # x, y, z with velocity and acceleration; heading with its rate
EQUAL = 1e-9


class Bank(NamedTuple):
    """The same filters and the same data for everybody. The heading is padded with a state that stays 0."""

    A: Array  # (4, 3, 3)
    B: Array  # (4, 3, 1)
    Q: Array  # (4, 3, 3)
    R_z: Array  # (4, 1, 1)
    x: Array  # (16, 4, 3)
    P: Array  # (16, 4, 3, 3)
    u: Array  # (16, 4, 1)
    z: Array  # (n, 16, 4, 1), position and heading as measured in n steps


def bank_data(steps: int = 200, seed: int = 3) -> Bank:
    """Models of lab 03 and random data."""
    rng = np.random.default_rng(seed)
    A, B, Q = np.zeros((4, 3, 3)), np.zeros((4, 3, 1)), np.zeros((4, 3, 3))
    for i, n in enumerate(SIZES):
        model = translation_model(PERIOD, P_MODEL) if n == 3 else heading_model(PERIOD, 1.0)
        A[i, :n, :n], B[i, :n] = model
        Q[i, :n, :n] = PERIOD * np.diag((0.1, 1.0, 1.0)[:n])
    x, P = rng.normal(size=(MEMBERS, 4, 3)), np.tile(np.eye(3), (MEMBERS, 4, 1, 1))
    x[:, 3, 2] = P[:, 3, 2, 2] = 0.0
    u, z = rng.normal(size=(MEMBERS, 4, 1)), rng.normal(size=(steps, MEMBERS, 4, 1))
    return Bank(A, B, Q, np.full((4, 1, 1), 0.01), x, P, u, z)


FIRST = np.array(((1.0, 0.0, 0.0),))  # H of all: position, or heading


def batched(b: Bank) -> tuple[Array, Array]:
    """Lab 03's answer for the whole stack: x (16, 4, 3) and P (16, 4, 3, 3) after all steps."""
    x, P = b.x, b.P
    for z in b.z:
        x, P = _predicted(x, P, b.u, b.A, b.B, b.Q)
        x, P, _ = _corrected(x, P, z - x[..., :1], FIRST, b.R_z)
    return x, P


def filterpy_small(b: Bank) -> tuple[Array, Array]:
    """filterpy, four small filters for each member."""
    filters = [
        [_filterpy(b.A[i, :n, :n], b.B[i, :n], b.Q[i, :n, :n], b.R_z[i],
                   b.x[m, i, :n], b.P[m, i, :n, :n], FIRST[:, :n]) for i, n in enumerate(SIZES)]
        for m in range(MEMBERS)
    ]  # fmt: skip
    for z in b.z:
        for m, member in enumerate(filters):
            for i, one in enumerate(member):
                one.predict(b.u[m, i, :, None])
                one.update(z[m, i, :, None])
    x, P = np.zeros_like(b.x), np.zeros_like(b.P)
    for m, member in enumerate(filters):
        for i, (one, n) in enumerate(zip(member, SIZES, strict=True)):
            x[m, i, :n], P[m, i, :n, :n] = one.x[:, 0], one.P
    return x, P


def filterpy_dense(b: Bank) -> tuple[Array, Array]:
    """filterpy, one filter of 11 states for each member."""
    keep = [3 * i + j for i, n in enumerate(SIZES) for j in range(n)]
    A, Q = (_blocks(M)[np.ix_(keep, keep)] for M in (b.A, b.Q))
    B, H = _blocks(b.B)[keep], _blocks(np.stack([FIRST] * 4))[:, keep]
    R_z = _blocks(b.R_z)
    filters = [
        _filterpy(A, B, Q, R_z, b.x[m].ravel()[keep], _blocks(b.P[m])[np.ix_(keep, keep)], H)
        for m in range(MEMBERS)
    ]
    for z in b.z:
        for m, one in enumerate(filters):
            one.predict(b.u[m])
            one.update(z[m])
    x, P = np.zeros_like(b.x), np.zeros_like(b.P)
    for m, one in enumerate(filters):
        whole, spread = np.zeros(12), np.zeros((12, 12))
        whole[keep], spread[np.ix_(keep, keep)] = one.x[:, 0], one.P
        x[m] = whole.reshape(4, 3)
        for i in range(4):
            P[m, i] = spread[3 * i : 3 * i + 3, 3 * i : 3 * i + 3]
    return x, P


def _filterpy(A: Array, B: Array, Q: Array, R_z: Array, x: Array, P: Array, H: Array) -> object:
    from filterpy.kalman import KalmanFilter

    one = KalmanFilter(len(x), len(H), B.shape[1])
    one.F, one.B, one.Q, one.R, one.H = A, B, Q, R_z, H
    one.x, one.P = x[:, None].copy(), P.copy()
    return one


def _blocks(parts: Array) -> Array:
    """Matrices (k, n, m) along the diagonal of one (kn, km)."""
    k, n, m = parts.shape
    out = np.zeros((k, n, k, m))
    for i, part in enumerate(parts):
        out[i, :, i] = part
    return out.reshape(k * n, k * m)


# Attitude ---------------------------------------------------------------------------------------------

GAIN = 1.0  # [rad/s], k_P of Mahony
SPAN = 1.0  # [s]


def attitude_data(rate: float) -> tuple[Array, Array]:
    """Gyro [rad/s] and accelerometer [m/s²] of an aircraft that turns about all axes for `SPAN`, body, (n, 3)."""
    from uavlab.so3 import exp

    t = np.arange(round(SPAN * rate)) / rate
    gyro = np.column_stack((np.sin(3 * t), 0.7 * np.cos(2 * t), 0.5 + 0.2 * np.sin(t)))
    accel, R = np.empty_like(gyro), exp(np.array((0.4, -0.3, 0.2)))
    for k, omega in enumerate(gyro):
        accel[k] = GRAVITY * R[2]
        R = R @ exp(omega / rate)
    return gyro, accel


def ours_attitude(gyro: Array, accel: Array, dt: float) -> Quat:
    """Lab 04's passive filter on the attitude that the accelerometer makes of the old one; from level, q (4,)."""
    q = np.array((1.0, 0.0, 0.0, 0.0))
    for omega, a in zip(gyro, accel, strict=True):
        q = attitude_step(q, omega, levelled(q, a), GAIN, dt)
    return q


def levelled(q: Quat, accel: Vec3) -> Quat:
    """`q` turned the short way until it agrees with the accelerometer about where up is."""
    w, x, y, z = q.tolist()
    a_x, a_y, a_z = accel.tolist()
    size = sqrt(a_x * a_x + a_y * a_y + a_z * a_z)
    v_x, v_y = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x)  # Rᵀ e3, where up should be
    v_z = w * w - x * x - y * y + z * z
    d_x, d_y, d_z = a_y * v_z - a_z * v_y, a_z * v_x - a_x * v_z, a_x * v_y - a_y * v_x
    d_w = size + a_x * v_x + a_y * v_y + a_z * v_z
    turned = (
        w * d_w - x * d_x - y * d_y - z * d_z,
        w * d_x + x * d_w + y * d_z - z * d_y,
        w * d_y - x * d_z + y * d_w + z * d_x,
        w * d_z + x * d_y - y * d_x + z * d_w,
    )
    size = sqrt(d_w * d_w + d_x * d_x + d_y * d_y + d_z * d_z)
    return np.array(turned) / size


def ahrs_attitude(gyro: Array, accel: Array, dt: float) -> Quat:
    """ahrs, `Mahony.updateIMU`, its integral so small that it does nothing (it must be above 0)."""
    from ahrs.filters import Mahony

    peer, q = Mahony(Dt=dt, k_P=GAIN, k_I=1e-12), np.array((1.0, 0.0, 0.0, 0.0))
    for omega, a in zip(gyro, accel, strict=True):
        q = peer.updateIMU(q, omega, a)
    return np.asarray(q)


def gap(p: Quat, q: Quat) -> float:
    """Angle between two attitudes [rad]."""
    return 2.0 * float(np.linalg.norm(p - q if p @ q > 0.0 else p + q))


# A mixture of two -------------------------------------------------------------------------------------


def mixtures() -> tuple[Array, Array]:
    """Covariance of two equally likely filters, at (10, 0) and (20, 0), each with covariance 1: filterpy's, and true.

    Both measure the second state, which tells neither from the other, with a noise so large that nothing changes.
    """
    from filterpy.kalman import KalmanFilter, MMAEFilterBank

    filters = []
    for x in (10.0, 20.0):
        one = KalmanFilter(2, 1)
        one.x, one.P, one.H = np.array((x, 0.0)), np.eye(2), np.array(((0.0, 1.0),))
        one.F, one.Q, one.R = np.eye(2), np.zeros((2, 2)), np.array(((1e14,),))
        filters.append(one)
    bank = MMAEFilterBank(filters, np.array((0.5, 0.5)), dim_x=2, H=filters[0].H)
    bank.update(np.zeros(1))
    off = [one.x - bank.x for one in filters]
    true = sum(p * (one.P + np.outer(y, y)) for p, one, y in zip(bank.p, filters, off, strict=True))
    return bank.P, np.asarray(true)


# The report -------------------------------------------------------------------------------------------


def report(rounds: int) -> None:
    """Run everything in turn, `rounds` times over, and print medians, ratios and how far the answers differ."""
    _report_bank(rounds)
    _report_attitude(rounds)
    wrong, right = mixtures()
    print("\nmixture of two filters of 2 states, equally likely, at (10, 0) and (20, 0), P = I")
    print(f"  by definition      {right.round(6).tolist()}")
    print(f"  filterpy's bank    {wrong.round(6).tolist()}")


def _report_bank(rounds: int) -> None:
    data = bank_data()
    runs = {
        "uavlab, lab 03's answer on a stack (16, 4, 3, 3)": batched,
        "filterpy, 16 dense filters of 11 states": filterpy_dense,
        "filterpy, 16 times four small filters": filterpy_small,
    }
    ends = [run(data) for run in runs.values()]
    apart = [max(np.abs(a - b).max() for a, b in zip(ends[0], end, strict=True)) for end in ends]
    work = {name: lambda run=run: run(data) for name, run in runs.items()}
    print(
        f"\nbank of {MEMBERS} × {sum(SIZES)} states, predict and correct with 4 measurements each"
    )
    _table(work, len(data.z), rounds)
    print(f"  answers after {len(data.z)} steps apart by at most {max(apart):.1e}")
    if max(apart) > EQUAL:
        raise SystemExit(f"the answers are not equal: {max(apart):.1e} is above {EQUAL:g}.")


def _report_attitude(rounds: int) -> None:
    gyro, accel = attitude_data(1000.0)
    work: dict[str, Work] = {
        "uavlab, lab 04's attitude_step, with the accelerometer": lambda: ours_attitude(
            gyro, accel, 1e-3
        ),
        "ahrs, Mahony.updateIMU": lambda: ahrs_attitude(gyro, accel, 1e-3),
    }
    print("\nattitude from gyro and accelerometer, one step")
    _table(work, len(gyro), rounds)
    # Both solve tan(θ/2)˙ = −k tan(θ/2) for the angle θ between their up and the accelerometer's: ours step by step
    # exactly, ahrs by Euler's rule. So what is between them must go like the step.
    gaps = []
    for rate in (100.0, 1000.0, 10_000.0):
        both = [f(*attitude_data(rate), 1.0 / rate) for f in (ours_attitude, ahrs_attitude)]
        gaps.append(gap(*both))
        print(f"  after {SPAN:g} s at {rate:5.0f} Hz they are {gaps[-1]:.1e} rad apart")
    if not (gaps[0] > 8.0 * gaps[1] > 64.0 * gaps[2] and gaps[2] < 1e-4):
        raise SystemExit("the answers do not come together with the step: they are not equal.")


def _table(work: dict[str, Work], steps: int, rounds: int) -> None:
    """CPU time of a step, median of the rounds; then the ratios to the first, as medians of the rounds' ratios."""
    found: dict[str, list[float]] = {name: [] for name in work}
    for run in work.values():
        run()
    for _ in range(rounds):
        for name, run in work.items():
            start = time.process_time()
            run()
            found[name].append(1e6 * (time.process_time() - start) / steps)
    for name, each in found.items():
        print(f"  {median(each):8.1f} µs  [{min(each):7.1f}, {max(each):7.1f}]  {name}")
    first, *others = found
    for other in others:
        ratio = median(b / a for a, b in zip(found[first], found[other], strict=True))
        print(f"  {ratio:8.1f} x   {other}  /  {first}")
