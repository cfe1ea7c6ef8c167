"""How wrong the instruments of a full aircraft are, against what their figures say, and where they fall silent."""

from math import pi
from typing import Any

import numpy as np
import pytest
from truth import Seen, at_rest, kept, spread, watch

from uavlab import so3
from uavlab.frames import Shift, heading, inverse, moved, wrap
from uavlab.sensors import (
    Ahrs,
    Barometer,
    BeaconCamera,
    Disturbance,
    FlowCamera,
    Gnss,
    Magnetometer,
    Outage,
    Rangefinder,
    Rtk,
    Slam,
    earth_field,
)

ZERO = np.zeros(3)


def high(z: float = 2.0, turn: tuple[float, float, float] = (0, 0, 0), v: Any = ZERO) -> Any:
    """Standing in the air, turned."""
    R = so3.exp(np.array(turn, dtype=float))
    return lambda t: at_rest(t)._replace(r=np.array((0.3, -0.2, z)), R=R, v=np.asarray(v, float))


def moving(t: float) -> Seen:
    """On a slow turn to somewhere else."""
    return at_rest(t)._replace(r=np.array((t, -2 * t, 1 + t)), R=so3.exp(np.array((0.1, 0.05, t))))


# GNSS and RTK ------------------------------------------------------------------------------------------


def test_a_plain_receiver_can_live_in_a_world_beside_and_says_how_sure_it_is():
    sure = Gnss(noise=ZERO, drift=ZERO, bias=np.array((2.0, -1.0, 0.5)), std=1.2)
    fix = kept(watch(sure, 20))[0]
    np.testing.assert_array_equal(fix.r, (2.0, -1.0, 0.5))
    assert fix.std == 1.2


def test_a_fixed_solution_is_off_by_centimetres_from_its_own_world_metres_away():
    fixes = kept(watch(Rtk(), 2001, dt=0.1))
    r = np.array([x.r for x in fixes])
    assert r.mean(axis=0) == pytest.approx((1.5, -1.0, 0.8), abs=0.003)
    assert r.std(axis=0) == pytest.approx((0.01, 0.01, 0.02), rel=spread(2000))
    assert {x.std for x in fixes} == {0.02}


def test_without_corrections_the_error_is_metres_and_the_std_says_so_until_fixed_again():
    floating = Rtk(delay=0.0, corrections_lost=(Outage(9.95, 11.95),), refix=3.0)
    flights = [kept(watch(floating, 200, seed=s, dt=0.1)) for s in range(60)]
    assert all((x.std == 1.0) == (9.95 < x.t < 14.95) for x in flights[0])
    at = np.array([next(x.r for x in f if x.t > 11.0) for f in flights]) - (1.5, -1.0, 0.8)
    assert at.std(axis=0) == pytest.approx((0.8, 0.8, 1.5), rel=0.3)
    after = np.array([f[-1].r for f in flights]) - (1.5, -1.0, 0.8)
    assert np.abs(after).max() < 0.1


def test_a_silent_receiver_sends_nothing_without_corrections_and_is_else_the_same():
    whole = watch(Rtk(corrections_lost=()), 1000)
    silent = watch(Rtk(corrections_lost=(Outage(3.0, 5.0),), refix=0.0, silent=True), 1000)
    assert not [x for x in kept(silent) if 3.0 <= x.t < 5.0 - 1e-6]
    for a, b in zip(whole, silent, strict=True):
        assert b is None or np.array_equal(a.r, b.r)


# SLAM --------------------------------------------------------------------------------------------------


def test_a_map_without_error_tells_the_true_pose_in_its_own_world():
    world = Shift(np.array((3.0, -4.0, 1.0)), 2.0)
    calm = Slam(noise=0, turn_noise=0, walk=0, heading_walk=0, world=world)
    for pose in kept(watch(calm, 100, see=moving)):
        home, true = moved(pose, inverse(world)), moving(pose.t)
        np.testing.assert_allclose(home.r, true.r, atol=1e-12)
        np.testing.assert_allclose(home.R, true.R, atol=1e-12)


def test_worlds_of_maps_differ_from_switch_on_to_switch_on_as_the_spread_says():
    worlds = [Slam().init(np.random.default_rng(s)).world for s in range(600)]
    assert np.std([w.r for w in worlds], axis=0) == pytest.approx(3.0, rel=0.1)
    assert np.std([w.heading for w in worlds]) == pytest.approx(pi / np.sqrt(3), rel=0.1)


