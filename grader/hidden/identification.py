"""Lab 05, hidden checks: known truths in noise, residuals square to the regressors, changes of unit and order."""

from __future__ import annotations

import numpy as np

from grader.hidden.identification_flight import *  # noqa: F403  (found here by their lab)
from grader.material import hidden
from uavlab import so3
from uavlab.exercises import bench, draw
from uavlab.exercises.expect import expect_record, expect_refusal
from uavlab.exercises.identification import (
    accelerometer_calibration,
    gyro_bias,
    motor_time_constant,
    thrust_curve,
    thrust_polynomial,
)
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.types import Array

CANARY = "canary-ff9ef27a49a8ce4b513eafaf"


def expect_square(M: Array, left: Array, message: str) -> None:
    """Fail the check unless the residuals are square to every regressor, as those of least squares are."""
    left = left.reshape(len(M), -1) / max(float(np.abs(left).max()), 1e-300)
    size = np.linalg.norm(M, axis=0)[:, None] * np.linalg.norm(left)
    cosines = M.T @ left / size
    expect(np.all(np.abs(cosines) < 1e-6), message)


# Sensors at rest --------------------------------------------------------------------------------------


def skewed(rng: np.random.Generator, spread: float, n: int = 80) -> Array:
    """Readings (n, 3) whose mean is not their median, with this standard deviation."""
    noise = rng.exponential(size=(n, 3))
    return spread * (noise - noise.mean(axis=0)) / noise.std(axis=0)


@hidden(gyro_bias)
def lopsided_noise(f: Function, rng: np.random.Generator) -> None:
    """Of lopsided noise the mean must be taken, and the order of the readings must not matter."""
    samples = draw.vector(rng, 0.1) + skewed(rng, 0.02) + rng.uniform(0.0, 0.01, size=3)
    expect_close(f(samples, 0.03), np.add.reduce(samples) / len(samples))
    expect_close(f(rng.permutation(samples), 0.03), np.add.reduce(samples) / len(samples))


@hidden(gyro_bias)
def a_large_bias_is_no_motion(f: Function, rng: np.random.Generator) -> None:
    """A bias however large is no motion: what counts is the spread about the mean, on each axis by itself."""
    bias = rng.uniform(0.5, 2.0, size=3) * rng.choice((-1.0, 1.0), size=3)
    expect_close(f(bias + skewed(rng, 0.03), 0.031), bias)


@hidden(gyro_bias, weight=2.0)
def a_slow_turn(f: Function, rng: np.random.Generator) -> None:
    """A turn that grows slowly, about any one axis, must raise ValueError."""
    for axis in range(3):
        bias = draw.vector(rng, 0.1)
        samples = bias + skewed(rng, 0.005)
        expect_close(f(samples, 0.006), bias)
        samples[:, axis] += np.linspace(-0.3, 0.3, len(samples)) * rng.choice((-1.0, 1.0))
        expect_refusal(f, samples, 0.1)


@hidden(gyro_bias, weight=0.5)
def a_reading_that_is_none(f: Function, rng: np.random.Generator) -> None:
    """A reading of NaN must raise ValueError, not become a bias."""
    bias = draw.vector(rng, 0.1)
    samples = bias + skewed(rng, 0.01)
    expect_close(f(samples, 0.02), bias)
    samples[int(rng.integers(len(samples))), int(rng.integers(3))] = np.nan
    expect_refusal(f, samples, 0.02)


@hidden(accelerometer_calibration, weight=2.0)
def best_in_noise(f: Function, rng: np.random.Generator) -> None:
    """With noise, T and b must be those of least squares, and near the truth."""
    made, R = bench.sensor(rng), bench.attitudes(rng, 24)
    samples = bench.at_rest(made, R) + 0.05 * rng.normal(size=(24, 3))
    T, b = expect_record(f(samples, R), (3, 3), (3,))
    expect(np.abs(T - made.T).max() < 0.03, "T is far from the truth.")
    expect(np.abs(b - made.b).max() < 0.15, "b is far from the truth.")
    M = np.column_stack((samples, -np.ones(24)))
    left = np.array([9.81 * turn[2] for turn in R]) - M @ np.vstack((T.T, T @ b))
    expect_square(M, left, "Another T and b leave a smaller sum of squares.")


