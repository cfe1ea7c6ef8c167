"""What travels between the parts: NamedTuples of float64 arrays, SI units, radians.

Axes: world z up; body x forward, y left, z up. ``R`` maps body to world. A vector is told in the
world unless its comment says otherwise. NamedTuples, because compiled code takes them both ways
and nobody can change one in flight.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple, TypeAlias

import numpy as np

Array: TypeAlias = np.ndarray
Vec3: TypeAlias = np.ndarray  # (3,)
Mat3: TypeAlias = np.ndarray  # (3, 3)
Quat: TypeAlias = np.ndarray  # (4,) [w, x, y, z], Hamilton, body → world

GRAVITY = 9.81  # [m/s²], the papers' g


class State(NamedTuple):
    """A rigid body: where it is, how it moves."""

    r: Vec3  # (3,) position [m], world
    v: Vec3  # (3,) velocity [m/s], world
    R: Mat3  # (3, 3) body → world
    omega: Vec3  # (3,) angular velocity [rad/s], body


class StateRate(NamedTuple):
    """Time derivatives of a `State`, field by field."""

    r_dot: Vec3  # (3,) [m/s], world
    v_dot: Vec3  # (3,) [m/s²], world
    R_dot: Mat3  # (3, 3) [1/s]
    omega_dot: Vec3  # (3,) [rad/s²], body


class Imu(NamedTuple):
    """One sample of an inertial measurement unit."""

    t: float  # [s] when it was true
    accel: Vec3  # (3,) specific force [m/s²], body; +g along z at rest
    gyro: Vec3  # (3,) angular velocity [rad/s], body


class Fix(NamedTuple):
    """One position fix of a satellite receiver."""

    t: float  # [s] when it was true
    r: Vec3  # (3,) position [m], world of the receiver
    v: Vec3  # (3,) velocity [m/s]


class Pose(NamedTuple):
    """One pose of a motion-capture system."""

    t: float  # [s] when it was true
    r: Vec3  # (3,) position [m], world of the cameras
    R: Mat3  # (3, 3) body → world


class Estimate(NamedTuple):
    """What the aircraft believes of itself."""

    r: Vec3  # (3,) position [m], the estimator's world
    v: Vec3  # (3,) velocity [m/s]
    a: Vec3  # (3,) acceleration [m/s²]
    R: Mat3  # (3, 3) body → world
    omega: Vec3  # (3,) angular velocity [rad/s], body


class Reference(NamedTuple):
    """The reference χ that a controller follows (MRS eq. 16)."""

    r: Vec3  # (3,) position [m]
    v: Vec3  # (3,) velocity [m/s]
    a: Vec3  # (3,) acceleration [m/s²]
    j: Vec3  # (3,) jerk [m/s³]
    heading: float  # [rad]
    heading_rate: float  # [rad/s]


class Command(NamedTuple):
    """What a controller asks of the embedded autopilot, and what it tells the estimator."""

    f_d: float  # collective thrust [N], along body z
    omega_d: Vec3  # (3,) angular velocity [rad/s], body
    a_d: Vec3  # (3,) unbiased desired acceleration [m/s²], world (MRS eq. 53)


class Exit(Enum):
    """How a flight ended. The value is a sentence."""

    DONE = "the scenario ran to its end"
    TILT = "the thrust axis passed 90 degrees of tilt"
    CRASH = "the aircraft hit the ground faster than it can bear"
    AWAY = "the aircraft left the flight volume"
    NAN = "a part returned a number that is not finite"
    ERROR = "a part raised an error"
