"""The barometer: a height above where it was switched on, in steps, on a pressure that wanders."""

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
from uavlab.types import Array, Height


class BarometerMemory(NamedTuple):
    """The wandering error, and heights under way."""

    drift: Array  # (1,) [m]
    line: Line


@final
class Barometer(NamedTuple):
    """``z − ground + bias + drift + noise``, rounded to the resolution.

    Rate follows the MRS Gazebo simulation (50 Hz), resolution the maker of the MS5611 that Bangura 2018 flew. Noise and
    drift are ours, of the size that weather and propeller wash have.
    """

    rate: float = 50.0  # [Hz]
    delay: float = 0.0  # [s]
    noise: float = 0.1  # [m]
    resolution: float = 0.1  # [m], 0: none
    ground: float = 0.0  # [m], height of the place where it was switched on
    bias: float = 0.0  # [m], constant
    drift: float = 0.5  # [m], standard deviation of the wandering error
    drift_tau: float = 300.0  # [s], its correlation time
    dropout: float = 0.0  # probability that a height is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # by [m]: a door opens, a gust over the static port
    outliers: Outliers = NO_OUTLIERS  # size [m]

    def init(self, rng: np.random.Generator) -> BarometerMemory:
        """Switch on: the error is drawn as it would be found.

        Raises
        ------
        BadInput
            A rate, delay, noise, resolution or probability that no instrument can have.
        """
        check_line("barometer", self.rate, self.delay, self.dropout, self.outages)
        names = ["noise", "resolution", "drift", "drift_tau"]
        check_sizes("barometer", **{name: getattr(self, name) for name in names})
        check_vectors("barometer", 1, ground=self.ground, bias=self.bias)
        check_faults("barometer", self.dropout, self.jumps, self.outliers, by=1)
        return BarometerMemory(self.drift * rng.standard_normal(1), Line())

    def step(
        self, memory: BarometerMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[BarometerMemory, Height | None]:
        """The height that arrives now, if one does."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            walk = self.drift * sqrt(2.0 / self.drift_tau)
            drift = drift_step(memory.drift, self.drift_tau, walk, since, rng)
            memory = memory._replace(drift=drift)
            white, chance = rng.standard_normal(1), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                error = self.bias + drift + self.noise * white + jumped(world.t, self.jumps)[0]
                error = error + outlier(chance, self.outliers, 1)[0]
                line = send(line, Height(world.t, self._told(float(world.r[2]), float(error[0]))))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]

    def _told(self, z: float, error: float) -> float:
        """The height [m] as it leaves the instrument."""
        z = z - self.ground + error
        return round(z / self.resolution) * self.resolution if self.resolution else z
