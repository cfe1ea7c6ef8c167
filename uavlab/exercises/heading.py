"""Lab 02, one angle without Euler: where the nose points, how fast that changes, and how to choose it."""

from __future__ import annotations

import numpy as np

from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.expect import (
    expect_heading,
    expect_heading_rate,
    expect_rotation,
    expect_thrust_axis,
)
from uavlab.exercises.spec import Function, exercise, expect, expect_close, numbers
from uavlab.types import Mat3, Vec3

# What the heading is and does -------------------------------------------------------------------------


@exercise(points=4, reads="MRS eq. (15), Sec. 3.4")
def heading_rate(R: Mat3, omega: Vec3) -> float:
    """Rate of change of the heading of a body that turns.

    The heading is an angle of the body x axis, seen from above. As the body turns the axis moves,
    and its shadow on the ground turns.

    Parameters
    ----------
    R : Mat3
        Rotation body → world, shape (3, 3). Valid while the body x axis is not vertical, where
        the heading is not defined.
    omega : Vec3
        Angular velocity [rad/s], body, shape (3,).

    Returns
    -------
    float
        Heading rate [rad/s], positive counter-clockwise seen from above.
    """
    ...


@heading_rate.check(weight=0)
def level_flight(f: Function, rng: np.random.Generator) -> None:
    """While the aircraft is level, the heading rate is the yaw rate."""
    for _ in range(3):
        omega = draw.vector(rng, 2.0)
        expect_close(f(so3.about_z(draw.angle(rng)), omega), omega[2])


@heading_rate.check
def derivative_of_the_heading(f: Function, rng: np.random.Generator) -> None:
    """The heading rate must be the derivative of the heading, also while the aircraft is tilted."""
    for _ in range(4):
        R, omega = draw.tilted(rng, 0.3, 1.0), draw.vector(rng, 2.0)
        expect_heading_rate(f(R, omega), R, omega, atol=1e-6)


@exercise(points=3, reads="MRS eq. (12)-(14), Sec. 3.3")
def with_heading(R_o: Mat3, heading: float) -> Mat3:
    """The same orientation, turned about the world z axis until it has the heading asked for.

    The estimator does this to the attitude of the autopilot, whose heading it does not trust. The
    tilt angle stays, the direction of the tilt turns along.

    Parameters
    ----------
    R_o : Mat3
        Orientation body → world, shape (3, 3). Valid while its x axis is not vertical.
    heading : float
        Heading wanted [rad], any number.

    Returns
    -------
    Mat3
        Orientation body → world, shape (3, 3).
    """
    ...


@with_heading.check(weight=0)
def a_level_aircraft(f: Function, rng: np.random.Generator) -> None:
    """A level aircraft that is given a heading is turned about its own z axis to that heading."""
    heading = draw.angle(rng)
    expect_close(f(so3.about_z(draw.angle(rng)), heading), so3.about_z(heading))


@with_heading.check
def turned_about_the_vertical(f: Function, rng: np.random.Generator) -> None:
    """The result must have the heading asked for, and every body axis must point as high as before."""
    for _ in range(3):
        R, heading = draw.tilted(rng, 0.2, 1.0), draw.angle(rng)
        got = expect_rotation(f(R, heading))
        expect_heading(got, heading)
        expect_close(got[2], R[2], "The tilt has changed.")


# Attitudes that point a force -------------------------------------------------------------------------


@exercise(points=3, reads="MRS eq. (17)-(20), Sec. 5.1.1")
def attitude_by_projection(f_d: Vec3, heading_d: float) -> Mat3:
    """Desired attitude after Lee: the thrust axis is exact, the heading only nearly.

    The heading vector is dropped at right angles onto the plane that the thrust axis leaves free.

    Parameters
    ----------
    f_d : Vec3
        Desired force [N], world, shape (3,), of any length above zero.
    heading_d : float
        Desired heading [rad].

    Returns
    -------
    Mat3
        Desired attitude R_d^o, body → world, shape (3, 3).

    Raises
    ------
    ValueError
        `f_d` is zero, or along the heading vector of (17) (to 1e-9): nothing is left to project.
    """
    ...


@attitude_by_projection.check
def thrust_along_the_force(f: Function, rng: np.random.Generator) -> None:
    """The result must be a rotation whose z axis points along the force."""
    for _ in range(3):
        f_d = draw.force(rng, 0.2, 1.0)
        got = expect_rotation(f(f_d, draw.angle(rng)))
        expect_thrust_axis(got, f_d)


@attitude_by_projection.check
def x_axis_nearest_to_the_heading(f: Function, rng: np.random.Generator) -> None:
    """Of all attitudes that point the force, it is the one whose x axis is nearest to the heading vector."""
    for _ in range(3):
        f_d, heading = draw.force(rng, 0.2, 1.0), draw.angle(rng)
        h_d = np.array((np.cos(heading), np.sin(heading), 0.0))
        got = expect_rotation(f(f_d, heading))
        expect_thrust_axis(got, f_d)
        expect_close(h_d @ got[:, 1], 0.0, "The y axis should be square to the heading vector.")
        expect(h_d @ got[:, 0] > 0, "The x axis points backwards.")


