"""Lab 02, hidden checks: slopes, symmetries and closed forms up to 80 degrees of tilt and upside down, and flights."""

from __future__ import annotations

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.spatial.transform import Rotation

from grader.hidden.heading_exact import (  # noqa: F401  (found here by their lab)
    exact_compensation,
    exact_to_the_last_digits,
    exact_yaw_rate,
)
from grader.hidden.rollout import Swing, turn, wave
from grader.material import hidden
from uavlab import frames, so3
from uavlab.exercises import draw
from uavlab.exercises.expect import (
    expect_heading,
    expect_heading_rate,
    expect_rotation,
    expect_thrust_axis,
)
from uavlab.exercises.heading import (
    attitude_by_projection,
    attitude_with_heading,
    heading_rate,
    parasitic_yaw_rate,
    with_heading,
    yaw_rate_from_heading_rate,
)
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.types import Mat3, Vec3

CANARY = "canary-b257d339c88404ec312ccdb8"

TILTS = np.radians(((20.0, 40.0), (40.0, 60.0), (60.0, 80.0), (110.0, 150.0)))  # and upside down
FLIP = np.diag((1.0, -1.0, 1.0))  # left for right


@hidden(heading_rate)
def at_any_tilt(f: Function, rng: np.random.Generator) -> None:
    """The heading rate must be the derivative of the heading at large tilts too, and upside down."""
    for low, high in TILTS:
        R, omega = draw.aimed(rng, low, high), draw.vector(rng, 2.0)
        expect_heading_rate(f(R, omega), R, omega, atol=1e-5)


@hidden(heading_rate)
def across_the_seam(f: Function, rng: np.random.Generator) -> None:
    """Where the heading jumps from π to −π its rate must not jump, nor at any other heading."""
    R, omega = draw.aimed(rng, 0.3, 0.9), draw.vector(rng, 2.0)
    for eta in (np.pi, -np.pi + 1e-9, np.pi / 2, 0.0, -np.pi / 2):
        turned = so3.about_z(eta - frames.heading(R)) @ R
        expect_heading_rate(f(turned, omega), R, omega, atol=1e-5)


@hidden(heading_rate)
def rolling_does_nothing(f: Function, rng: np.random.Generator) -> None:
    """A turn about the body x axis cannot move that axis: the roll rate must not change the heading rate."""
    for low, high in TILTS:
        R, omega = draw.aimed(rng, low, high), draw.vector(rng, 2.0)
        rate = numbers(f(R, omega), ())
        rolled = omega + rng.uniform(1.0, 5.0) * np.eye(3)[0]
        expect_close(f(R, rolled), rate)
        expect_heading_rate(rate, R, omega, atol=1e-5)


@hidden(heading_rate)
def turning_about_the_vertical(f: Function, rng: np.random.Generator) -> None:
    """A body that turns about the world z axis changes its heading by exactly that, however it is tilted."""
    for low, high in TILTS:
        R, pace = draw.aimed(rng, low, high), float(rng.uniform(0.5, 3.0))
        expect_close(f(R, pace * R[2]), pace)
        omega = draw.vector(rng, 2.0)  # the vertical part of any turn would do above
        expect_heading_rate(f(R, omega), R, omega, atol=1e-5)


@hidden(heading_rate, weight=2.0)
def summed_over_a_flight(f: Function, rng: np.random.Generator) -> None:
    """Summed over a wild flight, the heading rate must give the change of the heading."""
    swing, yaw, dt = Swing(rng), wave(rng, 3.0), 0.008

    def rate(t: float, R: Mat3) -> Vec3:
        return swing.rate(t, R) + yaw(t) * np.eye(3)[2]

    flown = [(0.0, swing.R), *turn(swing.R, rate, dt=dt, steps=250)]
    rates = [numbers(f(R, rate(t, R)), ()) for t, R in flown]
    change = np.unwrap([frames.heading(R) for _, R in flown]) - frames.heading(swing.R)
    expect_close(cumulative_simpson(rates, dx=dt, initial=0.0), change, atol=5e-3)


@hidden(with_heading)
def a_turn_about_the_vertical(f: Function, rng: np.random.Generator) -> None:
    """The orientation must be turned about the world z axis, at large tilts and upside down too."""
    for (low, high), was in zip(TILTS, (-2.5, -1.0, 1.0, 2.5), strict=True):
        R, eta = draw.aimed(rng, low, high), draw.angle(rng)
        R = so3.about_z(was - frames.heading(R)) @ R
        between = Rotation.from_euler("z", eta - was)
        expect_close(f(R, eta), (between * Rotation.from_matrix(R)).as_matrix())


