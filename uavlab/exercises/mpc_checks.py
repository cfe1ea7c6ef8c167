"""The public checks of lab 06: what predictions, programmes and solutions promise. The exercises are beside it."""

from __future__ import annotations

import numpy as np

from uavlab.exercises import draw, programmes
from uavlab.exercises.expect import expect_refusal, of_shapes
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.limits import AxisLimits, ForceLimits
from uavlab.qp import INFEASIBLE, QP, SOLVED, hard
from uavlab.types import Array, Estimate
from uavlab.weights import HORIZONTAL, ForceWeights, InputBounds, LandingWeights, SoftRows
from uavlab.weights import landing_model as continuous

# Predictions ------------------------------------------------------------------------------------------


def a_push_held(f: Function, rng: np.random.Generator) -> None:
    """An acceleration that is held for one step must move a mass by the parabola, however long the step is."""
    A, B = np.eye(2, k=1), np.array(((0.0,), (1.0,)))
    for dt in (float(rng.uniform(0.01, 0.1)), float(rng.uniform(0.5, 2.0))):
        A_d, B_d = of_shapes(f(A, B, dt), (2, 2), (2, 1))
        (r, v), u = rng.normal(size=2), float(rng.uniform(1.0, 3.0))
        want = (r + v * dt + 0.5 * u * dt**2, v + u * dt)
        expect_close(A_d @ (r, v) + B_d[:, 0] * u, want)


def two_steps_are_one_long_one(f: Function, rng: np.random.Generator) -> None:
    """Two steps with the same input must lead to where one step of twice the length leads."""
    for n, k in ((2, 1), (3, 2)):
        A, B, dt = rng.normal(size=(n, n)), rng.normal(size=(n, k)), float(rng.uniform(0.1, 0.4))
        A_d, B_d = of_shapes(f(A, B, dt), (n, n), (n, k))
        A_2, B_2 = of_shapes(f(A, B, 2.0 * dt), (n, n), (n, k))
        expect_close(A_2, A_d @ A_d)
        expect_close(B_2, A_d @ B_d + B_d)
        little = 1e-5  # a step so short that nothing but the slope is seen
        A_s, B_s = of_shapes(f(A, B, little), (n, n), (n, k))
        expect_close((A_s - np.eye(n)) / little, A, atol=1e-3)
        expect_close(B_s / little, B, atol=1e-3)


def step_by_step(f: Function, rng: np.random.Generator) -> None:
    """The prediction must say what one step after the other says."""
    for n, k, N in ((2, 1, 3), (3, 2, 5)):
        A, B = rng.normal(size=(n, n)), rng.normal(size=(n, k))
        Phi, Gamma = of_shapes(f(A, B, N), (N * n, n), (N * n, N * k))
        x, u = rng.normal(size=n), rng.normal(size=(N, k))
        told = (Phi @ x + Gamma @ u.ravel()).reshape(N, n)
        for i in range(N):
            x = A @ x + B @ u[i]
            expect_close(told[i], x)


def measured_within_its_limits(f: Function, rng: np.random.Generator) -> None:
    """Slow enough, all is measured; a velocity or acceleration far too large is that of the reference, alone."""
    limits = ForceLimits()
    x, wanted = rng.uniform(-1.5, 1.5, size=(3, 3)), draw.reference(rng)
    estimate = Estimate(x[0], x[1], x[2], np.eye(3), np.zeros(3))
    expect_close(numbers(f(estimate, wanted, limits), (3, 3)), x.T)
    for derivative, name in ((1, "v"), (2, "a")):
        axis, far = int(rng.integers(3)), x.copy()
        far[derivative, axis] = rng.choice((-1.0, 1.0)) * rng.uniform(4.0, 9.0)
        estimate = Estimate(far[0], far[1], far[2], np.eye(3), np.zeros(3))
        far[derivative, axis] = getattr(wanted, name)[axis]
        expect_close(numbers(f(estimate, wanted, limits), (3, 3)), far.T)


# Programmes -------------------------------------------------------------------------------------------


def flown(x0: Array, inputs: Array, dt: float, p: float) -> Array:
    """States of one axis after each of its inputs (N,), step by step (MRS eq. 10): (N, 3)."""
    (r, v, a), states = x0, []
    for u in inputs:
        r, v, a = r + v * dt + 0.5 * a * dt**2, v + a * dt, p * a + (1.0 - p) * u
        states.append((r, v, a))
    return np.array(states)


def flight_cost(states: Array, reference: Array, weights: ForceWeights) -> float:
    """What states (N, 3) cost against those that are wanted (MRS eq. 46, plain sums)."""
    squares = (states - reference) ** 2
    return float((squares[:-1] @ weights.Q).sum() + squares[-1] @ weights.S)


def a_plan_costs_what_its_flight_costs(f: Function, rng: np.random.Generator) -> None:
    """Two plans must differ in cost as the flights do that they lead to, while nobody is too fast."""
    N, dt, x0 = 6, float(rng.uniform(0.03, 0.1)), 0.3 * rng.normal(size=3)
    wanted = rng.normal(size=(N, 3))
    limits = AxisLimits(50.0, 3.0, 5.0, np.inf)
    qp = programmes.read(f(x0, wanted, 0.0, limits=limits, N=N, dt=dt), N)
    plans = rng.uniform(-3.0, 3.0, size=(5, N))
    costs = [flight_cost(flown(x0, z, dt, 0.0), wanted, HORIZONTAL) for z in plans]
    programmes.expect_costs(qp, plans, costs, "Plans cost something else than their flights.")


