"""What 000-9 and 000-10 measure: the touch of the ground, what was asked for, and a loss that is a loss."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from uavlab.experiments import failsafe_fall, landing_detection
from uavlab.experiments.control_flights import KNOWS, law
from uavlab.experiments.failsafe_fall import LOST, Loses, failsafe, fall, fallen
from uavlab.experiments.landing_detection import NAME, SOON, landing, watched
from uavlab.gains import gains_for
from uavlab.interfaces import standing_command
from uavlab.parts.pace import beginning
from uavlab.types import Attitude, Estimate, Exit

N = 1000


def made(z, masses):
    """A log of N ticks of 10 ms with these heights [m], whose thrust carries these masses [kg]."""
    r, v = np.zeros((N, 3)), np.zeros((N, 3))
    r[:, 2] = z
    v[:, 2] = np.gradient(r[:, 2], 0.01)
    meta = {"airframe": NAME, "dt": 0.01}
    f_d = np.asarray(masses) * 9.81
    return cast("Any", SimpleNamespace(t=np.arange(N) * 0.01, r=r, v=v, f_d=f_d, meta=meta))


def test_contact_is_the_first_touch_and_disarming_two_light_seconds():
    t = np.arange(N) * 0.01
    z = np.maximum(1.5 - 0.5 * t, 0.0)
    x = watched(made(z, np.where(t < 4.0, 3.5, 1.0)))
    assert x.contact == pytest.approx(3.0, abs=0.015)
    assert x.disarm == pytest.approx(5.99)
    assert x.vertical == pytest.approx(0.5, rel=1e-3)
    assert x.light == 0.0


def test_a_flight_that_never_lands_has_no_contact_and_tells_how_light_it_was():
    t = np.arange(N) * 0.01
    x = watched(made(np.full(N, 5.0), np.where((t > 2.0) & (t < 3.0), 1.0, 3.5)))
    assert (x.contact, x.disarm) == (np.inf, np.inf)
    assert x.light == pytest.approx(1.0, abs=0.02)


@pytest.mark.flight
def test_a_landing_in_gusts_is_seen_two_to_three_seconds_after_it():
    x = watched(landing(law(3.5, gains_for(NAME, "soft")), seed=1, end=9.0))
    assert x.log.exit is Exit.DONE
    assert SOON.low <= x.after <= SOON.high
    assert x.light == 0.0


def test_both_controllers_land_and_are_told_the_mass():
    made_by = landing_detection.controllers(3.1)
    assert {make().mass for make in made_by.values()} == {3.1}


# The failsafe -----------------------------------------------------------------------------------------


def test_what_is_lost_is_lost_and_the_attitude_stays():
    zero = np.zeros(3)
    here = Estimate(zero, zero, zero, np.eye(3), zero)
    part, R = Loses(0.02), np.diag((-1.0, -1.0, 1.0))
    readings = cast("Any", {KNOWS: here, "ahrs": Attitude(0.0, R)})
    memory, before = part.step(part.init(here), readings, standing_command(1.0), 0.01)
    _, after = part.step(memory, readings, standing_command(1.0), 0.01)
    assert np.isfinite(before.r).all()
    assert np.isnan(np.concatenate((after.r, after.v, after.a))).all()
    np.testing.assert_array_equal(after.R, R)
    assert beginning(before, None).heading == pytest.approx(np.pi)


@pytest.mark.flight
def test_it_comes_down_from_two_metres_level_and_slower_than_its_feet_bear():
    x = fallen(fall(failsafe(), seed=2))
    assert 2.0 < x.after < 3.0
    assert x.speed < 2.6
    assert x.tilt < 2.0
    assert x.log.exit is Exit.DONE
    assert np.isnan(x.log.r_e[-1]).all()
    assert [told[2:] for told in x.log.meta["swaps"]][1] == ["failsafe", "taken over"]


@pytest.mark.flight
def test_the_mass_that_it_believes_when_it_is_lost_is_the_one_that_it_has_learned():
    assert failsafe_fall.learned_mass(0, 0.5) == pytest.approx(4.0, abs=0.1)


def test_half_of_the_mass_takes_as_long_as_its_throttle_falls():
    part = failsafe()
    t = failsafe_fall.half_after(part)
    assert part.force(t) == pytest.approx(3.5 * 9.81 / 2.0)
    assert part.force(0.0) < 3.5 * 9.81
    assert LOST > 0.0