@hidden(accelerometer_calibration)
def a_sensor_turned_in_its_mount(f: Function, rng: np.random.Generator) -> None:
    """A sensor that is turned in its mount, or reads in other units, must give the same specific force."""
    made, R = bench.sensor(rng), bench.attitudes(rng, 9)
    samples = bench.at_rest(made, R)
    Q, scale = draw.rotation(rng), float(rng.uniform(50.0, 200.0))
    T, b = expect_record(f(scale * samples @ Q.T, R), (3, 3), (3,))
    expect_close(scale * T @ Q, made.T, atol=1e-7)
    expect_close(Q.T @ b / scale, made.b, atol=1e-7)


@hidden(accelerometer_calibration)
def turned_about_the_vertical(f: Function, rng: np.random.Generator) -> None:
    """Neither the heading of an orientation nor the order of the orientations may change T or b."""
    made, R = bench.sensor(rng), bench.attitudes(rng, 8)
    samples, mix = bench.at_rest(made, R), rng.permutation(8)
    turned = np.array([so3.about_z(draw.angle(rng)) @ x for x in R])
    T, b = expect_record(f(samples[mix], turned[mix]), (3, 3), (3,))
    expect_close(T, made.T, atol=1e-7)
    expect_close(b, made.b, atol=1e-7)


@hidden(accelerometer_calibration, weight=0.5)
def not_enough_orientations(f: Function, rng: np.random.Generator) -> None:
    """Three orientations, or many about one level axis, must raise ValueError; four good ones must not."""
    made, R = bench.sensor(rng), bench.attitudes(rng, 4)
    expect_close(expect_record(f(bench.at_rest(made, R), R), (3, 3), (3,))[1], made.b, atol=1e-7)
    expect_refusal(f, bench.at_rest(made, R[:3]), R[:3])
    one = np.array([so3.exp(np.array((lean, 0.0, 0.0))) for lean in np.linspace(-1.5, 1.5, 9)])
    expect_refusal(f, bench.at_rest(made, one), one)


# Motors and thrust ------------------------------------------------------------------------------------


def stairs(rng: np.random.Generator, t: Array, every: float) -> Array:
    """Commands [rad/s] that jump up and down every so many seconds."""
    levels = rng.permutation(np.linspace(200.0, 900.0, 12)) + rng.uniform(-20.0, 20.0, size=12)
    return levels[np.floor((t - t[0]) / every).astype(int) % 12]


@hidden(motor_time_constant, weight=2.0)
def a_noisy_step(f: Function, rng: np.random.Generator) -> None:
    """From one step with noise of one percent the time constant must come out to five percent, up or down."""
    quick, slow = (
        rng.uniform(0.03, 0.045),
        rng.uniform(0.055, 0.07),
    )  # one guess for both must not do
    for side, span, tau in ((-1.0, 7.0, float(quick)), (1.0, 11.0, float(slow))):
        span, start = span * rng.uniform(0.9, 1.1), float(rng.uniform(450.0, 600.0))
        t = np.linspace(0.0, span * tau, 300)
        command = np.full(300, start + 400.0 * side)
        speed = bench.lag(t, command, tau, start) + 4.0 * rng.normal(size=300)
        expect_close(f(t, command, speed), tau, "The time constant is off.", atol=0.05 * tau)


@hidden(motor_time_constant)
def stairs_without_rest(f: Function, rng: np.random.Generator) -> None:
    """Steps up and down before the speed has settled, at uneven times, must serve as well."""
    tau = float(rng.uniform(0.03, 0.07))
    t = 5.0 + np.cumsum(rng.uniform(0.001, 0.005, size=250))
    command = stairs(rng, t, 1.3 * tau)
    speed = bench.lag(t, command, tau, float(rng.uniform(200.0, 900.0)))
    expect_close(f(t, command, speed), tau, atol=0.02 * tau)