@hidden(with_heading)
def the_last_heading_counts(f: Function, rng: np.random.Generator) -> None:
    """Of two headings given one after the other only the last counts; its own heading changes nothing."""
    for low, high in TILTS:
        R, first, last = draw.aimed(rng, low, high), draw.angle(rng), draw.angle(rng)
        once = expect_rotation(f(R, last))
        expect_heading(once, last)
        expect_close(f(expect_rotation(f(R, first)), last), once)
        expect_close(f(R, frames.heading(R)), R)


@hidden(with_heading)
def any_number_of_turns(f: Function, rng: np.random.Generator) -> None:
    """A heading next to ±π, or some turns further, must work like any other."""
    for eta in (np.pi, -np.pi, np.pi - 1e-9, 7.5, -29.0):
        R = draw.aimed(rng, 0.2, 1.2)
        R = so3.about_z(eta + 0.5 - frames.heading(R)) @ R
        got = expect_rotation(f(R, eta))
        expect_heading(got, eta)
        expect_close(got[2], R[2])


@hidden(attitude_by_projection)
def dropped_at_right_angles(f: Function, rng: np.random.Generator) -> None:
    """The x axis must be the heading vector without its part along the thrust axis, at any tilt."""
    for low, high in TILTS:
        f_d, eta = draw.force(rng, low, high), draw.angle(rng)
        b3, h = f_d / np.linalg.norm(f_d), np.array((np.cos(eta), np.sin(eta), 0.0))
        flat = h - (h @ b3) * b3
        got = expect_rotation(f(f_d, eta))
        expect_thrust_axis(got, f_d)
        expect_close(got[:, 0], flat / np.linalg.norm(flat))


@hidden(attitude_by_projection)
def lee_in_a_turned_world(f: Function, rng: np.random.Generator) -> None:
    """Force and heading turned about the vertical must turn the attitude, and a stronger force must not."""
    for low, high in TILTS[:2]:
        f_d, eta, by = draw.force(rng, low, high), draw.angle(rng), draw.angle(rng)
        got = expect_rotation(f(f_d, eta))
        expect_thrust_axis(got, f_d)
        expect(got[:2, 0] @ (np.cos(eta), np.sin(eta)) > 0.0, "The x axis points backwards.")
        expect_close(f(so3.about_z(by) @ f_d, eta + by), so3.about_z(by) @ got)
        expect_close(f(float(rng.uniform(2.0, 9.0)) * f_d, eta), got)


@hidden(attitude_by_projection)
def lee_straight_up_and_sideways(f: Function, rng: np.random.Generator) -> None:
    """A lean towards the heading, or square to it, keeps the heading; the attitude is then a known turn."""
    for lean in rng.uniform(0.2, 1.2, size=2):
        eta = draw.angle(rng)
        for axis in ((0.0, lean, 0.0), (lean, 0.0, 0.0)):  # pitch, then roll
            R = so3.about_z(eta) @ so3.exp(np.array(axis))
            expect_close(f(20.0 * R[:, 2], eta), R)


@hidden(attitude_by_projection, weight=0.5)
def nothing_to_project(f: Function, rng: np.random.Generator) -> None:
    """A force of zero, or one along the heading vector, must raise ValueError; one beside it must not."""
    eta = draw.angle(rng)
    h = np.array((np.cos(eta), np.sin(eta), 0.0))
    beside = np.array((10.0 * h[0], 10.0 * h[1], 0.5))
    expect_thrust_axis(expect_rotation(f(beside, eta)), beside)
    expect_refusal(f, np.zeros(3), eta)
    expect_refusal(f, 10.0 * h, eta)


def expect_refusal(f: Function, f_d: Vec3, eta: float) -> None:
    """Fail the check unless the answer refuses; an answer that hangs or dies has not."""
    try:
        f(f_d, eta)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return
    expect(False, "It must raise ValueError.")


