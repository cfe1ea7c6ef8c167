"""Lab 05, known wrong answers: motors and thrust on the bench."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab.exercises import bench, draw
from uavlab.exercises.identification import (
    motor_time_constant,
    thrust_curve,
    thrust_polynomial,
)
from uavlab.solutions import identification as right

CANARY = "canary-be458f34dca1d2ba74154588"

# motor_time_constant ----------------------------------------------------------------------------------


@sample(motor_time_constant)
def steps(rng: np.random.Generator) -> list[Arguments]:
    """One step each, at the first sample, without noise: so that the ways to read it off agree."""
    drawn = []
    for low, high in ((200.0, 700.0), (300.0, 800.0), (750.0, 350.0), (100.0, 900.0)):
        tau, low = float(rng.uniform(0.03, 0.07)), low + float(rng.uniform(0.0, 50.0))
        t = 1.0 + np.linspace(0.0, 7.0 * tau, 300)
        command = np.full(300, high)
        drawn.append((t, command, bench.lag(t, command, tau, low)))
    return drawn


def crossing(t, command, speed, share):
    """Time from the first sample until so much of the step is done, between samples by a line."""
    done = (speed - speed[0]) / (command[-1] - speed[0])
    return float(np.interp(share, done, t - t[0]))


def slope_of_the_log(t, command, speed):
    gap = np.abs(command - speed)
    inside = gap > 0.02 * gap[0]
    return np.polyfit(t[inside], np.log(gap[inside]), 1)[0]


@mutant(
    motor_time_constant,
    hint="After one time constant 63 % of the step is done; 50 % is done after ln 2 of it.",
)
def half_of_the_step(t, command, speed):
    return crossing(t, command, speed, 0.5)


@mutant(
    motor_time_constant,
    hint="90 % of the step take 2.3 time constants: the rise time is not the time constant.",
)
def rise_time(t, command, speed):
    return crossing(t, command, speed, 0.9)


@mutant(
    motor_time_constant,
    hint="This is the time constant of log10: the gap shrinks by e, not by ten.",
)
def log_of_ten(t, command, speed):
    return -1.0 / (slope_of_the_log(t, command, speed) / np.log(10.0))


@mutant(motor_time_constant, hint="This is a rate in 1/s: the time constant is one over it.")
def rate_for_time(t, command, speed):
    return -slope_of_the_log(t, command, speed)


@mutant(
    motor_time_constant,
    hint="The logarithm of the wrong thing: it is the gap to the command that shrinks like exp(−t/τ), not the speed.",
)
def log_of_the_speed(t, command, speed):
    return 1.0 / abs(np.polyfit(t, np.log(speed), 1)[0])


@mutant(
    motor_time_constant,
    hint="Time must count from the step, not from where the clock began.",
)
def clock_time(t, command, speed):
    return t[0] + crossing(t, command, speed, 1.0 - np.exp(-1.0))


@mutant(
    motor_time_constant,
    hint="63 % of the end value is not 63 % of the step: the speed did not begin at zero.",
)
def share_of_the_end(t, command, speed):
    aim = (1.0 - np.exp(-1.0)) * command[-1]
    i = int(np.argmin(np.abs(speed - aim)))
    return float(t[i] - t[0])


@mutant(motor_time_constant, hint="The time constant has the wrong sign.")
def time_negated(t, command, speed):
    return -right.motor_time_constant(t, command, speed)


# thrust_polynomial ------------------------------------------------------------------------------------


@sample(thrust_polynomial)
def benches(rng: np.random.Generator) -> list[Arguments]:
    speeds = [rng.permutation(np.linspace(1.0, 9.0, n)) for n in (6, 9, 12, 15)]
    return [(x, 0.2 * x * x + 0.5 * x + rng.normal(size=len(x)) - 1.0) for x in speeds]


@mutant(
    thrust_polynomial, hint="The order is p_0, p_1, p_2: np.polyfit gives the highest power first."
)
def highest_first(speed, force):
    return np.polyfit(speed, force, 2)


@mutant(thrust_polynomial, hint="The constant p_0 is missing: the bench has an offset too.")
def through_the_origin(speed, force):
    x = np.linalg.lstsq(np.stack((speed, speed**2), 1), force, rcond=None)[0]
    return np.array((0.0, *x))


@mutant(
    thrust_polynomial,
    hint="The linear part is missing: the fit is a whole parabola, not only p_0 + p_2 speed².",
)
def no_linear_part(speed, force):
    x = np.linalg.lstsq(np.stack((np.ones_like(speed), speed**2), 1), force, rcond=None)[0]
    return np.array((x[0], 0.0, x[1]))


@mutant(
    thrust_polynomial,
    hint="The axes are swapped: force as a function of speed is asked for, the inverse of the paper's figure.",
)
def axes_swapped(speed, force):
    return np.polyfit(force, speed, 2)[::-1]


@mutant(
    thrust_polynomial,
    hint="A parabola through three of the points ignores the others: fit all of them.",
)
def through_three_points(speed, force):
    i = [0, len(speed) // 2, -1]
    return np.polyfit(speed[i], force[i], 2)[::-1]


@mutant(thrust_polynomial, hint="Only speed² is fitted: the parabola has three coefficients.")
def only_the_square(speed, force):
    return np.array((0.0, 0.0, speed**2 @ force / (speed**2 @ speed**2)))


@mutant(
    thrust_polynomial,
    hint="This is a straight line: the thrust grows with the square of the speed.",
)
def straight_line(speed, force):
    return np.array((*np.polyfit(speed, force, 1)[::-1], 0.0))


# thrust_curve -----------------------------------------------------------------------------------------


@sample(thrust_curve)
def hover_tests(rng: np.random.Generator) -> list[Arguments]:
    drawn = []
    for n in (4, 6, 9, 12):
        a_t, b_t = draw.thrust_curve(rng)
        mass = rng.uniform(1.0, 6.0, size=n)
        throttle = a_t * np.sqrt(9.81 * mass) + b_t + 0.02 * rng.normal(size=n)
        drawn.append((throttle, mass, float(rng.uniform(3.0, 10.0))))
    return drawn


@mutant(
    thrust_curve,
    hint="The square root is missing: throttle grows with the root of the force (33).",
)
def no_root(throttle, mass, g):
    return tuple(np.polyfit(mass * g, throttle, 1))


@mutant(thrust_curve, hint="The slope is one of force: put m g under the root, not m.")
def g_forgotten(throttle, mass, g):
    return tuple(np.polyfit(np.sqrt(mass), throttle, 1))


@mutant(
    thrust_curve,
    hint="This is the curve of one rotor of four: here the force of all rotors together is under the root.",
)
def of_one_rotor(throttle, mass, g):
    return tuple(np.polyfit(np.sqrt(mass * g / 4.0), throttle, 1))


@mutant(thrust_curve, hint="The offset b_t is missing: the line does not go through the origin.")
def no_offset(throttle, mass, g):
    root = np.sqrt(mass * g)
    return root @ throttle / (root @ root), 0.0


@mutant(thrust_curve, hint="The order is a_t, b_t: the slope first.")
def offset_first(throttle, mass, g):
    return tuple(np.polyfit(np.sqrt(mass * g), throttle, 1)[::-1])


@mutant(
    thrust_curve,
    hint="Only the first and the last hover are used: a fit listens to all of them.",
)
def two_hovers(throttle, mass, g):
    root = np.sqrt(mass * g)
    a_t = (throttle[-1] - throttle[0]) / (root[-1] - root[0])
    return a_t, throttle[0] - a_t * root[0]


@mutant(
    thrust_curve,
    hint="The residuals are taken in the force: least squares of the throttle is asked for.",
)
def fitted_backwards(throttle, mass, g):
    slope, at_zero = np.polyfit(throttle, np.sqrt(mass * g), 1)
    return 1.0 / slope, -at_zero / slope
