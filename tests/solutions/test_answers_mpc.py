"""The reference answers of lab 06 against scipy, simulation, an interior point, and what the papers print."""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from interior_point import solved, sparse
from numpy.testing import assert_allclose, assert_array_equal
from scipy.linalg import block_diag, expm, solve_discrete_are
from scipy.signal import cont2discrete

from uavlab.errors import BadInput
from uavlab.exercises import draw
from uavlab.limits import AxisLimits, ForceLimits
from uavlab.qp import INFEASIBLE, QP, Plan, cost, hard, without_slacks
from uavlab.solutions.mpc import (
    build_force_qp,
    build_soft_qp,
    discretize,
    initial_state,
    prediction_matrices,
    solve,
)
from uavlab.solvers import Solver
from uavlab.types import Estimate
from uavlab.weights import (
    HORIZONTAL,
    VERTICAL,
    InputBounds,
    LandingWeights,
    SoftRows,
    landing_model,
    soft_limits,
    with_endless_horizon,
)

seeds = st.integers(0, 2**32 - 1)
N, DT = 26, 0.05
LIMITS = ForceLimits()


def best(qp: QP) -> np.ndarray:
    plan = Solver(qp).solve(qp.q, qp.l, qp.u)
    assert plan.ok
    return plan.z


# Predictions ------------------------------------------------------------------------------------------


@given(seeds)
def test_steps_are_those_of_scipy(seed):
    rng = np.random.default_rng(seed)
    n, k = rng.integers(1, 5, size=2)
    A, B, dt = rng.normal(size=(n, n)), rng.normal(size=(n, k)), float(rng.uniform(0.01, 1.0))
    want = cont2discrete((A, B, np.eye(n), np.zeros((n, k))), dt)
    for got, right in zip(discretize(A, B, dt), want, strict=False):
        assert_allclose(got, right, atol=1e-12)


def test_the_integral_of_the_exponential_alone_is_no_input_matrix():
    # Errata, Landing (18): B is missing. The sample of the errata holds for the stand-in numbers.
    A, B = landing_model()
    A_d, B_d = discretize(A, B, DT)
    assert np.linalg.matrix_rank(A) < 10  # nor is there A⁻¹ (A_d − I)
    printed = expm(DT * np.block([[A, np.eye(10)], [np.zeros((10, 20))]]))[:10, 10:]
    assert printed.shape != B_d.shape
    assert_allclose(printed @ B, B_d, atol=1e-12)
    assert_allclose(B_d[:4, 0], (1.1e-4, 8.8e-3, 0.052, 1.90), rtol=0.03)
    assert_allclose(A_d, expm(A * DT), atol=1e-12)


@given(seeds)
def test_a_prediction_is_a_simulation(seed):
    rng = np.random.default_rng(seed)
    n, k, steps = rng.integers(1, 5, size=3)
    A, B, x, u = (rng.normal(size=s) for s in ((n, n), (n, k), n, (steps, k)))
    Phi, Gamma = prediction_matrices(A, B, steps)
    told = (Phi @ x + Gamma @ u.ravel()).reshape(steps, n)
    for i in range(steps):
        x = A @ x + B @ u[i]
        assert_allclose(told[i], x, atol=1e-9 * np.abs(told).max() + 1e-12)


def test_a_plan_starts_from_the_estimate_unless_it_is_far_too_fast():
    rng = np.random.default_rng(1)
    v, a = np.array((2.99, -3.0, 2.0)), np.array((-3.01, 0.1, 3.0))
    estimate = Estimate(rng.normal(size=3), v, a, np.eye(3), np.zeros(3))
    reference = draw.reference(rng)
    x = initial_state(estimate, reference, LIMITS)
    assert_array_equal(x[:, 0], estimate.r)
    assert_array_equal(x[:, 1], (2.99, reference.v[1], 2.0))
    assert_array_equal(x[:, 2], (reference.a[0], 0.1, reference.a[2]))


# The force MPC ----------------------------------------------------------------------------------------