@exercise(points=5, reads="MRS eq. (21)-(23), Sec. 5.1.2")
def attitude_with_heading(f_d: Vec3, heading_d: float) -> Mat3:
    """Desired attitude with both: the thrust axis along the force, and exactly the heading.

    The heading vector is moved along the world z axis, not at right angles, onto the plane that the
    thrust axis leaves free: seen from above it does not move.

    Parameters
    ----------
    f_d : Vec3
        Desired force [N], world, shape (3,), of any length above zero; it may also point down.
    heading_d : float
        Desired heading [rad].

    Returns
    -------
    Mat3
        Desired attitude R_d, body → world, shape (3, 3).

    Raises
    ------
    ValueError
        `f_d` is zero or horizontal (less than 1e-3 of its length is vertical): the plane that it
        leaves free is then vertical, and the heading cannot be chosen.
    """
    ...


@attitude_with_heading.check
def thrust_axis_and_heading(f: Function, rng: np.random.Generator) -> None:
    """The result must be a rotation with its z axis along the force and its heading as asked for."""
    for _ in range(3):
        f_d, heading = draw.force(rng, 0.3, 1.2), draw.angle(rng)
        got = expect_rotation(f(f_d, heading))
        expect_thrust_axis(got, f_d)
        expect_heading(got, heading)


@attitude_with_heading.check(weight=0)
def level_when_the_force_is(f: Function, rng: np.random.Generator) -> None:
    """With a force straight up, the attitude is a turn about the world z axis by the heading."""
    for _ in range(2):
        heading = draw.angle(rng)
        got = f(np.array((0.0, 0.0, float(rng.uniform(5.0, 50.0)))), heading)
        expect_close(got, so3.about_z(heading))


# Rates that keep or change it -------------------------------------------------------------------------


@exercise(points=3, reads="MRS eq. (27)-(31), Sec. 5.2")
def yaw_rate_from_heading_rate(R: Mat3, heading_rate: float) -> float:
    """Yaw rate that, alone, changes the heading at the rate asked for.

    A turn about the body z axis moves the body x axis along the body y axis. Only a part of that is
    seen from above, and the axis itself is seen shortened.

    Parameters
    ----------
    R : Mat3
        Rotation body → world, shape (3, 3). Valid while the body x axis is not vertical.
    heading_rate : float
        Heading rate wanted [rad/s].

    Returns
    -------
    float
        Angular velocity about body z [rad/s]. Where the thrust axis is horizontal (|R33| below
        1e-6) no yaw rate does it, and 0 is returned.
    """
    ...


@yaw_rate_from_heading_rate.check
def alone_it_turns_the_heading(f: Function, rng: np.random.Generator) -> None:
    """Turning with this yaw rate, and no other, must change the heading at the rate asked for."""
    for _ in range(4):
        R, rate = draw.tilted(rng, 0.3, 1.0), draw.pace(rng)
        yaw = numbers(f(R, rate), ())
        turning, said = np.array((0.0, 0.0, yaw)), "With your yaw rate the heading turns otherwise."
        expect_heading_rate(rate, R, turning, message=said)


@exercise(points=3, reads="MRS Sec. 5.3, Sec. 3.4")
def parasitic_yaw_rate(R: Mat3, omega: Vec3) -> float:
    """Yaw rate that undoes the heading rate which the roll and pitch rates make.

    Rolling and pitching to follow a force also swings the nose. With this yaw rate in place of
    ``omega[2]`` the heading stands still. (MRS eq. (25) subtracts ω_c, so the ω_3c that is
    subtracted there has the other sign; this one is added.)

    Parameters
    ----------
    R : Mat3
        Rotation body → world, shape (3, 3). Valid while the body x axis is not vertical.
    omega : Vec3
        Angular velocity [rad/s], body, shape (3,). Its third entry does not matter.

    Returns
    -------
    float
        Angular velocity about body z [rad/s]. Where the thrust axis is horizontal (|R33| below
        1e-6) no yaw rate does it, and 0 is returned.
    """
    ...


@parasitic_yaw_rate.check
def the_heading_stands_still(f: Function, rng: np.random.Generator) -> None:
    """With this yaw rate beside the roll and pitch rates, the heading must stand still."""
    for _ in range(4):
        R, omega = draw.tilted(rng, 0.3, 1.0), draw.vector(rng, 2.0)
        yaw = numbers(f(R, omega), ())
        turning = np.array((omega[0], omega[1], yaw))
        expect_heading_rate(0.0, R, turning, message="With your yaw rate the heading still turns.")