@hidden(attitude_with_heading, weight=2.0)
def both_at_any_tilt(f: Function, rng: np.random.Generator) -> None:
    """Thrust axis and heading must both be right, at tilts up to 80 degrees and at headings next to ±π."""
    for (low, high), eta in zip(TILTS[:3], (draw.angle(rng), np.pi - 1e-9, -np.pi), strict=True):
        for _ in range(2):
            f_d = draw.force(rng, low, high)
            got = expect_rotation(f(f_d, eta))
            expect_thrust_axis(got, f_d)
            expect_heading(got, eta)


@hidden(attitude_with_heading)
def in_the_mirror(f: Function, rng: np.random.Generator) -> None:
    """Left and right must be treated alike: the mirror image of force and heading asks for the mirror image."""
    for low, high in TILTS[:3]:
        f_d, eta = draw.force(rng, low, high), draw.angle(rng)
        got = expect_rotation(f(f_d, eta))
        expect_heading(got, eta)
        expect_thrust_axis(got, f_d)
        expect_close(f(FLIP @ f_d, -eta), FLIP @ got @ FLIP)


@hidden(attitude_with_heading)
def in_a_turned_world(f: Function, rng: np.random.Generator) -> None:
    """Force and heading turned about the vertical must turn the attitude, and a stronger force must not."""
    for low, high in TILTS[:2]:
        f_d, eta, by = draw.force(rng, low, high), draw.angle(rng), draw.angle(rng)
        got = expect_rotation(f(f_d, eta))
        expect_heading(got, eta)
        expect_close(f(so3.about_z(by) @ f_d, eta + by), so3.about_z(by) @ got)
        expect_close(f(float(rng.uniform(2.0, 9.0)) * f_d, eta), got)


@hidden(attitude_with_heading)
def upside_down(f: Function, rng: np.random.Generator) -> None:
    """With a force that points down the heading must be as asked for, not turned by 180 degrees."""
    for _ in range(3):
        f_d, eta = draw.force(rng, np.radians(110.0), np.radians(160.0)), draw.angle(rng)
        got = expect_rotation(f(f_d, eta))
        expect_thrust_axis(got, f_d)
        expect_heading(got, eta)


@hidden(attitude_with_heading, weight=0.5)
def no_such_attitude(f: Function, rng: np.random.Generator) -> None:
    """A force of zero, or a horizontal one, must raise ValueError; a steep one must not."""
    eta = draw.angle(rng)
    steep = draw.force(rng, np.radians(88.0), np.radians(89.0))
    got = expect_rotation(f(steep, eta))
    expect_thrust_axis(got, steep)
    expect_heading(got, eta)
    expect_refusal(f, np.zeros(3), eta)
    expect_refusal(f, 10.0 * so3.about_z(draw.angle(rng))[:, 0], eta)


@hidden(attitude_with_heading, weight=2.0)
def heading_held_on_a_fast_circle(f: Function, rng: np.random.Generator) -> None:
    """On a fast circle the aircraft that follows your attitude must keep its nose where it was told to."""
    eta, radius, speed = draw.angle(rng), 5.0, float(rng.uniform(7.0, 9.0))
    pace = speed / radius
    pull = speed**2 / radius

    def wanted(t: float) -> Mat3:
        force = so3.about_z(pace * t) @ (pull, 0.0, 9.81)  # per mass: to the centre, and up
        return expect_rotation(f(2.0 * force, eta))

    def follow(t: float, R: Mat3) -> Vec3:
        return 15.0 * so3.log(R.T @ wanted(t))

    off = [
        abs(frames.wrap(frames.heading(R) - eta))
        for _, R in turn(wanted(0.0), follow, dt=0.01, steps=300)
    ]
    expect(max(off) < np.radians(6.0), "The nose wandered off.")


@hidden(yaw_rate_from_heading_rate)
def makes_the_heading_rate(f: Function, rng: np.random.Generator) -> None:
    """Alone, the yaw rate must make the heading rate that was asked for, at large tilts and upside down."""
    for (low, high), side in zip(TILTS, (-1.0, 1.0, -1.0, 1.0), strict=True):
        R, pace = draw.aimed(rng, low, high), side * abs(draw.pace(rng))
        yaw = float(numbers(f(R, pace), ()))
        expect_heading_rate(pace, R, np.array((0.0, 0.0, yaw)), atol=1e-5)


