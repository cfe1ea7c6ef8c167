"""003-1: an aircraft that is told the wrong mass takes off, finds the right one, and keeps it while it moves about."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.fly import fly
from uavlab.flight.log import Log
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import Shift
from uavlab.interfaces import Stack
from uavlab.parts.controllers import Gains, Handover, TiltAxis
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.missions import Waypoints
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import CompiledPlant, World, load_airframe
from uavlab.plant.compiled import STILL
from uavlab.sensors import ImuSensor, Mocap
from uavlab.types import GRAVITY, Array, Command, Estimate, MassMemory, Reference, Vec3

A, K = 0.06 * np.pi, 1.0  # [rad/s] and gain, as printed
TOLD, NOMINAL, PRINTED = 1.0, 1.308, 1.394  # [kg] at the start, on the scales, and what Spica found
WORN = NOMINAL / PRINTED  # thrust that a rotor gives, over what it was calibrated for: 0.938
HEIGHT = 1.5  # [m] of the hover
RISE, CALM, END = 4.0, 30.0, 40.0  # [s] when it is told to rise, to move at random, and to stop
LEG = 2.0  # [s] between random places
RATE = (
    60.0  # [Hz] of control, the slowest that Spica names; Euler's step of (10) would diverge at it
)
NAME = "MK-Quadro"
GAINS = Gains(k_p=2.5, k_v=2.5, k_R=4.0)  # slow motors bear no more
# Filters that have settled while it stood on the ground, commanded to carry the mass that it was told.
STANDING = MassMemory(0.0, TOLD * GRAVITY, GRAVITY, 1.0 / TOLD)
# (6) with g = +9.81 in a hover that is right at first.
HOVERING = MassMemory(0.0, NOMINAL * GRAVITY, -GRAVITY, 1.0 / NOMINAL)


class Adapted(NamedTuple):
    """What the controller remembers."""

    mass: MassMemory
    f_d: float  # [N] commanded last


@dataclass(frozen=True)
class AdaptiveMass:
    """The stand-in's law with the mass that it finds while it flies (Spica Sec. 5.4)."""

    slot: ClassVar[str] = "controller"
    first: MassMemory
    g: float = GRAVITY  # [m/s²]; below 0 it is (6) as printed

    def init(self, estimate: Estimate, last: Command | None) -> Adapted:
        """Begin with the mass that was told, and without a thrust."""
        return Adapted(self.first, 0.0)

    def step(
        self, memory: Adapted, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Adapted, Command]:
        """Learn from the thrust of the last tick, then command with what was learned."""
        mass = learned(memory.mass, estimate.v, estimate.R, memory.f_d, dt, self.g)
        law = TiltAxis(1.0 / mass.inverse, GAINS)
        _, command = law.step(Handover(None, None), estimate, reference, dt)
        return Adapted(mass, command.f_d), command

    def reframe(self, memory: Adapted, shift: Shift) -> Adapted:
        """Nothing of it depends on the world's origin or heading."""
        return memory


def learned(memory: MassMemory, v: Vec3, R: Array, f_d: float, dt: float, g: float) -> MassMemory:
    """One step of the law, with the printed numbers."""
    return answer("identification", "mass_step")(memory, v[2], R, f_d, dt, a=A, k=K, g=g)


class WornPlant:
    """An aircraft whose rotors together give `share` of the thrust that they are commanded."""

    def __init__(self, share: float) -> None:
        self.share, self.plant = share, CompiledPlant(load_airframe(NAME))
        self.init = self.plant.init

    def advance(
        self,
        world: World,
        command: Command,
        wind: Vec3 = STILL,
        dt: float = 0.01,
        n: int | None = None,
    ) -> World:
        """As `CompiledPlant.advance`, with less thrust."""
        return self.plant.advance(
            world, command._replace(f_d=self.share * command.f_d), wind, dt, n
        )  # fmt: skip


def scenario(seed: int, end: float = END) -> Scenario:
    """Stand, take off, hover, then fly to a random place every few seconds."""
    rng = np.random.default_rng([seed, 31])
    stops: list[Any] = [(0.0, (0.0, 0.0, 0.0), 0.0), (RISE, (0.0, 0.0, HEIGHT), 0.0)]
    for t in np.arange(CALM, end, LEG):
        x, y, z = rng.uniform((-2.0, -2.0, 1.0), (2.0, 2.0, 3.0)).tolist()
        stops.append((float(t), (x, y, z), 0.0))
    instruments = {"imu": ImuSensor(rate=RATE), "mocap": Mocap(rate=RATE)}
    flight = Scenario(
        "adaptive mass", "", NAME, Waypoints(tuple(stops)), standing((0, 0, 0)), end, instruments
    )
    return flight._replace(rate=RATE, physics=16.0 * RATE, mission_rate=RATE)


def flown(seed: int, share: float, end: float = END) -> Log:
    """One flight that begins on the ground, told a mass of 1 kg."""
    mind = AdaptiveMass(STANDING)
    stack = Stack(AlphaBetaGamma(), CommandFilter(v_max=1.5), mind)
    return fly(scenario(seed, end), stack, seed=seed, plant=WornPlant(share))


def flown_as_printed() -> Log:
    """(6) with g = +9.81, from a hover."""
    mind = AdaptiveMass(HOVERING, -GRAVITY)
    stack = Stack(AlphaBetaGamma(), CommandFilter(), mind)
    there = standing((0, 0, HEIGHT))
    hover = scenario(0, 5.0)._replace(
        start=there, mission=Waypoints(((0.0, (0.0, 0.0, HEIGHT), 0.0),))
    )
    return fly(hover, stack, seed=0, plant=WornPlant(1.0))


