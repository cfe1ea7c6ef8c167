"""Faults on purpose: jumps that stay, outliers that are counted, and what cannot be, refused."""

from typing import Any

import numpy as np
import pytest
from truth import at_rest, kept, watch

from uavlab import so3
from uavlab.errors import BadInput, UnknownName
from uavlab.frames import heading
from uavlab.sensors import (
    INSTRUMENTS,
    KITS,
    Ahrs,
    Barometer,
    BeaconCamera,
    Disturbance,
    FlowCamera,
    Gnss,
    ImuSensor,
    Jump,
    Magnetometer,
    Mocap,
    Outage,
    Outliers,
    Rangefinder,
    Rtk,
    Slam,
    carry,
)
from uavlab.types import Shift

SHARED = {"rate", "delay", "dropout", "outages", "jumps", "outliers"}


def high(t: float) -> Any:
    return at_rest(t)._replace(r=np.array((0.0, 0.0, 2.0)))


def read(sensor: Any, ticks: int = 200) -> list:
    return watch(sensor, ticks, see=high)


def changed(before: list, after: list, value: Any) -> np.ndarray:
    """How far each reading moved when a fault was switched on."""
    pairs = zip(kept(before), kept(after), strict=True)
    return np.array([np.atleast_1d(value(b) - value(a)) for a, b in pairs])


NUMBERS = [
    (Gnss(), lambda x: x.r, 3),
    (Rtk(), lambda x: x.r, 3),
    (Mocap(), lambda x: x.r, 3),
    (Slam(world=Shift(np.zeros(3), 0.0)), lambda x: x.r, 3),
    (ImuSensor(), lambda x: x.accel, 3),
    (Magnetometer(), lambda x: x.m, 3),
    (FlowCamera(), lambda x: x.v_B, 2),
    (Barometer(resolution=0.0), lambda x: x.z, 1),
    (Rangefinder(farthest=500.0), lambda x: x.d, 1),
]


@pytest.mark.parametrize(("sensor", "value", "n"), NUMBERS)
def test_a_jump_comes_at_its_time_and_stays_and_jumps_add_up(sensor, value, n):
    by = np.array((1.0, 2.0, 3.0))[:n] if n > 1 else 2.0
    jumps = (Jump(0.5, by), Jump(1.0, by))
    moves = changed(read(sensor), read(sensor._replace(jumps=jumps)), value)
    times = np.array([x.t for x in kept(read(sensor))])
    count = (times > 0.5 - 1e-6).astype(float) + (times > 1.0 - 1e-6)
    np.testing.assert_allclose(moves, count[:, None] * np.atleast_1d(by), atol=1e-12)


@pytest.mark.parametrize(("sensor", "value", "n"), NUMBERS)
def test_outliers_have_their_share_and_size_and_leave_the_others_as_they_were(sensor, value, n):
    sensor = sensor._replace(rate=100.0)
    wild = sensor._replace(outliers=Outliers(0.1, 40.0), dropout=0.0)
    if isinstance(sensor, Rangefinder):  # a distance cannot be negative
        sensor, wild = sensor._replace(bias=100.0), wild._replace(bias=100.0)
    moves = changed(read(sensor, 1000), read(wild, 1000), value)
    size = np.linalg.norm(moves, axis=1)
    assert (size > 0).mean() == pytest.approx(0.1, abs=4 * np.sqrt(0.1 * 0.9 / 1000))
    np.testing.assert_allclose(size[size > 0], 40.0, rtol=1e-9)
    most = 4 * 40.0 / np.sqrt(n * (size > 0).sum())
    assert abs(moves[size > 0].mean(axis=0)).max() < most  # to no side


@pytest.mark.parametrize("sensor", [Mocap(turn_noise=0), Slam(turn_noise=0), Ahrs(noise=0)])
def test_headings_jump_and_rotations_have_outliers(sensor):
    def turned(a: Any, b: Any) -> np.ndarray:
        return np.array([so3.log(y.R @ x.R.T) for x, y in zip(kept(a), kept(b), strict=True)])

    jump = turned(read(sensor), read(sensor._replace(jumps=(Jump(1.0, turn=0.4),))))
    np.testing.assert_allclose(jump[0], 0.0, atol=1e-9)
    np.testing.assert_allclose(jump[-1], (0, 0, 0.4), atol=1e-9)
    wild = turned(read(sensor), read(sensor._replace(outliers=Outliers(0.2, turn=0.3))))
    size = np.linalg.norm(wild, axis=1)
    np.testing.assert_allclose(size[size > 1e-6], 0.3, atol=1e-9)
    assert 0 < (size > 1e-6).sum() < len(size) / 2


