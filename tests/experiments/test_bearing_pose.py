"""A pose from four bearings: exact without noise, refused when it cannot be, and good enough to fly on."""

import numpy as np
import pytest

from uavlab import so3
from uavlab.errors import BadInput
from uavlab.experiments import bearing_pose
from uavlab.experiments.answers import answer
from uavlab.experiments.homography import homography, pose_from_bearings, pose_from_homography
from uavlab.frames import Shift, moved
from uavlab.parts.beacons import BeaconEstimator
from uavlab.sensors.bearings import SQUARE
from uavlab.types import Bearings, Command, Estimate, Imu

IDLE = Command(15.0, np.zeros(3), np.zeros(3))


def seen(R, r, beacons=SQUARE):
    b = (beacons - r) @ R
    return b / np.linalg.norm(b, axis=1, keepdims=True)


def estimator():
    names = ("attitude_step", "position_observer_step")
    return BeaconEstimator(
        lambda b: pose_from_bearings(b, SQUARE), **{n: answer("complementary", n) for n in names}
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_pose_is_found_again_from_its_bearings(seed):
    rng = np.random.default_rng(seed)
    R = so3.exp(rng.normal(0.0, 0.4, 3)) @ so3.about_z(rng.uniform(-3, 3))
    r = np.array((0.0, 0.0, 1.6)) + rng.uniform(-0.5, 0.5, 3)
    found = pose_from_bearings(seen(R, r), SQUARE)
    np.testing.assert_allclose(found[0], R, atol=1e-9)
    np.testing.assert_allclose(found[1], r, atol=1e-9)


def test_the_matrix_maps_the_beacons_into_the_body_by_their_true_distances():
    """H = R_BW + t nᵀ/d with t = −R_BW r (errata), not as printed; X_2 = H X_1 in metres."""
    R, r = so3.exp(np.array((0.2, -0.1, 0.7))), np.array((0.3, -0.2, 1.6))
    n, d = np.array((0.0, 0.0, 1.0)), 0.1
    H = homography(seen(R, r), SQUARE, n, d)
    np.testing.assert_allclose(SQUARE @ H.T, (SQUARE - r) @ R, atol=1e-9)
    np.testing.assert_allclose(H, R.T - np.outer(R.T @ r, n) / d, atol=1e-8)


def test_a_plane_that_leans_serves_as_well():
    n = so3.exp(np.array((0.3, 0.2, 0.0)))[:, 2]
    flat = so3.exp(np.array((0.3, 0.2, 0.0)))
    beacons = (SQUARE - [0, 0, 0.1]) @ flat.T + 0.4 * n
    R, r = so3.exp(np.array((0.1, 0.3, -1.0))), np.array((0.2, 0.1, 2.0))
    found = pose_from_homography(homography(seen(R, r, beacons), beacons, n, 0.4), n, 0.4)
    np.testing.assert_allclose(found[0], R, atol=1e-9)
    np.testing.assert_allclose(found[1], r, atol=1e-9)


def test_a_fifth_beacon_out_of_sight_changes_nothing_and_three_are_too_few():
    R, r = so3.about_z(0.4), np.array((0.1, 0.2, 1.5))
    five = np.vstack((SQUARE, (0.0, 0.5, 0.1)))
    b = seen(R, r, five)
    b[4] = np.nan
    np.testing.assert_allclose(pose_from_bearings(b, five)[1], r, atol=1e-9)
    b[0] = np.nan
    assert pose_from_bearings(b, five) is None


def test_beacons_on_a_line_tell_no_pose():
    line = np.stack((np.linspace(-1, 1, 4), np.zeros(4), np.full(4, 0.1)), axis=1)
    assert pose_from_bearings(seen(np.eye(3), np.array((0.1, 0.2, 1.5)), line), line) is None


def test_a_plane_through_the_origin_is_refused():
    with pytest.raises(BadInput, match="Move the origin"):
        homography(seen(np.eye(3), np.array((0, 0, 1.5))), SQUARE, np.array((0.0, 0.0, 1.0)), 0.0)


def test_raw_poses_err_by_what_the_geometry_says():
    """σ_z of a bearing noise σ on four beacons at elevation θ, to first order: least squares by finite differences."""
    off, turned = bearing_pose.raw_errors(0, 150)
    r, h = np.array((0.0, 0.0, 1.6)), 1e-6
    flat = seen(np.eye(3), r)
    columns = []
    for step in np.eye(6) * h:
        moved_b = seen(so3.exp(step[3:]), r + step[:3])
        columns.append(((moved_b - flat) / h).ravel())
    J = np.array(columns).T
    least = bearing_pose.NOISE * np.sqrt(np.diag(np.linalg.inv(J.T @ J)))
    ours = np.concatenate((off.std(axis=0), np.deg2rad(turned.std(axis=0))))
    assert (ours > 0.85 * least).all()  # no unbiased estimate is better
    assert (ours < 1.6 * least).all()


def test_the_estimator_finds_a_still_aircraft_from_a_wrong_start_and_counts_bad_images():
    part = estimator()
    R, r = so3.about_z(0.3), np.array((0.2, -0.1, 1.6))
    zero = np.zeros(3)
    memory = part.init(Estimate(r + 0.3, zero, zero, R @ so3.exp(np.array((0.2, 0.1, 0.3))), zero))
    for k in range(600):
        readings = {"imu": Imu(k * 0.01, np.array((0.0, 0.0, 9.81)), zero)}
        if k % 3 == 0:
            b = seen(R, r) if k != 150 else np.full((4, 3), np.nan)
            readings["bearings"] = Bearings(k * 0.01, b)
        memory, estimate = part.step(memory, readings, IDLE, 0.01)
    assert memory.rejected == 1
    np.testing.assert_allclose(estimate.r, r, atol=1e-2)
    assert so3.angle(estimate.R, R) < 5e-3


def test_the_estimator_tells_the_same_flight_in_a_moved_world():
    part, shift = estimator(), Shift(np.array((3.0, -2.0, 0.5)), 0.4)
    R, r = so3.about_z(0.3), np.array((0.2, -0.1, 1.6))
    zero = np.zeros(3)
    here = part.init(Estimate(r + 0.1, zero, zero, R, zero))
    there = part.reframe(here, shift)
    for k in range(30):
        readings = {"imu": Imu(k * 0.01, np.array((0.1, 0.0, 9.9)), np.array((0.0, 0.1, 0.2)))}
        if k % 3 == 0:
            readings["bearings"] = Bearings(k * 0.01, seen(R, r))
        here, a = part.step(here, readings, IDLE, 0.01)
        there, b = part.step(there, readings, IDLE, 0.01)
    np.testing.assert_allclose(b.r, moved(a, shift).r, atol=1e-9)
    np.testing.assert_allclose(b.R, moved(a, shift).R, atol=1e-9)


@pytest.mark.flight
def test_an_aircraft_flies_on_bearings_alone():
    log = bearing_pose.flown(1, 6.0)
    assert log.exit.name == "DONE"
    r_error, R_error = bearing_pose.estimate_errors(log)
    assert np.sqrt(np.mean(r_error**2)) < 0.1
    assert np.sqrt(np.mean(R_error**2)) < 3.0
    assert np.linalg.norm(log.r - log.r_d, axis=1).max() < 0.35
