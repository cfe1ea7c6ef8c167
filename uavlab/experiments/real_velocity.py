"""Velocity of a real aircraft from its inertial unit alone, with the drag coefficient of its other flights."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.real_flights import FLIGHTS, UNITS, Flown, all_flown, offsets, pooled
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.types import Array

ZEROED = 5.0  # [s] at the start in which RTK velocity helps to find the offset (Bangura V-A, the online calibration)
HIGH, LOW = Band(0.0, 1.5), Band(0.0, 0.16)  # [m/s] what rows 002-3 and 002-2 accept for x and y
LOW_SPEED = 1.6  # [m/s] up to which a flight is compared with Bangura's low speeds
WHY = {
    "blind": "wind and bias differ from those of the other flights",
    "zeroed": "the wind is not that of the first seconds",
}
PAPER = {
    0: (1.3713, 0.1349),
    1: (0.7676, 0.1291),
}  # Table IV: mean error along x and y, high and low


class Told(NamedTuple):
    """Velocity through the air as the unit tells it, on a flight whose RTK track took no part in the calibration."""

    one: Flown
    c: float  # [1/√m], from the other flights
    blind: Array  # (N, 2) [m/s], body x and y: offset from the other flights as well
    zeroed: Array  # (N, 2) [m/s], offset from the first seconds of this flight
    later: Array  # (N,) bool, after those seconds


def told(one: Flown, others: list[Flown]) -> Told:
    """Apply what the same unit learnt on `others` to `one`; the others never contain the flight itself."""
    drag_velocity = answer("complementary", "drag_velocity")
    c = pooled(others)
    V = np.array([drag_velocity(a, c) for a in one.accel])
    learnt = offsets(others, c).mean(axis=0)
    later = one.t > one.t[0] + ZEROED
    here = (V - one.V[:, :2])[~later].mean(axis=0)
    return Told(one, c, V - learnt / c, V - here, later)


def all_told() -> list[Told]:
    """Each unit on each flight, calibrated on the four others."""
    those = all_flown()
    return [
        told(one, [x for x in those if x.unit == one.unit and x.flight != one.flight])
        for one in those
    ]


def errors(V: Array, one: Told) -> Array:
    """(2,) mean absolute error along body x and y [m/s], after the first seconds."""
    return np.abs(V - one.one.V[:, :2])[one.later].mean(axis=0)


def run(seeds: int) -> Outcome:
    """Ten recordings: nothing is left to chance."""
    del seeds
    those = all_told()
    rows = tuple(
        row for flight in FLIGHTS for row in _rows([x for x in those if x.one.flight == flight])
    )
    return Outcome(rows, _panels(those), _remarks(those))  # fmt: skip


def _rows(mine: list[Told]) -> list[Row]:
    """What the two units say of one flight: with the offset of the other flights, and with its own."""
    one = mine[0].one
    rows = []
    for how, what in (("blind", "IMU alone"), ("zeroed", f"offset of its first {ZEROED:g} s")):
        found = np.array([errors(getattr(x, how), x) for x in mine])
        for i, axis in enumerate("xy"):
            top = np.abs(one.V[:, i]).max()
            slow = top <= LOW_SPEED
            band, ours = LOW if slow else HIGH, float(found[:, i].mean())
            rows.append(Row(
                f"{one.flight}, {what}: mean error along {axis}, to {top:.1f} m/s [m/s]", f"{PAPER[i][int(slow)]:g}",
                ours, band, float(found[:, i].std()), "" if ours <= band.high else WHY[how],
            ))  # fmt: skip
    return rows


def _remarks(those: list[Told]) -> tuple[str, ...]:
    cs = [x.c for x in those]
    jumps = np.array([x.blind[0] - x.zeroed[0] for x in those])
    return (
        f"c is that of the four other flights of the same unit ({min(cs):.4f} to {max(cs):.4f}); only axes and "
        "clock of the unit were aligned on the flight that is judged. Specific force is a mean over half a second. "
        "Errors count after the first 5 s.",
        "IMU alone: the offset, too, comes from the other flights. Drag tells the velocity through the air, RTK that "
        "over ground; the wind of a flight is not known. The offsets differ by up to "
        f"{np.abs(jumps).max():.1f} m/s from those of the start of the flight itself. A bias of 0.1 m/s² makes 0.4 m/s "
        "of it; the rest is wind.",
        f"Offset of its first {ZEROED:g} s: Bangura zeroes the offset in hover while there is a velocity over ground; "
        "these flights do not hover, so the mean over the start is taken. It removes what stays the same.",
        "Bands are those of 002-3, and of 002-2 where the speed along the axis stays below 1.6 m/s. Bangura's Table "
        "III: 0.15 m/s (low) and 1.26 m/s (high) his own, 0.5 m/s (Burri, Leishman), 0.1 m/s (Davis), 2 m/s (Arain).",
        "Along y, line-1 and vertical-1 move slower than the air does: what is told there is the wind and how it "
        "changes, which no band made indoors allows for.",
        "Data: A. Hurwitz and I. Klein, 2023, CC BY 4.0.",
    )


def _panels(those: list[Told]) -> tuple[Panel, ...]:
    panels = []
    for x in those:
        if x.one.unit != UNITS[0]:
            continue
        for i, axis in enumerate("xy"):
            high, low = PAPER[i]
            panels.append(Panel(
                f"{x.one.name}, body {axis} (Bangura {high:.2f} high, {low:.2f} low)", "time [s]", "velocity [m/s]", (
                    Line("RTK", x.one.t, x.one.V[:, i], "truth"), Line("IMU alone", x.one.t, x.blind[:, i]),
                    Line("offset of its start", x.one.t, x.zeroed[:, i])),
                ((x.one.t[0] + ZEROED, "errors count"),)))  # fmt: skip
    return tuple(panels)


EXPERIMENTS = (
    Experiment(
        "real-velocity",
        "Velocity of a Phantom 4 from its IMU alone",
        "Bangura Sec. V-B Tables III, IV, flights of Hurwitz and Klein",
        run,
        seeds=1,
    ),
)
