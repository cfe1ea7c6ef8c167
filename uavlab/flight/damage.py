"""Damage: what faults do to motors, battery and load of the aircraft that flies."""

from __future__ import annotations

from typing import Any

import numpy as np

from uavlab.errors import BadInput
from uavlab.flight.fault import OF_PLANT, Fault
from uavlab.plant import CompiledPlant, ReadablePlant
from uavlab.types import Array, Command, Vec3

NOTICED = 0.2  # [s] until the speed that a motor's controller reports has told the autopilot that it stands still
STANDS = 0.1  # of its thrust: a motor that makes less is taken for dead


class Damage:
    """The damage of one flight, and the aircraft with its load."""

    def __init__(self, faults: tuple[Fault, ...], rotors: int) -> None:
        self.faults = tuple(x for x in faults if x.kind in OF_PLANT)
        self.rotors = rotors
        self.laden: dict[float, Any] = {}  # plant by load [kg]

    def of(self, kind: str) -> tuple[Fault, ...]:
        """The faults of one kind."""
        return tuple(x for x in self.faults if x.kind == kind)

    def shares(self, t: float) -> Array:
        """What each motor makes of the thrust asked of it at time `t` [s], shape (n,)."""
        out = np.ones(self.rotors)
        for x in self.of("motor"):
            if x.lasts(t):
                out[int(x.what)] *= float(x.value)
        for x in self.of("battery"):
            gone = min(max((t - x.t) / (x.until - x.t), 0.0), 1.0)
            out *= 1.0 - gone * (1.0 - float(x.value))
        return out

    def dead(self, t: float) -> tuple[int, ...]:
        """The rotors that the autopilot does without at time `t` [s]."""
        known = {
            int(x.what)
            for x in self.of("motor")
            if x.lasts(t) and x.lasts(t - NOTICED) and float(x.value) < STANDS
        }
        return tuple(sorted(known))

    def load(self, t: float) -> float:
        """What hangs below at time `t` [s], in kg."""
        return sum(float(x.value) for x in self.of("payload") if not x.t <= t + 1e-9)

    def advance(
        self, plant: Any, world: Any, command: Command, wind: Vec3, dt: float, inner: int
    ) -> Any:
        """The world `dt` [s] later, as `uavlab.plant.CompiledPlant.advance`, damaged as it is now."""
        if not self.faults:
            return plant.advance(world, command, wind, dt, inner)
        t, load = world.t, self.load(world.t)
        if load:
            plant = self.laden.setdefault(load, None) or plant.laden(load)
            self.laden[load] = plant
        return plant.advance(world, command, wind, dt, inner, self.shares(t), self.dead(t))


def breakable(scenario: Any, plant: Any) -> None:
    """Refuse damage to a world that somebody else made: of its motors and its mass we know nothing.

    Raises
    ------
    BadInput
        Names the faults, and the plant.
    """
    if isinstance(plant, CompiledPlant | ReadablePlant):
        return
    wrong = [
        f"faults[{k}] ({x.kind!r})" for k, x in enumerate(scenario.faults) if x.kind in OF_PLANT
    ]
    if wrong:
        raise BadInput(
            f"scenario {scenario.name!r}: {', '.join(wrong)} cannot happen to {type(plant).__name__}: its motors, "
            "battery and mass are its own affair. Fly without plant=, or take these faults out."
        )
