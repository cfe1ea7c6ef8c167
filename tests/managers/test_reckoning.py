"""How fast an aircraft is while nobody measures it; and what a pilot does with that."""

import numpy as np
import pytest
from flights import AIRFRAME, flown, modes
from ghost import DT, ZERO, Ghost, believing

from uavlab.area import Area
from uavlab.flight.fault import Fault
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import Shift, moved
from uavlab.managers.reckoning import FAR, TRUST, Reckoned, begun, reckoned, reframed
from uavlab.managers.rescue import CLIMBS, DROPS, MOST, _eased, believed
from uavlab.orders import EmergencyLand, LandThere, Velocity
from uavlab.parts.errands import Errand, Wait
from uavlab.parts.missions import still
from uavlab.plant.wind import low_altitude
from uavlab.sensors import laboratory
from uavlab.so3 import about_z, exp
from uavlab.types import GRAVITY, Exit, Imu

OFFSET = np.array((0.3, -0.2, 0.25))  # [m/s²] of the accelerometer
G = np.array((0.0, 0.0, GRAVITY))
TURN = Shift(np.array((3.0, -2.0, 0.5)), 0.7)


def flight(seconds, known, read=True, offset=OFFSET):
    """Tilted and accelerated by what varies; `known` says when there is an estimate. True and reckoned velocity."""
    m, v, t = begun(ZERO), ZERO, 0.0
    rows = []
    while t < seconds:
        R = about_z(0.3 * t) @ exp(np.array((0.2 * np.sin(t), 0.15 * np.cos(0.7 * t), 0.0)))
        a = np.array((np.sin(1.3 * t), np.cos(0.9 * t), 0.5 * np.sin(2.0 * t)))
        v = v + a * DT
        imu = {"imu": Imu(t, R.T @ (a + G) + offset, ZERO)} if read else {}
        estimate = believing(v=v)
        m = reckoned(m, estimate, known(t), R, imu, DT)
        t += DT
        rows.append((v, m))
    return rows


def test_an_offset_that_was_learned_lets_a_velocity_last():
    (v, m) = flight(20.0, lambda t: t < 12.0)[-1]
    np.testing.assert_allclose(m.offset, OFFSET, atol=0.03)
    assert np.linalg.norm(m.v - v) < 0.3
    assert m.age == pytest.approx(8.0, abs=0.05)
    (v, m) = flight(8.0, lambda t: t < 0.5)[-1]  # half a second teaches little
    assert np.linalg.norm(m.v - v) > 1.0


def test_without_an_accelerometer_it_is_soon_worth_nothing():
    rows = flight(4.0, lambda t: t < 2.0, read=False)
    assert rows[99][1].v == pytest.approx(rows[99][0])
    assert rows[110][1].holds
    assert not rows[-1][1].holds


def test_what_jumps_is_followed_and_teaches_nothing():
    m = Reckoned(ZERO, OFFSET)
    far = believing(v=(FAR + 0.1, 0.0, 0.0))
    after = reckoned(m, far, True, np.eye(3), {"imu": Imu(0.0, G, ZERO)}, DT)
    np.testing.assert_array_equal(after.v, far.v)
    np.testing.assert_array_equal(after.offset, OFFSET)


@pytest.mark.parametrize("good", [True, False])
def test_a_moved_world_reckons_the_same(good):
    R = exp(np.array((0.1, 0.2, 0.3)))
    imu = {"imu": Imu(0.0, np.array((0.4, -0.3, 9.5)), ZERO)}
    m, estimate = Reckoned(np.array((0.5, 0.2, -0.1)), OFFSET), believing(v=(0.6, 0.3, 0.0))
    here = reframed(reckoned(m, estimate, good, R, imu, DT), TURN)
    R_there = about_z(TURN.heading) @ R
    there = reckoned(reframed(m, TURN), moved(estimate, TURN), good, R_there, imu, DT)
    for a, b in zip(here, there, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)


# What a pilot makes of it -----------------------------------------------------------------------------


