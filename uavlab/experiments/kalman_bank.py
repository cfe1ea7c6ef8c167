"""MRS Sec. 3.5 flown again: a switch of worlds, one filter that hears everything, consistency, and a flight indoors."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import inf
from typing import NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.consistency import consistency
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.fly import fly
from uavlab.flight.log import Log
from uavlab.flight.worlds import flown_by, told
from uavlab.parts.bank import chosen
from uavlab.scenarios.estimation import bank_mind, gnss_to_rtk, naive_mind, through_a_door
from uavlab.sensors import Outage
from uavlab.types import Array

SOURCE = "MRS Sec. 3.5"
AT, END = 1.2, 2.2  # [s] the switch, and the end of these flights
MEAN, WORST = partial(np.mean, axis=0), partial(np.max, axis=0)


class Four(NamedTuple):
    """One seed, flown on the bank, on the bank without the switch, and on one filter that hears both."""

    bank: Log
    stayed: Log
    bank_level: Log  # as `bank`, had both receivers the same coordinates
    naive: Log
    naive_level: Log


def _switches(seeds: int) -> Iterator[Four]:
    """Hover on GNSS; corrections arrive at 0.7 s, RTK is asked for at `AT`."""
    two = chosen("gnss", "rtk")
    scenario = gnss_to_rtk()._replace(
        duration=END, mind=bank_mind(two, ((0.0, "gnss"), (AT, "rtk")))
    )
    rtk = scenario.sensors["rtk"]._replace(corrections_lost=(Outage(0.0, 0.7),))
    far = scenario._replace(sensors={**scenario.sensors, "rtk": rtk})
    level = far._replace(sensors={**far.sensors, "rtk": rtk._replace(offset=np.zeros(3))})
    stay, one = bank_mind(two, ((0.0, "gnss"),)), naive_mind(two)
    for seed in range(seeds):
        minds = (
            far,
            far._replace(mind=stay),
            level,
            far._replace(mind=one),
            level._replace(mind=one),
        )
        yield Four(*(fly(each, seed=seed) for each in minds))


def _apart(a: Log, b: Log) -> Array:
    """How far apart two flights truly are [m], (N,)."""
    n = min(len(a.t), len(b.t))
    return np.linalg.norm(a.r[:n] - b.r[:n], axis=1)


def _switch(seeds: int) -> Outcome:
    """Switch from GNSS to RTK, metres away, in closed loop."""
    answer("kalman_bank", "KalmanBank")
    flown = list(_switches(seeds))
    k = round(AT * 100)
    offset = np.stack([_apart(x.bank, x.bank_level) for x in flown])
    naive = np.stack([_apart(x.naive, x.naive_level) for x in flown])
    other = np.stack([_apart(x.bank, x.stayed) for x in flown])
    jump = np.array([np.linalg.norm(x.bank.r_d[k] - x.bank.r_d[k - 1]) for x in flown])
    steps = np.array([np.linalg.norm(_error(x.bank, k) - _error(x.stayed, k)) for x in flown])
    kick = np.array([np.linalg.norm(told(x.bank).v_e[k] - told(x.stayed).v_e[k]) for x in flown])
    quick = other[:, k : k + 25].max(axis=1)
    wander = np.array([_wander(x.stayed, k) for x in flown])
    rows = (
        _row("reference coordinates jump at the switch [m]", "several metres", jump, Band(0.5, inf)),
        _row(
            "true displacement that the offset makes, within 1 s of the switch [m]", "none",
            offset[:, k:].max(axis=1), Band(0.0, 0.02),
            "worst tick, against the same noise with both receivers in the same coordinates",
        ),
        _row(
            "the same, when one filter hears both [m]", "several metres",
            naive[:, -1], Band(1.0, inf), "the offset is 1.97 m",
        ),
        _row("step of the tracking error at the switch [m]", "none", steps, Band(0.0, 0.02)),
        _row(
            "step of the velocity estimate at the switch [m/s]", "—", kick, None,
            "two filters do not agree on it; a shift of worlds moves points, not speeds",
        ),
        _row(
            "true distance from the flight that did not switch, within 0.25 s [m]", "none",
            quick, Band(0.0, 0.02),
            f"mean of the flights; the worst is {quick.max():.3f} m: its two filters disagree most on the velocity",
        ),
        _row(
            "the same, within 1 s [m]", "—", other[:, k : k + 100].max(axis=1), None,
            "not of the switch: from then on one aircraft follows the noise of RTK and one that of GNSS",
        ),
        _row("motion of the flight that did not switch, in that second [m]", "—", wander, None),
    )  # fmt: skip
    return Outcome(rows, _switch_panels(flown[0], offset, naive), _REMARKS)


_REMARKS = (
    "The bank and the one filter hear the same receivers with the same noise; only the estimator differs.",
    "The one filter takes every innovation: with the bank's gate it would refuse RTK for ever, or jump to it.",
)


def _row(
    what: str, paper: str, values: Array, band: Band | None, note: str = ""
) -> Row:  # over the seeds
    return Row(what, paper, float(np.mean(values)), band, float(np.std(values)), note)


def _error(log: Log, k: int) -> Array:
    """What the position controller sees in tick `k`, in the world of the start [m], (3,)."""
    flight = told(log)
    return flight.r_e[k] - flight.r_d[k]


def _step_of_error(log: Log, k: int) -> float:
    """How far the error that the controller sees moves in the tick of the switch, beyond the tick before [m]."""
    error = log.r_e - log.r_d
    turn = log.worlds.shift_heading[k] - log.worlds.shift_heading[k - 1]
    c, s = np.cos(turn), np.sin(turn)
    x, y, z = error[k - 1]
    return float(np.linalg.norm(error[k] - (c * x - s * y, s * x + c * y, z)))


def _wander(log: Log, k: int) -> float:
    return float(np.linalg.norm(log.r[k : k + 100] - log.r[k], axis=1).max())


def _switch_panels(one: Four, offset: Array, naive: Array) -> tuple[Panel, ...]:
    t, bank, plain = one.bank.t, one.bank, one.naive
    raw = Panel(
        "x as the bank tells it, seed 0", "time [s]", "x [m]",
        (
            Line("true", t, bank.r[:, 0], "truth"), Line("estimate", t, bank.r_e[:, 0]),
            Line("reference", t, bank.r_d[:, 0], "dashed"),
        ), ((AT, "RTK flies"),),
    )  # fmt: skip
    fused = Panel(
        "x as one filter tells it, seed 0", "time [s]", "x [m]",
        (
            Line("true", t, plain.r[:, 0], "truth"), Line("estimate", t, plain.r_e[:, 0]),
            Line("reference", t, plain.r_d[:, 0], "dashed"),
        ), ((0.8, "RTK is heard"),),
    )  # fmt: skip
    moved = Panel(
        "true displacement that the offset makes, all seeds", "time [s]", "[m]",
        (
            Line("one filter, worst", t, WORST(naive).clip(1e-16), "dashed"),
            Line("one filter, mean", t, MEAN(naive).clip(1e-16)),
            Line("bank, worst", t, WORST(offset).clip(1e-16)),
            Line("2 cm", t, np.full(len(t), 0.02), "paper"),
        ), ((AT, "switch"),), log_y=True,
    )  # fmt: skip
    where = Panel(
        "true path from above, seed 0", "x [m]", "y [m]",
        (
            Line("one filter", plain.r[:, 0], plain.r[:, 1], "dashed"),
            Line("bank", bank.r[:, 0], bank.r[:, 1]),
            Line("bank, not switched", one.stayed.r[:, 0], one.stayed.r[:, 1], "truth"),
        ), equal=True,
    )  # fmt: skip
    return raw, fused, moved, where


# Outdoors → indoors -----------------------------------------------------------------------------------


def _indoor(seeds: int) -> Outcome:
    """Fly through a door behind which no satellite is heard."""
    answer("kalman_bank", "KalmanBank")
    door = 3.5
    logs = [fly(through_a_door(door), seed=seed) for seed in range(seeds)]
    goal = np.array([1.2 * door, 0.4 * door, 2.0])
    done = [log.exit.name == "DONE" for log in logs]
    inside = [flown_by(log)[-1][2] in {"slam", "flow+slam"} for log in logs]
    silent = np.array([_after(log, door) for log in logs])
    gap = np.array([np.linalg.norm(log.r[-1] - goal) for log in logs])
    steps = [
        (log, k)
        for log in logs
        for k in (np.flatnonzero(np.diff(log.worlds.flies)) + 1).tolist()
        if k > 20
    ]
    jump = np.array([np.linalg.norm(log.r_d[k] - log.r_d[k - 1]) for log, k in steps] or [np.nan])
    felt = np.array([_step_of_error(log, k) for log, k in steps] or [np.nan])
    rows = (
        Row("flights that end as they should [share]", "all", float(np.mean(done)), Band(1.0, 1.0)),
        Row("of them, flown by the map at the end [share]", "all", float(np.mean(inside)), Band(1.0, 1.0)),
        _row("from the last satellite fix to the change of filters [s]", "—", silent, Band(0.0, 1.5)),
        _row("reference coordinates jump at a change [m]", "—", jump, None),
        _row("step of the tracking error at a change [m]", "none", felt, Band(0.0, 0.02)),
        _row(
            "true distance from the last goal of the mission at the end [m]", "—", gap, Band(0.0, 2.0),
            "the mission gave its goals before the flight, in the world of the start; "
            "what GNSS was wrong by when it was left stays",
        ),
    )  # fmt: skip
    return Outcome(rows, _indoor_panels(logs, door))


def _after(log: Log, door: float) -> float:
    """Time from the door to the change of filters [s]; NaN if there was none."""
    return next((start - door for start, _, name in flown_by(log) if start > door and name), np.nan)


def _indoor_panels(logs: list[Log], door: float) -> tuple[Panel, ...]:
    one = told(logs[0])
    t, w = one.t, one.worlds
    paths = tuple(Line("", log.r[:, 0], log.r[:, 1]) for log in logs[:8])
    asked = Line("asked, seed 0", one.r_d[:, 0], one.r_d[:, 1], "paper")
    above = Panel("true paths from above", "x [m]", "y [m]", (asked, *paths), equal=True)
    lines = [Line("true", t, one.r[:, 0], "truth")]
    for k, name in enumerate(w.names):
        lines.append(Line(name, t, np.where(w.reliable[:, k], w.r[:, k, 0], np.nan)))
    same = Panel(
        "x of every hypothesis, told in the world of the start", "time [s]", "x [m]", tuple(lines),
        ((door, "satellites lost"),),
    )  # fmt: skip
    raw = Panel(
        "x as it was told, seed 0", "time [s]", "x [m]",
        (Line("true", t, one.r[:, 0], "truth"), Line("estimate", t, logs[0].r_e[:, 0]),
         Line("reference", t, logs[0].r_d[:, 0], "dashed")),
        ((door, "satellites lost"),),
    )  # fmt: skip
    error = Panel(
        "true distance from the reference, all seeds", "time [s]", "[m]",
        tuple(Line("", log.t, np.linalg.norm(log.r - told(log).r_d, axis=1)) for log in logs[:8]),
        ((door, "satellites lost"),),
    )  # fmt: skip
    return above, same, raw, error


EXPERIMENTS = (
    Experiment(
        "000-11",
        "Switch from GNSS to RTK, metres away, and one filter that hears both",
        SOURCE,
        _switch,
    ),
    Experiment(
        "000-indoor",
        "Outdoors to indoors: satellites lost, map and optic flow take over",
        "MRS Sec. 7.1",
        _indoor,
    ),
    Experiment("000-nees", "Consistency of the bank's filters", "MRS Sec. 3.2", consistency, 100),
)
