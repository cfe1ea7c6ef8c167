"""The MPC controller behind references that move: with the plan of MRS (44), and with one that follows them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.landing_detection import END, errand, landings
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.log import Log
from uavlab.flight.metrics import position_error
from uavlab.gains import MpcGains, mpc_gains_for
from uavlab.plant import load_airframe
from uavlab.types import Array, Exit

NAMES = ("T650", "F450")
SPEEDS = (0.5, 1.0, 1.5, 3.0)  # [m/s] of the reference; MPC may fly at 2
PRINTED, FOLLOWS = "plan (44)", "plan that follows"
NEVER = Band(0.0, 0.0)


class Errands(NamedTuple):
    """Some errands of one aircraft behind one speed."""

    fell: int  # that ended before their time
    mean: Array  # (n,) [m] mean error of those that did not
    height: Array  # (n,) [m] their largest error of height
    logs: list[Log]


def errands(name: str, speed: float, follows: bool, seeds: int) -> Errands:
    """Fly them: ten places, one each 3 s, in wind of up to 8 m/s with gusts."""
    mass = float(load_airframe(name).m)
    part = answer("mpc", "MpcController")(mass, gains=mpc_gains_for(mass)._replace(follows=follows))
    logs = [errand(part, seed, speed, name) for seed in range(seeds)]
    flew = [x for x in logs if x.exit is Exit.DONE]
    mean = np.array([position_error(x).mean() for x in flew])
    height = np.array([np.abs(x.r[:, 2] - x.r_d[:, 2]).max() for x in flew])
    return Errands(len(logs) - len(flew), mean, height, logs)


def rows_of(name: str, speed: float, seeds: int) -> tuple[list[Row], dict[str, Errands]]:
    """How many of one speed fell, and how far the others were off."""
    flown = {
        kind: errands(name, speed, kind == FOLLOWS, seeds) for kind in (PRINTED, FOLLOWS)
    }  # fmt: skip
    what, rows = f"{name} behind {speed:g} m/s", []
    for kind, each in flown.items():
        band = NEVER if kind == FOLLOWS else None
        rows.append(Row(f"{what}, {kind}: errands that fell", "—", float(each.fell), band))
        if each.mean.size:
            rows += [
                Row(f"{what}, {kind}: error, mean [m]", "—", float(each.mean.mean()), None,
                    float(each.mean.std())),
                Row(f"{what}, {kind}: error of height, largest [m]", "—", float(each.height.max())),
            ]  # fmt: skip
    return rows, flown


def run(seeds: int) -> Outcome:
    """All of it."""
    rows, shown = [], {}
    for name in NAMES:
        for speed in SPEEDS:
            new, flown = rows_of(name, speed, seeds)
            rows += new
            shown[name, speed] = flown
    rows += _landings(seeds)
    return Outcome(tuple(rows), _panels(shown), _REMARKS)


def _landings(seeds: int) -> list[Row]:
    """What it costs: the mass that a lag has taught is not there when it lands."""
    mpc, told = answer("mpc", "MpcController"), float(load_airframe(NAMES[0]).m)
    rows = []
    for kind in (PRINTED, FOLLOWS):
        each = landings(lambda kind=kind: mpc(told, gains=MpcGains(follows=kind == FOLLOWS)), seeds)
        after, down = [x.after for x in each], [x.vertical for x in each]
        rows += [
            Row(f"{NAMES[0]}, landings as in 000-9, {kind}: disarmed after contact [s]", "—",
                float(np.mean(after)), None, float(np.std(after))),
            Row(f"the same, {kind}: vertical speed at contact [m/s]", "0.5 asked for",
                float(np.mean(down)), None, float(np.std(down))),
        ]  # fmt: skip
    return rows


_REMARKS = (
    "The errands of 000-9: ten places within 16 by 16 by 12 m, one each 3 s, wind of up to 8 m/s with gusts. (44) "
    "plans towards a reference at rest; the plan brakes, the aircraft lags, the mass (37) learns the lag, and swings "
    "until the aircraft falls. `MpcGains(follows=True)` carries the reference on by its velocity, as the newer "
    "mrs_uav_controllers do by the prediction of the tracker. `uavlab.piloted` flies it.",
    "It also learns differently: disturbances and mass rest while their error shrinks at more than 0.3 m/s, the mass "
    "also while the reference is faster than the plan may be. (35) rests above 0.3 m/s of any motion: who is blown "
    "away by wind of more than 2 m/s² then never learns that there is any. That is most of the mean error of (44).",
    "What stays of the error is horizontal, and the wind: k_iw learns 0.1 N each second for each metre.",
)


def _panels(shown: dict[tuple[str, float], dict[str, Errands]]) -> tuple[Panel, ...]:
    """Heights of a flight that falls and of one that does not; how many fell."""
    one = shown["T650", 1.5]
    lines = [Line(kind, x.logs[0].t, x.logs[0].r[:, 2]) for kind, x in one.items()]
    wanted = one[FOLLOWS].logs[0]
    lines.append(Line("reference", wanted.t, wanted.r_d[:, 2], "dashed"))
    first = Panel("T650 behind 1.5 m/s, seed 0", "time [s]", "height [m]", tuple(lines))
    every = [Line("", x.t, np.abs(x.r[:, 2] - x.r_d[:, 2])) for x in one[FOLLOWS].logs]
    spread = Panel(
        f"T650 behind 1.5 m/s, {FOLLOWS}, all seeds", "time [s]", "error of height [m]",
        tuple(every), ((END, "end"),),
    )  # fmt: skip
    fell = [
        Line(f"{name}, {kind}", np.array(SPEEDS),
             np.array([float(shown[name, v][kind].fell) for v in SPEEDS]), "line" if name == "T650" else "dashed")
        for name in NAMES for kind in (PRINTED, FOLLOWS)
    ]  # fmt: skip
    counted = Panel("Errands that fell", "speed of the reference [m/s]", "of 20", tuple(fell))
    return first, spread, counted


EXPERIMENTS = (
    Experiment("mpc-errands", "Behind a reference that moves", "MRS Sec. 5.7, eq. (37), (44)", run),
)
