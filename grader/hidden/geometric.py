"""Lab 07, hidden checks: errors, forces and rates, by slopes, in turned worlds, in closed form, and along curves."""

from __future__ import annotations

import numpy as np

from grader.hidden.geometric_flown import *  # noqa: F403  the controller
from grader.hidden.geometric_learned import *  # noqa: F403  disturbances, mass, a_d
from grader.hidden.geometric_torque import *  # noqa: F403  torque and limits
from grader.hidden.rollout import turn
from grader.material import hidden
from uavlab import frames, so3
from uavlab.exercises import draw
from uavlab.exercises.expect import expect_heading_rate, expect_refusal
from uavlab.exercises.geometric import (
    attitude_error,
    desired_force,
    jerk_feedforward,
    rate_command,
)
from uavlab.exercises.geometric_checks import UP, ZERO, some_estimate, some_gains, some_mass
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.frames import Shift
from uavlab.types import GRAVITY, Mat3, Vec3

CANARY = "canary-5b3ed9c17f2a4086be91d4a7"

EXACT = 1e-11  # what a formula reaches and a quotient of differences does not

# attitude_error ---------------------------------------------------------------------------------------


@hidden(attitude_error, weight=2.0)
def sine_of_the_angle(f: Function, rng: np.random.Generator) -> None:
    """For any angle it must lie along the axis of the turn, as long as the sine of the angle."""
    for angle in (0.3, 1.0, np.pi / 2, 2.0, 2.9):
        R_d, n = draw.rotation(rng), draw.direction(rng)
        expect_close(f(R_d @ so3.exp(angle * n), R_d), np.sin(angle) * n, atol=EXACT)


@hidden(attitude_error)
def slope_of_the_misalignment(f: Function, rng: np.random.Generator) -> None:
    """As the body turns, the cosines that are missing between the axes must grow by rates times error."""
    for _ in range(4):
        R, R_d, omega, h = draw.rotation(rng), draw.rotation(rng), draw.vector(rng), 1e-5

        def missing(t: float, R: Mat3 = R, R_d: Mat3 = R_d, omega: Vec3 = omega) -> float:
            return 0.5 * (3.0 - float(np.sum(R_d * (R @ so3.exp(t * omega)))))

        slope = (missing(h) - missing(-h)) / (2.0 * h)
        expect_close(numbers(f(R, R_d), (3,)) @ omega, slope, atol=1e-7)


@hidden(attitude_error)
def the_way_back(f: Function, rng: np.random.Generator) -> None:
    """With both attitudes exchanged the error must be the opposite one, and in a turned world the same."""
    for _ in range(3):
        R, R_d, Q = (draw.rotation(rng) for _ in range(3))
        got = numbers(f(R, R_d), (3,))
        expect(float(np.linalg.norm(got)) > 1e-9, "They are not the same.")
        expect_close(got, np.sin(so3.angle(R, R_d)) * unit(so3.log(R_d.T @ R)), atol=1e-7)
        expect_close(f(R_d, R), -got)
        expect_close(f(Q @ R, Q @ R_d), got)


def unit(x: Vec3) -> Vec3:
    """Direction of a vector."""
    return x / np.linalg.norm(x)


# desired_force ----------------------------------------------------------------------------------------


@hidden(desired_force, weight=2.0)
def told_in_another_world(f: Function, rng: np.random.Generator) -> None:
    """In a turned and shifted world the force must be turned, and what turns with the nose stays what it is."""
    for _ in range(3):
        k, x, y, m = some_gains(rng), some_estimate(rng), draw.reference(rng), some_mass(rng)
        k = k._replace(k_p=(k.k_p[0],) * 2 + k.k_p[2:], k_v=(k.k_v[0],) * 2 + k.k_v[2:])
        d_w, d_b, shift = draw.vector(rng, 3.0), draw.vector(rng, 3.0), Shift(draw.vector(rng), 0.0)
        shift = shift._replace(heading=draw.angle(rng))
        got = numbers(f(x, y, m, d_w, d_b, k), (3,))
        Rz = so3.about_z(shift.heading)
        there = f(frames.moved(x, shift), frames.moved(y, shift), m, Rz @ d_w, d_b, k)
        expect_close(there, Rz @ got)
        pull = k.k_p * (x.r - y.r) + k.k_v * (x.v - y.v)
        expect_close(got, m * (y.a - pull + GRAVITY * UP) - flat(d_w + nose(x.R) @ d_b))


