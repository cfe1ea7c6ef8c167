"""Quadratic programmes by an algorithm that the library does not use: the interior-point method of Clarabel."""

import clarabel
import numpy as np
from scipy.sparse import csc_matrix, triu

from uavlab.qp import QP, slacked


def solved(qp: QP, tol: float = 1e-11) -> np.ndarray:
    """The z of `qp`, soft rows by slacks."""
    s = slacked(qp)
    above, below = np.isfinite(s.u), np.isfinite(s.l)
    rows = np.vstack((s.A[above], -s.A[below]))
    sides = np.concatenate((s.u[above], -s.l[below]))
    found = sparse(s.P, s.q, np.zeros((0, s.q.size)), np.zeros(0), rows, sides, tol)
    return found[: qp.q.size]


def sparse(P, q, C, d, A, b, tol: float = 1e-11) -> np.ndarray:
    """Minimise ``1/2 z'P z + q'z`` subject to ``C z = d`` and ``A z <= b``."""
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tol
    cones = [clarabel.ZeroConeT(len(d)), clarabel.NonnegativeConeT(len(b))]
    all_rows, sides = csc_matrix(np.vstack((C, A))), np.concatenate((d, b))
    problem = clarabel.DefaultSolver(csc_matrix(triu(P)), q, all_rows, sides, cones, settings)
    found = problem.solve()
    assert "Solved" in str(found.status), found.status
    return np.array(found.x)
