"""003-2 and 003-6: a figure of eight on Spica's loops, and a step that asks for more than the rotors have."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.control_flights import KNOWS, Knows, Passes, flown
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.experiments.torque_loop import TorqueLoop, wishes
from uavlab.flight.log import Log
from uavlab.flight.metrics import heading_error, headings, position_error, tilt
from uavlab.flight.scenario import Scenario, standing
from uavlab.interfaces import Mission
from uavlab.parts.missions import Follow, Waypoints
from uavlab.parts.paths import lemniscate, phase
from uavlab.plant import CompiledPlant, load_airframe
from uavlab.types import GRAVITY, Array, Reference

NAME = "MK-Quadro"
RATE = 500.0  # [Hz] of loops and physics alike, so that a torque is flown as it was asked for
LAP, LAPS, RAMP = 8.0, 3, 4.0  # [s] as printed; flown; [s] from rest
HIGH = 1.5  # [m]
CENTRE = np.array((0.0, 0.0, HIGH))
EXACT = Knows()
NOISE = Knows(r_noise=0.002, v_noise=0.02)  # ours, of cameras and their filter
STEP = (4.0, 2.0, 2.5)  # [m], where the step leads to, from (0, 0, HIGH)
TURN = np.pi / 2  # [rad]
DRAWS = 50  # thrusts and torques of each seed
F_MIN, F_MAX = 0.3131, 6.03  # [N], as printed


@dataclass(frozen=True)
class Eight(Follow):
    """The eight of 1 m × 1 m with height and yaw that swing at 1 rad/s (Spica Sec. 7)."""

    z: float = 0.2  # [m]
    yaw: float = 1.0  # [rad]

    def goal(self, t: float) -> Reference:
        """The point of now, with its derivatives."""
        x = super().goal(t)
        p, p1, p2, p3 = phase(t, 1.0, self.ramp)
        s, c = sin(p), cos(p)
        swing = (s, c * p1, c * p2 - s * p1**2, c * p3 - 3.0 * s * p1 * p2 - c * p1**3)
        r, v, a, j = (
            y + self.z * b * np.array((0.0, 0.0, 1.0)) for y, b in zip(x[:4], swing, strict=True)
        )
        return Reference(r, v, a, j, self.yaw * swing[0], self.yaw * swing[1])


EIGHT = Eight(lemniscate(CENTRE, 1.0, 1.0), 2.0 * np.pi / LAP, RAMP)


def there(t: float) -> Reference:
    """The point of the eight at `t` [s]."""
    return EIGHT.goal(t)


def scenario(mission: Mission, seconds: float, knows: Knows = EXACT) -> Scenario:
    """A flight in the laboratory; loops and physics at the same rate."""
    flight = Scenario(
        "Spica", "", NAME, mission, standing((0.0, 0.0, HIGH)), seconds, {KNOWS: knows}
    )
    return flight._replace(rate=RATE, physics=RATE, mission_rate=RATE)


def eight(
    *,
    ahead: bool = True,
    drag: bool = True,
    seconds: float = RAMP + LAPS * LAP,
    knows: Knows = EXACT,
    seed: int = 0,
) -> Log:
    """The figure of eight, with or without the feed-forward of (5), in air or without."""
    loop = TorqueLoop(load_airframe(NAME), there if ahead else None)
    plant = None
    if not drag:
        plant = CompiledPlant(load_airframe(NAME)._replace(drag_body=0.0, drag_rotor=0.0))
    return flown(scenario(EIGHT, seconds, knows), loop, tracker=Passes(), seed=seed, plant=plant)


def stepped(scaled: bool, seconds: float = 15.0) -> tuple[Log, TorqueLoop]:
    """A step of metres and a quarter turn, without any tracker that would soften it."""
    loop = TorqueLoop(load_airframe(NAME), None, scaled)
    stops = Waypoints(((0.0, (0.0, 0.0, HIGH), 0.0), (0.5, STEP, TURN)))
    return flown(scenario(stops, seconds), loop, tracker=Passes()), loop


def errors(log: Log) -> tuple[float, float]:
    """Largest position error [m] and yaw error [deg] after the start."""
    late = log.t >= RAMP
    if not late.any():
        return float("nan"), float("nan")
    return float(position_error(log)[late].max()), float(
        np.rad2deg(np.abs(heading_error(log)[late]).max())
    )


def run_eight(seeds: int) -> Outcome:
    """003-2."""
    log, bare = eight(), eight(ahead=False)
    noisy = np.array([errors(eight(seconds=RAMP + LAP, knows=NOISE, seed=s)) for s in range(seeds)])
    mean, spread = noisy.mean(axis=0).tolist(), noisy.std(axis=0).tolist()
    late = log.t >= RAMP
    worst, yaw = errors(log)
    empty = eight(seconds=RAMP + LAP, drag=False)
    speed = np.linalg.norm(log.v_d[late], axis=1).max()
    rows = (
        Row("largest position error [m]", "a plot", worst, Band(0.0, 0.1)),
        Row("largest yaw error [deg]", "a plot", yaw, Band(0.0, 5.0)),
        Row("peak speed of the reference [m/s]", "—", float(speed)),
        Row("peak acceleration of the reference [m/s²]", "—", float(np.linalg.norm(log.a_d[late], axis=1).max())),
        Row("peak tilt [deg]", "—", float(np.rad2deg(tilt(log)[late].max()))),
        Row("largest position error, noisy [m]", "a plot", mean[0], Band(0.0, 0.1), spread[0]),
        Row("largest yaw error, noisy [deg]", "a plot", mean[1], Band(0.0, 5.0), spread[1]),
        Row("largest position error without ω_d and its rate [m]", "—", errors(bare)[0]),
        Row("largest position error without drag [m]", "—", errors(empty)[0]),
        Row("largest yaw error without ω_d and its rate [deg]", "—", errors(bare)[1]),
    )  # fmt: skip
    remarks = (
        "“Amplitude of 0.2 m and frequency of 1 rad, respectively”: we read ±0.2 m in height and ±1 rad in yaw, "
        "both at 1 rad/s. The height comes on top of an eight that is level.",
        "The paper prints neither gains nor inertia; ours are in uavlab.gains and in the airframe. The motors' lag of "
        "0.047 s is not fed forward, as in the paper. Most of the position error is drag, which (4) does not know.",
        f"State known at {RATE:g} Hz; noisy: {NOISE.r_noise * 1e3:g} mm and {NOISE.v_noise * 1e3:g} mm/s (1σ), "
        "one lap.",
    )  # fmt: skip
    return Outcome(rows, _eight_panels(log, bare), remarks)


def _eight_panels(log: Log, bare: Log) -> tuple[Panel, ...]:
    n = slice(None, None, 20)
    t, start = log.t[n], ((RAMP, "full speed"),)
    return (
        Panel("Spica Fig. 4a: position", "time [s]", "position [m]", tuple(
            line for i, x in enumerate("xyz") for line in (
                Line(f"{x} wanted" if i == 0 else "", t, log.r_d[n, i], "truth"), Line(x, t, log.r[n, i]))), start),
        Panel("Spica Fig. 4b: yaw", "time [s]", "yaw [rad]", (
            Line("wanted", t, log.heading_d[n], "truth"), Line("yaw", t, headings(log)[n])), start),
        Panel("Spica Fig. 4c: position error", "time [s]", "error [m]", (
            *(Line(x, t, (log.r - log.r_d)[n, i]) for i, x in enumerate("xyz")),
            Line("size without feed-forward", t, position_error(bare)[n], "dashed")), start),
        Panel("Spica Fig. 4d: yaw error", "time [s]", "error [deg]", (
            Line("yaw", t, np.rad2deg(heading_error(log)[n])),
            Line("without feed-forward", t, np.rad2deg(heading_error(bare)[n]), "dashed")), start),
        Panel("From above", "x [m]", "y [m]", (
            Line("reference", log.r_d[n, 0], log.r_d[n, 1], "truth"), Line("flown", log.r[n, 0], log.r[n, 1])),
            equal=True),
        Panel("Thrust of the rotors", "time [s]", "thrust [N]",
              tuple(Line(f"rotor {i + 1}", t, log.rotors[n, i]) for i in range(4)), start),
    )  # fmt: skip


# Saturation -------------------------------------------------------------------------------------------


def share(asked: Array, given: Array, hover: Array) -> float:
    """λ: how much of what departs from hovering is given."""
    more = asked - hover
    return float((given - hover) @ more / (more @ more)) if more.any() else 1.0


def by_programme(u: Array, hover: Array, mixer: Array) -> float:
    """λ as the solution of the paper's programme, by a solver: it is the largest one that is allowed."""
    from scipy.optimize import linprog

    base, more = mixer @ hover, mixer @ (u - hover)
    rows, room = (
        np.concatenate((more, -more))[:, None],
        np.concatenate((F_MAX - base, base - F_MIN)),
    )
    return float(linprog([-1.0], A_ub=rows, b_ub=room, bounds=[(None, 1.0)], method="highs").x[0])


