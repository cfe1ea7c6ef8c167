"""Missions: what the aircraft is asked to do, as goals in the world in which the mission began."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import NO_SHIFT, Shift, compose, heading, moved
from uavlab.parts.paths import Path, along
from uavlab.parts.trackers import why_not
from uavlab.types import Estimate, Reference, Trajectory, Vec3


class Clock(NamedTuple):
    """A mission's memory: how long it has run, and where its world went."""

    t: float  # [s] since init
    shift: Shift  # the mission's world → the estimator's world


class _Timed:
    """A mission whose goal is a function of time alone."""

    slot: ClassVar[str] = "mission"

    def goal(self, t: float) -> Reference:
        """The goal at `t` [s], in the world in which the mission began."""
        raise NotImplementedError

    def init(self, estimate: Estimate) -> Clock:
        """A clock at zero."""
        return Clock(0.0, NO_SHIFT)

    def step(self, memory: Clock, estimate: Estimate, dt: float) -> tuple[Clock, Reference]:
        """The goal of now; then `dt` [s] pass."""
        goal = self.goal(memory.t)
        if memory.shift is not NO_SHIFT:
            goal = moved(goal, memory.shift)
        return memory._replace(t=memory.t + dt), goal

    def reframe(self, memory: Clock, shift: Shift) -> Clock:
        """Goals from now on are told in the new world."""
        return memory._replace(shift=compose(shift, memory.shift))


def still(r: Vec3, heading: float = 0.0) -> Reference:
    """Stand at `r` (3,) [m] with `heading` [rad]."""
    zero = np.zeros(3)
    return Reference(np.asarray(r, dtype=float), zero, zero, zero, heading, 0.0)


@dataclass(frozen=True)
class Waypoints(_Timed):
    """Stand at each place in turn: ``stops`` are (time [s], place (3,) [m], heading [rad])."""

    stops: tuple[tuple[float, tuple[float, float, float], float], ...]

    def __post_init__(self) -> None:
        times = [stop[0] for stop in self.stops]
        if not times or times != sorted(times):
            raise BadInput(f"waypoint times must grow from the first to the last; got {times}.")

    def goal(self, t: float) -> Reference:
        """The last stop whose time has come (the first before any has)."""
        due = [stop for stop in self.stops if stop[0] <= t] or [self.stops[0]]
        return still(np.array(due[-1][1]), due[-1][2])


class Given(NamedTuple):
    """What a mission remembers that gives its goal once."""

    t: float  # [s] since init
    shift: Shift  # the mission's world → the estimator's world
    done: bool  # whether it was given


@dataclass(frozen=True)
class Fly:
    """Fly along a trajectory: it is given once, when its time has come; a tracker keeps it. Before, stand at its start.

    Raises `BadInput` on a trajectory that nobody can fly: not finite, of wrong shapes, or backwards in time.
    """

    slot: ClassVar[str] = "mission"
    trajectory: Trajectory
    at: float = 0.0  # [s] after the start of the mission

    def __post_init__(self) -> None:
        if not isinstance(self.trajectory, Trajectory):
            raise BadInput(
                f"Fly takes a uavlab.types.Trajectory(t, r, heading); got {self.trajectory!r}."
            )
        try:
            way = Trajectory(*(np.array(x, dtype=float) for x in self.trajectory))
        except (TypeError, ValueError) as error:
            raise BadInput(f"the trajectory is not made of arrays of numbers: {error}.") from None
        object.__setattr__(self, "trajectory", way)
        if why := why_not(way):
            raise BadInput(why)
        if not 0.0 <= self.at < float("inf"):
            raise BadInput(f"a trajectory is given at {self.at} s; take a time of 0 s or later.")

    def init(self, estimate: Estimate) -> Given:
        """Nothing is given yet."""
        return Given(0.0, NO_SHIFT, False)

    def step(
        self, memory: Given, estimate: Estimate, dt: float
    ) -> tuple[Given, Reference | Trajectory | None]:
        """The start of the trajectory; once, the trajectory; then nothing new. Then `dt` [s] pass."""
        later = memory._replace(t=memory.t + dt)
        if memory.done:
            return later, None
        if memory.t < self.at - 1e-9:
            way = self.trajectory
            return later, moved(still(way.r[0], float(way.heading[0])), memory.shift)
        return later._replace(done=True), moved(self.trajectory, memory.shift)

    def reframe(self, memory: Given, shift: Shift) -> Given:
        """What is given from now on is told in the new world."""
        return memory._replace(shift=compose(shift, memory.shift))


class Elsewhere(NamedTuple):
    """The memory of a mission that is told in another world."""

    inner: Clock | Given
    shift: Shift | None  # its world → the estimator's, when last known


@dataclass(frozen=True)
class InWorld:
    """A mission whose goals are told in the world of one hypothesis, whichever one flies (MRS Sec. 3.5, 7.1).

    Until that world is known the aircraft is asked to stand where it is, and a trajectory waits; while it is unknown
    again, the last is kept.
    """

    slot: ClassVar[str] = "mission"
    mission: _Timed | Fly
    world: str  # name of a hypothesis

    def init(self, estimate: Estimate) -> Elsewhere:
        """The mission from its beginning."""
        return Elsewhere(self.mission.init(estimate), None)

    def step(
        self, memory: Elsewhere, estimate: Estimate, dt: float
    ) -> tuple[Elsewhere, Reference | Trajectory | None]:
        """The goal of now, told in the world that flies."""
        shift = estimate.worlds.get(self.world, memory.shift)
        inner, goal = self.mission.step(memory.inner, estimate, dt)  # type: ignore[arg-type]
        if shift is None:
            kept = memory.inner if isinstance(goal, Trajectory) else inner
            return Elsewhere(kept, None), still(estimate.r, heading(estimate.R))
        return Elsewhere(inner, shift), None if goal is None else moved(goal, shift)

    def reframe(self, memory: Elsewhere, shift: Shift) -> Elsewhere:
        """Its own world stays; the way from there is another one."""
        return memory._replace(shift=memory.shift and compose(shift, memory.shift))


@dataclass(frozen=True)
class Follow(_Timed):
    """Fly along a closed path at ``rate`` [rad/s], after a smooth start of ``ramp`` [s]."""

    path: Path
    rate: float
    ramp: float = 3.0
    heading: float = 0.0  # [rad], where the nose stays ...
    face: Vec3 | None = None  # ... or (3,) [m], the place that it looks at

    def goal(self, t: float) -> Reference:
        """The point of the path for now, with its derivatives."""
        r, v, a, j = along(self.path, t, self.rate, self.ramp)
        if self.face is None:
            return Reference(r, v, a, j, self.heading, 0.0)
        x, y = self.face[0] - r[0], self.face[1] - r[1]
        return Reference(r, v, a, j, atan2(y, x), (y * v[0] - x * v[1]) / (x * x + y * y))
