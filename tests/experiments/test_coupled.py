"""Smooth flights obey mechanics, and the reference filters do on a few of them what the experiments say of many."""

import numpy as np
import pytest

from uavlab import so3
from uavlab.experiments import coupled, coupled_starts, coupled_wind, drag_sweep
from uavlab.experiments.coupled_flights import filtered, wandering
from uavlab.experiments.motion import FIELD, PAPER_C, QUIET, Noise, instruments, motion, waves

SILENT = Noise(*(0.0,) * 7)
WIND = np.array((1.5, -2.0, 0.3))


@pytest.fixture(scope="module")
def fast():
    """To 14 m/s, in wind, with both drags."""
    t = np.arange(0.0, 10.0, 0.005)
    path = waves(
        t, np.array((14.0, 8.0, 5.0)), np.array((20.0, 14.0, 11.0)), np.array((0.3, 1.0, 2.0))
    )
    return motion(t, path, 0.5 * t, np.tile(WIND, (len(t), 1)), PAPER_C, 0.006), path  # fmt: skip


def test_velocity_is_the_rate_of_position_and_acceleration_that_of_velocity(fast):
    flown, (r, v, a) = fast
    np.testing.assert_allclose(np.gradient(r, flown.t, axis=0)[1:-1], v[1:-1], atol=1e-3)
    np.testing.assert_allclose(np.gradient(v, flown.t, axis=0)[1:-1], a[1:-1], atol=1e-3)


def test_specific_force_turned_into_the_world_is_acceleration_less_gravity(fast):
    flown, (_, _, a) = fast
    world = np.einsum("nij,nj->ni", flown.R, flown.force)
    np.testing.assert_allclose(world, a + np.array((0, 0, 9.81)), atol=1e-9)


def test_across_the_thrust_there_is_drag_and_nothing_else(fast):
    """Bangura (3) and the drag of the body, by hand from the velocity through the air."""
    flown, _ = fast
    V = np.einsum("nji,nj->ni", flown.R, flown.v - WIND)
    body = 0.006 * np.linalg.norm(V, axis=1, keepdims=True) * V
    lift = flown.force[:, 2] + body[:, 2]
    rotors = -PAPER_C * np.sqrt(lift)[:, None] * V[:, :2]
    np.testing.assert_allclose(flown.force[:, :2], rotors - body[:, :2], atol=1e-8)


def test_rates_carry_each_attitude_to_the_next(fast):
    flown, _ = fast
    for k in (0, 700, 1500):
        ahead = flown.R[k] @ so3.exp(flown.omega[k] * flown.dt)
        np.testing.assert_allclose(ahead, flown.R[k + 1], atol=1e-9)


def test_silent_instruments_tell_the_truth_at_their_rates_and_the_velocity_may_be_off():
    true, rng = wandering(1, 2.0, (1.0, 1.0, 0.5), (7.0, 9.0, 6.0))
    out = list(instruments(true, rng, SILENT._replace(rate=20.0, slow=50.0), off=(0.5, 1.0)))
    fixes = np.array([t for t, x in zip(true.t, out, strict=True) if "gnss" in x])
    np.testing.assert_allclose(np.diff(fixes)[:5], 0.05)
    assert not ((fixes >= 0.5) & (fixes < 1.0)).any()
    np.testing.assert_allclose(out[10]["imu"].accel, true.force[10])
    np.testing.assert_allclose(true.R[10] @ out[10]["magnetometer"].m, FIELD, atol=1e-12)


def test_without_noise_the_filters_stay_with_the_truth():
    true, rng = wandering(3, 4.0, (1.6, 1.6, 1.0), (7.0, 9.0, 6.0))
    flown = filtered(true, rng, SILENT._replace(rate=100.0, slow=100.0))
    assert np.abs(flown.off).max() < 0.05
    assert flown.turned.max() < 0.3


def test_a_steady_wind_is_found_but_for_its_vertical_part():
    """Filter 0 counts height over ground, so Filter 1 takes the air for one that does not rise (errata, after 4)."""
    true, rng = wandering(
        3, 12.0, (1.0, 1.0, 0.5), (7.0, 9.0, 6.0), wind=np.tile(WIND, (600, 1)), rate=50.0
    )
    flown = filtered(true, rng, SILENT._replace(rate=50.0, slow=50.0))
    gap = flown.w - WIND
    assert np.linalg.norm(gap[0]) > 2.0
    assert np.linalg.norm(gap[-1, :2]) < 0.15
    assert gap[-1, 2] == pytest.approx(-WIND[2], abs=0.1)


