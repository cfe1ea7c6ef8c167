"""The reference answers of lab 07 against scipy, Lee's law, finite differences and closed loops."""

import numpy as np
import pytest
from hypothesis import assume, given
from numpy.testing import assert_allclose
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation
from strategies import floats, headings, rates, tilted

from uavlab import frames, so3
from uavlab.errors import BadInput
from uavlab.gains import GROUPS, TorqueGains, gain_group
from uavlab.parts.paths import along, circle, lemniscate
from uavlab.plant import load_airframe
from uavlab.solutions.geometric import (
    GeometricController,
    attitude_error,
    desired_force,
    disturbance_step,
    estimated_mass,
    jerk_feedforward,
    rate_command,
    scale_to_limits,
    torque_command,
    unbiased_acceleration,
)
from uavlab.solutions.heading import (
    attitude_with_heading,
    heading_rate,
    parasitic_yaw_rate,
    yaw_rate_from_heading_rate,
)
from uavlab.types import GRAVITY, Command, Estimate, Reference

E3, ZERO, LEVEL = np.eye(3)[2], np.zeros(3), np.eye(3)
G = GRAVITY * E3
SOFT = GROUPS["now"]["soft"]
SIM = gain_group("T650-sim-2020", "soft")


def at_rest(r=ZERO, v=ZERO, R=LEVEL):
    return Estimate(np.array(r, float), np.array(v, float), ZERO, R, ZERO)


def still(r=ZERO, heading=0.0):
    return Reference(np.array(r, float), ZERO, ZERO, ZERO, heading, 0.0)


# Attitude ---------------------------------------------------------------------------------------------


@given(tilted(), rates)
def test_a_small_error_is_the_rotation_vector_of_scipy(R_d, w):
    R = R_d @ so3.exp(1e-4 * w)
    between = Rotation.from_matrix(R_d).inv() * Rotation.from_matrix(R)
    assert_allclose(attitude_error(R, R_d), between.as_rotvec(), atol=1e-9)


@given(tilted(), floats(-3.1, 3.1))
def test_the_error_is_the_sine_of_the_angle_and_vanishes_upside_down(R_d, angle):
    n = np.array((2.0, -1.0, 2.0)) / 3.0
    assert_allclose(attitude_error(R_d @ so3.exp(angle * n), R_d), np.sin(angle) * n, atol=1e-9)
    assert_allclose(attitude_error(R_d @ so3.exp(np.pi * n), R_d), ZERO, atol=1e-9)


PATHS = {"circle": circle(np.zeros(3), 5.0), "eight": lemniscate(np.zeros(3), 8.0, 4.0, 0.5)}


def attitude_along(path, t, heading):
    return attitude_with_heading(along(path, t, 1.3, 2.0)[2] + G, heading)


@pytest.mark.parametrize("name", PATHS)
@pytest.mark.parametrize("t", [0.7, 1.6, 2.9, 4.1])
def test_the_jerk_asks_for_the_roll_and_pitch_rates_of_the_attitude_along_a_path(name, t):
    path, heading, h, m = PATHS[name], 0.8, 1e-5, 3.5
    turn = attitude_along(path, t - h, heading).T @ attitude_along(path, t + h, heading)
    rate = Rotation.from_matrix(turn).as_rotvec() / (2 * h)
    _, _, a, jerk = along(path, t, 1.3, 2.0)
    R_d = attitude_along(path, t, heading)
    got = jerk_feedforward(m * (a + G), m, R_d, jerk)
    assert_allclose(got[:2], rate[:2], atol=1e-6)
    assert got[2] == 0.0


def test_26_as_printed_is_minus_the_square_of_the_thrust_per_mass_times_the_truth():
    f, m, jerk = 12.0 * 3.5 * E3, 3.5, np.array((1.0, -2.0, 0.5))
    printed = np.linalg.norm(f) / m * so3.hat(E3).T @ jerk
    assert_allclose(printed, -(12.0**2) * jerk_feedforward(f, m, np.eye(3), jerk))


def test_without_thrust_there_is_no_feedforward():
    with pytest.raises(BadInput, match="f_d is zero"):
        jerk_feedforward(ZERO, 3.5, np.eye(3), E3)


@given(tilted(), rates, floats(-3.0, 3.0), rates)
def test_the_commanded_rates_are_those_of_lab_02(R_d, w, rate, omega_j):
    R, k_R = R_d @ so3.exp(0.05 * w), np.array((5.0, 6.0, 2.0))
    assume(min(abs(R[2, 2]), abs(R_d[2, 2])) > 0.1)
    assume(max(abs(R[2, 0]), abs(R_d[2, 0])) < 0.95)
    omega_j = omega_j * (1.0, 1.0, 0.0)
    want = omega_j - k_R * attitude_error(R, R_d)
    want[2] += yaw_rate_from_heading_rate(R_d, rate) + parasitic_yaw_rate(R, want)
    assert_allclose(rate_command(R, R_d, rate, omega_j, k_R), want, atol=1e-9, rtol=1e-9)


