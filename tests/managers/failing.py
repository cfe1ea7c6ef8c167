"""Parts that fail when asked to, in ways that no fault of a scenario knows."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple


class Counting(NamedTuple):
    """Memory of a `Failing`."""

    t: float
    inner: Any
    failed: int = 0


@dataclass(frozen=True)
class Failing:
    """A tracker or controller whose output is changed from a time on."""

    part: Any
    slot: str
    change: Callable[[Any, float], Any]  # output and time since then → output
    at: float = 2.0
    counts: bool = False  # and says that it has no plan

    def init(self, estimate, last):
        return Counting(0.0, self.part.init(estimate, last))

    def step(self, memory, estimate, given, dt):
        inner, out = self.part.step(memory.inner, estimate, given, dt)
        fails = memory.t >= self.at
        out = self.change(out, memory.t - self.at) if fails else out
        return Counting(memory.t + dt, inner, memory.failed + (self.counts and fails)), out

    def reframe(self, memory, shift):
        return memory._replace(inner=self.part.reframe(memory.inner, shift))

    def failures(self, memory):
        return memory.failed


@dataclass(frozen=True)
class Mistaken:
    """An estimator whose estimate is changed from a time on."""

    slot: ClassVar[str] = "estimator"
    part: Any
    change: Callable[[Any, float], Any]
    at: float = 2.0

    def init(self, estimate):
        return Counting(0.0, self.part.init(estimate))

    def step(self, memory, readings, command, dt):
        inner, out = self.part.step(memory.inner, readings, command, dt)
        out = self.change(out, memory.t - self.at) if memory.t >= self.at else out
        return Counting(memory.t + dt, inner), out

    def reframe(self, memory, shift):
        return memory._replace(inner=self.part.reframe(memory.inner, shift))

    def hypotheses(self, memory):
        return {}