def test_a_filter_that_is_told_the_wrong_drag_tells_the_wrong_velocity():
    true, rng = wandering(5, 6.0, (1.6, 1.6, 1.0), (7.0, 9.0, 6.0), rate=50.0)
    off = np.abs(filtered(true, rng, SILENT._replace(rate=50.0), c=0.5 * PAPER_C).off[100:]).mean()
    assert off > 0.2


@pytest.mark.slow
def test_low_speed_stays_within_its_band():
    flown = coupled.low_speed(0)
    late = flown.t > 5.0
    assert np.abs(flown.off[late]).mean(axis=0).max() < 0.3
    assert flown.turned[late].mean() < 2.0


def test_the_line_through_a_parabola_lies_between_its_slopes():
    assert 0.02586 < coupled.best_linear() < 0.0794


def test_a_wind_of_known_decay_and_a_step_of_known_size_are_measured():
    from types import SimpleNamespace

    t = np.arange(0.0, 20.0, 0.02)
    w = np.exp(-0.5 * t)[:, None] * WIND
    assert coupled_wind.decay(SimpleNamespace(t=t, w=w), (1.0, 10.0)) == pytest.approx(0.5)
    x = np.where(t[:, None] < 10.0, 0.0, np.array((0.3, 0.4, 0.0)))
    assert coupled_wind.largest_step(x, 0 * x, t, 10.0) == pytest.approx(0.5)


def test_wrong_starts_are_turned_by_up_to_175_degrees_and_the_same_seed_is_the_same_start():
    angles = np.array([coupled_starts.wrong_start(s)[1] for s in range(200)])
    assert angles.max() < np.deg2rad(175.0)
    assert np.rad2deg(angles.max()) > 170.0
    R, angle = coupled_starts.wrong_start(7)
    assert so3.angle(R, np.eye(3)) == pytest.approx(angle)
    np.testing.assert_array_equal(coupled_starts.wrong_start(7)[0], R)


def test_the_passive_filter_forgets_a_wrong_start():
    off = coupled_starts.passive_errors(2)
    assert off[0] > 20.0
    assert off[-20:].mean() < 2.0


@pytest.mark.slow
def test_a_flight_without_velocity_over_ground_keeps_its_velocity_through_the_air():
    flown = coupled_wind.dropped(0, coupled_wind.WIND)
    lost = (flown.t > 16.0) & (flown.t < 30.0)
    assert np.sqrt((flown.off[lost] ** 2).sum(axis=1).mean()) < 0.3
    assert coupled_wind.decay(flown, coupled_wind.SHORT) == pytest.approx(
        coupled_wind.K_W, rel=0.05
    )
    assert coupled_wind.largest_step(flown.V, flown.true.V, flown.t, 30.0) < 0.1
    assert QUIET.accel > 0.0


def test_a_sweep_without_noise_gives_the_drag_that_was_flown():
    c, offset, r2 = drag_sweep.sweep(0, 0.06, gps=0.0, shake=0.0).linear
    assert (c, offset, r2) == pytest.approx((0.06, drag_sweep.OFFSET, 1.0))
    c_2, c_1, _, _ = drag_sweep.sweep(0, 0.06, gps=0.0, shake=0.0).quadratic
    assert c_1 == pytest.approx(0.06)
    assert c_2 == pytest.approx(0.0, abs=1e-9)


def test_a_body_that_drags_shows_in_the_quadratic_part_only():
    c_2, c_1, _, _ = drag_sweep.sweep(0, 0.06, parasitic=0.006, gps=0.0, shake=0.0).quadratic
    assert c_2 == pytest.approx(
        0.006 / np.sqrt(9.81), rel=0.4
    )  # in hover; it leans and so has less a_z
    assert c_1 == pytest.approx(0.06, rel=0.2)


def test_drag_is_found_again_through_comparable_noise():
    fits = np.array([drag_sweep.sweep(s, PAPER_C).linear for s in range(20)])
    assert fits[:, 0].mean() == pytest.approx(PAPER_C, rel=0.05)
    assert 0.3 < fits[:, 2].mean() < 0.6
