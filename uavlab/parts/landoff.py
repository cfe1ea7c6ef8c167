"""Take-off and landing: a reference that waits for an aircraft that is held, and one that goes below the ground.

Paper: MRS Sec. 4.2. The figures are those of the landoff tracker of mrs_uav_trackers.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import Shift, moved
from uavlab.interfaces import Goal
from uavlab.parts.pace import Pace, beginning, checked, closing, stepped, towards
from uavlab.types import Estimate, Reference, Vec3

LOWEST, HIGHEST = 0.5, 10.0  # [m], heights to which one may take off
SLOPE = 4.0  # [1/s], how the last centimetres of a climb fade
ARRIVED = 0.1  # [m] from the height that was asked for: the take-off is done
CLIMB, SINK = Pace(1.0, 0.3), Pace(0.5, 0.3)
EMERGENCY = Pace(0.5, 1.0)  # to sink at, when it must be soon
STOPPED = 0.05  # [m/s] horizontally: a landing may go down


class Lift(NamedTuple):
    """What the tracker remembers."""

    now: Reference  # of this tick
    top: float  # [m] the height at which a take-off ends, in the world of the estimate


@dataclass(frozen=True)
class LandOff:
    """Take off to a height, or land: begun by `init`, told by nobody afterwards (a goal is not looked at).

    A take-off climbs straight from where it begins. When the reference is farther than ``reach`` from the estimate,
    and its next step would take it farther still, it stands: an aircraft that hangs in the grass is not pulled at
    harder and harder. A landing first stops horizontally; then the reference sinks, and goes ``below`` the estimate
    once that sinks no more. Nobody need know where the ground is, and the thrust falls until `Touchdown` sees it.

    Raises `BadInput` on a height that is not between 0.5 and 10 m, or a pace that is no pace.
    """

    slot: ClassVar[str] = "tracker"
    height: float | None = None  # [m] to climb from where it begins; None: land
    climb: Pace = CLIMB
    sink: Pace = SINK
    stop: float = 2.0  # [m/s²], with which horizontal motion ends
    reach: float = 0.7  # [m] from estimate to reference, in a take-off
    below: float = 1.0  # [m] under the estimate, in a landing

    def __post_init__(self) -> None:
        h = self.height
        if h is not None and not LOWEST <= h <= HIGHEST:
            raise BadInput(
                f"a take-off to {h} m; take a height of {LOWEST:g} to {HIGHEST:g} m above the start, "
                "or None to land."
            )
        checked(self.climb, "climb")
        checked(self.sink, "sink")
        for name in ("stop", "reach", "below"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise BadInput(f"{name} is {value}; it must be a finite number above 0.")

    def init(self, estimate: Estimate, last: Reference | None) -> Lift:
        """Begin at the last reference, else where the estimate is; heights count from there."""
        now = beginning(estimate, last)
        return Lift(now, float(now.r[2]) + (self.height or 0.0))

    def step(
        self, memory: Lift, estimate: Estimate, goal: Goal | None, dt: float
    ) -> tuple[Lift, Reference]:
        """The reference of now; then it moves on by `dt` [s]."""
        now = memory.now
        v = np.empty(3)
        v[:2] = towards(now.v[:2], np.zeros(2), self.stop * dt)
        pace = self.sink if self.height is None else self.climb
        wanted = self._sinking(now, estimate) if self.height is None else self._climbing(memory)
        v[2] = now.v[2] + min(max(wanted - now.v[2], -pace.a * dt), pace.a * dt)
        later = stepped(now, v, dt)
        if self.height is not None and self._held(now, later, estimate):
            zero = np.zeros(3)
            later = Reference(now.r, zero, zero, zero, now.heading, 0.0)
        return memory._replace(now=later), now

    def _climbing(self, memory: Lift) -> float:
        """Vertical velocity towards the top [m/s]."""
        e = memory.top - float(memory.now.r[2])
        return min(closing(abs(e), self.climb.a, SLOPE), self.climb.v) * (1.0 if e > 0.0 else -1.0)

    def _sinking(self, now: Reference, estimate: Estimate) -> float:
        """Vertical velocity towards the place below the estimate [m/s]; 0 until it stands still, and never up."""
        if sqrt(now.v[:2] @ now.v[:2]) > STOPPED:
            return 0.0
        e = float(now.r[2]) - (float(estimate.r[2]) - self.below)
        return -min(closing(e, self.sink.a, SLOPE), self.sink.v) if e > 0.0 else 0.0

    def _held(self, now: Reference, later: Reference, estimate: Estimate) -> bool:
        """Whether the aircraft stays behind, and this step would leave it farther behind."""
        far = _distance(now.r, estimate.r)
        return far > self.reach and _distance(later.r, estimate.r) > far

    def reframe(self, memory: Lift, shift: Shift) -> Lift:
        """The same climb or descent, told in the new world."""
        return Lift(moved(memory.now, shift), memory.top + float(shift.r[2]))

    def arrived(self, memory: Lift, estimate: Estimate) -> bool:
        """Whether a take-off is done: reference and estimate near the top. Of a landing, `Touchdown` says it."""
        near = max(abs(memory.top - memory.now.r[2]), abs(memory.top - estimate.r[2])) < ARRIVED
        return self.height is not None and bool(near)


def _distance(a: Vec3, b: Vec3) -> float:
    e = a - b
    return sqrt(e @ e)
