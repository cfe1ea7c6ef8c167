"""Lab 06, the reference answers: predictions, the two quadratic programmes of the papers, and a solver for them.

Papers: MRS is Baca et al. 2021, Landing is Tzoumanikas et al. 2019. Numbers in comments are their equations; where the
errata correct one, the line says so.
"""

# canary-5e0c7d1b94a8f26370d9b1c4

from __future__ import annotations

from math import isfinite

import numpy as np
from scipy.linalg import expm

from uavlab.limits import AxisLimits, ForceLimits
from uavlab.qp import INFEASIBLE, LATE, QP, SOLVED, Plan, checked, hard, slacked, unslacked
from uavlab.types import Array, Estimate, Reference
from uavlab.weights import (
    HORIZONTAL,
    ForceWeights,
    InputBounds,
    LandingModel,
    LandingWeights,
    SoftRows,
    landing_model,
)

TRUSTED = 1.5  # times a limit: from there on the estimate is not where a plan begins (MRS software)
SLACK = 1e-8  # weight of each slack squared, which makes P definite (errata of Landing 27)

# Predictions ------------------------------------------------------------------------------------------


def discretize(A: Array, B: Array, dt: float) -> tuple[Array, Array]:
    """Exact steps of a linear model whose input is held (Landing eq. 18)."""
    n, k = B.shape
    both = np.zeros((n + k, n + k))
    both[:n, :n], both[:n, n:] = A, B
    step = expm(both * dt)  # (18), errata: times B; as one exponential, for A has no inverse
    return step[:n, :n], step[:n, n:]


def prediction_matrices(A: Array, B: Array, N: int) -> tuple[Array, Array]:
    """All states of a horizon from the first state and all inputs (Landing eq. 23)."""
    n, k = B.shape
    Phi, Gamma = np.zeros((N * n, n)), np.zeros((N * n, N * k))
    row, power = np.zeros((n, N * k)), np.eye(n)
    for i in range(N):
        row = A @ row
        row[:, i * k : (i + 1) * k] = B  # each row is the one above, one step older
        power = A @ power
        Phi[i * n : (i + 1) * n], Gamma[i * n : (i + 1) * n] = power, row  # (23)
    return Phi, Gamma


def initial_state(estimate: Estimate, reference: Reference, limits: ForceLimits) -> Array:
    """The estimate, where it keeps the limits; else the reference (MRS eq. 45)."""
    axes = (limits.horizontal, limits.horizontal, limits.vertical)
    most = TRUSTED * np.array([(axis.v, axis.a) for axis in axes])
    measured = np.column_stack((estimate.v, estimate.a))
    wanted = np.column_stack((reference.v, reference.a))
    kept = np.where(np.abs(measured) < most, measured, wanted)  # (45), errata: each by itself
    return np.column_stack((estimate.r, kept))


# Programmes -------------------------------------------------------------------------------------------


def build_force_qp(
    x0: Array,
    reference: Array,
    last_input: float,
    *,
    limits: AxisLimits,
    N: int,
    dt: float,
    p: float = 0.0,
    weights: ForceWeights = HORIZONTAL,
    period: float = 0.01,
    price: float = 1e4,
) -> QP:
    """The plan of one axis of the force MPC (MRS eq. 46-52)."""
    A = np.array(((1.0, dt, 0.5 * dt**2), (0.0, 1.0, dt), (0.0, 0.0, p)))  # (41), (10)
    B = np.array(((0.0,), (0.0,), (1.0 - p,)))  # (42)
    Phi, Gamma = prediction_matrices(A, B, N)  # (47)
    W = np.diag(np.concatenate((np.tile(weights.Q, N - 1), weights.S)))  # (46), errata: no halves
    P = 2.0 * Gamma.T @ W @ Gamma
    q = 2.0 * Gamma.T @ W @ (Phi @ x0 - np.ravel(reference))  # (43)

    rows, l, u, soft = [np.eye(N)], [np.full(N, -limits.a)], [np.full(N, limits.a)], [hard(N)]
    if isfinite(limits.v):
        v = (Phi @ x0)[
            1::3
        ]  # v_1 is among them, which no input changes: soft, or x0 could forbid all
        rows.append(Gamma[1::3])
        l.append(-limits.v - v)  # (49)
        u.append(limits.v - v)  # (48)
        soft.append(np.full(N, price))
    if isfinite(limits.j):
        most = np.full(N, limits.j * dt)
        most[0] = limits.j * period  # errata of (50): the first step, too, and it lasts one period
        last = np.zeros(N)
        last[0] = np.clip(last_input, -limits.a, limits.a)
        rows.append(np.eye(N) - np.eye(N, k=-1))
        l.append(last - most)  # (51)
        u.append(last + most)  # (50)
        soft.append(hard(N))
    return QP(P, q, np.vstack(rows), *(np.concatenate(x) for x in (l, u, soft)))


