"""The reference answers of lab 05 against numpy, scipy, closed forms, and the numbers of the papers; see its twin."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import curve_fit
from scipy.signal import lsim
from scipy.spatial.transform import Rotation
from strategies import floats

from uavlab.errors import BadInput
from uavlab.exercises import bench
from uavlab.solutions.identification import (
    accelerometer_calibration,
    attitude_response,
    drag_coefficient,
    gyro_bias,
    motor_time_constant,
    quadratic_drag,
    thrust_curve,
    thrust_polynomial,
)

G = 9.81
seeds = st.integers(0, 10_000).map(np.random.default_rng)


# The bench of the checks itself -----------------------------------------------------------------------


@pytest.mark.parametrize("b", [(49.0, 9.8, 49.0), (49.0, 14.0, 60.0), (30.0, 20.0, 10.0)])
def test_the_made_up_loop_is_the_one_of_scipy(b):
    t = np.arange(0.0, 5.0, 0.02)
    reference = bench.stick(np.random.default_rng(1), t) * np.clip(t, 0.0, 1.0)
    _, want, _ = lsim(([b[2]], [1.0, b[1], b[0]]), reference, t)
    assert_allclose(bench.loop(t, reference, *b), want, atol=1e-12)


def test_the_made_up_motor_is_the_one_of_an_integrator():
    t = np.linspace(0.0, 0.3, 31)
    command = np.where(np.arange(31) < 12, 700.0, 300.0)
    y = [400.0]
    for i in range(30):
        far = solve_ivp(lambda _, x, c=command[i]: (c - x) / 0.05, (0.0, 0.01), y[-1:], rtol=1e-10)
        y.append(far.y[0, -1])
    assert_allclose(bench.lag(t, command, 0.05, 400.0), y, rtol=1e-8)


# Sensors at rest --------------------------------------------------------------------------------------


def test_the_gyro_bias_of_noise_is_found_as_well_as_the_number_of_samples_allows():
    samples = 0.02 * np.random.default_rng(1).normal(size=(10_000, 3)) + (0.1, -0.2, 0.3)
    assert_allclose(gyro_bias(samples, 0.03), (0.1, -0.2, 0.3), atol=4 * 0.02 / 100.0)


def test_an_aircraft_that_moved_is_told_by_axis_value_bound_and_cure():
    samples = np.zeros((10, 3))
    samples[5:, 1] = 1.0
    with pytest.raises(
        BadInput, match=r"along body y .* 0\.5 rad/s; at most 0\.1 .* Hold it still"
    ):
        gyro_bias(samples, 0.1)
    assert_allclose(gyro_bias(samples, 0.6), (0.0, 0.5, 0.0))


@settings(max_examples=20)
@given(seeds)
def test_a_calibration_makes_gravity_of_every_reading(rng):
    made, R = bench.sensor(rng), bench.attitudes(rng, 6)
    T, b = accelerometer_calibration(bench.at_rest(made, R), R)
    assert_allclose(T, made.T, atol=1e-9)
    assert_allclose(b, made.b, atol=1e-9)


def test_the_calibration_meets_its_acceptance_numbers_in_noise():
    """N = 24 orientations and 0.05 m/s² of noise; offset and matrix as facts.md says, for the mean of many runs."""
    rng = np.random.default_rng(5)
    errors = []
    for _ in range(60):
        made, R = bench.sensor(rng), Rotation.random(24, rng=rng).as_matrix()
        T, b = accelerometer_calibration(
            bench.at_rest(made, R) + 0.05 * rng.normal(size=(24, 3)), R
        )
        errors.append((np.abs(b - made.b).mean(), np.abs(T - made.T).mean()))
    offset, matrix = np.mean(errors, axis=0)
    assert offset < 0.02
    assert matrix < 0.01


def test_orientations_in_one_plane_do_not_calibrate():
    made = bench.sensor(np.random.default_rng(2))
    R = Rotation.from_euler("x", np.linspace(-1.5, 1.5, 9)[:, None]).as_matrix()
    with pytest.raises(BadInput, match=r"determine 3 of 4 unknowns.*tilt it about two axes"):
        accelerometer_calibration(bench.at_rest(made, R), R)
    with pytest.raises(BadInput, match="samples has 3 samples; at least 4"):
        accelerometer_calibration(np.ones((3, 3)), R[:3])


# Motors and thrust ------------------------------------------------------------------------------------


@settings(max_examples=20)
@given(seeds, floats(0.02, 0.08))
def test_the_time_constant_agrees_with_a_fit_of_the_exponential(rng, tau):
    t = np.linspace(0.0, 8.0 * tau, 400)
    command = np.full(400, 700.0)
    speed = bench.lag(t, command, tau, 300.0) + 3.0 * rng.normal(size=400)

    def model(t, tau, start):
        return 700.0 + (start - 700.0) * np.exp(-t / tau)

    (want, _), _ = curve_fit(model, t, speed, p0=(0.05, 300.0))
    assert_allclose(motor_time_constant(t, command, speed), want, rtol=0.03)


def test_the_time_constant_of_spica_is_found_on_his_bench_to_one_percent():
    """Steps of 0.5 s up and back, 47 ms, noise of half a percent."""
    t = np.arange(0.0, 6.0, 0.004)
    command = np.where((t % 1.0) < 0.5, 300.0 + 60.0 * np.floor(t), 200.0)
    noise = 2.0 * np.random.default_rng(3).normal(size=len(t))
    speed = bench.lag(t, command, 0.047, 200.0) + noise
    assert_allclose(motor_time_constant(t, command, speed), 0.047, rtol=0.01)


def test_a_motor_that_does_not_follow_is_refused():
    t = np.linspace(0.0, 1.0, 100)
    steady, noise = np.full(100, 400.0), np.random.default_rng(0).normal(size=100)
    with pytest.raises(BadInput, match="a step of the command"):
        motor_time_constant(t, steady, steady)
    with pytest.raises(BadInput, match="speed does not follow command"):
        motor_time_constant(t, steady, steady + noise)
    with pytest.raises(BadInput, match=r"t runs backwards .* t\[0\] = 1 s"):
        motor_time_constant(t[::-1], steady, steady + noise)


@settings(max_examples=20)
@given(seeds)
def test_the_thrust_polynomial_is_the_one_of_numpy(rng):
    speed = rng.uniform(100.0, 900.0, size=15)
    force = 1e-5 * speed**2 + 0.1 * rng.normal(size=15)
    want = np.polynomial.Polynomial.fit(speed, force, 2).convert().coef
    assert_allclose(thrust_polynomial(speed, force), want, rtol=1e-7, atol=1e-12)


@settings(max_examples=20)
@given(seeds, floats(1.0, 12.0))
def test_the_thrust_curve_is_the_line_of_numpy(rng, g):
    mass, throttle = rng.uniform(1.0, 6.0, size=8), rng.uniform(0.3, 0.8, size=8)
    assert_allclose(
        thrust_curve(throttle, mass, g), np.polyfit(np.sqrt(g * mass), throttle, 1), rtol=1e-8
    )


@pytest.mark.parametrize(
    ("n", "mass", "throttle", "one_rotor"),
    [
        (4, (3.6, 4.2, 4.78), (0.515, 0.59, 0.66), (0.32, -0.437)),
        (8, (7.30, 10.20, 13.15, 16.05), (0.3548, 0.4633, 0.5748, 0.6530), (0.20912, -0.27171)),
    ],
    ids=["T650", "T18"],
)
def test_hover_tests_of_real_aircraft_give_the_curves_they_fly_with(n, mass, throttle, one_rotor):
    a_t, b_t = thrust_curve(np.array(throttle), np.array(mass), G)
    assert_allclose((a_t * np.sqrt(n), b_t), one_rotor, rtol=0.03)


def test_curves_that_are_not_determined_are_refused():
    with pytest.raises(BadInput, match=r"2 of 3 unknowns.*three different speeds"):
        thrust_polynomial(np.array((1.0, 2.0, 1.0, 2.0)), np.ones(4))
    with pytest.raises(BadInput, match="two different masses"):
        thrust_curve(np.array((0.4, 0.5)), np.array((2.0, 2.0)), G)
    with pytest.raises(BadInput, match="must be above 0, in kg"):
        thrust_curve(np.array((0.4, 0.5)), np.array((2.0, -2.0)), G)


# Drag -------------------------------------------------------------------------------------------------


def flight(rng, n, c_2, c, offset, force=0.0, speed=0.0):
    V, a_z = rng.uniform(-14.0, 14.0, size=(n, 2)), rng.uniform(8.0, 12.0, size=n)
    lateral = -np.sqrt(a_z)[:, None] * (c_2 * V * np.abs(V) + c * V + offset)
    accel = np.column_stack((lateral + force * rng.normal(size=(n, 2)), a_z))
    return accel, V + speed * rng.normal(size=(n, 2))


def test_the_drag_of_bangura_is_found_to_five_percent_with_gnss_noise():
    for seed in range(5):
        accel, V = flight(np.random.default_rng(seed), 8000, 0.0, 0.0794, 0.0224, 2.5, 0.5)
        c, offset, r2 = drag_coefficient(accel, V)
        assert_allclose(c, 0.0794, rtol=0.05)
        assert_allclose(offset, 0.0224, atol=0.05)
        assert np.all((r2 > 0.3) & (r2 < 0.6))


def test_both_fits_of_bangura_come_out_of_what_they_say():
    rng = np.random.default_rng(1)
    accel, V = flight(rng, 50, 0.00209, 0.02586, 0.0162)
    c_2, c, offset, r2 = quadratic_drag(accel, V)
    for got, want in ((c_2, 0.00209), (c, 0.02586), (offset, 0.0162), (r2, 1.0)):
        assert_allclose(got, want, rtol=1e-9)
    assert np.all(drag_coefficient(accel, V)[2] < 1.0)


@settings(max_examples=20)
@given(seeds)
def test_what_drag_leaves_is_square_to_what_explains_it(rng):
    accel, V = flight(rng, 40, 0.01, 0.05, 0.1, force=1.0)
    y = -accel[:, :2] / np.sqrt(accel[:, 2:])
    c, offset, r2 = drag_coefficient(accel, V)
    left = y - c * V - offset
    assert_allclose([(left * V).sum(0), left.sum(0)], 0.0, atol=1e-9)
    assert_allclose(r2, [np.corrcoef(V[:, i], y[:, i])[0, 1] ** 2 for i in (0, 1)], rtol=1e-9)
    c_2, c, offset, _ = quadratic_drag(accel, V)
    left = y - c_2 * V * np.abs(V) - c * V - offset
    assert_allclose([(left * V * np.abs(V)).sum(0), (left * V).sum(0)], 0.0, atol=1e-8)


def test_noise_in_the_velocity_draws_the_slope_towards_zero_by_the_formula():
    rng = np.random.default_rng(4)
    V = 2.0 * rng.normal(size=(40_000, 2))
    accel = np.column_stack((-0.08 * np.sqrt(G) * V, np.full(len(V), G)))
    c, _, _ = drag_coefficient(accel, V + rng.normal(size=V.shape))
    assert_allclose(c / 0.08, 4.0 / 5.0, atol=0.01)


def test_a_flight_that_tells_no_drag_is_refused():
    accel, V = flight(np.random.default_rng(0), 20, 0.0, 0.08, 0.0)
    with pytest.raises(BadInput, match="speeds along body y: fly to and fro"):
        drag_coefficient(accel, V * (1.0, 0.0))
    with pytest.raises(BadInput, match=r"2 of 3 unknowns.*along body x"):
        quadratic_drag(accel, np.where(V > 0.0, 5.0, -5.0) * (1.0, 1.2))
    with pytest.raises(BadInput, match=r"0 samples have a_z above 1.*is the sign right"):
        drag_coefficient(accel * (1.0, 1.0, -1.0), V)
    broken = accel.copy()
    broken[7, 0] = np.nan
    with pytest.raises(BadInput, match=r"accel\[7\] is \[nan.*1 of 20 samples.*Drop these rows"):
        drag_coefficient(broken, V)


def test_inputs_are_left_alone():
    rng = np.random.default_rng(0)
    t = np.arange(0.0, 3.0, 0.01)
    reference = bench.stick(rng, t)
    measured = bench.loop(t, reference, 49.0, 9.8, 49.0)
    accel, V = flight(rng, 20, 0.01, 0.08, 0.1)
    R = bench.attitudes(rng, 5)
    samples = bench.at_rest(bench.sensor(rng), R)
    given_ = (t, reference, measured, accel, V, R, samples)
    before = [x.copy() for x in given_]
    attitude_response(t, reference, measured), motor_time_constant(t, reference, 0.9 * measured)
    drag_coefficient(accel, V), quadratic_drag(accel, V)
    accelerometer_calibration(samples, R), gyro_bias(samples, 100.0)
    for was, x in zip(before, given_, strict=True):
        assert np.array_equal(was, x)


def test_orientations_that_only_noise_tells_apart_are_refused_with_a_cure():
    rng = np.random.default_rng(8)
    R = Rotation.from_euler("z", np.linspace(0, 300, 12)[:, None], degrees=True).as_matrix()
    samples = R[:, 2] * 9.81 + 0.05 * rng.normal(size=(12, 3))
    with pytest.raises(BadInput, match="tilt it about two axes"):
        accelerometer_calibration(samples, R)
