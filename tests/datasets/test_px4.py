"""The PX4 reader, against what gravity, the compass and the autopilot itself say."""

import contextlib

import numpy as np
import pytest
from real_flights import recording

from uavlab.datasets import as_log, read_px4
from uavlab.errors import BadFile


@pytest.fixture(scope="module")
def log():
    return read_px4(recording("px4-sample"))


def at(times, t, stack):
    """A stack of matrices at other times, entry by entry: good enough between samples 12 ms apart."""
    flat = stack.reshape(len(t), -1)
    return np.stack([np.interp(times, t, column) for column in flat.T], axis=1).reshape(
        -1, *stack.shape[1:]
    )


def rate_of_heading(R, omega):
    """η̇ from ḃ₁ = R (ω × e₁), by hand."""
    b1 = R[:, :, 0]
    b1_dot = np.einsum("nij,nj->ni", R, np.cross(omega, [1.0, 0.0, 0.0]))
    return (b1[:, 0] * b1_dot[:, 1] - b1[:, 1] * b1_dot[:, 0]) / (b1[:, 0] ** 2 + b1[:, 1] ** 2)


def test_at_rest_the_specific_force_points_up_in_the_world(log):
    up = np.einsum("nij,nj->ni", at(log.t_imu, log.t, log.R), log.accel).mean(axis=0)
    np.testing.assert_allclose(up, [0, 0, 9.8], atol=0.15)


def test_the_magnetic_field_points_north_and_down_where_px4_was_flown(log):
    east, north, up = np.einsum("nij,nj->ni", at(log.t_mag, log.t, log.R), log.mag).mean(axis=0)
    assert abs(east) < 0.01 < north
    assert up < 0


def test_attitude_is_a_rotation_and_agrees_with_its_quaternion(log):
    from scipy.spatial.transform import Rotation

    assert np.abs(log.R @ log.R.transpose(0, 2, 1) - np.eye(3)).max() < 1e-12
    np.testing.assert_allclose(Rotation.from_quat(log.q[:, [1, 2, 3, 0]]).as_matrix(), log.R, atol=1e-12)  # fmt: skip


def test_heading_of_the_attitude_is_the_heading_that_the_autopilot_logged(log):
    eta = np.unwrap(np.arctan2(log.R[:, 1, 0], log.R[:, 0, 0]))
    off = np.rad2deg(np.interp(log.t_heading, log.t, eta) - log.heading)
    assert abs(off.mean()) < 0.01
    assert np.sqrt(np.mean(off**2)) < 0.06  # the streams are not sampled at the same times


@pytest.mark.parametrize(("source", "worst"), [("logged", 0.1), ("gyro", 0.5)])
def test_heading_rate_of_all_body_rates_integrates_to_the_heading_and_the_third_alone_does_not(
    log, source, worst
):
    moving = (log.t > 2) & (log.t < 7)
    t, R = log.t[moving], log.R[moving]
    gyro = np.stack([np.interp(t, log.t_imu, log.gyro[:, i]) for i in range(3)], axis=1)
    omega = log.omega[moving] if source == "logged" else gyro
    eta = np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0]))

    def drift(rate):
        turned = np.concatenate([[0], np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(t))])
        return np.rad2deg(np.abs(eta - eta[0] - turned).max())

    assert drift(rate_of_heading(R, omega)) < 2 * worst + 0.5
    assert drift(omega[:, 2]) > 3 * drift(rate_of_heading(R, omega))


def test_streams_have_increasing_times_from_the_start_of_the_log(log):
    for t in (log.t, log.t_imu, log.t_mag, log.t_heading, log.t_d, log.t_omega_d):
        assert t[0] > -0.1
        assert (np.diff(t) > 0).all()


def test_a_barometer_that_gave_nothing_is_an_empty_stream(log):
    assert log.t_baro.shape == log.baro.shape == (0,)


def test_as_a_log_it_has_attitude_and_says_that_its_position_is_made_up(log):
    flight = as_log(log)
    np.testing.assert_array_equal(flight.R, log.R)
    assert np.ptp(flight.r, axis=0).max() == 0
    assert np.isnan(flight.v).all()
    assert "position is not known" in flight.meta["note"]


# Bad input -----------------------------------------------------------------------------------------


def test_a_log_that_is_not_there_is_named(tmp_path):
    with pytest.raises(BadFile, match=r"gone\.ulg cannot be read"):
        read_px4(tmp_path / "gone.ulg")


@pytest.mark.parametrize(
    ("content", "why"), [(b"", "is empty"), (b"PK\3\4 zip", "is not a PX4 log")]
)
def test_what_is_no_ulog_is_refused(tmp_path, content, why):
    path = tmp_path / "x.ulg"
    path.write_bytes(content)
    with pytest.raises(BadFile, match=why):
        read_px4(path)


def test_a_log_cut_short_is_refused_and_read_on_request(tmp_path, log):
    whole = recording("px4-sample").read_bytes()
    path = tmp_path / "cut.ulg"
    path.write_bytes(whole[: len(whole) // 2 - 1])
    with pytest.raises(BadFile, match=r"cut short or damaged: after byte \d+ of 2026681"):
        read_px4(path)
    part = read_px4(path, allow_cut=True)
    assert 0 < len(part.t) < len(log.t)
    np.testing.assert_array_equal(part.R, log.R[: len(part.t)])


def test_a_log_without_attitude_names_what_is_missing(tmp_path):
    path = tmp_path / "bare.ulg"
    path.write_bytes(b"ULog\x01\x12\x35\x01" + (7).to_bytes(8, "little") + b"\x28\x00B" + bytes(40))
    with pytest.raises(BadFile, match="no topic 'sensor_combined'"):
        read_px4(path)


@pytest.mark.parametrize("allow_cut", [False, True])
def test_noise_behind_a_right_beginning_is_one_clear_error(tmp_path, allow_cut):
    path = tmp_path / "noise.ulg"
    path.write_bytes(b"ULog\x01\x12\x35\x01" + np.random.default_rng(0).bytes(5000))
    with pytest.raises(BadFile):
        read_px4(path, allow_cut=allow_cut)


@pytest.mark.slow
def test_a_log_with_flipped_bytes_is_read_or_refused_but_never_hangs(tmp_path, log):
    whole = np.frombuffer(recording("px4-sample").read_bytes()[:300_000], dtype=np.uint8)
    rng = np.random.default_rng(1)
    for k in range(10):
        damaged = whole.copy()
        damaged[rng.integers(16, len(whole), 40)] = rng.integers(0, 256, 40)
        path = tmp_path / f"{k}.ulg"
        path.write_bytes(damaged.tobytes())
        with contextlib.suppress(BadFile):
            read_px4(path, allow_cut=True)
