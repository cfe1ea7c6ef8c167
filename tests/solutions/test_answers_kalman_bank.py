"""The reference answers of lab 03 against Riccati, least squares, chance, and the laws of worlds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.linalg import expm, solve_discrete_are
from scipy.stats import chi2

from uavlab import frames, so3
from uavlab.errors import BadInput, UnknownName
from uavlab.exercises import draw
from uavlab.solutions.kalman_bank import (
    arbitrate,
    correct,
    heading_model,
    moved_reference,
    predict,
    shift_between,
    translation_model,
)
from uavlab.types import Shift

seeds = st.integers(0, 2**32 - 1)
ZERO, DT = np.zeros(3), 0.01
POSITION = np.array(((1.0, 0.0, 0.0),))


# One filter -------------------------------------------------------------------------------------------


def test_without_a_lag_the_models_are_exact():
    assert_allclose(translation_model(0.3, 1.0)[0], expm(0.3 * np.eye(3, k=1)), atol=1e-12)
    assert_allclose(heading_model(0.3, 1.0)[0], expm(0.3 * np.eye(2, k=1)), atol=1e-12)


def test_the_filter_of_the_mrs_software_settles_at_the_gains_and_poles_that_were_computed_for_it():
    A, B = translation_model(DT, 0.9)
    Q, R_z = DT * np.diag((0.1, 1.0, 1.0)), np.array(((0.01,),))
    x, P = ZERO, np.eye(3)
    for _ in range(600):
        x, P = predict(x, P, np.zeros(1), A, B, Q)
        before = P
        x, P, _ = correct(x, P, np.zeros(1), POSITION, R_z)
    assert_allclose(before, solve_discrete_are(A.T, POSITION.T, Q, R_z), rtol=1e-9)
    K = before @ POSITION.T / (POSITION @ before @ POSITION.T + R_z)
    assert_allclose(K[:, 0], (0.292, 0.845, 0.0073), rtol=0.01)
    poles = np.log(np.linalg.eigvals((np.eye(3) - K @ POSITION) @ A).real) / DT
    assert_allclose(sorted(poles), (-31.0, -10.5, -3.2), rtol=0.02)


@given(seeds)
def test_a_recursion_is_the_least_squares_of_all_that_was_measured(seed):
    rng = np.random.default_rng(seed)
    x, P, _, _, _ = draw.belief(rng, 3, 1)
    rows, told, mean, cov = [np.linalg.inv(np.linalg.cholesky(P))], [], x, P
    told.append(rows[0] @ x)
    for m in (1, 2, 3):
        _, _, z, H, R_z = draw.belief(rng, 3, m)
        white = np.linalg.inv(np.linalg.cholesky(R_z))
        rows.append(white @ H)
        told.append(white @ z)
        mean, cov, _ = correct(mean, cov, z, H, R_z)
    rows = np.vstack(rows)
    assert_allclose(mean, np.linalg.lstsq(rows, np.concatenate(told))[0], atol=1e-6)
    assert_allclose(cov, np.linalg.inv(rows.T @ rows), atol=1e-6)


def test_a_sharp_measurement_of_something_unknown_leaves_a_covariance():
    x, P = ZERO, 1e8 * np.eye(3)
    for H in np.eye(3)[[0, 1, 0, 2, 1, 0]]:
        x, P, _ = correct(x, P, np.ones(1), H[None], np.array(((1e-8,),)))
        assert_allclose(P, P.T, atol=0.0)
        assert np.linalg.eigvalsh(P)[0] > 0.0


def test_over_many_flights_the_errors_are_as_large_as_the_filter_says():
    """Bounds: 99.9 %, both sides. A filter that is told a third of the noise is far outside."""
    A, B = translation_model(0.1, 0.5)
    Q, runs = 0.1 * np.diag((0.1, 1.0, 1.0)), 80
    root = np.linalg.cholesky(Q)
    for said, honest in ((0.04, True), (0.04 / 3, False)):
        off, nis = 0.0, 0.0
        for seed in range(runs):
            rng = np.random.default_rng(seed)
            truth, x, P, last = rng.normal(size=3), ZERO, np.eye(3), 0.0
            for _ in range(8):
                u = rng.normal(size=1)
                truth = A @ truth + B @ u + root @ rng.normal(size=3)
                x, P = predict(x, P, u, A, B, Q)
                z = truth[:1] + 0.2 * rng.normal(size=1)
                x, P, last = correct(x, P, z, POSITION, np.array(((said,),)))
            off += (truth - x) @ np.linalg.solve(P, truth - x)
            nis += last
        for total, degrees in ((off, 3 * runs), (nis, runs)):
            low, high = chi2.ppf((5e-4, 1 - 5e-4), degrees)
            assert (low < total < high) == honest


@pytest.mark.parametrize("spoil", [-9.0 * np.eye(3), np.triu(np.ones((3, 3)), 1), np.nan])
def test_what_is_no_covariance_is_refused_by_its_name(spoil):
    rng = np.random.default_rng(0)
    x, P, u, A, B, Q = draw.prediction(rng, 3, 1)
    with pytest.raises(BadInput, match=r"^P "):
        predict(x, P + spoil, u, A, B, Q)
    with pytest.raises(BadInput, match=r"^Q "):
        predict(x, P, u, A, B, Q + spoil)
    with pytest.raises(BadInput, match=r"^P "):
        correct(x, P + spoil, np.zeros(1), POSITION, np.eye(1))
    with pytest.raises(BadInput, match=r"^z "):
        correct(x, P, np.array((np.nan,)), POSITION, np.eye(1))
    with pytest.raises(BadInput, match=r"^H has shape \(1, 3\); \(2, 3\) fits the others"):
        correct(x, P, np.zeros(2), POSITION, np.eye(2))


# Who flies, and what a switch does --------------------------------------------------------------------


@given(seeds)
def test_the_arbiter_keeps_its_three_rules(seed):
    rng = np.random.default_rng(seed)
    told = {
        name: draw.hypothesis(
            rng, spread=float(rng.uniform(0.1, 10.0)), reliable=rng.random() < 0.6
        )
        for name in "abcd"
    }
    current, request = (str(x) for x in rng.choice(list("abcd"), size=2))
    flies, free = arbitrate(told, current, request), arbitrate(told, current, "")
    well = [name for name in told if told[name].reliable]
    trace = {name: np.trace(np.diag([P[0, 0] for P in x.P])) for name, x in told.items()}
    if request in well:
        assert flies == request
    else:
        assert flies == free
    if not well:
        assert free == current
    else:
        assert told[free].reliable
        assert free == current or trace[free] == min(trace[name] for name in well)
        assert free != current or trace[free] <= 2.0 * min(trace[name] for name in well)
    assert arbitrate(told, free, "") == free  # it does not take turns


def test_the_arbiter_refuses_names_that_nobody_has():
    told = {"gnss": draw.hypothesis(np.random.default_rng(0))}
    with pytest.raises(UnknownName, match="no hypothesis named 'gps'"):
        arbitrate(told, "gnss", "gps")


@given(seeds)
def test_a_change_of_world_leaves_the_aircraft_where_it_is_and_goes_back(seed):
    rng = np.random.default_rng(seed)
    a, b, c = (draw.hypothesis(rng) for _ in range(3))
    there = shift_between(a, b)
    assert_allclose(so3.about_z(there.heading) @ a.x[:, 0] + there.r, b.x[:, 0], atol=1e-9)
    assert abs(frames.wrap(a.h[0] + there.heading - b.h[0])) < 1e-9
    assert -np.pi <= there.heading < np.pi
    whole, both = shift_between(a, c), frames.compose(shift_between(b, c), there)
    assert_allclose(whole.r, both.r, atol=1e-9)
    x = draw.reference(rng)
    again = moved_reference(moved_reference(x, there), frames.inverse(there))
    for was, now in zip(x, again, strict=True):
        assert_allclose(now, was, atol=1e-9)


@given(seeds)
def test_a_moved_reference_is_the_one_of_the_library_but_for_whole_turns(seed):
    rng = np.random.default_rng(seed)
    x, shift = draw.reference(rng), Shift(draw.vector(rng), draw.angle(rng))
    ours, theirs = moved_reference(x, shift), frames.moved(x, shift)
    assert abs(frames.wrap(ours.heading - theirs.heading)) < 1e-9
    for one, two in zip(ours._replace(heading=0.0), theirs._replace(heading=0.0), strict=True):
        assert_allclose(one, two, atol=1e-12)
