"""The readers of the Phantom 4 flights, against mechanics and against damage."""

import numpy as np
import pytest
from real_flights import recording

from uavlab import datasets
from uavlab.datasets import as_log, read_dot, read_flight, read_rtk
from uavlab.datasets.phantom import DOT_COLUMNS, RTK_COLUMNS
from uavlab.errors import BadFile, UnknownName


@pytest.fixture(scope="module")
def track():
    return read_rtk(recording("phantom4-horizontal-8"))


def test_the_aircraft_accelerates_where_its_thrust_leans(track):
    """Signs of pitch, roll and compass: horizontal acceleration is thrust's lean less drag."""
    v = np.gradient(track.r, track.t, axis=0)
    a = np.gradient(v, track.t, axis=0)
    lean = 9.81 * track.R[:, :2, 2] / track.R[:, 2:, 2]
    calm = np.ones(5) / 5
    for i in range(2):
        push, pull, speed = (np.convolve(x[:, i], calm, "valid") for x in (lean, a, v))
        drag = (speed @ (push - pull)) / (speed @ speed)
        left = pull - push + drag * speed
        assert 0.2 < drag < 1.0
        assert left.std() < 0.35 * pull.std()


def test_speed_is_the_rate_of_the_positions(track):
    v = np.linalg.norm(as_log(track).v, axis=1)
    assert np.corrcoef(v, track.speed)[0, 1] > 0.98


def test_height_is_above_the_take_off(track):
    assert track.r[0, 2] == pytest.approx(10.1)


def test_every_flight_of_the_catalogue_is_read():
    for name in datasets.names():
        data = datasets.about(name)
        path = recording(name)
        reader = {"px4": datasets.read_px4, "rtk": read_rtk, "dot": read_dot}[data.kind]
        assert len(reader(path).t) > 100
        assert data.licence
        assert data.citation


def test_the_inertial_unit_measures_gravity_upwards_in_its_own_world():
    imu = read_dot(recording("phantom4-horizontal-8/IMU_1"))
    up = np.einsum("nij,nj->ni", imu.R, imu.accel).mean(axis=0)
    np.testing.assert_allclose(up, [0, 0, 9.8], atol=0.2)


def test_the_inertial_units_angles_turn_as_its_gyro_says():
    from scipy.spatial.transform import Rotation

    imu = read_dot(recording("phantom4-horizontal-8/IMU_1"))
    R = Rotation.from_matrix(imu.R)
    turned = (R[:-1].inv() * R[1:]).as_rotvec()[:, 0] / np.diff(imu.t)
    assert np.corrcoef(turned, imu.gyro[:-1, 0])[0, 1] > 0.99


# By name, by path ------------------------------------------------------------------------------------


def test_a_flight_is_found_by_name_and_by_path():
    path = recording("phantom4-line-1")
    by_name, by_path = read_flight("phantom4-line-1"), read_flight(path)
    np.testing.assert_array_equal(by_name.r, by_path.r)
    assert by_name.meta["licence"] == "CC BY 4.0"


def test_a_misspelt_dataset_gets_a_suggestion():
    with pytest.raises(UnknownName, match="Did you mean 'px4-sample'"):
        read_flight("px4-sampel")


def test_an_inertial_unit_alone_cannot_be_replayed():
    with pytest.raises(BadFile, match=r"GT\.csv beside it"):
        read_flight(recording("phantom4-line-1/IMU_1"))


# Bad input -----------------------------------------------------------------------------------------

HEAD = ",".join(RTK_COLUMNS)
ROW = "0.0,1,1,200,1,1,10,0,0,0"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "is empty"),
        (HEAD + "\n", "no rows"),
        ("a,b,c\n1,2,3\n", "has the columns a, b, c"),
        (",".join(DOT_COLUMNS) + "\n", "needed are: time, distance"),
        (f"{HEAD}\n{ROW}\n0.1,1,1,20", "line 3 has 4 of 10 numbers"),
        (f"{HEAD}\n{ROW}\n0.1,1,1,x,1,1,10,0,0,0\n", "line 3: could not convert"),
        (f"{HEAD}\n{ROW}\n0.1,1,1,nan,1,1,10,0,0,0\n", "line 3 has a value that is not finite"),
        (f"{HEAD}\n{ROW}\n{ROW}\n", "time does not increase from line 2"),
    ],
)
def test_a_damaged_table_is_refused_with_what_and_where(tmp_path, text, why):
    path = tmp_path / "GT.csv"
    path.write_text(text)
    with pytest.raises(BadFile, match=why):
        read_rtk(path)


def test_bytes_that_are_no_text_are_refused(tmp_path):
    path = tmp_path / "GT.csv"
    path.write_bytes(bytes(range(128, 256)))
    with pytest.raises(BadFile, match="cannot be read as a table"):
        read_rtk(path)


def test_a_kind_that_nobody_reads_is_refused_with_what_is_read(tmp_path):
    path = tmp_path / "flight.mp4"
    path.write_bytes(b"x")
    with pytest.raises(BadFile, match=r"a PX4 \.ulg, or a GT\.csv"):
        read_flight(path)
