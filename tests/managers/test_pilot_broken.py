"""Parts that are broken when a pilot has to begin anew: nobody is asked who cannot fly."""

import numpy as np
import pytest

import uavlab
from uavlab.flight.fault import Fault
from uavlab.flight.scenario import Scenario, standing
from uavlab.orders import TakeOff
from uavlab.parts.errands import Errand, Wait
from uavlab.parts.missions import still
from uavlab.sensors import laboratory
from uavlab.types import Exit


@pytest.mark.flight
def test_who_fell_lands_when_the_estimate_is_back_though_the_first_controller_is_broken():
    faults = (Fault("nan", 1.0, 3.0), Fault("part", 1.5, 30.0, "controller", "raises"))
    mission = Errand((still(np.array((0.0, 0.0, 3.0))), Wait(30.0)))
    start = standing((0.0, 0.0, 3.0))
    scenario = Scenario("back", "", "X500", mission, start, 20.0, laboratory(), faults=faults)
    log = uavlab.fly(scenario, uavlab.piloted(scenario))
    assert log.exit is Exit.LANDED, log.reason
    modes = [name for _, kind, name, _ in log.meta["events"] if kind == "mode"]
    assert modes == ["flying", "failsafe", "emergency", "landed"]


@pytest.mark.flight
def test_a_take_off_under_a_controller_that_cannot_begin_is_refused_with_what_it_raised():
    faults = (Fault("part", 0.1, 30.0, "controller", "raises"),)
    mission = Errand((Wait(0.5), TakeOff(2.0), Wait(30.0)))
    start = standing((0.0, 0.0, 0.0))
    scenario = Scenario("no", "", "X500", mission, start, 3.0, laboratory(), faults=faults)
    log = uavlab.fly(scenario, uavlab.piloted(scenario))
    assert log.exit is Exit.DONE, log.reason
    assert log.r[:, 2].max() == 0.0
    said, *_ = [said for _, kind, name, said in log.meta["events"] if kind == "refused"]
    assert "cannot begin: RuntimeError" in said
