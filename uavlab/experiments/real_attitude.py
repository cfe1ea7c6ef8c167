"""Attitude from the raw sensors of a real autopilot, against the autopilot's own (Spica Sec. 6.1, our data)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uavlab import so3
from uavlab.datasets.conventions import matrices_from_quaternions
from uavlab.experiments.answers import answer
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.types import Array, Mat3

GAIN = 0.5  # [1/s]: slow against the shakes of a hand, quick against what is left of the gyro bias
STILL = (
    2.0  # [s] at the start, in which the autopilot lies on the bench: the gyro bias is taken there
)
MOVED = (2.3, 6.5)  # [s] in which it is turned about; it lies still again afterwards
LAGS = np.arange(-0.020, 0.021, 0.002)  # [s]
GAINS = np.array((0.1, 0.2, 0.5, 1.0, 2.0, 5.0))  # [1/s]
DATA = "px4-sample"


class Recorded(NamedTuple):
    """What the filter is given, at the times of the gyro, and what it is compared with."""

    t: Array  # (N,) [s]
    gyro: Array  # (N, 3) [rad/s], body
    q_meas: Array  # (N, 4) attitude by gravity and magnetic north, body → world
    t_ekf: Array  # (A,) [s]
    R_ekf: Array  # (A, 3, 3) body → world, by EKF2


def recorded() -> Recorded:
    """The PX4 log, with an attitude of each accelerometer and magnetometer sample."""
    from uavlab.datasets import fetch, read_px4

    log = read_px4(fetch(DATA))
    field = np.stack([np.interp(log.t_imu, log.t_mag, x) for x in log.mag.T], axis=1)
    q_meas = [
        so3.quaternion_from_rotation(attitude_of(f, m))
        for f, m in zip(log.accel, field, strict=True)
    ]
    return Recorded(log.t_imu, log.gyro, np.array(q_meas), log.t, log.R)


def attitude_of(accel: Array, field: Array) -> Mat3:
    """Attitude body → world (3, 3) of specific force [m/s²] and magnetic field, body, (3,) each.

    Specific force is taken for up, and magnetic north for north: at rest, and without declination.
    """
    up = accel / np.linalg.norm(accel)
    east = np.cross(field, up)
    east = east / np.linalg.norm(east)
    return np.stack((east, np.cross(up, east), up))


def filtered(seen: Recorded, gain: float = GAIN) -> Array:
    """Attitudes (N, 3, 3) by the passive filter, less the gyro bias at rest (Spica Sec. 5.1)."""
    step = answer("complementary", "attitude_step")
    bias = answer("identification", "gyro_bias")(seen.gyro[seen.t < STILL], 0.01)
    q, out = seen.q_meas[0], np.empty((len(seen.t), 4))
    for k, dt in enumerate(np.diff(seen.t, prepend=seen.t[0])):
        q = out[k] = step(q, seen.gyro[k] - bias, seen.q_meas[k], gain, float(dt))
    return matrices_from_quaternions(out)


def errors(seen: Recorded, R: Array, lag: float = 0.0) -> tuple[Array, Array, Array]:
    """Errors of tilt, attitude and heading (A,) [deg] of `R` (N, 3, 3), if EKF2's stamps are `lag` [s] late."""
    at = seen.t_ekf - lag
    ours = np.stack([np.interp(at, seen.t, x) for x in R.reshape(-1, 9).T], axis=1)
    U, _, Vt = np.linalg.svd(ours.reshape(-1, 3, 3))
    ours = U @ Vt  # between two samples 4 ms apart: the nearest rotation
    tilt = np.arccos(np.clip(np.sum(ours[:, 2] * seen.R_ekf[:, 2], axis=1), -1.0, 1.0))
    whole = np.arccos(np.clip(0.5 * (np.sum(ours * seen.R_ekf, axis=(1, 2)) - 1.0), -1.0, 1.0))
    turned = _headings(ours) - _headings(seen.R_ekf)
    return np.rad2deg(tilt), np.rad2deg(whole), np.rad2deg(np.angle(np.exp(1j * turned)))


