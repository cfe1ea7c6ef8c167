"""000-5 and 000-6: a hover on an estimate that is noisy, and on one that jumps, under MPC and under SE(3)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uavlab.experiments.mistaken import (
    AT,
    CONTROLLERS,
    GAINS,
    HEIGHT,
    JUMP,
    LIMITS,
    NAME,
    RATE,
    TOLD,
    asked_axis,
    flown,
    jump,
    lean,
    noise,
)
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.log import Log
from uavlab.flight.metrics import tilt
from uavlab.types import GRAVITY, Array

SIGMAS = (0.0, 0.1, 1.0, 2.0)  # [m] and [m/s], as printed
SETTLE, END = 3.0, 20.0  # [s] of a noisy hover that are left out, and when it ends
PHASE = 10.0  # [s] of each σ in the flight of the figure
NEAR = 0.05  # of the jump: as close is settled
HELD = 10  # ticks for which noise stays in some flights: drawn at 10 Hz
WATCHED = 14.0  # [s], when the flight with the jump ends


class Hover(NamedTuple):
    """One noisy hover in numbers; angles in degrees."""

    swing: float  # standard deviation of the lean about one axis
    asked: float  # the same, of what the controller asked for
    tilt: float  # largest angle from the vertical
    error: float  # largest angle between the thrust axis and the asked one
    drift: float  # [m] largest true distance from where it should stand
    ended: bool  # before its time


def measured(log: Log, name: str) -> Hover:
    """What a hover says after it has settled."""
    late = log.t >= min(SETTLE, log.t[-1])
    axis = asked_axis(log, name)[late]
    R = log.R[late]
    there = np.einsum("nij,nj->ni", R, axis)
    asked = np.arctan2(there[:, :2], there[:, 2, None])
    drift = np.linalg.norm(log.r - log.r[0], axis=1).max()
    return Hover(
        _degrees(lean(R).std()), _degrees(asked.std()), _degrees(tilt(log)[late].max()),
        _degrees(control_error(log, name)[late].max()), float(drift), log.exit.name != "DONE",
    )  # fmt: skip


def control_error(log: Log, name: str) -> Array:
    """Angle between the thrust axis and the asked one [rad], shape (N,)."""
    return np.arccos(np.clip(asked_axis(log, name)[:, 2], -1.0, 1.0))


def _degrees(angle: float) -> float:
    return float(np.rad2deg(angle))


def predicted(sigma: float) -> float:
    """Lean about one axis [deg] that SE(3) asks for on an unfiltered estimate: position and velocity add up."""
    a = np.hypot(GAINS.k_p[0], GAINS.k_v[0]) * sigma
    return _degrees(np.arctan(a / GRAVITY))


# 000-5 -------------------------------------------------------------------------------------------------


def hovers(name: str, sigma: float, seeds: int, axes: int = 2, hold: int = 1) -> list[Hover]:
    """Hovers in noise; without any, nothing is left to chance, and one flight says it all."""
    sizes = np.full(round(END * RATE), sigma)
    errors = (noise(s, sizes, axes, hold) for s in range(seeds if sigma else 1))
    return [measured(flown(name, error, END), name) for error in errors]


def _row(quantity: str, paper: str, each: list[float], band: Band | None = None, note: str = "") -> Row:  # fmt: skip
    return Row(quantity, paper, float(np.mean(each)), band, float(np.std(each)), note)


def noisy_estimate(seeds: int) -> Outcome:
    """MRS Fig. 12."""
    quick = {(x, s): hovers(x, s, seeds) for x in CONTROLLERS for s in SIGMAS}
    held = {(x, s): hovers(x, s, seeds, hold=HELD) for x in CONTROLLERS for s in SIGMAS[2:]}
    high = {x: hovers(x, 1.0, seeds, axes=3) for x in (*CONTROLLERS, TOLD)}
    rows = (*_calm_rows(quick), *_lean_rows(quick, held), *_height_rows(high))
    every = [*quick.values(), *held.values(), *high.values()]
    ended = sum(x.ended for each in every for x in each)
    share = np.mean([x.swing / x.asked for x in quick["SE(3)", 1.0]])
    remarks = (
        f"{NAME}, {END:g} s of hover for each σ and seed, {SETTLE:g} s left out; the same σ in [m] on position and in "
        f"[m/s] on velocity, nothing filtered; attitude and acceleration are true. Safety is off. {ended} of "
        f"{sum(map(len, every))} flights ended before their time.",
        "The paper does not say along which axes the noise was, and how often it was drawn. If not said otherwise: "
        f"along x and y (the height has filters of its own, MRS Sec. 3), and anew at each tick of {RATE:g} Hz.",
        f"MPC with {LIMITS.horizontal.v:g} m/s, {LIMITS.horizontal.a:g} m/s² and {LIMITS.horizontal.j:g} m/s³. SE(3) "
        f"with the gains of {GAINS.source}: the paper does not say which flew.",
        f"SE(3) flies {share:.2f} of the lean that it asks for (σ = 1): its attitude loop, {GAINS.k_R[0]:g}/s, smooths "
        f"what is new at each tick. Noise that stays for {HELD / RATE:g} s, as that of a slow camera, comes through.",
        "With noise along z, too, MPC asks for ±2 m/s² most of the time, whichever way the noise points, so that an "
        "error of the height is met weakly. The mass that it learns (MRS eq. 37) is then too quick, and both swing.",
    )  # fmt: skip
    return Outcome(rows, _noise_panels(quick, held), remarks)


Found = dict[tuple[str, float], list[Hover]]


def _calm_rows(quick: Found) -> list[Row]:
    """What MPC makes of noise."""
    both = _degrees(np.arctan(np.hypot(LIMITS.horizontal.a, LIMITS.horizontal.a) / GRAVITY))
    why = f"x and y may both be at their limit of {LIMITS.horizontal.a:g} m/s²: {both:.1f}°"
    rows = []
    for s in SIGMAS:
        each = [x.tilt for x in quick["MPC", s]]
        rows.append(_row(f"MPC: largest tilt, σ = {s:g} [deg]", "“without excessive tilts”", each,
                         Band(0.0, 15.0), why if s == SIGMAS[-1] else ""))  # fmt: skip
    for s in SIGMAS[1:]:
        each = [x.drift for x in quick["MPC", s]]
        rows.append(_row(f"MPC: largest drift of the truth, σ = {s:g} [m]", "“successfully stabilizes”",
                         each, Band(0.0, 3.0) if s == 1.0 else None))  # fmt: skip
    return rows


def _lean_rows(quick: Found, held: Found) -> list[Row]:
    """What SE(3) makes of it, and how both compare."""
    rows, hard = [], "“excessive tilts”"
    for s in SIGMAS[1:]:
        flights, near = quick["SE(3)", s], predicted(s)
        rows += [
            _row(f"SE(3): lean that it asks for, std, σ = {s:g} [deg]", "—", [x.asked for x in flights],
                 Band(0.8 * near, 1.2 * near),
                 f"band: a fifth around atan(√(k_p² + k_v²) σ / g) = {near:.1f}°; the limit is 60°"),
            _row(f"SE(3): largest tilt, σ = {s:g} [deg]", hard, [x.tilt for x in flights]),
            _row(f"SE(3): largest drift of the truth, σ = {s:g} [m]", "—", [x.drift for x in flights]),
        ]  # fmt: skip
    for said, found, field, why in (
        ("asked for", quick, "asked", ""),
        ("flown", quick, "swing", "the attitude loop smooths what SE(3) asks for; see the next rows"),
        (f"flown, noise held for {HELD / RATE:g} s", held, "swing", ""),
    ):  # fmt: skip
        for s in SIGMAS[2:]:
            pairs = zip(found["SE(3)", s], found["MPC", s], strict=True)
            each = [getattr(x, field) / getattr(y, field) for x, y in pairs]
            what = f"lean of SE(3) over that of MPC, {said}, std, σ = {s:g}"
            rows.append(_row(what, hard, each, Band(2.0, np.inf), why))
    return rows


def _height_rows(high: dict[str, list[Hover]]) -> list[Row]:
    """The same with noise along z, too."""
    why = "the mass that it learns swings, and the height with it; see the next row"
    return [
        _row(f"{name}: largest drift of the truth, noise along all axes, σ = 1 [m]", "—",
             [x.drift for x in flights], None if name == "SE(3)" else Band(0.0, 3.0),
             why if name == "MPC" else "")
        for name, flights in high.items()
    ]  # fmt: skip


def _noise_panels(quick: Found, held: Found) -> tuple[Panel, ...]:
    """Fig. 12 with σ that grows in flight, and what all flights say over σ."""
    sizes = np.repeat(SIGMAS, round(PHASE * RATE))
    marks = tuple((k * PHASE, f"σ = {s:g}") for k, s in enumerate(SIGMAS) if k)
    position, angles, some = [], [], slice(None, None, 4)
    for name in CONTROLLERS:
        log = flown(name, noise(0, sizes), PHASE * len(SIGMAS))
        t = log.t[some]
        position.append(Panel(f"MRS Fig. 12, {name}: position", "time [s]", "x [m]", (
            Line("estimate", t, log.r_e[some, 0], "points"),
            Line("ground truth", t, log.r[some, 0]),
        ), marks))  # fmt: skip
        angles.append(Panel(f"MRS Fig. 12, {name}: tilt", "time [s]", "angle [deg]", (
            Line("tilt control error", t, np.rad2deg(control_error(log, name)[some])),
            Line("tilt", t, np.rad2deg(tilt(log)[some])),
        ), marks))  # fmt: skip

    def mean(found: Found, name: str, field: str) -> Array:
        each = [[getattr(x, field) for x in found[name, s]] for s in SIGMAS if (name, s) in found]
        return np.array([np.mean(x) for x in each])

    x, fine = np.array(SIGMAS), np.linspace(0.0, SIGMAS[-1], 50)
    over = Panel("lean about one axis, standard deviation", "σ [m] and [m/s]", "angle [deg]", (
        Line("atan(√(k_p² + k_v²) σ / g)", fine, np.array([predicted(s) for s in fine]), "paper"),
        *(Line(f"{name}, flown", x, mean(quick, name, "swing")) for name in CONTROLLERS),
        *(Line(f"{name}, flown, noise held", x[2:], mean(held, name, "swing"), "dashed") for name in CONTROLLERS),
        Line("SE(3), asked", x, mean(quick, "SE(3)", "asked")),
    ))  # fmt: skip
    return (*position, *angles, over, _height_panel())


def _height_panel() -> Panel:
    """Noise along all axes, with and without an estimate of the mass."""
    lines = []
    for name in ("MPC", TOLD, "SE(3)"):
        log = flown(name, noise(1, np.ones(round(2.0 * END * RATE)), axes=3), 2.0 * END)
        lines.append(Line(name, log.t[::4], log.r[::4, 2] - HEIGHT))
    return Panel("noise along z, too, σ = 1: height", "time [s]", "error [m]", tuple(lines))


# 000-6 -------------------------------------------------------------------------------------------------


class Reaction(NamedTuple):
    """What a jump of the estimate makes of a hover."""

    log: Log
    away: Array  # (N,) [m] estimated position along x, from where it should be
    tilt: float  # [deg] largest
    speed: float  # [m/s] largest, horizontal
    acceleration: float  # [m/s²] largest, horizontal
    settled: float  # [s] after the jump, until it stays within 5 %
    overshoot: float  # [m]


def reaction(name: str) -> Reaction:
    """One flight with the jump."""
    log = flown(name, jump(), WATCHED)
    away = log.r_e[:, 0] - log.r_d[:, 0]
    after = log.t > AT
    outside = log.t[after & (np.abs(away) > NEAR * JUMP)]
    horizontal = [np.linalg.norm(x[after, :2], axis=1).max() for x in (log.v, log.a)]
    settled = float(outside[-1]) - AT if outside[-1] < log.t[-1] else np.inf
    steep = float(np.rad2deg(tilt(log).max()))
    return Reaction(
        log, away, steep, float(horizontal[0]), float(horizontal[1]), settled, float(max(-away[after].min(), 0.0))
    )  # fmt: skip


def jumping_estimate(seeds: int) -> Outcome:
    """MRS Fig. 13. Nothing is left to chance."""
    mpc, se3 = (reaction(name) for name in CONTROLLERS)
    free = "“unbounded”"
    rows = (
        Row("MPC: largest speed [m/s]", "2", mpc.speed, Band(0.0, 2.1)),
        Row("MPC: largest acceleration [m/s²]", "2", mpc.acceleration, Band(0.0, 2.1)),
        Row("MPC: largest tilt [deg]", "“reasonably small”", mpc.tilt, Band(0.0, 13.0)),
        Row("MPC: until it stays within 5 % [s]", "—", mpc.settled, Band(3.2, 4.5)),
        Row("MPC: overshoot [m]", "—", mpc.overshoot, Band(0.0, 0.3)),
        Row("SE(3): largest tilt [deg]", "“excessive”", se3.tilt, Band(45.0, np.inf)),
        Row("SE(3): largest speed [m/s]", free, se3.speed, Band(5.0, 6.0)),
        Row("SE(3): largest acceleration [m/s²]", free, se3.acceleration),
        Row("SE(3): until it stays within 5 % [s]", "—", se3.settled),
        Row("SE(3): overshoot [m]", "—", se3.overshoot),
    )
    remarks = (
        f"{NAME} in a hover; at {AT:g} s the estimated position jumps by {JUMP:g} m along x, and nobody is told. Else "
        "the estimate is the truth. Emergency landing, failsafe and the check of innovations are off; they would land.",
        f"MPC with {LIMITS.horizontal.v:g} m/s, {LIMITS.horizontal.a:g} m/s² and {LIMITS.horizontal.j:g} m/s³. SE(3) "
        f"with the gains of {GAINS.source}: the paper does not say which flew.",
    )  # fmt: skip
    return Outcome(rows, _jump_panels(mpc, se3), remarks)


def _jump_panels(mpc: Reaction, se3: Reaction) -> tuple[Panel, ...]:
    marks = ((AT, "jump"),)
    v, a = LIMITS.horizontal.v, LIMITS.horizontal.a

    def panel(title: str, unit: str, of: Any, limit: float | None = None) -> Panel:
        lines = [Line(x, r.log.t, of(r)) for x, r in zip(CONTROLLERS, (mpc, se3), strict=True)]
        if limit is not None:
            lines.append(Line("limit of MPC", mpc.log.t, np.full(len(mpc.log.t), limit), "paper"))
        return Panel(title, "time [s]", unit, tuple(lines), marks)

    return (
        *(Panel(f"MRS Fig. 13, {name}: position", "time [s]", "x [m]", (
            Line("estimate", r.log.t, r.log.r_e[:, 0]), Line("ground truth", r.log.t, r.log.r[:, 0]),
            Line("reference", r.log.t, r.log.r_d[:, 0], "paper"),
        ), marks) for name, r in zip(CONTROLLERS, (mpc, se3), strict=True)),
        panel("speed", "[m/s]", lambda r: np.linalg.norm(r.log.v[:, :2], axis=1), v),
        panel("acceleration", "[m/s²]", lambda r: np.linalg.norm(r.log.a[:, :2], axis=1), a),
        panel("tilt", "[deg]", lambda r: np.rad2deg(tilt(r.log))),
        panel("height that is lost", "[m]", lambda r: HEIGHT - r.log.r[:, 2]),
    )  # fmt: skip


EXPERIMENTS = (
    Experiment("000-5", "Hover on a noisy estimate", "MRS Sec. 8.3, Fig. 12", noisy_estimate),
    Experiment(
        "000-6", "A jump of the estimate", "MRS Sec. 8.4, Fig. 13", jumping_estimate, seeds=1
    ),
)
