"""Optic flow: the velocity along the body's x and y axes, from a camera that looks at the ground."""

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
    check_times,
    check_vectors,
    jumped,
    outlier,
    within,
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
from uavlab.types import Array, Flow


class FlowMemory(NamedTuple):
    """The wandering error, and velocities under way."""

    drift: Array  # (2,) [m/s], body
    line: Line


@final
class FlowCamera(NamedTuple):
    """``(Rᵀ v)_xy + bias + drift + noise``, the noise's standard deviation being ``noise + noise_per_height z``.

    What a camera sees is an angular rate; the velocity is that times the height, hence the noise that grows. All
    figures are ours, of the size that small flow cameras have. The ground is z = 0.
    """

    rate: float = 50.0  # [Hz]
    delay: float = 0.02  # [s]
    noise: float = 0.03  # [m/s], near the ground
    noise_per_height: float = 0.02  # [1/s], that is [m/s] for each metre of height
    bias: Array = np.zeros(2)  # (2,) [m/s], constant
    drift: float = 0.02  # [m/s], standard deviation of a wandering error
    drift_tau: float = 20.0  # [s], its correlation time
    lowest: float = 0.2  # [m], below it the picture is not sharp
    highest: float = 8.0  # [m], above it there is nothing to hold on to
    tilt_max: float = pi / 6  # [rad], beyond it nothing is valid
    dark: tuple[Outage, ...] = ()  # times with too little light
    dropout: float = 0.0  # probability that a velocity is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # by [m/s]: from then on the ground moves, as water does
    outliers: Outliers = NO_OUTLIERS  # size [m/s]

    def init(self, rng: np.random.Generator) -> FlowMemory:
        """Switch on: the error is drawn as it would be found.

        Raises
        ------
        BadInput
            A rate, delay, noise, gate or probability that no instrument can have.
        """
        check_line("flow", self.rate, self.delay, self.dropout, self.outages)
        names = ["noise", "noise_per_height", "drift", "drift_tau"]
        check_sizes("flow", **{name: getattr(self, name) for name in names})
        check_vectors("flow", 2, bias=self.bias)
        check_number("flow", "lowest", self.lowest, 0.0, self.highest, "m")
        check_number("flow", "tilt_max", self.tilt_max, 0.0, pi / 2, "rad")
        check_times("flow", dark=self.dark)
        check_faults("flow", self.dropout, self.jumps, self.outliers, by=2)
        return FlowMemory(self.drift * rng.standard_normal(2), Line())

    def step(
        self, memory: FlowMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[FlowMemory, Flow | None]:
        """The velocity that arrives now, if one does."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            walk = self.drift * sqrt(2.0 / self.drift_tau)
            drift = drift_step(memory.drift, self.drift_tau, walk, since, rng)
            memory = memory._replace(drift=drift)
            white, chance = rng.standard_normal(2), rng.random()
            gone = lost(world.t, chance, self.dropout, self.outages)
            if self._sees(world) and not gone:
                spread = self.noise + self.noise_per_height * float(world.r[2])
                v_B = (world.R.T @ world.v)[:2] + self.bias + drift + spread * white
                v_B = v_B + jumped(world.t, self.jumps)[0] + outlier(chance, self.outliers, 2)[0]
                line = send(line, Flow(world.t, v_B))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]

    def _sees(self, world: Truth) -> bool:
        """Whether the ground can be seen: near enough, level enough, lit."""
        near = self.lowest <= float(world.r[2]) <= self.highest
        level = world.R[2, 2] >= cos(self.tilt_max)
        return bool(near and level and not within(world.t, self.dark))
