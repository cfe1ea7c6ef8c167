"""Spica's loops, (4) and (5), as a part that flies: the torque goes through the embedded rate loop as it was meant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.flight.log import Log
from uavlab.frames import Shift
from uavlab.gains import TorqueGains
from uavlab.plant.airframe import Airframe
from uavlab.so3 import about_z
from uavlab.so3 import log as rotation_vector
from uavlab.types import GRAVITY, Array, Command, Estimate, Mat3, Reference, Vec3

OURS = TorqueGains()
H = 2e-3  # [s] of the differences that turn a path into body rates
UP = np.array((0.0, 0.0, 1.0))
Goal = Callable[[float], Reference]


class Wound(NamedTuple):
    """What the loops remember."""

    t: float  # [s] since init
    e_p: Vec3  # (3,) [m s] integral of the position error, world
    e_R: Vec3  # (3,) [rad s] integral of the rotation error, body


class Wish(NamedTuple):
    """One tick of the loops: thrust and torque as asked for, and as the rotors can do them."""

    asked: Array  # (4,) [N, N m]
    given: Array  # (4,)
    memory: Wound


def rates_for_torque(tau: Vec3, omega: Vec3, airframe: Airframe) -> Vec3:
    """Body rates (3,) [rad/s] for which the embedded rate loop makes the torque `tau` (3,) [N m] at this instant.

    Exact while the autopilot works at the rate of the commands, for it adds ω × J ω and multiplies by J itself.
    """
    missing = airframe.J_inv @ (tau - np.cross(omega, airframe.J @ omega))
    return omega + missing / airframe.rate_gain


@lru_cache(maxsize=20_000)  # every seed flies the same path
def flat(goal: Goal, t: float) -> tuple[Vec3, Vec3]:
    """Angular velocity and acceleration (3,), (3,) that a path asks for, told in the wanted body frame.

    They depend on its third and fourth derivatives; taken here as differences of the attitude.
    """
    before, now, after = (_attitude(goal(max(s, 0.0))) for s in (t - H, t, t + H))
    first, second = rotation_vector(before.T @ now), rotation_vector(now.T @ after)
    return (first + second) / (2.0 * H), (second - first) / H**2


def _attitude(x: Reference) -> Mat3:
    return answer("heading", "attitude_with_heading")(x.a + GRAVITY * UP, x.heading)


@dataclass(frozen=True)
class TorqueLoop:
    """Position loop (4) and attitude loop (5) of Spica, within what the rotors can do."""

    slot: ClassVar[str] = "controller"
    airframe: Airframe
    goal: Goal | None = None  # the path, for the feed-forward; without one there is none
    scaled: bool = True  # whether thrust and torque are scaled (Spica Sec. 4)
    gains: TorqueGains = OURS

    def init(self, estimate: Estimate, last: Command | None) -> Wound:
        """Nothing is wound up."""
        return Wound(0.0, np.zeros(3), np.zeros(3))

    def step(
        self, memory: Wound, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Wound, Command]:
        """One tick: thrust and torque, told to the embedded loop as body rates."""
        wish = self.wish(memory, estimate, reference, dt)
        f, tau = float(wish.given[0]), wish.given[1:]
        omega_d = rates_for_torque(tau, estimate.omega, self.airframe)
        a_d = f / self.airframe.m * estimate.R[:, 2] - GRAVITY * UP
        return wish.memory, Command(f, omega_d, a_d)

    def wish(self, memory: Wound, estimate: Estimate, reference: Reference, dt: float) -> Wish:
        """Thrust and torque of this tick, asked for and given."""
        k, a, R = self.gains, self.airframe, estimate.R
        e_p, e_v = reference.r - estimate.r, reference.v - estimate.v
        force = a.m * (reference.a + GRAVITY * UP) + np.multiply(k.k_p, e_p)  # (4)
        force = force + np.multiply(k.k_ip, memory.e_p) + np.multiply(k.k_v, e_v)
        R_d = answer("heading", "attitude_with_heading")(force, reference.heading)
        omega_d, omega_dot_d = (
            (np.zeros(3), np.zeros(3)) if self.goal is None else flat(self.goal, memory.t)
        )
        tau = answer("geometric", "torque_command")(
            R, R_d, estimate.omega, omega_d, omega_dot_d, memory.e_R, a.J, k
        )
        asked = np.array((force @ R[:, 2], *tau))
        e_R = -answer("geometric", "attitude_error")(R, R_d)
        then = Wound(memory.t + dt, memory.e_p + e_p * dt, memory.e_R + e_R * dt)
        return Wish(asked, self.within(asked), then)

    def within(self, u: Array) -> Array:
        """What the rotors can do of `u` (4,), scaled towards hovering."""
        if not self.scaled:
            return u
        a = self.airframe
        hover = np.array((a.m * GRAVITY, 0.0, 0.0, 0.0))
        scale = answer("geometric", "scale_to_limits")
        return scale(u, hover, a.allocation, a.thrust_min, a.thrust_max)

    def reframe(self, memory: Wound, shift: Shift) -> Wound:
        """The position error turns along."""
        return memory._replace(e_p=about_z(shift.heading) @ memory.e_p)


def wishes(log: Log, loop: TorqueLoop) -> tuple[Array, Array]:
    """Thrust and torque (N, 4) asked for and given at each tick, told again from what the flight knew."""
    memory: Any = loop.init(_known(log, 0), None)
    asked, given = [], []
    for k in range(len(log.t)):
        wanted = Reference(
            log.r_d[k], log.v_d[k], log.a_d[k], np.zeros(3), float(log.heading_d[k]), 0.0
        )
        one = loop.wish(memory, _known(log, k), wanted, log.meta["dt"])
        memory = one.memory
        asked.append(one.asked)
        given.append(one.given)
    return np.array(asked), np.array(given)


def _known(log: Log, k: int) -> Estimate:
    return Estimate(log.r_e[k], log.v_e[k], np.zeros(3), log.R_e[k], log.omega[k])
