"""Every trigger is reached in a flight by what breaks there, and the flight ends on the ground, slowly."""

from math import radians

import numpy as np
import pytest
from failing import Failing, Mistaken
from flights import at, events, modes

import uavlab
from uavlab.experiments.control_flights import KNOWS, Believes, Knows, law
from uavlab.flight.fault import Fault
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import wrap
from uavlab.gains import gains_for
from uavlab.managers.safety import FAILSAFE, TRIGGERS
from uavlab.parts.missions import Waypoints
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import Wind, load_airframe
from uavlab.so3 import about_z
from uavlab.solutions.mpc import MpcController
from uavlab.types import Exit

T650 = load_airframe("T650")
M = float(T650.m)
HIGH = 2.0  # [m]
SE3 = law(M, gains_for("T650", "soft"))
pytestmark = pytest.mark.flight


def flight(
    controller=SE3, tracker=None, estimator=None, faults=(), height=HIGH, wind=0.0, seconds=25.0
):
    """A flight under watch, at `height` [m] until something breaks."""
    stay = Waypoints(((0.0, (0.0, 0.0, height), 0.0),))
    scenario = Scenario(
        "watched", "", "T650", stay, standing((0.0, 0.0, height)), seconds, {KNOWS: Knows(0.01, 0.02)},
        wind=Wind(np.array((wind, 0.0, 0.0)), np.full(3, 0.2 * wind)), faults=faults,
    )  # fmt: skip
    parts = (estimator or Believes(), tracker or CommandFilter(), controller)
    return uavlab.fly(scenario, uavlab.piloted(scenario, *parts))


def triggers(log):
    return [name for _, name, _ in events(log, "safety")]


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
    assert triggers(log) == [trigger]
    assert modes(log)[1] == TRIGGERS[trigger][0]
    assert log.exit is (Exit.FAILSAFE if TRIGGERS[trigger][0] == FAILSAFE else Exit.LANDED), (
        log.reason
    )
    down = np.flatnonzero(log.r[:, 2] < 0.002)[0]
    assert -log.v[down - 1, 2] < 3.0
    assert np.linalg.norm(log.r[-1, :2]) < 4.0


def test_there_is_a_break_for_every_trigger():
    assert BREAKS.keys() == TRIGGERS.keys()


def test_an_estimator_whose_heading_jumps_is_landed_without_it():
    log = flight(estimator=Mistaken(Believes(), turned))
    assert triggers(log) == ["jump"]
    assert log.exit is Exit.LANDED


def test_an_emergency_landing_whose_estimate_is_lost_too_ends_in_the_failsafe():
    faults = (Fault("link", 1.0), Fault("nan", 5.5))
    log = flight(faults=faults)
    assert triggers(log) == ["link", "state missing"]
    assert log.exit is Exit.FAILSAFE


def test_programmes_that_find_no_plan_are_landed_by_a_law_that_needs_none():
    log = flight(MpcController(M), faults=(Fault("solver", 2.0),))
    assert triggers(log) == ["solver"]
    assert at(log, "safety", "solver") == pytest.approx(2.5, abs=0.02)
    assert log.exit is Exit.LANDED


def test_a_silent_link_is_landed_in_wind_near_where_it_was():
    log = flight(faults=(Fault("link", 2.0),), wind=5.0)
    assert log.exit is Exit.LANDED
    assert np.linalg.norm(log.r[-1, :2]) < 1.5


@pytest.mark.parametrize("name", ["hover", "step", "circle", "gusts"])
def test_a_flight_in_which_nothing_breaks_is_left_alone(name):
    scenario = uavlab.scenarios.load(name)
    log = uavlab.fly(scenario, uavlab.piloted(scenario))
    assert triggers(log) == []
    assert log.exit is Exit.DONE
