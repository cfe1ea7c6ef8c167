"""Motion capture: cameras that see where the aircraft is and how it is turned."""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from uavlab.sensors.line import (
    Line,
    Outage,
    Truth,
    check_line,
    check_sizes,
    due,
    lost,
    receive,
    send,
)
from uavlab.so3 import exp
from uavlab.types import Pose


class MocapMemory(NamedTuple):
    """Poses under way."""

    line: Line


@final
class Mocap(NamedTuple):
    """Cameras in a laboratory. Figures are ours, of the size that makers state; Bangura 2018 has 40 Hz."""

    rate: float = 100.0  # [Hz]
    delay: float = 0.01  # [s]
    noise: float = 0.001  # [m], of each coordinate
    turn_noise: float = 0.002  # [rad], about each body axis
    dropout: float = 0.0  # probability that a pose is lost
    outages: tuple[Outage, ...] = ()

    def init(self, rng: np.random.Generator) -> MocapMemory:
        """Switch on.

        Raises
        ------
        BadInput
            A rate, delay, noise or probability that no instrument can have.
        """
        check_line("mocap", self.rate, self.delay, self.dropout, self.outages)
        check_sizes("mocap", noise=self.noise, turn_noise=self.turn_noise)
        return MocapMemory(Line())

    def step(
        self, memory: MocapMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[MocapMemory, Pose | None]:
        """The pose that arrives now, if one does."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            white, chance = rng.standard_normal(6), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                R = world.R @ exp(self.turn_noise * white[3:])
                line = send(line, Pose(world.t, world.r + self.noise * white[:3], R))
        line, arrived = receive(line, world.t, self.delay)
        return MocapMemory(line), arrived  # type: ignore[return-value]
