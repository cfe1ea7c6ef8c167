"""A whole mind with a safe pilot: what is aboard, who wrote it, and that it flies with stand-ins alone."""

import numpy as np
import pytest

import uavlab
from uavlab.area import Area
from uavlab.errors import BadInput, UnknownName
from uavlab.experiments.control_flights import KNOWS, Believes, Knows
from uavlab.flight import fill as filling
from uavlab.flight.fault import Fault
from uavlab.flight.fill import MINE, REFERENCE, STAND_IN, fill
from uavlab.flight.scenario import Scenario, standing
from uavlab.limits import limit_group
from uavlab.managers.safety import Safety
from uavlab.orders import Land, TakeOff, Use
from uavlab.parts.bank import BankEstimator
from uavlab.parts.controllers import TiltAxis
from uavlab.parts.errands import Errand
from uavlab.parts.estimator_slot import EstimatorSlot
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.missions import still
from uavlab.parts.trackers import CommandFilter
from uavlab.parts.vetted import Vetted
from uavlab.solutions.geometric import GeometricController
from uavlab.solutions.mpc import MpcTracker
from uavlab.types import Exit

AREA = Area(((-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)), 0.5, 9.0)


def errand(*steps, **more):
    scenario = Scenario(
        "errand", "", "F450", Errand(steps), standing((0, 0, 0)), 40.0, {KNOWS: Knows()}
    )
    return scenario._replace(**more)


class Mine(GeometricController):
    """A student's own."""


def test_the_names_of_the_parts_tell_their_groups():
    pilot = uavlab.piloted("F450", gains="soft").pilot
    assert list(pilot.controllers.parts) == [
        "GeometricController soft", "GeometricController supersoft", "GeometricController tight",
        "MpcController", "Emergency",
    ]  # fmt: skip
    names = list(pilot.trackers.parts)
    assert names[:2] == ["MpcTracker medium", "MpcTracker medium half"]
    assert {"LineTracker", "LandOff", "LandOff up", "LandOff emergency", "SpeedTracker z slow"} <= {
        *names
    }
    assert pilot.trackers.parts["MpcTracker slow"].limits == limit_group("slow")
    assert list(uavlab.piloted("X500").pilot.controllers.parts)[:2] == [
        "GeometricController supersoft", "GeometricController soft",
    ]  # fmt: skip


def test_scenario_gives_airframe_area_and_estimator():
    there = uavlab.scenarios.load("gnss-to-rtk")._replace(area=AREA)
    mind = uavlab.piloted(there)
    assert isinstance(mind.estimator, BankEstimator)
    assert mind.pilot.area is AREA
    assert mind.pilot.mass == pytest.approx(1.7)
    assert isinstance(uavlab.piloted("F450").estimator, AlphaBetaGamma)
    assert uavlab.piloted("F450", area=AREA).pilot.area is AREA
    assert mind.pilot.safety.curve == mind.pilot.curve
    assert uavlab.piloted("F450", safety=Safety(mute=2.0)).pilot.safety.mute == 2.0


def test_who_is_given_flies_first_and_an_object_flies_as_it_is():
    own = MpcTracker(limit_group("fast"))
    pilot = uavlab.piloted("F450", own, "TiltAxis", Believes()).pilot
    first = pilot.init(uavlab.Estimate(*np.zeros((3, 3)), np.eye(3), np.zeros(3)), False)
    assert (first.tracking.name, first.controlling.name) == ("MpcTracker", "TiltAxis")
    assert pilot.trackers.parts["MpcTracker"] is own
    pilot = uavlab.piloted("F450", CommandFilter).pilot
    assert pilot.trackers.parts["CommandFilter slow"].v_max == 1.0


def test_ones_own_answers_fly_in_all_groups_and_it_is_told_whose_they_are():
    mind = uavlab.piloted("F450", mine={"GeometricController": Mine})
    parts = mind.pilot.controllers.parts
    assert isinstance(parts["GeometricController tight"], Mine)
    assert mind.provenance["GeometricController"] == MINE
    assert mind.provenance["MpcTracker"] == REFERENCE
    assert mind.provenance["LandOff"] == mind.provenance["Emergency"] == "uavlab"
    assert mind.provenance["AlphaBetaGamma"] == STAND_IN


@pytest.mark.parametrize(
    ("given", "more", "said"),
    [
        ((3,), {}, "int has slot None"),
        ((AlphaBetaGamma(), Believes()), {}, "a mind has one"),
        ((TiltAxis(1.7), TiltAxis(1.8)), {}, "two parts are called TiltAxis"),
        ((), {"lifts": "Crane"}, "lifts or lands"),
    ],
)
def test_what_does_not_belong_together_is_refused_by_name(given, more, said):
    with pytest.raises(BadInput, match=said):
        uavlab.piloted("F450", *given, **more)


@pytest.mark.flight
def test_behind_an_estimator_that_lags_the_softest_gains_fly_first_and_do_not_swing():
    scenario = errand(TakeOff(1.5), still((1.0, 0.0, 2.5)), still((1.0, 1.5, 2.0)), airframe="F550")
    scenario = scenario._replace(sensors=uavlab.scenarios.load("hover").sensors, duration=14.0)
    tilts = {}
    for gains in ("", "soft"):
        for estimator in (AlphaBetaGamma(), EstimatorSlot({"eyes": Vetted(AlphaBetaGamma())})):
            mind = uavlab.piloted(scenario, estimator, gains=gains)
            R = uavlab.fly(scenario, mind).R
            tilts[gains] = np.degrees(np.arccos(R[-300:, 2, 2])).max()
    assert tilts[""] < 10.0
    assert tilts["soft"] > 20.0


def test_a_group_of_gains_that_the_airframe_has_not_is_refused():
    with pytest.raises(UnknownName, match="group of gains of X500 named 'tight'"):
        uavlab.piloted("X500", gains="tight")


@pytest.mark.flight
def test_it_flies_with_stand_ins_alone(monkeypatch):
    monkeypatch.setattr(filling, "reference", lambda *_: None)
    scenario = errand(
        TakeOff(1.5), Use("controller", "MpcController"), Use("limits", "slow"), Use("gains", "soft"),
        still((1.5, 0.0, 2.0)), Land(),
    )._replace(sensors=uavlab.scenarios.load("hover").sensors)  # fmt: skip
    mind = uavlab.piloted(scenario)
    theirs = ("MpcTracker", "MpcController", "GeometricController")
    assert {mind.provenance[x] for x in theirs} == {STAND_IN}
    log = uavlab.fly(scenario, mind)
    assert log.exit is Exit.LANDED, log.reason
    assert not [x for x in log.meta["events"] if x[1] in {"safety", "refused"}]


@pytest.mark.flight
def test_the_first_tracker_and_the_first_controller_are_those_that_a_fault_breaks():
    scenario = errand(TakeOff(1.5), still((1.0, 0.0, 1.5)), still((0.0, 0.0, 1.5)), Land())
    scenario = scenario._replace(faults=(Fault("part", 6.0, what="tracker", value="nan"),))
    log = uavlab.fly(scenario, uavlab.piloted(scenario, Believes()))
    [trigger] = [x for x in log.meta["events"] if x[1] == "safety"]
    assert trigger[2] == "tracker"
    assert "MpcTracker medium" in trigger[3]
    assert log.exit is Exit.LANDED


def test_a_mind_can_be_filled_with_what_is_filled_already():
    pilot = uavlab.piloted("F450", fill("TiltAxis", mass=1.7)).pilot
    assert isinstance(pilot.controllers.parts["TiltAxis"], TiltAxis)
