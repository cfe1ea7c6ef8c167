"""Rotations against scipy and the axioms of the group."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from uavlab import so3
from uavlab.errors import BadInput

component = st.floats(-3.0, 3.0)
vectors = st.tuples(component, component, component).map(np.array)


@given(vectors)
def test_exp_is_the_rotation_of_scipy(w):
    assert so3.exp(w) == pytest.approx(Rotation.from_rotvec(w).as_matrix(), abs=1e-14)


@given(vectors)
def test_log_undoes_exp_within_half_a_turn(w):
    size = np.linalg.norm(w)
    if size > np.pi - 1e-6:
        w = w * (3.0 / size)
    assert so3.log(so3.exp(w)) == pytest.approx(w, abs=1e-9)


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-8, 1e-4, 0.1])
def test_log_keeps_its_digits_near_a_half_turn(off):
    rng = np.random.default_rng(0)
    for _ in range(50):
        n = rng.normal(size=3)
        w = n / np.linalg.norm(n) * (np.pi - off)
        R = so3.exp(w)
        assert so3.exp(so3.log(R)) == pytest.approx(R, abs=1e-12)


@given(vectors, vectors)
def test_hat_is_the_cross_product_and_vee_undoes_it(w, x):
    assert so3.hat(w) @ x == pytest.approx(np.cross(w, x), abs=1e-12)
    assert np.array_equal(so3.vee(so3.hat(w)), w)


@given(vectors, vectors)
def test_angle_is_the_length_of_the_relative_log(a, b):
    R, S = so3.exp(a), so3.exp(b)
    want = np.linalg.norm(Rotation.from_matrix(R.T @ S).as_rotvec())
    assert so3.angle(R, S) == pytest.approx(want, abs=1e-7)


def test_project_returns_a_rotation_even_from_a_reflection():
    rng = np.random.default_rng(1)
    for _ in range(50):
        R = so3.project(rng.normal(size=(3, 3)))
        assert pytest.approx(np.eye(3), abs=1e-12) == R @ R.T
        assert np.linalg.det(R) == pytest.approx(1.0)


def test_project_finds_the_nearest_rotation():
    rng = np.random.default_rng(2)
    R = so3.exp(rng.normal(size=3))
    M = R + 1e-3 * rng.normal(size=(3, 3))
    best = np.linalg.norm(so3.project(M) - M)
    near = [
        np.linalg.norm(so3.project(M) @ so3.exp(1e-3 * w) - M) for w in rng.normal(size=(50, 3))
    ]
    assert best <= min(near)


@pytest.mark.parametrize(
    ("R", "said"),
    [
        (np.eye(2), "shape"),
        (np.diag([1, np.nan, 1]), "finite"),
        (2 * np.eye(3), "not a rotation"),
        (np.diag([1.0, 1.0, -1.0]), "reflection"),
    ],
)
def test_what_is_no_rotation_is_refused_with_the_reason(R, said):
    with pytest.raises(BadInput, match=said):
        so3.check_rotation(R)


@given(vectors)
def test_a_rotation_and_its_quaternion_agree_with_scipy_at_every_angle(w):
    R = so3.exp(w)
    q = so3.quaternion_from_rotation(R)
    assert q[0] >= 0.0
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-12)
    assert so3.rotation_from_quaternion(q) == pytest.approx(R, abs=1e-12)
    assert Rotation.from_quat(q, scalar_first=True).as_matrix() == pytest.approx(R, abs=1e-12)


@pytest.mark.parametrize(
    "axis", [*np.eye(3), np.array([0.6, 0.8, 0.0]), np.array([0.0, 0.6, -0.8])]
)
def test_half_turns_have_quaternions_too(axis):
    R = 2 * np.outer(axis, axis) - np.eye(3)
    assert so3.rotation_from_quaternion(so3.quaternion_from_rotation(R)) == pytest.approx(
        R, abs=1e-12
    )