def test_a_map_drifts_like_the_root_of_time_and_a_closed_loop_takes_it_back():
    calm = Slam(noise=0, turn_noise=0, world=Shift(ZERO, 0.0), delay=0.0, rate=10.0)
    seldom = calm._replace(rate=1.0)
    ends = [kept(watch(seldom, 5, seed=s, dt=1.0))[-1] for s in range(300)]
    span = np.sqrt(ends[0].t)
    assert np.std([x.r for x in ends]) == pytest.approx(0.02 * span, rel=spread(900))
    turns = [heading(x.R) for x in ends]
    assert np.std(turns) == pytest.approx(0.001 * span, rel=spread(300))
    closed = watch(calm._replace(closures=(2.0,)), 40, dt=0.1)
    at = next(x for x in closed if x.t >= 2.0)
    np.testing.assert_array_equal(at.r, ZERO)
    assert np.linalg.norm(closed[19].r) > 1e-3


# Optic flow and rangefinder ----------------------------------------------------------------------------


def test_flow_is_the_velocity_along_the_bodys_own_axes():
    calm = FlowCamera(noise=0, noise_per_height=0, drift=0)
    one = kept(watch(calm, 10, see=high(2.0, (0, 0, pi / 2), (1.0, 0.5, 9.0))))[0]
    np.testing.assert_allclose(one.v_B, (0.5, -1.0), atol=1e-12)


@pytest.mark.parametrize("z", [1.0, 6.0])
def test_flow_is_noisier_the_higher_it_flies(z):
    v = [x.v_B for x in kept(watch(FlowCamera(drift=0), 1501, see=high(z), dt=0.02))]
    assert np.std(v, axis=0) == pytest.approx(0.03 + 0.02 * z, rel=spread(1500))


@pytest.mark.parametrize(
    ("sensor", "see", "reads"),
    [
        (FlowCamera(), high(2.0), True),
        (FlowCamera(), high(0.1), False),
        (FlowCamera(), high(8.5), False),
        (FlowCamera(), high(2.0, (0.5, 0, 0)), True),
        (FlowCamera(), high(2.0, (0, -0.55, 0)), False),
        (FlowCamera(dark=(Outage(0.0, 9.0),)), high(2.0), False),
        (Rangefinder(), high(2.0), True),
        (Rangefinder(), high(0.05), False),
        (Rangefinder(), high(36.5), False),
        (Rangefinder(), high(2.0, (0, 0.5, 0)), True),
        (Rangefinder(), high(2.0, (0.4, 0.4, 0)), False),
        (Rangefinder(tilt_max=pi / 2), high(2.0, (pi, 0, 0)), False),
    ],
)
def test_beyond_its_gates_an_instrument_is_silent(sensor, see, reads):
    assert bool(kept(watch(sensor, 20, see=see))) == reads


def test_a_gate_takes_no_chance_from_the_readings_that_follow():
    def hop(t: float) -> Seen:
        return high(50.0 if t < 0.5 else 2.0)(t)

    for sensor in (FlowCamera(), Rangefinder()):
        stayed, hopped = watch(sensor, 100, see=high(2.0)), watch(sensor, 100, see=hop)
        assert repr(stayed[60:]) == repr(hopped[60:])


def test_a_range_runs_along_the_tilted_body_axis_and_is_off_by_its_noise():
    d = [x.d for x in kept(watch(Rangefinder(), 1500, see=high(3.0, (0.4, 0, 0))))]
    assert np.mean(d) == pytest.approx(3.0 / np.cos(0.4), abs=0.002)
    assert np.std(d) == pytest.approx(0.01, rel=spread(1500))


# Magnetometer ------------------------------------------------------------------------------------------

PURE = Magnetometer(noise=0, turn_on=0, drift=0)


def test_the_field_dips_north_and_turns_against_the_aircraft():
    assert np.linalg.norm(earth_field(1.15, 0.3)) == pytest.approx(1.0)
    assert np.arcsin(-earth_field()[2]) == pytest.approx(1.15)
    level = kept(watch(PURE, 1, see=high(2.0, (0, 0, pi / 2))))[0]  # nose to the west
    np.testing.assert_allclose(level.m, (0, -np.cos(1.15), -np.sin(1.15)), atol=1e-12)


def test_hard_iron_stays_within_a_flight_and_noise_is_white():
    loud = Magnetometer(drift=0)
    flights = np.array([[x.m for x in kept(watch(loud, 12, seed=s))] for s in range(200)])
    off = flights.mean(axis=1) - earth_field()
    total = np.hypot(0.02, 0.0083 / np.sqrt(12))
    assert off.std(axis=0) == pytest.approx(total, rel=spread(200))
    noise = np.sqrt(flights.var(axis=1, ddof=1).mean())
    assert noise == pytest.approx(0.0083, rel=spread(200 * 11 * 3))


