"""Quadratic programmes: optimality as such, three algorithms against each other, and what is no problem at all."""

from math import inf, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from interior_point import solved
from numpy.testing import assert_allclose, assert_array_equal

from uavlab.errors import BadInput
from uavlab.qp import (
    INFEASIBLE,
    LATE,
    QP,
    Plan,
    checked,
    cost,
    hard,
    slacked,
    unslacked,
    without_slacks,
)
from uavlab.solutions.mpc import build_soft_qp
from uavlab.solvers import Osqp, Solver, affine
from uavlab.weights import InputBounds, LandingWeights, soft_limits, with_endless_horizon

seeds = st.integers(0, 2**32 - 1)
BOTH = pytest.mark.parametrize("Kind", [Solver, Osqp])


def problem(seed: int, price: float = 2.0, n: int = 5, m: int = 9) -> QP:
    """Some rows hard (and met by a point that is drawn), some soft, some without a side."""
    rng = np.random.default_rng(seed)
    root, A, point = rng.normal(size=(n, n)), rng.normal(size=(m, n)), rng.normal(size=n)
    middle = A @ point
    l, u = middle - rng.uniform(0.1, 2.0, m), middle + rng.uniform(0.1, 2.0, m)
    l[1], u[2], u[-1] = -inf, inf, inf
    soft = hard(m)
    soft[m // 2 :] = price
    shift = np.where(
        np.isfinite(soft), rng.normal(size=m), 0.0
    )  # what is soft need not be possible
    return QP(root @ root.T + np.eye(n), 5 * rng.normal(size=n), A, l + shift, u + shift, soft)


def solve(qp: QP, Kind=Solver, warm: Plan | None = None) -> Plan:
    return Kind(qp).solve(qp.q, qp.l, qp.u, warm)


# Optimality -------------------------------------------------------------------------------------------


@given(seeds)
@settings(max_examples=60, deadline=None)
def test_a_plan_meets_the_conditions_of_karush_kuhn_and_tucker(seed):
    qp = problem(seed)
    plan = solve(qp)
    assert plan.ok
    Az, y, soft = qp.A @ plan.z, plan.y, np.isfinite(qp.soft)
    missed = np.maximum(np.maximum(Az - qp.u, qp.l - Az), 0.0)
    assert_allclose(qp.P @ plan.z + qp.q + qp.A.T @ y, 0.0, atol=1e-9)  # nothing pulls
    assert (missed[~soft] < 1e-8).all()
    assert (np.abs(y[soft]) <= qp.soft[soft] + 1e-4).all()  # a price bounds its multiplier
    assert_allclose(np.abs(y[missed > 1e-6]), qp.soft[missed > 1e-6], atol=1e-4)
    at_rest = (Az < qp.u - 1e-6) & (Az > qp.l + 1e-6)
    assert_array_equal(y[at_rest], 0.0)
    assert (y[Az < qp.u - 1e-6] <= 0.0).all()
    assert (y[Az > qp.l + 1e-6] >= 0.0).all()
    assert plan.cost == pytest.approx(cost(qp, plan.z), rel=1e-9, abs=1e-9)


@given(seeds, st.sampled_from((0.3, 2.0, 100.0)))
@settings(max_examples=40, deadline=None)
def test_a_box_on_multipliers_slacks_and_an_interior_point_give_the_same(seed, price):
    qp = problem(seed, price)
    z = solved(qp)  # Clarabel, with slacks
    assert_allclose(solve(qp).z, z, atol=1e-6)  # DAQP, a box on the multipliers
    assert_allclose(solve(qp, Osqp).z, z, atol=1e-6)  # OSQP, with slacks
    assert cost(qp, solve(qp).z) <= cost(qp, z) + 1e-8


def test_a_price_above_the_multiplier_is_as_good_as_a_hard_row_and_one_below_is_paid():
    qp = problem(3)._replace(soft=hard(9))
    strict = solve(qp)
    assert strict.ok
    most = np.abs(strict.y).max()
    assert most > 0.1
    dear = solve(qp._replace(soft=np.full(9, 1.01 * most)))
    assert_allclose(dear.z, strict.z, atol=1e-9)
    cheap = qp._replace(soft=np.full(9, 0.5 * most))
    assert cost(cheap, solve(cheap).z) < strict.cost - 1e-3


def test_without_any_side_the_least_cost_is_where_its_slope_is_zero():
    qp = problem(4)
    qp = qp._replace(l=np.full(9, -inf), u=np.full(9, inf))
    for Kind in (Solver, Osqp):
        assert_allclose(solve(qp, Kind).z, np.linalg.solve(qp.P, -qp.q), atol=1e-6)


def defect(qp: QP, plan: Plan) -> float:
    """By how much a plan violates the conditions on its rows."""
    Az, y, tol = qp.A @ plan.z, plan.y, 1e-6
    over, under = Az - qp.u, qp.l - Az
    free = np.abs(y) < qp.soft * (1 - 1e-9) - tol  # not paid for: must not be missed
    return max(
        np.maximum(-over, 0.0)[y > tol].max(initial=0.0),
        np.maximum(-under, 0.0)[y < -tol].max(initial=0.0),
        np.maximum(np.maximum(over, under), 0.0)[free].max(initial=0.0),
    )


@pytest.mark.parametrize("n", [2, 10])
def test_rows_of_very_different_size_are_missed_where_that_is_right(n):
    # With one weak square for all rows DAQP stopped at wrong points in 1 of 400 of these.
    def build(x):
        return without_slacks(
            build_soft_qp(
                x, np.zeros(10), weights=with_endless_horizon(LandingWeights(), 0.05), N=n, dt=0.05,
                bounds=InputBounds(), soft=soft_limits(2.5, 1.0, 0.3),
            ), 3 * n,
        )  # fmt: skip

    family = affine(build, ((10,),))
    solver, rng = Solver(family.qp), np.random.default_rng(n)
    size = np.array((4.0, 1.5, 0.1, 0.5, 4.0, 1.5, 0.1, 0.5, 2.0, 1.0))
    for _ in range(300):
        q, l, u = family(size * rng.normal(size=10))
        plan = solver.solve(q, l, u)
        assert plan.ok
        assert defect(family.qp._replace(q=q, l=l, u=u), plan) < 1e-8


# What is an answer, and what an error -----------------------------------------------------------------


@BOTH
def test_no_answer_is_a_value(Kind):
    A = np.array(((1.0, 1.0), (1.0, 1.0)))
    qp = QP(np.eye(2), np.ones(2), A, np.array((1.0, -inf)), np.array((inf, 0.0)), hard(2))
    plan = solve(qp, Kind)
    assert plan.status == INFEASIBLE
    assert not plan.ok
    assert_array_equal(plan.z, (0.0, 0.0))
    warm = plan._replace(z=np.array((3.0, 4.0)), y=np.array((0.0, 0.1)))
    assert_array_equal(solve(qp, Kind, warm).z, warm.z)
    assert solve(qp._replace(soft=np.ones(2)), Kind).ok  # what is soft always has one


@pytest.mark.parametrize(("Kind", "few"), [(Solver, 1), (Osqp, 1)])
def test_an_answer_that_is_not_found_in_time_is_a_value(Kind, few):
    qp = problem(5)
    late = Kind(qp, iterations=few).solve(qp.q, qp.l, qp.u)
    assert late.status == LATE
    assert np.isfinite(late.z).all()


def test_a_solver_goes_on_after_a_problem_without_an_answer():
    A = np.array(((1.0, 0.0), (1.0, 0.0)))
    qp = QP(np.eye(2), np.ones(2), A, np.array((-1.0, -inf)), np.array((inf, 1.0)), hard(2))
    solver = Solver(qp)
    before = solver.solve(qp.q, qp.l, qp.u)
    assert solver.solve(qp.q, np.array((2.0, -inf)), qp.u, before).status == INFEASIBLE
    after = solver.solve(qp.q, qp.l, qp.u)
    assert_array_equal(after.z, before.z)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"q": np.array((nan, 0.0))}, r"q\[0\] of the QP = nan"),
        ({"l": np.array((0.0, nan, 0.0))}, r"l\[1\] of the QP = nan"),
        ({"u": np.array((1.0, -5.0, 1.0))}, "row 1 of the QP wants at least"),
        ({"P": -np.eye(2)}, "eigenvalue -1"),
        ({"P": np.array(((1.0, 1.0), (0.0, 1.0)))}, "not symmetric"),
        ({"A": np.ones((3, 4))}, r"A of the QP has shape \(3, 4\)"),
        ({"A": np.full((3, 2), inf)}, r"A\[0, 0\] of the QP = inf"),
        ({"soft": np.array((1.0, 0.0, inf))}, r"soft\[1\] of the QP = 0"),
    ],
)
def test_what_is_no_problem_is_refused_with_the_culprit(change, says):
    fine = QP(np.eye(2), np.zeros(2), np.ones((3, 2)), -np.ones(3), np.ones(3), hard(3))
    assert checked(fine).q.dtype == float
    with pytest.raises(BadInput, match=says):
        checked(fine._replace(**change))
    for Kind in (Solver, Osqp):
        with pytest.raises(BadInput, match=says):
            Kind(fine._replace(**change))
        if change.keys() <= {"q", "l", "u"}:
            with pytest.raises(BadInput, match=says):
                Kind(fine).solve(*fine._replace(**change)[1:2], *fine._replace(**change)[3:5])


