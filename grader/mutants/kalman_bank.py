"""Lab 03, known wrong answers: each with the hint that an answer like it earns; and inputs that tell them apart."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from grader.mutants.kalman_bank_arbiter import *  # noqa: F403  who flies, and what a switch does
from grader.mutants.kalman_bank_class import *  # noqa: F403  the bank of the lab
from uavlab.exercises import draw
from uavlab.exercises.kalman_bank import correct, heading_model, predict, translation_model

CANARY = "canary-6d096a2c6311bd3a4934a814"

# translation_model ------------------------------------------------------------------------------------


@sample(translation_model)
def steps(rng: np.random.Generator) -> list[Arguments]:
    return [
        (float(dt), float(p))
        for dt, p in zip(rng.uniform(0.02, 0.3, size=5), rng.uniform(0.6, 0.9, size=5), strict=True)
    ]


def column(*b):
    return np.array([[x] for x in b])


def translation(dt, p, square=0.5, b=None):
    A = np.array([[1.0, dt, square * dt**2], [0.0, 1.0, dt], [0.0, 0.0, p]])
    return A, column(0.0, 0.0, 1.0 - p if b is None else b)


@mutant(
    translation_model,
    hint="In B stands what the input fills up, 1 − p, not what is left, p: see (9).",
)
def left_for_filled(dt, p):
    return translation(dt, p, b=p)


@mutant(
    translation_model,
    hint="The position gains half of dt² times the acceleration: in (10) there is a ½.",
)
def half_missing(dt, p):
    return translation(dt, p, square=1.0)


@mutant(
    translation_model,
    hint="The position gains dt²/2 times the acceleration, too: an entry of A is missing.",
)
def square_missing(dt, p):
    return translation(dt, p, square=0.0)


@mutant(
    translation_model,
    hint="A is transposed: the position gains dt times the velocity, in the first row.",
)
def model_transposed(dt, p):
    A, B = translation(dt, p)
    return A.T, B


@mutant(
    translation_model, hint="p does not stand in A: of the old acceleration the share p is left."
)
def nothing_fades(dt, p):
    A, B = translation(dt, p)
    A[2, 2] = 1.0
    return A, B


@mutant(
    translation_model,
    hint="p and 1 − p have changed places: p is what is left of the old acceleration.",
)
def shares_swapped(dt, p):
    return translation(dt, 1.0 - p)


@mutant(
    translation_model,
    hint="The input acts on the acceleration alone: velocity and position follow from it.",
)
def input_on_all(dt, p):
    A, _ = translation(dt, p)
    return A, column(0.5 * dt**2, dt, 1.0) * (1.0 - p)


# heading_model ----------------------------------------------------------------------------------------


@sample(heading_model)
def steps_of_heading(rng: np.random.Generator) -> list[Arguments]:
    return steps.draw(rng)


def turn_model(dt, p, b=None):
    return np.array([[1.0, dt], [0.0, p]]), column(0.0, 1.0 - p if b is None else b)


@mutant(heading_model, hint="In B stands what the input fills up, 1 − p, not p: see (9) and (11).")
def rate_left_for_filled(dt, p):
    return turn_model(dt, p, b=p)


@mutant(heading_model, hint="The heading gains dt times its rate: dt is missing in A.")
def no_step(dt, p):
    return turn_model(1.0, p)


@mutant(
    heading_model, hint="A is transposed: the heading gains dt times its rate, in the first row."
)
def turn_transposed(dt, p):
    A, B = turn_model(dt, p)
    return A.T, B


@mutant(heading_model, hint="p does not stand in A: of the old rate the share p is left.")
def rate_never_fades(dt, p):
    return turn_model(dt, 1.0, b=1.0 - p)


@mutant(heading_model, hint="p stands at the heading: it is the rate that fades, not the heading.")
def heading_fades(dt, p):
    return np.array([[p, dt], [0.0, 1.0]]), column(0.0, 1.0 - p)


@mutant(heading_model, hint="p and 1 − p have changed places: p is what is left of the old rate.")
def rate_shares_swapped(dt, p):
    return turn_model(dt, 1.0 - p)


# predict ----------------------------------------------------------------------------------------------


@sample(predict)
def predictions(rng: np.random.Generator) -> list[Arguments]:
    return [draw.prediction(rng, n, k) for n, k in ((3, 1), (3, 2), (2, 1), (4, 2), (2, 2))]


@mutant(predict, hint="The covariance is multiplied the wrong way round: it is A P Aᵀ, not Aᵀ P A.")
def wrong_side(x, P, u, A, B, Q):
    return A @ x + B @ u, A.T @ P @ A + Q


@mutant(
    predict, hint="Q is missing: what the model misses makes the filter less sure in each step."
)
def noise_missing(x, P, u, A, B, Q):
    return A @ x + B @ u, A @ P @ A.T


@mutant(predict, hint="The input is not used: add B u.")
def input_missing(x, P, u, A, B, Q):
    return A @ x, A @ P @ A.T + Q


@mutant(predict, hint="The input has the wrong sign: in (7) it is added.")
def input_subtracted(x, P, u, A, B, Q):
    return A @ x - B @ u, A @ P @ A.T + Q


@mutant(
    predict,
    hint="The covariance is multiplied once only: an error that is multiplied by A has the covariance A P Aᵀ.",
)
def one_factor(x, P, u, A, B, Q):
    return A @ x + B @ u, A @ P + Q


@mutant(
    predict, hint="The covariance stays as it was but for Q: the model moves errors, too: A P Aᵀ."
)
def covariance_stands(x, P, u, A, B, Q):
    return A @ x + B @ u, P + Q


@mutant(
    predict,
    hint="Here Q is that of one step: do not multiply it by dt, as the MRS software does with its own.",
)
def noise_times_a_step(x, P, u, A, B, Q):
    return A @ x + B @ u, A @ P @ A.T + 0.01 * Q


@mutant(predict, hint="Q is inside: it is added after P is moved, A P Aᵀ + Q, not A (P + Q) Aᵀ.")
def noise_inside(x, P, u, A, B, Q):
    return A @ x + B @ u, A @ (P + Q) @ A.T


# correct ----------------------------------------------------------------------------------------------


@sample(correct)
def beliefs(rng: np.random.Generator) -> list[Arguments]:
    return [draw.belief(rng, n, m) for n, m in ((3, 1), (3, 2), (2, 1), (2, 2), (4, 3))]


def weighed(x, P, z, H, R_z):
    """Innovation, its covariance, and the gain."""
    S = H @ P @ H.T + R_z
    return z - H @ x, S, P @ H.T @ np.linalg.inv(S)


@mutant(
    correct, hint="The gain has the wrong sign: the state moves towards the measurement, by + K ν."
)
def away_from_it(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    return x - K @ nu, P - K @ S @ K.T, nu @ np.linalg.solve(S, nu)


@mutant(correct, hint="P grows: a measurement makes a filter surer, P is (I − K H) P.")
def less_sure(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    return x + K @ nu, P + K @ S @ K.T, nu @ np.linalg.solve(S, nu)


@mutant(correct, hint="P is returned as it came: a measurement makes a filter surer.")
def as_sure_as_before(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    return x + K @ nu, P, nu @ np.linalg.solve(S, nu)


@mutant(correct, hint="R_z is missing in the covariance of the innovation: S = H P Hᵀ + R_z.")
def noise_forgotten(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, 0.0)
    return x + K @ nu, P - K @ H @ P, nu @ np.linalg.solve(S, nu)


@mutant(
    correct,
    hint="K R_z Kᵀ is missing: Joseph's form has two terms, the noise comes in through the gain.",
)
def half_of_joseph(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    rest = np.eye(len(x)) - K @ H
    return x + K @ nu, rest @ P @ rest.T, nu @ np.linalg.solve(S, nu)


@mutant(
    correct, hint="The innovation is normalised by R_z alone: its covariance is S = H P Hᵀ + R_z."
)
def normalised_by_noise(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    return x + K @ nu, P - K @ S @ K.T, nu @ np.linalg.solve(R_z, nu)


@mutant(correct, hint="The innovation is squared but not normalised: divide by S, νᵀ S⁻¹ ν.")
def not_normalised(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    return x + K @ nu, P - K @ S @ K.T, nu @ nu


@mutant(correct, hint="S stands where its inverse belongs: νᵀ S⁻¹ ν.")
def not_inverted(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    return x + K @ nu, P - K @ S @ K.T, nu @ S @ nu


@mutant(
    correct,
    hint="The innovation is what was surprising before the correction: this is the rest after it.",
)
def rest_for_innovation(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    left = z - H @ (x + K @ nu)
    return x + K @ nu, P - K @ S @ K.T, left @ np.linalg.solve(S, left)


@mutant(correct, hint="This is the root of the normalised innovation squared: leave the square.")
def distance_for_square(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    return x + K @ nu, P - K @ S @ K.T, np.sqrt(nu @ np.linalg.solve(S, nu))


@mutant(
    correct, hint="P and R_z have changed places in the gain: much noise must give a small gain."
)
def noise_for_doubt(x, P, z, H, R_z):
    nu, S, K = weighed(x, P, z, H, R_z)
    K = np.linalg.pinv(H) @ R_z @ np.linalg.inv(S)
    return x + K @ nu, P - K @ H @ P, nu @ np.linalg.solve(S, nu)
