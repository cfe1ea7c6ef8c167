"""Known wrong answers of lab 06, continued: the two programmes, each with one thing in it that is wrong."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from scipy.linalg import block_diag, expm

from grader.hidden.mpc_qps import exact, problem, weighed
from grader.material import Play, mutant, sample
from uavlab.exercises import programmes
from uavlab.exercises.mpc import build_force_qp, build_soft_qp
from uavlab.limits import AxisLimits
from uavlab.qp import QP
from uavlab.types import Array
from uavlab.weights import HORIZONTAL, LandingModel, landing_model

CANARY = "canary-ed8ce8af26da67ba666bddde"


def told(f: Any, given: tuple, named: dict, n: int, points: Array, ways: Array) -> list[Array]:
    """What a programme means: the same for any order and scale of its rows."""
    said = programmes.meaning(programmes.read(f(*given, **named), n), points, ways)
    return [said.costs[:-1] / (1.0 + np.abs(said.costs[:-1]).max()), said.ways]


def but_for(f: Any, what: str) -> Any:
    """The right answer, but for one thing."""

    def answer(*given: Any, **named: Any) -> QP:
        return f(*given, **named, wrong=what)

    answer.__name__ = f"{f.__name__}_{what}".replace(" ", "_")
    return answer


def stacked(A: Array, B: Array, N: int) -> tuple[Array, Array]:
    n, k = B.shape
    Phi, Gamma = [], np.zeros((N * n, N * k))
    for i in range(N):
        Phi.append(np.linalg.matrix_power(A, i + 1))
        for j in range(i + 1):
            Gamma[n * i : n * i + n, k * j : k * j + k] = np.linalg.matrix_power(A, i - j) @ B
    return np.vstack(Phi), Gamma


# The force --------------------------------------------------------------------------------------------


@sample(build_force_qp)
def forces(rng: np.random.Generator) -> list[Play]:
    made = []
    for p, j, last in ((0.0, 4.0, 0.2), (0.5, 4.0, -0.3), (0.0, np.inf, 0.1), (0.0, 5.0, 20.0)):
        N, dt, a = 5, float(rng.uniform(0.1, 0.2)), float(rng.uniform(7.0, 9.0))
        named = {
            "limits": AxisLimits(float(rng.uniform(0.5, 1.0)), a, j, np.inf), "N": N, "dt": dt, "p": p,
            "weights": weighed(rng), "period": float(rng.uniform(0.01, 0.03)), "price": float(rng.uniform(50, 90)),
        }  # fmt: skip
        given = (rng.normal(size=3), rng.normal(size=(N, 3)), last)
        held = np.full(N, float(np.clip(last, -a, a)))
        points = np.vstack((held, rng.uniform(-a, a, size=(4, N))))
        ways = np.vstack((rng.normal(size=(6, N)), np.ones(N), -np.ones(N)))
        made.append(partial(told, given=given, named=named, n=N, points=points, ways=ways))
    return made


def force(
    x0, reference, last_input, *, limits, N, dt, p=0.0, weights=HORIZONTAL, period=0.01, price=1e4, wrong="",
):  # fmt: skip
    """The right programme, but for one thing that is named."""
    if wrong == "no lag":
        p = 0.0
    half = {"no square": 0.0, "whole square": 1.0}.get(wrong, 0.5)
    A = np.array([[1.0, dt, half * dt**2], [0.0, 1.0, dt], [0.0, 0.0, p]])
    B = np.array([[0.0], [0.0], [1.0 if wrong == "whole input" else 1.0 - p]])
    if wrong == "at once":
        B = np.array([[0.5 * dt**2], [dt], [1.0]]) * (1.0 - p)
        A[:2, 2] = 0.0
    Phi, Gamma = stacked(A, B, N)
    Q, S = weights
    if wrong == "swapped":
        Q, S = S, Q
    S = Q if wrong == "no end" else S
    W = block_diag(*[np.diag(Q)] * (N - 1), np.diag(S))
    if wrong == "half":
        W[:-3, :-3] *= 0.5
    wish = np.asarray(reference)
    if wrong == "shifted":
        wish = np.vstack((wish[1:], wish[-1:]))
    if wrong == "position only":
        wish = wish * (1.0, 0.0, 0.0)
    P = Gamma.T @ W @ Gamma * (1.0 if wrong == "factor" else 2.0)
    q = 2.0 * Gamma.T @ W @ (Phi @ x0 - wish.ravel())
    rows, l, u, soft = _rows(Phi @ x0, Gamma, last_input, limits, dt, period, price, wrong)
    return QP(P, -q if wrong == "sign" else q, rows, l, u, soft)


def _rows(free, Gamma, last_input, limits, dt, period, price, wrong):
    N = Gamma.shape[1]
    a = np.inf if wrong == "no a" else limits.a
    rows, least, most, soft = [np.eye(N)], [np.full(N, -a)], [np.full(N, a)], [np.full(N, np.inf)]
    if wrong != "no v":
        cost = np.inf if wrong == "hard" else 1e4 if wrong == "one price" else price
        fast = limits.v * np.ones(N)
        low = np.full(N, -np.inf) if wrong == "one side" else -fast - free[1::3]
        rows, least, most = [*rows, Gamma[1::3]], [*least, low], [*most, fast - free[1::3]]
        soft.append(np.full(N, cost))
    if np.isfinite(limits.j) and wrong != "no slew":
        size = limits.j * np.array([period, *[dt] * (N - 1)])
        size[0] = limits.j * dt if wrong == "dt first" else size[0]
        size[0] = np.inf if wrong == "first free" else size[0]
        if wrong == "period later":
            size[1:] = limits.j * period
        if wrong == "j alone":
            size[:] = limits.j
        start = last_input if wrong == "not clipped" else np.clip(last_input, -limits.a, limits.a)
        start = 0.0 if wrong == "from zero" else start
        start = start * np.eye(N)[0]
        rows.append(np.eye(N) - np.eye(N, k=-1))
        least, most, soft = (
            [*least, start - size],
            [*most, start + size],
            [*soft, np.full(N, np.inf)],
        )
    return np.vstack(rows), *(np.concatenate(x) for x in (least, most, soft))


FORCE = {
    "first free": "The first input may be anything: (50) and (51) lack i = 1, with the last input before it.",
    "dt first": "The first input may change by j dt: after one period there is a new plan, so it is j period.",
    "period later": "Later inputs may change by j period only: between them lies dt.",
    "from zero": "The first input is held against 0: the last input was another one.",
    "not clipped": "A last input beyond ±a leaves no plan: take it as ±a.",
    "no slew": "The slew is not limited.",
    "j alone": "The slew is limited by j: multiply it by the time between the inputs.",
    "no a": "The inputs are not limited by a.",
    "hard": "The velocities are hard: a start that is too fast leaves no plan.",
    "no v": "The velocities are not limited.",
    "one side": "Only velocities above 0 are limited: those below −v cost as much.",
    "one price": "The price is a fixed one: use the one that is given.",
    "no lag": "p is ignored: after a step the share p of the acceleration is left.",
    "whole input": "The input is not multiplied by 1 − p.",
    "no square": "The position lacks the dt²/2 of the acceleration.",
    "whole square": "The position gains dt² of the acceleration: half of it is right.",
    "at once": "The input moves position and velocity in its own step: in (10) it reaches the acceleration only.",
    "factor": "A QP has ½ before P: P lacks a factor of 2.",
    "half": "The weights of the last state count double: take plain sums.",
    "no end": "S is not used: it weighs the last state.",
    "swapped": "Q and S have changed places: S weighs the last state only.",
    "shifted": "The reference is shifted by a step: its first row is wanted at step 1.",
    "position only": "Only positions are wanted: velocities and accelerations of the reference count, too.",
    "sign": "The sign of q is wrong: it flies away from the reference.",
}
for what, hint in FORCE.items():
    globals()[f"force_{what}"] = mutant(build_force_qp, hint=hint)(but_for(force, what))


# The landing ------------------------------------------------------------------------------------------


@sample(build_soft_qp)
def landings(rng: np.random.Generator) -> list[Play]:
    made = []
    for N, l, kind in ((3, 2, ""), (2, 3, "moving"), (2, 1, "end"), (2, 2, "moving")):
        weights, bounds, soft, model = problem(rng, l)
        if kind == "end":
            weights = weights._replace(end=tuple(map(tuple, rng.normal(size=(10, 10)))))
        wish = rng.normal(size=(N, 10)) if kind == "moving" else rng.normal(size=10)
        named = {
            "weights": weights, "bounds": bounds, "soft": soft, "N": N,
            "dt": float(rng.uniform(0.05, 0.2)), "model": model,
        }  # fmt: skip
        x0 = (-1.5 if l == 1 else 1.5) * soft.G[0] + 0.5 * rng.normal(size=10)  # kept, or missed
        n = 3 * N + l * N
        points = np.abs(rng.uniform(-1.0, 1.0, size=(6, n)))
        points[-1, : 3 * N], points[-1, 3 * N :] = 0.0, 5.0 if l == 1 else 60.0
        ways = np.vstack((np.eye(n), -np.eye(n), rng.normal(size=(6, n))))
        made.append(
            partial(
                told,
                given=(x0, wish), named=named, n=n, points=points, ways=ways,
            )
        )  # fmt: skip
    return made


def landing(x0, reference, *, weights, bounds, soft, N, dt, model=LandingModel(), wrong=""):
    """The right programme, but for one thing that is named."""
    if wrong == "own model":
        model = LandingModel()
    A, B = landing_model(model)
    A_d, B_d = exact(A, B, dt)
    if wrong == "euler":
        A_d, B_d = np.eye(10) + A * dt, B * dt
    if wrong == "held":
        B_d = expm(A * dt) @ B * dt
    Phi, Gamma = stacked(A_d, B_d, N)
    Q, R = np.diag(weights.Q), np.diag(weights.R)
    end = Q if weights.end is None or wrong == "end" else np.array(weights.end)
    Q = block_diag(*[Q] * (N - 1), end)
    QQ = Q if wrong == "Q" else Q.T @ Q
    RR = np.kron(np.eye(N), R if wrong == "R" else R.T @ R)
    wish = np.broadcast_to(reference, (N, 10))
    if wrong == "stacked":
        wish = wish.ravel(order="F").reshape(N, 10)
    if wrong == "first":
        wish = np.broadcast_to(wish[0], (N, 10))
    H = Gamma.T @ QQ @ Gamma + (0.0 if wrong == "no R" else RR)
    g = 2.0 * Gamma.T @ QQ @ (Phi @ x0 - wish.ravel())
    l = len(soft.h)
    P = block_diag((1.0 if wrong == "factor" else 2.0) * H, 1e-8 * np.eye(l * N))
    q = np.append(g, np.full(l * N, 0.0 if wrong == "free" else soft.price))
    rows, least, most = _fence(Phi @ x0, Gamma, bounds, soft, wrong)
    return QP(P, q, rows, least, most, np.full(len(rows), np.inf))


def _fence(free, Gamma, bounds, soft, wrong):
    N, l = Gamma.shape[1] // 3, len(soft.h)
    G = np.kron(np.eye(N), soft.G)
    sign = 1.0 if wrong == "signs" else -1.0
    S = np.zeros((l * N, l * N)) if wrong == "no slack" else sign * np.eye(l * N)
    if wrong == "first slacks":
        S = -np.kron(np.eye(N)[:, :1] @ np.ones((1, N)), np.eye(l)).T
    if wrong == "order":
        S = S[np.arange(l * N).reshape(N, l).T.ravel()]
    rows = np.block([
        [np.eye(3 * N), np.zeros((3 * N, l * N))],
        [G @ Gamma, S],
        [np.zeros((l * N, 3 * N)), np.eye(l * N)],
    ])
    h = np.tile(soft.h, N) - (0.0 if wrong == "from rest" else G @ free)
    low, high = np.tile(bounds.lower, N), np.tile(bounds.upper, N)
    if wrong == "symmetric":
        low = -high
    below = np.full(l * N, -np.inf) if wrong == "negative" else np.zeros(l * N)
    above = np.full(l * N, 100.0 if wrong == "bounded" else np.inf)
    least = np.concatenate((low, np.full(l * N, -np.inf), below))
    return rows, least, np.concatenate((high, h, above))


LANDING = {
    "free": "Slacks cost nothing: q lacks their price.",
    "R": "R is not squared: inputs weigh ‖R u‖².",
    "Q": "Q is not squared: errors weigh ‖Q e‖².",
    "no R": "Inputs do not weigh anything: R is missing in P.",
    "factor": "A QP has ½ before P: P lacks a factor of 2.",
    "end": "The last state has a weight of its own, weights.end, if that is given.",
    "stacked": "The reference is stacked number by number: stack it step by step, as the states.",
    "first": "Of a reference that moves only the first row is used.",
    "own model": "The model that is given is not used.",
    "euler": "The model is discretized by Euler's step: use your exact one.",
    "held": "The input acts at the start of the step only: it is held.",
    "from rest": "The soft rows forget where the flight begins: G Phi x_0 belongs on the other side.",
    "no slack": "The slacks are not in the soft rows: these are hard now.",
    "signs": "The slacks tighten their rows: they are to be subtracted.",
    "first slacks": "All steps share the slacks of the first one: each has its own.",
    "order": "Slacks are ordered row by row: those of one step stand together.",
    "negative": "Slacks may be negative: then they earn their price.",
    "bounded": "The slacks have an upper bound: a row may be missed by any length.",
    "symmetric": "The least input is taken for the negative of the largest one.",
}
for what, hint in LANDING.items():
    globals()[f"landing_{what}"] = mutant(build_soft_qp, hint=hint)(but_for(landing, what))
