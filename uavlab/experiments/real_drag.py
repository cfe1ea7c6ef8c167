"""The drag coefficient of a real aircraft: inertial units against RTK velocity (Bangura Sec. V-A, on our data)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.real_flights import EXCITED, FLIGHTS, UNITS, Flown, all_flown, pooled
from uavlab.experiments.spec import Experiment, Line, Outcome, Panel, Row
from uavlab.types import Array

PAPER_C, PAPER_R2 = 0.0794, 0.4272
PAPER_QUADRATIC, PAPER_QUADRATIC_R2 = (0.00209, 0.02586, 0.0162), 0.4736


class Fit(NamedTuple):
    """What one unit on one flight says of the drag; each (2,), along body x and y."""

    c: Array  # [1/√m]
    offset: Array
    r2: Array
    quadratic: Array  # (2, 2) of V|V| and of V
    quadratic_r2: Array
    std: Array  # standard deviation of the velocity [m/s]


def fit(one: Flown) -> Fit:
    """Both drag models, by the reference answers of the identification lab."""
    c, offset, r2 = answer("identification", "drag_coefficient")(one.accel, one.V[:, :2])
    c_2, c_1, _, more = answer("identification", "quadratic_drag")(one.accel, one.V[:, :2])
    parts = np.stack((c_2, c_1), axis=1)
    return Fit(c, offset, r2, parts, more, one.V[:, :2].std(axis=0))


def run(seeds: int) -> Outcome:
    """Ten recordings: nothing is left to chance."""
    del seeds
    those = all_flown()
    fits = [fit(x) for x in those]
    rows = [
        row
        for i, axis in enumerate("xy")
        for f in FLIGHTS
        for row in _rows(f, axis, i, those, fits)
    ]
    lively = [k for k in _pairs(fits) if fits[k[0]].std[k[1]] >= EXCITED]
    rows += [
        Row("c of all flights together, both axes [1/√m]", f"{PAPER_C}", pooled(those)),
        Row("c where excited, mean [1/√m]", f"{PAPER_C}", *_mean_std([fits[k].c[i] for k, i in lively])),
        Row("R² where excited, mean", f"{PAPER_R2}", *_mean_std([fits[k].r2[i] for k, i in lively])),
        Row("R² where excited, quadratic, mean", f"{PAPER_QUADRATIC_R2}",
            *_mean_std([fits[k].quadratic_r2[i] for k, i in lively])),
        Row("part of V|V| where excited, mean", f"{PAPER_QUADRATIC[0]}",
            *_mean_std([fits[k].quadratic[i, 0] for k, i in lively])),
    ]  # fmt: skip
    return Outcome(tuple(rows), _panels(those, fits), _remarks(those, fits))


def _rows(flight: str, axis: str, i: int, those: list[Flown], fits: list[Fit]) -> list[Row]:
    """Rows of c and R² of a flight along one axis: mean over the units, their difference as spread."""
    mine = [x for x, one in zip(fits, those, strict=True) if one.flight == flight]
    std = np.mean([x.std[i] for x in mine])
    what = f"{flight}, body {axis} ({std:.1f} m/s{'' if std >= EXCITED else ', not excited'})"
    return [
        Row(f"c, {what}", f"{PAPER_C}", *_mean_std([x.c[i] for x in mine])),
        Row(f"R², {what}", f"{PAPER_R2}", *_mean_std([x.r2[i] for x in mine])),
    ]


def _remarks(those: list[Flown], fits: list[Fit]) -> tuple[str, ...]:
    lags = ", ".join(f"{x.name} {x.alignment.lag:+.2f} s" for x in those)
    left = max(x.alignment.left for x in those if x.flight != "line-1")
    lean = max(np.rad2deg(x.alignment.tilt) for x in those)
    dull = [
        f"{x.name} {axis}"
        for x, f in zip(those, fits, strict=True)
        for i, axis in enumerate("xy")
        if f.std[i] < EXCITED and x.unit == 1
    ]
    return (
        "Clock, axes and heading of each unit come from the flight itself (uavlab.datasets.alignment). Lags: "
        f"{lags}. The rates agree to {100 * left:.0f} % or better (line-1, which hardly turns, to "
        f"{100 * max(x.alignment.left for x in those):.0f} %), the two verticals to {lean:.1f}° rms.",
        f"An axis is called excited where the velocity along it varies by {EXCITED:g} m/s (standard deviation) or "
        f"more. Not excited: {', '.join(dull)} (and the second unit alike). There c says nothing, even its sign.",
        "The spread of a row is that of the two units, which rode on the same aircraft.",
        "The offset holds the accelerometer's bias and c times the wind along the axis. The heading of a flight varies "
        "by no more than 20°, so the two cannot be told apart, and the wind was not recorded.",
        "Bangura's R² is that of raw GPS velocities; ours is of RTK positions and means over half a second, so where "
        "the axis is excited it is higher. Another aircraft: the coefficient need not be his.",
        "Data: A. Hurwitz and I. Klein, 2023, CC BY 4.0.",
    )


def _panels(those: list[Flown], fits: list[Fit]) -> tuple[Panel, ...]:
    panels = []
    for i, axis in enumerate("xy"):
        cloud = [
            Line(x.flight, x.V[:, i], x.root[:, i] - f.offset[i], "points")
            for x, f in zip(those, fits, strict=True)
            if x.unit == 1 and f.std[i] >= 0.5
        ]
        V = np.linspace(*_ends([line.x for line in cloud]), 50)
        c = pooled(those)
        title = f"Drag along body {axis}: ours c = {c:.4f}, Bangura {PAPER_C} (R² {PAPER_R2})"
        parts = PAPER_QUADRATIC[0] * V * np.abs(V) + PAPER_QUADRATIC[1] * V
        panels.append(
            Panel(title, "velocity over ground [m/s]", "−a/√a_z less offset [√(m/s²)]", (
                *cloud, Line("ours, all flights", V, c * V), Line("Bangura, linear", V, PAPER_C * V, "paper"),
                Line("Bangura, quadratic", V, parts, "dashed"))))  # fmt: skip
    for what, paper in (("c", PAPER_C), ("r2", PAPER_R2)):
        std = np.array([f.std for f in fits])
        values = np.array([getattr(f, what) for f in fits])
        lines = [
            Line(
                f"unit {unit}, body {axis}",
                std[unit - 1 :: 2, i],
                values[unit - 1 :: 2, i],
                "points",
            )
            for unit in UNITS
            for i, axis in enumerate("xy")
        ]
        ends = np.array((0.0, std.max()))
        lines.append(Line("Bangura", ends, np.full(2, paper), "paper"))
        name = {"c": "c [1/√m]", "r2": "R²"}[what]
        panels.append(Panel(f"{name} of each flight", "how much the velocity varies [m/s]", name, tuple(lines),
                            ((EXCITED, "excited from here"),)))  # fmt: skip
    return tuple(panels)


def _pairs(fits: list[Fit]) -> list[tuple[int, int]]:
    return [(k, i) for k in range(len(fits)) for i in range(2)]


def _ends(xs: list[Array]) -> tuple[float, float]:
    return min(float(x.min()) for x in xs), max(float(x.max()) for x in xs)


def _mean_std(x: list[Any]) -> tuple[Any, ...]:
    """Mean, no band, standard deviation."""
    return float(np.mean(x)), None, float(np.std(x))


EXPERIMENTS = (
    Experiment(
        "real-drag",
        "Drag coefficient of a Phantom 4 from IMU and RTK",
        "Bangura Sec. V-A Fig. 6, flights of Hurwitz and Klein",
        run,
        seeds=1,
    ),
)
