"""Lab 06, right answers written in other ways than the reference: all must get full marks."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import expm
from scipy.sparse import csc_matrix

from grader.material import variant
from grader.variants.mpc_parts import *  # noqa: F403  the two parts
from uavlab.exercises.mpc import (
    build_force_qp,
    build_soft_qp,
    discretize,
    initial_state,
    prediction_matrices,
    solve,
)
from uavlab.qp import INFEASIBLE, LATE, QP, SOLVED, Plan, checked, cost, slacked
from uavlab.solvers import Osqp, Solver
from uavlab.weights import HORIZONTAL, LandingModel, landing_model

CANARY = "canary-f8ba77d8c0a9dc8119799f54"


@variant(discretize)
def by_a_series(A, B, dt):
    """Taylor's series of a short step, then doubled."""
    n = len(A)
    short = dt / 1024
    term, total = np.eye(n), np.eye(n)
    for i in range(1, 8):
        term = term @ A * short / (i + 1)
        total = total + term
    B_d = total @ B * short
    A_d = np.eye(n) + A @ total * short
    for _ in range(10):
        A_d, B_d = A_d @ A_d, A_d @ B_d + B_d
    return A_d, B_d


@variant(discretize)
def column_by_column(A, B, dt):
    A_d, columns = expm(dt * A), []
    for b in B.T:
        big = np.zeros((len(A) + 1,) * 2)
        big[:-1, :-1], big[:-1, -1] = A, b
        columns.append(expm(big * dt)[:-1, -1])
    return A_d, np.array(columns).T


@variant(prediction_matrices)
def as_blocks(A, B, N):
    powers = [np.eye(len(A))]
    for _ in range(N):
        powers.append(powers[-1] @ A)
    none = np.zeros(np.shape(B))
    rows = [[powers[i - j] @ B if j <= i else none for j in range(N)] for i in range(N)]
    return np.concatenate(powers[1:]), np.block(rows)


@variant(prediction_matrices)
def by_trying(A, B, N):
    """Fly each unit vector."""
    n, k = B.shape

    def fly(x, u):
        out = []
        for i in range(N):
            x = A @ x + B @ u[i]
            out.append(x)
        return np.concatenate(out)

    still = np.zeros((N, k))
    Phi = [fly(e, still) for e in np.eye(n)]
    Gamma = [fly(np.zeros(n), e.reshape(N, k)) for e in np.eye(N * k)]
    return np.transpose(Phi), np.transpose(Gamma)


@variant(initial_state)
def in_a_loop(estimate, reference, limits):
    rows = []
    for i in range(3):
        most = limits.vertical if i == 2 else limits.horizontal
        v = reference.v[i] if abs(estimate.v[i]) >= 1.5 * most.v else estimate.v[i]
        a = reference.a[i] if abs(estimate.a[i]) >= 1.5 * most.a else estimate.a[i]
        rows.append([estimate.r[i], v, a])
    return rows


@variant(initial_state)
def by_masks(estimate, reference, limits):
    x = np.array([estimate.r, estimate.v, estimate.a]).T
    wish = np.array([reference.r, reference.v, reference.a]).T
    h, w = limits
    most = 1.5 * np.array([[math.inf, h.v, h.a]] * 2 + [[math.inf, w.v, w.a]])
    far = np.abs(x) >= most
    x[far] = wish[far]
    return x