def flat(x: Vec3) -> Vec3:
    """The horizontal part of a vector."""
    return x * (1.0, 1.0, 0.0)


def nose(R: Mat3) -> Mat3:
    """From the frame of the heading of `R` to the world."""
    x, y = R[:2, 0] / np.hypot(*R[:2, 0])
    return np.array(((x, -y, 0.0), (y, x, 0.0), (0.0, 0.0, 1.0)))


@hidden(desired_force, weight=2.0)
def twice_the_mass(f: Function, rng: np.random.Generator) -> None:
    """Twice the mass must ask for twice the force, but for the disturbances, which are forces already."""
    for _ in range(3):
        k, x, y, m = some_gains(rng), some_estimate(rng), draw.reference(rng), some_mass(rng)
        d_w, d_b = draw.vector(rng, 3.0), draw.vector(rng, 3.0)
        d = flat(d_w + nose(x.R) @ d_b)
        once, twice = (numbers(f(x, y, s * m, d_w, d_b, k), (3,)) + d for s in (1.0, 2.0))
        expect_close(twice, 2.0 * once)
        a = y.a - np.multiply(k.k_p, x.r - y.r) - np.multiply(k.k_v, x.v - y.v)
        expect_close(once / m - GRAVITY * UP, a)


@hidden(desired_force)
def a_push_along_the_nose(f: Function, rng: np.random.Generator) -> None:
    """What turns with the nose must be taken off along the nose of now, not of the reference, and level."""
    for _ in range(3):
        k, x, y, m = some_gains(rng), some_estimate(rng), draw.reference(rng), some_mass(rng)
        ahead, up = float(rng.uniform(1.0, 4.0)), float(rng.uniform(1.0, 4.0))
        without = numbers(f(x, y, m, ZERO, ZERO, k), (3,))
        got = numbers(f(x, y, m, up * UP, np.array((ahead, 0.0, up)), k), (3,))
        expect_close(without - got, ahead * unit(flat(x.R[:, 0])))


# jerk_feedforward -------------------------------------------------------------------------------------


@hidden(jerk_feedforward, weight=2.0)
def flown_along_a_curve(f: Function, rng: np.random.Generator) -> None:
    """Flown round a fast circle with these rates alone, the thrust axis must stay along the force."""
    speed, radius, m, eta = rng.uniform(6.0, 8.0), 5.0, some_mass(rng), draw.angle(rng)
    pace, pull = speed / radius, speed**2 / radius

    def force(t: float) -> Vec3:
        return m * (so3.about_z(pace * t + eta) @ (-pull, 0.0, GRAVITY))

    def rate(t: float, R: Mat3) -> Vec3:
        jerk = so3.about_z(pace * t + eta) @ (0.0, -pace * pull, 0.0)
        return numbers(f(force(t), m, R, jerk), (3,))

    start = so3.about_z(eta) @ so3.exp(np.array((0.0, -np.arctan2(pull, GRAVITY), 0.0)))
    for t, R in turn(start @ so3.about_z(draw.angle(rng)), rate, dt=0.02, steps=110):
        off = np.linalg.norm(np.cross(R[:, 2], unit(force(t))))
        expect(off < 2e-3, "The thrust axis left the force.")