def formula_against_programme(seeds: int) -> Array:
    """Difference of both λ [1] for random thrusts and torques, shape (seeds · DRAWS,)."""
    airframe = load_airframe(NAME)
    scale, mixer = answer("geometric", "scale_to_limits"), np.linalg.inv(airframe.allocation)
    hover = np.array((airframe.m * GRAVITY, 0.0, 0.0, 0.0))
    off = []
    for seed in range(seeds):
        rng = np.random.default_rng([seed, 36])
        for _ in range(DRAWS):
            u = hover + rng.normal(size=4) * (10.0, 1.5, 1.5, 0.2) * rng.uniform(0.05, 3.0)
            given = scale(u, hover, airframe.allocation, F_MIN, F_MAX)
            off.append(abs(share(u, given, hover) - by_programme(u, hover, mixer)))
    return np.array(off)


def mixed(asked: Array) -> Array:
    """Rotor thrusts (N, 4) [N] that the embedded autopilot makes of thrust and torque (N, 4) if nobody scales them."""
    from uavlab.plant.autopilot import mix
    from uavlab.plant.constants import pack, unpacked
    from uavlab.plant.jit import entry

    def each(asked: Array, numbers: Array, allocation: Array, mixer: Array, out: Array) -> None:
        c = unpacked(numbers, allocation, mixer)
        for k in range(len(asked)):
            mix(asked[k, 0], (asked[k, 1], asked[k, 2], asked[k, 3]), c, out[k])

    out = np.empty((len(asked), 4))
    entry(each)(np.ascontiguousarray(asked), *pack(load_airframe(NAME)), out)
    return out


