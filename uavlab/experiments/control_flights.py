"""What the experiments on control share: an aircraft that knows its state, and a reference controller with a change."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.flight.fly import fly
from uavlab.flight.log import Log
from uavlab.flight.scenario import Scenario
from uavlab.frames import Shift, heading, moved
from uavlab.gains import GeometricGains
from uavlab.interfaces import Memory, Readings, Stack
from uavlab.parts.controllers import limited_tilt
from uavlab.parts.trackers import CommandFilter
from uavlab.types import GRAVITY, Command, Estimate, Hypothesis, Mat3, Reference, Vec3

KNOWS = "state"  # the instrument that these aircraft carry


class Knows(NamedTuple):
    """An instrument that tells the whole state, with white errors if it is asked to."""

    r_noise: float = 0.0  # [m] of each coordinate
    v_noise: float = 0.0  # [m/s]

    def init(self, rng: np.random.Generator) -> None:
        """It remembers nothing."""

    def step(
        self, memory: None, world: Any, dt: float, rng: np.random.Generator
    ) -> tuple[None, Estimate]:
        """The state of now."""
        r, v = world.r, world.v
        if self.r_noise or self.v_noise:
            white = rng.standard_normal(6)
            r, v = r + self.r_noise * white[:3], v + self.v_noise * white[3:]
        return None, Estimate(r, v, world.a, world.R, world.omega)


@dataclass(frozen=True)
class Believes:
    """An estimator that believes that instrument: so that an experiment on control is one on control alone."""

    slot: ClassVar[str] = "estimator"

    def init(self, estimate: Estimate) -> Estimate:
        """What is true at the start."""
        return estimate

    def step(
        self, memory: Estimate, readings: Readings, command: Command, dt: float
    ) -> tuple[Estimate, Estimate]:
        """What was told now."""
        told: Any = readings.get(KNOWS, memory)
        return told, told

    def reframe(self, memory: Estimate, shift: Shift) -> Estimate:
        """The same, told in another world."""
        return moved(memory, shift)

    def hypotheses(self, memory: Estimate) -> Mapping[str, Hypothesis]:
        """It has one belief only."""
        return {}


@dataclass(frozen=True)
class Passes:
    """A tracker that adds nothing: the goal is the reference."""

    slot: ClassVar[str] = "tracker"

    def init(self, estimate: Estimate, last: Reference | None) -> Reference:
        """The last reference, else stand where the estimate is."""
        zero = np.zeros(3)
        return last or Reference(estimate.r, zero, zero, zero, heading(estimate.R), 0.0)

    def step(
        self, memory: Reference, estimate: Estimate, goal: Reference | None, dt: float
    ) -> tuple[Reference, Reference]:
        """The goal, or the last one."""
        return goal or memory, goal or memory

    def reframe(self, memory: Reference, shift: Shift) -> Reference:
        """The same, told in another world."""
        return moved(memory, shift)


class Tick(NamedTuple):
    """One step of a controller: what went in and what came out."""

    estimate: Estimate
    reference: Reference
    before: Memory
    after: Memory
    command: Command


Change = Callable[[Any, Tick], tuple[Memory, Command]]  # controller, tick → memory and command


@dataclass(frozen=True)
class Altered:
    """A controller whose result is changed at every tick: an equation as printed instead of the corrected one."""

    slot: ClassVar[str] = "controller"
    law: Any
    change: Change

    def init(self, estimate: Estimate, last: Command | None) -> Memory:
        """As the law."""
        return self.law.init(estimate, last)

    def step(
        self, memory: Memory, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Memory, Command]:
        """As the law, then the change."""
        after, command = self.law.step(memory, estimate, reference, dt)
        return self.change(self.law, Tick(estimate, reference, memory, after, command))

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """As the law."""
        return self.law.reframe(memory, shift)


def law(mass: float, gains: GeometricGains) -> Any:
    """The reference answer of lab 07."""
    return answer("geometric", "GeometricController")(mass, gains)


def flown(
    scenario: Scenario, controller: Any, *, tracker: Any = None, seed: int = 0, plant: Any = None
) -> Log:
    """One flight of an aircraft that knows its state; the scenario's own instruments stay, if it has that one."""
    if KNOWS not in scenario.sensors:
        scenario = scenario._replace(sensors={KNOWS: Knows()})
    mind = Stack(Believes(), tracker or CommandFilter(), controller)
    return fly(scenario, mind, seed=seed, plant=plant)


