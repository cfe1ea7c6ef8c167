"""Real flights: the experiments on them find what was put into made-up ones, and train on no flight they judge."""

import numpy as np
import pytest
from real_flights import recording

from uavlab import so3
from uavlab.datasets import read_dot, read_rtk
from uavlab.datasets.alignment import Alignment
from uavlab.experiments import find_experiment, real_attitude, real_drag, real_velocity
from uavlab.experiments.real_flights import Flown, flown, offsets, pooled

C = 0.09


def made(flight, wind=(0.0, 0.0), c=C, seed=1, unit=1):
    """A flight on which drag is exactly c √a_z (V − wind), with V of RTK."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 30.0, 0.1)
    V = np.stack((2 + np.sin(t), 3 * np.cos(0.7 * t), 0 * t), axis=1) + rng.normal(size=3)
    a_z = 9.81 + np.sin(2 * t)
    force = -c * np.sqrt(a_z)[:, None] * (V[:, :2] - np.array(wind))
    sat = Alignment(0.0, np.eye(3), 0.0, 0.0, 0.0, 0.0)
    return Flown(flight, unit, sat, t, np.column_stack((force, a_z)), V)


def test_drag_is_found_again_whatever_the_wind():
    assert pooled([made("a", (1.0, -2.0)), made("b", (-3.0, 0.5), seed=2)]) == pytest.approx(C)


def test_the_offset_of_a_flight_is_the_wind_times_the_drag():
    found = offsets([made("a", (1.0, -2.0))], C)
    np.testing.assert_allclose(found, [[-C * 1.0, C * 2.0]], atol=1e-12)


def test_both_models_fit_a_linear_drag_and_see_no_quadratic_part():
    found = real_drag.fit(made("a"))
    np.testing.assert_allclose(found.c, C)
    np.testing.assert_allclose(found.r2, 1.0)
    np.testing.assert_allclose(found.quadratic, [[0.0, C], [0.0, C]], atol=1e-9)


def test_velocity_from_drag_is_through_the_air_and_a_zeroed_offset_makes_it_over_ground():
    one = made("a", (1.0, -2.0))
    told = real_velocity.told(one, [made("b", (0.0, 0.0), seed=2)])
    np.testing.assert_allclose(told.blind, one.V[:, :2] - [1.0, -2.0], atol=1e-9)
    np.testing.assert_allclose(told.zeroed, one.V[:, :2], atol=1e-9)


def test_no_flight_is_judged_with_a_coefficient_of_its_own(monkeypatch):
    """If each flight had a drag of its own, none would be told with that."""
    drags = {"a": 0.05, "b": 0.1, "c": 0.2}
    flights = [made(f, c=c, unit=u) for f, c in drags.items() for u in (1, 2)]
    monkeypatch.setattr(real_velocity, "all_flown", lambda: flights)
    for told in real_velocity.all_told():
        others = [c for f, c in drags.items() if f != told.one.flight]
        assert min(others) < told.c < max(others)
        assert told.c == pytest.approx(np.mean(others))


def test_attitude_of_gravity_and_north_is_the_attitude():
    R = so3.exp(np.array((0.3, -0.4, 2.0)))
    field = R.T @ np.array((0.0, 0.42, -0.91))
    np.testing.assert_allclose(real_attitude.attitude_of(R.T @ [0, 0, 9.81], field), R, atol=1e-12)


def test_a_late_stamp_is_seen_as_the_turn_that_was_made_meanwhile():
    t = np.arange(0.0, 2.0, 0.004)
    R = np.array([so3.exp(np.array((0.5 * s, 0.0, 0.0))) for s in t])
    at = t[50:-50]
    seen = real_attitude.Recorded(t, np.zeros((len(t), 3)), np.zeros((len(t), 4)), at, R[40:-60])
    assert real_attitude.errors(seen, R)[0].mean() == pytest.approx(np.rad2deg(0.5 * 0.04))
    assert max(real_attitude.errors(seen, R, 0.04)[1]) < 1e-5


def test_a_real_flight_shows_the_drag_along_the_axis_that_it_excites():
    name = "phantom4-horizontal-8"
    one = flown(read_rtk(recording(name)), read_dot(recording(f"{name}/IMU_1")))
    found = real_drag.fit(one)
    assert found.c[1] == pytest.approx(0.085, abs=0.005)
    assert found.r2[1] > 0.85


@pytest.mark.slow
def test_attitude_stays_with_the_autopilots_own_on_the_real_log():
    recording("px4-sample")
    assert find_experiment("real-px4").outcome().met