def run(seeds: int) -> Outcome:
    """One recording: nothing is left to chance."""
    del seeds
    seen = recorded()
    ours = filtered(seen)
    moving = (seen.t_ekf > MOVED[0]) & (seen.t_ekf < MOVED[1])
    by_lag = np.array([[_rms(x[moving]) for x in errors(seen, ours, lag)] for lag in LAGS])
    lag = float(LAGS[np.argmin(by_lag[:, 0])])
    tilt, whole, heading = errors(seen, ours)
    late = errors(seen, ours, lag)
    raw = errors(seen, matrices_from_quaternions(seen.q_meas), lag)
    band, wide = Band(0.0, 0.3), Band(0.0, 2.0)
    rows = (
        Row("whole recording, as stamped: tilt, rms [deg]", "—", _rms(tilt), band),
        Row("whole recording, as stamped: attitude, rms [deg]", "—", _rms(whole), wide),
        Row("while it is turned, stamps corrected: tilt, rms [deg]", "—", _rms(late[0][moving]), band),
        Row("while it is turned, stamps corrected: attitude, rms [deg]", "—", _rms(late[1][moving]), wide),
        Row("while it is turned, as stamped: tilt, rms [deg]", "—", _rms(tilt[moving])),
        Row("while it is turned, as stamped: attitude, rms [deg]", "—", _rms(whole[moving])),
        Row("lateness of EKF2's stamps, from the data [ms]", "—", 1e3 * lag),
        Row("heading, mean error [deg]", "—", heading.mean()),
        Row("while it is turned, no gyro: tilt, rms [deg]", "—", _rms(raw[0][moving])),
        Row("while it is turned, no gyro: attitude, rms [deg]", "—", _rms(raw[1][moving])),
    )  # fmt: skip
    remarks = (
        f"Passive filter with a gain of {GAIN:g} 1/s on the raw gyro, accelerometer and magnetometer of {DATA}, from "
        f"the first sample on; the gyro bias is that of the first {STILL:g} s, at rest. Nothing else was calibrated.",
        "The log has no position, so EKF2 knew no declination: its north is magnetic north, and so is ours. "
        "No angle was fitted.",
        f"The board is turned about for {MOVED[1] - MOVED[0]:.1f} of 69 s and lies still for the rest, so the rms over "
        "all of it flatters. While it is turned, the tilt as stamped misses the band of 0.3°: EKF2's attitude is "
        f"that of {1e3 * lag:.0f} ms before its stamp (EKF2 runs every 8 ms), and at 3 rad/s that is a degree or so.",
        "It was handled on a bench: long accelerations, which this filter takes for tilt, are missing.",
    )
    sweep = np.array([
        [_rms(x[moving]) for x in errors(seen, filtered(seen, g), lag)] for g in GAINS
    ])
    return Outcome(rows, _panels(seen, ours, (late, raw), (by_lag, sweep), lag), remarks)


def _panels(
    seen: Recorded, ours: Array, of: tuple[Any, Any], swept: tuple[Array, Array], lag: float
) -> tuple[Panel, ...]:
    shown, (late, raw), (by_lag, sweep) = (MOVED[0] - 0.5, MOVED[1] + 0.5), of, swept
    k, k_ekf = ((t > shown[0]) & (t < shown[1]) for t in (seen.t, seen.t_ekf))
    t, t_ekf = seen.t[k], seen.t_ekf[k_ekf] - lag
    early = seen.t_ekf < 12.0
    lean = [np.rad2deg(np.arccos(R[:, 2, 2])) for R in (seen.R_ekf[k_ekf], ours[k])]
    turn = [np.rad2deg(np.unwrap(_headings(R))) for R in (seen.R_ekf[k_ekf], ours[k])]
    return (
        Panel("Tilt while the board is turned", "time [s]", "tilt [deg]",
              (Line("EKF2", t_ekf, lean[0], "truth"), Line("filter", t, lean[1]))),
        Panel("Heading while the board is turned", "time [s]", "heading from east [deg]",
              (Line("EKF2", t_ekf, turn[0], "truth"), Line("filter", t, turn[1]))),
        Panel("Errors against EKF2, stamps corrected", "time [s]", "error [deg]",
              (Line("tilt without the gyro", seen.t_ekf[early], raw[0][early]),
               Line("attitude", seen.t_ekf[early], late[1][early]), Line("tilt", seen.t_ekf[early], late[0][early])),
              ((MOVED[0], "turned"), (MOVED[1], "still again")), log_y=True),
        Panel("How late EKF2's stamps are, while the board is turned", "lateness [ms]", "rms error [deg]",
              (Line("attitude", 1e3 * LAGS, by_lag[:, 1]), Line("tilt", 1e3 * LAGS, by_lag[:, 0]),
               Line("band of tilt", 1e3 * LAGS, np.full(len(LAGS), 0.3), "dashed"))),
        Panel("What the gain does while the board is turned", "gain [1/s]", "rms error [deg]",
              (Line("attitude", GAINS, sweep[:, 1]), Line("tilt", GAINS, sweep[:, 0])), ((GAIN, "flown"),)),
    )  # fmt: skip


def _headings(R: Array) -> Array:
    return np.arctan2(R[:, 1, 0], R[:, 0, 0])


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x**2)))


EXPERIMENTS = (
    Experiment(
        "real-px4",
        "Attitude from raw sensors against the autopilot's EKF2",
        "Spica Sec. 6.1, PX4 log",
        run,
        seeds=1,
    ),
)
