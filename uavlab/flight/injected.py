"""Faults in flight: where each of them takes hold of the loop."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from uavlab.flight.fault import Fault
from uavlab.interfaces import Stack
from uavlab.types import Command, Estimate, Vec3

KINDS: Mapping[str, str] = {}  # kind → what happens, in a sentence


class Injected:
    """The faults of one flight."""

    def __init__(self, faults: tuple[Fault, ...], airframe: Any) -> None:
        self.faults, self.airframe = faults, airframe

    def minds(self, mind: Stack) -> Stack:
        """The mind, with parts that fail when their time comes."""
        return mind

    def wind(self, wind: Vec3, t: float) -> Vec3:
        """The air (3,) [m/s], world, with gusts."""
        return wind

    def readings(self, readings: Mapping[str, Any], t: float) -> Mapping[str, Any]:
        """What arrives of what was measured."""
        return readings

    def estimate(self, estimate: Estimate, t: float) -> Estimate:
        """What is told of what was estimated."""
        return estimate

    def linked(self, t: float) -> bool:
        """Whether who commands is heard."""
        return True

    @contextmanager
    def solving(self, t: float) -> Iterator[None]:
        """Within it, programmes find no plan if that is a fault of now."""
        yield

    def advance(
        self, plant: Any, world: Any, command: Command, wind: Vec3, dt: float, inner: int
    ) -> Any:
        """The world `dt` [s] later, with motors, battery and load as they are."""
        return plant.advance(world, command, wind, dt, inner)
