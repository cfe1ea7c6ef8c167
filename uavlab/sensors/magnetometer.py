"""The magnetometer: the earth's field in the body, plus iron that turns with it, plus iron that stands around."""

from __future__ import annotations

from math import cos, inf, sin, sqrt
from typing import NamedTuple, final

import numpy as np

from uavlab.errors import BadInput
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
from uavlab.types import Field, Vec3


def earth_field(inclination: float = 1.15, azimuth: float = 0.0) -> Vec3:
    """Direction (3,) of the earth's field, a unit vector in the world.

    Parameters
    ----------
    inclination : float
        [rad], how far it dips below the horizon; 1.15 (66°) in the middle of Europe.
    azimuth : float
        [rad], direction of magnetic north, counter-clockwise from the world's x axis.
    """
    level = cos(inclination)
    return np.array((level * cos(azimuth), level * sin(azimuth), -sin(inclination)))


class Disturbance(NamedTuple):
    """Iron or current nearby: a field that is there for a time, or around a place, or both."""

    m: Vec3  # (3,) in units of the earth's field, world
    start: float = -inf  # [s]
    end: float = inf  # [s]
    place: Vec3 | None = None  # (3,) [m], world; None: everywhere
    reach: float = 1.0  # [m], where it has half its strength; far away it falls like a dipole's

    def at(self, t: float, r: Vec3) -> Vec3 | float:
        """What it adds at `t` [s] and `r` (3,) [m]: (3,), world; 0 before and after."""
        if not self.start <= t < self.end:
            return 0.0
        if self.place is None:
            return np.asarray(self.m)
        far = float(np.linalg.norm(r - self.place)) / self.reach
        return np.asarray(self.m) / (1.0 + far**3)


def _check_disturbance(one: Disturbance) -> None:
    place = np.zeros(3) if one.place is None else one.place
    check_vectors("magnetometer: disturbance", 3, m=one.m, place=place)
    if not (one.start <= one.end and one.reach > 0.0):
        raise BadInput(
            f"magnetometer: disturbance from {one.start} to {one.end} s with reach {one.reach} m; "
            "it must not end before it starts, and reach further than 0 m."
        )


class MagnetometerMemory(NamedTuple):
    """Biases, and readings under way."""

    hard_iron: Vec3  # (3,) drawn when switched on, body
    drift: Vec3  # (3,) wandering, body
    line: Line


@final
class Magnetometer(NamedTuple):
    """``Rᵀ (field + disturbances) + hard_iron + drift + bias + noise``, in units of the earth's field, body.

    Rate and noise are those of the MRS Gazebo simulation (100 Hz, 4e-4 gauss/√Hz, in a field of 0.48 gauss). Field
    direction, hard iron and drift are ours.
    """

    field: Vec3 = earth_field()  # (3,) unit vector, world
    rate: float = 100.0  # [Hz]
    delay: float = 0.0  # [s]
    noise: float = 0.0083  # [1], of each component of one sample
    turn_on: float = 0.02  # [1], standard deviation of the hard-iron bias at switch-on
    drift: float = 0.005  # [1], standard deviation of the wandering bias
    drift_tau: float = 600.0  # [s], its correlation time
    bias: Vec3 = np.zeros(3)  # (3,) [1], body: hard iron that is known to be there
    disturbances: tuple[Disturbance, ...] = ()
    dropout: float = 0.0  # probability that a sample is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # by [1], body: hard iron that is new, as after a strong current
    outliers: Outliers = NO_OUTLIERS  # size [1]

    def init(self, rng: np.random.Generator) -> MagnetometerMemory:
        """Switch on: draw the biases.

        Raises
        ------
        BadInput
            A field that is not a unit vector; a rate, delay, noise or probability that no instrument can have.
        """
        check_line("magnetometer", self.rate, self.delay, self.dropout, self.outages)
        names = ["noise", "turn_on", "drift", "drift_tau"]
        check_sizes("magnetometer", **{name: getattr(self, name) for name in names})
        check_vectors("magnetometer", 3, bias=self.bias, field=self.field)
        length = float(np.linalg.norm(self.field))
        if np.shape(self.field) != (3,) or abs(length - 1.0) > 1e-6:
            raise BadInput(
                f"magnetometer: field is {self.field}; it must be a unit vector (3,): see earth_field."
            )
        for one in self.disturbances:
            _check_disturbance(one)
        check_faults("magnetometer", self.dropout, self.jumps, self.outliers)
        hard_iron, drift = rng.standard_normal((2, 3))
        return MagnetometerMemory(self.turn_on * hard_iron, self.drift * drift, Line())

    def step(
        self, memory: MagnetometerMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[MagnetometerMemory, Field | None]:
        """The sample that arrives now, if one does."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            walk = self.drift * sqrt(2.0 / self.drift_tau)
            drift = drift_step(memory.drift, self.drift_tau, walk, since, rng)
            memory = memory._replace(drift=drift)
            white, chance = rng.standard_normal(3), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                field = self.field + sum(d.at(world.t, world.r) for d in self.disturbances)
                m = world.R.T @ field + memory.hard_iron + drift + self.bias + self.noise * white
                m = m + jumped(world.t, self.jumps)[0] + outlier(chance, self.outliers)[0]
                line = send(line, Field(world.t, m))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]