def nine_states(x0, wanted, last, price=1e4, period=0.01):
    """First inputs by MRS (40)-(52) as they stand: 9 states and 3 inputs each step, equalities for the model."""
    axes = ((LIMITS.horizontal, 0.0, HORIZONTAL),) * 2 + ((LIMITS.vertical, 0.5, VERTICAL),)
    A = block_diag(*(np.array(((1, DT, DT**2 / 2), (0, 1, DT), (0, 0, p))) for _, p, _ in axes))
    B = block_diag(*(np.array(((0,), (0,), (1 - p,))) for _, p, _ in axes))
    Q = np.concatenate([w.Q for *_, w in axes])
    S = np.concatenate([w.S for *_, w in axes])
    nx, nu = 9 * N, 3 * N  # then N slacks for each axis's speed
    size = nx + nu + 3 * N
    W = np.concatenate((np.tile(Q, N - 1), S))
    P = np.diag(np.concatenate((2 * W, np.zeros(size - nx))))
    q = np.concatenate((-2 * W * np.tile(wanted, N), np.zeros(nu), np.full(3 * N, price)))
    model = np.hstack((  # (47)
        np.eye(nx) - np.kron(np.eye(N, k=-1), A), -np.kron(np.eye(N), B), np.zeros((nx, 3 * N)),
    ))  # fmt: skip
    start = np.concatenate((A @ x0, np.zeros(nx - 9)))
    speeds = np.zeros((3 * N, nx))
    speeds[np.arange(3 * N), 3 * np.arange(3 * N) + 1] = 1.0
    none, slack = np.zeros((3 * N, nu)), np.eye(3 * N)
    v = np.tile([a.v for a, *_ in axes], N)
    inputs = np.hstack((np.zeros((nu, nx)), np.eye(nu), np.zeros((nu, 3 * N))))
    a = np.tile([a.a for a, *_ in axes], N)
    steps = inputs - np.vstack((np.zeros((3, size)), inputs[:-3]))
    most = np.tile([5.0 * DT, 5.0 * DT, 1e4], N)
    most[:2] = 5.0 * period
    before = np.concatenate((last, np.zeros(nu - 3)))
    rows = np.vstack((
        np.hstack((speeds, none, -slack)), np.hstack((-speeds, none, -slack)),  # (48), (49)
        np.hstack((np.zeros((3 * N, nx)), none, -slack)),
        inputs, -inputs, steps, -steps,  # (50), (51)
    ))  # fmt: skip
    sides = np.concatenate((v, v, np.zeros(3 * N), a, a, most + before, most - before))
    z = sparse(P, q, model, start, rows, sides)
    return z[nx : nx + 3]


@pytest.mark.parametrize("seed", range(8))
def test_three_small_problems_are_the_large_one(seed):
    rng = np.random.default_rng(seed)
    x0 = (rng.normal(size=(3, 3)) * (4.0, 1.5, 0.8)).clip((-9, -2.6, -1.9), (9, 2.6, 1.9))
    r, last = rng.normal(size=3), rng.uniform(-2.0, 2.0, 3)
    wanted = np.column_stack((r, np.zeros((3, 2))))  # (44)
    inputs = [
        best(build_force_qp(x, np.tile(w, (N, 1)), u, limits=a, N=N, dt=DT, p=p, weights=k))[0]
        for x, w, u, a, p, k in zip(
            x0, wanted, last,
            (LIMITS.horizontal, LIMITS.horizontal, LIMITS.vertical), (0.0, 0.0, 0.5),
            (HORIZONTAL, HORIZONTAL, VERTICAL), strict=True,
        )
    ]  # fmt: skip
    assert_allclose(inputs, nine_states(x0.ravel(), wanted.ravel(), last), atol=1e-6)


def force(x0, last=0.0, limits=LIMITS.horizontal, **more) -> QP:
    return build_force_qp(np.array(x0), np.zeros((N, 3)), last, limits=limits, N=N, dt=DT, **more)


def test_without_limits_it_is_a_linear_regulator():
    none = AxisLimits(inf, inf, inf, inf)
    qp = force((1.0, 0.3, -0.2), limits=none)
    A = np.array(((1, DT, DT**2 / 2), (0, 1, DT), (0, 0, 0)))
    B = np.array(((0.0,), (0.0,), (1.0,)))
    X = np.diag(HORIZONTAL.S)  # the recursion of Riccati, backwards
    for _ in range(N):
        K = np.linalg.solve(B.T @ X @ B, B.T @ X @ A)
        X = np.diag(HORIZONTAL.Q) + A.T @ X @ (A - B @ K)
    assert best(qp)[0] == pytest.approx((-K @ (1.0, 0.3, -0.2)).item(), abs=1e-9)


