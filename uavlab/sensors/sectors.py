"""The sector scanner: how far the nearest thing is all around, above and below."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, hypot, inf, pi, sin, sqrt
from typing import NamedTuple, final

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import heading, wrap
from uavlab.plant.obstacles import Obstacle
from uavlab.sensors.faults import (
    NO_OUTLIERS,
    Jump,
    Outliers,
    check_faults,
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
from uavlab.types import Array, Sectors, Vec3


@final
class Scanner(NamedTuple):
    """A lidar that turns, kept level, with a beam up and one down. It sees upright cylinders on flat ground at z = 0.

    Each of n sectors tells the nearest surface in it, n = 8 and 20 Hz as mrs_uav_managers has them; reach and noise are
    ours. What is farther than the reach is inf. Cylinders end somewhere: above them there is nothing, and one that
    stands below is what the beam down finds. Up there is nothing but the sky.
    """

    rate: float = 20.0  # [Hz]
    delay: float = 0.0  # [s]
    n: int = 8  # sectors; the middle of the first is ahead, that of the next to the left
    noise: float = 0.03  # [m]
    reach: float = 20.0  # [m]
    dropout: float = 0.0  # probability that a turn is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[
        Jump, ...
    ] = ()  # by [m], of all beams or of the n and the one down: dirt on the window
    outliers: Outliers = NO_OUTLIERS  # size [m]: rain, a bird; also where there is nothing
    obstacles: tuple[Obstacle, ...] = ()  # those of the scenario, when it flies

    def init(self, rng: np.random.Generator) -> Line:
        """Switch on.

        Raises
        ------
        BadInput
            A rate, delay, noise, reach or probability that no instrument can have, or fewer than two sectors.
        """
        check_line("sectors", self.rate, self.delay, self.dropout, self.outages)
        check_sizes("sectors", noise=self.noise, reach=self.reach)
        if not (self.n >= 2 and self.n % 1 == 0):  # a file may say 8.0
            raise BadInput(f"sectors: n is {self.n}; it must be a whole number of 2 or more.")
        check_faults("sectors", self.dropout, self.jumps, self.outliers, by=int(self.n) + 1)
        return Line()

    def step(
        self, memory: Line, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[Line, Sectors | None]:
        """The turn that arrives now, if one does."""
        line, since = due(memory, world.t, self.rate)
        if since >= 0.0:
            n = int(self.n)
            white, chance = rng.standard_normal(n + 1), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                true = np.append(
                    around(world.r, heading(world.R), self.obstacles, n),
                    world.r[2] - floor(world.r, self.obstacles),
                )
                d = (
                    np.minimum(true + self.noise * white, self.reach)
                    + jumped(world.t, self.jumps)[0]
                )
                d = np.maximum(d + outlier(chance, self.outliers, n + 1)[0], 0.0)
                d = np.where(d < self.reach, d, inf)
                line = send(line, Sectors(world.t, d[:-1], float(d[-1]), inf))
        line, arrived = receive(line, world.t, self.delay)
        return line, arrived  # type: ignore[return-value]


def around(r: Vec3, eta: float, obstacles: Sequence[Obstacle], n: int) -> Array:
    """The nearest surface in each of n sectors.

    Parameters
    ----------
    r : Vec3
        Where it is (3,) [m], world.
    eta : float
        Heading [rad].
    obstacles : sequence of Obstacle
        What stands there.
    n : int
        Number of sectors; sector i spans π/n to both sides of eta + 2π i/n.

    Returns
    -------
    Array
        Distances (n,) [m]; inf where there is nothing, 0 inside of an obstacle.
    """
    d = np.full(n, inf)
    for x, y, radius, height in obstacles:
        if r[2] > height:
            continue
        dx, dy = x - r[0], y - r[1]
        far, towards = hypot(dx, dy), atan2(dy, dx) - eta
        for i in range(n):
            off = max(abs(wrap(towards - 2.0 * pi * i / n)) - pi / n, 0.0)
            d[i] = min(d[i], _along(far, off, radius))
    return d


def _along(far: float, off: float, radius: float) -> float:
    """How far a circle is along a ray [m], if its middle is `far` [m] away and `off` [rad] from the ray.

    In a sector the nearest ray is the one to the middle, or the edge if the middle lies outside.
    """
    if far <= radius:
        return 0.0
    across = far * sin(off)
    if off >= 0.5 * pi or across > radius:
        return inf
    return far * cos(off) - sqrt(radius * radius - across * across)


def floor(r: Vec3, obstacles: Sequence[Obstacle]) -> float:
    """Height [m] of what is straight below `r` (3,) [m], world: the ground, or the top of an obstacle."""
    tops = [
        height
        for x, y, radius, height in obstacles
        if height < r[2] and hypot(x - r[0], y - r[1]) <= radius
    ]
    return max(tops, default=0.0)