@hidden(yaw_rate_from_heading_rate)
def twice_the_rate(f: Function, rng: np.random.Generator) -> None:
    """Twice the heading rate needs twice the yaw rate, the opposite one the opposite, and none needs none."""
    for low, high in TILTS[:3]:
        R, pace = draw.aimed(rng, low, high), draw.pace(rng)
        yaw = numbers(f(R, pace), ())
        expect_heading_rate(pace, R, np.array((0.0, 0.0, float(yaw))), atol=1e-5)
        expect_close(f(R, 2.0 * pace), 2.0 * yaw)
        expect_close(f(R, -pace), -yaw)
        expect_close(f(R, 0.0), 0.0)


@hidden(yaw_rate_from_heading_rate, weight=0.5)
def on_the_knife_edge(f: Function, rng: np.random.Generator) -> None:
    """With the thrust axis horizontal the yaw rate must be 0, and a little above the horizon it is large."""
    for _ in range(2):
        R, pace = draw.knife_edge(rng), draw.pace(rng)
        expect_close(f(R, pace), 0.0)
        above = R @ so3.exp(np.array((0.05, 0.0, 0.0)))
        yaw = float(numbers(f(above, pace), ()))
        expect_heading_rate(pace, above, np.array((0.0, 0.0, yaw)), atol=1e-3)


@hidden(yaw_rate_from_heading_rate, weight=2.0)
def follows_a_heading(f: Function, rng: np.random.Generator) -> None:
    """Flown for some seconds on a tilted aircraft, the yaw rate must take the heading where its rate leads."""
    pace = wave(rng, 3.0)

    def rate(t: float, R: Mat3) -> Vec3:
        return np.array((0.0, 0.0, float(numbers(f(R, pace(t)), ()))))

    start, dt = draw.tilted(rng, 0.5, 0.8), 0.01
    wanted = frames.heading(start)
    for t, R in turn(start, rate, dt=dt, steps=200):
        wanted += dt * pace(t - 0.5 * dt)
        off = abs(frames.wrap(frames.heading(R) - wanted))
        expect(off < 2e-3, "The heading went another way.")


@hidden(parasitic_yaw_rate)
def stands_still_at_any_tilt(f: Function, rng: np.random.Generator) -> None:
    """With this yaw rate the heading must stand still, at large tilts and upside down too."""
    for low, high in TILTS:
        R, omega = draw.aimed(rng, low, high), draw.vector(rng, 2.0)
        yaw = float(numbers(f(R, omega), ()))
        expect(abs(yaw) > 0.0, "There is something to undo.")
        expect_heading_rate(0.0, R, np.array((omega[0], omega[1], yaw)), atol=1e-5)


@hidden(parasitic_yaw_rate)
def only_the_pitch_rate_counts(f: Function, rng: np.random.Generator) -> None:
    """Neither the roll rate nor the yaw rate that the body already has may change the answer."""
    for low, high in TILTS[:3]:
        R, omega = draw.aimed(rng, low, high), draw.vector(rng, 2.0)
        yaw = numbers(f(R, omega), ())
        others = omega + rng.uniform(1.0, 3.0, size=3) * (1.0, 0.0, 1.0)
        expect_close(f(R, others), yaw)
        expect_heading_rate(0.0, R, np.array((omega[0], omega[1], float(yaw))), atol=1e-5)


@hidden(parasitic_yaw_rate, weight=0.5)
def nothing_helps_on_the_knife_edge(f: Function, rng: np.random.Generator) -> None:
    """With the thrust axis horizontal the answer must be 0, and a little above the horizon it is large."""
    for _ in range(2):
        R, omega = draw.knife_edge(rng), draw.vector(rng, 2.0)
        expect_close(f(R, omega), 0.0)
        above = R @ so3.exp(np.array((0.05, 0.0, 0.0)))
        yaw = float(numbers(f(above, omega), ()))
        expect_heading_rate(0.0, above, np.array((*omega[:2], yaw)), atol=1e-3)


@hidden(parasitic_yaw_rate, weight=2.0)
def heading_held_in_a_wild_flight(f: Function, rng: np.random.Generator) -> None:
    """Flown through fast rolls and pitches, the aircraft must keep its heading with this yaw rate alone."""
    swing = Swing(rng)

    def rate(t: float, R: Mat3) -> Vec3:
        omega = swing.rate(t, R) + 0.3 * np.eye(3)[2]
        omega[2] = float(numbers(f(R, omega), ()))
        return omega

    for _, R in turn(swing.R, rate, dt=0.008, steps=250):
        off = abs(frames.wrap(frames.heading(R) - frames.heading(swing.R)))
        expect(off < 5e-3, "The nose wandered off.")