def test_a_direction_without_cost_is_refused_by_the_solver_that_cannot_bear_it():
    qp = slacked(problem(6))
    with pytest.raises(BadInput, match="too flat"):
        Solver(qp)
    assert solve(qp, Osqp).ok


# Warm starts ------------------------------------------------------------------------------------------


@BOTH
def test_a_warm_start_changes_nothing_but_the_time(Kind):
    rng = np.random.default_rng(7)
    qp = problem(7, n=20, m=60)
    solver, warm, saved = Kind(qp), None, 0
    for _ in range(20):
        q = qp.q + 0.05 * rng.normal(size=20)
        cold = solver.solve(q, qp.l, qp.u)
        warm = solver.solve(q, qp.l, qp.u, warm)
        assert_allclose(warm.z, cold.z, atol=1e-9 if Kind is Solver else 1e-5)
        saved += cold.iterations - warm.iterations
    assert saved > 0


@pytest.mark.parametrize("seed", range(5))
def test_what_a_solver_finds_depends_on_nothing_that_it_solved_before(seed):
    qp, rng = problem(seed, n=12, m=30), np.random.default_rng(seed)
    solver = Solver(qp)
    warm = solver.solve(qp.q, qp.l, qp.u)
    q = qp.q + 0.1 * rng.normal(size=12)
    first = solver.solve(q, qp.l, qp.u, warm)
    for _ in range(5):
        solver.solve(9 * rng.normal(size=12), qp.l, qp.u)
        again = solver.solve(q, qp.l, qp.u, warm)
        for a, b in zip(first, again, strict=True):
            assert_array_equal(a, b)  # to the last bit