@given(tilted(), floats(-3.0, 3.0), rates)
def test_on_the_attitude_the_heading_changes_as_it_should(R, rate, omega_j):
    assume(abs(R[2, 2]) > 0.1)
    assume(abs(R[2, 0]) < 0.95)
    omega, h = rate_command(R, R, rate, omega_j * (1.0, 1.0, 0.0), np.ones(3)), 1e-6
    ahead = frames.heading(R @ so3.exp(h * omega)) - frames.heading(R @ so3.exp(-h * omega))
    assert_allclose(frames.wrap(ahead) / (2 * h), rate, atol=1e-3)
    assert_allclose(heading_rate(R, omega), rate, atol=1e-8)


def test_the_circle_that_faces_its_centre_needs_the_rates_of_the_errata():
    """A steady turn about the vertical: (−0.989, 0, 0.990) rad/s at 5 m and 7 m/s."""
    w, m = 1.4, 3.5
    a, jerk = np.array((-9.8, 0.0, 0.0)), np.array((0.0, -9.8 * w, 0.0))
    R = attitude_with_heading(a + G, np.pi)
    omega_j = jerk_feedforward(m * (a + G), m, R, jerk)
    got = rate_command(R, R, w, omega_j, np.ones(3))
    assert_allclose(got, w * R[2], atol=1e-9)
    assert_allclose(np.abs(got), (0.99, 0.0, 0.99), atol=2e-3)


# Force, disturbances, mass ----------------------------------------------------------------------------


@given(tilted(), headings)
def test_a_force_in_another_world_is_the_same_force_turned(R, turn):
    x, y = at_rest((1.0, 2.0, 3.0), (0.3, 0.2, -0.4), R), still((1.2, 1.5, 3.3))
    shift, d_w, d_b = frames.Shift(np.array((4.0, -5.0, 6.0)), turn), np.ones(3), 2.0 * np.ones(3)
    Rz = so3.about_z(turn)
    here = desired_force(x, y, 3.5, d_w, d_b, SOFT)
    there = desired_force(frames.moved(x, shift), frames.moved(y, shift), 3.5, Rz @ d_w, d_b, SOFT)
    assert_allclose(there, Rz @ here, atol=1e-9)


def hovered(mass, told, learn, seconds, dt=0.01):
    """Height and believed mass of a point mass that the force law flies."""
    z, v, m_e = 0.0, 0.0, told
    for _ in range(round(seconds / dt)):
        force = desired_force(at_rest((0, 0, z), (0, 0, v)), still(), m_e, ZERO, ZERO, SOFT)[2]
        m_e = learn(m_e, z, dt)
        v += dt * (force / mass - GRAVITY)
        z += dt * v
        if abs(z) > 20.0:
            break
    return z, m_e


def test_37_corrected_finds_the_mass_and_as_printed_flies_away():
    right, m_e = hovered(3.5, 3.0, lambda m, z, dt: estimated_mass(m, z, dt, 3.0, SOFT), 30.0)
    assert 3.46 < m_e < 3.51
    assert abs(right) < 0.05
    wrong, _ = hovered(3.5, 3.0, lambda m, z, dt: m + SOFT.k_m * z * dt, 30.0)
    assert wrong < -20.0


def test_a_mass_stays_within_its_limits():
    assert estimated_mass(3.4, -1e3, 1.0, 3.0, SIM) == 9.0
    assert estimated_mass(3.4, 1e3, 1.0, 3.0, SIM) == pytest.approx(0.3)
    assert estimated_mass(8.0, 1e3, 1.0, 8.0, SIM) == 2.0


def test_wind_is_split_until_the_nose_turns_and_then_told_apart():
    m, dt, push = 3.5, 0.01, np.array((3.0, 0.0, 0.0))
    r, v, d_w, d_b = ZERO, ZERO, ZERO, ZERO
    for k in range(12000):
        eta = np.pi * min(max(k * dt - 40.0, 0.0) / 4.0, 1.0)
        force = desired_force(at_rest(r, v, so3.about_z(eta)), still(), m, d_w, d_b, SIM)
        d_w, d_b = disturbance_step(d_w, d_b, r, eta, dt, SIM)
        v = v + dt * ((force + push) / m - G)
        r = r + dt * v
        if k == 3999:  # nobody can tell
            assert_allclose(d_w, d_b)
            assert_allclose(d_w + d_b, push, atol=0.05)
    assert_allclose(d_w + so3.about_z(eta) @ d_b, push, atol=0.01)
    assert d_w[0] > 2.9
    assert abs(d_b[0]) < 0.1


