"""What travels between the parts: NamedTuples of float64 arrays, SI units, radians.

Axes: world z up; body x forward, y left, z up. ``R`` maps body to world. A vector is told in the
world unless its comment says otherwise. NamedTuples, because compiled code takes them both ways
and nobody can change one in flight.
"""

from __future__ import annotations

from collections.abc import Mapping
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


class Sectors(NamedTuple):
    """How far the nearest thing is in each sector around, above and below; inf where nothing is within reach."""

    t: float  # [s] when it was true
    d: Array  # (n,) [m]; sector i looks 2π i/n to the left of the nose, all of them level
    down: float  # [m]
    up: float  # [m]


class Sticks(NamedTuple):
    """How somebody on the ground holds a remote control."""

    t: float  # [s] when it was true
    engaged: bool  # whether the aircraft is to obey it
    push: Vec3  # (3,) forward, left, up, each in [−1, 1]: of the heading frame, so the same in every world
    turn: float  # to the left, in [−1, 1]
    failsafe: bool  # whether the switch is on


class Estimate(NamedTuple):
    """What the aircraft believes of itself."""

    r: Vec3  # (3,) position [m], the estimator's world
    v: Vec3  # (3,) velocity [m/s]
    a: Vec3  # (3,) acceleration [m/s²]
    R: Mat3  # (3, 3) body → world
    omega: Vec3  # (3,) angular velocity [rad/s], body
    world: str = ""  # whose world this is told in: the hypothesis that flies, if there are several
    shift: Shift = NO_SHIFT  # from the world in which the flight began to the one this is told in
    worlds: Mapping[str, Shift] = {}  # hypothesis → from its world to the one this is told in
    reliable: bool = True  # whether any measurement of late stands behind it


class Hypothesis(NamedTuple):
    """What one filter of a bank believes, in its own world: 11 states, each axis by itself (MRS Sec. 3.1)."""

    x: Array  # (3, 3), a row for each axis: position [m], velocity [m/s], acceleration [m/s²]
    P: Array  # (3, 3, 3) covariance of each row
    h: Array  # (2,) heading [rad] and heading rate [rad/s]
    P_h: Array  # (2, 2) its covariance
    nis: float  # normalised innovation squared per degree of freedom, lately; about 1 when all is well
    reliable: bool  # healthy enough to fly on


class VerticalMemory(NamedTuple):
    """What a barometer and an accelerometer say of the vertical: Filter 0 of Bangura."""

    z: float  # [m] height, as the barometer counts it
    v_z: float  # [m/s] vertical velocity, world, up
    b_z: float  # [m/s²] bias of the vertical acceleration, world, up


class VerticalGains(NamedTuple):
    """Gains of Filter 0. Its error decays like s³ + k_1 s² + k_2 s + k_3: three poles at −1 rad/s."""

    k_1: float = 3.0  # [1/s] on the height
    k_2: float = 3.0  # [1/s²] on the velocity
    k_3: float = 1.0  # [1/s³] on the bias; must stay below k_1 k_2


class BodyMemory(NamedTuple):
    """Filter 1 of Bangura: velocity through the air, told in the body, and attitude."""

    V: Vec3  # (3,) velocity through the air [m/s], body
    R: Mat3  # (3, 3) body → world
    u: float  # latent scaling of the attitude [1]; 1 when all is well
    b_a: Vec3  # (3,) accelerometer bias [m/s²], body
    b_omega: Vec3  # (3,) gyro bias [rad/s], body


class InertialMemory(NamedTuple):
    """Filter 2 of Bangura: velocity over ground, told in the world, and attitude."""

    v: Vec3  # (3,) velocity over ground [m/s], world
    R: Mat3  # (3, 3) body → world
    u: float  # latent scaling of the attitude [1]; 1 when all is well
    b_a: Vec3  # (3,) accelerometer bias [m/s²], body
    b_omega: Vec3  # (3,) gyro bias [rad/s], body


class AidedGains(NamedTuple):
    """Gains of a velocity-aided attitude filter (Bangura prints none).

    Near hover the tilt obeys s² + k_v s + g² k_r, the scaling s² + k_v s + g² k_u, and the heading s² + h k_m s +
    h k_m k_b_m, with h the squared horizontal field. We damp all three well, and let the tilt be quicker than the
    scaling, and that quicker than the biases: these three compete for the same innovation.
    """

    k_v: float = 4.0  # [1/s] on the velocity
    k_r: float = 0.04  # [rad s/m²] on the tilt: with k_v two poles near −2 rad/s
    k_u: float = 0.01  # [s²/m²] on the scaling: slowest pole near −0.26 rad/s
    k_m: float = 6.0  # [rad/s] on the heading: near −1 rad/s where the horizontal field is 0.4
    k_b_a: float = 0.05  # [1/s] of the velocity innovation, on the accelerometer bias
    k_b_omega: float = 0.01  # [rad/m²] of the tilt innovation, on the gyro bias; below k_v k_r
    k_b_m: float = 0.1  # [1/s] of the heading innovation, on the gyro bias


class Pull(NamedTuple):
    """What one filter of a coupled pair adds to the rates of the other."""

    v_dot: Vec3  # (3,) on its velocity [m/s²], in the frame of that velocity
    turn: Vec3  # (3,) on its attitude [rad/s], an angular velocity told in the world
    b_a_dot: Vec3  # (3,) on its accelerometer bias [m/s³], body


