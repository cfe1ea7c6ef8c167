"""Clock, axes and heading of an inertial unit, found again in flights where they are known."""

import numpy as np
import pytest
from real_flights import recording
from scipy.spatial.transform import Rotation

from uavlab import so3
from uavlab.datasets import read_dot, read_rtk
from uavlab.datasets.alignment import align, averaged, rates_of_attitudes
from uavlab.datasets.phantom import DotImu, RtkTrack
from uavlab.errors import BadInput

M = so3.exp(np.array((0.05, -0.12, 0.6)))  # case → body
LAG, HEADING = 0.73, -2.1


def attitude(t, wobble=0.35):
    """A smooth attitude in time, by scipy: tilts of some twenty degrees, and a slow turn."""
    w = np.stack(
        (wobble * np.sin(1.9 * t), wobble * np.sin(1.3 * t + 1.0), 0.4 * np.sin(0.4 * t)), axis=1
    )
    return Rotation.from_rotvec(w)


def made(lag=LAG, heading=HEADING, mounting=M, noise=0.0, bias=0.0, wobble=0.35):
    """A track and an inertial unit of one made-up flight, and the truth about them."""
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 25.0, 0.1)
    R = attitude(t, wobble).as_matrix()
    track = RtkTrack(t, np.zeros((len(t), 3)), R, np.zeros(len(t)), np.zeros(len(t)), np.zeros(len(t)), {})  # fmt: skip
    t_imu = np.arange(0.0, 25.0, 1 / 120)
    h = 1e-4
    there = attitude(t_imu + lag, wobble)
    before, after = (attitude(t_imu + lag + s, wobble) for s in (-h, h))
    rates = (before.inv() * after).as_rotvec() / (2 * h)
    gyro = rates @ mounting + bias + noise * rng.standard_normal(rates.shape)
    own = so3.about_z(-heading) @ there.as_matrix() @ mounting
    accel = 9.81 * own[:, 2]
    return track, DotImu(t_imu, accel, gyro, own, {})


@pytest.mark.parametrize(("lag", "heading"), [(-1.4, -2.1), (0.0, 3.1), (0.73, 0.0)])
def test_clock_axes_and_heading_are_found_again(lag, heading):
    found = align(*made(lag=lag, heading=heading))
    assert found.lag == pytest.approx(lag, abs=0.01)
    assert so3.angle(found.M, M) < np.deg2rad(0.3)
    assert np.cos(found.heading - heading) > np.cos(np.deg2rad(0.5))
    assert found.left < 0.05


def test_a_biased_and_noisy_gyro_is_aligned_all_the_same():
    found = align(*made(noise=0.05, bias=0.03))
    assert found.lag == pytest.approx(LAG, abs=0.02)
    assert so3.angle(found.M, M) < np.deg2rad(1.0)


@pytest.mark.parametrize("turn", [np.pi / 2, np.pi, -2.5])
def test_a_case_that_sits_crosswise_or_backwards_is_told(turn):
    found = align(*made(mounting=so3.about_z(turn)))
    assert so3.angle(found.M, so3.about_z(turn)) < np.deg2rad(0.3)


def test_a_track_turned_in_the_world_changes_the_heading_and_nothing_else():
    track, imu = made()
    before = align(track, imu)
    after = align(track._replace(R=so3.about_z(0.8) @ track.R), imu)
    assert after.lag == before.lag
    np.testing.assert_allclose(after.M, before.M, atol=1e-9)
    assert np.angle(np.exp(1j * (after.heading - before.heading))) == pytest.approx(0.8)


def test_recordings_of_two_flights_are_refused():
    track, imu = made()
    with pytest.raises(BadInput, match="Are both of the same flight"):
        align(track, imu._replace(gyro=np.random.default_rng(1).standard_normal(imu.gyro.shape)))


def test_an_aircraft_that_turned_about_one_axis_only_is_refused():
    track, imu = made(wobble=0.0)
    with pytest.raises(BadInput, match="rolls and pitches"):
        align(track, imu)


def test_recordings_that_hardly_overlap_are_refused():
    track, imu = made()
    with pytest.raises(BadInput, match="smaller reach"):
        align(track, imu._replace(t=imu.t + 15.0))


def test_rates_of_attitudes_are_those_of_a_steady_turn():
    t, omega = np.arange(0.0, 2.0, 0.1), np.array((0.3, -0.2, 0.9))
    R = Rotation.from_rotvec(t[:, None] * omega).as_matrix()
    at, rates = rates_of_attitudes(t, R)
    np.testing.assert_allclose(at, t[1:-1])
    np.testing.assert_allclose(rates, np.tile(omega, (len(at), 1)), atol=1e-12)


def test_a_mean_over_a_window_is_the_integral_over_it():
    t = np.arange(0.0, 10.0, 0.001)
    x = np.stack((np.sin(t), t), axis=1)
    at = np.array((2.0, 5.5))
    means = averaged(t, x, at, 0.5)
    exact = (np.cos(at - 0.25) - np.cos(at + 0.25)) / 0.5
    np.testing.assert_allclose(means, np.stack((exact, at), axis=1), atol=1e-6)


@pytest.mark.parametrize("unit", [1, 2])
def test_a_real_unit_explains_the_rates_of_its_aircraft(unit):
    name = "phantom4-horizontal-8"
    found = align(read_rtk(recording(name)), read_dot(recording(f"{name}/IMU_{unit}")))
    assert found.left < 0.05
    assert found.lag == pytest.approx(-0.4, abs=0.05)
    assert found.tilt < np.deg2rad(1.0)
    assert so3.angle(found.M, np.eye(3)) < np.deg2rad(4.0)
