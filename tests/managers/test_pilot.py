"""A whole flight under a safe pilot: up, to a place, with other parts, down, motors off."""

import numpy as np
import pytest
from flights import at, errand, events, finite, flown, modes

from uavlab.flight.fill import REFERENCE
from uavlab.orders import Land, TakeOff, Use
from uavlab.parts.missions import still
from uavlab.types import Exit

pytestmark = pytest.mark.flight


def test_a_pilot_takes_off_flies_to_a_place_with_another_controller_lands_and_switches_off():
    scenario = errand(
        TakeOff(2.0), still((2.0, 1.0, 2.0), 0.5), Use("controller", "MpcController"),
        still((2.0, 2.0, 1.5), 0.5), Land(),
    )  # fmt: skip
    log = flown(scenario)
    assert log.exit is Exit.LANDED, log.reason
    assert modes(log) == ["ground", "taking off", "flying", "landing", "landed"]
    np.testing.assert_allclose(log.r[-1], (2.0, 2.0, 0.0), atol=0.1)
    assert abs(log.f_d[-1]) == 0.0
    assert log.meta["provenance"]["MpcController"] == REFERENCE
    taken = [name for kind, name, said in events(log, "controller") if said == "taken over"]
    assert taken == ["MpcController"]
    assert at(log, "mode", "landed") < at(log, "mode", "landing") + 10.0
    assert finite(log)
