"""Lab 03, hidden checks: Riccati and Lyapunov equations, least squares, and information."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm, solve_discrete_are, solve_discrete_lyapunov

from grader.hidden.kalman_bank_arbiter import *  # noqa: F403  who flies, and what a switch does
from grader.hidden.kalman_bank_health import *  # noqa: F403  the bank, continued
from grader.hidden.kalman_bank_worlds import *  # noqa: F403  the bank
from grader.material import hidden
from uavlab.exercises import draw
from uavlab.exercises.expect import of_shapes
from uavlab.exercises.kalman_bank import correct, heading_model, predict, translation_model
from uavlab.exercises.spec import Function, expect, expect_close
from uavlab.types import Array

CANARY = "canary-a27d4c45a4d3f02a2171451e"


def refuses(f: Function, *args: Array) -> None:
    """Fail the check unless the answer refuses; an answer that hangs or dies has not."""
    try:
        f(*args)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        return
    expect(False, "It must raise ValueError.")


# Models -----------------------------------------------------------------------------------------------


@hidden(translation_model)
def exact_without_a_lag(f: Function, rng: np.random.Generator) -> None:
    """With p = 1 the model must be the exact solution of a constant acceleration, for short and long steps."""
    for dt in (1e-3, float(rng.uniform(0.005, 0.1)), float(rng.uniform(0.5, 2.0))):
        A, B = of_shapes(f(dt, 1.0), (3, 3), (3, 1))
        expect_close(A, expm(dt * np.eye(3, k=1)))
        expect_close(B, np.zeros((3, 1)))


@hidden(translation_model, weight=2.0)
def flown_with_an_input(f: Function, rng: np.random.Generator) -> None:
    """Many steps with a held input must give the sums of a geometric series."""
    for p in (0.0, float(rng.uniform(0.5, 0.95))):
        dt, n = float(rng.uniform(0.005, 0.05)), 12
        A, B = of_shapes(f(dt, p), (3, 3), (3, 1))
        (r, v, a), u = rng.normal(size=3), float(rng.uniform(1.0, 3.0))
        x = np.array((r, v, a))
        for _ in range(n):
            x = A @ x + B[:, 0] * u
        accelerations = u + p ** np.arange(n + 1) * (a - u)
        speeds = v + dt * np.concatenate(([0.0], np.cumsum(accelerations[:-1])))
        r += np.sum(dt * speeds[:-1] + 0.5 * dt**2 * accelerations[:-1])
        expect_close(x, (r, speeds[-1], accelerations[-1]))


@hidden(translation_model)
def the_input_acts_on_the_acceleration(f: Function, rng: np.random.Generator) -> None:
    """The input must reach the acceleration alone, with a gain that is one in the end, whatever p is."""
    for p in rng.uniform(0.05, 0.95, size=3):
        A, B = of_shapes(f(float(rng.uniform(0.005, 0.05)), float(p)), (3, 3), (3, 1))
        expect_close(B[:2, 0], np.zeros(2))
        expect_close(A[2], (0.0, 0.0, p))
        expect_close(B[2, 0] / (1.0 - A[2, 2]), 1.0)


@hidden(heading_model)
def exact_turn_without_a_lag(f: Function, rng: np.random.Generator) -> None:
    """With p = 1 the model must be the exact solution of a constant rate, for short and long steps."""
    for dt in (1e-3, float(rng.uniform(0.005, 0.1)), float(rng.uniform(0.5, 2.0))):
        A, B = of_shapes(f(dt, 1.0), (2, 2), (2, 1))
        expect_close(A, expm(dt * np.eye(2, k=1)))
        expect_close(B, np.zeros((2, 1)))


@hidden(heading_model)
def turned_with_an_input(f: Function, rng: np.random.Generator) -> None:
    """Many steps with a held input must give the sums of a geometric series."""
    for p in (0.0, float(rng.uniform(0.5, 0.95))):
        dt, n, u = float(rng.uniform(0.005, 0.05)), 12, float(rng.uniform(1.0, 3.0))
        A, B = of_shapes(f(dt, p), (2, 2), (2, 1))
        eta, rate = h = rng.normal(size=2)
        for _ in range(n):
            h = A @ h + B[:, 0] * u
        rates = u + p ** np.arange(n + 1) * (rate - u)
        expect_close(h, (eta + dt * rates[:-1].sum(), rates[-1]))


@hidden(heading_model)
def the_input_acts_on_the_rate(f: Function, rng: np.random.Generator) -> None:
    """The input must reach the rate alone, with a gain that is one in the end, whatever p is."""
    for p in rng.uniform(0.05, 0.95, size=3):
        A, B = of_shapes(f(float(rng.uniform(0.005, 0.05)), float(p)), (2, 2), (2, 1))
        expect_close(B[0, 0], 0.0)
        expect_close(A[1], (0.0, p))
        expect_close(B[1, 0] / (1.0 - A[1, 1]), 1.0)


# One filter -------------------------------------------------------------------------------------------


@hidden(predict)
def settles_where_lyapunov_says(f: Function, rng: np.random.Generator) -> None:
    """Predicted for long, a stable model must settle at its equilibrium, with the covariance of Lyapunov's equation."""
    x, P, u, A, B, Q = draw.prediction(rng, 3, 2)
    A *= 0.4 / np.abs(np.linalg.eigvals(A)).max()
    for _ in range(40):
        x, P = of_shapes(f(x, P, u, A, B, Q), (3,), (3, 3))
    expect_close(x, np.linalg.solve(np.eye(3) - A, B @ u), atol=1e-7)
    expect_close(P, solve_discrete_lyapunov(A, Q), atol=1e-7)


