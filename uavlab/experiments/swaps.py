"""Every controller takes over from every other in mid-flight, and every tracker; and a world jumps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import permutations
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.circles import FIG_7, HEIGHT, NAME, RADIUS, plant
from uavlab.experiments.control_flights import KNOWS, Believes, Knows, flown
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.fill import fill
from uavlab.flight.fly import fly
from uavlab.flight.log import Log
from uavlab.flight.metrics import position_error
from uavlab.flight.scenario import Scenario, Swap, standing
from uavlab.frames import moved
from uavlab.gains import GROUPS
from uavlab.interfaces import Stack
from uavlab.limits import limit_group
from uavlab.parts.controllers import HeadingController, TiltAxis
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.missions import Follow, Waypoints
from uavlab.parts.paths import circle
from uavlab.parts.slot import FIRST, TAKEN, Slot
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import CALM, load_airframe
from uavlab.sensors import ImuSensor, Mocap
from uavlab.types import Array, Command, Estimate, Hypothesis, Shift

NEAR = Band(-np.inf, 0.02)  # [m]
AT, WATCHED = 1.0, 3.0  # [s] of a hover: when it is swapped, and for how long it is watched
AT_SPEED, BUMP, AFTER = (
    8.0,
    0.3,
    4.0,
)  # [s] of a circle: swap, how long a bump is, and how long it flies on
FAST, SLOW = 7.0, 2.5  # [m/s]
FLIES = 1.0  # [m] mean error in the last lap, above which a part cannot fly the circle
BLOW = np.array((3.0, 0.0, 0.0))  # [m/s] of steady wind
JUMP, JUMPED = (
    Shift(np.array((3.0, -2.0, 0.5)), 0.4),
    600,
)  # the world of design.md, Sec. 3, and its tick
DT = 0.01  # [s]

Parts = Mapping[str, Any]


@lru_cache(maxsize=1)
def controllers() -> Parts:
    """Those of the issue, by the name that a swap calls them."""
    mass, gains = float(load_airframe(NAME).m), GROUPS["T650-sim-2020"]
    se3 = answer("geometric", "GeometricController")
    return {
        "SE(3) soft": se3(mass, gains["soft"]),
        "SE(3) tight": se3(mass, gains["tight"]),
        "MPC": answer("mpc", "MpcController")(mass),
        "heading": fill(HeadingController, mass=mass).part,
        "tilt": TiltAxis(mass),
    }


@lru_cache(maxsize=1)
def trackers() -> Parts:
    """Likewise; `race` has the limits of MRS Fig. 7."""
    mpc = answer("mpc", "MpcTracker")
    return {
        "MPC medium": mpc(limit_group("medium")),
        "MPC fast": mpc(limit_group("fast")),
        "filter": CommandFilter(),
        "MPC race": mpc(FIG_7),
    }


ISSUE = ("MPC medium", "MPC fast", "filter")  # of the trackers
RACERS = ("MPC race", "filter")  # the limits of the others forbid 7 m/s with 9.8 m/s²


def hovering(wind: Array | None = None) -> Scenario:
    """Hover on the instruments of the laboratory; in a steady wind, on the true state."""
    mission = Waypoints(((0.0, (0.0, 0.0, 2.0), 0.0),))
    kit: Mapping[str, Any] = {"imu": ImuSensor(), "mocap": Mocap()}
    calm = Scenario("hover", "", NAME, mission, standing((0, 0, 2)), AT + WATCHED, kit)
    if wind is None:
        return calm
    settled = 20.0  # [s] until the integrators know the wind
    return calm._replace(
        sensors={KNOWS: Knows()}, wind=CALM._replace(mean=wind), duration=settled + AFTER
    )


def circling(speed: float) -> Scenario:
    """The circle of MRS Fig. 10, the nose along x, by an aircraft that knows its state."""
    way = circle(np.array((0.0, 0.0, HEIGHT)), RADIUS)
    mission = Follow(way, speed / RADIUS, 5.0)
    start = standing((RADIUS, 0.0, HEIGHT))
    return Scenario("circle", "", NAME, mission, start, AT_SPEED + AFTER, {KNOWS: Knows()})


class Flight(NamedTuple):
    """What is swapped, and how it is flown."""

    scenario: Scenario
    slot: str  # tracker or controller
    names: tuple[str, ...]  # of the parts
    at: float  # [s]

    def fly(self, first: str, then: str = "", seed: int = 0) -> Log:
        """From `first` to `then`, or `first` all the way."""
        scenario = self.scenario
        if then:
            scenario = scenario._replace(swaps=(Swap(self.at, self.slot, then),))
        every = {"tracker": trackers(), "controller": controllers()}[self.slot]
        part: Any = Slot({name: every[name] for name in self.names}, first)
        follows = self.slot == "tracker"
        tracker = part if follows else CommandFilter()
        law = controllers()["SE(3) soft"] if follows else part
        if KNOWS in scenario.sensors:
            return flown(scenario, law, tracker=tracker, plant=plant())
        return fly(scenario, Stack(AlphaBetaGamma(), tracker, law), seed=seed, plant=plant())


def apart(a: Log, b: Log, at: float, seconds: float) -> Array:
    """Distance of two true paths [m] in the seconds after `at`; not a number if one ended or no swap was made."""
    first, n = round(at / DT), round(seconds / DT)
    if _refused(a) or _refused(b) or min(len(a.t), len(b.t)) < first + n:
        return np.full(n, np.nan)
    return np.linalg.norm(a.r[first : first + n] - b.r[first : first + n], axis=1)


def roams(log: Log, at: float, seconds: float) -> float:
    """Largest distance from where it was at `at` [m]."""
    some = slice(round(at / DT), round((at + seconds) / DT))
    if len(log.t) < some.stop or _refused(log):
        return float("nan")
    return float(np.linalg.norm(log.r[some] - log.r[some.start], axis=1).max())


def _refused(log: Log) -> bool:
    return any(outcome not in {FIRST, TAKEN} for *_, outcome in log.meta["swaps"])


# The matrices -----------------------------------------------------------------------------------------


def hover_rows(flight: Flight, seeds: int) -> tuple[list[Row], dict[tuple[str, str], float]]:
    """One row for each pair: how much farther a swap lets the aircraft roam."""
    without = {a: [flight.fly(a, seed=s) for s in range(seeds)] for a in flight.names}
    rows, matrix = [], {}
    for a, logs in without.items():
        each = [roams(x, AT, WATCHED) for x in logs]
        what = f"hover, {flight.slot}: {a} alone: roams [m]"
        rows.append(Row(what, "—", float(np.mean(each)), None, float(np.std(each))))
    for a, b in permutations(flight.names, 2):
        logs = [flight.fly(a, b, seed=s) for s in range(seeds)]
        each = [
            roams(x, AT, WATCHED) - roams(y, AT, WATCHED)
            for x, y in zip(logs, without[a], strict=True)
        ]
        distance = [apart(x, y, AT, WATCHED).max() for x, y in zip(logs, without[a], strict=True)]
        matrix[a, b] = float(np.max(distance))
        rows.append(Row(f"hover, {flight.slot}: {a} → {b}: roams farther by [m]", "—",
                        float(np.mean(each)), NEAR, float(np.std(each)),
                        f"at most {max(each):.4f}; largest distance of the two paths {matrix[a, b]:.4f}"))  # fmt: skip
    return rows, matrix


Swapped = dict[tuple[str, str], Array]


def circle_rows(flight: Flight, speed: float) -> tuple[list[Row], Swapped]:
    """One row for each pair that can fly it: the distance to the flight without swap, and where it ends."""
    alone = {a: flight.fly(a) for a in flight.names}
    late = round(AT_SPEED / DT)
    errors = {a: float(position_error(x)[late:].mean()) for a, x in alone.items()}
    able = [a for a in flight.names if errors[a] < FLIES and alone[a].exit.name == "DONE"]
    what = f"circle, {speed:g} m/s, {flight.slot}"
    rows = [Row(f"{what}: {a}: mean error without swap [m]", "—", errors[a], None, None,
                "" if a in able else "cannot fly it: not swapped") for a in flight.names]  # fmt: skip
    found: Swapped = {}
    for a, b in permutations(able, 2):
        log = flight.fly(a, b)
        found[a, b] = apart(log, alone[a], AT_SPEED, AFTER)
        after, there = float(found[a, b].max()), float(apart(log, alone[b], AT_SPEED, AFTER)[-1])
        rows.append(Row(f"{what}: {a} → {b}: first {BUMP:g} s [m]", "—",
                        float(found[a, b][: round(BUMP / DT)].max()), NEAR, None,
                        f"later {after:.2f} from the old way, at the end {there:.3f} from the new one's"))  # fmt: skip
    return rows, found


def windy_rows(flight: Flight) -> tuple[list[Row], Swapped]:
    """Hover in a steady wind: whoever learned the wind hands over a command, but not what it learned."""
    rows, found = [], {}
    for a, b in permutations(("SE(3) soft", "SE(3) tight"), 2):
        d = found[a, b] = apart(flight.fly(a, b), flight.fly(a), flight.at, AFTER)
        what = f"hover in {BLOW[0]:g} m/s of wind: {a} → {b}"
        rows += [Row(f"{what}: first {BUMP:g} s [m]", "—", float(d[: round(BUMP / DT)].max()), NEAR),
                 Row(f"{what}: in {AFTER:g} s [m]", "—", float(d.max()), None, None,
                     "its integrators begin at zero")]  # fmt: skip
    return rows, found


# The world that jumps ---------------------------------------------------------------------------------


class Told(NamedTuple):
    """Memory of `Jumps`."""

    estimate: Estimate
    tick: int


@dataclass(frozen=True)
class Jumps:
    """An estimator that knows the state, tells it in another world from a tick on, and says so."""

    slot: ClassVar[str] = "estimator"
    jump: Shift = JUMP
    at: int = JUMPED

    def init(self, estimate: Estimate) -> Told:
        """What is true at the start."""
        return Told(estimate, 0)

    def step(self, memory: Told, readings: Any, command: Command, dt: float) -> tuple[Told, Estimate]:  # fmt: skip
        """What was told now, in the world of now."""
        told, tick = readings.get(KNOWS, memory.estimate), memory.tick + 1
        if tick >= self.at:
            told = moved(told, self.jump)._replace(shift=self.jump)
        return Told(told, tick), told

    def reframe(self, memory: Told, shift: Shift) -> Told:
        """The same, told in another world."""
        return memory._replace(estimate=moved(memory.estimate, shift))

    def hypotheses(self, memory: Told) -> Mapping[str, Hypothesis]:
        """It has one belief only."""
        return {}


SOME = (
    Swap(4.0, "tracker", "MPC fast"), Swap(5.0, "controller", "MPC"), Swap(7.0, "tracker", "filter"),
    Swap(JUMPED * DT, "controller", "SE(3) tight"), Swap(8.0, "controller", "heading"),
)  # fmt: skip
LATE = (Swap(7.0, "controller", "MPC"),)


def jumped(swaps: tuple[Swap, ...]) -> tuple[Log, Log]:
    """The slow circle in wind with a slot in both places: with a jump of the world, and without."""
    scenario = circling(SLOW)._replace(wind=CALM._replace(mean=BLOW), swaps=swaps)
    tracker: Any = Slot(trackers(), "filter")
    law: Any = Slot(controllers(), "SE(3) soft")
    there, here = (
        fly(scenario, Stack(x, tracker, law), plant=plant()) for x in (Jumps(), Believes())
    )
    return there, here


def jump_rows() -> list[Row]:
    """What the jump does to the true path."""
    rows = []
    for name, swaps in {"no swap": (), "five swaps": SOME, "a swap to MPC after it": LATE}.items():
        d = float(apart(*jumped(swaps), 0.0, AT_SPEED + AFTER).max())
        band, why = (None, "its limits belong to axes: those of the world in which it begins")
        if swaps is not LATE:
            band, why = Band(0.0, 1e-9), "band: rounding"
        what = "the world jumps, slots in both places"
        rows.append(Row(f"{what}, {name}: paths apart [m]", "—", d, band, None, why))
    return rows


def run(seeds: int) -> Outcome:
    """All of it."""
    names = tuple(controllers())
    calm = hovering()
    laws, laws_matrix = hover_rows(Flight(calm, "controller", names, AT), seeds)
    ways, _ = hover_rows(Flight(calm, "tracker", ISSUE, AT), seeds)
    fast, found = circle_rows(Flight(circling(FAST), "controller", names, AT_SPEED), FAST)
    race, raced = circle_rows(Flight(circling(FAST), "tracker", RACERS, AT_SPEED), FAST)
    slow, slowly = circle_rows(Flight(circling(SLOW), "tracker", ISSUE, AT_SPEED), SLOW)
    windy = hovering(BLOW)
    blown, drifts = windy_rows(Flight(windy, "controller", names, windy.duration - AFTER))
    rows = (*laws, *ways, *fast, *race, *slow, *blown, *jump_rows())
    able = dict.fromkeys(a for a, _ in found)
    panels = (
        _matrix("Hover, controllers, all seeds", laws_matrix),
        _bumps(f"Hover in {BLOW[0]:g} m/s of wind", drifts, AFTER),
        *(_bumps(f"Circle, {FAST:g} m/s: from {a}", {k: d for k, d in found.items() if k[0] == a}) for a in able),
        _bumps(f"Circle, {FAST:g} m/s: trackers", raced),
        _bumps(f"Circle, {SLOW:g} m/s: trackers", slowly),
    )  # fmt: skip
    return Outcome(rows, panels, _remarks())


def _remarks() -> tuple[str, ...]:
    return (
        f"Hover: {NAME}, the instruments of the laboratory with their noise, swapped at {AT:g} s. Measured is how far "
        f"the true aircraft goes from where it was at the swap within {WATCHED:g} s, less how far it goes without the "
        "swap, same seed. The figure has the largest distance of the two true paths of all seeds, which is stricter. "
        "What is left is noise: that of the last command lasts while it fades, half a second. On the true "
        "state it is 0.",
        f"Circle: true state, radius {RADIUS:g} m, swapped at {AT_SPEED:g} s. Parts with different steady errors must "
        "move the aircraft in the end; that is what one swaps for. A bump is what comes at once: the distance to the "
        f"flight without swap in the first {BUMP:g} s. The notes say how far it goes later.",
        f"The {FAST:g} m/s circle asks for {FAST**2 / RADIUS:.1f} m/s²: the trackers medium and fast may not fly it. "
        f"They are swapped at {SLOW:g} m/s; at {FAST:g} m/s a tracker with the limits of MRS Fig. 7 stands in.",
        f"A part counts as able to fly a circle if its mean error there is below {FLIES:g} m. MPC has limits of 2 m/s "
        "and 2 m/s², and no jerk feed-forward: it is metres off, and is swapped in hover only.",
    )


def _matrix(title: str, matrix: Mapping[tuple[str, str], float]) -> Panel:
    """Who took over across, who flew before as clouds, a little beside each other."""
    names = list(dict.fromkeys(a for a, _ in matrix))
    lines = []
    for i, a in enumerate(names):
        others = [k for k, b in enumerate(names) if b != a]
        x = np.array(others) + 0.08 * (i - len(names) / 2)
        y = np.array([1e3 * matrix[a, names[k]] for k in others])
        lines.append(Line(f"from {a}", x, y, "points"))
    edge = np.array((-0.5, len(names) + 2.0))  # room for the legend
    limit = Line("20 mm", edge, np.full(2, 1e3 * NEAR.high), "paper")
    floor = Line("", edge, np.zeros(2), "truth")
    marks = tuple((k + 0.3, f"to {name}") for k, name in enumerate(names))
    return Panel(
        title, "who takes over", "paths apart, at most [mm]", (*lines, limit, floor), marks
    )


def _bumps(title: str, found: Swapped, seconds: float = 1.0) -> Panel:
    """Distance to the flight without swap over time, one line for each pair; less than a micrometre is left out."""
    some = slice(0, round(seconds / DT), 2)
    t = np.arange(round(AFTER / DT))[some] * DT
    lines = [
        Line(f"{a} → {b}", t, 1e3 * np.where(d > 1e-6, d, np.nan)[some])
        for (a, b), d in found.items()
    ]
    limit = Line("20 mm", np.array((0.0, seconds)), np.full(2, 1e3 * NEAR.high), "paper")
    return Panel(title, "time since the swap [s]", "from the flight without swap [mm]",
                 (*lines, limit), ((BUMP, f"{BUMP:g} s"),), True)  # fmt: skip


EXPERIMENTS = (Experiment("swap-matrix", "Parts swapped in mid-flight", "MRS Sec. 7.2", run),)