def masses(log: Log, first: MassMemory, g: float = GRAVITY) -> Array:
    """Estimated mass [kg] at each tick (N,): the flight's own, told again from what it measured and commanded."""
    dt, memory, f_d, out = log.meta["dt"], first, 0.0, np.empty(len(log.t))
    for k, (v, R) in enumerate(zip(log.v_e, log.R_e, strict=True)):
        memory = learned(memory, v, R, f_d, dt, g)
        out[k], f_d = 1.0 / memory.inverse, log.f_d[k]
    return out


class Found(NamedTuple):
    """One flight in numbers."""

    log: Log
    mass: Array  # (N,) [kg]
    lift_off: float  # [s] after it is told to rise
    final: float  # [kg] before the random motion
    settled: float  # [s] from lift-off until 95 % of the way is done
    wander: float  # largest share by which it leaves `final` during the random motion


def found(log: Log) -> Found:
    """What the flight says of the law."""
    mass = masses(log, STANDING)
    lift_off = float(log.t[np.argmax(log.r[:, 2] > 0.0)])
    hover = (log.t >= CALM - 5.0) & (log.t < CALM)
    final = float(mass[hover].mean())
    away = np.abs(mass - final) > 0.05 * abs(final - TOLD)
    last = np.flatnonzero(away & (log.t < CALM))[-1]
    wander = np.abs(mass[log.t >= CALM] / final - 1.0).max(initial=0.0)
    return Found(log, mass, lift_off - RISE, final, float(log.t[last]) - lift_off, float(wander))


def adaptive_mass(seeds: int) -> Outcome:
    """Spica's first experiment, with ideal rotors and with rotors that give less than they were calibrated for."""
    ideal, worn = ([found(flown(s, share)) for s in range(seeds)] for share in (1.0, WORN))

    def row(
        quantity: str, paper: str, name: str, flights: list[Found], band: Band | None = None
    ) -> Row:
        each = [getattr(x, name) for x in flights]
        return Row(quantity, paper, float(np.mean(each)), band, float(np.std(each)))

    def near(x: float) -> Band:
        return Band(0.99 * x, 1.01 * x)

    less = f"thrust {100 * WORN:.1f} %"
    rows = (
        row("mass, ideal thrust [kg]", "1.308 on the scales", "final", ideal, near(NOMINAL)),
        row(f"mass, {less} [kg]", "1.394", "final", worn, near(PRINTED)),
        row("95 % of the way, ideal thrust, after lift-off [s]", "—", "settled", ideal, Band(0.0, 20.0)),
        row(f"95 % of the way, {less}, after lift-off [s]", "—", "settled", worn, Band(0.0, 20.0)),
        row("largest deviation in random motion, ideal thrust", "“constant”", "wander", ideal, Band(0.0, 0.02)),
        row(f"largest deviation in random motion, {less}", "“constant”", "wander", worn, Band(0.0, 0.02)),
        row("lift-off, ideal thrust, after the order to rise [s]", "—", "lift_off", ideal),
    )  # fmt: skip
    crash = flown_as_printed()
    speed = max(np.linalg.norm(x.log.v, axis=1).max() for x in worn)
    remarks = (
        "On the ground the law finds commanded thrust over g, whatever the mass is: the position error raises the "
        "command, and with it the estimate, until the aircraft lifts off. We do not gate it, as Spica does not.",
        f"a = 0.06π rad/s and k = 1 as printed, at {RATE:g} Hz; position and tilt loop are our stand-in's, velocity "
        f"and attitude come from motion capture and gyro.",
        f"Random motion: to a new place every {LEG:g} s, up to {speed:.1f} m/s.",
        f"Spica does not say why he found 1.394 kg. Rotors with {100 * WORN:.1f} % of the thrust would do it.",
        f"(6) as printed, with g = +9.81 m/s²: the estimate turns negative at once, and the aircraft {crash.reason}.",
    )  # fmt: skip
    return Outcome(rows, _panels(ideal[0], worn[0], crash), remarks)


def _panels(ideal: Found, worn: Found, crash: Log) -> tuple[Panel, ...]:
    log, every = worn.log, slice(None, None, 6)
    t, ends = log.t[every], np.array((0.0, log.t[-1]))
    marks = ((RISE + worn.lift_off, "lift-off"), (CALM, "random motion"))
    printed = masses(crash, MassMemory(0.0, NOMINAL * GRAVITY, -GRAVITY, 1.0 / NOMINAL), -GRAVITY)
    return (
        Panel("Spica Fig. 3a: estimated mass", "time [s]", "mass [kg]", (
            Line("on the scales", ends, np.full(2, NOMINAL), "truth"),
            Line("1.394 kg, as printed", ends, np.full(2, PRINTED), "paper"),
            Line("ideal thrust", ideal.log.t[every], ideal.mass[every]),
            Line(f"thrust {100 * WORN:.1f} %", t, worn.mass[every]),
        ), marks),
        Panel("Spica Fig. 3b: position", "time [s]", "position [m]",
              tuple(Line(x, t, log.r[every, i]) for i, x in enumerate("xyz")), marks),
        Panel("Spica Fig. 3c: velocity", "time [s]", "velocity [m/s]",
              tuple(Line(x, t, log.v[every, i]) for i, x in enumerate("xyz")), marks),
        Panel("(6) as printed, from a hover with the right mass", "time [s]", "height [m], 1/mass [1/kg]", (
            Line("height", crash.t, crash.r[:, 2]),
            Line("estimate of 1/m", crash.t, 1.0 / printed),
            Line("1/m", crash.t, np.full(len(crash.t), 1.0 / NOMINAL), "truth"),
        )),
    )  # fmt: skip


EXPERIMENTS = (
    Experiment("003-1", "Mass found in flight", "Spica Sec. 5.4, 7, Fig. 3", adaptive_mass),
)