def turned(asked: Array, given: Array) -> float:
    """Largest angle [deg] between what is asked for and what is given, beyond hovering, in rotor thrusts."""
    hover = load_airframe(NAME).m * GRAVITY / 4.0
    a, b = asked - hover, given - hover
    size = np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1)
    some = size > 1e-9
    cosine = np.sum(a * b, axis=1)[some] / size[some]
    return float(np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0))).max(initial=0.0))


def run_saturation(seeds: int) -> Outcome:
    """003-6."""
    airframe = load_airframe(NAME)
    mixer = np.linalg.inv(airframe.allocation)
    log, loop = stepped(True)
    raw, raw_loop = stepped(False)
    asked, given = (x @ mixer.T for x in wishes(log, loop))
    raw_asked = wishes(raw, raw_loop)[0]
    hover = np.full(4, airframe.m * GRAVITY / 4.0)
    lam = np.array([share(a, b, hover) for a, b in zip(asked, given, strict=True)])
    off = formula_against_programme(seeds)
    rows = (
        Row("λ by the formula less λ by a solver, largest", "0", float(off.max()), Band(0.0, 1e-9)),
        Row("least thrust told to a rotor [N]", "0.3131", float(given.min()), Band(F_MIN - 1e-4, np.inf)),
        Row("greatest thrust told to a rotor [N]", "6.03", float(given.max()), Band(-np.inf, F_MAX + 1e-4)),
        Row("least thrust of a rotor [N]", "0.3131", float(log.rotors.min()), Band(F_MIN - 1e-4, np.inf)),
        Row("greatest thrust of a rotor [N]", "6.03", float(log.rotors.max()), Band(-np.inf, F_MAX + 1e-4)),
        Row("angle between asked and given [deg]", "direction kept", turned(asked, given), Band(0.0, 1e-3)),
        Row("the same without scaling, by the autopilot's own way [deg]", "—",
            turned(raw_asked @ mixer.T, mixed(raw_asked))),
        Row("least thrust asked of a rotor [N]", "—", float(asked.min())),
        Row("greatest thrust asked of a rotor [N]", "—", float(asked.max())),
        Row("least λ", "—", float(lam.min())),
        Row("time with λ < 1 [s]", "—", float((lam < 1.0 - 1e-9).sum() / RATE)),
        Row("position error at the end [m]", "—", float(position_error(log)[-1])),
        Row("position error at the end without scaling [m]", "—", float(position_error(raw)[-1])),
        Row("greatest tilt, scaled [deg]", "—", float(np.rad2deg(tilt(log).max()))),
    )  # fmt: skip
    far = float(np.linalg.norm(np.subtract(STEP, (0.0, 0.0, HIGH))))
    remarks = (
        f"A step of {far:.1f} m and {np.rad2deg(TURN):g}° at once, straight into (4). Scaled: {log.reason}. "
        f"Not scaled: {raw.reason}.",
        f"The programme in one unknown is solved by HiGHS for {seeds * DRAWS} random thrusts and torques.",
        "The paper calls the matrix of its bounds A⁻¹; it is M⁻¹ of (1).",
        "Scaling everything by the same share cuts the torque about x and y as hard as the one about z. Our embedded "
        "autopilot, which mixes what is not scaled, gives up yaw first.",
    )  # fmt: skip
    return Outcome(rows, _saturation_panels(log, raw, asked, given, lam), remarks)


