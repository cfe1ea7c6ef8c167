"""Lab 01, known wrong answers, the second half: motors and thrust curves."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab.exercises import draw
from uavlab.exercises.dynamics import (
    apparent_mass,
    force_from_throttle,
    motor_step,
    throttle_from_force,
)

CANARY = "canary-cfa3073cad0f3f5e9d13146d"

# motor_step -------------------------------------------------------------------------------------------


@sample(motor_step)
def gaps(rng: np.random.Generator) -> list[Arguments]:
    speeds = rng.uniform(100.0, 900.0, size=(6, 2, 4))
    taus = rng.uniform(0.02, 0.1, size=6)
    shares = (0.05, 0.3, 0.9, 1.4, 2.5, 5.0)
    return [
        (*x, float(tau), float(s * tau)) for x, tau, s in zip(speeds, taus, shares, strict=True)
    ]


@mutant(
    motor_step,
    hint="This is a step of Euler: right for short steps only. The gap shrinks by exp(−dt/τ).",
)
def euler_lag(speed, command, tau, dt):
    return speed + dt / tau * (command - speed)


@mutant(
    motor_step,
    hint="This is a step of Euler, stopped at the command: the exact one never quite arrives.",
)
def euler_lag_stopped(speed, command, tau, dt):
    return speed + min(dt / tau, 1.0) * (command - speed)


@mutant(
    motor_step, hint="This is the implicit step, dt / (τ + dt): near, but not the exact solution."
)
def implicit_lag(speed, command, tau, dt):
    return speed + dt / (tau + dt) * (command - speed)


@mutant(
    motor_step,
    hint="The shares are swapped: exp(−dt/τ) of the gap is left, it is not what is closed.",
)
def shares_swapped(speed, command, tau, dt):
    return speed + np.exp(-dt / tau) * (command - speed)


@mutant(motor_step, hint="τ is a time, not a rate: the exponent is −dt/τ.")
def tau_as_rate(speed, command, tau, dt):
    return command + (speed - command) * np.exp(-dt * tau)


@mutant(motor_step, hint="The exponent has the wrong sign: the gap grows instead of shrinking.")
def growing_gap(speed, command, tau, dt):
    return command + (speed - command) * np.exp(dt / tau)


@mutant(motor_step, hint="The motor has no lag: it is at the command at once.")
def no_lag(speed, command, tau, dt):
    return command


@mutant(
    motor_step,
    hint="The speed falls by itself, but the command does not pull it up: its share is missing.",
)
def command_missing(speed, command, tau, dt):
    return speed * np.exp(-dt / tau)


# throttle_from_force ----------------------------------------------------------------------------------


@sample(throttle_from_force)
def forces(rng: np.random.Generator) -> list[Arguments]:
    drawn = (*rng.uniform(2.0, 60.0, size=4), 1500.0, -float(rng.uniform(1.0, 20.0)))
    return [(float(f), *draw.thrust_curve(rng)) for f in drawn]


@mutant(
    throttle_from_force,
    hint="The square root is missing: throttle grows with rotor speed, force with its square.",
)
def no_root(f, a_t, b_t):
    return a_t * max(f, 0.0) + b_t


@mutant(throttle_from_force, hint="The offset b_t is added in (32); it has its sign already.")
def offset_subtracted(f, a_t, b_t):
    return a_t * np.sqrt(max(f, 0.0)) - b_t


@mutant(throttle_from_force, hint="The offset b_t is missing.")
def no_offset(f, a_t, b_t):
    return a_t * np.sqrt(max(f, 0.0))


@mutant(throttle_from_force, hint="The slope a_t stands before the square root, not under it.")
def slope_under_the_root(f, a_t, b_t):
    return np.sqrt(a_t * max(f, 0.0)) + b_t


@mutant(throttle_from_force, hint="This is the inverse: it makes a force of a throttle.")
def the_inverse(f, a_t, b_t):
    return max((f - b_t) / a_t, 0.0) ** 2


@mutant(
    throttle_from_force,
    hint="The throttle was clipped to [0, 1]: leave that to the caller, who wants to know.",
)
def clipped_throttle(f, a_t, b_t):
    return np.clip(a_t * np.sqrt(max(f, 0.0)) + b_t, 0.0, 1.0)


@mutant(throttle_from_force, hint="A force below zero has no square root: take it as zero.")
def root_of_a_pull(f, a_t, b_t):
    return a_t * np.sqrt(f) + b_t


@mutant(
    throttle_from_force,
    hint="A force below zero became a push: rotors cannot pull, take it as zero.",
)
def pull_taken_as_push(f, a_t, b_t):
    return a_t * np.sqrt(abs(f)) + b_t


# force_from_throttle ----------------------------------------------------------------------------------


@sample(force_from_throttle)
def throttles(rng: np.random.Generator) -> list[Arguments]:
    drawn = [(float(T), *draw.thrust_curve(rng)) for T in rng.uniform(0.05, 1.0, size=5)]
    return [*drawn, (-0.5 - float(rng.uniform(0.0, 0.3)), *draw.thrust_curve(rng))]


def force(T, a_t, b_t):
    return max((T - b_t) / a_t, 0.0) ** 2


@mutant(
    force_from_throttle,
    hint="The square is missing: rotor speed is (T − b_t)/a_t, force its square.",
)
def not_squared(T, a_t, b_t):
    return max((T - b_t) / a_t, 0.0)


@mutant(
    force_from_throttle, hint="The offset b_t must be subtracted before dividing: (32) adds it."
)
def offset_added(T, a_t, b_t):
    return max((T + b_t) / a_t, 0.0) ** 2


@mutant(
    force_from_throttle,
    hint="The slope a_t must be squared too: it stands outside the square root in (32).",
)
def slope_not_squared(T, a_t, b_t):
    return max(T - b_t, 0.0) ** 2 / a_t


@mutant(force_from_throttle, hint="Divide by the slope a_t instead of multiplying.")
def slope_multiplied(T, a_t, b_t):
    return (max(T - b_t, 0.0) * a_t) ** 2


@mutant(
    force_from_throttle,
    hint="Below b_t the parabola rises again, but the rotors stand still: the force there is zero.",
)
def other_branch(T, a_t, b_t):
    return ((T - b_t) / a_t) ** 2


@mutant(force_from_throttle, hint="This is (32) itself: it makes a throttle of a force.")
def the_curve_itself(T, a_t, b_t):
    return a_t * np.sqrt(T) + b_t


@mutant(force_from_throttle, hint="The offset b_t is missing.")
def force_without_offset(T, a_t, b_t):
    return max(T / a_t, 0.0) ** 2


# apparent_mass ----------------------------------------------------------------------------------------


@sample(apparent_mass)
def hovers(rng: np.random.Generator) -> list[Arguments]:
    return [(*x, float(rng.uniform(1.6, 24.0))) for x in throttles.draw(rng)]


@mutant(apparent_mass, hint="This is a force: divide by g for the mass.")
def weight_for_mass(T, a_t, b_t, g):
    return force(T, a_t, b_t)


@mutant(
    apparent_mass,
    hint="Divide by g instead of multiplying: less gravity lets the same force carry more.",
)
def gravity_multiplied(T, a_t, b_t, g):
    return force(T, a_t, b_t) * g


@mutant(
    apparent_mass, hint="Use the g that you are given, not 9.81: the aircraft may hover elsewhere."
)
def gravity_of_the_earth(T, a_t, b_t, g):
    return force(T, a_t, b_t) / 9.81


@mutant(
    apparent_mass,
    hint="Below b_t the parabola rises again, but the rotors stand still: they carry no mass.",
)
def mass_on_the_other_branch(T, a_t, b_t, g):
    return ((T - b_t) / a_t) ** 2 / g


@mutant(apparent_mass, hint="The square is missing: see (34).")
def mass_not_squared(T, a_t, b_t, g):
    return max((T - b_t) / a_t, 0.0) / g


@mutant(apparent_mass, hint="g stands outside the square in (34).")
def gravity_squared(T, a_t, b_t, g):
    return (max((T - b_t) / a_t, 0.0) / g) ** 2


@mutant(apparent_mass, hint="The offset b_t must be subtracted: (33) adds it.")
def mass_with_offset_added(T, a_t, b_t, g):
    return max((T + b_t) / a_t, 0.0) ** 2 / g
