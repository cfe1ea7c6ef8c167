"""Faults in flight: where each of them takes hold of the loop."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import cos, inf, nan, pi
from typing import Any

import numpy as np

from uavlab.flight.broken import broken
from uavlab.flight.damage import Damage
from uavlab.flight.fault import KINDS, Fault
from uavlab.flight.misreadings import Misreadings
from uavlab.interfaces import Stack
from uavlab.solvers import unsolved
from uavlab.types import Command, Estimate, Vec3

__all__ = ["KINDS", "Injected"]


class Injected:
    """The faults of one flight. Until one begins, all that passes here is what it was, to the last bit."""

    def __init__(self, faults: tuple[Fault, ...], airframe: Any) -> None:
        self.faults, self.t = faults, -inf  # nothing is broken before the first tick
        self.misreadings = Misreadings(faults)
        self.damage = Damage(faults, int(airframe.n))

    def now(self, kind: str, t: float) -> list[Fault]:
        """The faults of this kind at time `t` [s]."""
        return [x for x in self.faults if x.kind == kind and x.lasts(t)]

    def minds(self, mind: Stack) -> Stack:
        """The mind, with parts that fail when their time comes; see `uavlab.flight.broken.broken`."""
        return broken(mind, self.faults, lambda: self.t)

    def wind(self, wind: Vec3, t: float) -> Vec3:
        """The air (3,) [m/s], world, with gusts; and the time for the parts that fail."""
        self.t = t
        for x in self.now("gust", t):
            passed = (t - x.t) / (x.until - x.t)
            wind = wind + 0.5 * (1.0 - cos(2.0 * pi * passed)) * np.asarray(x.value, dtype=float)
        return wind

    def readings(self, readings: Mapping[str, Any], t: float) -> Mapping[str, Any]:
        """What arrives of what was measured."""
        return self.misreadings.arrived(readings, t)

    def estimate(self, estimate: Estimate, t: float) -> Estimate:
        """What is told of what was estimated."""
        for x in self.now("nan", t):
            none = np.full(3, nan)
            estimate = estimate._replace(r=none, v=none, a=none)
            if x.what == "all":
                estimate = estimate._replace(R=np.full((3, 3), nan), omega=none)
        return estimate

    def linked(self, t: float) -> bool:
        """Whether who commands is heard."""
        return not self.now("link", t)

    @contextmanager
    def solving(self, t: float) -> Iterator[None]:
        """Within it, programmes find no plan if that is a fault of now."""
        if self.now("solver", t):
            with unsolved():
                yield
        else:
            yield

    def advance(
        self, plant: Any, world: Any, command: Command, wind: Vec3, dt: float, inner: int
    ) -> Any:
        """The world `dt` [s] later, with motors, battery and load as they are."""
        return self.damage.advance(plant, world, command, wind, dt, inner)
