"""Every trigger is reached in a flight by what breaks there, and the flight ends on the ground, slowly."""

from math import radians

import numpy as np
import pytest
from guard import Failing, Guarded, Mistaken

import uavlab
from uavlab.experiments.control_flights import KNOWS, Believes, Knows, law
from uavlab.flight.fault import Fault
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import wrap
from uavlab.gains import gains_for
from uavlab.interfaces import Stack
from uavlab.managers.safety import FAILSAFE, TRIGGERS, Safety
from uavlab.parts.missions import Waypoints
from uavlab.parts.throttle import ThrustCurve
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import Wind, load_airframe
from uavlab.so3 import about_z
from uavlab.solutions.mpc import MpcController
from uavlab.types import Exit

T650 = load_airframe("T650")
M = float(T650.m)
LIMITS = Safety(curve=ThrustCurve(T650.a_t, T650.b_t))
HIGH = 2.0  # [m]
SE3 = law(M, gains_for("T650", "soft"))
pytestmark = pytest.mark.flight


def flight(
    controller=SE3, tracker=None, estimator=None, faults=(), height=HIGH, wind=0.0, seconds=25.0
):
    """A flight under watch, at `height` [m] until something breaks."""
    tracker, estimator = tracker or CommandFilter(), estimator or Believes()
    stay = Waypoints(((0.0, (0.0, 0.0, height), 0.0),))
    scenario = Scenario(
        "watched", "", "T650", stay, standing((0.0, 0.0, height)), seconds, {KNOWS: Knows(0.01, 0.02)},
        wind=Wind(np.array((wind, 0.0, 0.0)), np.full(3, 0.2 * wind)), faults=faults,
    )  # fmt: skip
    pilot = Guarded(tracker, controller, LIMITS, M)
    return uavlab.fly(scenario, Stack(estimator, tracker, controller, pilot=pilot))


def moved_by(x, y=0.0, z=0.0, turn=0.0):
    def change(out, _t):
        turned = {"heading": wrap(out.heading + turn)} if hasattr(out, "heading") else {}
        return out._replace(r=out.r + np.array((x, y, z)), **turned)

    return change


def turned(estimate, _t):
    Rz = about_z(radians(100.0))
    return estimate._replace(R=Rz @ estimate.R, v=Rz @ estimate.v)


def chatters(command, t):
    """Rates that no aircraft can follow, and back."""
    side = 1.0 if round(t / 0.01) % 2 else -1.0
    return command._replace(omega_d=command.omega_d + side * np.array((6.0, 0.0, 0.0)))


def rolls(command, _t):
    return command._replace(omega_d=np.array((2.0, 0.0, 0.0)))


def nothing(out, _t):
    return out


def tracking(change, **given):
    return {"tracker": Failing(CommandFilter(), "tracker", change, **given)}


def controlling(change, **given):
    return {"controller": Failing(SE3, "controller", change, **given)}


BREAKS = {
    "control error": tracking(moved_by(2.0)),
    "lost": tracking(moved_by(2.0, 2.0)),
    "heading error": tracking(moved_by(0.0, turn=2.0)),
    "tracker": tracking(moved_by(np.nan)),
    "jump": {"estimator": Mistaken(Believes(), moved_by(0.0, 1.45, 0.8))},
    "tilt": {**controlling(rolls), "height": 8.0},
    "tilt error": controlling(chatters),
    "solver": controlling(nothing, counts=True),
    "controller": controlling(lambda x, _t: x._replace(f_d=np.nan)),
    "throttle": {"faults": (Fault("payload", 99.0, value=3.9),), "controller": SE3},
    "state missing": {"faults": (Fault("nan", 2.0),)},
    "unreliable": {
        "estimator": Mistaken(Believes(), lambda x, _t: x._replace(r=x.r, reliable=False))
    },
    "link": {"faults": (Fault("link", 2.0),)},
}


@pytest.mark.parametrize("trigger", TRIGGERS)
def test_what_breaks_is_seen_and_the_flight_ends_on_the_ground_below_three_metres_per_second(
    trigger,
):
    log = flight(**BREAKS[trigger])
    said = log.meta["events"][0]
    assert said[1:3] == ["safety", trigger]
    assert log.exit is (Exit.FAILSAFE if TRIGGERS[trigger][0] == FAILSAFE else Exit.LANDED), (
        log.reason
    )
    down = np.flatnonzero(log.r[:, 2] < 0.002)[0]
    assert -log.v[down - 1, 2] < 3.0
    assert np.linalg.norm(log.r[-1, :2]) < 15.0
    assert 0.05 < said[0] < 6.0


def test_there_is_a_break_for_every_trigger():
    assert BREAKS.keys() == TRIGGERS.keys()


def test_an_estimator_whose_heading_jumps_is_landed_without_it():
    log = flight(estimator=Mistaken(Believes(), turned))
    assert log.meta["events"][0][2] == "jump"
    assert log.exit.good


def test_an_emergency_landing_whose_estimate_is_lost_too_ends_in_the_failsafe():
    faults = (Fault("link", 1.0), Fault("nan", 5.5))
    log = flight(faults=faults)
    assert [x[2] for x in log.meta["events"]] == ["link", "state missing"]
    assert log.exit is Exit.FAILSAFE


def test_programmes_that_find_no_plan_are_landed_by_a_law_that_needs_none():
    log = flight(MpcController(M), faults=(Fault("solver", 2.0),))
    assert log.meta["events"][0][2] == "solver"
    assert log.meta["events"][0][0] == pytest.approx(2.5, abs=0.02)
    assert log.exit is Exit.LANDED


def test_a_silent_link_is_landed_in_wind_near_where_it_was():
    log = flight(faults=(Fault("link", 2.0),), wind=5.0)
    assert log.exit is Exit.LANDED
    assert np.linalg.norm(log.r[-1, :2]) < 1.5


@pytest.mark.parametrize("name", ["hover", "takeoff", "step", "circle", "gusts"])
def test_a_flight_in_which_nothing_breaks_is_left_alone(name):
    scenario = uavlab.scenarios.load(name)
    mind = uavlab.stack(scenario.airframe)
    airframe = load_airframe(scenario.airframe)
    limits = Safety(curve=ThrustCurve(airframe.a_t, airframe.b_t))
    pilot = Guarded(mind.tracker, mind.controller, limits, float(airframe.m))
    log = uavlab.fly(scenario, mind._replace(pilot=pilot))
    assert "events" not in log.meta
    assert log.exit is Exit.DONE
