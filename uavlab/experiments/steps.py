"""000-1 and 000-2: steps of growing size, along one axis and in space, on the MPC tracker and SE(3) (MRS Figs 7, 8)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.circles import plant
from uavlab.experiments.control_flights import KNOWS, Knows, flown, law
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.log import Log
from uavlab.flight.metrics import position_error, tilt
from uavlab.flight.scenario import Scenario, standing
from uavlab.gains import GROUPS
from uavlab.limits import AxisLimits, Limits, limit_group
from uavlab.parts.missions import Waypoints
from uavlab.plant import CompiledPlant, load_airframe
from uavlab.types import Array, Estimate

NAME = "T650"
HEIGHT = 20.0  # [m], ours
PRINTED = AxisLimits(9.0, 12.0, 50.0, 50.0)
UP, DOWN = AxisLimits(4.0, 6.0, 50.0, 50.0), AxisLimits(2.0, 2.0, 50.0, 50.0)  # of 000-2, ours
ALIKE = limit_group("fast-2020")._replace(
    horizontal=PRINTED, up=PRINTED, down=PRINTED, source="MRS Sec. 8.1"
)
UNLIKE = ALIKE._replace(up=UP, down=DOWN)
SIZES = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # [m] of the steps, back and forth; ours
LONGEST = {
    "one axis": np.array((1.0, 0.0, 0.0)),
    "three axes": np.array((1.0, 0.6, 0.3)),
}  # of a step
REST = 5.0  # [s] for each step, beside the time at full speed
GAINS = GROUPS["T650-sim-2020"]
FLIES = "soft"
NEAR = 0.1  # [m] from where on a step is done
SETTLE = 1.0  # [s] left out before the first step


def stops(way: Array, sizes: tuple[float, ...], limits: Limits) -> tuple[Any, ...]:
    """Places to step to: back and forth along `way` (3,), each step of the next size."""
    r, t, out = np.array((0.0, 0.0, HEIGHT)), SETTLE, []
    out.append((0.0, tuple(r.tolist()), 0.0))
    for k, size in enumerate(sizes):
        r = r + (-1.0) ** k * size * way
        out.append((t, tuple(r.tolist()), 0.0))
        slowest = min(limits.up.v, limits.down.v)
        t += REST + max(size / limits.horizontal.v, size * abs(way[2]) / slowest)
    return (*out, (t, tuple(r.tolist()), 0.0))


class Flown(NamedTuple):
    """One flight, and what its tracker asked for."""

    log: Log
    stops: tuple[Any, ...]
    wanted: Array  # (N, 5, 3) position, velocity, acceleration, jerk, snap of the reference
    failures: int

    @property
    def throttle(self) -> Array:
        """Throttle that the thrust command means (MRS eq. 32), (N,)."""
        airframe = load_airframe(NAME)
        return airframe.a_t * np.sqrt(np.maximum(self.log.f_d, 0.0)) + airframe.b_t


def step_flight(
    way: Array, limits: Limits, *, group: str = FLIES, sizes: tuple[float, ...] = SIZES,
    drag: bool = True,
) -> Flown:  # fmt: skip
    """Fly the steps, on an aircraft that knows its state, with the drag of its body as MRS simulates it."""
    places = stops(way, sizes, limits)
    end = places[-1][0]
    mission = Waypoints(places)
    start = standing(places[0][1])
    scenario = Scenario("steps", "", NAME, mission, start, end, {KNOWS: Knows()})
    airframe = load_airframe(NAME)
    tracker = answer("mpc", "MpcTracker")(limits)
    air = plant() if drag else CompiledPlant(airframe._replace(drag_rotor=0.0, drag_body=0.0))
    log = flown(scenario, law(float(airframe.m), GAINS[group]), tracker=tracker, plant=air)
    wanted, failures = asked(tracker, mission, log)
    return Flown(log, places, wanted, failures)


def asked(tracker: Any, mission: Waypoints, log: Log) -> tuple[Array, int]:
    """What the tracker asked for, told again with jerk and snap, which a log does not keep; and its failures."""
    zero, dt = np.zeros(3), log.meta["dt"]
    here = Estimate(log.r_e[0], log.v_e[0], zero, log.R_e[0], zero)
    memory, clock = tracker.init(here, None), mission.init(here)
    out = np.zeros((len(log.t), 5, 3))
    for k in range(len(log.t)):
        clock, goal = mission.step(clock, here, dt)
        memory, reference = tracker.step(memory, here, goal, dt)
        out[k, :4] = reference.r, reference.v, reference.a, reference.j
    out[:-1, 4] = np.diff(out[:, 3], axis=0) / dt
    return out, tracker.failures(memory)


# What is told -----------------------------------------------------------------------------------------


def error(flight: Flown) -> Array:
    """Distance of the aircraft from its reference [m], (N,)."""
    return position_error(flight.log)


def largest(x: Array) -> float:
    """The largest size in an array."""
    return float(np.abs(x).max())


def times(flight: Flown) -> list[float]:
    """How long after each order the aircraft is there for good: within NEAR of the place [s]."""
    t, out = flight.log.t, []
    for (start, place, _), (end, _, _) in zip(flight.stops[1:-1], flight.stops[2:], strict=True):
        during = (t >= start) & (t < end)
        away = np.linalg.norm(flight.log.r[during] - np.array(place), axis=1) > NEAR
        out.append((np.flatnonzero(away)[-1] + 1) * flight.log.meta["dt"] if away.any() else 0.0)
    return out


def over(flight: Flown) -> float:
    """How far the reference goes beyond a place, along any axis [m]."""
    t, worst = flight.log.t, 0.0
    for k, (start, place, _) in enumerate(flight.stops[1:-1], start=1):
        during = (t >= start) & (t < flight.stops[k + 1][0])
        there = np.array(place)
        towards = np.sign(there - np.array(flight.stops[k - 1][1]))
        worst = max(worst, float(((flight.wanted[during, 0] - there) * towards).max()))
    return worst


KINDS = (
    ("speed", "v", "m/s"), ("acceleration", "a", "m/s²"), ("jerk", "j", "m/s³"), ("snap", "s", "m/s⁴"),
)  # fmt: skip


def limit_rows(
    flight: Flown, axes: slice, limit: AxisLimits, what: str, sign: int = 0
) -> list[Row]:
    """Largest speed to snap of the reference, each against its limit and 1 %; of one sign only if it is not 0."""
    rows = []
    for i, (kind, name, unit) in enumerate(KINDS, start=1):
        x, most = flight.wanted[:, i, axes], getattr(limit, name)
        ours = float((sign * x).max()) if sign else largest(x)
        printed = f"limit {most:g}" if limit is PRINTED else "—"
        rows.append(
            Row(f"{kind} of the reference{what} [{unit}]", printed, ours, Band(0.0, 1.01 * most))
        )
    return rows


DRAG = (
    "drag, {:.1f} N at the speed then, is unknown to the controller, and its integrals learn too slowly: it costs "
    "drag/(m k_p)"
)


def error_rows(flights: dict[str, Flown], free: Flown, most: float) -> list[Row]:
    """The largest tracking error with each group of gains; judged is that of FLIES. `free` flew without drag."""
    rows = []
    for group, flight in flights.items():
        e = error(flight)
        v = float(np.linalg.norm(flight.log.v[e.argmax()]))
        judged = group == FLIES
        note = (
            DRAG.format(load_airframe(NAME).drag_body * v**2) if judged and e.max() > most else ""
        )
        band = Band(0.0, most) if judged else None
        rows.append(
            Row(
                f"tracking error, {group} gains, largest [m]", "—", float(e.max()), band, None, note
            )
        )
    name = f"tracking error, {FLIES} gains, without drag, largest [m]"
    return [*rows, Row(name, "—", float(error(free).max()))]


def common_rows(flights: dict[str, Flown]) -> list[Row]:
    """Throttle, tilt, times and failures."""
    one = flights[FLIES]
    each = ", ".join(f"{x:.2f}" for x in times(one))
    return [
        Row("throttle, largest", "—", float(one.throttle.max()), Band(0.0, 0.9)),
        Row("tilt, largest [deg]", "—", float(np.rad2deg(tilt(one.log).max()))),
        Row(f"longest step, until within {NEAR:g} m [s]", "—", times(one)[-1], None, None,
            f"of all steps: {each} s"),
        Row("reference beyond a place, largest [m]", "—", over(one)),
        Row("steps of the tracker without a plan", "—", float(one.failures), Band(0.0, 0.0)),
    ]  # fmt: skip


REMARKS = (
    "The paper prints the limits only, and shows the curves. Steps of 1 to 32 m, back and forth, are ours.",
    "It does not say which gains flew. We say, as of its circles, the soft set of the T650 in simulation of 2020; the "
    "others are told. Drag is that of the body alone, as MRS simulate it. The aircraft knows its state.",
    "Limits are kept by each axis for itself. Jerk and snap are hard in the programme of the tracker, speed and "
    "acceleration are soft, and of those it plans with 99.5 %. From rest to rest, the limits of x and y are in "
    "proportion to their ways.",
    "No step from rest gets to 12 m/s²: with a snap of 50 m/s⁴ it is at 9 m/s before, by about 10 m/s².",
)
SWING = (
    "24.5 is what a snap of 50 needs to get from 0 to 12 m/s²; the step of 16 m goes from speeding up at 10 m/s² "
    "straight into braking, and to swing by 20 m/s² may take √(20 · 50) = 31.6. The limit is 50"
)


def all_groups(way: Array, limits: Limits, sizes: tuple[float, ...] = SIZES) -> dict[str, Flown]:
    """The same steps with each group of gains."""
    return {group: step_flight(way, limits, group=group, sizes=sizes) for group in GAINS}


def run_one_axis(_seeds: int, sizes: tuple[float, ...] = SIZES) -> Outcome:
    """000-1. Nothing is left to chance."""
    flights = all_groups(LONGEST["one axis"], ALIKE, sizes)
    free = step_flight(LONGEST["one axis"], ALIKE, sizes=sizes, drag=False)
    one = flights[FLIES]
    jerk = largest(one.wanted[:, 3])
    rows = (
        *limit_rows(one, slice(None), PRINTED, ""),
        Row("jerk of the reference, if its limit does not bind [m/s³]", "—", jerk, Band(0.0, 24.5), None,
            SWING if jerk > 24.5 else ""),
        *error_rows(flights, free, 0.5),
        *common_rows(flights),
    )  # fmt: skip
    return Outcome(rows, _one_axis_panels(flights), REMARKS)


def run_three_axes(_seeds: int, sizes: tuple[float, ...] = SIZES) -> Outcome:
    """000-2. Nothing is left to chance."""
    flights = all_groups(LONGEST["three axes"], UNLIKE, sizes)
    free = step_flight(LONGEST["three axes"], UNLIKE, sizes=sizes, drag=False)
    one = flights[FLIES]
    rows = (
        *limit_rows(one, slice(0, 2), PRINTED, ", x or y"),
        *limit_rows(one, slice(2, 3), UP, ", upwards", 1),
        *limit_rows(one, slice(2, 3), DOWN, ", downwards", -1),
        *error_rows(flights, free, 0.6),
        Row("way from above, off the straight line, largest [m]", "—", off_line(one)),
        *common_rows(flights),
    )
    more = (
        f"The vertical limits, {UP.v:g} m/s and {UP.a:g} m/s² upwards, {DOWN.v:g} and {DOWN.a:g} downwards, are ours: "
        "the paper prints one set for all, but 12 m/s² downwards is more than gravity gives.",
    )
    return Outcome(rows, _three_axes_panels(flights), REMARKS + more)


def off_line(flight: Flown) -> float:
    """How far the reference leaves the straight way, seen from above [m]."""
    x, y = LONGEST["three axes"][:2] / np.linalg.norm(LONGEST["three axes"][:2])
    return largest(flight.wanted[:, 0, 0] * y - flight.wanted[:, 0, 1] * x)


# Pictures ---------------------------------------------------------------------------------------------

EVERY = slice(None, None, 5)


def _followed(flight: Flown, order: int, axis: int, limit: float, title: str, unit: str) -> Panel:
    """One derivative of one axis: wanted, flown, and its limits."""
    log, t = flight.log, flight.log.t[EVERY]
    flown_ = (log.r, log.v, log.a)[order][EVERY, axis]
    lines = [
        Line("reference", t, flight.wanted[EVERY, order, axis], "truth"),
        Line("aircraft", t, flown_),
    ]
    if limit:
        for sign, name in ((1.0, "limit forwards"), (-1.0, "limit backwards")):
            lines.append(Line(name, t, np.full(len(t), sign * limit), "dashed"))
    return Panel(title, "time [s]", unit, tuple(lines))


def _errors(flights: dict[str, Flown]) -> Panel:
    return Panel("Tracking error by gains", "time [s]", "error [m]",
                 tuple(Line(group, x.log.t[EVERY], error(x)[EVERY]) for group, x in flights.items()))  # fmt: skip


def _one_axis_panels(flights: dict[str, Flown]) -> tuple[Panel, ...]:
    one = flights[FLIES]
    t = one.log.t[EVERY]
    return (
        _followed(one, 0, 0, 0.0, "MRS Fig. 7: position", "x [m]"),
        _followed(one, 1, 0, PRINTED.v, "MRS Fig. 7: velocity", "velocity [m/s]"),
        _followed(one, 2, 0, PRINTED.a, "MRS Fig. 7: acceleration", "acceleration [m/s²]"),
        Panel("Jerk and snap of the reference", "time [s]", "jerk [m/s³], snap [m/s⁴]", (
            Line("snap", t, one.wanted[EVERY, 4, 0], "dashed"), Line("jerk", t, one.wanted[EVERY, 3, 0]))),
        _errors(flights),
        Panel("Throttle and tilt", "time [s]", "throttle, tilt [rad]", (
            Line("throttle", t, one.throttle[EVERY]), Line("tilt", t, tilt(one.log)[EVERY]))),
    )  # fmt: skip


def _three_axes_panels(flights: dict[str, Flown]) -> tuple[Panel, ...]:
    one = flights[FLIES]
    t, r, wanted = one.log.t[EVERY], one.log.r[EVERY], one.wanted[EVERY]
    limits = ((UP.v, "up"), (-DOWN.v, "down"))
    return (
        *(_followed(one, 0, i, 0.0, f"MRS Fig. 8: {x}", f"{x} [m]") for i, x in enumerate("xyz")),
        Panel("Vertical velocity", "time [s]", "velocity [m/s]", (
            Line("reference", t, wanted[:, 1, 2], "truth"), Line("aircraft", t, one.log.v[EVERY, 2]),
            *(Line(f"limit {name}", t, np.full(len(t), v), "dashed") for v, name in limits))),
        _errors(flights),
        Panel("From above", "x [m]", "y [m]", (
            Line("reference", wanted[:, 0, 0], wanted[:, 0, 1], "truth"), Line("aircraft", r[:, 0], r[:, 1])),
            equal=True),
    )  # fmt: skip


EXPERIMENTS = (
    Experiment("000-1", "Steps along one axis", "MRS Sec. 8.1, Fig. 7", run_one_axis, seeds=1),
    Experiment("000-2", "Steps along three axes", "MRS Sec. 8.1, Fig. 8", run_three_axes, seeds=1),
)
