"""Known wrong answers of lab 06, continued: solutions of programmes."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.linalg import solve_triangular

from grader.hidden.mpc import with_prices
from grader.material import Play, mutant, sample
from uavlab.exercises import programmes
from uavlab.exercises.mpc import solve
from uavlab.exercises.mpc_checks import solved_by_hand
from uavlab.qp import INFEASIBLE, QP, SOLVED, Plan, cost, hard
from uavlab.solvers import Solver

CANARY = "canary-48c98e7ec13347e9ba9c3e3b"


def answered(f, qp: QP, warm: Plan | None = None) -> list:
    """What a solver says, to as many digits as any right one has."""
    plan = programmes.read_plan(f(qp, warm), len(qp.q), len(qp.l))
    told = plan.cost if plan.status == SOLVED else 0.0
    return [np.round(plan.z, 2), plan.status, round(told, 2)]


def refused(f, qp: QP) -> list:
    """Whether a solver refuses something."""
    try:
        f(qp)
    except ValueError:
        return [1.0]
    return [0.0]


def excluded(qp: QP) -> QP:
    """Rows of which each excludes the other."""
    row = qp.A[0]
    l, u = np.array((0.5, -np.inf)), np.array((np.inf, -0.5))
    return qp._replace(A=np.vstack((row, row)), l=l, u=u, soft=hard(2))


@sample(solve)
def programmes_to_solve(rng: np.random.Generator) -> list[Play]:
    qp, _, _ = solved_by_hand(rng, 3, 5)
    soft, _, _ = with_prices(rng, 3, 6)
    none = excluded(qp)
    warm = Plan(rng.normal(size=3), np.zeros(2), SOLVED, 0.0, 1)
    return [
        partial(answered, qp=qp), partial(answered, qp=soft), partial(answered, qp=none),
        partial(answered, qp=none, warm=warm), partial(refused, qp=qp._replace(q=qp.q * np.nan)),
    ]  # fmt: skip


def solved(qp: QP, warm: Plan | None = None) -> Plan:
    """The right answer, by another solver."""
    plan = Solver(qp).solve(qp.q, qp.l, qp.u)
    if not plan.ok and warm is not None:
        return plan._replace(z=warm.z)
    return plan._replace(cost=cost(qp, plan.z)) if plan.ok else plan


@mutant(solve, hint="Where no z is allowed it raises an error: that is a status.")
def raises(qp, warm=None):
    plan = solved(qp, warm)
    if not plan.ok:
        raise RuntimeError(plan.status)
    return plan


@mutant(solve, hint="Soft rows are treated as hard: they may be missed, at their price.")
def soft_as_hard(qp, warm=None):
    return solved(qp._replace(soft=hard(len(qp.l))), warm)


@mutant(solve, hint="Soft rows are left out: missing them has a price.")
def soft_left_out(qp, warm=None):
    is_hard = np.isinf(qp.soft)
    l, u = np.where(is_hard, qp.l, -np.inf), np.where(is_hard, qp.u, np.inf)
    return solved(qp._replace(l=l, u=u), warm)


@mutant(solve, hint="The cost lacks the price of what is missed.")
def price_not_told(qp, warm=None):
    plan = solved(qp, warm)
    return plan._replace(cost=float(0.5 * plan.z @ qp.P @ plan.z + qp.q @ plan.z))


@mutant(solve, hint="It always says solved: tell when there is no solution.")
def always_solved(qp, warm=None):
    return solved(qp, warm)._replace(status=SOLVED, cost=0.0 * len(qp.l))


@mutant(
    solve, hint="What is not finite is taken: it must raise ValueError (uavlab.qp.checked does)."
)
def takes_anything(qp, warm=None):
    if np.isnan(qp.q).any():
        return Plan(np.zeros(len(qp.q)), np.zeros(len(qp.l)), INFEASIBLE, np.inf, 0)
    return solved(qp, warm)


@mutant(solve, hint="Without a solution z is zero: it must be that of the plan to begin with.")
def forgets_the_plan_before(qp, warm=None):
    return solved(qp)


@mutant(solve, hint="No row is kept: this is the lowest point of the cost, wherever it is.")
def no_rows_at_all(qp, warm=None):
    if np.isnan(qp.q).any():
        raise ValueError
    root = np.linalg.cholesky(qp.P)
    z = -solve_triangular(root.T, solve_triangular(root, qp.q, lower=True))
    return Plan(z, np.zeros(len(qp.l)), SOLVED, cost(qp, z), 1)


@mutant(solve, hint="The price of missing a row is its square here: each unit costs the same.")
def squared_prices(qp, warm=None):
    soft = np.isfinite(qp.soft)
    n, k = len(qp.q), int(soft.sum())
    P = np.zeros((n + k, n + k))
    P[:n, :n], P[n:, n:] = qp.P, np.diag(qp.soft[soft])
    A = np.hstack((qp.A, np.zeros((len(qp.l), k))))
    A[soft, n:] = np.eye(k)
    plan = solved(QP(P, np.append(qp.q, np.zeros(k)), A, qp.l, qp.u, hard(len(qp.l))), None)
    if not plan.ok:
        return solved(qp, warm)
    return plan._replace(z=plan.z[:n], cost=cost(qp, plan.z[:n]))
