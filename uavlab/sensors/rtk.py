"""The differential receiver: centimetres while a base station's corrections arrive, metres or nothing without."""

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
from uavlab.types import Fix, Vec3


class RtkMemory(NamedTuple):
    """The error that a float solution would have, and fixes under way."""

    drift: Vec3  # (3,) [m], world
    line: Line


@final
class Rtk(NamedTuple):
    """A real-time kinematic receiver: ``r + offset + noise``, and ``+ drift`` while corrections are lost.

    The paper says that a plain and a differential receiver may differ by several metres, and that corrections may be
    missing (MRS Sec. 3.5); it prints no figures. All figures here are ours, of the size that makers state.
    """

    rate: float = 10.0  # [Hz]
    delay: float = 0.1  # [s]
    noise: Vec3 = np.array((0.01, 0.01, 0.02))  # (3,) [m], of each fixed position
    offset: Vec3 = np.array((1.5, -1.0, 0.8))  # (3,) [m], of its base station from the true world
    velocity_noise: Vec3 = np.array((0.03, 0.03, 0.05))  # (3,) [m/s]
    corrections_lost: tuple[Outage, ...] = ()  # no corrections: a float solution, or nothing
    silent: bool = False  # True: it sends nothing while corrections are lost
    refix: float = 5.0  # [s] from corrections coming back to a fixed solution
    float_noise: Vec3 = np.array((0.05, 0.05, 0.1))  # (3,) [m], of each float position
    drift: Vec3 = np.array((0.8, 0.8, 1.5))  # (3,) [m], standard deviation of a float's error
    drift_tau: float = 30.0  # [s], its correlation time
    std_fixed: float = 0.02  # [m], what it says of its own error when fixed ...
    std_float: float = 1.0  # [m], ... and when not
    dropout: float = 0.0  # probability that a fix is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # by [m]: a wrong integer, held
    outliers: Outliers = NO_OUTLIERS  # size [m]

    def init(self, rng: np.random.Generator) -> RtkMemory:
        """Switch on: the error of the float solution is drawn as it would be found.

        Raises
        ------
        BadInput
            A rate, delay, noise, interval or probability that no instrument can have.
        """
        check_line("rtk", self.rate, self.delay, self.dropout, self.outages)
        names = [
            "noise",
            "velocity_noise",
            "float_noise",
            "drift",
            "drift_tau",
            "refix",
            "std_fixed",
            "std_float",
        ]
        check_sizes("rtk", **{name: getattr(self, name) for name in names})
        check_vectors("rtk", 3, offset=self.offset)
        check_times("rtk", corrections_lost=self.corrections_lost)
        check_faults("rtk", self.dropout, self.jumps, self.outliers)
        return RtkMemory(self.drift * rng.standard_normal(3), Line())

    def step(
        self, memory: RtkMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[RtkMemory, Fix | None]:
        """The fix that arrives now, if one does; its std tells fixed from float."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            walk = self.drift * sqrt(2.0 / self.drift_tau)
            drift = drift_step(memory.drift, self.drift_tau, walk, since, rng)
            memory = memory._replace(drift=drift)
            white, chance = rng.standard_normal(6), rng.random()
            fixed = not within(world.t, self.corrections_lost, self.refix)
            gone = lost(world.t, chance, self.dropout, self.outages)
            if not gone and (fixed or not self.silent):
                error = self.noise * white[:3] if fixed else drift + self.float_noise * white[:3]
                r = world.r + self.offset + error + jumped(world.t, self.jumps)[0]
                r = r + outlier(chance, self.outliers)[0]
                v = world.v + self.velocity_noise * white[3:]
                std = self.std_fixed if fixed else self.std_float
                line = send(line, Fix(world.t, r, v, std))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]
