"""Motion capture: cameras that see where the aircraft is and how it is turned."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple, final

import numpy as np

from uavlab.frames import moved
from uavlab.sensors.drift import drift_step
from uavlab.sensors.faults import (
    NO_OUTLIERS,
    Jump,
    Outliers,
    check_faults,
    check_vectors,
    jumped_world,
    outlier,
)
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
from uavlab.types import Pose, Vec3


class MocapMemory(NamedTuple):
    """The wandering error, and poses under way."""

    line: Line
    drift: Vec3 = np.zeros(3)  # (3,) [m]


@final
class Mocap(NamedTuple):
    """Cameras in a laboratory. Figures are ours, of the size that makers state; Bangura 2018 has 40 Hz."""

    rate: float = 100.0  # [Hz]
    delay: float = 0.01  # [s]
    noise: float = 0.001  # [m], of each coordinate
    turn_noise: float = 0.002  # [rad], about each body axis
    bias: Vec3 = np.zeros(3)  # (3,) [m], constant: cameras that were moved after calibration
    drift: float = 0.0  # [m], standard deviation of a wandering error: cameras that warm up
    drift_tau: float = 600.0  # [s], its correlation time
    dropout: float = 0.0  # probability that a pose is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # by [m], turn [rad]: somebody kicks a tripod
    outliers: Outliers = NO_OUTLIERS  # size [m], turn [rad]: markers mixed up

    def init(self, rng: np.random.Generator) -> MocapMemory:
        """Switch on.

        Raises
        ------
        BadInput
            A rate, delay, noise or probability that no instrument can have.
        """
        check_line("mocap", self.rate, self.delay, self.dropout, self.outages)
        check_sizes("mocap", noise=self.noise, turn_noise=self.turn_noise)
        check_sizes("mocap", drift=self.drift, drift_tau=self.drift_tau)
        check_vectors("mocap", 3, bias=self.bias)
        check_faults("mocap", self.dropout, self.jumps, self.outliers, turn=1)
        start = self.drift * rng.standard_normal(3) if self.drift else np.zeros(3)
        return MocapMemory(Line(), start)

    def step(
        self, memory: MocapMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[MocapMemory, Pose | None]:
        """The pose that arrives now, if one does."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            if self.drift:
                walk = self.drift * sqrt(2.0 / self.drift_tau)
                drift = drift_step(memory.drift, self.drift_tau, walk, since, rng)
                memory = memory._replace(drift=drift)
            white, chance = rng.standard_normal(6), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                by, turn = outlier(chance, self.outliers)
                R = world.R @ exp(self.turn_noise * white[3:] + turn)
                r = world.r + self.noise * white[:3] + (self.bias + memory.drift + by)
                pose = Pose(world.t, r, R)
                if self.jumps:
                    pose = moved(pose, jumped_world(world.t, self.jumps))
                line = send(line, pose)
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]
