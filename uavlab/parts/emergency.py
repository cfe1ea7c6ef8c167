"""The emergency controller: what brings an aircraft down when the law that flew it cannot be trusted (MRS Sec. 7.2)."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, pi, radians, sqrt, tan
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import Shift, heading, moved, wrap
from uavlab.parts.controllers import Handover, fading, limited_tilt
from uavlab.so3 import about_z
from uavlab.types import GRAVITY, Array, Command, Estimate, Mat3, Reference, Vec3

_G = np.array((0.0, 0.0, GRAVITY))
_G.setflags(write=False)


class Bearing(NamedTuple):
    """What the emergency controller remembers."""

    m_e: float  # [kg] mass, as vertical velocities tell
    d: Vec3  # (3,) [m/s²] with which it leans against the wind, world; level
    command: Command | None  # the last one, for when not even an attitude is known
    handover: Handover


@dataclass(frozen=True)
class Emergency:
    """Go to the reference and stay with it, in no hurry, however large the errors are.

    An error of the place asks for a velocity of no more than ``v`` (vertically ``rise``), an error of the velocity for
    an acceleration of no more than ``a`` (``lift``), and the force for a tilt of no more than ``tilt``. So an estimate
    that is metres off moves the aircraft gently, and inside these bounds the law is linear. What the errors of the
    velocity add up to is mass, and a lean against the wind: whoever has to land now may carry a load that nobody told,
    or have rotors that lost some of their thrust. Errors of the place are not added up. They stay as large as they are
    when the estimate has jumped, and an integral of them runs away.

    mrs_uav_managers lands in an emergency with its MPC controller and other limits. We do not: the programme may be
    what has failed, and this law shares no line with it, nor with any answer of a lab. It also lands better. Behind a
    height that jumped, and in strong wind, the MPC controller with the emergency limits comes down too fast or is
    carried away, while this law lands (tests/parts/test_emergency.py flies both).

    A reference that is no number is not looked at: then it brakes. Without an attitude the last command stands.

    Raises `BadInput` on a number with which nothing can be held.
    """

    slot: ClassVar[str] = "controller"
    mass: float  # [kg] as it was told
    v: float = 2.0  # [m/s] horizontally towards the reference, beside the velocity of the reference
    rise: float = 1.0  # [m/s] likewise, vertically
    a: float = 2.5  # [m/s²] horizontally, beside the wind's; of the emergency controller of mrs_uav_managers
    lift: float = 6.0  # [m/s²] vertically: who is heavier than told falls with the difference
    tilt: float = radians(30.0)  # [rad]
    k_p: float = 0.75  # [1/s] horizontal velocity for an error of the place
    k_v: float = 4.0  # [1/s] horizontal acceleration for an error of the velocity
    k_d: float = 1.0  # [1/s²] of the lean against the wind, for an error of the velocity
    k_z: float = 1.5  # [1/s] vertical velocity for an error of the height
    k_w: float = 6.0  # [1/s] vertical acceleration for an error of the velocity
    k_m: float = 0.6  # [1/m] of the mass that was told, for an error of the vertical velocity
    share: float = 0.6  # of the mass, by which it may be heavier or lighter than told
    k_R: float = 6.0  # [1/s] rate for an error of the axis of thrust
    k_heading: float = 1.0  # [1/s]
    turn: float = pi  # [rad/s] no more than that about the horizontal axes, and a quarter of it about the vertical one
    tau: float = 0.1  # [s] with which the command before it fades

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (isfinite(value) and value > 0.0):
                raise BadInput(f"{name} is {value}; it must be a finite number above 0.")
        if not self.tilt < 0.5 * pi:
            raise BadInput(f"tilt is {self.tilt} rad; it must be below π/2.")
        if not self.share < 1.0:
            raise BadInput(f"share is {self.share}; it must be below 1: some of the mass is left.")

    def init(self, estimate: Estimate, last: Command | None) -> Bearing:
        """Take over from `last`, if that was a command; the mass is as told."""
        if last is not None and not _numbers(last.f_d, last.omega_d, last.a_d):
            last = None
        return Bearing(self.mass, np.zeros(3), last, Handover(last, None))

    def step(
        self, memory: Bearing, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Bearing, Command]:
        """One tick of `dt` [s]."""
        R = estimate.R
        if not _numbers(R):
            return memory, memory.command or Command(memory.m_e * GRAVITY, np.zeros(3), np.zeros(3))
        missing, a = self._wanted(estimate, reference)
        if memory.handover.last is None:  # else that command flies on, and nothing is learned
            memory = self._learned(memory, missing, dt)
        m_e = memory.m_e
        f = limited_tilt(m_e * (a + memory.d + _G), self.tilt)
        f_d = max(float(f @ R[:, 2]), 0.0)
        law = Command(f_d, self._rates(R, f, reference), (f_d / m_e) * R[:, 2] - memory.d - _G)
        handover, command = fading(memory.handover, law, dt, self.tau)
        return memory._replace(command=command, handover=handover), command

    def _wanted(self, estimate: Estimate, reference: Reference) -> tuple[Vec3, Vec3]:
        """Error of the velocity (3,) [m/s] and acceleration (3,) [m/s²], world."""
        if not _numbers(estimate.v):
            return np.zeros(3), np.zeros(3)
        e, v, a = np.zeros(3), np.zeros(3), np.zeros(3)
        if _numbers(estimate.r, reference.r, reference.v, reference.a):
            e, v, a = reference.r - estimate.r, reference.v, reference.a
        wish = np.append(_shortened(self.k_p * e[:2], self.v), _clipped(self.k_z * e[2], self.rise))
        missing = v + wish - estimate.v
        level = _shortened(a[:2] + self.k_v * missing[:2], self.a)
        return missing, np.append(level, _clipped(a[2] + self.k_w * missing[2], self.lift))

    def _learned(self, memory: Bearing, missing: Vec3, dt: float) -> Bearing:
        """Mass and lean, one step later. They learn of velocities, which no jump of a place can hold off for long."""
        d = memory.d + self.k_d * dt * np.array((missing[0], missing[1], 0.0))
        d[:2] = _shortened(d[:2], GRAVITY * tan(self.tilt))
        off = memory.m_e - self.mass + self.k_m * self.mass * float(missing[2]) * dt
        return memory._replace(m_e=self.mass + _clipped(off, self.share * self.mass), d=d)

    def _rates(self, R: Mat3, f: Vec3, reference: Reference) -> Vec3:
        """Body rates (3,) [rad/s] that turn the axis of thrust the short way to the force, and the nose gently."""
        x, y, z = f @ R  # the wanted force, told in the body: e3 × f = (−y, x, 0)
        flat = sqrt(x * x + y * y)
        angle = float(np.arctan2(flat, z))
        k = min(self.k_R * angle, self.turn) / flat if flat > 0.0 else 0.0
        yaw = 0.0
        if _numbers(reference.heading):
            yaw = self.k_heading * wrap(reference.heading - heading(R))
        return np.array((-k * y, k * x, _clipped(yaw, 0.25 * self.turn)))

    def reframe(self, memory: Bearing, shift: Shift) -> Bearing:
        """The same, told in the new world."""
        last, rest = (None if x is None else moved(x, shift) for x in memory.handover)
        command = memory.command and moved(memory.command, shift)
        return Bearing(memory.m_e, about_z(shift.heading) @ memory.d, command, Handover(last, rest))


def _shortened(x: Array, most: float) -> Array:
    """`x` (n,), no longer than `most`."""
    size = sqrt(x @ x)
    return x * (most / size) if size > most else x


def _clipped(x: float, most: float) -> float:
    """`x`, no larger than `most` in size."""
    return min(max(float(x), -most), most)


def _numbers(*given: Array | float) -> bool:
    """Whether all of it is finite."""
    return all(np.isfinite(x).all() for x in given)