def test_as_printed_the_first_input_may_jump_at_once():
    # Errata, MRS (50): printed from i = 2 on. A jump of the estimate by 5 m then asks for 2 m/s² in 10 ms.
    qp = force((5.0, 0.0, 0.0))
    right = best(qp)
    assert right[0] == pytest.approx(-5.0 * 0.01)  # 5 m/s³ for one period
    first = np.flatnonzero((np.eye(N)[0] == qp.A).all(axis=1))[
        -1
    ]  # the last such row is the slew's
    l, u = qp.l.copy(), qp.u.copy()
    l[first], u[first] = -inf, inf
    printed = best(qp._replace(l=l, u=u))
    assert printed[0] == pytest.approx(-2.0)
    assert abs(printed[0]) / 0.01 == pytest.approx(200.0)  # [m/s³]
    assert np.abs(np.diff(right)).max() <= 5.0 * DT + 1e-9


def test_the_halves_of_the_cost_matter_at_the_end_of_the_horizon_only_as_printed():
    # Errata, MRS (46): a half in front of the stages alone makes S count twice.
    x = (0.4, 0.0, 0.0)
    plain = best(force(x, limits=AxisLimits(inf, 2.0, inf, inf)))
    twice = HORIZONTAL._replace(S=tuple(2 * s for s in HORIZONTAL.S))
    printed = best(force(x, limits=AxisLimits(inf, 2.0, inf, inf), weights=twice))
    assert 1e-6 < np.abs(plain - printed).max() < 0.2


@given(seeds)
@settings(max_examples=30, deadline=None)
def test_there_is_always_a_plan_within_the_hard_limits(seed):
    rng = np.random.default_rng(seed)
    x0, last = rng.normal(size=3) * (20.0, 4.0, 3.0), float(rng.normal() * 3)
    for limits, p in ((LIMITS.horizontal, 0.0), (LIMITS.vertical, 0.5)):
        qp = force(x0, last, limits, p=p)
        u = best(qp)
        assert np.abs(u).max() <= limits.a + 1e-9
        if np.isfinite(limits.j):
            assert abs(u[0] - np.clip(last, -limits.a, limits.a)) <= limits.j * 0.01 + 1e-9
            assert np.abs(np.diff(u)).max() <= limits.j * DT + 1e-9


def test_a_speed_that_cannot_be_kept_is_missed_as_little_as_can_be():
    qp = force((0.0, 3.0, 0.0))  # v_1 is 3 m/s already
    u = best(qp)
    v = 3.0 + DT * np.cumsum(np.concatenate(((0.0,), u[:-1])))
    assert v[0] > 2.0
    assert v[-1] < 2.0
    assert_allclose(u[:5], -0.05 - 0.25 * np.arange(5), atol=1e-9)  # brakes as hard as it may
    with_hard = qp._replace(soft=hard(qp.l.size))
    assert Solver(with_hard).solve(qp.q, qp.l, qp.u).status == INFEASIBLE


def test_a_reference_that_moves_is_looked_ahead_to():
    t = DT * np.arange(1, N + 1)
    moving = np.column_stack((0.5 * t, np.full(N, 0.5), np.zeros(N)))
    qp = build_force_qp(
        np.array((0.0, 0.5, 0.0)), moving, 0.0, limits=LIMITS.horizontal, N=N, dt=DT
    )
    assert_allclose(best(qp), 0.0, atol=1e-9)


# The landing ------------------------------------------------------------------------------------------

X0 = np.array((-3.0, 4.0, 0.1, 0.0, 1.0, -1.0, 0.0, 0.2, 2.0, -1.0))


WEIGHTS, STOP = LandingWeights(), np.zeros(10)


def landing(n: int, weights=WEIGHTS, x0=X0, soft=None, wanted=STOP) -> QP:
    soft = soft or soft_limits()
    return build_soft_qp(x0, wanted, weights=weights, bounds=InputBounds(), soft=soft, N=n, dt=DT)


