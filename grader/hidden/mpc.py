"""Lab 06, hidden checks: differential equations, impulse responses, limits to the last digit, and known solutions."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from grader.hidden.mpc_flight import *  # noqa: F403  the two parts
from grader.hidden.mpc_qps import *  # noqa: F403  the two programmes
from grader.hidden.mpc_qps import exact
from grader.material import hidden
from uavlab.exercises import draw, programmes
from uavlab.exercises.expect import expect_refusal, of_shapes
from uavlab.exercises.mpc import discretize, initial_state, prediction_matrices, solve
from uavlab.exercises.mpc_checks import solved_by_hand
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.limits import AxisLimits, ForceLimits
from uavlab.qp import INFEASIBLE, QP, SOLVED, hard
from uavlab.types import Array, Estimate, Reference
from uavlab.weights import landing_model

CANARY = "canary-d48e540c3f959aaaeadd7b6b"


def model(rng: np.random.Generator, n: int, k: int) -> tuple[Array, Array]:
    """A continuous model (n, n), (n, k), neither fast nor slow."""
    A = rng.normal(size=(n, n))
    return 1.5 * A / np.abs(np.linalg.eigvals(A)).max(), rng.normal(size=(n, k))


# Predictions ------------------------------------------------------------------------------------------


@hidden(discretize, weight=2.0)
def as_the_equation_flows(f: Function, rng: np.random.Generator) -> None:
    """After one step with a held input, x must be where the differential equation takes it."""
    for n, k in ((3, 1), (2, 2), (4, 3)):
        (A, B), dt = model(rng, n, k), float(rng.uniform(0.2, 0.8))
        A_d, B_d = of_shapes(f(A, B, dt), (n, n), (n, k))
        x, u = rng.normal(size=n), rng.normal(size=k)
        end = solve_ivp(lambda _t, y, A=A, b=B @ u: A @ y + b, (0.0, dt), x, rtol=1e-9, atol=1e-11)
        expect_close(A_d @ x + B_d @ u, end.y[:, -1], atol=1e-6)


@hidden(discretize)
def models_without_an_inverse(f: Function, rng: np.random.Generator) -> None:
    """Chains of integrators, and the model of the landing, must come out right, though their A has no inverse."""
    for n in (3, 4):
        dt = float(rng.uniform(0.05, 1.5))
        A_d, B_d = of_shapes(f(np.eye(n, k=1), np.eye(n)[:, -1:], dt), (n, n), (n, 1))
        powers = np.cumprod([1.0, *(dt / np.arange(1, n + 1))])  # dt^i / i!
        expect_close(A_d[0], powers[:n])
        expect_close(B_d[::-1, 0], powers[1:])
    dt = float(rng.uniform(0.02, 0.1))
    A_d, B_d = of_shapes(f(*landing_model(), dt), (10, 10), (10, 3))
    for got, want in zip((A_d, B_d), exact(*landing_model(), dt), strict=True):
        expect_close(got, want)


@hidden(discretize)
def a_steady_state_stays(f: Function, rng: np.random.Generator) -> None:
    """Where the equation stands still for some input, a step of any length must stand still, too."""
    for dt in (float(rng.uniform(0.05, 0.2)), float(rng.uniform(1.0, 3.0))):
        A, B = model(rng, 3, 2)
        A -= 2.0 * np.eye(3)
        u = rng.normal(size=2)
        x = -np.linalg.solve(A, B @ u)
        A_d, B_d = of_shapes(f(A, B, dt), (3, 3), (3, 2))
        expect_close(A_d @ x + B_d @ u, x, atol=1e-8)
        away = rng.normal(size=3)  # and it is reached in the end
        for _ in range(int(60.0 / dt)):
            away = A_d @ away + B_d @ u
        expect_close(away, x, atol=1e-6)


@hidden(prediction_matrices)
def pushed_once(f: Function, rng: np.random.Generator) -> None:
    """One input at one step must move the states after it only, and all of them as if it had come first."""
    n, k, N = 3, 2, 6
    A, B = rng.normal(size=(n, n)), rng.normal(size=(n, k))
    _, Gamma = of_shapes(f(A, B, N), (N * n, n), (N * n, N * k))
    told = Gamma.reshape(N, n, N, k)
    for i in range(N):
        for m in range(N):
            want = np.linalg.matrix_power(A, i - m) @ B if m <= i else np.zeros((n, k))
            expect_close(told[i, :, m], want)


@hidden(prediction_matrices)
def left_alone(f: Function, rng: np.random.Generator) -> None:
    """Without inputs the prediction must be the powers of A, from the first on; the state of now is not in it."""
    for n, N in ((2, 1), (3, 4), (4, 7)):
        A, B = rng.normal(size=(n, n)), rng.normal(size=(n, 1))
        Phi, Gamma = of_shapes(f(A, B, N), (N * n, n), (N * n, N))
        expect_close(Phi, np.vstack([np.linalg.matrix_power(A, i + 1) for i in range(N)]))
        expect_close(Gamma[:n, :1], B)


@hidden(prediction_matrices)
def of_a_longer_horizon(f: Function, rng: np.random.Generator) -> None:
    """The beginning of a long horizon must be a short one, and what follows must start where that ends."""
    n, k, N, more = 3, 1, 3, 4
    A, B = rng.normal(size=(n, n)), rng.normal(size=(n, k))
    Phi, Gamma = of_shapes(f(A, B, N + more), ((N + more) * n, n), ((N + more) * n, (N + more) * k))
    short, pushes = of_shapes(f(A, B, N), (N * n, n), (N * n, N * k))
    rest, later = of_shapes(f(A, B, more), (more * n, n), (more * n, more * k))
    expect_close(Phi[: N * n], short)
    expect_close(Gamma[: N * n, : N * k], pushes)
    expect_close(Phi[N * n :], rest @ short[-n:])
    expect_close(Gamma[N * n :], np.hstack((rest @ pushes[-n:], later)))
    x, u = rng.normal(size=n), rng.normal(size=1)
    expect_close(short[:n] @ x + pushes[:n, :k] @ u, A @ x + B @ u)


def bounds(rng: np.random.Generator) -> ForceLimits:
    """Limits of which no two are alike."""
    v, a, w, b = rng.uniform(1.0, 4.0, size=4)
    return ForceLimits(AxisLimits(v, a, 5.0, np.inf), AxisLimits(w, b, np.inf, np.inf))


def at(r: Array, v: Array, a: Array) -> Estimate:
    """An estimate that is told to tilt and to turn, which does not matter here."""
    return Estimate(r, v, a, np.eye(3), np.ones(3))


def wish(rng: np.random.Generator) -> Reference:
    """A reference."""
    return draw.reference(rng)


@hidden(initial_state, weight=2.0)
def at_one_and_a_half_times(f: Function, rng: np.random.Generator) -> None:
    """Below 1.5 times the limit the estimate counts, and from there on the reference."""
    for sign in (1.0, -1.0):
        limits, wanted = bounds(rng), wish(rng)
        axes = (limits.horizontal, limits.horizontal, limits.vertical)
        most = np.array([(x.v, x.a) for x in axes]).T
        r = draw.vector(rng, 9.0)
        below, above = sign * 1.49 * most, sign * 1.51 * most
        inside = numbers(f(at(r, *below), wanted, limits), (3, 3))
        expect_close(inside, np.column_stack((r, *below)))
        outside = numbers(f(at(r, *above), wanted, limits), (3, 3))
        expect_close(outside, np.column_stack((r, wanted.v, wanted.a)))


@hidden(initial_state)
def each_number_by_itself(f: Function, rng: np.random.Generator) -> None:
    """A number that breaks its limit must be replaced, and none of the five others with it."""
    limits, wanted = bounds(rng), wish(rng)
    axes = (limits.horizontal, limits.horizontal, limits.vertical)
    for axis in range(3):
        for kind in range(2):
            r = draw.vector(rng, 50.0)
            x = np.array([(0.9 * b.v, -0.9 * b.a) for b in axes]).T * rng.choice(
                (-1, 1), size=(2, 3)
            )
            x[kind, axis] *= 2.0
            want = np.column_stack((r, *x))
            want[axis, 1 + kind] = (wanted.v, wanted.a)[kind][axis]
            expect_close(numbers(f(at(r, *x), wanted, limits), (3, 3)), want)


@hidden(initial_state)
def limits_that_are_none(f: Function, rng: np.random.Generator) -> None:
    """Without limits all must be as measured; with some, the position is measured at any distance."""
    none = AxisLimits(np.inf, np.inf, np.inf, np.inf)
    x, wanted = 40.0 * rng.normal(size=(3, 3)), wish(rng)
    expect_close(numbers(f(at(*x), wanted, ForceLimits(none, none)), (3, 3)), x.T)
    x = 5e3 * (1.0 + rng.uniform(size=(3, 3)))
    got = numbers(f(at(*x), wanted, bounds(rng)), (3, 3))
    expect_close(got, np.column_stack((x[0], wanted.v, wanted.a)))
    some = bounds(rng)._replace(horizontal=none)
    got = numbers(f(at(*x), wanted, some), (3, 3))
    expect_close(got[:2], x.T[:2])
    expect_close(got[2], (x[0, 2], wanted.v[2], wanted.a[2]))


# Solutions --------------------------------------------------------------------------------------------


def with_prices(rng: np.random.Generator, n: int, m: int) -> tuple[QP, Array, float]:
    """A programme made around its solution, with rows that are worth missing: with that, and its cost."""
    qp, z, y = solved_by_hand(rng, n, m)
    soft = hard(m)
    missed = np.flatnonzero(y)[:2]
    soft[missed] = np.abs(y[missed])  # at its price a row is missed by any length
    length = rng.uniform(0.3, 1.0, size=missed.size)
    l, u = qp.l.copy(), qp.u.copy()
    for i, far in zip(missed, length, strict=True):
        if y[i] > 0.0:
            l[i], u[i] = l[i] - far, u[i] - far
        else:
            l[i], u[i] = l[i] + far, u[i] + far
    kept = np.flatnonzero(y)[2:]
    soft[kept] = 1.5 * np.abs(y[kept])  # and these are soft, but too dear to be missed
    qp = qp._replace(l=l, u=u, soft=soft)
    return qp, z, float(0.5 * z @ qp.P @ z + qp.q @ z + soft[missed] @ length)


@hidden(solve, weight=2.0)
def rows_at_their_price(f: Function, rng: np.random.Generator) -> None:
    """A soft row must be missed where that is worth its price, and kept where it is not; the cost is told with it."""
    for n, m in ((3, 6), (4, 9)):
        qp, z, cost = with_prices(rng, n, m)
        plan = programmes.read_plan(f(qp), n, m)
        expect(plan.status == SOLVED, "There is a solution.")
        expect_close(plan.z, z, atol=1e-3)
        expect_close(plan.cost, cost, atol=1e-3, rtol=1e-3)


@hidden(solve)
def what_nature_balances(f: Function, rng: np.random.Generator) -> None:
    """Multipliers must balance the slope of the cost, whichever way their signs are counted; equal bounds hold."""
    qp, z, y = solved_by_hand(rng, 5, 6)
    plan = programmes.read_plan(f(qp), 5, 6)
    expect_close(plan.z, z, atol=1e-3)
    expect(np.isfinite(plan.y).all(), "Multipliers must be finite.")
    off = min(np.abs(plan.y - y).max(), np.abs(plan.y + y).max())
    expect(off < 1e-2 * (1.0 + np.abs(y).max()), "Multipliers are others.")
    expect_close(plan.cost, 0.5 * z @ qp.P @ z + qp.q @ z, atol=1e-3, rtol=1e-3)
    A = rng.normal(size=(2, 4))
    point = rng.normal(size=4)
    qp = QP(np.eye(4), np.zeros(4), A, A @ point, A @ point, hard(2))
    plan = programmes.read_plan(f(qp), 4, 2)
    expect_close(plan.z, np.linalg.pinv(A) @ A @ point, atol=1e-3)  # the point that is nearest to 0


@hidden(solve)
def begun_elsewhere(f: Function, rng: np.random.Generator) -> None:
    """Whatever plan it is given to begin with, the solution must be the same; without one, z is that plan's."""
    qp, z, _ = solved_by_hand(rng, 4, 6)
    first = programmes.read_plan(f(qp), 4, 6)
    other, _, _ = solved_by_hand(rng, 4, 6)
    before = f(other)
    for warm in (first, before):
        plan = programmes.read_plan(f(qp, warm), 4, 6)
        expect(plan.status == SOLVED, "There is a solution.")
        expect_close(plan.z, z, atol=1e-3)
    row, gap = rng.normal(size=4), float(rng.uniform(0.5, 1.0))
    none = qp._replace(
        A=np.vstack((row, row)),
        l=np.array((gap, -np.inf)),
        u=np.array((np.inf, -gap)),
        soft=hard(2),
    )
    warm = first._replace(z=rng.normal(size=4), y=np.zeros(2))
    plan = programmes.read_plan(f(none, warm), 4, 2)
    expect(plan.status == INFEASIBLE, "There is no solution.")
    expect_close(plan.z, warm.z)
    expect_close(programmes.read_plan(f(none), 4, 2).z, np.zeros(4))
    priced = programmes.read_plan(f(none._replace(soft=np.full(2, 3.0))), 4, 2)
    expect(priced.status == SOLVED, "Rows that may be missed exclude nothing.")


@hidden(solve, weight=0.5)
def what_is_no_programme(f: Function, rng: np.random.Generator) -> None:
    """What is not finite, or does not fit, must raise ValueError; infinite bounds are fine."""
    qp, _, _ = solved_by_hand(rng, 3, 4)
    free = qp._replace(l=np.full(4, -np.inf), u=np.full(4, np.inf))
    plan = programmes.read_plan(f(free), 3, 4)
    expect_close(plan.z, -np.linalg.solve(qp.P, qp.q), atol=1e-3)
    wrong = qp.l.copy()
    wrong[1] = qp.u[1] + 1.0
    for bad in (
        qp._replace(P=qp.P * np.nan), qp._replace(A=qp.A * np.nan), qp._replace(l=qp.l * np.nan),
        qp._replace(q=qp.q[:2]), qp._replace(A=qp.A[:, :2]), qp._replace(l=wrong),
    ):  # fmt: skip
        expect_refusal(f, bad)