@variant(build_force_qp)
def squares_of_a_stacked_map(
    x0, reference, last_input, *, limits, N, dt, p=0.0, weights=HORIZONTAL, period=0.01, price=1e4,
):  # fmt: skip
    """Least squares of what unit inputs do; rows in another order, scaled, one-sided."""

    def fly(x, u):
        out = []
        for one in u:
            x = np.array([
                x[0] + dt * x[1] + dt * dt * x[2] / 2,
                x[1] + dt * x[2],
                p * x[2] + (1 - p) * one,
            ])
            out.append(x)
        return np.array(out)

    free = fly(np.asarray(x0, float), np.zeros(N))
    pushed = np.array([fly(np.zeros(3), e) for e in np.eye(N)])  # (N inputs, N steps, 3)
    root = np.sqrt(np.array([weights.Q] * (N - 1) + [weights.S]))
    M = (pushed * root).reshape(N, -1).T
    b = ((np.asarray(reference) - free) * root).ravel()
    rows, l, soft = [], [], []
    last = min(max(last_input, -limits.a), limits.a)
    for i in range(N):
        e, speed = np.eye(N)[i], pushed[:, i, 1]
        step, far, from_ = (
            (e - np.eye(N)[i - 1], limits.j * dt, 0.0) if i else (e, limits.j * period, last)
        )
        for s in (1.0, -1.0):
            kinds = [(-s * speed, s * free[i, 1] - limits.v, price)]
            kinds += [(-7.0 * s * step, -7.0 * (far + s * from_), math.inf)]
            kinds += [(s * e / limits.a, -1.0, math.inf)]
            for row, least, cost_of in kinds[not i :]:  # v_1 is decided
                if math.isfinite(least):
                    rows.append(row)
                    l.append(least)
                    soft.append(cost_of)
    return QP(
        2 * M.T @ M,
        -2 * M.T @ b,
        np.array(rows),
        np.array(l),
        np.full(len(l), np.inf),
        np.array(soft),
    )


@variant(build_force_qp)
def by_lifting(
    x0, reference, last_input, *, limits, N, dt, p=0.0, weights=HORIZONTAL, period=0.01, price=1e4,
):  # fmt: skip
    """The states from one system of equations for all steps; rows scaled, prices with them."""
    A = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, p]])
    B = np.array([0, 0, 1 - p])
    L = np.linalg.inv(np.eye(3 * N) - np.kron(np.eye(N, k=-1), A))
    M, start = L @ np.kron(np.eye(N), B[:, None]), L[:, :3] @ A @ x0
    w = np.concatenate([*[weights.Q] * (N - 1), weights.S])
    q = 2 * (M.T * w) @ (start - np.concatenate(list(reference)))
    v, V = start[1::3], M[1::3]
    D = np.eye(N) - np.eye(N, k=-1)
    d = np.append(limits.j * period, np.full(N - 1, limits.j * dt))
    c = np.zeros(N)
    c[0] = np.clip(last_input, -limits.a, limits.a)
    a = np.full(N, limits.a)
    none = np.full(N, np.inf)
    return QP(
        2 * (M.T * w) @ M, q, np.vstack([D, 10 * V, np.eye(N)]),
        np.concatenate([c - d, -10 * (limits.v + v), -a]), np.concatenate([c + d, 10 * (limits.v - v), a]),
        np.concatenate([none, np.full(N, price / 10), none]),
    )  # fmt: skip


def landing_maps(N, dt, model):
    A, B = landing_model(model)
    both = expm(np.vstack([np.hstack([A, B]), np.zeros((3, 13))]) * dt)
    A, B = both[:10, :10], both[:10, 10:]
    L = np.linalg.inv(np.eye(10 * N) - np.kron(np.eye(N, k=-1), A))
    return L[:, :10] @ A, L @ np.kron(np.eye(N), B)


@variant(build_soft_qp)
def rows_of_the_paper(x0, reference, *, weights, bounds, soft, N, dt, model=LandingModel()):
    """One-sided rows, as (27) has them."""
    Phi, Gamma = landing_maps(N, dt, model)
    l, m = len(soft.h) * N, 3 * N
    QC = np.kron(np.eye(N), np.diag(weights.Q))
    if weights.end is not None:
        QC[-10:, -10:] = np.array(weights.end)
    M = np.vstack([QC @ Gamma, np.kron(np.eye(N), np.diag(weights.R))])
    wish = np.tile(reference, N) if np.ndim(reference) == 1 else np.reshape(reference, -1)
    b = np.append(QC @ (wish - Phi @ x0), np.zeros(m))
    P = np.zeros((m + l, m + l))
    P[:m, :m] = 2 * M.T @ M
    P[m:, m:] = 1e-8 * np.eye(l)
    G = np.kron(np.eye(N), soft.G)
    one, zero = np.eye(m), np.zeros
    A = np.vstack([
        np.hstack([one, zero((m, l))]), np.hstack([-one, zero((m, l))]),
        np.hstack([G @ Gamma, -np.eye(l)]), np.hstack([zero((l, m)), -np.eye(l)]),
    ])  # fmt: skip
    u = np.concatenate([
        np.tile(bounds.upper, N), -np.tile(bounds.lower, N), np.tile(soft.h, N) - G @ Phi @ x0, zero(l),
    ])  # fmt: skip
    q = np.append(-2 * M.T @ b, np.full(l, soft.price))
    return QP(P, q, A, np.full(len(u), -np.inf), u, np.full(len(u), np.inf))


