"""000-3 and 000-4: a circle at 7 m/s on SE(3), the nose to its centre or always one way (MRS Figs 9, 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.control_flights import (
    KNOWS,
    Altered,
    Knows,
    flown,
    law,
    without_parasitic,
)
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.log import Log
from uavlab.flight.metrics import heading_error, headings, position_error, tilt
from uavlab.flight.scenario import Scenario, standing
from uavlab.gains import GROUPS, GeometricGains
from uavlab.limits import GROUPS as LIMITS
from uavlab.limits import AxisLimits
from uavlab.parts.missions import Clock, Follow
from uavlab.parts.paths import circle
from uavlab.plant import CompiledPlant, load_airframe
from uavlab.plant.wind import low_altitude
from uavlab.types import Array, Estimate, Trajectory

NAME = "T650"
RADIUS, SPEED, HEIGHT = 5.0, 7.0, 10.0  # [m], [m/s] as printed, [m] ours
RATE = SPEED / RADIUS  # [rad/s]
LAP = 2.0 * np.pi / RATE  # [s]
RAMP = 5.0  # [s] from rest to full speed
LAPS, FIRST = 13, 5  # flown, and from which one on errors count
GAINS = GROUPS["T650-sim-2020"]
FLIES = "soft"  # the default group of the MRS software today
SAMPLE = 0.2  # [s] of the trajectory, the step of the MPC tracker
FIG_7 = LIMITS["fast"]._replace(horizontal=AxisLimits(9.0, 12.0, 50.0, 50.0))  # MRS Fig. 7
SIDE = 4.0  # [m/s] of wind, ours
NOISE = Knows(r_noise=0.02, v_noise=0.05)  # ours, of a good differential receiver and its filter
BLOWN_LAPS = 7


def scenario(facing: bool, laps: float = LAPS) -> Scenario:
    """The circle, from standing on it; `facing` its centre, or along world x."""
    centre = np.array((0.0, 0.0, HEIGHT))
    mission = Follow(circle(centre, RADIUS), RATE, RAMP, 0.0, centre if facing else None)
    start = standing((RADIUS, 0.0, HEIGHT), np.pi if facing else 0.0)
    return Scenario("circle", "", NAME, mission, start, laps * LAP + RAMP / 2, {KNOWS: Knows()})


def plant(rotor_drag: bool = False) -> CompiledPlant:
    """The aircraft as MRS simulates it, with the drag of its body; `rotor_drag`: with ours on top."""
    airframe = load_airframe(NAME)
    return CompiledPlant(airframe if rotor_drag else airframe._replace(drag_rotor=0.0))


def round_and_round(
    facing: bool, gains: GeometricGains, *, compensated: bool = True, rotor_drag: bool = False,
    laps: float = LAPS,
) -> Log:  # fmt: skip
    """One flight in calm air of an aircraft that knows its state."""
    controller: Any = law(float(load_airframe(NAME).m), gains)
    if not compensated:
        controller = Altered(controller, without_parasitic)
    return flown(scenario(facing, laps), controller, plant=plant(rotor_drag))


@dataclass(frozen=True)
class Sent(Follow):
    """The same path, sent as a whole when the flight begins."""

    seconds: float = 0.0  # how much of it

    def step(self, memory: Clock, estimate: Estimate, dt: float) -> tuple[Clock, Any]:
        """Places and headings at every fifth of a second."""
        t = np.arange(0.0, self.seconds, SAMPLE)
        goals = [self.goal(x) for x in t]
        turns = np.unwrap([x.heading for x in goals])
        return memory, Trajectory(t, np.array([x.r for x in goals]), turns)


def tracked(facing: bool) -> tuple[Log, Array]:
    """The circle as a trajectory that the MPC tracker follows, and how far its reference is from it [m], (N,)."""
    flight = scenario(facing, BLOWN_LAPS)
    way: Any = flight.mission
    seconds = flight.duration + 10.0  # the tracker looks ahead
    sent = Sent(way.path, way.rate, way.ramp, way.heading, way.face, seconds)
    log = flown(
        flight._replace(mission=sent, mission_rate=1.0 / 50.0),
        law(float(load_airframe(NAME).m), GAINS[FLIES]),
        tracker=answer("mpc", "MpcTracker")(FIG_7),
        plant=plant(),
    )
    return log, np.linalg.norm([way.goal(t).r for t in log.t] - log.r_d, axis=1)


def _tracked_rows(facing: bool) -> tuple[Row, ...]:
    log, cut = tracked(facing)
    what = f"with the MPC tracker, laps {FIRST + 1} to {BLOWN_LAPS}, {FLIES} gains"
    late = log.t >= FIRST * LAP + RAMP / 2
    mean = float(cut[late].mean()) if late.any() else float("nan")
    return (
        Row(f"{what}: error [m]", "0.1" if facing else "0.5", lapped(log).error),
        Row(f"{what}: its reference from the circle [m]", "—", mean),
    )


def freely(gains: GeometricGains) -> Log:
    """The circle with the nose to its centre, in vacuum."""
    airframe = load_airframe(NAME)
    empty = CompiledPlant(airframe._replace(drag_rotor=0.0, drag_body=0.0))
    return flown(scenario(True, BLOWN_LAPS), law(float(airframe.m), gains), plant=empty)


def blown(facing: bool, seed: int) -> Log:
    """The same in a side wind with gusts, on noisy measurements."""
    wind = low_altitude(np.array((SIDE, 0.0, 0.0)), HEIGHT)
    windy = scenario(facing, BLOWN_LAPS)._replace(wind=wind, sensors={KNOWS: NOISE})
    return flown(windy, law(float(load_airframe(NAME).m), GAINS[FLIES]), seed=seed, plant=plant())


class Lapped(NamedTuple):
    """A flight on the circle in numbers; of the laps that count, unless it says otherwise."""

    log: Log
    error: float  # [m] mean distance from the reference
    last: float  # [m] the same of the last lap
    rates: Array  # (3,) [rad/s] mean, body
    rms: Array  # (3,) [rad/s]
    tilt: float  # [deg] mean
    throttle: float  # mean (MRS eq. 32)
    heading: float  # [deg] largest size of the error


def lapped(log: Log) -> Lapped:
    """What counts of a flight; not a number where it ended before that."""
    airframe = load_airframe(NAME)
    late = log.t >= FIRST * LAP + RAMP / 2
    if not late.any():
        nan = float("nan")
        return Lapped(log, nan, nan, np.full(3, nan), np.full(3, nan), nan, nan, nan)
    e = position_error(log)
    last = log.t >= log.t[-1] - LAP
    throttle = airframe.a_t * np.sqrt(log.rotors[late].sum(axis=1)) + airframe.b_t
    return Lapped(
        log, float(e[late].mean()), float(e[last].mean()), log.omega[late].mean(axis=0),
        np.sqrt((log.omega[late] ** 2).mean(axis=0)), float(np.rad2deg(tilt(log)[late].mean())),
        float(throttle.mean()), float(np.rad2deg(np.abs(heading_error(log)[late]).max())),
    )  # fmt: skip


def groups(facing: bool, rotor_drag: bool = False) -> dict[str, Lapped]:
    """One flight with each group of gains."""
    return {
        name: lapped(round_and_round(facing, gains, rotor_drag=rotor_drag))
        for name, gains in GAINS.items()
    }


def _told(by_group: dict[str, Lapped], draggy: dict[str, Lapped], paper: str) -> tuple[Row, ...]:
    """Rows that are told, not judged: other gains, and the drag of rotors on top."""
    others = [x for x in by_group if x != FLIES]
    return (
        *(Row(f"the same, {x} gains [m]", paper, by_group[x].error) for x in others),
        *(Row(f"the last of {LAPS} laps, {x} gains [m]", paper, by_group[x].last) for x in by_group),
        *(Row(f"with the drag of rotors, {x} gains [m]", paper, draggy[x].error) for x in draggy),
    )  # fmt: skip


def _blown_row(facing: bool, seeds: int) -> tuple[Row, list[Log]]:
    logs = [blown(facing, s) for s in range(seeds)]
    errors = [lapped(log).error for log in logs]
    what = f"in a side wind of {SIDE:g} m/s with gusts, noisy, {FLIES} gains [m]"
    return Row(what, "—", float(np.mean(errors)), None, float(np.std(errors))), logs


def near(x: float, share: float) -> Band:
    """A band around `x`."""
    return Band(x - abs(share * x), x + abs(share * x))


def run_facing(seeds: int) -> Outcome:
    """000-3."""
    by_group, draggy = groups(True), groups(True, rotor_drag=True)
    one, free = by_group[FLIES], lapped(freely(GAINS[FLIES]))
    wind, logs = _blown_row(True, seeds)
    c = np.sqrt(0.5)
    rows = (
        Row(f"mean position error, {FLIES} gains [m]", "0.1", one.error, Band(0.03, 0.20), None,
            "simulated as MRS do, with the drag of the body alone"),
        Row("body rate about x [rad/s]", "—", one.rates[0], near(-RATE * c, 0.1)),
        Row("body rate about y [rad/s]", "—", one.rates[1], Band(-0.1 * RATE * c, 0.1 * RATE * c), None,
            "the band is that of a circle without drag, as wide as the others; drag tilts the aircraft forward, and "
            "the heading rate then has a share about y"),
        Row("body rate about z [rad/s]", "—", one.rates[2], near(RATE * c, 0.1)),
        Row("body rate about y without any drag [rad/s]", "—", free.rates[1]),
        Row("tilt [deg]", "near 45 by its acceleration", one.tilt),
        Row("throttle", "—", one.throttle),
        *_told(by_group, draggy, "0.1"),
        *_tracked_rows(True),
        wind,
    )  # fmt: skip
    remarks = (
        *_remarks(),
        "The text says that this circle needs only the rates about x and y. It needs those about x and z: "
        "ω = η̇ Rᵀe3.",
    )
    return Outcome(rows, _panels(by_group, draggy, logs), remarks)


def run_constant(seeds: int) -> Outcome:
    """000-4."""
    by_group, draggy = groups(False), groups(False, rotor_drag=True)
    one, facing = by_group[FLIES], lapped(round_and_round(True, GAINS[FLIES]))
    bare = lapped(round_and_round(False, GAINS[FLIES], compensated=False))
    wind, logs = _blown_row(False, seeds)
    rows = (
        Row(f"mean position error, {FLIES} gains [m]", "0.5", one.error, Band(0.15, 0.60), None,
            "simulated as MRS do, with the drag of the body alone"),
        Row("the same over that with the nose to the centre", "5", one.error / facing.error, Band(1.7, np.inf)),
        Row("heading error, largest [deg]", "—", one.heading, Band(0.0, 5.0)),
        Row("heading error without compensation, largest [deg]", "—", bare.heading, Band(one.heading, np.inf),
            None, "must be larger than with it"),
        *(Row(f"body rate about {x}, rms [rad/s]", "—", one.rms[i]) for i, x in enumerate("xyz")),
        Row("tilt [deg]", "—", one.tilt),
        Row("throttle", "—", one.throttle),
        *_told(by_group, draggy, "0.5"),
        *_tracked_rows(False),
        wind,
    )  # fmt: skip
    panels = _panels(by_group, draggy, logs, bare)
    return Outcome(rows, panels, _remarks())


def _remarks() -> tuple[str, ...]:
    return (
        f"The paper does not say which gains flew. We say: the group {FLIES} of the T650 in simulation of 2020, "
        "for soft is what the software takes by default today; the others are told.",
        "Drag is what decides here. The simulator of MRS has the drag of the body alone (4.9 N at 7 m/s on this "
        "aircraft), and so have the rows that are judged. Our T650 also has the drag of its rotors, measured on "
        "another quadrotor by Bangura: 12 N together.",
        "The reference is the circle itself with all its derivatives, which our command filter passes on. "
        f"The MPC tracker, with the limits of Fig. 7, gets places and headings every {SAMPLE:g} s, and cuts the curve.",
        f"The aircraft knows its state, except in the wind. Errors are means from lap {FIRST + 1} to {LAPS} "
        f"({BLOWN_LAPS} in the wind).",
    )


def _panels(
    by_group: dict[str, Lapped],
    draggy: dict[str, Lapped],
    windy: Sequence[Log],
    bare: Lapped | None = None,
) -> tuple[Panel, ...]:
    log = by_group[FLIES].log
    n = slice(-int(2 * LAP / log.meta["dt"]), None, 3)  # the last two laps
    t, mark = log.t[n], ((FIRST * LAP + RAMP / 2, "counts from here"),)
    head = [Line("heading", t, np.rad2deg(headings(log)[n]), "points")]
    wish = np.rad2deg((log.heading_d[n] + np.pi) % (2 * np.pi) - np.pi)
    figure = 9 if bare is None else 10
    heading_panel = Panel(f"MRS Fig. {figure}: heading", "time [s]", "heading [deg]",
                          (Line("reference", t, wish, "truth"), *head))  # fmt: skip
    if bare is not None:
        heading_panel = Panel(
            "MRS Fig. 10: heading, wanted 0", "time [s]", "heading [deg]",
            (Line("compensated", t, np.rad2deg(heading_error(log)[n])),
             Line("without compensation", t, np.rad2deg(heading_error(bare.log)[n]))))  # fmt: skip
    errors = [Line(k, x.log.t[::20], position_error(x.log)[::20]) for k, x in by_group.items()]
    drag = [Line(f"{k}, rotor drag", x.log.t[::20], position_error(x.log)[::20], "dashed")
            for k, x in draggy.items() if k == FLIES]  # fmt: skip
    gusty = np.array([position_error(x)[::20] for x in windy if len(x.t) == len(windy[0].t)])
    return (
        Panel(f"MRS Fig. {figure}: position, the last two laps", "time [s]", "position [m]", (
            Line("x wanted", t, log.r_d[n, 0], "truth"), Line("x", t, log.r[n, 0]),
            Line("y wanted", t, log.r_d[n, 1], "paper"), Line("y", t, log.r[n, 1]))),
        heading_panel,
        Panel("Position error by gains", "time [s]", "error [m]", (*errors, *drag), mark),
        Panel("From above", "x [m]", "y [m]", (
            Line("reference", log.r_d[n, 0], log.r_d[n, 1], "truth"),
            Line(FLIES, log.r[n, 0], log.r[n, 1]),
            Line(f"{FLIES}, rotor drag", draggy[FLIES].log.r[n, 0], draggy[FLIES].log.r[n, 1], "dashed"),
        ), equal=True),
        Panel("Body rates", "time [s]", "rate [rad/s]",
              tuple(Line(f"about {x}", t, log.omega[n, i]) for i, x in enumerate("xyz"))),
        Panel(f"In a side wind of {SIDE:g} m/s: {len(gusty)} seeds", "time [s]", "error [m]", (
            Line("all", windy[0].t[::20], gusty.min(axis=0), "band", gusty.max(axis=0)),
            Line("mean", windy[0].t[::20], gusty.mean(axis=0)),
        ), mark),
    )  # fmt: skip


EXPERIMENTS = (
    Experiment("000-3", "A circle, nose to its centre", "MRS Sec. 8.2, Fig. 9", run_facing),
    Experiment("000-4", "A circle, heading constant", "MRS Sec. 8.2, Fig. 10", run_constant),
)
