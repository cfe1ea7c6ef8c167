"""Who flies at a pole is stopped by the bumper; who takes the sticks flies, gives back, and can bring it down."""

import numpy as np
import pytest
from flights import at, events, modes

import uavlab
from uavlab.experiments.control_flights import KNOWS, Believes, Knows
from uavlab.flight.scenario import Scenario, standing
from uavlab.limits import limit_group
from uavlab.managers.bumper import Bumper, spaced
from uavlab.orders import Use
from uavlab.parts.errands import Errand
from uavlab.parts.missions import still
from uavlab.plant.obstacles import Obstacle
from uavlab.sensors import Hold, Outage, Receiver, Scanner
from uavlab.types import Exit

pytestmark = pytest.mark.flight
POLE = Obstacle(12.0, 0.3, 0.5, 6.0)
DEAF = Bumper(0.0, 0.0, 0.0)


def flight(sensors, *steps, seconds=20.0, heading=0.0, obstacles=(), **pilot):
    scenario = Scenario(
        "overridden", "", "T650", Errand(steps), standing((0.0, 0.0, 2.0), heading), seconds,
        {KNOWS: Knows(0.01, 0.02), **sensors}, obstacles=obstacles,
    )  # fmt: skip
    return uavlab.fly(scenario, uavlab.piloted(scenario, Believes(), **pilot))


def towards_the_pole(group="medium", **pilot):
    goal = still((24.0, 0.0, 2.0))
    return flight({"sectors": Scanner()}, Use("limits", group), goal, obstacles=(POLE,), **pilot)


def nearest(log):
    """From the middle of the aircraft to the pole [m]."""
    return float((np.hypot(log.r[:, 0] - POLE.x, log.r[:, 1] - POLE.y) - POLE.radius).min())


# The bumper -------------------------------------------------------------------------------------------


def test_without_a_bumper_the_pole_is_hit():
    assert towards_the_pole(bumper=DEAF).exit is Exit.CRASH


@pytest.mark.parametrize("group", ["slow", "medium", "fast"])
def test_an_aircraft_that_flies_at_a_pole_is_stopped(group):
    log = towards_the_pole(group)
    assert log.exit is Exit.DONE, log.reason
    assert "evading" in modes(log)
    assert nearest(log) > 0.33
    kind, name, said = events(log, "bumper")[0]
    assert (kind, name) == ("bumper", "near")
    assert "ahead; bound" in said
    assert not events(log, "safety")


def test_a_distance_that_knows_no_speed_is_too_short_at_four_metres_per_second():
    assert towards_the_pole(bumper=Bumper(a=np.inf, late=0.0)).exit is Exit.CRASH
    flat = limit_group("medium").horizontal
    log = towards_the_pole(bumper=spaced(flat.v, flat.a))
    assert log.exit is Exit.DONE
    assert nearest(log) > 1.5


def test_a_pole_that_is_passed_at_a_distance_bumps_nobody():
    aside = Obstacle(10.0, 7.0, 0.5, 6.0)
    log = flight({"sectors": Scanner()}, still((20.0, 0.0, 2.0)), obstacles=(aside,))
    assert not events(log, "bumper")
    np.testing.assert_allclose(log.r[-1], (20.0, 0.0, 2.0), atol=0.1)


# The remote control -----------------------------------------------------------------------------------

HOLDS = (
    Hold(3.0, True, (1.0, 0.0, 0.0)),
    Hold(6.0, True),
    Hold(8.0, True, (0.0, 0.0, 0.5), 1.0),
    Hold(11.0),
)


def sticks(*holds, **fields):
    return {"remote": Receiver(holds=holds, **fields)}


def test_somebody_takes_over_flies_along_the_nose_stops_climbs_turns_and_gives_back():
    log = flight(sticks(*HOLDS), still((0.0, 0.0, 2.0), 0.8), heading=0.8)
    assert modes(log) == ["flying", "manual", "flying"]
    assert at(log, "mode", "manual") == pytest.approx(3.02, abs=0.02)

    def then(t):
        return round(t / 0.01)

    nose = np.array((np.cos(0.8), np.sin(0.8), 0.0))
    np.testing.assert_allclose(log.v[then(5.5)], nose, atol=0.15)
    np.testing.assert_allclose(log.v[then(7.8)], 0.0, atol=0.1)
    stood = log.r[then(7.8)]
    assert stood @ nose == pytest.approx(3.0, abs=0.6)
    assert log.v[then(10.5), 2] == pytest.approx(0.5, abs=0.1)
    np.testing.assert_allclose(log.r[then(10.5), :2], stood[:2], atol=0.15)
    turned = np.arctan2(log.R[then(10.9), 1, 0], log.R[then(10.9), 0, 0])
    assert 0.8 + 0.3 < turned < 0.8 + 0.2 * 3.0
    assert log.exit is Exit.DONE
    assert not events(log, "safety")


def test_sticks_that_fall_silent_give_back_and_the_aircraft_stands():
    log = flight(
        sticks(Hold(2.0, True, (1.0, 0.0, 0.0)), outages=(Outage(4.0, 99.0),)), still((0.0, 0.0, 2.0)),
        seconds=10.0,
    )  # fmt: skip
    assert [said for _, _, said in events(log, "remote")][-1].endswith("silent for 1 s")
    assert at(log, "mode", "flying") == 0.0
    np.testing.assert_allclose(log.v[-1], 0.0, atol=0.1)


def test_the_failsafe_switch_hovers_lands_and_then_falls():
    log = flight(sticks(Hold(3.0, failsafe=True)), still((4.0, 0.0, 2.0)), seconds=30.0)
    assert modes(log) == ["flying", "manual", "emergency", "failsafe"]
    assert at(log, "mode", "emergency") == pytest.approx(at(log, "mode", "manual") + 2.0)
    assert at(log, "mode", "failsafe") == pytest.approx(at(log, "mode", "emergency") + 2.0)
    assert log.exit is Exit.FAILSAFE, log.reason


def test_a_switch_that_is_let_go_in_the_emergency_lets_it_land():
    log = flight(sticks(Hold(3.0, failsafe=True), Hold(5.5)), still((4.0, 0.0, 2.0)))
    assert modes(log) == ["flying", "manual", "emergency", "landed"]
    assert log.exit is Exit.LANDED
