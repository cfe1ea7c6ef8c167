"""The attitude of the embedded autopilot: its tilt is good, its heading starts anywhere and wanders."""

from __future__ import annotations

from math import pi, sqrt
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
from uavlab.so3 import about_z, exp
from uavlab.types import Array, Attitude


class AhrsMemory(NamedTuple):
    """The errors, and attitudes under way."""

    tilt: Array  # (2,) [rad], about the world's x and y axes
    heading: float  # [rad], of the true world in the autopilot's own
    line: Line


@final
class Ahrs(NamedTuple):
    """``Rz(heading + wander) exp(tilt error) R exp(noise)``: the autopilot's world differs by its heading alone.

    All figures are ours, of the size that autopilots have; MRS eq. 14 takes tilt from here and heading from a filter.
    """

    rate: float = 100.0  # [Hz]
    delay: float = 0.0  # [s]
    noise: float = 0.0005  # [rad], about each body axis
    tilt: float = 0.005  # [rad], standard deviation of the tilt error about each level axis (0.3°)
    tilt_tau: float = 20.0  # [s], its correlation time
    tilt_bias: Array = np.zeros(2)  # (2,) [rad], constant: how it was mounted or trimmed
    heading: float | None = None  # [rad] at switch-on, of the true world in its own; None: drawn
    heading_walk: float = 0.002  # [rad/√s], drives the wandering of heading
    dropout: float = 0.0  # probability that an attitude is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # turn [rad], of heading: the autopilot has reset it
    outliers: Outliers = NO_OUTLIERS  # turn [rad]

    def init(self, rng: np.random.Generator) -> AhrsMemory:
        """Switch on: tilt error and heading are drawn as they would be found.

        Raises
        ------
        BadInput
            A rate, delay, noise or probability that no instrument can have.
        """
        check_line("ahrs", self.rate, self.delay, self.dropout, self.outages)
        names = ["noise", "tilt", "tilt_tau", "heading_walk"]
        check_sizes("ahrs", **{name: getattr(self, name) for name in names})
        check_vectors("ahrs", 2, tilt_bias=self.tilt_bias)
        check_faults("ahrs", self.dropout, self.jumps, self.outliers, by=0, turn=1)
        tilt, heading = self.tilt * rng.standard_normal(2), rng.uniform(-pi, pi)
        if self.heading is not None:
            check_vectors("ahrs", 1, heading=self.heading)
            heading = self.heading
        return AhrsMemory(tilt, heading, Line())

    def step(
        self, memory: AhrsMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[AhrsMemory, Attitude | None]:
        """The attitude that arrives now, if one does."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            walk = self.tilt * sqrt(2.0 / self.tilt_tau)
            tilt = drift_step(memory.tilt, self.tilt_tau, walk, since, rng)
            white, chance = rng.standard_normal(4), rng.random()
            heading = memory.heading + self.heading_walk * sqrt(since) * float(white[3])
            memory = memory._replace(tilt=tilt, heading=heading)
            if not lost(world.t, chance, self.dropout, self.outages):
                turn = about_z(heading + float(jumped(world.t, self.jumps)[1]))
                off = exp(np.append(tilt + self.tilt_bias, 0.0))
                wrong = self.noise * white[:3] + outlier(chance, self.outliers)[1]
                line = send(line, Attitude(world.t, turn @ off @ world.R @ exp(wrong)))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]
