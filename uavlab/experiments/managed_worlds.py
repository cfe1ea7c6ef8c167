"""000-11 and the way indoors once more, with everything in the loop: pilot, area, limits, goals of two worlds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.area import Area
from uavlab.experiments.answers import answer
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.experiments.story import down, refusals, when
from uavlab.flight.fill import fill
from uavlab.flight.fly import fly
from uavlab.flight.log import Log
from uavlab.flight.piloted import piloted
from uavlab.flight.scenario import Scenario, standing
from uavlab.flight.worlds import flown_by, told
from uavlab.interfaces import Stack
from uavlab.orders import In, LandHome, TakeOff, Use
from uavlab.parts.bank import BankEstimator, chosen
from uavlab.parts.errands import Errand, Wait
from uavlab.parts.missions import still
from uavlab.scenarios.estimation import outdoors
from uavlab.scenarios.managed import DOOR, HOUSE, LAND_AT, WIDE, outdoor_indoor_managed
from uavlab.sensors import Gnss, Rtk
from uavlab.types import Array, Exit, Vec3

NAME = "T650"
OFFSET = np.array((1.5, -1.0, 0.8))  # [m] of the differential receiver's world
STILL, NEVER, ALL = Band(0.0, 0.02), Band(0.0, 0.0), Band(1.0, 1.0)
BORDER = 8.0  # [m] from the start to each side
CLEAR = 2.0  # [m] inside or outside of it: more than a satellite receiver wanders
ASKED = "estimator"


# GNSS → RTK -------------------------------------------------------------------------------------------


def on_satellites(airframe: str, area: Area) -> Stack:
    """The safe pilot on two receivers; GNSS first."""
    estimator = fill(BankEstimator, setup=chosen("gnss", "rtk"), requests=((0.0, "gnss"),))
    return piloted(airframe, estimator, area=area)


def switched(offset: Vec3, seed: int, switch: bool = True, end: float = 80.0) -> Log:
    """Take off on GNSS, switch to RTK in flight; goals in both worlds, some outside of the area; home."""
    area = Area(np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * BORDER, 0.5, 8.0)
    here = np.array((BORDER - CLEAR, -2.0, 3.0))  # inside; and outside:
    there = here + np.array((2.0 * CLEAR, 0.0, 0.0))
    far = np.array((0.0, 4.0, 0.0))
    start, rtk = (
        [still(x) for x in (here, there)],
        [In("rtk", still(x + far + offset)) for x in (here, there)],
    )
    change = (Use(ASKED, "rtk"),) if switch else ()
    steps = (
        TakeOff(2.0), Use("limits", "fast"), start[0], *change, Wait(1.5), *rtk, *start, LandHome(),
    )  # fmt: skip
    scenario = Scenario(
        "gnss to rtk", "", NAME, Errand(steps, patience=6.0), standing((0.0, 0.0, 0.0)), end,
        outdoors(gnss=Gnss(), rtk=Rtk(offset=offset)), area=area,
    )  # fmt: skip
    return fly(scenario, on_satellites(NAME, area), seed=seed)


class Change(NamedTuple):
    """A change of worlds in flight."""

    k: int  # the tick
    jump: float  # [m] of the reference, as it is told
    felt: float  # [m] by which the error that the controller sees steps in this tick
    moved: float  # [m] the true aircraft, within a quarter of a second, off the way that it was on


def changes(log: Log, earlier: int = 0) -> list[Change]:
    """Every change of the filter that flies, but the first; or what was so many ticks `earlier`, to hold it against."""
    flight = told(log)
    error = flight.r_e - flight.r_d
    found = []
    for k in (np.flatnonzero(np.diff(log.worlds.flies)) + 1 - earlier).tolist():
        if k < 50 or k + 25 >= len(log.t):
            continue
        t, v = log.t[k : k + 25] - log.t[k - 1], log.v[k - 1]
        a = (v - log.v[k - 6]) / (log.t[k - 1] - log.t[k - 6])
        way = log.r[k - 1] + t[:, None] * v + 0.5 * t[:, None] ** 2 * a
        found.append(Change(
            k, float(np.linalg.norm(log.r_d[k] - log.r_d[k - 1])),
            float(np.linalg.norm(error[k] - error[k - 1])),
            float(np.linalg.norm(log.r[k : k + 25] - way, axis=1).max()),
        ))  # fmt: skip
    return found


def _switch(seeds: int) -> Outcome:
    """000-11, in the loop."""
    answer("kalman_bank", "KalmanBank")
    flown = [(switched(OFFSET, s), switched(np.zeros(3), s)) for s in range(seeds)]
    stayed = [switched(OFFSET, s, switch=False, end=15.0) for s in range(seeds)]
    at = [when(a, ASKED, "rtk") for a, _ in flown]
    apart = [_apart(a, b) for a, b in flown]
    quick = [
        float(_apart(a, c)[(t := round(x * 100)) : t + 25].max())
        for (a, _), c, x in zip(flown, stayed, at, strict=True)
    ]
    logs = [a for a, _ in flown]
    jumps = [max((x.jump for x in changes(a)), default=np.nan) for a in logs]
    ends = [down(a) for a in logs]
    outside = [sum("outside the border" in x for x in refusals(a)) for a in logs]
    rows = (
        Row("flights that ended as landed [share]", "all",
            float(np.mean([x.exit is Exit.LANDED for x in logs])), ALL),
        _mean("reference coordinates jump at the switch [m]", "several metres", jumps, Band(0.5, np.inf)),
        Row("true displacement that the offset makes, in all of the flight, largest [m]", "none",
            max(float(x.max()) for x in apart), STILL,
            note="against the same noise with both receivers in the same coordinates, and goals told in them"),
        _mean("true distance from the flight that did not switch, within 0.25 s [m]", "none", quick, STILL),
        Row("the same, largest [m]", "—", max(quick), None, None,
            "not of the shift: two filters do not agree on the velocity, as in 000-11"),
        Row("goals outside of the area that were refused, of those in the world of GNSS or RTK [share]", "all",
            float(np.mean(outside)) / 2.0, ALL, note="2 m outside the border, one told in each world"),
        Row("goals inside that were refused", "none",
            float(sum(len(refusals(a)) - n for a, n in zip(logs, outside, strict=True))), NEVER),
        Row("emergencies and failsafes", "none", float(sum(_hurt(x) for x in logs)), NEVER),
        _mean("motors off, from where it took off [m]", "—", [float(np.hypot(*x.at[:2])) for x in ends], None,
              "what GNSS wandered until it was left"),
    )  # fmt: skip
    return Outcome(rows, _switch_panels(flown, stayed[0], at[0], apart), _SWITCHED)


_SWITCHED = (
    f"{NAME} takes off on GNSS by an order, flies 6 m with the limits fast, switches to RTK while it hovers there by "
    "the order `Use('estimator', 'rtk')`, is given a goal inside and one outside of a square area in the world of RTK, "
    "and one of each in that of the start, and lands home. Safe pilot, watch, area and groups of limits in the loop.",
    "The area is told in the world of the start. GNSS wanders by half a metre; so the goals keep 2 m from the border.",
)


def _hurt(log: Log) -> bool:
    return when(log, "safety") == when(log, "safety")


def _apart(a: Log, b: Log) -> Array:
    n = min(len(a.t), len(b.t))
    return np.linalg.norm(a.r[:n] - b.r[:n], axis=1)


def _switch_panels(
    flown: list[tuple[Log, Log]], stayed: Log, at: float, apart: list[Array]
) -> tuple[Panel, ...]:
    one = flown[0][0]
    offset = tuple(Line("", np.arange(len(x)) * 0.01, np.maximum(x, 1e-16)) for x in apart)
    return (
        Panel("x as it is told, seed 0", "time [s]", "x [m]",
              (Line("true", one.t, one.r[:, 0], "truth"), Line("estimate", one.t, one.r_e[:, 0]),
               Line("reference", one.t, one.r_d[:, 0], "dashed")), ((at, "RTK flies"),)),
        Panel("True path from above, seed 0", "x [m]", "y [m]",
              (Line("switched", one.r[:, 0], one.r[:, 1]),
               Line("not switched", stayed.r[:, 0], stayed.r[:, 1], "dashed"),
               Line("area", BORDER * np.array((-1, 1, 1, -1, -1)), BORDER * np.array((-1, -1, 1, 1, -1)), "paper")),
              equal=True),
        Panel("True displacement that the offset makes, all seeds", "time [s]", "[m]",
              (*offset, Line("2 cm", np.array((0.0, one.t[-1])), np.full(2, 0.02), "paper")), log_y=True),
    )  # fmt: skip


# Outdoors → indoors -----------------------------------------------------------------------------------


def _indoors(seeds: int) -> Outcome:
    """The way indoors, in the loop."""
    answer("kalman_bank", "KalmanBank")
    logs = [fly(outdoor_indoor_managed(), seed=seed) for seed in range(seeds)]
    ends, all_changes = [down(x) for x in logs], [changes(x) for x in logs]
    flat, before = ([x for log in logs for x in changes(log, k)] for k in (0, 50))
    off = [float(np.hypot(*(x.at - LAND_AT)[:2])) for x in ends]
    silent = [_left(x) for x in logs]
    wall = [_beside_door(x) for x in logs]
    errors = [np.linalg.norm(x.r_e - x.r_d, axis=1)[_in_air(x)] for x in logs]
    rows = (
        Row("flights that ended as landed [share]", "all",
            float(np.mean([x.exit is Exit.LANDED for x in logs])), ALL),
        _mean("changes of the filter that flies, in flight", "—", [float(len(x)) for x in all_changes]),
        _mean("reference coordinates jump at the door [m]", "—", [x[0].jump for x in all_changes if x]),
        Row("step of the control error at a change, largest [m]", "none", max(x.felt for x in flat), Band(0.0, 0.05),
            note=f"half a second before a change: {max(x.felt for x in before):.4f}"),
        _mean("true departure from the way it was on, 0.25 s after a change [m]", "none",
              [x.moved for x in flat], STILL,
              f"at most {max(x.moved for x in flat):.3f}; the aircraft steers all the time:"),
        _mean("the same, half a second before a change [m]", "—", [x.moved for x in before], None,
              f"at most {max(x.moved for x in before):.3f}"),
        _mean("from the last satellite fix to the change of filters [s]", "—", silent, Band(0.0, 1.5)),
        Row("passes the door: farthest from its middle [m]", f"< {WIDE:g}", max(wall), Band(0.0, WIDE),
            note="the magnetometer turns the map's world against that of the start"),
        Row("control error, largest [m]", "< 1.5, the bound of the watch",
            max(float(x.max()) for x in errors), Band(0.0, 1.5)),
        _mean("control error, mean [m]", "—", [float(x.mean()) for x in errors]),
        Row("indoors flown with limits slow and gains soft [share]", "all",
            float(np.mean([_slow(x) for x in logs])), ALL),
        Row("emergencies and failsafes", "none", float(sum(_hurt(x) for x in logs)), NEVER),
        _mean("landed from where it was asked to [m]", "—", off, Band(0.0, 0.5)),
        Row("the same, largest [m]", "—", max(off), Band(0.0, 1.0)),
    )  # fmt: skip
    return Outcome(rows, _indoor_panels(logs, ends), _INDOORS)


_INDOORS = (
    f"`uavlab fly outdoor-indoor-managed`: {NAME} takes off under the sky on RTK with the limits medium, is told fast "
    "and tight, flies to two places in the world of the satellites, one in front of a house, and from there to three "
    "in the world of a map that knows the house, and lands. Walls are no-fly zones. As it passes the door satellites "
    "are lost; from 21 to 25 s the map is, too, and optic flow carries on.",
    "What flies when is the arbiter's choice. The groups are those of `uavlab.managers.groups`: a camera allows slow "
    "and medium, soft and supersoft; what it does not allow falls back to slow and soft.",
)


def _in_air(log: Log) -> Array:
    return (log.r[:, 2] > 0.3) & (log.t > 1.0)


def _left(log: Log) -> float:
    """From the loss of satellites to the first filter without them [s]."""
    return next((a - DOOR for a, _, name in flown_by(log) if a > DOOR and name), np.nan)


def _beside_door(log: Log) -> float:
    """How far from the middle of the door it truly passes the wall [m]."""
    k = int(np.argmax(log.r[:, 0] > HOUSE[0]))
    return float(abs(log.r[k, 1])) if k else np.nan


def _slow(log: Log) -> bool:
    """Whether slow limits and soft gains took over when the satellites were lost."""
    fell = (when(log, "limits", "slow", DOOR), when(log, "gains", "soft", DOOR))
    return max(fell) < DOOR + 2.0


def _indoor_panels(logs: list[Log], ends: list) -> tuple[Panel, ...]:
    x0, y0, x1, y1 = HOUSE
    house = Line(
        "walls",
        np.array((x0, x0, x1, x1, x0, x0)),
        np.array((-WIDE, y0, y0, y1, y1, WIDE)),
        "paper",
    )
    paths = tuple(Line("", x.r[:, 0], x.r[:, 1]) for x in logs[:8])
    one, same = logs[0], told(logs[0])
    marks = ((DOOR, "satellites lost"),)
    stood = Line(
        "landed", np.array([x.at[0] for x in ends]), np.array([x.at[1] for x in ends]), "points"
    )
    error = tuple(
        Line("", x.t, np.where(_in_air(x), np.linalg.norm(x.r_e - x.r_d, axis=1), np.nan))
        for x in logs[:8]
    )
    return (
        Panel("True paths from above", "x [m]", "y [m]", (house, *paths, stood), equal=True),
        Panel("x as it is told, seed 0", "time [s]", "x [m]",
              (Line("true", one.t, one.r[:, 0], "truth"), Line("estimate", one.t, one.r_e[:, 0]),
               Line("reference", one.t, one.r_d[:, 0], "dashed")), marks),
        Panel("x told in the world of the start, seed 0", "time [s]", "x [m]",
              (Line("true", one.t, one.r[:, 0], "truth"), Line("estimate", one.t, same.r_e[:, 0])), marks),
        Panel("Control error", "time [s]", "[m]", error, marks),
    )  # fmt: skip


def _mean(
    quantity: str, paper: str, each: list[float], band: Band | None = None, note: str = ""
) -> Row:
    return Row(quantity, paper, float(np.mean(each)), band, float(np.std(each)), note)


EXPERIMENTS = (
    Experiment(
        "000-11-managed", "From GNSS to RTK under orders, in an area", "MRS Sec. 3.5, 7", _switch
    ),
    Experiment(
        "outdoor-indoor-managed",
        "Through a door under orders: the map takes over, and limits fall",
        "MRS Sec. 7.1",
        _indoors,
    ),
)
