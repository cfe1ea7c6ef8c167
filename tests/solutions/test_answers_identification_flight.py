"""The reference answers of lab 05 on flights: mass, inertia and attitude loop against scipy and the papers' numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares
from scipy.signal import lfilter, lsim
from scipy.spatial.transform import Rotation
from strategies import floats

from uavlab.errors import BadInput
from uavlab.exercises import bench
from uavlab.solutions.identification import attitude_response, inertia_step, mass_step
from uavlab.types import InertiaMemory, MassMemory

G = 9.81
seeds = st.integers(0, 10_000).map(np.random.default_rng)


# Mass and inertia -------------------------------------------------------------------------------------


def continuous(memory, v_z, lift, dt, a, k, g):
    """The four differential equations of Spica with corrected signs, by scipy: filters first, then the estimate."""

    def filters(_, x):
        return a * (np.array((v_z, lift, g)) - x)

    x = solve_ivp(filters, (0.0, dt), memory[:3], rtol=1e-10, atol=1e-12).y[:, -1]
    y = a * (v_z - x[0]) + x[2]
    learn = solve_ivp(
        lambda _, m: k * (y - m * x[1]) * x[1], (0.0, dt), memory[3:], "LSODA", rtol=1e-10
    )
    return (*x, learn.y[0, -1])


@settings(max_examples=15)
@given(seeds, floats(0.002, 0.2))
def test_a_mass_step_is_the_solution_of_its_differential_equations(rng, dt):
    memory = MassMemory(*(float(x) for x in rng.uniform((-1, 5, 5, 0.4), (1, 20, 10, 1.2))))
    v_z, u_1, R = float(rng.normal()), float(rng.uniform(5.0, 25.0)), Rotation.random(rng=rng)
    R = R.as_matrix()
    got = mass_step(memory, v_z, R, u_1, dt, a=0.5, k=0.3, g=G)
    assert_allclose(got, continuous(memory, v_z, u_1 * R[2, 2], dt, 0.5, 0.3, G), rtol=1e-4)


def weigh(dt, T, m, efficiency=1.0, law=mass_step):
    """Estimate [kg] over `T` seconds of a flight up and down with a mass of `m` [kg]."""
    memory, v, said = MassMemory(0.0, 0.0, 0.0, 1.0 / 0.9), 0.0, []
    for t in np.arange(0.0, T, dt):
        u_1 = (m * G + 2.0 * np.sin(t)) / efficiency
        v += dt * (u_1 * efficiency / m - G)
        memory = law(memory, v, np.eye(3), u_1, dt, a=0.06 * np.pi, k=1.0, g=G)
        said.append(1.0 / memory.inverse)
    return np.array(said)


@pytest.mark.parametrize("rate", [500.0, 100.0, 60.0, 20.0])
def test_the_mass_is_found_at_any_rate(rate):
    assert_allclose(weigh(1.0 / rate, 12.0, 1.308)[-5:], 1.308, rtol=0.006)


def test_rotors_that_give_938_thousandths_make_the_1394_grams_of_spica():
    assert_allclose(weigh(0.01, 12.0, 1.308, efficiency=0.938)[-1], 1.394, atol=0.003)


def test_the_printed_sign_makes_a_negative_mass():
    """Errata: (6), (7) and (9) with g = +9.81. What the printed law learns is not the aircraft."""

    def printed(memory, v, R, u_1, dt, *, a, k, g):
        return mass_step(memory, v, R, u_1, dt, a=a, k=k, g=-g)

    assert weigh(0.01, 12.0, 1.308, law=printed)[-1] < 0.0


def test_a_step_of_euler_runs_away_where_the_exact_one_does_not():
    """Errata: (10) is stiff; an Euler step multiplies the error by 1 − k υ² dt."""
    m, dt = 1.308, 1.0 / 60.0
    assert abs(1.0 - (m * G) ** 2 * dt) > 1.0
    memory = MassMemory(0.0, m * G, G, 2.0 / m)
    for _ in range(5):
        memory = mass_step(memory, 0.0, np.eye(3), m * G, dt, a=0.19, k=1.0, g=G)
    assert_allclose(1.0 / memory.inverse, m, rtol=1e-5)


def test_the_filters_are_the_ones_of_scipy():
    rng = np.random.default_rng(8)
    v, u, dt, a = rng.normal(size=40), rng.uniform(5.0, 20.0, size=40), 0.02, 0.7
    keep = np.exp(-a * dt)
    memory, said = MassMemory(0.0, 0.0, 0.0, 1.0), []
    for v_z, u_1 in zip(v, u, strict=True):
        memory = mass_step(memory, v_z, np.eye(3), u_1, dt, a=a, k=0.1, g=G)
        said.append(memory[:3])
    for got, x in zip(np.transpose(said), (v, u, np.full(40, G)), strict=True):
        assert_allclose(got, lfilter([1.0 - keep], [1.0, -keep], x), rtol=1e-10, atol=1e-12)


def test_the_inertia_is_found_while_the_aircraft_is_shaken():
    """J of facts.md for Spica's aircraft, which turns slowly about z, and has the gyroscopic term."""
    J, dt = np.array((0.0125, 0.0125, 0.024)), 0.004
    omega, memory = np.zeros(3), InertiaMemory(np.zeros(3), np.zeros(3), 2.0 / J)
    for i in range(1500):
        torque = np.array((0.03, 0.03, 0.002)) * np.cos(np.array((2.1, 2.9, 4.3)) * i * dt)

        def turn(_, w, torque=torque):
            return (torque - np.cross(w, J * w)) / J

        k_1 = turn(0, omega)
        omega = omega + dt * turn(0, omega + 0.5 * dt * k_1)
        memory = inertia_step(memory, omega, torque, dt, a=1.0, k=1e8)
    assert_allclose(1.0 / memory.inverse, J, rtol=0.05)


