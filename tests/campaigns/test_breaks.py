"""Random faults: all kinds, all of which can happen, none that no aircraft survives by physics alone."""

from collections import Counter

import numpy as np
import pytest

from uavlab.campaigns.breaks import SIZES, fault, label
from uavlab.flight.fault import FIELDS, KINDS, told
from uavlab.flight.scenario import Scenario, checked, standing
from uavlab.parts.missions import Waypoints
from uavlab.plant import load_airframe
from uavlab.sensors import KITS


def drawn(airframe, kit, n=400):
    rng = np.random.default_rng(1)
    aboard = sorted(KITS[kit]())
    return [fault(rng, load_airframe(airframe), aboard, 15.0) for _ in range(n)]


@pytest.mark.parametrize("airframe", ["T650", "F550"])
@pytest.mark.parametrize("kit", ["laboratory", "survey"])
def test_every_fault_that_is_drawn_can_happen_and_every_kind_does(airframe, kit):
    faults = drawn(airframe, kit)
    assert {x.kind for x in faults} == set(KINDS)
    calm = Scenario(
        "x", "", airframe, Waypoints(((0.0, (0, 0, 2), 0.0),)), standing((0, 0, 2)), 20.0, KITS[kit]()
    )  # fmt: skip
    checked(calm._replace(faults=tuple(faults)))
    assert all(0.5 <= x.t <= 15.0 for x in faults)
    stays = np.mean([x.until == np.inf for x in faults if x.kind in {"lost", "link", "nan"}])
    assert stays == pytest.approx(SIZES.stays, abs=0.15)


def test_only_a_hexacopter_loses_a_rotor_and_every_rotor_has_its_turn():
    assert not [x for x in drawn("T650", "survey") if label(list(x)) == "motor dead"]
    weak = [x for x in drawn("F550", "survey") if x.kind == "motor"]
    assert {x.what for x in weak} == set("012345")
    labels = Counter(label(list(x)) for x in weak)
    assert labels["motor dead"] > 5
    assert labels["motor weak"] > 5


@pytest.mark.parametrize("kit", ["laboratory", "survey"])
def test_every_instrument_aboard_can_tell_what_is_wrong(kit):
    for name in KITS[kit]():
        assert any(f"{name}.{field}" in SIZES.errors for field in FIELDS[name])


def test_a_fault_counts_in_the_line_of_its_kind_as_a_log_tells_it():
    faults = told(tuple(drawn("F550", "survey")), 20.0)
    assert {
        "instrument lost", "motor dead", "motor weak", "part estimator nan", "part tracker raises", "link",
    } <= {label(x) for x in faults}  # fmt: skip
