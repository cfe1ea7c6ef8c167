"""Lab 06, hidden checks, continued: what the two programmes allow and cost, whatever order and scale rows have."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from grader.material import hidden
from uavlab.exercises import programmes
from uavlab.exercises.mpc import build_force_qp, build_soft_qp
from uavlab.exercises.mpc_checks import flight_cost, flown
from uavlab.exercises.spec import Function, expect
from uavlab.limits import AxisLimits
from uavlab.qp import QP
from uavlab.solvers import Solver
from uavlab.types import Array
from uavlab.weights import (
    HORIZONTAL,
    VERTICAL,
    ForceWeights,
    InputBounds,
    LandingModel,
    LandingWeights,
    SoftRows,
    landing_model,
)

CANARY = "canary-52fa1014ab23cd98a5c8c01a"

INF = np.inf


def weighed(rng: np.random.Generator) -> ForceWeights:
    """Weights of which no two are alike."""
    return ForceWeights(
        tuple(rng.uniform(1.0, 9.0, size=3)), tuple(rng.uniform(10.0, 20.0, size=3))
    )


# The force --------------------------------------------------------------------------------------------


@hidden(build_force_qp, weight=2.0)
def costs_of_any_flight(f: Function, rng: np.random.Generator) -> None:
    """For any weights, step, lag and moving reference, plans must differ in cost as their flights do."""
    for p, N in ((0.0, 5), (0.5, 7), (float(rng.uniform(0.1, 0.9)), 1)):
        dt, x0, wanted = float(rng.uniform(0.05, 0.3)), rng.normal(size=3), rng.normal(size=(N, 3))
        limits, weights = AxisLimits(1e3, 5.0, INF, INF), weighed(rng)
        qp = programmes.read(f(x0, wanted, 0.3, limits=limits, N=N, dt=dt, p=p, weights=weights), N)
        plans = rng.uniform(-5.0, 5.0, size=(6, N))
        costs = [flight_cost(flown(x0, z, dt, p), wanted, weights) for z in plans]
        programmes.expect_costs(qp, plans, costs, "Some plan costs something else.")


@hidden(build_force_qp, weight=2.0)
def too_fast_costs_its_price(f: Function, rng: np.random.Generator) -> None:
    """Each m/s beyond the limit, at each step and in both directions, must cost its price, and be allowed."""
    for p in (0.0, 0.5):
        N, dt, price = 6, float(rng.uniform(0.1, 0.3)), float(rng.uniform(50.0, 500.0))
        x0, wanted, v = np.array((0.0, rng.normal(), rng.normal())), rng.normal(size=(N, 3)), 0.8
        limits = AxisLimits(v, 6.0, INF, INF)
        qp = programmes.read(
            f(x0, wanted, 0.0, limits=limits, N=N, dt=dt, p=p, weights=VERTICAL, price=price), N
        )
        plans, costs = rng.uniform(-6.0, 6.0, size=(8, N)), []
        for z in plans:
            states = flown(x0, z, dt, p)
            missed = np.maximum(np.abs(states[:, 1]) - v, 0.0).sum()
            costs.append(flight_cost(states, wanted, VERTICAL) + price * missed)
        programmes.expect_costs(qp, plans, costs, "A speed beyond its limit costs something else.")
        expect(min(programmes.way(qp, z, z * 1e-3) for z in plans) >= 0.0, "A plan is forbidden.")


def fence(N: int, a: float, j: float, dt: float, period: float, last: float) -> QP:
    """The hard rows of the force controller, as a programme without a cost."""
    rows, most = [np.eye(N)], [np.full(N, a)]
    least = [np.full(N, -a)]
    if np.isfinite(j):
        step = np.eye(N) - np.eye(N, k=-1)
        size = j * np.array([period, *[dt] * (N - 1)])
        start = last * np.eye(N)[0]
        rows, least, most = [*rows, step], [*least, start - size], [*most, start + size]
    A = np.vstack(rows)
    return QP(
        np.eye(N), np.zeros(N), A, np.concatenate(least), np.concatenate(most), np.full(len(A), INF)
    )


@hidden(build_force_qp, weight=2.0)
def what_may_be_flown(f: Function, rng: np.random.Generator) -> None:
    """Inputs and their changes, the first one too, must be bounded by what is asked for, and by nothing else."""
    for p, j in (
        (0.0, float(rng.uniform(3.0, 8.0))),
        (0.5, float(rng.uniform(3.0, 8.0))),
        (0.5, INF),
    ):
        N, dt, period = 6, float(rng.uniform(0.04, 0.2)), float(rng.uniform(0.005, 0.03))
        a, last = float(rng.uniform(1.0, 3.0)), float(rng.uniform(-0.9, 0.9))
        limits, x0 = AxisLimits(1.0, a, j, INF), rng.normal(size=3)
        qp = programmes.read(
            f(x0, rng.normal(size=(N, 3)), last, limits=limits, N=N, dt=dt, p=p, period=period), N
        )
        true, ways = fence(N, a, j, dt, period, last), rng.normal(size=(12, N))
        held = np.full(N, last)
        far = [programmes.way(true, held, w) for w in ways]
        programmes.expect_ways(qp, held, ways, far, "It allows other inputs.")
        edge = held + 0.999 * far[0] * ways[0]  # and from the edge on
        far = [programmes.way(true, edge, w) for w in ways]
        programmes.expect_ways(qp, edge, ways, far, "It allows other inputs.")


@hidden(build_force_qp)
def there_is_always_a_plan(f: Function, rng: np.random.Generator) -> None:
    """From any state, also one far too fast, and from any last input, there must be a plan."""
    N, dt, a = 5, 0.05, float(rng.uniform(1.0, 3.0))
    limits = AxisLimits(float(rng.uniform(0.5, 2.0)), a, 5.0, INF)
    for last, start in ((4.0 * a, a), (-4.0 * a, -a), (0.5 * a, 0.5 * a)):
        x0 = 20.0 * rng.normal(size=3)
        qp = programmes.read(f(x0, np.zeros((N, 3)), last, limits=limits, N=N, dt=dt), N)
        away = -np.sign(start) * np.ones(N)
        far = [5.0 * 0.01 + 0.0]
        programmes.expect_ways(qp, np.full(N, start), (away,), far, "A last input beyond ±a is ±a.")


@hidden(build_force_qp)
def the_best_plan(f: Function, rng: np.random.Generator) -> None:
    """The best of all plans must be the best flight: no plan near it that is allowed flies better."""
    N, dt = 8, 0.1
    x0, wanted = np.array((0.0, rng.normal(), 0.0)), np.zeros((N, 3))
    wanted[:, 0] = rng.uniform(2.0, 4.0)
    limits = AxisLimits(1.0, 2.0, 5.0, INF)
    qp = programmes.read(f(x0, wanted, 0.1, limits=limits, N=N, dt=dt), N)
    best = Solver(qp).solve(qp.q, qp.l, qp.u)
    expect(best.ok, "There must be a plan.")
    true = fence(N, 2.0, 5.0, dt, 0.01, 0.1)

    def cost(z: Array) -> float:
        states = flown(x0, z, dt, 0.0)
        missed = np.maximum(np.abs(states[:, 1]) - 1.0, 0.0).sum()
        return flight_cost(states, wanted, HORIZONTAL) + 1e4 * missed

    at = 0.999999 * best.z + 1e-6 * 0.1  # a little inwards
    for way in rng.normal(size=(10, N)):
        step = min(0.5 * programmes.way(true, at, way), 0.05)
        expect(step >= 0.0, "The best plan is one that is forbidden.")
        expect(cost(at + step * way) >= cost(at) - 1e-2, "Another plan flies better.")


# The landing ------------------------------------------------------------------------------------------


def problem(
    rng: np.random.Generator, l: int
) -> tuple[LandingWeights, InputBounds, SoftRows, LandingModel]:
    """Weights, bounds, soft rows and a model of which no two numbers are alike."""
    Q, R = rng.uniform(0.5, 2.0, size=10), rng.uniform(0.5, 2.0, size=3)
    bounds = InputBounds(
        tuple(-rng.uniform(0.2, 1.0, size=3)), tuple(rng.uniform(0.2, 1.0, size=3))
    )
    soft = SoftRows(
        rng.normal(size=(l, 10)), rng.uniform(0.5, 2.0, size=l), float(rng.uniform(20, 90))
    )
    c, b = rng.uniform(0.1, 0.4, size=3), rng.uniform(8.0, 12.0, size=3)
    return LandingWeights(tuple(Q), tuple(R)), bounds, soft, LandingModel(tuple(c), tuple(b))


def exact(A: Array, B: Array, dt: float) -> tuple[Array, Array]:
    """One step of a model with a held input, by the exponential of both."""
    n, k = B.shape
    flow = expm(dt * np.block([[A, B], [np.zeros((k, n + k))]]))
    return flow[:n, :n], flow[:n, n:]


def landed(x0: Array, inputs: Array, dt: float, model: LandingModel) -> Array:
    """States after each input (N, 3): (N, 10)."""
    A, B = exact(*landing_model(model), dt)
    states = []
    for u in inputs:
        x0 = A @ x0 + B @ u
        states.append(x0)
    return np.array(states)


@hidden(build_soft_qp, weight=2.0)
def costs_of_any_landing(f: Function, rng: np.random.Generator) -> None:
    """For any weights, model and moving reference, plans must differ in cost by what (20) and (25) say."""
    for N, l in ((3, 1), (2, 3)):
        weights, bounds, soft, model = problem(rng, l)
        dt, x0, wanted = (
            float(rng.uniform(0.03, 0.2)),
            rng.normal(size=10),
            rng.normal(size=(N, 10)),
        )
        if l == 3:
            weights = weights._replace(end=tuple(map(tuple, rng.normal(size=(10, 10)))))
        end = np.diag(weights.Q) if weights.end is None else np.array(weights.end)
        got = f(x0, wanted, weights=weights, bounds=bounds, soft=soft, N=N, dt=dt, model=model)
        qp = programmes.read(got, 3 * N + l * N)
        plans, costs = rng.uniform(-1.0, 1.0, size=(8, 3 * N + l * N)), []
        plans[:, 3 * N :] = np.abs(plans[:, 3 * N :])
        for z in plans:
            u = z[: 3 * N].reshape(N, 3)
            e = landed(x0, u, dt, model) - wanted
            weighed_e = [*(e[:-1] * weights.Q), end @ e[-1]]
            J = (np.square(weighed_e)).sum() + ((u * weights.R) ** 2).sum()
            costs.append(J + soft.price * z[3 * N :].sum())
        programmes.expect_costs(qp, plans, costs, "Some plan costs something else.")


@hidden(build_soft_qp, weight=2.0)
def what_may_be_landed(f: Function, rng: np.random.Generator) -> None:
    """Inputs, soft rows of each step with the slacks of that step, and slacks must be bounded as asked, and no more."""
    N, l = 3, 2
    weights, bounds, soft, model = problem(rng, l)
    dt, x0 = float(rng.uniform(0.03, 0.2)), 2.0 * rng.normal(size=10)
    got = f(x0, np.zeros(10), weights=weights, bounds=bounds, soft=soft, N=N, dt=dt, model=model)
    qp, size = programmes.read(got, 3 * N + l * N), 3 * N + l * N
    free = soft.G @ landed(x0, np.zeros((N, 3)), dt, model).T  # (l, N)
    reach = np.array([
        (soft.G @ landed(np.zeros(10), np.eye(3 * N)[i].reshape(N, 3), dt, model).T).T.ravel()
        for i in range(3 * N)
    ]).T
    rows = np.block([
        [np.eye(3 * N), np.zeros((3 * N, l * N))],
        [reach, -np.eye(l * N)],
        [np.zeros((l * N, 3 * N)), np.eye(l * N)],
    ])
    least = np.concatenate((np.tile(bounds.lower, N), np.full(l * N, -INF), np.zeros(l * N)))
    most = np.concatenate((
        np.tile(bounds.upper, N),
        (soft.h[:, None] - free).T.ravel(),
        np.full(l * N, INF),
    ))
    true = QP(np.eye(size), np.zeros(size), rows, least, most, np.full(len(rows), INF))
    z = np.concatenate((np.zeros(3 * N), np.maximum(-most[3 * N : -l * N], 0.0) + 0.3))
    ways = [*np.eye(size), *-np.eye(size), *rng.normal(size=(20, size))]
    far = [programmes.way(true, z, w) for w in ways]
    programmes.expect_ways(qp, z, ways, far, "It allows other plans.")


@hidden(build_soft_qp)
def every_row_is_hard(f: Function, rng: np.random.Generator) -> None:
    """The slacks are what is soft: no row may have a price of its own, and P must leave no direction free."""
    N, l = 2, 2
    weights, bounds, soft, model = problem(rng, l)
    args = {"weights": weights, "bounds": bounds, "soft": soft, "N": N, "dt": 0.05, "model": model}
    qp = programmes.read(f(rng.normal(size=10), rng.normal(size=10), **args), 3 * N + l * N)
    expect(np.isinf(qp.soft).all(), "A row has a price.")
    expect(np.linalg.eigvalsh(qp.P)[0] > 0.0, "P leaves a direction free.")
    expect(np.linalg.eigvalsh(qp.P)[0] < 1e-3, "Slacks are to cost their price alone.")


@hidden(build_soft_qp)
def a_far_too_fast_start(f: Function, rng: np.random.Generator) -> None:
    """From a state that breaks its soft rows there must be a plan, with slacks as large as what it misses."""
    N, dt = 4, 0.05
    rows = SoftRows(np.vstack((np.eye(10)[9], -np.eye(10)[9])), np.full(2, 1.0), 1e3)
    x0 = np.zeros(10)
    x0[9] = float(rng.uniform(3.0, 5.0)) * rng.choice((-1.0, 1.0))
    args = {"weights": LandingWeights(), "bounds": InputBounds(), "soft": rows, "N": N, "dt": dt}
    qp = programmes.read(f(x0, np.zeros(10), **args), 5 * N)
    best = Solver(qp).solve(qp.q, qp.l, qp.u)
    expect(best.ok, "There must be a plan.")
    v = landed(x0, best.z[: 3 * N].reshape(N, 3), dt, LandingModel())[:, 9]
    missed = np.maximum(np.abs(v) - 1.0, 0.0)
    slacks = best.z[3 * N :].reshape(N, 2)
    expect(np.abs(slacks.sum(axis=1) - missed).max() < 1e-3, "Slacks are not what is missed.")
    expect(np.abs(v[0]) < np.abs(x0[9]) - 0.1, "It does not brake.")