def test_steps_that_mean_nothing_are_refused():
    mass = MassMemory(0.0, 0.0, 0.0, 1.0)
    for wrong in ({"a": 0.0, "k": 1.0}, {"a": 1.0, "k": -1.0}, {"a": np.nan, "k": 1.0}):
        with pytest.raises(BadInput, match="must be finite and above 0"):
            mass_step(mass, 0.0, np.eye(3), 10.0, 0.01, **wrong, g=G)
    with pytest.raises(BadInput, match=r"dt is 0\.0"):
        inertia_step(InertiaMemory(*np.ones((3, 3))), np.zeros(3), np.ones(3), 0.0, a=1.0, k=1.0)


# The attitude loop ------------------------------------------------------------------------------------


def record(rng, b, noise=0.0, T=20.0, cut=4.0):
    t = np.arange(0.0, T + cut, 0.01)
    reference = bench.stick(rng, t)
    tilt = bench.loop(t, reference, *b)
    part = t >= cut
    return t[part], reference[part], tilt[part] + noise * rng.normal(size=part.sum())


@settings(max_examples=10, deadline=None)
@given(seeds, floats(4.0, 9.0), floats(0.3, 1.2), floats(0.7, 1.3))
def test_the_loop_that_flew_is_found(rng, pace, damping, gain):
    b = np.array((pace**2, 2.0 * damping * pace, gain * pace**2))
    assert_allclose(attitude_response(*record(rng, b)), b, rtol=0.01)


def test_the_fit_is_as_good_as_that_of_a_simulation_in_the_time_domain():
    """Output error by scipy, over the first state too: the same answer, near the truth as noise lets it be."""
    rng, b = np.random.default_rng(3), (49.0, 9.8, 49.0)
    t, reference, measured = record(rng, b, noise=0.005, T=10.0)

    def off(x):
        A, B = [[0.0, 1.0], [-x[0], -x[1]]], [[0.0], [x[2]]]
        tilt = lsim((A, B, [[1.0, 0.0]], [[0.0]]), reference, t - t[0], X0=x[3:5])[1]
        return tilt + x[5] - measured

    slow = least_squares(
        off, (40.0, 8.0, 40.0, measured[0], 0.0, 0.0), x_scale=(50, 10, 50, 0.1, 1, 0.1)
    )
    sigma = 0.005 * np.sqrt(np.diag(np.linalg.inv(slow.jac.T @ slow.jac)))[:3]
    got = np.array(attitude_response(t, reference, measured))
    assert np.all(np.abs(got - slow.x[:3]) < 1.5 * sigma)
    assert np.all(np.abs(got - b) < 4.0 * sigma)


def test_noise_does_not_draw_the_answer():
    """The mean over many noisy records is the truth, to what that mean can tell."""
    b = np.array((49.0, 9.8, 49.0))
    said = [attitude_response(*record(np.random.default_rng(s), b, noise=0.01)) for s in range(30)]
    error = np.std(said, axis=0) / np.sqrt(30)
    assert np.all(np.abs(np.mean(said, axis=0) - b) < 4.0 * error)


def test_the_model_of_one_noisy_flight_tells_another():
    b = (49.0, 9.8, 45.0)
    got = attitude_response(*record(np.random.default_rng(1), b, noise=0.005))
    t, reference, tilt = record(np.random.default_rng(2), b, cut=0.0)
    _, told, _ = lsim(([got[2]], [1.0, got[1], got[0]]), reference, t)
    assert np.std(told - tilt) < 0.03 * np.std(tilt)


@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_one_frequency_in_steady_swing_does_not_tell_three_numbers(noise):
    t = np.arange(0.0, 20.0, 0.01)
    swing = 0.08 * np.sin(2 * np.pi * t - 0.7) + noise * np.random.default_rng(0).normal(
        size=len(t)
    )
    with pytest.raises(BadInput, match="Move the stick"):
        attitude_response(t, 0.1 * np.sin(2 * np.pi * t), swing)


def test_flights_that_tell_nothing_are_refused():
    rng = np.random.default_rng(6)
    t, reference, measured = record(rng, (49.0, 9.8, 49.0))
    noise = 0.003 * rng.normal(size=len(t))
    with pytest.raises(BadInput, match=r"moves by 0 rad in all; at least 1e-06.*Excite"):
        attitude_response(t, np.full(len(t), 0.2), measured)
    with pytest.raises(BadInput, match="does not excite the loop"):
        attitude_response(t, 1e-3 * reference, noise)
    with pytest.raises(BadInput, match="t runs backwards"):
        attitude_response(t[::-1], reference, measured)
    with pytest.raises(BadInput, match=r"measured has shape \(1900,\); \(2000\) is needed"):
        attitude_response(t, reference, measured[:1900])
