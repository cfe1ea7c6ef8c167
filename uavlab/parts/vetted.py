"""An estimator that does not believe every reading: what cannot be a measurement of now is not handed on.

Paper: MRS Sec. 3; the delay and age limits of the estimators of mrs_uav_managers are 0.5 to 2 s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from statistics import median_low
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import Shift, moved
from uavlab.interfaces import Estimator, Memory, Readings
from uavlab.types import (
    Attitude,
    Bearings,
    Command,
    Estimate,
    Field,
    Fix,
    Flow,
    Height,
    Hypothesis,
    Imu,
    Pose,
    Range,
)

KINDS = (Imu, Fix, Pose, Attitude, Field, Height, Range, Flow, Bearings)  # others are not judged
PLACES = (Fix, Pose, Flow, Bearings, Estimate)  # what keeps an aircraft where it is
ROUNDING = 1e-9  # [s]


class Watched(NamedTuple):
    """Memory of `Vetted`."""

    inner: Memory  # of the estimator
    clock: float | None  # [s] by the instruments' own time; None before the first reading
    quiet: float  # [s] since a reading of a place was handed on
    seen: Mapping[str, Any]  # instrument → what it read last
    again: Mapping[str, int]  # instrument → how often it has repeated that
    why: Mapping[str, str] = {}  # instrument → why its last reading was dropped


@dataclass(frozen=True)
class Vetted:
    """An estimator that is told only of readings that can be measurements of now.

    Dropped is a reading that is not finite; one that repeats the values before it for the fifth time or more, for the
    noise of an instrument never does; and one that is older than `age`, or from as far in the future. Time is that of
    the readings themselves: the latest one that was not dropped, carried on by the ticks. A direction to a beacon that
    was not seen may be NaN. Readings of kinds that `uavlab.types` does not know as an estimator's are handed on.

    Without any reading of a place (position, pose, optic flow, bearings) for `age` the estimate is not ``reliable``,
    whatever the estimator says.

    Parameters
    ----------
    estimator : Estimator
        Who is told.
    age : float
        [s] How old a reading may be, and how long a place may go unmeasured.
    repeats : int
        How often the same values may not come again.

    Raises
    ------
    BadInput
        `age` is no time above 0, `repeats` is below 1, or `estimator` is none.
    """

    slot: ClassVar[str] = "estimator"
    estimator: Estimator
    age: float = 0.5
    repeats: int = 5

    def __post_init__(self) -> None:
        if getattr(self.estimator, "slot", None) != "estimator":
            raise BadInput(f"Vetted takes an estimator; got {type(self.estimator).__name__}.")
        if not (isfinite(self.age) and self.age > 0.0):
            raise BadInput(f"age is {self.age} s; it must be a finite time above 0.")
        if not self.repeats >= 1:
            raise BadInput(f"repeats is {self.repeats}; it must be 1 or more.")

    @property
    def first_name(self) -> str:
        """Who of several is told first; empty for one alone."""
        return getattr(self.estimator, "first_name", "")

    @property
    def names(self) -> tuple[str, ...]:
        """Whom a swap may name; empty for one alone."""
        return getattr(self.estimator, "names", ())

    def init(self, estimate: Estimate) -> Watched:
        """Continue from `estimate`; nothing has been read yet."""
        return Watched(self.estimator.init(estimate), None, 0.0, {}, {})

    def step(
        self, memory: Watched, readings: Readings, command: Command, dt: float
    ) -> tuple[Watched, Estimate]:
        """One tick of `dt` [s]: judge, then estimate."""
        clock = self._clock(memory.clock, readings, dt)
        again, seen, why = dict(memory.again), dict(memory.seen), dict(memory.why)
        good = {}
        for name, x in readings.items():
            if not isinstance(x, KINDS):
                good[name] = x
                continue
            again[name] = again.get(name, 0) + 1 if _same(x, seen.get(name)) else 0
            seen[name] = x
            said = self._why_not(x, again[name], clock)
            if said:
                why[name] = said
            else:
                good[name] = x
                why.pop(name, None)
        quiet = memory.quiet + dt
        if any(isinstance(x, PLACES) for x in good.values()):
            quiet = 0.0
        inner, out = self.estimator.step(memory.inner, good, command, dt)
        if quiet > self.age + ROUNDING:
            out = out._replace(reliable=False)
        return Watched(inner, clock, quiet, seen, again, why), out

    def _clock(self, clock: float | None, readings: Readings, dt: float) -> float | None:
        """The time of now, by the readings that can be of now."""
        times = [float(x.t) for x in readings.values() if isinstance(x, KINDS) and isfinite(x.t)]
        if clock is None:
            return median_low(times) if times else None
        clock += dt
        return max([clock, *(t for t in times if t - clock <= self.age)])

    def _why_not(self, x: Any, again: int, clock: float | None) -> str:
        """Why this is no measurement of now; empty if it may be one."""
        for field, value in zip(x._fields, x, strict=True):
            unseen = isinstance(x, Bearings) and field == "b"
            if not (unseen or np.isfinite(value).all()):
                return f"its {field} is not finite"
        if again >= self.repeats:
            return f"it is frozen: the same values {self.repeats} times again"
        assert clock is not None  # this reading has a time, so there is a clock
        late = clock - float(x.t)
        if abs(late) > self.age + ROUNDING:
            what = f"{late:.2f} s old" if late > 0.0 else f"{-late:.2f} s in the future"
            return f"it is {what}; at most {self.age:g} s are taken"
        return ""

    def reframe(self, memory: Watched, shift: Shift) -> Watched:
        """The same, told in the new world."""
        seen = {name: moved(x, shift) for name, x in memory.seen.items()}
        return memory._replace(inner=self.estimator.reframe(memory.inner, shift), seen=seen)

    def hypotheses(self, memory: Watched) -> Mapping[str, Hypothesis]:
        """What each filter of the estimator believes."""
        return self.estimator.hypotheses(memory.inner)

    def dropped(self, memory: Watched) -> Mapping[str, str]:
        """Why an instrument is not listened to now: by instrument, of its last reading."""
        return memory.why

    def swap(self, memory: Watched, name: str) -> Watched:
        """Hand on that `name` is to be told.

        Raises
        ------
        BadInput
            The estimator hears no requests, or refuses this one.
        UnknownName
            It knows nobody of this name.
        """
        part: Any = self.estimator
        if not hasattr(part, "swap"):
            raise BadInput(f"{type(part).__name__} hears no requests.")
        return memory._replace(inner=part.swap(memory.inner, name))

    def news(self, memory: Watched) -> tuple[tuple[str, str], ...]:
        """What became of the members of an estimator that is several, in the last step."""
        part: Any = self.estimator
        return part.news(memory.inner) if hasattr(part, "news") else ()


def _same(x: Any, last: Any) -> bool:
    """Whether a reading has the values of the last one; its time may be another."""
    if type(x) is not type(last):
        return False
    pairs = zip(x._fields, x, last, strict=True)
    return all(np.array_equal(a, b, equal_nan=name == "b") for name, a, b in pairs if name != "t")