@hidden(motor_time_constant)
def a_step_that_comes_late(f: Function, rng: np.random.Generator) -> None:
    """A step somewhere in the record must count from where it is, not from the first sample."""
    tau, low = float(rng.uniform(0.03, 0.07)), float(rng.uniform(200.0, 400.0))
    t = np.arange(0.0, 0.9, 0.003)
    command = np.where(t > rng.uniform(0.2, 0.4), low + 300.0, low)
    expect_close(f(t, command, bench.lag(t, command, tau, low)), tau, atol=0.02 * tau)


@hidden(motor_time_constant)
def another_clock_and_another_unit(f: Function, rng: np.random.Generator) -> None:
    """Time in milliseconds must make it a thousand times larger; speeds in rpm, or from an offset, change nothing."""
    tau, size = float(rng.uniform(0.03, 0.07)), float(rng.uniform(5.0, 12.0))
    t = np.linspace(0.0, rng.uniform(7.0, 12.0) * tau, 200)
    command = np.full(200, 800.0)
    speed = bench.lag(t, command, tau, 300.0)
    expect_close(f(1e3 * t, command, speed), 1e3 * tau, atol=10.0 * tau)
    expect_close(f(t, size * command - 900.0, size * speed - 900.0), tau, atol=0.01 * tau)


@hidden(motor_time_constant, weight=0.5)
def no_step_at_all(f: Function, rng: np.random.Generator) -> None:
    """A speed that is at its command all the time, or times that run backwards, must raise ValueError."""
    tau, t, start = 0.05, np.arange(0.0, 0.6, 0.003), float(rng.uniform(300.0, 600.0))
    command = np.full(len(t), start + 300.0)
    speed = bench.lag(t, command, tau, start)
    expect_close(f(t, command, speed), tau, atol=0.01 * tau)
    expect_refusal(f, t, command, command.copy())
    expect_refusal(f, t[::-1].copy(), command, speed)


