"""Visual SLAM: a pose in a world of its own, which drifts, and jumps when a loop closes."""

from __future__ import annotations

from math import pi, sqrt
from typing import NamedTuple, final

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import NO_SHIFT, Shift, compose, moved
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
from uavlab.types import Pose


class SlamMemory(NamedTuple):
    """Where its world lies, how far it has drifted, and poses under way."""

    world: Shift  # true world → the map's, as drawn or given
    drift: Shift  # the map's world at switch-on → now
    closed: int  # how many loops have been closed
    line: Line


@final
class Slam(NamedTuple):
    """A map that is built in flight: the true pose, moved into the map's world, moved by the drift, and noisy.

    All figures are ours, of the size that published visual SLAM has indoors.
    """

    rate: float = 30.0  # [Hz]
    delay: float = 0.05  # [s]
    noise: float = 0.01  # [m], of each coordinate
    turn_noise: float = 0.003  # [rad], about each body axis
    world: Shift | None = None  # true world → the map's; None: drawn, ...
    spread: float = 3.0  # [m], ... its origin with this standard deviation, its heading from all
    walk: float = 0.02  # [m/√s], drives the drift of position
    heading_walk: float = 0.001  # [rad/√s], drives the drift of heading, about the map's origin
    closures: tuple[float, ...] = ()  # [s], times at which a loop closes: the drift is taken back
    dropout: float = 0.0  # probability that a pose is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # by [m], turn [rad], in the map's world: a wrong loop, closed
    outliers: Outliers = NO_OUTLIERS  # size [m], turn [rad]

    def init(self, rng: np.random.Generator) -> SlamMemory:
        """Switch on: the map's world is drawn, or the one given.

        Raises
        ------
        BadInput
            A rate, delay, noise, world or probability that no instrument can have.
        """
        check_line("slam", self.rate, self.delay, self.dropout, self.outages)
        names = ["noise", "turn_noise", "spread", "walk", "heading_walk"]
        check_sizes("slam", **{name: getattr(self, name) for name in names})
        check_faults("slam", self.dropout, self.jumps, self.outliers, turn=1)
        if not np.isfinite(self.closures).all() or list(self.closures) != sorted(self.closures):
            raise BadInput(f"slam: closures are {self.closures} s; finite times that grow, please.")
        r, turn = self.spread * rng.standard_normal(3), rng.uniform(-pi, pi)
        world = Shift(r, turn) if self.world is None else self.world
        check_vectors("slam: world", 3, r=world.r)
        check_vectors("slam: world", 1, heading=world.heading)
        return SlamMemory(world, NO_SHIFT, 0, Line())

    def step(
        self, memory: SlamMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[SlamMemory, Pose | None]:
        """The pose that arrives now, if one does, in the map's world."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            memory = self._drifted(memory, world.t, since, rng.standard_normal(4))
            white, chance = rng.standard_normal(6), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                by, turn = outlier(chance, self.outliers)
                shift = compose(memory.drift, memory.world)
                shift = compose(jumped_world(world.t, self.jumps), shift)
                pose = moved(Pose(world.t, world.r, world.R), shift)
                R = pose.R @ exp(self.turn_noise * white[3:] + turn)
                line = send(line, Pose(world.t, pose.r + self.noise * white[:3] + by, R))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]

    def _drifted(self, memory: SlamMemory, t: float, since: float, xi: np.ndarray) -> SlamMemory:
        """After `since` [s] of random walk; back at zero when a loop has closed."""
        closed = sum(t >= time for time in self.closures)
        if closed > memory.closed:
            return memory._replace(drift=NO_SHIFT, closed=closed)
        r = memory.drift.r + self.walk * sqrt(since) * xi[:3]
        heading = memory.drift.heading + self.heading_walk * sqrt(since) * float(xi[3])
        return memory._replace(drift=Shift(r, heading))
