"""The satellite receiver: position and velocity, late, and wrong by an error that wanders."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple, final

import numpy as np

from uavlab.sensors.drift import drift_step
from uavlab.sensors.faults import (
    NO_OUTLIERS,
    Jump,
    Outliers,
    check_faults,
    check_vectors,
    jumped,
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
from uavlab.types import Fix, Vec3


class GnssMemory(NamedTuple):
    """The wandering error, and fixes under way."""

    drift: Vec3  # (3,) [m], world
    line: Line


@final
class Gnss(NamedTuple):
    """A receiver whose antenna is at the centre of mass.

    Rate and velocity noise follow the MRS Gazebo simulation (10 Hz; 0.2 and 0.4 m/s/√Hz over 0.1 s). Position error and
    delay are ours, of the size that consumer receivers have under open sky.
    """

    rate: float = 10.0  # [Hz]
    delay: float = 0.1  # [s]
    noise: Vec3 = np.array((0.02, 0.02, 0.04))  # (3,) [m], of each position
    drift: Vec3 = np.array((0.5, 0.5, 1.0))  # (3,) [m], standard deviation of the wandering error
    drift_tau: float = 60.0  # [s], its correlation time
    velocity_noise: Vec3 = np.array((0.063, 0.063, 0.126))  # (3,) [m/s]
    bias: Vec3 = np.zeros(3)  # (3,) [m], constant: where its world lies
    std: float = 0.0  # [m], what it says of its own error; 0: nothing
    dropout: float = 0.0  # probability that a fix is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # by [m]: a new set of satellites, a reflection that stays
    outliers: Outliers = NO_OUTLIERS  # size [m], of position

    def init(self, rng: np.random.Generator) -> GnssMemory:
        """Switch on: the error is drawn as it would be found.

        Raises
        ------
        BadInput
            A rate, delay, noise or probability that no instrument can have.
        """
        check_line("gnss", self.rate, self.delay, self.dropout, self.outages)
        check_sizes(
            "gnss",
            noise=self.noise,
            drift=self.drift,
            drift_tau=self.drift_tau,
            velocity_noise=self.velocity_noise,
            std=self.std,
        )
        check_vectors("gnss", 3, bias=self.bias)
        check_faults("gnss", self.dropout, self.jumps, self.outliers)
        return GnssMemory(self.drift * rng.standard_normal(3), Line())

    def step(
        self, memory: GnssMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[GnssMemory, Fix | None]:
        """The fix that arrives now, if one does."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            walk = self.drift * sqrt(2.0 / self.drift_tau)
            memory = memory._replace(
                drift=drift_step(memory.drift, self.drift_tau, walk, since, rng)
            )
            white, chance = rng.standard_normal(6), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                r = world.r + memory.drift + self.noise * white[:3]
                r = r + self.bias + jumped(world.t, self.jumps)[0]
                r = r + outlier(chance, self.outliers)[0]
                v = world.v + self.velocity_noise * white[3:]
                line = send(line, Fix(world.t, r, v, self.std))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]