@hidden(jerk_feedforward)
def any_turn_about_the_axis(f: Function, rng: np.random.Generator) -> None:
    """Turned about the thrust axis, the wanted attitude must give the same turn, told in its own axes."""
    for _ in range(3):
        R_d, m, jerk, by = draw.rotation(rng), some_mass(rng), draw.vector(rng), draw.angle(rng)
        force = rng.uniform(10.0, 60.0) * R_d[:, 2]
        got = numbers(f(force, m, R_d, jerk), (3,))
        spun = R_d @ so3.about_z(by)
        expect_close(spun @ numbers(f(force, m, spun, jerk), (3,)), R_d @ got)
        expect(float(np.linalg.norm(got)) > 0.0, "There is a jerk.")
        swing = jerk - R_d[:, 2] * (R_d[:, 2] @ jerk)
        turned = np.cross(R_d @ got, force) / m
        expect_close(turned, swing, "The force changes otherwise.", atol=EXACT)


@hidden(jerk_feedforward)
def more_thrust_turns_less(f: Function, rng: np.random.Generator) -> None:
    """Twice the jerk or mass must turn twice as fast, twice the force half as fast; a jerk along it, not at all."""
    for _ in range(3):
        R_d, m, jerk = draw.rotation(rng), some_mass(rng), draw.vector(rng)
        force = rng.uniform(10.0, 60.0) * R_d[:, 2]
        got = numbers(f(force, m, R_d, jerk), (3,))
        expect(float(np.linalg.norm(got)) > 0.0, "There is a jerk.")
        expect_close(
            np.linalg.norm(force) * np.linalg.norm(got),
            m * np.linalg.norm(np.cross(R_d[:, 2], jerk)),
        )
        expect_close(f(force, m, R_d, 2.0 * jerk), 2.0 * got)
        expect_close(f(force, 2.0 * m, R_d, jerk), 2.0 * got)
        expect_close(f(2.0 * force, m, R_d, jerk), 0.5 * got)
        expect_close(f(force, m, R_d, 3.0 * R_d[:, 2]), ZERO)


@hidden(jerk_feedforward, weight=0.5)
def nothing_to_turn(f: Function, rng: np.random.Generator) -> None:
    """A force of zero must raise ValueError; a small one must not."""
    R_d, m, jerk = draw.rotation(rng), some_mass(rng), ZERO
    for _ in range(2):
        jerk = draw.vector(rng)
        got = numbers(f(0.1 * R_d[:, 2], m, R_d, jerk), (3,))
        expect_close(got[:2] * 0.1, m * np.array((-jerk @ R_d[:, 1], jerk @ R_d[:, 0])))
    expect_refusal(f, ZERO, m, R_d, jerk)


# rate_command -----------------------------------------------------------------------------------------


def of_heading(R: Mat3, rate: float) -> float:
    """Yaw rate that makes a heading rate, in closed form."""
    return rate * (1.0 - R[2, 0] ** 2) / R[2, 2]


def some_rates(rng: np.random.Generator) -> tuple[Mat3, Mat3, float, Vec3, Vec3]:
    """Arguments of a rate command: attitudes half a radian apart, and the rest."""
    R_d = draw.aimed(rng, 0.3, 0.7)
    R = R_d @ so3.exp(rng.uniform(0.2, 0.5) * draw.direction(rng))
    return R, R_d, draw.pace(rng), draw.vector(rng) * (1.0, 1.0, 0.0), rng.uniform(3.0, 8.0, size=3)


@hidden(rate_command, weight=3.0)
def every_term(f: Function, rng: np.random.Generator) -> None:
    """Off the wanted attitude, with all that (25) and Sec. 5.2 and 5.3 ask for, the rates must be exact."""
    for _ in range(4):
        R, R_d, rate, omega_j, k_R = some_rates(rng)
        S = R_d.T @ R
        want = omega_j - k_R * so3.vee(S - S.T) / 2.0
        want[2] += of_heading(R_d, rate) - want[1] * R[2, 1] / R[2, 2]
        expect_close(f(R, R_d, rate, omega_j, k_R), want, atol=EXACT)