_ZERO = np.zeros(3)
_ZERO.setflags(write=False)
NO_PULL = Pull(_ZERO, _ZERO, _ZERO)


class CoupledGains(NamedTuple):
    """Gains of the coupled filters of Bangura."""

    vertical: VerticalGains = VerticalGains()
    body: AidedGains = AidedGains()
    inertial: AidedGains = AidedGains()
    k_1_vc: float = 0.5  # [1/s] velocity of Filter 1 towards that of Filter 2
    k_2_vc: float = 0.5  # [1/s] velocity of Filter 2 towards that of Filter 1
    k_1_rc: float = 1.0  # [1/s] attitude of Filter 1 towards that of Filter 2
    k_2_rc: float = 1.0  # [1/s] attitude of Filter 2 towards that of Filter 1
    k_1_b_a: float = 0.2  # [1/s] accelerometer bias of Filter 1 towards that of Filter 2
    k_2_b_a: float = 0.2  # [1/s] accelerometer bias of Filter 2 towards that of Filter 1
    k_w: float = 0.5  # [1/s] on the wind, which then settles within 10 s


class CoupledMemory(NamedTuple):
    """A memory for the coupled filters of Bangura: the three filters, the wind, and what was measured last."""

    vertical: VerticalMemory
    body: BodyMemory
    inertial: InertialMemory
    w: Vec3  # (3,) wind [m/s], world
    m_W: Vec3  # (3,) magnetic field, world
    imu: Imu | None
    v_meas: Vec3 | None  # (3,) velocity over ground [m/s], world; None while it has dropped out
    age: float  # [s] since it was measured
    m_meas: Vec3 | None  # (3,) magnetic field, body
    z_meas: float | None  # [m]
    rejected: int  # readings that were not numbers


class CoupledEstimate(NamedTuple):
    """What the coupled filters of Bangura believe."""

    V: Vec3  # (3,) velocity through the air [m/s], body (Filter 1)
    v: Vec3  # (3,) velocity over ground [m/s], world (Filter 2)
    a: Vec3  # (3,) acceleration [m/s²], world
    w: Vec3  # (3,) wind [m/s], world
    R: Mat3  # (3, 3) body → world (Filter 2)
    omega: Vec3  # (3,) angular velocity [rad/s], body, bias taken off
    z: float  # [m] height (Filter 0)
    u_1: float  # latent scaling of Filter 1 [1]
    u_2: float  # latent scaling of Filter 2 [1]
    b_a: Vec3  # (3,) accelerometer bias [m/s²], body (Filter 2)
    b_omega: Vec3  # (3,) gyro bias [rad/s], body (Filter 2)


class MassMemory(NamedTuple):
    """What an adaptive estimate of the mass remembers (Spica Sec. 5.4): three filtered signals and 1/m."""

    v_z: float  # [m/s] filtered vertical velocity, world, up
    lift: float  # [N] filtered vertical part of the commanded thrust
    g: float  # [m/s²] filtered gravity
    inverse: float  # [1/kg] estimate of 1/m


class InertiaMemory(NamedTuple):
    """What an adaptive estimate of the inertia remembers: each body axis by itself (Spica Sec. 5.4)."""

    omega: Vec3  # (3,) filtered angular velocity [rad/s], body
    torque: Vec3  # (3,) filtered commanded torque [N m], body
    inverse: Vec3  # (3,) estimate of 1/J of each axis [1/(kg m²)]


class Reference(NamedTuple):
    """The reference χ that a controller follows (MRS eq. 16)."""

    r: Vec3  # (3,) position [m]
    v: Vec3  # (3,) velocity [m/s]
    a: Vec3  # (3,) acceleration [m/s²]
    j: Vec3  # (3,) jerk [m/s³]
    heading: float  # [rad]
    heading_rate: float  # [rad/s]


class Trajectory(NamedTuple):
    """A way to fly: places and headings at times, sampled at any rate (MRS Sec. 4.1). A goal may be one.

    Between two samples the aircraft is wanted on the line between them; behind the last, at the last.
    """

    t: Array  # (K,) [s], growing; 0 is when the trajectory is given
    r: Array  # (K, 3) positions [m], world
    heading: Array  # (K,) [rad]


class Command(NamedTuple):
    """What a controller asks of the embedded autopilot, and what it tells the estimator."""

    f_d: float  # collective thrust [N], along body z
    omega_d: Vec3  # (3,) angular velocity [rad/s], body
    a_d: Vec3  # (3,) unbiased desired acceleration [m/s²], world (MRS eq. 53)


class Exit(Enum):
    """How a flight ended. The value is a sentence."""

    DONE = "the scenario ran to its end"
    LANDED = "the aircraft landed and switched its motors off"
    FAILSAFE = "the aircraft came down under the failsafe"
    TILT = "the thrust axis passed 90 degrees of tilt"
    CRASH = "the aircraft hit an obstacle, or the ground faster than it can bear"
    AWAY = "the aircraft left the flight volume"
    NAN = "a part returned a number that is not finite"
    ERROR = "a part raised an error"

    @property
    def good(self) -> bool:
        """Whether this is how a flight should end."""
        return self in {Exit.DONE, Exit.LANDED}
