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


class Shift(NamedTuple):
    """Change of world: ``r_new = Rz(heading) r_old + r`` (z stays vertical, so four degrees of freedom)."""

    r: Vec3  # (3,) [m], where the old origin lies in the new world
    heading: float  # [rad], how far the old world is turned in the new one


NO_SHIFT = Shift(np.zeros(3), 0.0)
NO_SHIFT.r.setflags(write=False)


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
    std: float = 0.0  # [m], what the receiver says of its error; 0: it says nothing


class Pose(NamedTuple):
    """One pose of a motion-capture system, or of visual SLAM."""

    t: float  # [s] when it was true
    r: Vec3  # (3,) position [m], world of the cameras or of the map
    R: Mat3  # (3, 3) body → world


class Attitude(NamedTuple):
    """One attitude of the embedded autopilot: its tilt is good, its heading wanders."""

    t: float  # [s] when it was true
    R: Mat3  # (3, 3) body → the autopilot's own world


class Field(NamedTuple):
    """One sample of a magnetometer."""

    t: float  # [s] when it was true
    m: Vec3  # (3,) magnetic field, body, in units of the earth's


class Height(NamedTuple):
    """One height of a barometer."""

    t: float  # [s] when it was true
    z: float  # [m] above where it was switched on


class Range(NamedTuple):
    """One distance of a rangefinder that looks down."""

    t: float  # [s] when it was true
    d: float  # [m] to the ground, along the negative body z axis


class Flow(NamedTuple):
    """One velocity of an optic-flow camera that looks down."""

    t: float  # [s] when it was true
    v_B: Array  # (2,) velocity along the body x and y axes [m/s], rotation taken off


class Bearings(NamedTuple):
    """Directions to beacons, from one image."""

    t: float  # [s] when it was true
    b: Array  # (n, 3) unit vectors to the beacons, body; NaN where one was not seen


class Estimate(NamedTuple):
    """What the aircraft believes of itself."""

    r: Vec3  # (3,) position [m], the estimator's world
    v: Vec3  # (3,) velocity [m/s]
    a: Vec3  # (3,) acceleration [m/s²]
    R: Mat3  # (3, 3) body → world
    omega: Vec3  # (3,) angular velocity [rad/s], body
    world: str = ""  # whose world this is told in: the hypothesis that flies, if there are several
    shift: Shift = NO_SHIFT  # from the world in which the flight began to the one this is told in


class Hypothesis(NamedTuple):
    """What one filter of a bank believes, in its own world: 11 states, each axis by itself (MRS Sec. 3.1)."""

    x: Array  # (3, 3), a row for each axis: position [m], velocity [m/s], acceleration [m/s²]
    P: Array  # (3, 3, 3) covariance of each row
    h: Array  # (2,) heading [rad] and heading rate [rad/s]
    P_h: Array  # (2, 2) its covariance
    nis: float  # normalised innovation squared per degree of freedom, lately; about 1 when all is well
    reliable: bool  # healthy enough to fly on


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
