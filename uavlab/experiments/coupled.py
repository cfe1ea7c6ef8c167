"""The coupled filters of Bangura at low speed, at high speed, and beside others (002-2, 002-3, 002-7)."""

from __future__ import annotations

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.coupled_flights import (
    RATE,
    SETTLED,
    Flown,
    attitude_panel,
    errors,
    filtered,
    scaling_panel,
    speed_panels,
    wandering,
)
from uavlab.experiments.motion import PAPER_C, PAPER_PARTS, QUIET, Noise
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.types import GRAVITY

LOW = (1.6, 1.6, 1.0)  # [m/s] top speeds, Table IV
HIGH = (14.8, 8.0, 5.0)
GNSS = Noise(velocity=0.1, rate=10.0)
PARASITIC = PAPER_PARTS[0] * np.sqrt(GRAVITY)  # [1/m] of Bangura's quadratic fit, in hover
LOOSE = (
    "a few flights pull the mean up: V_z is made with the estimated tilt (errata), and at 14 m/s ten degrees of tilt "
    "are 2.5 m/s of V_z; with drag told as wrong as here the tilt of Filter 1 follows it, and u shows it (to 1.6)"
)
HOW = (
    f"Smooth flights by chance, {RATE:g} Hz; errors count after {SETTLED:g} s. Noise, all ours: {QUIET.accel} m/s² "
    f"and {QUIET.gyro} rad/s, biases of {QUIET.accel_bias} m/s² (what zeroing in hover leaves) "
    f"and {QUIET.gyro_bias} rad/s (1σ)."
)


def low_speed(seed: int) -> Flown:
    """To 1.6 m/s, with motion capture at 40 Hz."""
    true, rng = wandering(seed, 20.0, LOW, (7.0, 9.0, 6.0))
    return filtered(true, rng)


def high_speed(seed: int, c: float, rotor: float, parasitic: float) -> Flown:
    """To 14.8 m/s with GPS, on an aircraft whose drag is `rotor` and `parasitic`, and a filter that is told `c`."""
    true, rng = wandering(seed, 25.0, HIGH, (20.0, 14.0, 11.0), c=rotor, parasitic=parasitic)
    return filtered(true, rng, GNSS, c=c)


def best_linear(seed: int = 0) -> float:
    """The linear c [1/√m] that a calibration flight finds on the aircraft with quadratic drag (along body x)."""
    true, _ = wandering(seed, 60.0, HIGH, (20.0, 14.0, 11.0), c=PAPER_PARTS[1], parasitic=PARASITIC)
    return float(answer("identification", "drag_coefficient")(true.force, true.V[:, :2])[0][0])


def run_low(seeds: int) -> Outcome:
    """002-2."""
    flights = [low_speed(s) for s in range(seeds)]
    mean, std = errors(flights)
    turned = np.array([x.turned[x.t > SETTLED].mean() for x in flights])
    papers = (("0.1349", "0.0210"), ("0.1291", "0.0281"), ("0.1552", "0.0428"))
    rows = []
    for i, (axis, (m, s)) in enumerate(zip("xyz", papers, strict=True)):
        rows += [
            Row(f"mean error of V_{axis} [m/s]", m, mean[:, i].mean(), Band(0.0, 0.16), mean[:, i].std()),
            Row("standard deviation of that error [m/s]", s, std[:, i].mean()),
        ]  # fmt: skip
    band = Band(0.0, 2.0)
    rows.append(Row("mean error of the attitude [deg]", "negligible", turned.mean(), band, turned.std()))  # fmt: skip
    panels = (*speed_panels(flights[0], "Bangura's mean error 0.13 to 0.16"), attitude_panel(flights[0]),
              scaling_panel(flights[0]))  # fmt: skip
    remarks = (HOW, f"Velocity over ground at {QUIET.rate:g} Hz with {QUIET.velocity} m/s; no wind.",
               "What is wrong is nearly constant in a flight: the accelerometer's bias over c √g, 0.08 m/s for "
               "0.02 m/s².")  # fmt: skip
    return Outcome(tuple(rows), panels, remarks)


