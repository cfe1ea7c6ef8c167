"""The reference answers of lab 01 against scipy, closed forms and conservation laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation
from strategies import floats, headings, inertias, rates, rotations, states, vectors

from uavlab import so3
from uavlab.solutions.dynamics import (
    allocation_matrix,
    apparent_mass,
    force_from_throttle,
    motor_step,
    rigid_body_rate,
    rotor_thrusts,
    step_on_so3,
    throttle_from_force,
)
from uavlab.types import State

curves = st.tuples(floats(0.05, 0.5), floats(-1.3, 0.3))  # a_t, b_t of real and odd aircraft


@given(states(), vectors(50.0), vectors(5.0), floats(0.3, 20.0), inertias())
def test_power_becomes_kinetic_energy(state, force, torque, m, J):
    rate = rigid_body_rate(state, force, torque, m=m, J=J)
    growth = m * state.v @ rate.v_dot + state.omega @ J @ rate.omega_dot
    assert_allclose(growth, force @ state.v + torque @ state.omega, rtol=1e-9, atol=1e-8)


@given(states(), vectors(5.0), inertias())
def test_torque_changes_the_angular_momentum_in_the_world(state, torque, J):
    rate = rigid_body_rate(state, np.zeros(3), torque, m=1.0, J=J)
    change = rate.R_dot @ J @ state.omega + state.R @ J @ rate.omega_dot
    assert_allclose(change, state.R @ torque, atol=1e-9)


def test_a_tumbling_body_keeps_energy_and_angular_momentum():
    J = np.diag((0.01, 0.02, 0.027))
    start = State(np.zeros(3), np.zeros(3), np.eye(3), np.array((0.02, 6.0, -0.01)))

    def slope(_, x):
        state = State(x[:3], x[3:6], x[6:15].reshape(3, 3), x[15:])
        rate = rigid_body_rate(state, np.zeros(3), np.zeros(3), m=1.0, J=J)
        return np.concatenate([a.ravel() for a in rate])

    x0 = np.concatenate([a.ravel() for a in start])
    end = solve_ivp(slope, (0.0, 5.0), x0, method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    R, omega = end[6:15].reshape(3, 3), end[15:]
    assert_allclose(R @ J @ omega, J @ start.omega, atol=1e-8)
    assert_allclose(omega @ J @ omega, start.omega @ J @ start.omega, rtol=1e-9)
    assert abs(omega[1] - 6.0) > 1.0  # the intermediate axis is not stable: it did tumble


@given(rotations(), rates, floats(-2.0, 2.0))
def test_a_step_is_the_turn_that_scipy_makes(R, omega, dt):
    want = (Rotation.from_matrix(R) * Rotation.from_rotvec(omega * dt)).as_matrix()
    assert_allclose(step_on_so3(R, omega, dt), want, atol=1e-12)


@given(rotations(), rates, floats(0.0, 1.0), floats(0.0, 1.0))
def test_two_steps_make_one(R, omega, a, b):
    twice = step_on_so3(step_on_so3(R, omega, a), omega, b)
    assert_allclose(twice, step_on_so3(R, omega, a + b), atol=1e-12)


@given(st.integers(3, 8), st.data(), floats(0.05, 0.6), floats(0.005, 0.05))
def test_every_rotor_makes_the_torque_of_its_push_and_of_its_drag(n, data, arm, c):
    angles = np.array(data.draw(st.lists(headings, min_size=n, max_size=n)))
    spins = np.array(data.draw(st.lists(st.sampled_from((-1.0, 1.0)), min_size=n, max_size=n)))
    M = allocation_matrix(angles, arm, c, spins)
    assert M.shape == (4, n)
    for k in range(n):
        push = np.array((0.0, 0.0, 1.0))
        place = Rotation.from_euler("z", angles[k]).apply((arm, 0.0, 0.0))
        assert_allclose(M[0, k], 1.0)
        assert_allclose(M[1:, k], np.cross(place, push) + c * spins[k] * push, atol=1e-15)


def test_the_quadrotor_of_spica_has_the_matrix_that_is_printed():
    M = allocation_matrix(np.radians([0, 90, 180, 270]), 0.25, 0.0174, np.array([1.0, -1, 1, -1]))
    want = [
        [1, 1, 1, 1],
        [0, 0.25, 0, -0.25],
        [-0.25, 0, 0.25, 0],
        [0.0174, -0.0174, 0.0174, -0.0174],
    ]
    assert_allclose(M, want, atol=1e-15)


@pytest.mark.parametrize("n", [4, 6, 8])
@given(seed=st.integers(0, 1000))
def test_rotor_thrusts_make_what_was_asked_and_waste_nothing(n, seed):
    rng = np.random.default_rng(seed)
    M = allocation_matrix(
        2 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n,
        0.3,
        0.02,
        np.resize((1.0, -1.0), n),
    )
    u = np.array((20.0, *rng.normal(size=3)))
    thrusts = rotor_thrusts(u[0], u[1:], M)
    assert_allclose(M @ thrusts, u, atol=1e-9)
    assert_allclose(null_space(M).T @ thrusts, 0.0, atol=1e-9)


@given(floats(0.0, 1000.0), floats(0.0, 1000.0), floats(0.01, 0.2), floats(0.0, 1.0))
def test_a_motor_follows_the_differential_equation(speed, command, tau, share):
    got = motor_step(np.array([speed]), np.array([command]), tau, share * tau)
    if share > 0:
        ode = solve_ivp(
            lambda _, w: (command - w) / tau, (0, share * tau), [speed], rtol=1e-9, atol=1e-9
        )
        assert_allclose(got, ode.y[:, -1], atol=1e-4)
    else:
        assert_allclose(got, [speed], atol=1e-12)


@given(curves, floats(0.0, 500.0))
def test_throttle_and_force_are_inverse(curve, f):
    T = throttle_from_force(f, *curve)
    assert_allclose(force_from_throttle(T, *curve), f, rtol=1e-9, atol=1e-9)
    assert_allclose(apparent_mass(T, *curve, 9.81), f / 9.81, rtol=1e-9, atol=1e-9)


@given(curves, floats(-100.0, 0.0))
def test_a_pull_asks_for_as_little_as_nothing(curve, f):
    assert throttle_from_force(f, *curve) == curve[1]


@given(curves, floats(0.0, 2.0))
def test_below_the_offset_the_rotors_stand_still(curve, below):
    assert force_from_throttle(curve[1] - below, *curve) == 0.0
    assert apparent_mass(curve[1] - below, *curve, 9.81) == 0.0


def test_real_hover_data_give_back_the_masses():
    # T650 of the MRS group: three hover tests, fitted per motor; collective a_t = a / sqrt(n).
    a_t, b_t = 0.32 / np.sqrt(4), -0.437
    for mass, throttle in ((3.6, 0.515), (4.2, 0.59), (4.78, 0.66)):
        assert_allclose(apparent_mass(throttle, a_t, b_t, 9.81), mass, rtol=0.02)
        assert_allclose(throttle_from_force(mass * 9.81, a_t, b_t), throttle, atol=0.006)


@given(states(), vectors(10.0), vectors(1.0))
def test_inputs_are_left_alone(state, force, torque):
    before = [x.copy() for x in (*state, force, torque)]
    rigid_body_rate(state, force, torque, m=1.0, J=np.eye(3))
    step_on_so3(state.R, state.omega, 0.1)
    for was, x in zip(before, (*state, force, torque), strict=True):
        assert np.array_equal(was, x)


def test_an_hour_of_steps_stays_on_the_group():
    R, omega = np.eye(3), np.array((1.0, -2.0, 0.5))
    for _ in range(10_000):
        R = step_on_so3(R, omega, 0.01)
    assert_allclose(R @ R.T, np.eye(3), atol=1e-11)
    assert so3.angle(R, so3.exp(100.0 * omega)) < 1e-10