@pytest.mark.parametrize("belief", [{"reliable": False}, {"r": ZERO * np.nan, "v": ZERO * np.nan}])
def test_a_guess_is_not_flown_but_what_the_accelerometer_says(belief):
    ghost = Ghost().fly(0.5)
    wild = believing((0.3, 0.0, 2.0), (5.0, 0.0, 3.0))._replace(**belief)
    hangs = {"imu": Imu(0.0, G, ZERO)}
    m, x = believed(ghost.memory, wild, hangs, DT)
    np.testing.assert_allclose(x.v, 0.0, atol=1e-3)
    np.testing.assert_allclose(x.r, (0.0, 0.0, 2.0), atol=1e-3)
    assert not x.reliable
    old = m._replace(reckoned=m.reckoned._replace(age=TRUST))
    _, x = believed(old, wild, hangs, DT)  # of two guesses that of the estimator, if it is a number
    expected = wild if np.isfinite(wild.v).all() else old.estimate
    np.testing.assert_array_equal(x.v, expected.v)


def test_a_fall_is_eased_when_it_climbs_or_drops_and_by_no_more_than_that():
    assert _eased(-1.0) == 0.0
    assert _eased(CLIMBS) == _eased(DROPS) == 0.0
    assert _eased(0.7) == pytest.approx(-1.0)
    assert _eased(-3.0) == pytest.approx(1.0)
    assert (_eased(9.0), _eased(-9.0)) == (-MOST, MOST)


def test_who_lands_where_the_fence_holds_it_sinks_there_and_not_outside():
    area = Area(((-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)), 0.0, 3.0)
    start = believing((0.0, 0.5, 2.9), (4.0, 1.0, 3.0))
    ghost = Ghost(start=start, area=area).fly(0.1)
    ghost.fly(12.0, EmergencyLand())
    assert ghost.way()[:, 2].max() <= 3.0
    assert ghost.reference.r[2] < 0.5


class Stuck:
    """A tracker that cannot begin."""

    slot = "tracker"

    def init(self, estimate, last):
        raise RuntimeError("broken")

    def step(self, memory, estimate, goal, dt):
        raise RuntimeError("broken")

    def reframe(self, memory, shift):
        return memory


def test_who_is_to_land_elsewhere_and_cannot_get_there_lands_here():
    ghost = Ghost().fly(0.2, Velocity(np.array((0.5, 0.0, 0.0)))).fly(1.0)
    parts = {
        k: Stuck() if k.startswith("CommandFilter") else x
        for k, x in ghost.pilot.trackers.parts.items()
    }
    slot = ghost.pilot.trackers.__class__(parts, ghost.pilot.trackers.first)
    object.__setattr__(ghost.pilot, "trackers", slot)
    ghost.fly(14.0, LandThere(np.array((5.0, 0.0, 0.0)), 0.0))
    assert ("mode", "landing", "it does not get there") in ghost.said("mode")


def blown(*faults, wind=4.0, seed=1, **more):
    """Hovering in wind on the cameras of a laboratory."""
    mission = Errand((still(np.array((0.0, 0.0, 2.5))), Wait(60.0)))
    air = low_altitude(np.array((wind, 0.0, 0.0)), 5.0)
    scenario = Scenario(
        "blown", "", AIRFRAME, mission, standing((0.0, 0.0, 2.5)), 40.0, laboratory(), wind=air, faults=faults
    )  # fmt: skip
    return flown(scenario, "AlphaBetaGamma", seed=seed)


@pytest.mark.flight
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_who_loses_the_cameras_in_wind_is_not_carried_away(seed):
    log = blown(Fault("lost", 10.0, what="mocap"), seed=seed)
    assert log.exit is Exit.FAILSAFE, log.reason
    assert modes(log)[-1] == "failsafe"
    down = np.flatnonzero(log.r[:, 2] <= 0.0)[0]
    assert np.linalg.norm(log.v[down - 1]) < 2.5
    assert np.hypot(*log.r[down, :2]) < 4.0


@pytest.mark.flight
def test_a_load_that_drops_in_a_fall_does_not_let_it_climb():
    log = blown(Fault("payload", 12.0, value=0.5), Fault("lost", 10.0, what="mocap"), wind=0.0)
    assert log.exit is Exit.FAILSAFE, log.reason
    after = log.t > 12.0
    assert log.r[after, 2].max() < 4.0
