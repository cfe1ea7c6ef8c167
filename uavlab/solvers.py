"""Solvers behind one face, made for a hundred problems a second that differ in q, l and u alone.

`Solver` is an active-set method (DAQP): exact, and quick where a plan resembles the one before. `Osqp` is a
first-order method: any problem, to a tolerance. `affine` finds what changes from tick to tick, whoever wrote the
`build_*` function.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf, isfinite
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.qp import INFEASIBLE, LATE, QP, SOLVED, Plan, checked, slacked, unslacked
from uavlab.types import Array

HUGE = 1e30  # what both solvers take for infinity
# DAQP adds to the price of a miss its square, weakly: the row is missed by 1/SHARP too little of its way. Per way,
# a' inv(P) a, that a row moves: one number for all rows made DAQP stop at a wrong point now and then.
SHARP = 3e7
SOFT = 8  # by this bit DAQP knows a soft row; by 1 one that binds, by 2 that it does so at l
FEW = 8  # so many binding rows are found as quickly as they are told
MISSED, NONE = 2, -1  # exits of DAQP: solved, but a soft row is missed; no solution
ITERATIONS = 2000
FLAT = 1e-9  # least eigenvalue of P beside its largest entry
_UNSOLVED: ContextVar[bool] = ContextVar("uavlab_unsolved", default=False)


@contextmanager
def unsolved() -> Iterator[None]:
    """Within it no solver of this thread finds a plan: whatever it is asked, it is LATE. A fault, made on purpose."""
    before = _UNSOLVED.set(True)
    try:
        yield
    finally:
        _UNSOLVED.reset(before)


class Affine(NamedTuple):
    """q, l and u of a family of problems: ``M @ parameters + c``."""

    qp: QP  # with all parameters at 0
    M: Array  # (n + 2 m, k)
    c: Array  # (n + 2 m,)

    def __call__(self, parameters: Array) -> tuple[Array, Array, Array]:
        """The vectors q (n,), l (m,), u (m,) for parameters (k,)."""
        v = self.M @ parameters
        v += self.c
        n, m = self.qp.q.size, self.qp.l.size
        return v[:n], v[n : n + m], v[n + m :]


def affine(
    build: Callable[..., QP], sizes: Sequence[tuple[int, ...]], steps: Sequence[float] = ()
) -> Affine:
    """Find how q, l and u depend on what a problem is built from, by building it once for each number.

    Parameters
    ----------
    build : Callable
        Called with one array for each shape of `sizes` (a float for ``()``); gives a QP.
    sizes : sequence of shapes
        Of its arguments, k numbers in all.
    steps : sequence of float, optional
        How far from 0 to try each argument; 1 if left out.

    Returns
    -------
    Affine
        From k numbers in the order of the arguments to q, l, u.

    Raises
    ------
    BadInput
        P, A or the prices depend on the arguments, or q, l, u not affinely.
    """
    steps = tuple(steps) or (1.0,) * len(sizes)
    scale = np.concatenate([np.full(int(np.prod(s)), h) for s, h in zip(sizes, steps, strict=True)])
    base = checked(build(*_parted(np.zeros(scale.size), sizes)))
    c = _vector(base)
    M = np.zeros((c.size, scale.size))
    for i, h in enumerate(scale):
        e = np.zeros(scale.size)
        e[i] = h
        M[:, i] = _change(base, build(*_parted(e, sizes)), c) / h
    found = _change(base, build(*_parted(scale, sizes)), c)
    if np.abs(found - M @ scale).max() > 1e-8 * (1.0 + np.abs(found).max()):
        raise BadInput(
            "q, l and u of this QP are not affine in what it is built from: no clip, no max, no product of two."
        )
    return Affine(base, M, c)


def _parted(numbers: Array, sizes: Sequence[tuple[int, ...]]) -> list[Any]:
    parts, at = [], 0
    for shape in sizes:
        size = int(np.prod(shape))
        part = numbers[at : at + size].reshape(shape)
        parts.append(part if shape else float(part))
        at += size
    return parts


def _vector(qp: QP) -> Array:
    return np.concatenate((qp.q, qp.l.clip(-HUGE, HUGE), qp.u.clip(-HUGE, HUGE)))


def _change(base: QP, other: QP, c: Array) -> Array:
    for name in ("P", "A", "soft"):
        if not np.array_equal(getattr(base, name), getattr(other, name)):
            raise BadInput(
                f"{name} of this QP depends on what it is built from: it cannot be factored once."
            )
    return _vector(other) - c


class Solver:
    """An active-set solver of problems that share P, A and prices, by DAQP.

    Soft rows need no slack variables: a price bounds the multiplier of its row, and DAQP keeps it there.
    What it finds depends on nothing but what it is given, to the last bit: the working set of ``warm`` is handed over
    each time. Of hard rows only, as DAQP may err when a soft one is told to bind and should be missed.

    Parameters
    ----------
    qp : QP
        P must have no eigenvalue of 0.
    iterations : int
        After so many the plan is LATE.

    Raises
    ------
    BadInput
        No problem at all (`uavlab.qp.checked`), or a P that leaves a direction free.
    """

    def __init__(self, qp: QP, iterations: int = ITERATIONS) -> None:
        import daqp

        self.qp = qp = checked(qp)
        size = np.abs(qp.P).max()
        if (least := np.linalg.eigvalsh(qp.P)[0]) <= FLAT * size:
            raise BadInput(
                f"P of the QP has the eigenvalue {least:.3g} beside entries of {size:.3g}, which is too flat for "
                "an active-set method: weigh every input, make slacks soft rows (without_slacks), or take Osqp."
            )
        n, m = qp.q.size, qp.l.size
        self._soft = np.isfinite(qp.soft)
        self._cold = np.where(self._soft, SOFT, 0).astype(np.int32)
        self._hard = (~self._soft).astype(float)
        self._soft_rows, self._prices = qp.A[self._soft], qp.soft[self._soft]
        self._still = np.flatnonzero(~qp.A.any(axis=1) & ~self._soft)  # rows that no z changes
        self._model = daqp.Model()
        self._model.settings = {"iter_limit": iterations, "primal_tol": 1e-9, "dual_tol": 1e-12}
        one = np.ones(m)  # sides that any z near 0 keeps; the true ones come with each problem
        # DAQP has a shorter way for limits of z itself.
        boxed = n if np.array_equal(qp.A[:n], np.eye(n)) else 0
        self._model.setup(qp.P, qp.q, qp.A[boxed:].copy(), one, -one, self._cold.copy())
        way = np.einsum("ij,ij->i", qp.A @ np.linalg.inv(qp.P), qp.A)
        rho = SHARP * np.where(way > 0.0, way, 1.0)
        prices = np.where(self._soft, qp.soft, 0.0)
        self._model.soft_weights(rho_l=rho, rho_u=rho, w_l=prices, w_u=prices)

    def solve(self, q: Array, l: Array, u: Array, warm: Plan | None = None) -> Plan:
        """The plan for these q (n,), l (m,) and u (m,).

        Parameters
        ----------
        q, l, u : Array
            As in `QP`; ±inf or ±1e30 where there is no bound.
        warm : Plan or None
            A plan of a similar problem: with the same rows binding it is found at once.

        Returns
        -------
        Plan
            SOLVED; or INFEASIBLE or LATE with the z of `warm`, else zeros.

        Raises
        ------
        BadInput
            Something is NaN, q not finite, or l above u.
        """
        if not ((l <= u).all() and isfinite(q @ q)):
            checked(self.qp._replace(q=q, l=l, u=u))
        if _UNSOLVED.get():
            return self._none(LATE, 0, warm)
        sense = self._begun(warm)
        if self._still.size:
            l, u, always = l.copy(), u.copy(), self._kept(l, u)
            l[self._still], u[self._still] = -1.0, 1.0
            if not always:
                return self._none(INFEASIBLE, 0, warm)
        self._model.update(f=q, bupper=u, blower=l, sense=sense)
        z, cost, flag, info = self._model.solve()
        if flag > 0:
            if flag == MISSED:  # what DAQP then says that it costs holds its square, too
                cost = self._cost(z, q, l, u)
            return Plan(z, info["lam"], SOLVED, cost, info["iterations"])
        if sense is not self._cold:
            plan = self.solve(q, l, u)  # it may have been led astray
            return plan if plan.ok else self._none(plan.status, plan.iterations, warm)
        return self._none(INFEASIBLE if flag == NONE else LATE, info["iterations"], warm)

    def _begun(self, warm: Plan | None) -> Array:
        """What DAQP is told of the rows (m,): which are soft, and which hard ones bound in the plan before."""
        if warm is None or np.count_nonzero(warm.y) <= FEW:
            return self._cold
        y = warm.y * self._hard
        return self._cold + (y != 0.0).view(np.int8) + ((y < 0.0).view(np.int8) << 1)

    def _cost(self, z: Array, q: Array, l: Array, u: Array) -> float:
        """The same as `uavlab.qp.cost`, of what does not change looked up."""
        Az, soft = self._soft_rows @ z, self._soft
        missed = np.maximum(np.maximum(Az - u[soft], l[soft] - Az), 0.0)
        return float(z @ (0.5 * (self.qp.P @ z) + q) + self._prices @ missed)

    def _kept(self, l: Array, u: Array) -> bool:
        """Whether 0 is within the sides of all rows that no z changes."""
        return bool((l[self._still] <= 0.0).all() and (u[self._still] >= 0.0).all())

    def _none(self, status: str, iterations: int, warm: Plan | None) -> Plan:
        return _none(self.qp, status, iterations, warm)


def _none(qp: QP, status: str, iterations: int, warm: Plan | None) -> Plan:
    """No plan: the old one, else zeros."""
    z, y = (np.zeros(qp.q.size), np.zeros(qp.l.size)) if warm is None else warm[:2]
    return Plan(z, y, status, inf, iterations)


class Osqp:
    """A first-order solver of problems that share P, A and prices, by OSQP: any convex problem, to a tolerance.

    Parameters
    ----------
    qp : QP
        P may be singular.
    eps : float
        Tolerance, absolute and relative, of limits and of P z + q + A'y = 0.
    iterations : int
        After so many the plan is LATE.

    Raises
    ------
    BadInput
        No problem at all (`uavlab.qp.checked`).
    """

    def __init__(self, qp: QP, eps: float = 1e-6, iterations: int = 50_000) -> None:
        import osqp
        from scipy.sparse import csc_matrix, triu

        self.qp = qp = checked(qp)
        self._soft = np.isfinite(qp.soft)
        all_hard = slacked(qp)
        self._model = osqp.OSQP()
        self._model.setup(
            csc_matrix(triu(all_hard.P)), all_hard.q, csc_matrix(all_hard.A), all_hard.l, all_hard.u,
            eps_abs=eps, eps_rel=eps, max_iter=iterations, polishing=True, verbose=False,
            adaptive_rho_interval=200,  # seldom: beside high prices it else goes to and fro for ever
        )  # fmt: skip
        self._rho = self._model.settings.rho

    def solve(self, q: Array, l: Array, u: Array, warm: Plan | None = None) -> Plan:
        """The plan for these q (n,), l (m,) and u (m,); see `Solver.solve`."""
        qp = self.qp._replace(q=q, l=l, u=u)
        if not ((l <= u).all() and isfinite(q @ q)):
            checked(qp)
        if _UNSOLVED.get():
            return _none(self.qp, LATE, 0, warm)
        s = slacked(qp)
        self._model.update_settings(
            rho=self._rho
        )  # it adapts: what was solved before must not count
        self._model.update(q=s.q, l=s.l, u=s.u)
        self._model.warm_start(*self._start(qp, warm))
        found = self._model.solve(raise_error=False)
        status = {"solved": SOLVED, "primal infeasible": INFEASIBLE}.get(found.info.status, LATE)
        if status != SOLVED:
            return _none(self.qp, status, found.info.iter, warm)
        return unslacked(qp, Plan(found.x, found.y, status, found.info.obj_val, found.info.iter))

    def _start(self, qp: QP, warm: Plan | None) -> tuple[Array, Array]:
        """Variables and multipliers to begin with, slacks and their rows included."""
        k = int(self._soft.sum())
        if warm is None:
            return np.zeros(qp.q.size + k), np.zeros(qp.l.size + 2 * k)
        A, l, u = qp.A[self._soft], qp.l[self._soft], qp.u[self._soft]
        missed = np.maximum(np.maximum(A @ warm.z - u, l - A @ warm.z), 0.0)
        y, of_soft = warm.y.copy(), warm.y[self._soft]
        y[self._soft] = of_soft.clip(min=0.0)
        y = np.concatenate((y, of_soft.clip(max=0.0), np.abs(of_soft) - qp.soft[self._soft]))
        return np.concatenate((warm.z, missed)), y