@variant(build_soft_qp)
def step_after_step(x0, reference, *, weights, bounds, soft, N, dt, model=LandingModel()):
    """Sums over the steps, and a row at a time."""
    Phi, Gamma = landing_maps(N, dt, model)
    k = len(soft.h)
    n = 3 * N + k * N
    P, q = 1e-8 * np.eye(n), np.zeros(n)
    P[: 3 * N, : 3 * N] = 2 * np.diag(np.tile(np.square(weights.R), N))
    q[3 * N :] = soft.price
    rows, least, most = (
        [np.eye(n)],
        [*bounds.lower * N, *[0.0] * (k * N)],
        [*bounds.upper * N, *[math.inf] * (k * N)],
    )
    for i in range(N):
        M, free = Gamma[10 * i : 10 * i + 10], Phi[10 * i : 10 * i + 10] @ x0
        W = np.diag(weights.Q) if weights.end is None or i < N - 1 else np.array(weights.end)
        wish = reference if np.ndim(reference) == 1 else reference[i]
        P[: 3 * N, : 3 * N] += 2 * M.T @ W.T @ W @ M
        q[: 3 * N] += 2 * M.T @ W.T @ W @ (free - wish)
        for r in range(k):
            row = np.append(soft.G[r] @ M, -np.eye(k * N)[i * k + r])
            rows.append(3.0 * row[None])
            least.append(-math.inf)
            most.append(3.0 * float(soft.h[r] - soft.G[r] @ free))
    A = np.vstack(rows)
    return QP(P, q, A, np.array(least), np.array(most), np.full(len(A), np.inf))


@variant(solve)
def by_the_shipped_one(qp, warm=None):
    return Osqp(qp).solve(qp.q, qp.l, qp.u, warm)


@variant(solve)
def by_an_active_set(qp, warm=None):
    """Not what is asked for, but right."""
    plan = Solver(qp).solve(qp.q, qp.l, qp.u)
    if plan.ok:
        return plan._replace(cost=cost(qp, plan.z))
    return plan if warm is None else plan._replace(z=warm.z)


@variant(solve)
def with_a_warm_start(qp, warm=None):
    import osqp

    checked(qp)
    n, m = len(qp.q), len(qp.l)
    big = slacked(qp)
    solver = osqp.OSQP()
    solver.setup(
        csc_matrix(big.P), big.q, csc_matrix(big.A), np.maximum(big.l, -1e30), np.minimum(big.u, 1e30),
        verbose=False, polishing=True, eps_abs=1e-7, eps_rel=1e-7, max_iter=200_000,
    )  # fmt: skip
    if warm is not None:
        solver.warm_start(x=np.append(warm.z, np.zeros(len(big.q) - n)))
    got = solver.solve()
    if got.info.status != "solved":
        z = np.zeros(n) if warm is None else warm.z
        status = INFEASIBLE if "infeasible" in got.info.status else LATE
        return Plan(z, np.zeros(m), status, math.inf, got.info.iter)
    y = np.array(got.y[:m])
    soft = np.flatnonzero(np.isfinite(qp.soft))
    y[soft] += got.y[m : m + len(soft)]
    return Plan(got.x[:n], y, SOLVED, cost(qp, got.x[:n]), got.info.iter)
