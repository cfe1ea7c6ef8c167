"""A camera that knows beacons: the direction to each of them, in the body."""

from __future__ import annotations

from math import cos, pi, sqrt
from typing import NamedTuple, final

import numpy as np

from uavlab.errors import BadInput
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
from uavlab.so3 import exp
from uavlab.types import Array, Bearings, Vec3

SQUARE = np.array([(1.0, 1.0, 0.1), (-1.0, 1.0, 0.1), (-1.0, -1.0, 0.1), (1.0, -1.0, 0.1)])
SQUARE.setflags(write=False)


class BeaconMemory(NamedTuple):
    """How the camera is turned on its mount, and images under way."""

    drift: Vec3  # (3,) [rad], about the body axes
    line: Line


@final
class BeaconCamera(NamedTuple):
    """``exp(mounting) Rᵀ (p − r)`` as unit vectors, each then bent by a random angle about both its tangent axes.

    Beacons, rate and noise are those of Spica 2013 Sec. 7 (four at 0.1 m height in a square of 2 m, 30 Hz, 1.5°); the
    field of view is ours, a fisheye that looks down.
    """

    beacons: Array = SQUARE  # (n, 3) [m], world
    rate: float = 30.0  # [Hz]
    delay: float = 0.0  # [s]
    noise: float = 1.5 * pi / 180  # [rad], about each tangent axis of each bearing
    axis: Vec3 = np.array((0.0, 0.0, -1.0))  # (3,) unit vector along which it looks, body
    view: float = 80.0 * pi / 180  # [rad], half angle of the field of view
    bias: Vec3 = np.zeros(3)  # (3,) [rad], how the camera is turned on its mount
    drift: float = 0.0  # [rad], standard deviation of a wandering turn
    drift_tau: float = 60.0  # [s], its correlation time
    dropout: float = 0.0  # probability that an image is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # turn (3,) [rad]: the mount slips
    outliers: Outliers = NO_OUTLIERS  # turn [rad], of one beacon in such an image

    def init(self, rng: np.random.Generator) -> BeaconMemory:
        """Switch on: the turn is drawn as it would be found.

        Raises
        ------
        BadInput
            Beacons that are no places; an axis, rate, delay, noise or probability that no instrument can have.
        """
        check_line("bearings", self.rate, self.delay, self.dropout, self.outages)
        names = ["noise", "drift", "drift_tau"]
        check_sizes("bearings", **{name: getattr(self, name) for name in names})
        check_vectors("bearings", 3, bias=self.bias, axis=self.axis)
        check_number("bearings", "view", self.view, 0.0, pi, "rad")
        check_faults("bearings", self.dropout, self.jumps, self.outliers, by=0, turn=3)
        p = np.asarray(self.beacons)
        if p.ndim != 2 or p.shape[1:] != (3,) or not len(p) or not np.isfinite(p).all():
            raise BadInput(f"bearings: beacons have shape {p.shape}; (n, 3) finite places, n ≥ 1.")
        if abs(float(np.linalg.norm(self.axis)) - 1.0) > 1e-6:
            raise BadInput(f"bearings: axis is {self.axis}; it must be a unit vector (3,).")
        return BeaconMemory(self.drift * rng.standard_normal(3), Line())

    def step(
        self, memory: BeaconMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[BeaconMemory, Bearings | None]:
        """The bearings that arrive now, if an image does; NaN where a beacon is outside it."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            walk = self.drift * sqrt(2.0 / self.drift_tau)
            drift = drift_step(memory.drift, self.drift_tau, walk, since, rng)
            memory = memory._replace(drift=drift)
            white, chance = rng.standard_normal((len(self.beacons), 3)), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                turn = self.bias + drift + jumped(world.t, self.jumps)[1]
                b = self._seen(world, turn, white, chance)
                line = send(line, Bearings(world.t, b))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]

    def _seen(self, world: Truth, turn: Vec3, white: Array, chance: float) -> Array:
        """Unit vectors (n, 3), body; `white` (n, 3) is normal."""
        away = (self.beacons - world.r) @ world.R
        true = away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-9)
        b = true @ exp(turn).T
        bend = self.noise * white
        wrong = np.asarray(outlier(chance, self.outliers)[1])
        if wrong.any():
            bend[int(chance * 1e9) % len(b)] += _across(wrong, b[int(chance * 1e9) % len(b)])
        b = np.array([exp(w - (w @ u) * u) @ u for w, u in zip(bend, b, strict=True)])
        b[true @ self.axis < cos(self.view)] = np.nan
        return b


def _across(w: Vec3, u: Vec3) -> Vec3:
    """As long as `w`, across the unit vector `u`."""
    level = w - (w @ u) * u
    return float(np.linalg.norm(w) / np.linalg.norm(level)) * level
