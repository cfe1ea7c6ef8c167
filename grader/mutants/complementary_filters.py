"""Lab 04, known wrong answers, the second part: the two velocity-aided filters.

Each is the right filter with one thing wrong, and the samples take tiny steps: so a mistake is known again whatever
way of stepping stands around it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from grader.material import Arguments, Mutant, mutant, sample
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.complementary import body_filter_step, inertial_filter_step
from uavlab.exercises.paths import FIELD
from uavlab.exercises.spec import Exercise
from uavlab.types import GRAVITY, AidedGains, BodyMemory, Imu, InertialMemory, Pull

CANARY = "canary-0f24c33fb8a31151b5fd3f4b"

TINY = 1e-5  # [s]
E3 = np.array((0.0, 0.0, 1.0))


def cases(kind: Any, rng: np.random.Generator) -> list[Arguments]:
    """A filter that is off in everything; at the end without a velocity, and without a magnetometer."""
    drawn = []
    for k in range(6):
        R = draw.tilted(rng, 0.4, 1.0)
        small = rng.uniform(0.1, 0.3, size=(2, 3))
        x = kind(draw.vector(rng), R, float(rng.uniform(0.7, 0.9)), *small)
        imu = Imu(0.0, draw.vector(rng, 2.0) + GRAVITY * E3, draw.vector(rng, 2.0))
        m = (R @ draw.tilted(rng, 0.4, 0.8)).T @ FIELD
        gains = AidedGains(*rng.uniform(0.7, 1.3, size=7) * (4.0, 0.2, 0.2, 9.0, 0.7, 0.2, 0.7))
        named = {"m_W": FIELD, "gains": gains, "pull": Pull(*rng.normal(size=(3, 3)))}
        seen = x[0] + rng.uniform(0.5, 1.5, size=3)
        drawn.append((x, imu, None if k == 4 else seen, None if k == 5 else m, TINY, named))
    return drawn


@sample(body_filter_step)
def in_the_body(rng: np.random.Generator) -> list[Arguments]:
    return cases(BodyMemory, rng)


@sample(inertial_filter_step)
def in_the_world(rng: np.random.Generator) -> list[Arguments]:
    return cases(InertialMemory, rng)


def compass(x, m, m_W, gains, wrong):
    """Δ^μ, with what may be wrong in it."""
    if m is None:
        return np.zeros(3)
    up, twist = x.u * x.R[2], np.cross(m, m_W if "field" in wrong else x.R.T @ m_W)
    if "flipped" in wrong:
        twist = -twist
    return gains.k_m * (twist if "whole" in wrong else (twist @ up) * up)


def step(x, imu, seen, m, dt, *, m_W, gains, pull, wrong):
    """Filter 1 or 2, after what `x` is; `wrong` names what is wrong in it."""
    v, R, u, b_a, b_omega = x
    body, g = isinstance(x, BodyMemory), GRAVITY
    if seen is None:
        seen = np.zeros(3) if "zero" in wrong else v
    e = v - seen
    e_W = R @ e if body and "untold" not in wrong else e
    omega = imu.gyro - (0 if "gyro bias" in wrong else b_omega)
    d_v, d_r = gains.k_v * e, -g / (1 if "no u" in wrong else u) * np.cross(e_W, E3)
    d_r = -d_r if "tilt" in wrong else d_r
    d_m = compass(x, m, m_W, gains, wrong)
    weight = g * (1.0 if "weight" in wrong else u) * (-1.0 if "down" in wrong else 1.0)
    if body:
        spin = {"no turn": 0.0, "turn": -1.0}.get(next(iter(wrong), ""), 1.0)
        v_dot = spin * np.cross(v, omega) + imu.accel - b_a - weight * R[2] - d_v + pull.v_dot
    else:
        v_dot = (imu.accel - b_a if "accel" in wrong else R @ (imu.accel - b_a)) - d_v + pull.v_dot
        v_dot = v_dot - weight * E3
    u_dot = gains.k_u * g * (seen if "measured" in wrong else e_W)[2]
    u_dot = -u_dot if "u" in wrong else u_dot
    b_a_dot = gains.k_b_a * (d_v if body or "b_a world" in wrong else R.T @ d_v)
    b_a_dot = (-b_a_dot if "b_a" in wrong else b_a_dot) + pull.b_a_dot
    b_omega_dot = gains.k_b_omega * (d_r if "b_omega world" in wrong else R.T @ d_r)
    b_omega_dot = -b_omega_dot if "b_omega" in wrong else b_omega_dot
    b_omega_dot = b_omega_dot - (0.0 if "no compass" in wrong else gains.k_b_m * d_m)
    turn = R @ pull.turn if "pull" in wrong else pull.turn
    R_new = so3.exp(dt * (turn - gains.k_r * d_r)) @ R @ so3.exp(dt * (omega + d_m))
    rest = u + dt * u_dot, b_a + dt * b_a_dot, b_omega + dt * b_omega_dot
    return type(x)(v + dt * v_dot, R_new, *rest)


def known(exercise: Exercise, name: str, hint: str) -> Mutant:
    """The filter of `exercise` with the mistake `name`, one of those that `step` knows."""

    def run(memory, imu, seen, m_meas, dt, *, m_W, gains, pull):
        given = {"m_W": m_W, "gains": gains, "pull": pull, "wrong": {name}}
        return step(memory, imu, seen, m_meas, dt, **given)

    run.__name__ = name.replace(" ", "_")
    return mutant(exercise, hint=hint)(run)


# Filter 1 ---------------------------------------------------------------------------------------------

ONE = body_filter_step
one_1 = known(
    ONE,
    "b_omega world",
    "(6f) is taken as printed: Δ^r is told in the world, the gyro bias in the body.",
)
one_2 = known(ONE, "b_omega", "The gyro bias follows Δ^r with the wrong sign, and runs away.")
one_3 = known(
    ONE, "tilt", "The tilt is turned the wrong way: with z up, Δ^r of (7b) changes its sign."
)
one_4 = known(
    ONE, "down", "Gravity has the sign of the paper, whose z points down: here it is −g e_3."
)
one_5 = known(
    ONE, "no turn", "The term −Ω × V is missing: told in the body, a velocity turns with it."
)
one_6 = known(ONE, "turn", "The term −Ω × V has the wrong sign: it is V × Ω.")
one_7 = known(
    ONE,
    "weight",
    "u is missing in front of gravity: (6a) has X^T e_3, and X is u R. So u acts on nothing.",
)
one_8 = known(ONE, "u", "The scaling runs away: with z up, (6d) changes its sign.")
one_9 = known(
    ONE,
    "no compass",
    "The magnetometer is missing in the gyro bias: its vertical part is never found.",
)
one_10 = known(
    ONE, "flipped", "The magnetometer turns the wrong way: (7c) has measured × expected, μ × μ̂."
)
one_11 = known(
    ONE,
    "whole",
    "The magnetometer also tilts: (7c) keeps only the part along the vertical, X^T e_3.",
)
one_12 = known(ONE, "no u", "Δ^r of (7b) lacks the division by u.")
one_13 = known(ONE, "b_a", "The accelerometer bias follows Δ^v with the wrong sign, and runs away.")
one_14 = known(
    ONE,
    "untold",
    "The velocity error is told in the body: (6d) and (7b) need it in the world, R Ṽ.",
)
one_15 = known(
    ONE, "zero", "A velocity that was not measured is taken for 0: None means no innovation."
)
one_16 = known(ONE, "gyro bias", "The gyro bias is not taken off the gyro.")
one_17 = known(
    ONE, "pull", "The pull on the attitude is told in the world: it stands on the left of R."
)
one_18 = known(
    ONE, "field", "The expected field is told in the world: μ̂ is R^T m_W, in the body like μ."
)

# Filter 2 ---------------------------------------------------------------------------------------------

TWO = inertial_filter_step
two_1 = known(
    TWO,
    "weight",
    "(9a) is taken as printed: without u in front of gravity the scaling acts on nothing.",
)
two_2 = known(
    TWO,
    "measured",
    "(9d) is taken as printed: with the measured velocity u integrates the climb. Take v̂ − v.",
)
two_3 = known(
    TWO,
    "b_a world",
    "(9f) is taken as printed: Δ^v is told in the world, the accelerometer bias in the body.",
)
two_4 = known(
    TWO,
    "b_omega world",
    "(9g) is taken as printed: Δ^r is told in the world, the gyro bias in the body.",
)
two_5 = known(
    TWO, "tilt", "The tilt is turned the wrong way: with z up, Δ^r of (10a) changes its sign."
)
two_6 = known(TWO, "down", "Gravity has the sign of the paper, whose z points down: here −u g e_3.")
two_7 = known(TWO, "u", "The scaling runs away: with z up, (9d) changes its sign.")
two_8 = known(TWO, "accel", "The specific force is told in the body: turn it into the world first.")
two_9 = known(
    TWO,
    "no compass",
    "The magnetometer is missing in the gyro bias: its vertical part is never found.",
)
two_10 = known(
    TWO, "flipped", "The magnetometer turns the wrong way: (10c) has measured × expected, μ × μ̂."
)
two_11 = known(
    TWO,
    "whole",
    "The magnetometer also tilts: (10c) keeps only the part along the vertical, X^T e_3.",
)
two_12 = known(TWO, "no u", "Δ^r of (10a) lacks the division by u.")
two_13 = known(
    TWO, "b_omega", "The gyro bias follows Δ^r with the wrong sign: with z up, that changes too."
)
two_14 = known(
    TWO,
    "zero",
    "A velocity that has dropped out is taken for 0: None means no innovation, for u neither.",
)
two_15 = known(TWO, "b_a", "The accelerometer bias follows Δ^v with the wrong sign, and runs away.")