@hidden(predict, weight=2.0)
def in_other_coordinates(f: Function, rng: np.random.Generator) -> None:
    """Told in other coordinates, and of several states and inputs, it must be the same prediction."""
    for n, k in ((3, 1), (2, 1), (4, 2)):
        x, P, u, A, B, Q = draw.prediction(rng, n, k)
        T = np.linalg.cholesky(draw.covariance(rng, n))
        back = np.linalg.inv(T)
        got, cov = of_shapes(
            f(T @ x, T @ P @ T.T, u, T @ A @ back, T @ B, T @ Q @ T.T), (n,), (n, n)
        )
        expect_close(back @ got - A @ x, B @ u, atol=1e-7)
        expect_close(back @ cov @ back.T - Q, A @ P @ A.T, atol=1e-7)


@hidden(predict)
def nothing_moves(f: Function, rng: np.random.Generator) -> None:
    """Of what stands still, the covariance must grow by Q in each step, and by nothing else."""
    for n in (2, 3):
        x, P, _, _, _, Q = draw.prediction(rng, n, 1)
        Q[0] = Q[:, 0] = 0.0  # a state that the model does not miss: Q is singular
        got, cov = of_shapes(f(x, P, np.ones(1), np.eye(n), np.zeros((n, 1)), Q), (n,), (n, n))
        expect_close(got, x)
        expect_close(cov, P + Q)


@hidden(predict, weight=0.5)
def refuses_what_cannot_be_predicted(f: Function, rng: np.random.Generator) -> None:
    """What is no covariance, does not fit, or is not finite must raise ValueError."""
    x, P, u, A, B, Q = draw.prediction(rng, 3, 1)
    got, _ = of_shapes(f(x, P, u, A, B, Q), (3,), (3, 3))
    expect_close(got, A @ x + B @ u)
    skew = P + np.triu(np.ones((3, 3)), 1)
    for bad in (P - 20.0 * np.eye(3), skew, P[:2, :2], P * np.nan):
        refuses(f, x, bad, u, A, B, Q)
    refuses(f, x, P, u, A, B, Q - 20.0 * np.eye(3))
    refuses(f, x, P, u, A[:2, :2], B, Q)
    refuses(f, x * np.nan, P, u, A, B, Q)


