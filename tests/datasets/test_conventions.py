"""From north-east-down to east-north-up, against cases that can be checked by hand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from uavlab.datasets import conventions as c


def compass(degrees, pitch=0.0, roll=0.0):
    angles = np.deg2rad([[degrees], [pitch], [roll]])
    return c.attitude_from_ned_frd(c.matrices_from_tait_bryan(*angles))[0]


@pytest.mark.parametrize(
    ("degrees", "nose"), [(0, [0, 1, 0]), (90, [1, 0, 0]), (180, [0, -1, 0]), (270, [-1, 0, 0])]
)
def test_the_nose_points_where_the_compass_says(degrees, nose):
    R = compass(degrees)
    np.testing.assert_allclose(R[:, 0], nose, atol=1e-12)
    np.testing.assert_allclose(R[:, 2], [0, 0, 1], atol=1e-12)


def test_pitch_up_raises_the_nose_and_roll_right_lowers_the_right_wing():
    assert compass(0, pitch=10)[2, 0] > 0.17
    assert compass(0, roll=10)[2, 1] > 0.17  # the left wing rises


def test_heading_is_the_azimuth_of_the_nose():
    for degrees in (0, 10, 120, 238.3, 359):
        R = compass(degrees, pitch=20, roll=-15)
        want = c.heading_from_compass(np.deg2rad([degrees]))[0]
        assert np.angle(np.exp(1j * (np.arctan2(R[1, 0], R[0, 0]) - want))) == pytest.approx(0, abs=1e-12)  # fmt: skip


def test_quaternions_and_matrices_are_told_alike():
    q = Rotation.random(20, rng=np.random.default_rng(1)).as_quat()[:, [3, 0, 1, 2]]
    told = c.attitude_from_ned_frd(c.matrices_from_quaternions(q))
    np.testing.assert_allclose(c.matrices_from_quaternions(c.quaternion_from_ned_frd(q)), told, atol=1e-14)  # fmt: skip


def test_a_vector_has_the_same_meaning_in_both_tellings():
    rng = np.random.default_rng(2)
    q = Rotation.random(20, rng=rng).as_quat()[:, [3, 0, 1, 2]]
    R, x = c.matrices_from_quaternions(q), rng.normal(size=(20, 3))
    there = c.enu_from_ned(np.einsum("nij,nj->ni", R, x))
    here = np.einsum("nij,nj->ni", c.attitude_from_ned_frd(R), c.flu_from_frd(x))
    np.testing.assert_allclose(here, there, atol=1e-12)


def test_tait_bryan_matrices_agree_with_scipy():
    angles = np.random.default_rng(3).uniform(-1.5, 1.5, (3, 20))
    want = Rotation.from_euler("ZYX", angles.T).as_matrix()
    np.testing.assert_allclose(c.matrices_from_tait_bryan(*angles), want, atol=1e-12)