# Other forms of the same problem ----------------------------------------------------------------------


def test_slacks_can_be_put_in_and_taken_out():
    qp = problem(8)
    with_slacks = slacked(qp)
    assert not np.isfinite(with_slacks.soft).any()
    there = solve(with_slacks, Osqp)
    told = unslacked(qp, there)
    plan = solve(qp)
    assert_allclose(told.z, plan.z, atol=1e-6)
    assert_allclose(told.y, plan.y, atol=1e-4)
    assert told.cost == pytest.approx(plan.cost, abs=1e-6)
    one_sided = qp._replace(l=np.where(np.isfinite(qp.soft), -inf, qp.l))
    one_sided = one_sided._replace(u=one_sided.u.clip(max=50.0))
    s = slacked(one_sided)
    keep = np.r_[:9, 9 + 5 : 9 + 10]  # the rows for l of soft rows bound nothing here
    s = QP(s.P, s.q, s.A[keep], s.l[keep], s.u[keep], hard(len(keep)))
    back = without_slacks(s, 5)
    for name in QP._fields:
        assert_array_equal(getattr(back, name), getattr(one_sided, name))
    with pytest.raises(BadInput, match="no slacks"):
        without_slacks(qp, 4)


def test_what_changes_from_tick_to_tick_is_found_whoever_builds_the_problem():
    base = problem(9)
    rng = np.random.default_rng(9)
    K, L = rng.normal(size=(5, 3)), rng.normal(size=(9, 1))

    def build(x: np.ndarray, last: float) -> QP:
        rows = L[:, 0] * last
        return base._replace(q=base.q + K @ x, l=base.l + rows, u=base.u + rows)

    family = affine(build, ((3,), ()), (1.0, 0.5))
    for _ in range(5):
        x, last = 3 * rng.normal(size=3), float(rng.normal())
        want = build(x, last)
        q, l, u = family(np.append(x, last))
        assert_allclose(q, want.q, atol=1e-12)
        assert_allclose(l.clip(-1e30, 1e30), want.l.clip(-1e30, 1e30), rtol=1e-12, atol=1e-12)
        assert_allclose(u.clip(-1e30, 1e30), want.u.clip(-1e30, 1e30), rtol=1e-12, atol=1e-12)
        assert_allclose(Solver(family.qp).solve(q, l, u).z, solve(want).z, atol=1e-9)
    with pytest.raises(BadInput, match="not affine"):
        affine(lambda x: base._replace(q=base.q * x[0] * x[1]), ((2,),))
    with pytest.raises(BadInput, match="P of this QP depends"):
        affine(lambda x: base._replace(P=base.P * (1.0 + x**2)), ((),))