@hidden(rate_command)
def nothing_swings_the_nose(f: Function, rng: np.random.Generator) -> None:
    """What roll and pitch make of the heading must be undone, to the last bit of it, where the aircraft is now."""
    for _ in range(4):
        R, R_d, _, omega_j, k_R = some_rates(rng)
        k_R = k_R * (1.0, 1.0, 0.0)  # no yaw but that one
        got = numbers(f(R, R_d, 0.0, omega_j, k_R), (3,))
        expect(float(np.linalg.norm(got[:2])) > 1e-6, "It must roll or pitch.")
        expect_heading_rate(0.0, R, got, atol=1e-5, message="The nose swings.")
        expect_close(got[:2] - omega_j[:2], (f_rolls(R, R_d) * k_R)[:2])


def f_rolls(R: Mat3, R_d: Mat3) -> Vec3:
    """What (24) and a gain of one ask for."""
    w = so3.log(R.T @ R_d)
    angle = float(np.linalg.norm(w))
    return w * np.sin(angle) / angle


@hidden(rate_command)
def the_wanted_attitude_turns_the_nose(f: Function, rng: np.random.Generator) -> None:
    """The wanted heading rate must add the yaw rate that makes it on the wanted attitude, and nothing else."""
    for _ in range(4):
        R, R_d, rate, omega_j, k_R = some_rates(rng)
        more = numbers(f(R, R_d, rate, omega_j, k_R), (3,)) - f(R, R_d, 0.0, omega_j, k_R)
        expect_close(more[:2], np.zeros(2))
        expect_heading_rate(rate, R_d, more, atol=1e-5, message="It makes another rate.")


@hidden(rate_command, weight=2.0)
def round_the_circle(f: Function, rng: np.random.Generator) -> None:
    """Along the attitudes of a fast circle, from a start that is off, it must catch up and keep axis and nose."""
    pace, pull, eta, spin = (
        rng.uniform(1.2, 1.5),
        rng.uniform(7.0, 10.0),
        draw.angle(rng),
        draw.pace(rng),
    )
    spin, k_R = 0.5 * spin, rng.uniform(5.0, 7.0, size=3)

    def at(t: float) -> tuple[Mat3, Vec3]:
        a = so3.about_z(pace * t) @ (-pull, 0.0, GRAVITY)
        b, h = unit(a), eta + spin * t
        c, s = np.cos(h), np.sin(h)
        x = unit(np.array((c, s, -(b[0] * c + b[1] * s) / b[2])))
        R_d = np.column_stack((x, np.cross(b, x), b))
        j = R_d.T @ so3.about_z(pace * t) @ (0.0, -pace * pull, 0.0) / np.linalg.norm(a)
        return R_d, np.array((-j[1], j[0], 0.0))

    def rate(t: float, R: Mat3) -> Vec3:
        R_d, omega_j = at(t)
        return numbers(f(R, R_d, spin, omega_j, k_R), (3,))

    start = at(0.0)[0] @ so3.exp(0.2 * draw.direction(rng))
    for t, R in turn(start, rate, dt=0.02, steps=110):
        off = so3.angle(R, at(t)[0])
        expect(t < 1.8 or off < 0.01, "It did not catch up.")


@hidden(rate_command, weight=0.5)
def wanted_on_the_knife_edge(f: Function, rng: np.random.Generator) -> None:
    """Where the wanted thrust axis is horizontal the heading rate adds nothing; a little above, it adds much."""
    for _ in range(2):
        R, R_d, rate, k_R = (
            draw.aimed(rng, 0.2, 0.6),
            draw.knife_edge(rng),
            draw.pace(rng),
            np.ones(3),
        )
        expect_close(numbers(f(R, R_d, rate, ZERO, k_R), (3,)) - f(R, R_d, 0.0, ZERO, k_R), ZERO)
        above = R_d @ so3.exp(np.array((0.05, 0.0, 0.0)))
        more = numbers(f(R, above, rate, ZERO, k_R), (3,)) - f(R, above, 0.0, ZERO, k_R)
        expect_heading_rate(rate, above, more, atol=1e-3)
