"""How wrong each instrument is: noise, bias and drift, against what their figures say."""

import numpy as np
import pytest
from truth import at_rest, drifting, kept, spread, watch

from uavlab import so3
from uavlab.sensors import Gnss, ImuSensor, Mocap
from uavlab.sensors.drift import drift_step

STEADY = ImuSensor(gyro_walk=0, gyro_turn_on=0, accel_walk=0, accel_turn_on=0)
PERFECT = STEADY._replace(gyro_noise=0, accel_noise=0)


def test_an_imu_at_rest_feels_the_ground_push_up():
    first = watch(PERFECT, 1)[0]
    np.testing.assert_allclose(first.accel, (0, 0, 9.81), atol=1e-12)
    np.testing.assert_allclose(first.gyro, 0, atol=1e-12)


def test_an_imu_in_free_fall_feels_nothing():
    def falling(t: float):
        return at_rest(t)._replace(a=np.array((0, 0, -9.81)), R=so3.exp(np.array((1.0, 2.0, 3.0))))

    assert watch(PERFECT, 1, see=falling)[0].accel == pytest.approx((0, 0, 0), abs=1e-12)


def test_an_imu_reads_specific_force_and_rates_in_the_body():
    for reading in kept(watch(PERFECT, 20, see=drifting)):
        true = drifting(reading.t)
        np.testing.assert_allclose(true.R @ reading.accel - (0, 0, 9.81), true.a, atol=1e-12)
        np.testing.assert_array_equal(reading.gyro, true.omega)


@pytest.mark.parametrize("rate", [100.0, 25.0])
def test_imu_noise_is_its_density_times_the_root_of_the_rate(rate: float):
    readings = kept(watch(STEADY._replace(rate=rate), 4000, dt=1 / rate))
    gyro = np.array([x.gyro for x in readings])
    accel = np.array([x.accel for x in readings])
    assert gyro.std(axis=0) == pytest.approx(1.87e-4 * np.sqrt(rate), rel=spread(4000))
    assert accel.std(axis=0) == pytest.approx(1.86e-3 * np.sqrt(rate), rel=spread(4000))
    assert abs(np.corrcoef(gyro[1:, 0], gyro[:-1, 0])[0, 1]) < 4 / np.sqrt(4000)  # white


def test_imu_offsets_differ_from_switch_on_to_switch_on_and_stay_within_a_flight():
    quiet = ImuSensor(gyro_noise=0, gyro_walk=0, accel_noise=0, accel_walk=0)
    flights = [kept(watch(quiet, 3, seed=s)) for s in range(400)]
    gyro = np.array([[x.gyro for x in f] for f in flights])
    accel = np.array([[x.accel - (0, 0, 9.81) for x in f] for f in flights])
    assert np.ptp(gyro, axis=1).max() == 0.0
    assert gyro[:, 0].std(axis=0) == pytest.approx(0.0087, rel=0.12)
    assert accel[:, 0].std(axis=0) == pytest.approx(0.196, rel=0.12)


def test_imu_bias_wanders_at_first_like_the_root_of_time():
    quiet = ImuSensor(rate=10, gyro_noise=0, gyro_turn_on=0, accel_noise=0, accel_turn_on=0)
    ends = [kept(watch(quiet, 11, seed=s, dt=0.1))[-1] for s in range(150)]
    assert ends[0].t == pytest.approx(1.0)
    assert np.std([x.gyro for x in ends]) == pytest.approx(3.88e-5, rel=spread(450))
    off = [x.accel - (0, 0, 9.81) for x in ends]
    assert np.std(off) == pytest.approx(6e-3, rel=spread(450))


@pytest.mark.parametrize("dt", [0.05, 1.0])
def test_drift_forgets_with_its_time_constant_whatever_the_step(dt: float):
    rng = np.random.default_rng(1)
    tau, sigma = 2.0, 0.7
    walk, x, seen = sigma * np.sqrt(2 / tau), np.zeros(3), []
    for _ in range(20_000):
        x = drift_step(x, tau, walk, dt, rng)
        seen.append(x)
    path = np.array(seen)[1000:]
    assert path.std(axis=0) == pytest.approx(sigma, rel=0.12)
    k = round(2.0 / dt)
    assert (path[k:] * path[:-k]).mean() / sigma**2 == pytest.approx(np.exp(-1), abs=0.08)


def test_a_fix_is_off_by_its_drift_at_switch_on_and_by_its_noise_from_fix_to_fix():
    fixes = [kept(watch(Gnss(), 31, seed=s)) for s in range(300)]
    r = np.array([[x.r for x in f] for f in fixes])
    v = np.array([[x.v for x in f] for f in fixes])
    assert r[:, 0].std(axis=0) == pytest.approx((0.5, 0.5, 1.0), rel=0.12)
    jump = np.diff(r, axis=1).std(axis=(0, 1))
    slow = np.array((0.5, 0.5, 1.0)) * np.sqrt(2 * 0.1 / 60)
    white = np.sqrt(2) * np.array((0.02, 0.02, 0.04))
    assert jump == pytest.approx(np.hypot(slow, white), rel=0.08)
    assert v.std(axis=(0, 1)) == pytest.approx((0.063, 0.063, 0.126), rel=0.08)


def test_cameras_are_off_by_their_noise_and_their_rotations_are_rotations():
    poses = kept(watch(Mocap(), 1501, see=lambda t: drifting(t)._replace(t=t)))
    r = np.array([x.r - drifting(x.t).r for x in poses])
    w = np.array([so3.log(drifting(x.t).R.T @ x.R) for x in poses])
    assert r.std(axis=0) == pytest.approx(0.001, rel=spread(1500))
    assert w.std(axis=0) == pytest.approx(0.002, rel=spread(1500))
    assert max(np.abs(x.R @ x.R.T - np.eye(3)).max() for x in poses) < 1e-12