@given(tilted(), floats(0.3, 15.0))
def test_still_in_the_wind_a_d_is_zero_and_as_printed_it_is_not(R, m):
    assume(R[2, 2] > 0.3)
    assume(abs(R[2, 0]) < 0.95)
    thrust = m * GRAVITY / R[2, 2]
    d_w = -thrust * R[:, 2] * (1.0, 1.0, 0.0)
    assert_allclose(unbiased_acceleration(thrust, R, d_w, ZERO, m), ZERO, atol=1e-9)
    printed = (thrust * R[:, 2] - G + d_w) / m
    assert_allclose(printed[2], GRAVITY * (1.0 - 1.0 / m), atol=1e-9)


# Torque and limits ------------------------------------------------------------------------------------


@given(tilted(), rates, rates, rates)
def test_the_torque_is_that_of_lee(R, omega, omega_d, dot):
    """Lee et al. 2010, eq. (16), with his errors, which have the other sign."""
    J = np.array(((0.02, 0.001, 0.0), (0.001, 0.03, -0.002), (0.0, -0.002, 0.04)))
    R_d, k = R @ so3.exp(np.array((0.4, -0.3, 0.8))), TorqueGains()
    integral = np.array((0.1, -0.2, 0.3))
    e_R = so3.vee(R_d.T @ R - R.T @ R_d) / 2.0
    e_omega = omega - R.T @ R_d @ omega_d
    lee = -np.array(k.k_R) * e_R - np.array(k.k_omega) * e_omega + np.cross(omega, J @ omega)
    lee -= J @ (so3.hat(omega) @ R.T @ R_d @ omega_d - R.T @ R_d @ dot)
    got = torque_command(R, R_d, omega, omega_d, dot, integral, J, k)
    assert_allclose(got, lee + np.array(k.k_iR) * integral, atol=1e-9)


@given(floats(-40.0, 40.0), rates, floats(0.5, 3.0))
def test_the_share_is_that_of_a_linear_programme(more, torque, size):
    craft = load_airframe("MK-Quadro")
    M, low, high = np.asarray(craft.allocation), float(craft.thrust_min), float(craft.thrust_max)
    hold = np.array((craft.m * GRAVITY, 0.0, 0.0, 0.0))
    u = hold + size * np.array((more, *(0.2 * torque)))
    A = np.linalg.inv(M)
    room = np.concatenate((high - A @ hold, A @ hold - low))
    rows = np.concatenate((A @ (u - hold), -A @ (u - hold)))[:, None]
    best = linprog([-1.0], A_ub=rows, b_ub=room, bounds=[(0.0, 1.0)]).x[0]
    got = scale_to_limits(u, hold, M, low, high)
    assert_allclose(got, hold + best * (u - hold), atol=1e-6)
    assert (A @ got > low - 1e-9).all()
    assert (A @ got < high + 1e-9).all()


def test_an_aircraft_that_cannot_hover_is_refused():
    M = np.asarray(load_airframe("MK-Quadro").allocation)
    with pytest.raises(BadInput, match="cannot hover"):
        scale_to_limits(np.ones(4), np.array((20.0, 0.0, 0.0, 0.0)), M, 0.3, 4.9)


# The controller ---------------------------------------------------------------------------------------


def test_what_was_learnt_changes_worlds_with_the_controller():
    part, shift = GeometricController(3.5, SIM), frames.Shift(np.array((5.0, 1.0, 0.0)), 1.1)
    x, y = at_rest((0.4, -0.3, 2.0), R=so3.about_z(0.3)), still((0.0, 0.0, 2.2), 0.5)
    memory = part.init(x, None)
    for _ in range(500):
        memory, _ = part.step(memory, x, y, 0.01)
    assert np.linalg.norm(memory.d_w) > 1.0
    _, here = part.step(memory, x, y, 0.01)
    moved = frames.moved(x, shift), frames.moved(y, shift)
    _, there = part.step(part.reframe(memory, shift), *moved, 0.01)
    for a, b in zip(frames.moved(here, shift), there, strict=True):
        assert_allclose(a, b, atol=1e-9)


def test_an_aircraft_that_is_held_down_asks_for_a_finite_command():
    part, x, y = GeometricController(3.5), at_rest(), still((0.0, 0.0, -50.0))
    memory = part.init(x, Command(30.0, ZERO, ZERO))
    for _ in range(3000):
        memory, command = part.step(memory, x, y, 0.01)
    assert memory.m_e == pytest.approx(0.35)
    assert command.f_d == pytest.approx(1.0)
    assert np.isfinite(command.a_d).all()
