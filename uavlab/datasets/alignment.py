"""An inertial unit with a clock, axes and a heading of its own, brought together with the track of the aircraft.

The rates of the track's attitudes are the unit's rates in other axes and at other times. The lag is where they agree
best, and the axes follow by least squares (Wahba's problem). In level flight up is up however the case is turned about
the vertical, so that turn is left to the rates. The two others are taken from what both call up: that is what the
accelerometers feel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab import so3
from uavlab.datasets.phantom import DotImu, RtkTrack
from uavlab.errors import BadInput
from uavlab.types import Array, Mat3

WINDOW = 0.2  # [s] in which rates are compared: from one attitude of the track to the next but one
STRANGERS = 0.5  # share of the rates left over, above which two recordings are not of one flight
TURNING = 0.02  # [rad/s] rms about a second axis, below which the axes cannot be told


class Alignment(NamedTuple):
    """How an inertial unit sat in the aircraft, and when; and how well that is known."""

    lag: float  # [s] the track's time is the unit's time plus this
    M: Mat3  # (3, 3) case of the unit → body (FLU) of the aircraft
    heading: float  # [rad] how far the unit's own world is turned in the track's
    left: float  # rms share of the track's rates that the unit's do not explain, 0 to 1
    tilt: float  # [rad] rms angle between what the two call up
    wander: float  # [rad] standard deviation of the unit's heading against the track's


def align(track: RtkTrack, imu: DotImu, *, reach: float = 3.0) -> Alignment:
    """Find clock, axes and heading of `imu` from the flight itself.

    Parameters
    ----------
    track : RtkTrack
        Attitudes of the aircraft in time, body → world.
    imu : DotImu
        Rates and attitudes of the unit, case and own world, own clock.
    reach : float
        The lag is looked for in ±reach [s].

    Raises
    ------
    BadInput
        They do not overlap, the aircraft did not turn about two axes, or they are not of one flight.
    """
    t, rates = rates_of_attitudes(track.t, track.R)
    coarse = np.arange(-reach, reach + 0.05, 0.1)
    near = min((_mounting(t, rates, imu, lag)[0], lag) for lag in coarse)[1]
    fine = near + np.arange(-0.1, 0.105, 0.01)
    left, lag = min((_mounting(t, rates, imu, lag)[0], lag) for lag in fine)
    if not left <= STRANGERS:
        raise BadInput(
            f"alignment: {100 * left:.0f} % of the track's rates are not in the inertial unit's, even at the best lag "
            f"within ±{reach:g} s; allowed {100 * STRANGERS:.0f} %. Are both of the same flight?"
        )
    R, R_imu = _both(track, imu, lag)
    M = _levelled(R[:, 2], R_imu[:, 2], _mounting(t, rates, imu, lag)[1])
    up = np.einsum("nj,ij->ni", R_imu[:, 2], M)
    apart = np.arcsin(np.clip(np.linalg.norm(np.cross(up, R[:, 2]), axis=1), 0.0, 1.0))
    forward = R_imu @ M.T  # body → the unit's own world
    turned = np.exp(1j * (_headings(R) - _headings(forward)))
    heading = float(np.angle(turned.mean()))
    wander = float(np.angle(turned * np.exp(-1j * heading)).std())
    return Alignment(float(lag), M, heading, left, float(np.sqrt(np.mean(apart**2))), wander)


def rates_of_attitudes(t: Array, R: Array) -> tuple[Array, Array]:
    """Times (N − 2,) [s] and body rates (N − 2, 3) [rad/s] of attitudes `R` (N, 3, 3) at `t` (N,) [s].

    Each is the mean rate between the neighbours of a time.
    """
    turns = np.array([so3.log(a.T @ b) for a, b in zip(R[:-2], R[2:], strict=True)])
    return t[1:-1], turns / (t[2:] - t[:-2])[:, None]


def averaged(t: Array, x: Array, at: Array, window: float) -> Array:
    """Means of `x` (N, k), sampled at `t` (N,) [s], over `window` [s] about each of the times `at` (M,) → (M, k)."""
    steps = 0.5 * (x[1:] + x[:-1]) * np.diff(t)[:, None]
    whole = np.concatenate((np.zeros((1, x.shape[1])), np.cumsum(steps, axis=0)))
    ends = [
        np.stack([np.interp(at + side * window / 2, t, column) for column in whole.T], axis=1)
        for side in (1, -1)
    ]
    return (ends[0] - ends[1]) / window


def _mounting(t: Array, rates: Array, imu: DotImu, lag: float) -> tuple[float, Mat3]:
    """The turn case → body that explains the rates best at this lag, and the rms share that it leaves (Wahba)."""
    there = _within(t, imu, lag)
    mine = averaged(imu.t, imu.gyro, t[there] - lag, WINDOW)
    theirs = rates[there] - rates[there].mean(axis=0)  # means are biases
    mine = mine - mine.mean(axis=0)
    if len(mine) and np.linalg.svd(theirs, compute_uv=False)[1] < TURNING * np.sqrt(len(theirs)):
        raise BadInput(
            f"alignment: the aircraft turned about one axis only (rms about a second is below {TURNING:g} rad/s), so "
            "the unit's axes cannot be told. Take a flight that rolls and pitches."
        )
    M = so3.project(theirs.T @ mine)
    left = theirs - mine @ M.T
    return float(np.sqrt(np.sum(left**2) / np.sum(theirs**2))), M


def _within(t: Array, imu: DotImu, lag: float) -> Array:
    """Which of the track's times (N,) [s] the unit saw as well."""
    there = (t - lag > imu.t[0] + WINDOW) & (t - lag < imu.t[-1] - WINDOW)
    if there.sum() < 0.5 * len(t):
        raise BadInput(
            f"alignment: at a lag of {lag:.2f} s only {there.sum()} of {len(t)} attitudes lie within the inertial "
            "unit's recording; at least half must. Look for the lag in a smaller reach."
        )
    return there


def _both(track: RtkTrack, imu: DotImu, lag: float) -> tuple[Array, Array]:
    """The track's attitudes and the unit's at the nearest sample, (n, 3, 3) each, where both recorded."""
    there = _within(track.t, imu, lag)
    nearest = np.interp(track.t[there] - lag, imu.t, np.arange(len(imu.t)))
    return track.R[there], imu.R[np.rint(nearest).astype(int)]


def _levelled(up: Array, up_imu: Array, M: Mat3) -> Mat3:
    """`M` turned about body x and y so that both agree on what is up (n, 3), body and case."""
    for _ in range(3):  # least squares for a small turn, and again
        seen = up_imu @ M.T
        # δ × seen = up − seen, for δ = (δ_x, δ_y, 0)
        zero = np.zeros(len(seen))
        about_x = np.stack((zero, -seen[:, 2], seen[:, 1]), axis=1)
        about_y = np.stack((seen[:, 2], zero, -seen[:, 0]), axis=1)
        A = np.stack((about_x.ravel(), about_y.ravel()), axis=1)
        x, y = np.linalg.lstsq(A, (up - seen).ravel(), rcond=None)[0]
        M = so3.exp(np.array((x, y, 0.0))) @ M
    return M


def _headings(R: Array) -> Array:
    """Headings (N,) [rad] of attitudes (N, 3, 3)."""
    return np.arctan2(R[:, 1, 0], R[:, 0, 0])
