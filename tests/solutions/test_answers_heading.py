"""The reference answers of lab 02 against finite differences, scipy and symmetries."""

import numpy as np
import pytest
from hypothesis import assume, given
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation
from strategies import floats, forces, headings, rates, tilted

from uavlab import frames, so3
from uavlab.solutions.heading import (
    attitude_by_projection,
    attitude_with_heading,
    heading_rate,
    parasitic_yaw_rate,
    with_heading,
    yaw_rate_from_heading_rate,
)


def slope(R, omega, h=1e-5):
    ahead, behind = frames.heading(R @ so3.exp(h * omega)), frames.heading(R @ so3.exp(-h * omega))
    return frames.wrap(ahead - behind) / (2 * h)


def is_rotation(R):
    assert_allclose(R @ R.T, np.eye(3), atol=1e-9)
    return np.linalg.det(R) > 0


@given(tilted(), rates)
def test_the_heading_rate_is_the_derivative_of_the_heading(R, omega):
    assume(abs(R[2, 0]) < 0.95)
    assert_allclose(heading_rate(R, omega), slope(R, omega), atol=1e-4)


@given(tilted(), rates, floats(-10.0, 10.0))
def test_the_roll_rate_never_turns_the_heading(R, omega, roll):
    assume(abs(R[2, 0]) < 0.95)
    rolled = omega + np.array((roll, 0.0, 0.0))
    assert_allclose(heading_rate(R, rolled), heading_rate(R, omega), atol=1e-9)


@given(tilted(), floats(-10.0, 10.0))
def test_a_turn_about_the_vertical_is_the_heading_rate(R, pace):
    assume(abs(R[2, 0]) < 0.99)
    assert_allclose(heading_rate(R, pace * R[2]), pace, atol=1e-9)


@given(tilted(high=np.radians(60.0)), headings)
def test_heading_agrees_with_the_intrinsic_yaw_of_scipy(R, eta):
    turned = with_heading(R, eta)
    yaw = Rotation.from_matrix(turned).as_euler("ZYX")[0]
    assert abs(frames.wrap(yaw - eta)) < 1e-9


@given(tilted(), headings)
def test_a_new_heading_only_turns_about_the_vertical(R, eta):
    assume(abs(R[2, 0]) < 0.999)
    got = with_heading(R, eta)
    assert is_rotation(got)
    assert_allclose(got[2], R[2], atol=1e-12)
    assert abs(frames.wrap(frames.heading(got) - eta)) < 1e-9


@given(forces(), headings)
def test_the_oblique_attitude_keeps_the_force_and_the_heading(f_d, eta):
    R_d = attitude_with_heading(f_d, eta)
    assert is_rotation(R_d)
    assert_allclose(R_d[:, 2], f_d / np.linalg.norm(f_d), atol=1e-12)
    assert abs(frames.wrap(frames.heading(R_d) - eta)) < 1e-9


@given(forces(low=np.radians(100.0), high=np.radians(180.0)), headings)
def test_the_oblique_attitude_keeps_both_upside_down(f_d, eta):
    R_d = attitude_with_heading(f_d, eta)
    assert is_rotation(R_d)
    assert_allclose(R_d[:, 2], f_d / np.linalg.norm(f_d), atol=1e-12)
    assert abs(frames.wrap(frames.heading(R_d) - eta)) < 1e-8


@given(forces(), headings)
def test_the_oblique_attitude_is_the_one_of_spica(f_d, eta):
    z = f_d / np.linalg.norm(f_d)
    x = np.cross((-np.sin(eta), np.cos(eta), 0.0), z)
    assert_allclose(attitude_with_heading(f_d, eta)[:, 0], x / np.linalg.norm(x), atol=1e-9)


@given(forces(), headings)
def test_the_projected_attitude_keeps_the_force_and_nears_the_heading(f_d, eta):
    R_d = attitude_by_projection(f_d, eta)
    h = np.array((np.cos(eta), np.sin(eta), 0.0))
    assert is_rotation(R_d)
    assert_allclose(R_d[:, 2], f_d / np.linalg.norm(f_d), atol=1e-12)
    best = np.linalg.norm(h - (h @ R_d[:, 2]) * R_d[:, 2])  # the longest shadow on that plane
    assert_allclose(h @ R_d[:, 0], best, atol=1e-12)


@pytest.mark.parametrize(
    ("tilt", "worst"), [(10.0, 0.9), (20.0, 3.6), (30.0, 8.2), (45.0, 19.5), (60.0, 36.9)]
)
def test_the_projected_attitude_loses_the_heading_by_what_the_errata_say(tilt, worst):
    lean = np.radians(tilt)
    lost = [
        abs(frames.wrap(frames.heading(attitude_by_projection(f_d, 0.0))))
        for a in np.linspace(0, 2 * np.pi, 721)
        for f_d in [np.array((np.sin(lean) * np.cos(a), np.sin(lean) * np.sin(a), np.cos(lean)))]
    ]
    assert_allclose(np.degrees(max(lost)), worst, atol=0.06)


@pytest.mark.parametrize(
    "f_d", [np.zeros(3), np.array((3.0, 4.0, 0.0)), np.array((1.0, 0.0, 1e-4))]
)
def test_a_force_that_cannot_choose_its_heading_is_refused(f_d):
    with pytest.raises(ValueError, match="f_d"):
        attitude_with_heading(f_d, 0.3)


@pytest.mark.parametrize("length", [0.0, 10.0, -10.0])
def test_a_force_with_nothing_to_project_is_refused(length):
    with pytest.raises(ValueError, match="f_d"):
        attitude_by_projection(length * np.array((np.cos(0.3), np.sin(0.3), 0.0)), 0.3)


@given(tilted(), floats(-5.0, 5.0))
def test_a_yaw_rate_alone_makes_the_heading_rate(R, pace):
    assume(abs(R[2, 0]) < 0.95)
    yaw = yaw_rate_from_heading_rate(R, pace)
    assert_allclose(heading_rate(R, np.array((0.0, 0.0, yaw))), pace, atol=1e-9)
    assert_allclose(yaw, pace * (1.0 - R[2, 0] ** 2) / R[2, 2], atol=1e-9)


@given(tilted(), rates)
def test_the_heading_stands_still_once_the_parasite_is_undone(R, omega):
    assume(abs(R[2, 0]) < 0.95)
    yaw = parasitic_yaw_rate(R, omega)
    assert_allclose(heading_rate(R, np.array((omega[0], omega[1], yaw))), 0.0, atol=1e-9)


def test_with_a_horizontal_thrust_axis_no_yaw_rate_is_asked_for():
    R = so3.exp(np.array((np.pi / 2, 0.0, 0.0))) @ so3.about_z(0.5)
    assert yaw_rate_from_heading_rate(R, 1.0) == 0.0
    assert parasitic_yaw_rate(R, np.ones(3)) == 0.0


def test_inputs_are_left_alone():
    R, omega, f_d = so3.exp(np.array((0.3, 0.2, 0.1))), np.ones(3), np.array((1.0, 2.0, 9.0))
    before = [x.copy() for x in (R, omega, f_d)]
    heading_rate(R, omega), with_heading(R, 1.0), parasitic_yaw_rate(R, omega)
    attitude_by_projection(f_d, 1.0), attitude_with_heading(f_d, 1.0)
    yaw_rate_from_heading_rate(R, 1.0)
    for was, x in zip(before, (R, omega, f_d), strict=True):
        assert np.array_equal(was, x)