def test_a_disturbance_is_there_in_its_time_and_near_its_place_only():
    m = np.array((0.0, 0.4, 0.0))
    timed = PURE._replace(disturbances=(Disturbance(m, start=0.095, end=0.195),))
    off = [x.m[1] for x in kept(watch(timed, 30))]
    np.testing.assert_allclose(off, [0.0] * 10 + [0.4] * 10 + [0.0] * 10, atol=1e-12)
    placed = PURE._replace(disturbances=(Disturbance(m, place=ZERO, reach=2.0),))

    def at(x: float) -> float:
        return watch(placed, 1, see=lambda t: at_rest(t)._replace(r=np.array((x, 0, 0))))[0].m[1]

    assert [at(0.0), at(2.0)] == pytest.approx([0.4, 0.2])
    assert at(40.0) / at(20.0) == pytest.approx(1 / 8, rel=0.01)


# Autopilot and barometer -------------------------------------------------------------------------------


def test_the_autopilots_tilt_is_good_to_tenths_of_a_degree_and_its_heading_starts_anywhere():
    first = [watch(Ahrs(noise=0), 1, seed=s, see=high(2.0, (0.2, 0.1, 0.0)))[0] for s in range(500)]
    R = high(2.0, (0.2, 0.1, 0.0))(0.0).R
    dip = np.array([x.R.T @ (0, 0, 1) - R.T @ (0, 0, 1) for x in first])
    assert np.sqrt((dip**2).sum(axis=1).mean()) == pytest.approx(0.005 * np.sqrt(2), rel=0.1)
    turns = [wrap(heading(x.R) - heading(R)) for x in first]
    assert np.std(turns) == pytest.approx(pi / np.sqrt(3), rel=0.1)


def test_the_autopilots_heading_wanders_like_the_root_of_time():
    given = Ahrs(noise=0, tilt=0, heading=0.7, rate=0.2)
    ends = [kept(watch(given, 6, seed=s, dt=5.0))[-1] for s in range(300)]
    assert ends[0].t == 25.0
    off = [heading(x.R) - 0.7 for x in ends]
    assert np.mean(off) == pytest.approx(0.0, abs=0.002)
    assert np.std(off) == pytest.approx(0.01, rel=spread(300))


def test_a_barometer_counts_from_its_ground_in_whole_steps():
    z = [x.z for x in kept(watch(Barometer(ground=1.0, drift=0), 1500, see=high(3.0), dt=0.02))]
    np.testing.assert_allclose(np.array(z) * 10, np.round(np.array(z) * 10), atol=1e-9)
    assert np.mean(z) == pytest.approx(2.0, abs=4 * 0.104 / np.sqrt(1500))
    assert np.std(z) == pytest.approx(np.hypot(0.1, 0.1 / np.sqrt(12)), rel=spread(1500))


def test_a_barometers_drift_is_as_large_as_said_and_slow():
    slow = Barometer(noise=0, resolution=0, rate=0.1)
    z = np.array([[x.z for x in kept(watch(slow, 7, seed=s, dt=10.0))] for s in range(400)])
    assert z[:, 0].std() == pytest.approx(0.5, rel=spread(400))
    alike = np.exp(-60 / 300)
    assert np.corrcoef(z[:, 0], z[:, -1])[0, 1] == pytest.approx(
        alike, abs=4 * (1 - alike**2) / np.sqrt(400)
    )


# Beacons -----------------------------------------------------------------------------------------------


def test_bearings_are_unit_vectors_to_the_beacons_bent_by_their_angle_on_each_axis():
    camera, see = BeaconCamera(), high(1.5, (0.2, -0.1, 0.8))
    b = np.array([x.b for x in kept(watch(camera, 1500, see=see, dt=1 / 30))])
    np.testing.assert_allclose(np.linalg.norm(b, axis=2), 1.0, atol=1e-12)
    true = (camera.beacons - see(0).r) @ see(0).R
    true /= np.linalg.norm(true, axis=1, keepdims=True)
    for k, u in enumerate(true):
        across = np.linalg.svd(u[None])[2][1:]  # two axes at a right angle to u
        assert (b[:, k] @ across.T).std(axis=0) == pytest.approx(np.radians(1.5), rel=spread(1500))


def test_a_beacon_outside_the_picture_is_a_row_of_nan():
    beacons = np.array([(0.3, -0.2, 0.0), (0.3, 5.8, 0.0), (0.3, -0.2, 9.0)])
    narrow = BeaconCamera(beacons=beacons, view=pi / 4, noise=0)
    b = kept(watch(narrow, 5, see=high(2.0)))[0].b
    np.testing.assert_allclose(b[0], (0, 0, -1), atol=1e-12)
    assert np.isnan(b[1:]).all()
