"""Attitude from a wrong start: almost all of them are forgotten (Spica eq. 12, Bangura Sec. II-D; 002-175)."""

from __future__ import annotations

import numpy as np

from uavlab import so3
from uavlab.experiments.answers import answer
from uavlab.experiments.coupled_flights import filtered, wandering
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.types import Array, Estimate, Mat3

WORST = np.deg2rad(175.0)
STARTS = 200
RATE = 25.0  # [Hz], to keep 200 flights short
SECONDS = 30.0  # the attitude is there in five; what it taught the biases meanwhile takes longer to forget
ATTITUDE = np.deg2rad(2.0)  # [rad] noise of the attitude that the passive filter is given
GAIN = 2.0  # [1/s] of the passive filter
THERE = 5.0  # [deg] mean error of the last two seconds, below which a start is forgotten
MOST = 0.95  # share that we call almost all


def wrong_start(seed: int) -> tuple[Mat3, float]:
    """A turn about any axis by an angle of up to 175°, evenly; and that angle [rad]."""
    rng = np.random.default_rng([175, seed])
    axis, angle = rng.standard_normal(3), rng.uniform(0.0, WORST)
    return so3.exp(axis / np.linalg.norm(axis) * angle), angle


def coupled_errors(seed: int) -> Array:
    """Errors (M,) [deg] of the coupled filters in time, both begun at the same wrong attitude."""
    true, rng = wandering(seed, SECONDS, (1.6, 1.6, 1.0), (7.0, 9.0, 6.0), rate=RATE)
    zero = np.zeros(3)
    start = Estimate(true.r[0], true.v[0], zero, true.R[0] @ wrong_start(seed)[0], zero)
    return filtered(true, rng, start=start).turned


def passive_errors(seed: int) -> Array:
    """Errors (M,) [deg] of the passive filter in time, which is given a noisy attitude."""
    step = answer("complementary", "attitude_step")
    true, rng = wandering(seed, SECONDS, (1.6, 1.6, 1.0), (7.0, 9.0, 6.0), rate=RATE)
    q = so3.quaternion_from_rotation(true.R[0] @ wrong_start(seed)[0])
    off = np.empty(len(true.t) - 1)
    shakes = ATTITUDE * rng.standard_normal((len(true.t), 3))
    for k in range(len(off)):
        seen = so3.quaternion_from_rotation(true.R[k] @ so3.exp(shakes[k]))
        q = step(q, true.omega[k], seen, GAIN, true.dt)
        off[k] = so3.angle(so3.rotation_from_quaternion(q), true.R[k + 1])
    return np.rad2deg(off)


def run(seeds: int) -> Outcome:
    """002-175."""
    begun = np.rad2deg([wrong_start(s)[1] for s in range(seeds)])
    rows, panels = [], []
    t = np.arange(1, round(SECONDS * RATE)) / RATE
    band = Band(MOST, 1.0)
    for what, fly in (("passive filter", passive_errors), ("coupled filters", coupled_errors)):
        off = np.array([fly(s) for s in range(seeds)])
        end = off[:, -round(2 * RATE) :].mean(axis=1)
        there = end < THERE
        far = there[begun > 120.0]
        rows += [
            Row(f"{what}: share of all starts that are forgotten", "almost all", there.mean(), band),
            Row(f"{what}: the same, of those beyond 120°", "almost all", far.mean() if len(far) else np.nan),
            Row(f"{what}: error at the end, median [deg]", "—", float(np.median(end))),
            Row(f"{what}: error at the end, largest [deg]", "—", end.max()),
        ]  # fmt: skip
        some = (Line("", t, x) for x in off[:: max(seeds // 25, 1)][:25])
        lines = (*some, Line(f"{THERE:g}°", t, np.full(len(t), THERE), "paper"))
        title = f"{what}: {int(there.sum())} of {seeds} starts are forgotten"
        panels.append(Panel(title, "time [s]", "attitude error [deg]", lines, log_y=True))
        panels.append(Panel(f"{what}: from where, to where", "error at the start [deg]", "error at the end [deg]",
                            (Line("starts", begun, end, "points"),), log_y=True))  # fmt: skip
    remarks = (
        f"{seeds} starts, turned about any axis by up to 175°, evenly; {SECONDS:g} s at {RATE:g} Hz. Forgotten: the "
        f"mean error of the last two seconds is below {THERE:g}°. We call {100 * MOST:g} % almost all; no paper says "
        "how many.",
        "The passive filter is given an attitude with 2° of noise; the coupled filters have only IMU, magnetometer, "
        "barometer and the velocity of motion capture, and both begin at the same wrong attitude.",
    )
    return Outcome(tuple(rows), tuple(panels), remarks)


EXPERIMENTS = (
    Experiment("002-175", "Attitude from a start wrong by up to 175°", "Bangura Sec. II-D, Spica eq. 12", run, STARTS),
)  # fmt: skip