def run_high(seeds: int) -> Outcome:
    """002-3."""
    c = best_linear()
    linear = [high_speed(s, PAPER_C, PAPER_C, 0.0) for s in range(seeds)]
    fitted = [high_speed(s, c, PAPER_PARTS[1], PARASITIC) for s in range(seeds)]
    printed = [high_speed(s, PAPER_C, PAPER_PARTS[1], PARASITIC) for s in range(seeds)]
    rows = (
        *_high_rows("linear drag", linear, (0.5, 0.5, 0.5)),
        *_high_rows("quadratic drag", fitted, (1.5, 1.5, 2.0)),
        *_high_rows("quadratic drag, filter told c = 0.0794", printed, None),
    )
    remarks = (
        HOW,
        "Errors are against the truth; Bangura's are against GPS, whose noise is in them.",
        f"Linear: rotor drag of {PAPER_C}, as the filter is told. Quadratic: the aircraft has the drag of Bangura's "
        f"quadratic fit, {PAPER_PARTS[0]} V|V| + {PAPER_PARTS[1]} V, and the filter is told c = {c:.4f}, the line "
        "that a calibration flight at these speeds finds. His own line, 0.0794, does not fit his parabola (errata: 44 "
        "% at 14 m/s, three times at low speed), so what it gives is told and not judged.",
    )
    panels = (*speed_panels(linear[0], "linear drag"), *speed_panels(fitted[0], "quadratic drag"))
    return Outcome(rows, panels, remarks)


def _high_rows(
    what: str, flights: list[Flown], bands: tuple[float, float, float] | None
) -> list[Row]:
    mean, std = errors(flights)
    papers = (("1.3713", "1.1818"), ("0.7676", "0.9676"), ("1.6571", "1.9896"))
    rows = []
    for i, (axis, (m, s)) in enumerate(zip("xyz", papers, strict=True)):
        band = Band(0.0, bands[i]) if bands else None
        ours = float(mean[:, i].mean())
        note = LOOSE if band and ours > band.high else ""
        name = f"{what}: mean error of V_{axis} [m/s]"
        rows.append(Row(name, m, ours, band, float(mean[:, i].std()), note))
        if note:
            rows.append(
                Row(
                    f"{what}: the same, median of the flights [m/s]",
                    m,
                    float(np.median(mean[:, i])),
                )
            )
        if bands:
            rows.append(Row(f"{what}: standard deviation of that error [m/s]", s, std[:, i].mean()))
    return rows


def run_table(seeds: int) -> Outcome:
    """002-7: context only."""
    low = errors([low_speed(s) for s in range(seeds)])[0]
    high = errors([high_speed(s, PAPER_C, PAPER_C, 0.0) for s in range(seeds)])[0]
    others = (
        ("System dynamics [31], to 2 m/s", "0.5"), ("Davis [29], below 2 m/s", "0.1"),
        ("Arain [25], to 6 m/s", "2"), ("Leishman [44], to 3 m/s", "0.5"),
    )  # fmt: skip
    said = "; ".join(f"{name}: {value} m/s" for name, value in others)
    rows = (
        Row("coupled, low speed (1.6 m/s): mean error [m/s]", "0.15", low.mean(), None, low.mean(axis=1).std()),
        Row("coupled, high speed (14.5 m/s): mean error [m/s]", "1.26", high.mean(), None, high.mean(axis=1).std()),
    )  # fmt: skip
    places = np.arange(6.0)
    values = np.array((0.15, 1.26, 0.5, 0.1, 2.0, 0.5))
    panel = Panel("Table III: mean errors as printed, and ours", "0, 1: coupled, low, high; then [31] [29] [25] [44]",
                  "mean error [m/s]", (Line("printed", places, values, "points"),
                  Line("ours", places[:2], np.array((low.mean(), high.mean())), "points")))  # fmt: skip
    remarks = (f"Context only, nothing is judged. Others, as Table III prints them: {said}.", HOW,
               "Table III prints 0.15 for low speed; the mean of Table IV's numbers is 0.14 (errata).")  # fmt: skip
    return Outcome(rows, (panel,), remarks)


EXPERIMENTS = (
    Experiment("002-2", "Velocity and attitude at low speed", "Bangura Fig. 9, Table IV", run_low),
    Experiment("002-3", "Velocity at high speed", "Bangura Fig. 8, Table IV", run_high),
    Experiment("002-7", "Errors beside those of others", "Bangura Table III", run_table),
)