def test_a_jump_of_heading_turns_a_map_about_its_own_origin():
    still = Slam(
        noise=0, turn_noise=0, walk=0, heading_walk=0, world=Shift(np.array((2.0, 0, 0)), 0.0)
    )
    pose = kept(read(still._replace(jumps=(Jump(0.0, (1.0, 0.0, 0.0), np.pi / 2),))))[0]
    np.testing.assert_allclose(pose.r, (1.0, 2.0, 2.0), atol=1e-12)
    assert heading(pose.R) == pytest.approx(np.pi / 2)


def test_a_gyro_jumps_by_its_own_figure():
    jump = (Jump(1.0, 0.0, (0.0, 0.0, 0.1)),)
    moves = changed(read(ImuSensor()), read(ImuSensor(jumps=jump)), lambda x: x.gyro)
    np.testing.assert_allclose(moves[-1], (0, 0, 0.1), atol=1e-12)
    assert not moves[0].any()


def test_a_camera_slips_on_its_mount_and_confuses_one_beacon_at_a_time():
    still = BeaconCamera(noise=0, rate=100.0)
    slip = changed(
        read(still), read(still._replace(jumps=(Jump(1.0, turn=(0, 0, 0.2)),))), lambda x: x.b
    )
    assert not slip[0].any()
    assert np.linalg.norm(slip[-1], axis=-1).min() > 0.1
    wild = still._replace(outliers=Outliers(0.2, turn=0.3))
    moves = np.linalg.norm(changed(read(still), read(wild), lambda x: x.b), axis=-1)
    assert set((moves > 1e-6).sum(axis=1)) == {0, 1}
    np.testing.assert_allclose(moves[moves > 1e-6], 2 * np.sin(0.15), atol=1e-9)


def test_cameras_may_drift_and_stand_askew():
    warm = Mocap(noise=0, bias=np.array((0.1, 0, 0)), drift=0.01)
    first = np.array([watch(warm, 2, seed=s)[1].r for s in range(300)])
    assert first.mean(axis=0) == pytest.approx((0.1, 0, 0), abs=0.002)
    assert first.std(axis=0) == pytest.approx(0.01, rel=0.12)


def test_every_instrument_has_every_fault():
    for kind in INSTRUMENTS.values():
        assert set(kind._fields) >= SHARED


@pytest.mark.parametrize(
    ("sensor", "said"),
    [
        (Gnss(outliers=Outliers(1.2, 3.0)), "outliers.probability is 1.2"),
        (Gnss(dropout=0.5, outliers=Outliers(0.6, 3.0)), "1 − dropout"),
        (Gnss(outliers=Outliers(0.1, -3.0)), "outliers.size is -3"),
        (Gnss(outliers=Outliers(0.1, 1.0, 0.3)), "outliers.turn is 0.3"),
        (Gnss(jumps=(Jump(1.0, (1.0, 2.0)),)), "jump at 1 s: by"),
        (Gnss(jumps=(Jump(float("nan"), 1.0),)), "jump is at t = nan"),
        (Barometer(jumps=(Jump(1.0, 1.0, 0.2),)), "turn is 0.2"),
        (Ahrs(jumps=(Jump(1.0, 3.0),)), "by is 3.0"),
        (Gnss(bias=np.array((1.0, np.nan, 0.0))), "bias"),
        (Rtk(corrections_lost=(Outage(5.0, 2.0),)), "corrections_lost from 5.0 to 2.0"),
        (Rtk(refix=-1.0), "refix"),
        (Slam(closures=(5.0, 2.0)), "closures"),
        (Slam(world=Shift(np.array((np.inf, 0, 0)), 0.0)), "world"),
        (FlowCamera(lowest=9.0), "lowest is 9.0 m"),
        (Rangefinder(tilt_max=2.0), "tilt_max is 2.0 rad"),
        (Rangefinder(nearest=-1.0), "nearest"),
        (Magnetometer(field=np.array((0.4, 0, -0.4))), "unit vector"),
        (Magnetometer(disturbances=(Disturbance(np.ones(3), reach=0.0),)), "reach"),
        (Magnetometer(disturbances=(Disturbance(np.ones(2)),)), "m is"),
        (BeaconCamera(beacons=np.zeros((4, 2))), "beacons"),
        (BeaconCamera(axis=np.array((0, 0, -2.0))), "axis"),
        (BeaconCamera(view=4.0), "view"),
        (Ahrs(heading=float("nan")), "heading"),
    ],
)  # fmt: skip
def test_a_fault_that_cannot_be_is_refused_by_name(sensor, said):
    with pytest.raises(BadInput, match=said):
        sensor.init(np.random.default_rng(0))


def test_kits_carry_instruments_under_their_names():
    for make in KITS.values():
        for name, sensor in make().items():
            assert type(sensor) is INSTRUMENTS[name]
    mine = carry("imu", gnss=Gnss(rate=5.0))
    assert mine["gnss"].rate == 5.0
    with pytest.raises(UnknownName, match="barometer"):
        carry("barometr")