# Changes ----------------------------------------------------------------------------------------------


def without_parasitic(_law: Any, tick: Tick) -> tuple[Memory, Command]:
    """Leave out what MRS Sec. 5.3 compensates: what roll and pitch rates make of the heading."""
    omega = tick.command.omega_d
    taken = answer("heading", "parasitic_yaw_rate")(tick.estimate.R, omega)
    return tick.after, tick.command._replace(omega_d=omega - np.array((0.0, 0.0, taken)))


def wanted(the_law: Any, tick: Tick) -> tuple[Vec3, Mat3]:
    """Force [N], (3,), and attitude (3, 3) that the law wants at this tick."""
    x = tick.before
    force = answer("geometric", "desired_force")(
        tick.estimate, tick.reference, x.m_e, x.d_w, x.d_b, the_law.gains
    )
    force = limited_tilt(force, the_law.gains.tilt_max)
    return force, answer("heading", "attitude_with_heading")(force, tick.reference.heading)


def jerk_rates(the_law: Any, tick: Tick) -> tuple[Vec3, Vec3]:
    """Body rates that the jerk asks for [rad/s], each (3,): (26) corrected, and as printed."""
    force, R_d = wanted(the_law, tick)
    m_e = tick.before.m_e
    right = answer("geometric", "jerk_feedforward")(force, m_e, R_d, tick.reference.j)
    share = float(np.linalg.norm(force)) / m_e
    return right, -(share**2) * right  # printed: ‖f‖/m_e for m_e/‖f‖, and the matrix transposed


def printed_jerk(the_law: Any, tick: Tick) -> tuple[Memory, Command]:
    """MRS (26) as printed; the heading stays compensated."""
    right, printed = jerk_rates(the_law, tick)
    parasitic, R = answer("heading", "parasitic_yaw_rate"), tick.estimate.R
    was = tick.command.omega_d
    omega = was - right + printed
    omega[2] += parasitic(R, omega) - parasitic(R, was)
    most = np.array(the_law.gains.rate_max)
    return tick.after, tick.command._replace(omega_d=np.clip(omega, -most, most))


def printed_mass(the_law: Any, tick: Tick) -> tuple[Memory, Command]:
    """MRS (37) as printed: the mass moves the other way, within the same bounds."""
    m, most = the_law.mass, the_law.gains.m_max
    m_e = 2.0 * tick.before.m_e - tick.after.m_e
    return tick.after._replace(
        m_e=float(np.clip(m_e, max(m - most, 0.1 * m), m + most))
    ), tick.command


def printed_acceleration(_law: Any, tick: Tick) -> tuple[Memory, Command]:
    """MRS (53) as printed: gravity is divided by the mass."""
    more = np.array((0.0, 0.0, GRAVITY * (1.0 - 1.0 / tick.before.m_e)))
    return tick.after, tick.command._replace(a_d=tick.command.a_d + more)


def memories(log: Log, controller: Any) -> list[Memory]:
    """What the controller remembered before each tick: told again from what it got in this flight, N of them."""
    dt = log.meta["dt"]
    kept: list[Memory] = []
    memory = controller.init(_estimate(log, 0), None)
    for k in range(len(log.t)):
        kept.append(memory)
        memory, _ = controller.step(memory, _estimate(log, k), _reference(log, k), dt)
    return kept


def _estimate(log: Log, k: int) -> Estimate:
    return Estimate(log.r_e[k], log.v_e[k], np.zeros(3), log.R_e[k], log.omega[k])


def _reference(log: Log, k: int) -> Reference:
    return Reference(
        log.r_d[k], log.v_d[k], log.a_d[k], np.zeros(3),
        float(log.heading_d[k]), float(log.heading_rate_d[k]),
    )  # fmt: skip
