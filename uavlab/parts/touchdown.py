"""Touch-down, seen by the thrust: an aircraft that stands is carried by the ground (MRS Sec. 5.4, eq. 34)."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt

from uavlab.errors import BadInput
from uavlab.parts.throttle import ThrustCurve, checked
from uavlab.types import GRAVITY, Command

IDLE = 0.01  # throttle below which the rotors carry nothing


@dataclass(frozen=True)
class Touchdown:
    """Touched down: the apparent mass has been below ``share`` of the mass for ``time``.

    What it remembers is one number, for how long this has been so [s]. Share and time are those of mrs_uav_managers.

    Raises `BadInput` on a mass that cannot hover on the curve, a share that is not between 0 and 1, or a time below 0.
    """

    mass: float  # [kg] as last believed before the landing
    curve: ThrustCurve
    share: float = 0.5
    time: float = 2.0  # [s]

    def __post_init__(self) -> None:
        checked(self.curve, self.mass)
        if not 0.0 < self.share < 1.0:
            raise BadInput(f"share is {self.share}; it must lie between 0 and 1.")
        if not (isfinite(self.time) and self.time >= 0.0):
            raise BadInput(f"time is {self.time} s; it must be finite, 0 or more.")

    def init(self) -> float:
        """It has not been light yet [s]."""
        return 0.0

    def step(self, memory: float, command: Command, dt: float) -> tuple[float, bool]:
        """One tick of `dt` [s] under this command: for how long it has been light [s], and whether it stands."""
        f, (a_t, b_t) = max(command.f_d, 0.0), self.curve
        idle = sqrt(f) < (IDLE - b_t) / a_t  # MRS (32): the throttle is a straight line of the root
        light = idle or f < self.share * self.mass * GRAVITY
        memory = memory + dt if light else 0.0
        return memory, memory > self.time - 1e-9
