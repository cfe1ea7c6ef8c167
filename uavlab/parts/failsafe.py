"""The failsafe: level, nose where it was, a little less thrust than hover, and ever less (MRS Sec. 5.10)."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, isfinite, radians, sin, sqrt, tan
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import Shift, heading, moved, wrap
from uavlab.parts.controllers import Handover, fading
from uavlab.parts.throttle import ThrustCurve, checked
from uavlab.so3 import about_z, log
from uavlab.types import GRAVITY, Command, Estimate, Mat3, Reference, Vec3

STEEPEST = GRAVITY * tan(radians(15.0))  # [m/s²], largest lean


class Fall(NamedTuple):
    """What the failsafe remembers."""

    t: float  # [s] since it took over
    heading: float  # [rad] then, in the world of the estimate
    handover: Handover
    lean: Vec3  # (3,) [m/s²] against the wind, world; level


@dataclass(frozen=True)
class Failsafe:
    """Come down without knowing where one is, or how fast: a feed-forward for the thrust, feedback for the attitude.

    It looks at the attitude of the estimate only; positions and velocities may be anything, NaN too, and so may the
    reference. The throttle begins at ``share`` of that which hovers the ``mass`` and falls by ``rate``; the curve
    turns it into a force. Both are as in mrs_uav_managers; the paper prints none. It does not stop what moves
    sideways, and it does not stop at the ground: `Touchdown` does. The command before it fades in
    tenths of a second.

    Who levels out in wind is carried away by it. With a ``lean``, told in the world of the estimate in which it begins,
    it keeps the thrust tilted against the wind as it was while there still was an estimate (ours; MRS level out).

    Raises `BadInput` on a mass that cannot hover on the curve, or a number that makes no descent.
    """

    slot: ClassVar[str] = "controller"
    mass: float  # [kg] as last believed: the m_e of the controller before it
    curve: ThrustCurve
    share: float = 0.98  # of the hover throttle
    rate: float = 0.015  # [1/s], of the range of the throttle
    k_R: float = 3.0  # [1/s], body rates for a rotation to level
    tau: float = 0.1  # [s], with which the command before it fades
    lean: tuple[float, float] = (0.0, 0.0)  # [m/s²] of the horizontal thrust against the wind

    def __post_init__(self) -> None:
        checked(self.curve, self.mass)
        if not 0.0 < self.share <= 1.0:
            raise BadInput(f"share is {self.share}; take 0 to 1: above hover nothing comes down.")
        for name in ("rate", "k_R", "tau"):
            value = getattr(self, name)
            if not (isfinite(value) and value > 0.0):
                raise BadInput(f"{name} is {value}; it must be a finite number above 0.")
        if not hypot(*self.lean) <= STEEPEST:
            raise BadInput(
                f"lean is {self.lean} m/s²; take finite numbers of {STEEPEST:.2f} m/s² together at most."
            )

    def init(self, estimate: Estimate, last: Command | None) -> Fall:
        """Take over from `last`, and keep the heading of now."""
        lean = np.array((*self.lean, 0.0))
        return Fall(0.0, heading(estimate.R), Handover(last, None), lean)

    def force(self, t: float) -> float:
        """The thrust [N], `t` [s] after it took over."""
        a_t, b_t = self.curve
        hover, idle = sqrt(self.mass * GRAVITY), max(-b_t / a_t, 0.0)
        # MRS (32): the throttle is a straight line of the root of the force, and so the root falls evenly, too.
        root = hover - (1.0 - self.share) * (hover + b_t / a_t) - self.rate * t / a_t
        return max(root, idle) ** 2

    def step(
        self, memory: Fall, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Fall, Command]:
        """One tick of `dt` [s]; the reference is not looked at."""
        R, f = estimate.R, self.force(memory.t)
        omega = self.k_R * log(R.T @ _leaning(memory))
        a = (f / self.mass) * R[:, 2] - np.array((0.0, 0.0, GRAVITY))
        handover, command = fading(memory.handover, Command(f, omega, a), dt, self.tau)
        return memory._replace(t=memory.t + dt, handover=handover), command

    def reframe(self, memory: Fall, shift: Shift) -> Fall:
        """The same fall, told in the new world."""
        turned = wrap(memory.heading + shift.heading)
        handover = Handover(*(None if x is None else moved(x, shift) for x in memory.handover))
        lean = about_z(shift.heading) @ memory.lean
        return memory._replace(heading=turned, handover=handover, lean=lean)


def _leaning(memory: Fall) -> Mat3:
    """The attitude (3, 3) that is wanted: level, or leaning, the nose where it was."""
    if not memory.lean.any():
        return about_z(memory.heading)
    b3 = memory.lean + np.array((0.0, 0.0, GRAVITY))
    b3 = b3 / sqrt(b3 @ b3)
    b2 = np.cross(b3, (cos(memory.heading), sin(memory.heading), 0.0))
    b2 = b2 / sqrt(b2 @ b2)
    return np.column_stack((np.cross(b2, b3), b2, b3))