def bench_of_forces(rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Speeds [rad/s] and noisy forces [N], each (n,), of a motor bench."""
    speed = rng.permutation(np.linspace(150.0, 950.0, n))
    force = 1e-5 * rng.uniform(0.5, 2.0) * speed**2 + 1e-3 * rng.uniform(-1.0, 1.0) * speed
    return speed, force + rng.uniform(-0.3, 0.3) + 0.1 * rng.normal(size=n)


@hidden(thrust_polynomial, weight=2.0)
def best_parabola(f: Function, rng: np.random.Generator) -> None:
    """With noise, the parabola must be the one of least squares in the force."""
    for n in (7, 20):
        speed, force = bench_of_forces(rng, n)
        p = numbers(f(speed, force), (3,))
        M = np.stack((np.ones(n), speed, speed**2), axis=1)
        expect_square(M, force - M @ p, "Another parabola leaves a smaller sum of squares.")


@hidden(thrust_polynomial)
def speed_in_other_units(f: Function, rng: np.random.Generator) -> None:
    """With speeds in other units, or forces in grams, it must be the same parabola."""
    speed, force = bench_of_forces(rng, 9)
    p = np.polynomial.Polynomial.fit(speed, force, 2).convert().coef
    s, w = float(rng.uniform(0.05, 0.2)), float(rng.uniform(5.0, 100.0))
    got = numbers(f(s * speed, w * force), (3,)) * (1.0, s, s * s) / w
    expect_close(got, p, "It is another parabola.", atol=1e-6)


@hidden(thrust_polynomial)
def every_point_counts(f: Function, rng: np.random.Generator) -> None:
    """Points told in another order must make the same parabola, and a point told twice must count twice."""
    speed, force = bench_of_forces(rng, 8)
    mix = rng.permutation(np.append(np.arange(8), 3))
    fine = np.polynomial.Polynomial.fit(speed[mix], force[mix], 2).convert().coef
    expect_close(f(speed[mix], force[mix]), fine, atol=1e-6)


@hidden(thrust_polynomial, weight=0.5)
def two_speeds_only(f: Function, rng: np.random.Generator) -> None:
    """Many readings at only two speeds must raise ValueError; at three they must not."""
    speed, force = bench_of_forces(rng, 9)
    three = np.repeat(speed[:3], 3)
    means = force.reshape(3, 3).mean(axis=1)
    p = numbers(f(three, force), (3,))
    expect_close(np.polyval(p[::-1], speed[:3]), means, atol=1e-6)
    expect_refusal(f, np.repeat(speed[:2], 5)[:9], force)


def hovers(rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """Throttles [1] and masses [kg], each (n,), of noisy hover tests."""
    a_t, b_t = draw.thrust_curve(rng)
    mass = rng.permutation(np.linspace(1.5, 6.0, n)) * rng.uniform(0.8, 1.2)
    return a_t * np.sqrt(9.81 * mass) + b_t + 0.02 * rng.normal(size=n), mass


@hidden(thrust_curve, weight=2.0)
def best_curve(f: Function, rng: np.random.Generator) -> None:
    """With noise, the curve must be the one of least squares in the throttle."""
    for n, g in ((5, 9.81), (12, 3.7)):
        throttle, mass = hovers(rng, n)
        x = np.array(expect_record(f(throttle, mass, g), (), ()))
        M = np.stack((np.sqrt(g * mass), np.ones(n)), axis=1)
        expect_square(M, throttle - M @ x, "Another curve leaves a smaller sum of squares.")


@hidden(thrust_curve)
def two_aircraft_that_exist(f: Function, rng: np.random.Generator) -> None:
    """From hover tests of two aircraft that exist, a T650 and a T18, the curves must come out that are flown with."""
    for n, mass, throttle, one in (
        (4, (3.6, 4.2, 4.78), (0.515, 0.59, 0.66), (0.32, -0.437)),
        (8, (7.30, 10.20, 13.15, 16.05), (0.3548, 0.4633, 0.5748, 0.6530), (0.20912, -0.27171)),
    ):
        mix = rng.permutation(len(mass))
        got = f(np.array(throttle)[mix], np.array(mass)[mix], 9.81)
        a_t, b_t = expect_record(got, (), ())
        expect(abs(a_t * np.sqrt(n) / one[0] - 1.0) < 0.05, "The slope is another one.")
        expect(abs(b_t / one[1] - 1.0) < 0.05, "The offset is another one.")


@hidden(thrust_curve)
def throttle_from_another_zero(f: Function, rng: np.random.Generator) -> None:
    """Throttle from another zero must move the offset, in percent it must scale both; order changes nothing."""
    throttle, mass = hovers(rng, 6)
    line = np.polyfit(np.sqrt(9.81 * mass), throttle, 1)
    mix, by = rng.permutation(6), float(rng.uniform(0.5, 2.0))
    expect_close(
        expect_record(f((throttle + by)[mix], mass[mix], 9.81), (), ()), (line[0], line[1] + by)
    )
    expect_close(expect_record(f(100.0 * throttle, mass, 9.81), (), ()), 100.0 * line, atol=1e-7)


@hidden(thrust_curve, weight=0.5)
def one_mass_only(f: Function, rng: np.random.Generator) -> None:
    """Hovers with one mass only must raise ValueError; with two they must not."""
    a_t, b_t = draw.thrust_curve(rng)
    mass = np.repeat(rng.uniform(1.0, 5.0) * np.array((1.0, 1.5)), 3)
    got = f(a_t * np.sqrt(9.81 * mass) + b_t, mass, 9.81)
    expect_close(expect_record(got, (), ()), (a_t, b_t))
    expect_refusal(f, rng.uniform(0.4, 0.5, size=5), np.full(5, mass[0]), 9.81)
