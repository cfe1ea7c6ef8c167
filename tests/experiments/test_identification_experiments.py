"""Identification flown again: benches and flights that say what they claim, and verdicts that a wrong answer loses."""

import numpy as np
import pytest

from uavlab.experiments import adaptive_mass, attitude_fit, bench_tests, find_experiment
from uavlab.experiments.answers import answer
from uavlab.plant import load_airframe

MK = load_airframe("MK-Quadro")
G = 9.81


def quiet(monkeypatch):
    """Instruments without noise."""
    for name in ("FORCE_NOISE", "TORQUE_NOISE", "SPEED_NOISE"):
        monkeypatch.setattr(bench_tests, name, 0.0)


def wrong(monkeypatch, module, name, change):
    """Let one answer of the lab be another."""

    def other(stem, asked):
        right = answer(stem, asked)
        return change(right) if asked == name else right

    monkeypatch.setattr(module, "answer", other)


# 003-4 ------------------------------------------------------------------------------------------------


def test_commands_30_and_180_give_the_printed_thrusts():
    speed = bench_tests.wanted_speed(MK, np.array((30.0, 180.0)))
    np.testing.assert_allclose(MK.thrust_coefficient * speed**2, (0.3131, 6.03), rtol=1e-3)


def test_the_bench_holds_17_steps_for_5_seconds_each_after_10_of_rest():
    record = bench_tests.bench_record(MK, 0)
    assert record.t[-1] == pytest.approx(17 * 15.0, abs=0.01)
    assert sorted(set(record.command)) == list(range(30, 191, 10))
    np.testing.assert_array_equal(record.command[record.t < 10.0], 30.0)
    np.testing.assert_array_equal(record.command[(record.t > 40.01) & (record.t < 44.9)], 50.0)


def test_without_noise_the_bench_finds_the_motor(monkeypatch):
    quiet(monkeypatch)
    found = bench_tests.identified(MK, bench_tests.bench_record(MK, 0))
    assert found.tau == pytest.approx(0.047, rel=2e-3)
    assert found.c == pytest.approx(0.0174, rel=1e-9)
    assert found.rms < 1e-6


def test_the_bench_is_met_and_a_time_constant_in_other_units_is_not(monkeypatch):
    experiment = find_experiment("003-4")
    assert experiment.outcome(2).met
    wrong(monkeypatch, bench_tests, "motor_time_constant", lambda right: lambda *x: 1.1 * right(*x))
    assert [row.met for row in experiment.outcome(1).rows] == [False, True, True, True, True]


# 003-5, 000-33 ----------------------------------------------------------------------------------------


def test_calibration_brings_the_specific_force_to_g_and_refuses_a_gyro_that_was_moved():
    found = bench_tests.at_rest(3)
    assert np.std(found.raw - G) > 3.0 * np.std(found.right - G)
    np.testing.assert_allclose(found.right, G, atol=0.2)
    assert found.refused


def test_a_transposed_matrix_is_seen_by_the_verdict(monkeypatch):
    def transposed(right):
        def calibration(samples, attitudes):
            T, b = right(samples, attitudes)
            return T.T, b

        return calibration

    wrong(monkeypatch, bench_tests, "accelerometer_calibration", transposed)
    met = [row.met for row in bench_tests.sensors_at_rest(2).rows]
    assert met[0] is True
    assert met[2:4] == [False, False]


def test_the_thrust_curves_are_those_that_mrs_configures():
    outcome = find_experiment("000-33").outcome()
    assert outcome.met
    assert sum(row.met is True for row in outcome.rows) == 4


# 003-1 ------------------------------------------------------------------------------------------------


def test_the_mass_is_told_again_from_a_log_as_the_flight_had_it(monkeypatch):
    kept, real = [], adaptive_mass.learned

    def kept_too(*told):
        kept.append(real(*told))
        return kept[-1]

    monkeypatch.setattr(adaptive_mass, "learned", kept_too)
    log = adaptive_mass.flown(0, 1.0, end=2.0)
    had = [1.0 / memory.inverse for memory in kept]
    again = adaptive_mass.masses(log, adaptive_mass.STANDING)
    np.testing.assert_allclose(again, had, rtol=1e-12)


