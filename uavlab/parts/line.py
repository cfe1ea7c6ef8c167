"""The line: straight to the goal at a given pace, and stop there."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import Shift, moved, wrap
from uavlab.interfaces import Goal
from uavlab.parts.pace import Pace, beginning, checked, closing, stepped
from uavlab.types import Estimate, Reference, Trajectory, Vec3

LEVEL, UPRIGHT = Pace(3.0, 1.0), Pace(1.0, 1.0)
SLOPE = 4.0  # [1/s], how the last centimetres fade
ARRIVED = 0.1  # [m] from the goal
TURN = 0.5  # [rad/s], largest heading rate
K_TURN = 1.0  # [1/s], heading rate for an error of the heading


class Leg(NamedTuple):
    """What the tracker remembers."""

    now: Reference  # of this tick
    goal: Reference | None  # None: stand


@dataclass(frozen=True)
class LineTracker:
    """Fly straight to the place and the heading of the goal, as the line tracker of mrs_uav_trackers does.

    From rest the way is a line, and the speed along it a trapezoid: as fast as the pace of the axes allows in this
    direction. From any other motion it turns into the line with the same acceleration. Jerk has no limit.

    Raises `BadInput` on a pace that is none; in flight on a trajectory.
    """

    slot: ClassVar[str] = "tracker"
    horizontal: Pace = LEVEL
    vertical: Pace = UPRIGHT

    def __post_init__(self) -> None:
        checked(self.horizontal, "horizontal")
        checked(self.vertical, "vertical")

    def init(self, estimate: Estimate, last: Reference | None) -> Leg:
        """Continue from the last reference, else from the estimate and its velocity; stop until told otherwise."""
        return Leg(beginning(estimate, last), None)

    def step(
        self, memory: Leg, estimate: Estimate, goal: Goal | None, dt: float
    ) -> tuple[Leg, Reference]:
        """The reference of now; then it moves on by `dt` [s]."""
        if isinstance(goal, Trajectory):
            raise BadInput("LineTracker flies to one place; give it a Reference, not a Trajectory.")
        goal = goal if goal is not None else memory.goal
        turn = 0.0
        if goal is not None:
            turn = K_TURN * wrap(goal.heading - memory.now.heading)
            turn = min(max(turn, -TURN), TURN)
        now = memory.now._replace(heading_rate=turn)
        change = self._wanted(now, goal) - now.v
        share = max(self._size(change, "a") / dt, 1.0)
        later = stepped(now, now.v + change / share, dt)
        return Leg(later._replace(heading=wrap(now.heading + turn * dt)), goal), now

    def _wanted(self, now: Reference, goal: Reference | None) -> Vec3:
        """The velocity towards the goal (3,) [m/s], world: the fastest that can still be stopped there."""
        way = np.zeros(3) if goal is None else goal.r - now.r
        distance = sqrt(way @ way)
        if distance == 0.0:
            return np.zeros(3)
        along = way / distance
        v, a = 1.0 / self._size(along, "v"), 1.0 / self._size(along, "a")
        return along * min(closing(distance, a, SLOPE), v)

    def _size(self, x: Vec3, limit: str) -> float:
        """How many times the limit "v" or "a" the vector `x` is, by the axis that is nearer to its own."""
        flat, up = sqrt(x[0] * x[0] + x[1] * x[1]), abs(float(x[2]))
        return max(flat / getattr(self.horizontal, limit), up / getattr(self.vertical, limit))

    def reframe(self, memory: Leg, shift: Shift) -> Leg:
        """The same leg, told in the new world."""
        goal = memory.goal and moved(memory.goal, shift)
        return Leg(moved(memory.now, shift), goal)

    def arrived(self, memory: Leg) -> bool:
        """Whether the reference is within 0.1 m of the goal."""
        if memory.goal is None:
            return False
        e = memory.goal.r - memory.now.r
        return sqrt(e @ e) < ARRIVED