def _saturation_panels(
    log: Log, raw: Log, asked: Array, given: Array, lam: Array
) -> tuple[Panel, ...]:
    soon = log.t < 3.0
    t, ends = log.t[soon], np.array((0.0, 3.0))
    limits = (
        Line("limits", ends, np.full(2, F_MIN), "dashed"),
        Line("", ends, np.full(2, F_MAX), "dashed"),
    )
    n = slice(None, None, 10)
    return (
        Panel("Thrusts asked of the rotors", "time [s]", "thrust [N]", (
            *(Line(f"rotor {i + 1}", t, asked[soon, i]) for i in range(4)), *limits)),
        Panel("Thrusts told to the rotors", "time [s]", "thrust [N]", (
            *(Line(f"rotor {i + 1}", t, given[soon, i]) for i in range(4)), *limits)),
        Panel("Share that is given", "time [s]", "λ", (Line("λ", t, lam[soon]),)),
        Panel("Distance to the new place", "time [s]", "distance [m]", (
            Line("scaled", log.t[n], position_error(log)[n]), Line("not scaled", raw.t[n], position_error(raw)[n]))),
        Panel("Yaw", "time [s]", "yaw [deg]", (
            Line("wanted", log.t[n], np.rad2deg(log.heading_d[n]), "truth"),
            Line("scaled", log.t[n], np.rad2deg(headings(log)[n])),
            Line("not scaled", raw.t[n], np.rad2deg(headings(raw)[n])))),
        Panel("Tilt", "time [s]", "tilt [deg]", (
            Line("scaled", log.t[n], np.rad2deg(tilt(log)[n])),
            Line("not scaled", raw.t[n], np.rad2deg(tilt(raw)[n])))),
    )  # fmt: skip


EXPERIMENTS = (
    Experiment("003-2", "A figure of eight", "Spica Sec. 4, 7, Fig. 4", run_eight),
    Experiment("003-6", "More than the rotors have", "Spica Sec. 4", run_saturation),
)
