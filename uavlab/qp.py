"""Quadratic programs: what every predictive controller hands to a solver, and what it gets back.

Minimise ``1/2 z'P z + q'z`` over z, subject to ``l <= A z <= u``. A row may be soft: missing it by 1 costs its price
(the exact L1 penalty of Landing eq. 25), so that no disturbance leaves the problem without an answer.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.types import Array

SOLVED, INFEASIBLE, LATE = "solved", "infeasible", "not finished"


class QP(NamedTuple):
    """Minimise ``1/2 z'P z + q'z`` subject to ``l <= A z <= u``."""

    P: Array  # (n, n) symmetric, no negative eigenvalue
    q: Array  # (n,)
    A: Array  # (m, n)
    l: Array  # (m,) −inf: no bound from below
    u: Array  # (m,) inf: no bound from above
    soft: Array  # (m,) price of each unit by which a row is missed; inf: the row is hard


class Plan(NamedTuple):
    """What a solver found. Where it found nothing, `status` says so, and z is the warm start or zeros."""

    z: Array  # (n,)
    y: Array  # (m,) multipliers: P z + q + A'y = 0; above 0 where u holds z back, below 0 where l does
    status: str  # SOLVED, INFEASIBLE or LATE
    cost: float  # 1/2 z'P z + q'z, and what the soft rows cost
    iterations: int

    @property
    def ok(self) -> bool:
        """Whether z is the answer."""
        return self.status == SOLVED


def hard(m: int) -> Array:
    """Prices of `m` rows none of which may be missed: all inf, shape (m,)."""
    return np.full(m, inf)


def cost(qp: QP, z: Array) -> float:
    """What `z` (n,) costs: ``1/2 z'P z + q'z``, and the price of every soft row that it misses."""
    soft = np.isfinite(qp.soft)
    Az = qp.A[soft] @ z
    missed = np.maximum(np.maximum(Az - qp.u[soft], qp.l[soft] - Az), 0.0)
    return float(0.5 * z @ qp.P @ z + qp.q @ z + qp.soft[soft] @ missed)


def checked(qp: QP) -> QP:
    """The same problem, if it is one.

    Parameters
    ----------
    qp : QP
        With n variables and m rows.

    Returns
    -------
    QP
        The same, as arrays of float64.

    Raises
    ------
    BadInput
        A shape that does not fit, NaN, an infinity where a number must stand, l above u, a price that is not
        above 0, or a P that is not symmetric or has a negative eigenvalue.
    """
    qp = QP(*(np.asarray(x, dtype=float) for x in qp))
    n, m = qp.q.size, qp.l.size
    shapes = QP((n, n), (n,), (m, n), (m,), (m,), (m,))  # type: ignore[arg-type]
    for name, value, shape in zip(QP._fields, qp, shapes, strict=True):
        if value.shape != shape:
            raise BadInput(
                f"{name} of the QP has shape {value.shape}; {shape} fits q and l (n = {n}, m = {m})."
            )
        bad = np.isnan(value) if name in {"l", "u", "soft"} else ~np.isfinite(value)
        if bad.any():
            at = tuple(int(i) for i in np.argwhere(bad)[0])
            raise BadInput(
                f"{name}{list(at)} of the QP = {value[at]}: only numbers make a problem. "
                "Look at the estimate and the reference that it was built from."
            )
    _check_limits(qp)
    _check_convex(qp.P)
    return qp


def _check_limits(qp: QP) -> None:
    crossed = np.flatnonzero(qp.l > qp.u)
    if crossed.size:
        i = int(crossed[0])
        raise BadInput(
            f"row {i} of the QP wants at least l = {qp.l[i]:g} and at most u = {qp.u[i]:g}: "
            "no number is both. Swap them, or widen the limits."
        )
    if (free := np.flatnonzero(qp.soft <= 0.0)).size:
        i = int(free[0])
        raise BadInput(f"soft[{i}] of the QP = {qp.soft[i]:g}: a price is above 0 (inf: hard).")


def _check_convex(P: Array) -> None:
    size = float(np.abs(P).max(initial=0.0))
    if np.abs(P - P.T).max(initial=0.0) > 1e-9 * size:
        raise BadInput("P of the QP is not symmetric: take (P + P.T) / 2.")
    least = float(np.linalg.eigvalsh(P)[0]) if P.size else 0.0
    if least < -1e-9 * size:
        raise BadInput(
            f"P of the QP has the eigenvalue {least:.3g}: with one below 0 no cost is the least. "
            "Weights must not be negative."
        )


def slacked(qp: QP) -> QP:
    """The same problem with hard rows only: each soft row gets a slack variable (Landing eq. 26).

    Parameters
    ----------
    qp : QP
        With n variables and m rows, k of them soft.

    Returns
    -------
    QP
        Variables ``[z, s]`` (n + k). Rows: the m old ones, soft ones as ``a'z − s <= u``; then k rows
        ``a'z + s >= l``; then k rows ``s >= 0``. Each unit of a slack costs the price of its row.
    """
    soft = np.flatnonzero(np.isfinite(qp.soft))
    n, m, k = qp.q.size, qp.l.size, soft.size
    P = np.zeros((n + k, n + k))
    P[:n, :n] = qp.P
    A = np.zeros((m + 2 * k, n + k))
    A[:m, :n], A[m : m + k, :n] = qp.A, qp.A[soft]
    A[soft, n + np.arange(k)] = -1.0
    A[m:, n:] = np.vstack((np.eye(k), np.eye(k)))
    l = np.concatenate((qp.l, qp.l[soft], np.zeros(k)))
    u = np.concatenate((qp.u, np.full(2 * k, inf)))
    l[soft] = -inf
    return QP(P, np.concatenate((qp.q, qp.soft[soft])), A, l, u, hard(m + 2 * k))


def unslacked(qp: QP, plan: Plan) -> Plan:
    """A plan for ``slacked(qp)``, told as one for `qp`: without the slacks, the two rows of a soft one added."""
    soft = np.flatnonzero(np.isfinite(qp.soft))
    n, m, k = qp.q.size, qp.l.size, soft.size
    y = plan.y[:m].copy()
    y[soft] += plan.y[m : m + k]
    z = plan.z[:n]
    return plan._replace(z=z, y=y, cost=cost(qp, z))


def without_slacks(qp: QP, n: int) -> QP:
    """The same problem with soft rows in place of slack variables: the way back from Landing eq. (27).

    Parameters
    ----------
    qp : QP
        Its variables from number n on are slacks: each has a price in q, stands in one row (with z) and in one
        of its own that keeps it from falling below 0. What P says of them is dropped.
    n : int
        How many variables are none.

    Returns
    -------
    QP
        Of n variables; a row that had a slack is soft, at its price.

    Raises
    ------
    BadInput
        A variable from n on is no slack.
    """
    A, S = qp.A[:, :n], qp.A[:, n:]
    keeps = A.any(axis=1) | ~S.any(axis=1)
    A, S = A[keeps], S[keeps]
    if (np.abs(S).sum(axis=0) != 1.0).any() or (np.count_nonzero(S, axis=1) > 1).any():
        raise BadInput(
            f"the variables of the QP from {n} on are no slacks, each with -1 or 1 in one row."
        )
    soft = np.where(S.any(axis=1), np.abs(S) @ qp.q[n:], qp.soft[keeps])
    return QP(qp.P[:n, :n], qp.q[:n], A, qp.l[keeps], qp.u[keeps], soft)