def a_plan_begins_where_the_last_one_was(f: Function, rng: np.random.Generator) -> None:
    """The first input may differ from the last one by what a period allows, each later one by what dt allows."""
    N, dt, period, last = 5, 0.05, float(rng.uniform(0.01, 0.03)), float(rng.uniform(-0.5, 0.5))
    j = float(rng.uniform(4.0, 8.0))
    limits = AxisLimits(2.0, 2.0, j, np.inf)
    got = f(
        np.zeros(3), np.zeros((N, 3)), last, limits=limits, N=N, dt=dt, period=period
    )  # fmt: skip
    qp, held = programmes.read(got, N), np.full(N, last)
    programmes.expect_ways(
        qp, held, (np.ones(N), -np.ones(N)), (j * period,) * 2, "Mind the first input."
    )
    later = np.arange(N) >= 2
    programmes.expect_ways(qp, held, (later, -1.0 * later), (j * dt,) * 2, "Mind the later inputs.")


def landed(x0: Array, inputs: Array, dt: float) -> Array:
    """States of the landing model after each of its inputs (N, 3), in fine steps: (N, 10)."""
    (A, B), fine, states, x = continuous(), dt / 40, [], x0
    for u in inputs:
        for _ in range(40):  # Taylor's sum to the fourth power
            c = A @ x + B @ u
            d = A @ c
            e = A @ d
            x = x + fine * (c + fine / 2 * (d + fine / 3 * (e + fine / 4 * (A @ e))))
        states.append(x)
    return np.array(states)


def a_landing_costs_what_it_weighs(f: Function, rng: np.random.Generator) -> None:
    """Two plans must differ in cost by squares of weighed errors and inputs, and by the price of their slacks."""
    N, x0, wanted, weights = 3, rng.normal(size=10), rng.normal(size=10), LandingWeights()
    soft = SoftRows(
        rng.normal(size=(2, 10)), rng.uniform(1.0, 2.0, size=2), float(rng.uniform(20.0, 60.0))
    )
    qp = programmes.read(
        f(x0, wanted, weights=weights, bounds=InputBounds(), soft=soft, N=N, dt=0.05), 5 * N
    )
    plans, costs = rng.uniform(0.0, 1.0, size=(4, 5 * N)), []
    for z in plans:
        u = z[: 3 * N].reshape(N, 3)
        e = landed(x0, u, 0.05) - wanted
        costs.append(
            ((e * weights.Q) ** 2).sum()
            + ((u * weights.R) ** 2).sum()
            + soft.price * z[3 * N :].sum()
        )
    programmes.expect_costs(qp, plans, costs, "Plans cost something else than they weigh.")


def a_slack_lets_a_row_be_missed(f: Function, rng: np.random.Generator) -> None:
    """With enough slack every state is allowed; a slack may not be negative; inputs stay within their bounds."""
    N, x0, bounds = 3, 9.0 * rng.normal(size=10), InputBounds()
    soft = SoftRows(rng.normal(size=(2, 10)), rng.uniform(1.0, 2.0, size=2))
    qp = programmes.read(
        f(x0, np.zeros(10), weights=LandingWeights(), bounds=bounds, soft=soft, N=N, dt=0.05), 5 * N
    )
    z = np.concatenate((np.zeros(3 * N), np.full(2 * N, 1e3)))
    for i in range(3 * N):
        way = np.eye(5 * N)[i]
        far = (bounds.upper[i % 3], -bounds.lower[i % 3])
        programmes.expect_ways(qp, z, (way, -way), far, "Inputs have other bounds.")
    missed = np.maximum(
        soft.G @ landed(x0, np.zeros((N, 3)), 0.05).T - soft.h[:, None], 0.0
    ).T.ravel()
    for k in range(2 * N):
        least = np.eye(5 * N)[3 * N + k]
        programmes.expect_ways(
            qp, z, (-least,), (1e3 - missed[k],), "A slack has another least size."
        )


# Solutions --------------------------------------------------------------------------------------------


def solved_by_hand(rng: np.random.Generator, n: int, m: int) -> tuple[QP, Array, Array]:
    """A programme with hard rows, made around its solution: with that, and the multipliers."""
    root, A = rng.normal(size=(n, n)), rng.normal(size=(m, n))
    P, z = root @ root.T + np.eye(n), rng.normal(size=n)
    side = rng.permutation(np.arange(m) % 3) - 1  # which bound holds z back: l, none, u
    y = side * rng.uniform(0.5, 3.0, size=m)
    l = A @ z - np.where(side < 0, 0.0, rng.uniform(0.5, 2.0, size=m))
    u = A @ z + np.where(side > 0, 0.0, rng.uniform(0.5, 2.0, size=m))
    return QP(P, -P @ z - A.T @ y, A, l, u, hard(m)), z, y


def the_best_that_is_allowed(f: Function, rng: np.random.Generator) -> None:
    """Of a programme with a known solution, it must be found."""
    for n, m in ((3, 3), (5, 6)):
        qp, z, _ = solved_by_hand(rng, n, m)
        plan = programmes.read_plan(f(qp), n, m)
        expect(plan.status == SOLVED, "There is a solution.")
        expect_close(plan.z, z, "The solution is another one.", atol=1e-3)


def rows_that_exclude_each_other(f: Function, rng: np.random.Generator) -> None:
    """Where no z is allowed the status must say so, without an error; what is not a number is an error."""
    qp, _, _ = solved_by_hand(rng, 3, 4)
    row, gap = rng.normal(size=3), float(rng.uniform(0.5, 1.0))
    both = qp._replace(
        A=np.vstack((row, -row)), l=np.full(2, gap), u=np.full(2, np.inf), soft=hard(2)
    )
    plan = programmes.read_plan(f(both), 3, 2)
    expect(plan.status == INFEASIBLE, "There is no solution.")
    expect_refusal(f, qp._replace(q=qp.q * np.nan))