def build_soft_qp(
    x0: Array,
    reference: Array,
    *,
    weights: LandingWeights,
    bounds: InputBounds,
    soft: SoftRows,
    N: int,
    dt: float,
    model: LandingModel = LandingModel(),
) -> QP:
    """The plan of the landing, with a slack for every soft row and step (Landing eq. 27)."""
    Phi, Gamma = prediction_matrices(*discretize(*landing_model(model), dt), N)
    Q = np.kron(np.eye(N), np.diag(weights.Q))
    if weights.end is not None:
        Q[-10:, -10:] = weights.end
    R = np.kron(np.eye(N), np.diag(weights.R))
    l = len(soft.h)
    H = (Q @ Gamma).T @ (Q @ Gamma) + R.T @ R  # (24); errata of (27): it multiplies, and R'R
    e = Phi @ x0 - np.broadcast_to(reference, (N, 10)).ravel()
    q = (Q @ Gamma).T @ (
        Q @ e
    )  # errata of (27): times the stacked map, as (24) has it; inputs to 0
    P = SLACK * np.eye((3 + l) * N)
    P[: 3 * N, : 3 * N] = 2.0 * H  # a QP has 1/2 in front of P
    G = np.kron(np.eye(N), soft.G)
    A = np.block([
        [np.eye(3 * N), np.zeros((3 * N, l * N))],
        [G @ Gamma, -np.eye(l * N)],
        [np.zeros((l * N, 3 * N)), np.eye(l * N)],
    ])
    least = np.concatenate((np.tile(bounds.lower, N), np.full(l * N, -np.inf), np.zeros(l * N)))
    most = np.tile(soft.h, N) - G @ Phi @ x0
    most = np.concatenate((np.tile(bounds.upper, N), most, np.full(l * N, np.inf)))
    return QP(
        P, np.concatenate((2.0 * q, np.full(l * N, soft.price))), A, least, most, hard(most.size)
    )


def solve(qp: QP, warm: Plan | None = None) -> Plan:
    """A plan by OSQP, soft rows with slacks (Landing eq. 26)."""
    import osqp
    from scipy.sparse import csc_matrix, triu

    qp = checked(qp)
    hardened = slacked(qp)  # (26)
    solver = osqp.OSQP()
    solver.setup(
        csc_matrix(triu(hardened.P)), hardened.q, csc_matrix(hardened.A), hardened.l, hardened.u,
        eps_abs=1e-7, eps_rel=1e-7, max_iter=100_000, polishing=True, verbose=False,
        adaptive_rho_interval=200,  # seldom: with prices of 1e4 it else goes to and fro for ever
    )  # fmt: skip
    if warm is not None and np.isfinite(warm.z).all():
        slacks = np.zeros(hardened.q.size - qp.q.size)
        solver.warm_start(x=np.concatenate((warm.z, slacks)))
    found = solver.solve(raise_error=False)
    status = {"solved": SOLVED, "primal infeasible": INFEASIBLE}.get(found.info.status, LATE)
    if status != SOLVED:
        z, y = (np.zeros(qp.q.size), np.zeros(qp.l.size)) if warm is None else warm[:2]
        return Plan(z, y, status, np.inf, found.info.iter)
    plan = Plan(found.x, found.y, status, found.info.obj_val, found.info.iter)
    return unslacked(qp, plan)
