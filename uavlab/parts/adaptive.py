"""A controller that weighs its aircraft while it flies, with the mass estimate of the identification lab."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import ClassVar, NamedTuple

from uavlab.frames import Shift
from uavlab.interfaces import asks
from uavlab.parts.controllers import Gains, Handover, TiltAxis
from uavlab.types import GRAVITY, Command, Estimate, MassMemory, Reference


class Weighing(NamedTuple):
    """Memory of `AdaptiveController`."""

    handover: Handover  # of the law that it flies
    mass: MassMemory
    f_d: float  # [N] thrust that was asked for last


@dataclass(frozen=True)
class AdaptiveController:
    """The stand-in's law, with the mass that thrust and vertical velocity tell (Spica 5.4), whatever it was told."""

    slot: ClassVar[str] = "controller"
    mass_step: Callable[..., MassMemory] = asks("identification")
    mass: float = 0.0  # [kg] what it is told, to begin with
    gains: Gains = Gains()
    a: float = 0.06 * pi  # [rad/s] of the filters (Spica)
    k: float = 1.0  # gain of the adaptation (Spica)

    @staticmethod
    def stand_in(mass: float, gains: Gains = Gains(), **_parameters: float) -> TiltAxis:
        """What flies while the function is missing: the law alone, with the mass it was told."""
        return TiltAxis(mass, gains)

    def init(self, estimate: Estimate, last: Command | None) -> Weighing:
        """Take over from `last`."""
        weight = self.mass * GRAVITY
        lift = weight if last is None else last.f_d * float(estimate.R[2, 2])
        memory = MassMemory(float(estimate.v[2]), lift, GRAVITY, 1.0 / self.mass)
        f_d = weight if last is None else last.f_d
        return Weighing(Handover(last, None), memory, f_d)

    def step(
        self, memory: Weighing, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Weighing, Command]:
        """One tick: learn from the thrust of the last one, then fly."""
        seen = self.mass_step(
            memory.mass,
            float(estimate.v[2]),
            estimate.R,
            memory.f_d,
            dt,
            a=self.a,
            k=self.k,
            g=GRAVITY,
        )
        law = TiltAxis(believed(seen, self.mass), self.gains)
        handover, command = law.step(memory.handover, estimate, reference, dt)
        return Weighing(handover, seen, command.f_d), command

    def reframe(self, memory: Weighing, shift: Shift) -> Weighing:
        """The hand-over, told in the new world; a mass weighs the same in each."""
        law = TiltAxis(self.mass, self.gains)
        return memory._replace(handover=law.reframe(memory.handover, shift))


def believed(memory: MassMemory, told: float) -> float:
    """The estimated mass [kg], kept between a third and three times of the one that was told [kg]."""
    inverse = min(max(memory.inverse, 1.0 / (3.0 * told)), 3.0 / told)
    return 1.0 / inverse
