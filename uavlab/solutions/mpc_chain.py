"""Lab 06, the reference answers: the programme of one axis of the MPC tracker (MRS Sec. 4.1).

The axis is a chain of position, velocity, acceleration and jerk, driven by snap. Jerk and snap are hard, and always can
be kept; speed and acceleration are soft, at a price that is paid only while they cannot be kept: no state leaves the
problem without an answer.
"""

# canary-4a9e27d0c15b83f6e0d2b794

from __future__ import annotations

from functools import lru_cache
from math import factorial
from typing import NamedTuple

import numpy as np

from uavlab.limits import Limits
from uavlab.qp import QP, Plan, hard
from uavlab.solvers import Solver
from uavlab.types import Array

TAU = 0.35  # [s] two poles with which a goal is reached: p + 2 tau v + tau² a is weighed ...
BRAKE = 0.25  # ... or this share of v/a, if longer: from full speed it brakes in time, and stays within 2 cm
JERK, SNAP = 0.003, 0.001  # [s⁶], [s⁸] what a jerk and a snap cost, beside position squared
PRICE = 3e4  # of a m/s or m/s² too much: above what a goal would pay for it, as far as `near` lets one pull
KEPT = 0.995  # of the limits of speed and acceleration is planned with; the rest is for what lies between the rows
FINE, NEAR = 4, 5  # rows for each of the first steps: a plan is flown by a small part of a step


class Machine(NamedTuple):
    """The programme of one axis, factored; what of it depends on the state and the goal is a product."""

    tau: float  # [s], see TAU
    t: Array  # (N,) [s] ends of the steps
    root: Array  # (N,) a variable of the programme is a snap times this
    Phi: Array  # (N, 4, 4) the states at t, without any snap
    cost: Array  # (N, 4 N) errors of these states → q
    rows: Array  # (2 K + N, 4) speeds, accelerations, jerks that are limited, without any snap
    K: int  # how many speeds and accelerations are limited
    solver: Solver


def chain(dt: float) -> tuple[Array, Array]:
    """Exact step of position, velocity, acceleration and jerk under a constant snap: A (4, 4), b (4,)."""
    A, b = np.eye(4), np.zeros(4)
    for i in range(4):
        b[i] = dt ** (4 - i) / factorial(4 - i)
        for j in range(i + 1, 4):
            A[i, j] = dt ** (j - i) / factorial(j - i)
    return A, b


class Horizon(NamedTuple):
    """States along a plan: ``Phi x + Gamma z``, at the ends of its N steps and at K finer times."""

    Phi: Array  # (N, 4, 4)
    Gamma: Array  # (N, 4, N)
    fine: Array  # (K, 4, 4)
    fine_gamma: Array  # (K, 4, N)


def horizon(spans: Array) -> Horizon:
    """Predictions over steps of `spans` (N,) [s]; the first NEAR whole steps are looked at FINE times each."""
    N = len(spans)
    Phi, Gamma, fine = np.zeros((N, 4, 4)), np.zeros((N, 4, N)), []
    P, G = np.eye(4), np.zeros((4, N))
    for k, span in enumerate(spans):
        parts = FINE if 1 <= k <= NEAR else 1
        for i in range(1, parts + 1):
            A, b = chain(span * i / parts)
            Phi[k], Gamma[k] = A @ P, A @ G
            Gamma[k, :, k] += b
            fine.append((Phi[k].copy(), Gamma[k].copy()))
        P, G = Phi[k], Gamma[k]
    return Horizon(Phi, Gamma, *(np.array(x) for x in zip(*fine, strict=True)))


@lru_cache(maxsize=64)
def machine(N: int, dt: float, period: float, tau: float) -> Machine:
    """The programme of N steps: the first as long as a tick of the tracker, the others `dt` [s]."""
    spans = np.full(N, dt)
    spans[0] = period
    Phi, Gamma, free, forced = horizon(spans)
    share = spans / dt  # the integral of a cost, not a sum: the first step is short
    root = np.sqrt(share)
    Gamma, forced, K = Gamma / root, forced / root, len(free)
    c = np.array((1.0, 2.0 * tau, tau**2, 0.0))
    Q = np.outer(c, c) + np.diag((0.0, 0.0, 0.0, JERK))
    cost = 2.0 * np.einsum("k,kin,ij->nkj", share, Gamma, Q).reshape(N, 4 * N)
    P = cost @ Gamma.reshape(4 * N, N) + 2.0 * SNAP * np.eye(N)

    A = np.concatenate((np.eye(N), forced[:, 1], forced[:, 2], Gamma[:, 3]))
    rows = np.concatenate((free[:, 1], free[:, 2], Phi[:, 3]))
    soft = np.concatenate((hard(N), np.full(2 * K, PRICE), hard(N)))
    one = np.ones(len(A))
    solver = Solver(QP((P + P.T) / 2.0, np.zeros(N), A, -one, one, soft))
    return Machine(tau, np.cumsum(spans), root, Phi, cost, rows, K, solver)


@lru_cache(maxsize=64)
def boxes(limits: Limits) -> Array:
    """Limits as (4 axes, 2 directions, 4 derivatives from speed to snap): upwards, downwards."""
    h, turn = limits.horizontal, limits.heading
    box = np.array(((h, h), (h, h), (limits.up, limits.down), (turn, turn)), dtype=float)
    box.setflags(write=False)
    return box


def slowness(box: Array) -> float:
    """The tau [s] for the limits (2, 4) of an axis."""
    v, a = box[:, 0].max(), box[:, 1].min()
    return max(TAU, BRAKE * v / a) if v / a < 4.0 else 1.0


def solved(m: Machine, x: Array, wanted: Array, box: Array) -> Plan:
    """The plan of one axis.

    Parameters
    ----------
    m : Machine
        Of this axis.
    x, wanted : Array
        State (4,); states that are wanted (N, 4).
    box : Array
        Limits (2, 4), upwards and downwards.
    """
    q = m.cost @ (m.Phi @ x - wanted).ravel()
    free = np.concatenate((np.zeros(len(m.t)), m.rows @ x))
    high = _reach(m, box[0], x[3] - box[1, 3] * m.t) - free
    low = -_reach(m, box[1], -x[3] - box[0, 3] * m.t) - free
    return m.solver.solve(q, low, high)


def _reach(m: Machine, most: Array, back: Array) -> Array:
    """How far each row may go in one direction: to its limit of `most` (4,); or, a jerk, to where it can be brought."""
    v, a, j, s = most
    fair = np.full(2 * m.K, KEPT * v)
    fair[m.K :] = KEPT * a
    return np.concatenate((m.root * s, fair, np.maximum(j, back + 1e-9 * np.abs(back))))
