"""Smooth random flights for the checks of filters: where the aircraft is, and what perfect instruments would say."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab import so3
from uavlab.interfaces import Reading
from uavlab.types import GRAVITY, Estimate, Field, Fix, Height, Imu, Mat3, Vec3

FIELD = np.array((0.35, -0.2, -0.9))  # a magnetic field of the north, world; its heading is not 0
FIELD.setflags(write=False)
_G = np.array((0.0, 0.0, GRAVITY))


class Moment(NamedTuple):
    """A flight at one time."""

    r: Vec3  # (3,) position [m], world
    v: Vec3  # (3,) velocity [m/s], world
    R: Mat3  # (3, 3) body → world


class Path:
    """A flight that weaves about and leans up to `lean` [rad], its heading near `yaw` [rad] + t `turn` [rad/s].

    Readings are means over a step: what turns and moves the aircraft exactly from one time to the next.
    """

    def __init__(
        self, rng: np.random.Generator, yaw: float, *, turn: float = 0.0, lean: float = 0.4
    ) -> None:
        self.yaw, self.turn, self.lean = yaw, turn, lean
        self.size = rng.uniform(0.7, 1.3, size=3) * (1.5, 1.5, 0.5)  # [m]
        self.pace = rng.uniform(1.0, 2.0, size=6)  # [rad/s]
        self.phase = rng.uniform(0.0, 6.0, size=6)

    def at(self, t: float) -> Moment:
        """The flight at time `t` [s]."""
        angle = self.pace * t + self.phase
        r = self.size * np.sin(angle[:3])
        v = self.size * self.pace[:3] * np.cos(angle[:3])
        tilt = self.lean * np.array((np.sin(angle[3]), np.sin(angle[4]), 0.0))
        R = so3.about_z(self.yaw + self.turn * t) @ so3.exp(tilt)
        return Moment(r, v, R)

    def imu(self, t: float, dt: float) -> Imu:
        """Specific force and angular velocity from `t` to `t` + `dt` [s]."""
        here, there = self.at(t), self.at(t + dt)
        force = here.R.T @ ((there.v - here.v) / dt + _G)
        return Imu(t, force, so3.log(here.R.T @ there.R) / dt)


class Blown:
    """A flight in a steady wind: the rotors drag as Bangura eq. (3) says, and all instruments are perfect.

    It weaves like a `Path`; its thrust carries its weight. `step` moves it, and says what is read before.
    """

    def __init__(self, rng: np.random.Generator, yaw: float, *, w: Vec3, c: float) -> None:
        self.path = Path(rng, yaw, turn=0.5, lean=0.3)
        self.w, self.c = w, c  # [m/s], world; [1/√m]
        self.t, self.r, self.v = 0.0, np.zeros(3), rng.normal(size=3)
        self.before, self.R = self.v, self.path.at(0.0).R

    def guess(self) -> Estimate:
        """What one may believe at the start: velocity and attitude are right."""
        return Estimate(self.r, self.v, np.zeros(3), self.R, np.zeros(3))

    def step(self, dt: float) -> dict[str, Reading]:
        """Fly on for `dt` [s]; the readings of its beginning, of ``imu barometer magnetometer gnss``."""
        V = self.R.T @ (self.v - self.w)
        up = GRAVITY / self.R[2, 2] - 0.5 * self.v[2]
        accel = np.append(-self.c * np.sqrt(up) * V[:2], up)
        there = self.path.at(self.t + dt).R
        readings: dict[str, Reading] = {
            "imu": Imu(self.t, accel, so3.log(self.R.T @ there) / dt),
            "barometer": Height(self.t, float(self.r[2])),
            "magnetometer": Field(self.t, self.R.T @ FIELD),
            "gnss": Fix(self.t, self.r, self.v),
        }
        a, self.before = self.R @ accel - _G, self.v
        self.t, self.r, self.v, self.R = self.t + dt, self.r + dt * self.v, self.v + dt * a, there
        return readings
