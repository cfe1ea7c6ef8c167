"""Lab 04, known wrong answers, the last part: the attitude filter."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab.exercises import draw
from uavlab.exercises.complementary import attitude_step
from uavlab.solutions import complementary as right

CANARY = "canary-99e392793862827f4a4565ae"

# attitude_step ----------------------------------------------------------------------------------------


@sample(attitude_step)
def attitudes(rng: np.random.Generator) -> list[Arguments]:
    drawn = []
    for _ in range(5):
        q, q_meas = rng.normal(size=(2, 4))
        q, q_meas = q / np.linalg.norm(q), q_meas / np.linalg.norm(q_meas)
        gain, dt = float(rng.uniform(1.0, 8.0)), float(rng.uniform(0.05, 0.2))
        drawn.append((q, draw.vector(rng, 3.0), q_meas, gain, dt))
    return drawn


def product(p, q):
    """Hamilton product."""
    v = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.append(p[0] * q[0] - p[1:] @ q[1:], v)


def conjugate(q):
    return q * (1, -1, -1, -1)


def turn(w):
    """Quaternion of a rotation vector."""
    a = np.linalg.norm(w)
    return np.append(np.cos(a / 2), np.sin(a / 2) / a * w) if a else np.eye(4)[0]


def unit(q):
    return q / np.linalg.norm(q)


def euler(q, rate, dt):
    return q + 0.5 * dt * product(q, np.append(0.0, rate))


def innovation(q, q_meas):
    """2 δq_s δq_v."""
    d = product(conjugate(q), q_meas)
    return 2.0 * d[0] * d[1:]


@mutant(
    attitude_step,
    hint="This is one explicit Euler step of (12): with a large gain or dt it overshoots. Solve for the error angle.",
)
def one_euler_step(q, omega, q_meas, gain, dt):
    return unit(euler(q, omega + gain * innovation(q, q_meas), dt))


@mutant(
    attitude_step,
    hint="The innovation is held over the step: with a large gain or dt it turns past the measurement.",
)
def innovation_held(q, omega, q_meas, gain, dt):
    return unit(product(q, turn(dt * (omega + gain * innovation(q, q_meas)))))


@mutant(
    attitude_step,
    hint="The error is taken the wrong way round: δq is q* ⊗ q_meas, not q_meas* ⊗ q; yours grows.",
)
def wrong_way_round(q, omega, q_meas, gain, dt):
    return right.attitude_step(q, omega, q_meas, -gain, dt)


@mutant(
    attitude_step,
    hint="The error is told in the world: q_meas ⊗ q* must be q* ⊗ q_meas, which is told in the body like omega.",
)
def error_in_the_world(q, omega, q_meas, gain, dt):
    told = product(product(q, q_meas), conjugate(q))  # q* ⊗ this is q_meas ⊗ q*
    return right.attitude_step(q, omega, told, gain, dt)


@mutant(
    attitude_step,
    hint="The gyro is told in the body: its turn stands on the right of q, not on the left.",
)
def gyro_in_the_world(q, omega, q_meas, gain, dt):
    return unit(product(turn(dt * omega), right.attitude_step(q, 0 * omega, q_meas, gain, dt)))


@mutant(
    attitude_step, hint="The gyro turns twice as far: the quaternion of an angle holds its half."
)
def whole_angle(q, omega, q_meas, gain, dt):
    return right.attitude_step(q, 2.0 * omega, q_meas, gain, dt)


@mutant(attitude_step, hint="The gyro is missing: between two measurements it is all there is.")
def no_gyro(q, omega, q_meas, gain, dt):
    return right.attitude_step(q, 0.0 * omega, q_meas, gain, dt)


@mutant(
    attitude_step,
    hint="The error fades half as fast as (12) says: in 2 K δq_s δq_v the 2 belongs to the body rate.",
)
def half_the_gain(q, omega, q_meas, gain, dt):
    return right.attitude_step(q, omega, q_meas, 0.5 * gain, dt)


@mutant(
    attitude_step,
    hint="The angle itself fades like exp(−gain dt): by (12) it is the tangent of its half that does.",
)
def angle_fades(q, omega, q_meas, gain, dt):
    d = product(conjugate(q), q_meas)
    d = d * np.sign(d[0])
    half = np.arctan2(np.linalg.norm(d[1:]), d[0])
    by = 2.0 * half * (1.0 - np.exp(-gain * dt)) / np.linalg.norm(d[1:])
    return unit(product(product(q, turn(by * d[1:])), turn(dt * omega)))


@mutant(
    attitude_step,
    hint="Where δq_s is negative the long way is taken: q_meas and −q_meas are one attitude.",
)
def long_way(q, omega, q_meas, gain, dt):
    d = product(conjugate(q), q_meas)
    half = np.arctan2(np.linalg.norm(d[1:]), d[0])
    left = 2.0 * np.arctan(np.tan(0.5 * half) * np.exp(-gain * dt))
    by = 2.0 * (half - left) / np.linalg.norm(d[1:])
    return unit(product(product(q, turn(by * d[1:])), turn(dt * omega)))
