"""Flights with everything in the loop: what their logs tell, and what each trigger of the watch leads to."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import uavlab
from uavlab import scenarios
from uavlab.experiments import managed_landings, managed_worlds, safety_triggers, story
from uavlab.experiments.managed_worlds import OFFSET, switched
from uavlab.experiments.safety_triggers import CAUSES, provoked
from uavlab.experiments.story import down, leant, refusals, when
from uavlab.managers.safety import TRIGGERS
from uavlab.types import Exit

N = 1000


def made(z, events=(), tilt=0.0):
    """A log of N ticks of 10 ms with these heights [m], this tilt [rad] and these events."""
    r, v = np.zeros((N, 3)), np.zeros((N, 3))
    r[:, 2], v[:, 0] = z, 0.3
    v[:, 2] = np.gradient(r[:, 2], 0.01)
    c, s = np.cos(tilt), np.sin(tilt)
    R = np.tile(np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c))), (N, 1, 1))
    t = np.arange(N) * 0.01
    return cast("Any", SimpleNamespace(t=t, r=r, v=v, R=R, meta={"dt": 0.01, "events": events}))


# What a log tells -------------------------------------------------------------------------------------


def test_a_landing_is_told_from_the_take_off_before_it():
    t = np.arange(N) * 0.01
    z = np.clip(np.minimum(t - 1.0, 1.5 - 0.5 * (t - 3.0)), 0.0, 1.5)  # stands, climbs, sinks
    end = down(made(z, [[8.5, "touchdown", "landing", "it is light"]]))
    assert end.contact == pytest.approx(6.0, abs=0.02)
    assert end.after == pytest.approx(2.5, abs=0.02)
    assert end.sink == pytest.approx(0.5, rel=0.01)
    assert end.speed == pytest.approx(np.hypot(0.5, 0.3), rel=0.01)
    assert end.height == 0.0


def test_motors_that_go_off_in_the_air_are_told_with_the_height():
    end = down(made(np.full(N, 3.0), [[4.0, "touchdown", "landing", "it is light"]]))
    assert end.height == 3.0
    assert np.isnan(end.contact)


def test_what_never_flew_or_was_never_said_is_no_number():
    end = down(made(np.zeros(N)))
    assert np.isnan((end.contact, end.off, end.height, end.after)).all()
    assert np.isnan(when(made(np.zeros(N)), "safety"))


def test_events_are_found_by_kind_name_and_time():
    log = made(np.zeros(N), [
        [1.0, "limits", "fast", "first"], [2.0, "refused", "Reference", "too far"],
        [5.0, "limits", "slow", "taken over"], [6.0, "limits", "fast", "taken over"],
    ])  # fmt: skip
    assert when(log, "limits") == 1.0
    assert when(log, "limits", "fast", since=2.0) == 6.0
    assert refusals(log) == ["too far"]


def test_the_tilt_is_that_of_the_time_that_is_asked_for():
    assert leant(made(np.zeros(N), tilt=0.1), 1.0, 2.0) == pytest.approx(np.rad2deg(0.1))
    assert np.isnan(leant(made(np.zeros(N)), 20.0, 30.0))


# The watch --------------------------------------------------------------------------------------------


def test_every_trigger_of_the_watch_is_provoked():
    assert {x.trigger for x in CAUSES} == set(TRIGGERS)


@pytest.mark.flight
@pytest.mark.parametrize(
    "cause", [x for x in CAUSES if x.trigger in {"unreliable", "controller"}], ids=lambda x: x.said
)
def test_what_breaks_is_seen_in_time_and_comes_down_as_it_should(cause):
    log = provoked(cause, 1)
    assert (
        cause.soon.low <= when(log, "safety", cause.trigger) - safety_triggers.AT <= cause.soon.high
    )
    assert log.exit is (Exit.FAILSAFE if cause.falls else Exit.LANDED)
    assert down(log).speed < 3.0


# Flights ----------------------------------------------------------------------------------------------


@pytest.mark.flight
@pytest.mark.parametrize("who", [managed_landings.SE3, managed_landings.BOTH])
def test_who_stands_for_two_seconds_is_off_and_nobody_in_the_air_is(who):
    log = managed_landings.there_and_back(who, 3)
    end = down(log)
    assert log.exit is Exit.LANDED
    assert 2.0 < end.after < 3.0
    assert end.height == pytest.approx(0.0, abs=0.01)
    assert np.hypot(*end.at[:2]) < 1.0


@pytest.mark.flight
def test_a_state_that_is_lost_at_two_metres_is_noticed_and_touches_down_slowly():
    log = managed_landings.lost_at_two_metres(2)
    end, lost = down(log), managed_landings.LOST
    assert log.exit is Exit.FAILSAFE
    assert when(log, "safety", "state missing") - lost == pytest.approx(0.09, abs=0.011)
    assert 2.0 < end.contact - lost < 3.0
    assert end.speed < 2.6
    assert leant(log, lost, end.contact - 0.01) < 2.0


@pytest.mark.flight
def test_the_offset_of_a_receiver_moves_reference_and_estimate_and_not_the_aircraft():
    far, near = switched(OFFSET, 0, end=13.0), switched(np.zeros(3), 0, end=13.0)
    assert np.linalg.norm(far.r - near.r, axis=1).max() < 1e-9
    (change,) = managed_worlds.changes(far)
    assert change.jump > 0.5
    assert change.felt < 0.05
    assert when(far, "estimator", "rtk") == pytest.approx(far.t[change.k], abs=0.02)


@pytest.mark.flight
def test_an_errand_refuses_the_tower_and_lands_at_home():
    log = uavlab.fly(scenarios.load("errand"))
    assert log.exit is Exit.LANDED
    assert [x for x in refusals(log) if "tower" in x] == refusals(log)
    assert len(refusals(log)) == 1
    assert np.hypot(*down(log).at[:2]) < 0.3


@pytest.mark.slow
def test_the_way_indoors_ends_where_it_was_asked_to_on_the_map_and_slowly():
    log = uavlab.fly(scenarios.load("outdoor-indoor-managed"), seed=1)
    assert log.exit is Exit.LANDED
    assert np.hypot(*(down(log).at - managed_worlds.LAND_AT)[:2]) < 0.6
    assert when(log, "limits", "slow", story.HIGH) > managed_worlds.DOOR
    assert np.isnan(when(log, "safety"))
