"""000-10: position and velocity are lost at 2 m, and the failsafe brings the aircraft down (MRS Sec. 5.10)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.control_flights import KNOWS, Knows, law, memories
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.fly import fly
from uavlab.flight.log import Log
from uavlab.flight.metrics import tilt
from uavlab.flight.scenario import Scenario, Swap, standing
from uavlab.flight.slot import Slot
from uavlab.frames import Shift, moved
from uavlab.gains import gains_for
from uavlab.interfaces import Readings, Stack
from uavlab.parts.failsafe import Failsafe
from uavlab.parts.missions import Waypoints
from uavlab.parts.throttle import ThrustCurve
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import CALM, CompiledPlant, Wind, load_airframe
from uavlab.sensors import Ahrs
from uavlab.types import GRAVITY, Array, Command, Estimate, Hypothesis

NAME = "T650"
HEIGHT = 2.0  # [m]
LOST = 8.0  # [s] of hover, in which a load is learned
END = LOST + 8.0
TOLD, MORE = 3.5, 0.5  # [kg], of the airframe, and a load
NOWHERE = np.full(3, np.nan)
CURVE_OF_2020 = {"share": 0.95, "rate": 0.02}


class Hours(NamedTuple):
    """Memory of `Loses`."""

    t: float  # [s]
    last: Estimate


@dataclass(frozen=True)
class Loses:
    """An estimator that believes its instruments, and from ``lost`` on knows its attitude only."""

    slot: ClassVar[str] = "estimator"
    lost: float  # [s]

    def init(self, estimate: Estimate) -> Hours:
        """What is true at the start."""
        return Hours(0.0, estimate)

    def step(
        self, memory: Hours, readings: Readings, command: Command, dt: float
    ) -> tuple[Hours, Estimate]:
        """What was told now; no position, velocity or acceleration once they are lost."""
        told: Any = readings.get(KNOWS, memory.last)
        attitude: Any = readings.get("ahrs", memory.last)
        told, t = told._replace(R=attitude.R), memory.t + dt
        if t > self.lost - 1e-9:
            told = told._replace(r=NOWHERE, v=NOWHERE, a=NOWHERE)
        return Hours(t, told), told

    def reframe(self, memory: Hours, shift: Shift) -> Hours:
        """The same, told in another world."""
        return memory._replace(last=moved(memory.last, shift))

    def hypotheses(self, memory: Hours) -> Mapping[str, Hypothesis]:
        """It has one belief only."""
        return {}


class Fallen(NamedTuple):
    """A flight after the loss."""

    after: float  # [s] from the loss to the ground; inf: it did not get there
    speed: float  # [m/s] at touch-down, all of it
    aside: float  # [m/s] at touch-down, horizontally
    tilt: float  # [deg] largest on the way
    log: Log


def failsafe(mass: float = TOLD, **numbers: Any) -> Failsafe:
    """That of the airframe, for a believed mass [kg]."""
    airframe = load_airframe(NAME)
    return Failsafe(mass, ThrustCurve(airframe.a_t, airframe.b_t), **numbers)


def fall(part: Failsafe, seed: int, *, wind: Wind = CALM, more: float = 0.0) -> Log:
    """Hover with SE(3); then everything but the attitude is lost, and `part` takes over in the same tick."""
    airframe = load_airframe(NAME)
    scenario = Scenario(
        "fall", "", NAME, Waypoints(((0.0, (0.0, 0.0, HEIGHT), 0.0),)),
        standing((0.0, 0.0, HEIGHT)), END,
        {KNOWS: Knows(0.02, 0.05), "ahrs": Ahrs(heading=0.0, heading_walk=0.0)},
        wind=wind, swaps=(Swap(LOST, "controller", "failsafe"),),
    )  # fmt: skip
    slot: Any = Slot({"SE(3)": law(TOLD, gains_for(NAME, "soft")), "failsafe": part})
    plant = CompiledPlant(airframe._replace(m=airframe.m + more))
    return fly(scenario, Stack(Loses(LOST), CommandFilter(), slot), seed=seed, plant=plant)


def fallen(log: Log) -> Fallen:
    """What became of it."""
    falls = log.t >= LOST - 1e-9
    down = np.flatnonzero(falls & (log.r[:, 2] <= 0.0))
    k = int(down[0]) if down.size else len(log.t) - 1
    v, way = log.v[k - 1], falls & (np.arange(len(log.t)) <= k)
    after = float(log.t[k]) - LOST if down.size else np.inf
    degrees = float(np.rad2deg(tilt(log)[way].max()))
    return Fallen(after, float(np.linalg.norm(v)), float(np.hypot(v[0], v[1])), degrees, log)


def learned_mass(seed: int, more: float) -> float:
    """What SE(3) believes that it weighs [kg] when everything is lost."""
    log = fall(failsafe(), seed, more=more)
    upto = int(np.searchsorted(log.t, LOST - 1e-9))
    before = log._replace(**{x: getattr(log, x)[:upto] for x in _SERIES})
    return float(memories(before, law(TOLD, gains_for(NAME, "soft")))[-1].m_e)


_SERIES = ("t", "r_e", "v_e", "R_e", "omega", "r_d", "v_d", "a_d", "heading_d", "heading_rate_d")


def half_after(part: Failsafe) -> float:
    """When its throttle would hover half of the mass [s]."""
    weight = part.mass * GRAVITY
    return (part.share * throttle(part, weight) - throttle(part, weight / 2.0)) / part.rate


def throttle(part: Failsafe, f: float) -> float:
    """The throttle for a force [N], 0 to 1."""
    return min(max(answer("dynamics", "throttle_from_force")(f, *part.curve), 0.0), 1.0)


def run(seeds: int) -> Outcome:
    """000-10."""
    part, wind = failsafe(), CALM._replace(mean=np.array((3.0, 0.0, 0.0)))
    calm = [fallen(fall(part, s)) for s in range(seeds)]
    blown = [fallen(fall(part, s, wind=wind)) for s in range(seeds)]
    old = [fallen(fall(replace(part, **CURVE_OF_2020), s)) for s in range(seeds)]
    loaded = [fallen(fall(part, s, more=MORE)) for s in range(seeds)]
    believed = [learned_mass(s, MORE) for s in range(seeds)]
    knows = [fallen(fall(failsafe(m), s, more=MORE)) for s, m in enumerate(believed)]
    rows = (
        _mean("on the ground after [s]", "moderate descent", [x.after for x in calm], Band(2.0, 3.0)),
        Row("the same, soonest [s]", "—", min(x.after for x in calm), Band(2.0, 3.0)),
        Row("the same, latest [s]", "—", max(x.after for x in calm), Band(2.0, 3.0)),
        Row("speed at touch-down, largest [m/s]", "—", max(x.speed for x in calm), Band(0.0, 2.6)),
        Row("tilt on the way, largest [deg]", "levelled", max(x.tilt for x in calm), Band(0.0, 2.0)),
        _mean("speed aside at touch-down [m/s]", "—", [x.aside for x in calm]),
        _mean("in 3 m/s of wind: speed aside at touch-down [m/s]", "—", [x.aside for x in blown]),
        Row("in 3 m/s of wind: tilt as it is lost, largest [deg]", "—", max(x.tilt for x in blown)),
        _mean("as in 2020 (.95, 2 %/s): on the ground after [s]", "—", [x.after for x in old]),
        _mean("as in 2020: speed at touch-down [m/s]", "—", [x.speed for x in old]),
        _mean(f"+{MORE} kg, nobody told of: speed at touch-down [m/s]", "—", [x.speed for x in loaded]),
        _mean(f"+{MORE} kg: mass that SE(3) believes as it is lost [kg]", f"{TOLD + MORE}", believed),
        _mean(f"+{MORE} kg, that mass: on the ground after [s]", "—", [x.after for x in knows]),
        _mean(f"+{MORE} kg, that mass: speed at touch-down [m/s]", "—", [x.speed for x in knows]),
        Row("throttle of half of the mass after [s]", "—", half_after(part)),
    )  # fmt: skip
    remarks = (
        f"{NAME} hovers {LOST:g} s at {HEIGHT:g} m with SE(3), then position, velocity and acceleration are NaN. "
        "Attitude from the modelled autopilot, tilt errors included. The failsafe begins at .98 of the hover throttle "
        "and closes it by 1.5 % of its range each second; the command before it fades with 0.1 s.",
        "Level is what the attitude says: its own error of 0.3° stays. In wind the aircraft leant when it was lost; it "
        "is levelled, and drifts away with the air.",
    )
    return Outcome(rows, _panels(calm, blown, knows, part), remarks)


def _mean(quantity: str, paper: str, each: list[float], band: Band | None = None) -> Row:
    return Row(quantity, paper, float(np.mean(each)), band, float(np.std(each)))


def _panels(
    calm: list[Fallen], blown: list[Fallen], knows: list[Fallen], part: Failsafe
) -> tuple[Panel, ...]:
    """Height, speed, throttle and tilt after the loss: the first flight of a kind, and the spread of the calm ones."""

    def lines(of: Any) -> tuple[Line, ...]:
        kinds = (("calm", calm), ("3 m/s of wind", blown), (f"+{MORE} kg, learned", knows))
        t, every = since(calm[0].log), np.array([of(x.log)[shown(x.log)] for x in calm])
        spread = Line("calm, all seeds", t, every.min(axis=0), "band", every.max(axis=0))
        each = (Line(name, since(x[0].log), of(x[0].log)[shown(x[0].log)]) for name, x in kinds)
        return (spread, *each)

    def throttles(log: Log) -> Array:
        return np.array([throttle(part, float(f)) for f in log.f_d])

    x = "time after the loss [s]"
    return (
        Panel("Height", x, "height [m]", lines(lambda log: log.r[:, 2])),
        Panel("Vertical speed", x, "speed [m/s]", lines(lambda log: log.v[:, 2])),
        Panel("Throttle", x, "throttle [1]", lines(throttles)),
        Panel("Tilt", x, "tilt [deg]", lines(lambda log: np.rad2deg(tilt(log)))),
    )


def shown(log: Log) -> Array:
    """The ticks of the pictures (N,): a second before the loss, and four after it."""
    return (log.t > LOST - 1.0) & (log.t < LOST + 4.0)


def since(log: Log) -> Array:
    """Their times after the loss [s], shape (n,)."""
    return log.t[shown(log)] - LOST


EXPERIMENTS = (Experiment("000-10", "Nothing but an attitude at 2 m", "MRS Sec. 5.10", run),)