@hidden(correct, weight=3.0)
def information_adds_up(f: Function, rng: np.random.Generator) -> None:
    """What is known must be the sum of what was known and what was measured: inverse covariances add."""
    for n, m in ((3, 1), (3, 2), (2, 3)):
        x, P, z, H, R_z = draw.belief(rng, n, m)
        got, cov, nis = of_shapes(f(x, P, z, H, R_z), (n,), (n, n), ())
        known = np.linalg.inv(P) + H.T @ np.linalg.inv(R_z) @ H
        expect_close(cov, np.linalg.inv(known), atol=1e-7)
        told = np.linalg.solve(P, x) + H.T @ np.linalg.solve(R_z, z)
        expect_close(got, np.linalg.solve(known, told), atol=1e-7)
        off, left = got - x, z - H @ got  # the least that both together can be off
        least = off @ np.linalg.solve(P, off) + left @ np.linalg.solve(R_z, left)
        expect_close(nis, least, atol=1e-7)


@hidden(correct)
def least_squares_of_all(f: Function, rng: np.random.Generator) -> None:
    """Of what stands still, one measurement after the other must give the least squares of all, in any order."""
    x, P, _, _, _ = draw.belief(rng, 3, 1)
    seen = [draw.belief(rng, 3, 1)[2:] for _ in range(5)]
    rows = [np.linalg.inv(np.linalg.cholesky(P)), *(H / np.sqrt(R) for _, H, R in seen)]
    told = [rows[0] @ x, *(z / np.sqrt(R[0]) for z, _, R in seen)]
    best = np.linalg.lstsq(np.vstack(rows), np.concatenate(told))[0]
    for order in (seen, seen[::-1]):
        mean, cov = x, P
        for z, H, R_z in order:
            mean, cov, _ = of_shapes(f(mean, cov, z, H, R_z), (3,), (3, 3), ())
        expect_close(mean, best, atol=1e-7)


@hidden(correct)
def settles_where_riccati_says(f: Function, rng: np.random.Generator) -> None:
    """Where Riccati's equation says that a filter settles, a correction and a prediction must lead back there."""
    for m in (1, 2):
        x, Q, z, H, R_z = draw.belief(rng, 3, m)
        A = expm(float(rng.uniform(0.1, 0.3)) * np.eye(3, k=1))
        settled = solve_discrete_are(A.T, H.T, Q, R_z)
        _, P, _ = of_shapes(f(x, settled, z, H, R_z), (3,), (3, 3), ())
        expect_close(A @ P @ A.T + Q, settled, rtol=1e-6)


@hidden(correct)
def noise_without_end_and_without(f: Function, rng: np.random.Generator) -> None:
    """A measurement that is nothing but noise must change nothing, and one without noise must be believed."""
    for n, m in ((3, 1), (3, 2)):
        x, P, z, H, R_z = draw.belief(rng, n, m)
        got, cov, nis = of_shapes(f(x, P, z, H, 1e12 * R_z), (n,), (n, n), ())
        expect_close(got, x, atol=1e-7)
        expect_close(cov, P, atol=1e-7)
        expect_close(nis, 0.0, atol=1e-7)
        got, cov, nis = of_shapes(f(x, P, z, H, 1e-9 * R_z), (n,), (n, n), ())
        expect_close(H @ got, z, atol=1e-6)
        nu = z - H @ x
        expect_close(nis, nu @ np.linalg.solve(H @ P @ H.T, nu), rtol=1e-5)
        expect(np.abs(cov - cov.T).max() < 1e-9, "The covariance is not symmetric.")


@hidden(correct, weight=0.5)
def refuses_what_cannot_be_corrected(f: Function, rng: np.random.Generator) -> None:
    """What is no covariance, does not fit, or is not finite must raise ValueError."""
    x, P, z, H, R_z = draw.belief(rng, 3, 2)
    got, _, _ = of_shapes(f(x, P, z, H, R_z), (3,), (3, 3), ())
    expect_close(got - x, P @ H.T @ np.linalg.solve(H @ P @ H.T + R_z, z - H @ x), atol=1e-7)
    for bad in (P - 20.0 * np.eye(3), P + np.triu(np.ones((3, 3)), 1), P[:2, :2]):
        refuses(f, x, bad, z, H, R_z)
    refuses(f, x, P, z, H, R_z - 20.0 * np.eye(2))
    refuses(f, x, P, z * np.nan, H, R_z)
    refuses(f, x, P, z, H[:1], R_z)
