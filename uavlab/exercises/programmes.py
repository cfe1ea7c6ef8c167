"""What a quadratic programme means: read from what it allows and costs, whatever order and scale its rows have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from uavlab import qp as programme
from uavlab.exercises.spec import WrongForm, expect
from uavlab.qp import QP, Plan
from uavlab.types import Array

FAR = 1e4  # a way out that is longer counts as none


class Meaning(NamedTuple):
    """A programme, asked at some points: two that differ in rows only have the same meaning."""

    costs: Array  # (K - 1,) what each further point costs more than the first
    ways: Array  # (K, D) from each point in each direction, how far until a hard row forbids it


def read(got: Any, n: int) -> QP:
    """`got` as plain arrays; fail the check unless it is a programme with `n` variables."""
    asked = f"A QP with {n} variables is asked for: P, q, A, l, u, soft, of shapes that fit."
    if not isinstance(got, tuple | list) or len(got) != 6:
        raise WrongForm(asked, asked)
    P, q, A, l, u, soft = (_plain(x, asked) for x in got)
    m = l.size
    fits = (P.shape, q.shape, A.shape) == ((n, n), (n,), (m, n)) and l.shape == u.shape == (m,)
    if not (fits and soft.shape == (m,)):
        raise WrongForm(asked, asked)
    expect(all(np.isfinite(x).all() for x in (P, q, A)), "P, q and A must be finite.")
    expect(not np.isnan([l, u, soft]).any(), "Bounds and prices must be numbers.")
    expect((l <= u).all(), "A row wants more than it allows.")
    expect((soft > 0.0).all(), "A price is above 0.")
    expect(np.abs(P - P.T).max() <= 1e-6 * np.abs(P).max(), "P must be symmetric.")
    return QP(0.5 * (P + P.T), q, A, l, u, soft)


def way(qp: QP, z: Array, direction: Array) -> float:
    """How far from `z` (n,) along `direction` (n,) the hard rows allow to go; −1 if `z` itself is forbidden."""
    is_hard = np.isinf(qp.soft)
    A, l, u = qp.A[is_hard], qp.l[is_hard], qp.u[is_hard]
    at, by = A @ z, A @ direction
    size = 1e-9 * (1.0 + np.abs(A) @ np.abs(z))
    if (at > u + size).any() or (at < l - size).any():
        return -1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        out = np.where(by > 0.0, (u - at) / by, np.where(by < 0.0, (l - at) / by, np.inf))
    return float(np.clip(out.min(initial=FAR), 0.0, FAR))


def meaning(
    qp: QP, points: Sequence[Array] | Array, directions: Sequence[Array] | Array
) -> Meaning:
    """What a programme says at some points (n,), and of the ways (n,) from there."""
    costs = np.array([programme.cost(qp, z) for z in points])
    ways = np.array([[way(qp, z, d) for d in directions] for z in points])
    return Meaning(costs[1:] - costs[0], ways)


def expect_costs(
    qp: QP, points: Sequence[Array] | Array, want: Sequence[float], message: str
) -> None:
    """Fail the check unless points (n,) differ in cost as `want` does; what is the same for all does not matter."""
    costs = np.array([programme.cost(qp, z) for z in points])
    off = np.abs((costs - costs[0]) - (np.asarray(want) - want[0]))
    expect(off.max() <= 1e-6 * (1.0 + np.ptp(np.asarray(want))), message)


def expect_ways(
    qp: QP, z: Array, directions: Sequence[Array] | Array, want: Sequence[float], message: str
) -> None:
    """Fail the check unless from `z` (n,) one can go as far as `want` in each direction (n,), and no further."""
    for direction, far in zip(directions, want, strict=True):
        got = way(qp, z, direction)
        expect(abs(got - min(far, FAR)) <= 1e-6 * (1.0 + min(far, FAR)), message)


def read_plan(got: Any, n: int, m: int) -> Plan:
    """`got` as plain numbers; fail the check unless it is a plan for `n` variables and `m` rows."""
    asked = f"A Plan is asked for: z of shape ({n},), y of shape ({m},), status, cost, iterations."
    if not isinstance(got, tuple | list) or len(got) != 5 or type(got[2]) is not str:
        raise WrongForm(asked, asked)
    z, y, cost, iterations = (_plain(got[i], asked) for i in (0, 1, 3, 4))
    if (z.shape, y.shape, cost.shape, iterations.shape) != ((n,), (m,), (), ()):
        raise WrongForm(asked, asked)
    expect(np.isfinite(z).all(), "z must be finite, solved or not.")
    return Plan(z, y, got[2], float(cost), int(iterations))


def _plain(x: Any, asked: str) -> Array:
    """Numbers as a float64 copy, whatever `x` says of itself; infinite ones may be among them."""
    try:
        raw = np.array(x, copy=True, subok=False)
    except Exception:  # ragged, or an object that refuses to be an array
        raise WrongForm(asked, asked) from None
    if raw.dtype.kind not in "fiu":
        raise WrongForm(asked, asked)
    return raw.astype(float)