@pytest.mark.flight
def test_worn_rotors_lift_less_than_they_are_commanded_and_the_estimate_makes_up_for_it():
    share = adaptive_mass.WORN
    log = adaptive_mass.flown(0, share, end=30.0)
    hover = log.t > 26.0
    assert log.rotors[hover].sum(axis=1).mean() == pytest.approx(1.308 * G, rel=2e-3)
    assert log.f_d[hover].mean() == pytest.approx(1.394 * G, rel=2e-3)
    mass = adaptive_mass.masses(log, adaptive_mass.STANDING)
    assert mass[log.t < 3.5] == pytest.approx(
        1.0, abs=0.01
    )  # on the ground: commanded thrust over g
    assert mass[-1] == pytest.approx(1.394, rel=0.01)


def test_equation_6_as_printed_brings_the_aircraft_down():
    log = adaptive_mass.flown_as_printed()
    assert log.exit.name == "CRASH"
    assert (adaptive_mass.masses(log, adaptive_mass.HOVERING, -G) < 0.0).all()


# 001-8 ------------------------------------------------------------------------------------------------


def test_a_tilt_pushes_to_the_side_that_the_linear_model_says():
    flight = attitude_fit.flown(np.random.default_rng(0), (0.1, 0.1))
    n = 100
    for axis in range(3):
        push = attitude_fit._integral(attitude_fit.pushes(flight)[:, axis])
        gained, given = flight.v[n:, axis] - flight.v[:-n, axis], push[n:] - push[:-n]
        assert np.corrcoef(gained, given)[0, 1] > 0.9


def test_damping_is_found_in_a_flight_that_has_it():
    t = np.arange(2000) / attitude_fit.RATE
    tilt = np.column_stack((0.1 * np.sin(2.0 * t), 0.0 * t))
    c, push, v = 0.3, G * tilt[:, 0], np.zeros((len(t), 3))
    for k in range(1, len(t)):  # v̇ = push − c v, the push taken between its samples
        mean = 0.5 * (push[k] + push[k - 1])
        v[k, 0] = v[k - 1, 0] * np.exp(-c / 100) + mean * (1 - np.exp(-c / 100)) / c
    flight = attitude_fit.Flown(t, tilt, tilt, v, 0.0 * t)
    assert attitude_fit.damping(flight, 0) == pytest.approx(c, rel=1e-4)


def test_the_attitude_model_is_the_step_response_of_a_second_order_loop():
    step = attitude_fit.attitude_model(np.array((49.0, 14.0, 98.0)), np.ones(300))
    t = np.arange(300) / attitude_fit.RATE  # double pole at −7, steady gain 2
    np.testing.assert_allclose(step, 2.0 * (1.0 - (1.0 + 7.0 * t) * np.exp(-7.0 * t)), atol=1e-9)


def test_a_fit_is_100_for_the_truth_and_0_for_its_mean():
    y = np.sin(np.arange(100.0))
    assert attitude_fit.fit(y, y) == 100.0
    assert attitude_fit.fit(y, np.full(100, y.mean())) == pytest.approx(0.0, abs=1e-9)


def test_the_attitude_loop_is_met_by_the_answer_and_lost_by_one_without_its_damping(monkeypatch):
    models = attitude_fit.identified(np.random.default_rng(1))
    flight = attitude_fit.flown(np.random.default_rng(2), (0.12, 0.12))
    for axis in range(2):
        right = attitude_fit.attitude_model(models.b[axis], flight.reference[:, axis])
        assert attitude_fit.fit(flight.tilt[:, axis], right) > 85.0
        b = models.b[axis] * (1.0, 0.3, 1.0)
        wrong_one = attitude_fit.attitude_model(b, flight.reference[:, axis])
        assert attitude_fit.fit(flight.tilt[:, axis], wrong_one) < 85.0