def test_as_printed_the_matrices_of_the_landing_do_not_fit_each_other():
    # Errata, Landing (27): the Hessian is set 2 × 3, R stands alone, and the linear term lacks the stacked map.
    n, l = 4, 10
    Phi, Gamma = prediction_matrices(*discretize(*landing_model(), DT), n)
    Q, R = (
        np.kron(np.eye(n), np.diag(LandingWeights().Q)),
        np.kron(np.eye(n), np.diag(LandingWeights().R)),
    )
    QG = Q @ Gamma
    assert QG.T.shape[1] != 3 * n + l * n
    linear = np.concatenate((-Q @ Phi @ X0, np.zeros(3 * n)))
    assert linear.size != 3 * n  # 13 n numbers for 3 n inputs: the map is missing
    qp = landing(n)
    assert qp.P.shape == (3 * n + l * n,) * 2
    assert_allclose(qp.P[: 3 * n, : 3 * n], 2 * (QG.T @ QG + R.T @ R), atol=1e-12)
    stacked = np.vstack((QG, R))
    assert_allclose(qp.q[: 3 * n], -2 * stacked.T @ linear, atol=1e-9)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_the_landing_costs_what_it_says(n):
    rng, weights = np.random.default_rng(n), LandingWeights()
    wanted = rng.normal(size=(n, 10))
    qp = landing(n, wanted=wanted)
    A, B = discretize(*landing_model(), DT)

    def flown(u):
        x, total = X0, 0.0
        for k in range(n):
            x = A @ x + B @ u[k]
            total += np.sum((weights.Q * (x - wanted[k])) ** 2) + np.sum((weights.R * u[k]) ** 2)
        return total

    def told(u):
        z = np.concatenate((u.ravel(), np.zeros(10 * n)))
        return 0.5 * z @ qp.P @ z + qp.q @ z

    u, w = rng.normal(size=(2, n, 3))
    assert told(u) - told(w) == pytest.approx(flown(u) - flown(w))


def test_slacks_boxes_and_an_interior_point_land_alike():
    for n in (2, 6):
        qp = landing(n, x0=np.array((-3.0, 9.0, 0.5, 0.0, 1.0, -1.0, 0.0, 0.2, 2.0, -3.0)))
        small = without_slacks(qp, 3 * n)
        assert np.isfinite(small.soft).sum() == 10 * n
        u = best(small)
        assert (small.A[3 * n :] @ u > small.u[3 * n :] + 0.01).any()  # it is too fast to help it
        assert cost(small, u) <= cost(small, solved(qp)[: 3 * n]) + 1e-5
        assert_allclose(solve(qp).z[: 3 * n], u, atol=2e-3)  # the cost is flat there


def test_a_short_horizon_lands_slowly_unless_its_end_is_weighed_for_all_that_follows():
    # Errata: 0.1 s in steps of 50 ms is N = 2.
    A, B = discretize(*landing_model(), DT)
    weights = LandingWeights()

    def slowest(n, w):
        wide = SoftRows(np.zeros((0, 10)), np.zeros(0))
        qp = landing(n, w, soft=wide)
        Phi, Gamma = prediction_matrices(A, B, n)
        Q = np.kron(np.eye(n), np.diag(w.Q))
        if w.end is not None:
            Q[-10:, -10:] = w.end
        K = np.linalg.solve(qp.P, 2 * (Q @ Gamma).T @ Q @ Phi)[:3]  # no limit: a linear law
        return np.abs(np.linalg.eigvals(A - B @ K)).max()

    endless = with_endless_horizon(weights, DT)
    X = solve_discrete_are(A, B, np.diag(np.square(weights.Q)), np.diag(np.square(weights.R)))
    K = np.linalg.solve(np.diag(np.square(weights.R)) + B.T @ X @ B, B.T @ X @ A)
    lqr = np.abs(np.linalg.eigvals(A - B @ K)).max()
    assert slowest(2, weights) > 0.98  # 2.5 s and more
    assert slowest(20, weights) < 0.97
    for n in (2, 5):
        assert slowest(n, endless) == pytest.approx(lqr, abs=1e-9)


# Solutions --------------------------------------------------------------------------------------------


def test_the_answer_solves_soft_rows_and_says_what_it_costs():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        qp = force(rng.normal(size=3) * (5.0, 2.5, 1.0), float(rng.uniform(-2, 2)))
        plan, exact = solve(qp), Solver(qp).solve(qp.q, qp.l, qp.u)
        assert_allclose(plan.z, exact.z, atol=1e-5)
        assert plan.cost == pytest.approx(exact.cost, rel=1e-6)
        assert_allclose(qp.P @ plan.z + qp.q + qp.A.T @ plan.y, 0.0, atol=1e-3)


def test_no_answer_is_a_value_and_no_number_is_an_error():
    qp = force((0.0, 3.0, 0.0))
    impossible = qp._replace(soft=hard(qp.l.size))
    warm = Plan(np.arange(N, dtype=float), np.zeros(qp.l.size), "solved", 0.0, 1)
    plan = solve(impossible, warm)
    assert plan.status == INFEASIBLE
    assert_array_equal(plan.z, warm.z)
    assert_array_equal(solve(impossible).z, 0.0)
    with pytest.raises(BadInput, match="q\\[0\\] of the QP = nan"):
        solve(force((np.nan, 0.0, 0.0)))
