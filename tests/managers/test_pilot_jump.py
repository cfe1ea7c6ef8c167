"""An estimate that jumps: an emergency landing begins where the estimate is, at the speed that was flown."""

import numpy as np
import pytest

import uavlab
from uavlab.flight.fault import Fault
from uavlab.flight.scenario import Scenario, standing
from uavlab.parts.errands import Errand, Wait
from uavlab.parts.missions import still
from uavlab.sensors import laboratory
from uavlab.types import Exit


@pytest.mark.slow
@pytest.mark.flight
@pytest.mark.parametrize("by", [1.8, 5.0])
def test_a_jump_of_the_cameras_ends_in_a_landing_near_where_it_was(by):
    # The estimator takes such a jump for a velocity of 15 m/s: a reference that began with it would run away.
    mission = Errand((still(np.array((0.0, 0.0, 3.0))), Wait(20.0)))
    start = standing((0.0, 0.0, 3.0))
    jump = Fault("jump", 3.0, 40.0, "mocap", (by, 0.0, 0.0))
    scenario = Scenario("jump", "", "F450", mission, start, 20.0, laboratory(), faults=(jump,))
    log = uavlab.fly(scenario, uavlab.piloted(scenario))
    assert log.exit is Exit.LANDED, log.reason
    assert (
        np.linalg.norm(log.r[:, :2], axis=1).max() < 8.0
    )  # it leans for as long as the velocity is wrong
    assert np.abs(log.r_d[:, 0]).max() < by + 2.0
