"""Controllers: the stand-in that flies at once, and the one that flies the answers of the heading lab."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, exp, sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab.frames import Shift, heading, moved, wrap
from uavlab.interfaces import asks
from uavlab.types import GRAVITY, Command, Estimate, Mat3, Reference, Vec3

_G = np.array((0.0, 0.0, GRAVITY))
_G.setflags(write=False)


class Handover(NamedTuple):
    """A memoryless controller's memory: what to add so that taking over is not felt."""

    last: Command | None  # the command before us, until the first step
    rest: Command | None  # what still differs from it; fades


def fading(memory: Handover, command: Command, dt: float, tau: float) -> tuple[Handover, Command]:
    """Add the fading difference to the command before us, so that the first step repeats it.

    Parameters
    ----------
    memory : Handover
        From ``init`` or the step before.
    command : Command
        What the law asks for now.
    dt, tau : float
        Tick and time constant [s] with which the difference fades.
    """
    if memory.last is not None:
        rest = _sum(memory.last, command, -1.0)
    elif memory.rest is not None:
        rest = _sum(memory.rest, memory.rest, exp(-dt / tau) - 1.0)
    else:
        return memory, command
    if abs(rest.f_d) < 1e-9 and max(np.abs(rest.omega_d).max(), np.abs(rest.a_d).max()) < 1e-9:
        return Handover(None, None), command
    return Handover(None, rest), _sum(command, rest, 1.0)


def _sum(a: Command, b: Command, k: float) -> Command:
    """Commands added field by field, the second taken `k` times."""
    return Command(a.f_d + k * b.f_d, a.omega_d + k * b.omega_d, a.a_d + k * b.a_d)


class Gains(NamedTuple):
    """Gains of a position loop around an attitude loop."""

    k_p: float = 6.0  # [1/s²] on position; the soft set of the MRS controllers
    k_v: float = 4.0  # [1/s] on velocity
    k_R: float = 8.0  # [1/s] on the tilt error
    k_heading: float = 2.0  # [1/s] on the heading error
    tilt_max: float = 1.05  # [rad] (60°)


def wanted_acceleration(estimate: Estimate, reference: Reference, gains: Gains) -> Vec3:
    """Acceleration that closes position and velocity errors [m/s²], world, shape (3,)."""
    return (
        reference.a
        + gains.k_p * (reference.r - estimate.r)
        + gains.k_v * (reference.v - estimate.v)
    )


def limited_tilt(f: Vec3, tilt_max: float) -> Vec3:
    """The force `f` (3,) [N], world, with its horizontal part cut to the largest tilt [rad]."""
    up = max(f[2], 1.0)  # a force that points down would turn the aircraft over
    flat = sqrt(f[0] * f[0] + f[1] * f[1])
    most = up * np.tan(tilt_max)
    k = min(1.0, most / flat) if flat > 0.0 else 1.0
    return np.array((k * f[0], k * f[1], up))


@dataclass(frozen=True)
class TiltAxis:
    """Stand-in: turn the thrust axis the short way to the wanted force, and yaw slowly on the side.

    It looks at the cross product of the two axes and takes yaw for heading, which is fair near
    hover only. No feed-forward, no integral: it lags on a circle and leans away from the wind.
    """

    slot: ClassVar[str] = "controller"
    mass: float  # [kg]
    gains: Gains = Gains()

    def init(self, estimate: Estimate, last: Command | None) -> Handover:
        """Take over from `last`."""
        return Handover(last, None)

    def step(
        self, memory: Handover, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Handover, Command]:
        """One tick of the P law."""
        k, R = self.gains, estimate.R
        a = wanted_acceleration(estimate, reference, k)
        f = limited_tilt(self.mass * (a + _G), k.tilt_max)
        x, y, z = f @ R  # the wanted force, told in the body: e3 × f = (−y, x, 0)
        size = sqrt(x * x + y * y + z * z)
        turn = k.k_R / size
        yaw = k.k_heading * wrap(reference.heading - heading(R)) + reference.heading_rate
        command = Command(z, np.array((-turn * y, turn * x, yaw)), f / self.mass - _G)
        return fading(memory, command, dt, 0.5)

    def reframe(self, memory: Handover, shift: Shift) -> Handover:
        """The hand-over, told in the new world."""
        return _moved_handover(memory, shift)


@dataclass(frozen=True)
class HeadingController:
    """Fly a force and a heading with the functions of lab 02 (MRS Sec. 5.1–5.3, without integrals).

    Roll and pitch rates turn the thrust axis to that of R_d. Everything about the heading is a heading
    rate, wanted or corrected; the student turns it into a yaw rate, and takes off what roll and pitch
    make of it. (MRS eq. 25 feeds e_R back on all three axes. Without its jerk feed-forward the tilt lags,
    and a yaw error in body axes is then no heading error.)
    """

    slot: ClassVar[str] = "controller"
    attitude_with_heading: Callable[[Vec3, float], Mat3] = asks("heading")
    yaw_rate_from_heading_rate: Callable[[Mat3, float], float] = asks("heading")
    parasitic_yaw_rate: Callable[[Mat3, Vec3], float] = asks("heading")
    mass: float = 0.0  # [kg]
    gains: Gains = Gains()

    @staticmethod
    def stand_in(mass: float, gains: Gains = Gains()) -> TiltAxis:
        """What flies while one of the three functions is missing."""
        return TiltAxis(mass, gains)

    def init(self, estimate: Estimate, last: Command | None) -> Handover:
        """Take over from `last`."""
        return Handover(last, None)

    def step(
        self, memory: Handover, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Handover, Command]:
        """One tick: MRS (17)–(23) for the attitude, (31) and Sec. 5.3 for the yaw rate."""
        k, R = self.gains, estimate.R
        a = wanted_acceleration(estimate, reference, k)
        f = limited_tilt(self.mass * (a + _G), k.tilt_max)

        R_d = self.attitude_with_heading(f, reference.heading)
        x, y, z = R_d[:, 2] @ R  # the wanted thrust axis, told in the body: e3 × b3d = (−y, x, 0)
        sine = sqrt(x * x + y * y)
        turn = k.k_R * atan2(sine, z) / sine if sine > 0.0 else 0.0
        omega_d = np.array((-turn * y, turn * x, 0.0))

        rate = reference.heading_rate + k.k_heading * wrap(heading(R_d) - heading(R))
        omega_d[2] = self.yaw_rate_from_heading_rate(R, rate) + self.parasitic_yaw_rate(R, omega_d)

        command = Command(float(f @ R[:, 2]), omega_d, f / self.mass - _G)
        return fading(memory, command, dt, 0.5)

    def reframe(self, memory: Handover, shift: Shift) -> Handover:
        """The hand-over, told in the new world."""
        return _moved_handover(memory, shift)


def _moved_handover(memory: Handover, shift: Shift) -> Handover:
    return Handover(*(None if x is None else moved(x, shift) for x in memory))
