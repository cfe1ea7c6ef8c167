"""The rangefinder: how far the ground is along the body's negative z axis."""

from __future__ import annotations

from math import cos, pi, sqrt
from typing import NamedTuple, final

import numpy as np

from uavlab.sensors.drift import drift_step
from uavlab.sensors.faults import (
    NO_OUTLIERS,
    Jump,
    Outliers,
    check_faults,
    check_number,
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
from uavlab.types import Array, Range


class RangefinderMemory(NamedTuple):
    """The wandering error, and distances under way."""

    drift: Array  # (1,) [m]
    line: Line


@final
class Rangefinder(NamedTuple):
    """``z / cos(tilt) + bias + drift + noise`` over flat ground at z = 0.

    Rate, reach and noise are those of the Garmin lidar in the MRS Gazebo simulation (100 Hz, 0.1 to 36 m, 0.01 m), the
    tilt gate that of its estimators (30°). Drift is ours.
    """

    rate: float = 100.0  # [Hz]
    delay: float = 0.0  # [s]
    noise: float = 0.01  # [m]
    nearest: float = 0.1  # [m], nothing nearer is measured
    farthest: float = 36.0  # [m], nor anything farther
    tilt_max: float = pi / 6  # [rad], beyond it nothing is valid
    bias: float = 0.0  # [m], constant: where it is mounted
    drift: float = 0.0  # [m], standard deviation of a wandering error
    drift_tau: float = 60.0  # [s], its correlation time
    dropout: float = 0.0  # probability that a distance is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # by [m]: from then on the ground lies lower, as past an edge
    outliers: Outliers = NO_OUTLIERS  # size [m]: grass, a reflection

    def init(self, rng: np.random.Generator) -> RangefinderMemory:
        """Switch on: the error is drawn as it would be found.

        Raises
        ------
        BadInput
            A rate, delay, noise, reach or probability that no instrument can have.
        """
        check_line("rangefinder", self.rate, self.delay, self.dropout, self.outages)
        names = ["noise", "nearest", "farthest", "drift", "drift_tau"]
        check_sizes("rangefinder", **{name: getattr(self, name) for name in names})
        check_number("rangefinder", "nearest", self.nearest, 0.0, self.farthest, "m")
        check_number("rangefinder", "tilt_max", self.tilt_max, 0.0, 0.5 * pi, "rad")
        check_vectors("rangefinder", 1, bias=self.bias)
        check_faults("rangefinder", self.dropout, self.jumps, self.outliers, by=1)
        return RangefinderMemory(self.drift * rng.standard_normal(1), Line())

    def step(
        self, memory: RangefinderMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[RangefinderMemory, Range | None]:
        """The distance that arrives now, if one does."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            walk = self.drift * sqrt(2.0 / self.drift_tau)
            drift = drift_step(memory.drift, self.drift_tau, walk, since, rng)
            memory = memory._replace(drift=drift)
            white, chance = rng.standard_normal(1), rng.random()
            level = float(world.R[2, 2])
            gone = lost(world.t, chance, self.dropout, self.outages)
            if level > 0.0 and level >= cos(self.tilt_max) and not gone:
                error = self.bias + drift + self.noise * white + jumped(world.t, self.jumps)[0]
                error = error + outlier(chance, self.outliers, 1)[0]
                d = float(world.r[2]) / level + float(error[0])
                if self.nearest <= d <= self.farthest:
                    line = send(line, Range(world.t, d))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]
