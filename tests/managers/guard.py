"""The plainest pilot that obeys the watch: a pair, an emergency landing, a fall. And parts that fail when asked to."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.interfaces import Event, Report
from uavlab.managers.safety import FAILSAFE, Play, Safety, begun, kind_of, reframed, watched
from uavlab.orders import ORDERS, Unheard
from uavlab.parts.emergency import Emergency
from uavlab.parts.failsafe import Failsafe
from uavlab.parts.landoff import EMERGENCY, LandOff
from uavlab.parts.touchdown import Touchdown


class Guarding(NamedTuple):
    """Memory of a `Guarded`."""

    t: float
    level: str  # of the verdict that is obeyed
    parts: tuple  # tracker and controller that fly
    memories: tuple
    watch: Any
    light: float  # [s], of the touch-down
    down: bool
    last: tuple = (None, None)  # reference and command
    events: tuple = ()


@dataclass(frozen=True)
class Guarded:
    """Tracker and controller, under watch."""

    tracker: Any
    controller: Any
    limits: Safety
    mass: float

    def init(self, estimate, ground):
        parts = (self.tracker, self.controller)
        memories = tuple(part.init(estimate, None) for part in parts)
        return Guarding(0.0, "", parts, memories, begun(self.limits), 0.0, False)

    def step(self, m, estimate, readings, asked, dt):
        goals = [x for x in asked if not isinstance(x, ORDERS)]
        heard = not any(isinstance(x, Unheard) for x in asked)
        m, reference, command = self._flown(m, estimate, goals[-1] if goals else None, dt)
        if not np.isfinite(estimate.r).all() and m.level != FAILSAFE:
            command = m.last[1]
        if m.level != FAILSAFE:
            failed = sum(
                p.failures(x)
                for p, x in zip(m.parts, m.memories, strict=True)
                if hasattr(p, "failures")
            )
            play = Play(kind_of(m.parts[1]), m.last == (None, None), failed, heard, bool(m.level))
            watch, verdict = watched(self.limits, m.watch, estimate, reference, command, play, dt)
            m = m._replace(watch=watch)
            if verdict.level not in {"", m.level}:
                m = self._obeyed(m, verdict, estimate)
                m, reference, command = self._flown(m, estimate, None, dt)
        light, down = Touchdown(self.mass, self.limits.curve).step(m.light, command, dt)
        m = m._replace(
            t=m.t + dt,
            light=light,
            down=m.down or (down and bool(m.level)),
            last=(reference, command),
        )
        return m, reference, command

    def _flown(self, m, estimate, goal, dt):
        tracking, reference = m.parts[0].step(m.memories[0], estimate, goal, dt)
        controlling, command = m.parts[1].step(m.memories[1], estimate, reference, dt)
        return m._replace(memories=(tracking, controlling)), reference, command

    def _obeyed(self, m, verdict, estimate):
        law = (
            Failsafe(self.mass, self.limits.curve)
            if verdict.level == FAILSAFE
            else Emergency(self.mass)
        )
        parts = (LandOff(sink=EMERGENCY), law)
        said = Event(m.t, "safety", verdict.trigger, verdict.said)
        return m._replace(
            level=verdict.level, parts=parts, watch=m.watch._replace(mute=self.limits.mute),
            memories=(parts[0].init(estimate, None), law.init(estimate, m.last[1])), events=(*m.events, said),
        )  # fmt: skip

    def reframe(self, m, shift):
        memories = tuple(p.reframe(x, shift) for p, x in zip(m.parts, m.memories, strict=True))
        return m._replace(memories=memories, watch=reframed(m.watch, shift))

    def report(self, m):
        over = ("failsafe" if m.level == FAILSAFE else "landed") if m.down else ""
        return Report(m.level or "flying", m.events, over)


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
