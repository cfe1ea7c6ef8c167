"""Take-off and landing: when they may begin, where they lead, and when the motors go off."""

import numpy as np
import pytest
from flights import at, errand, events, flown, modes
from ghost import DT, SQUARE, Ghost, believing

from uavlab.area import Area, NoFly
from uavlab.flight.fault import Fault
from uavlab.frames import heading, wrap
from uavlab.orders import Land, LandHome, LandThere, TakeOff, Use
from uavlab.parts.errands import Wait
from uavlab.parts.missions import still
from uavlab.plant import CALM
from uavlab.scenarios import load
from uavlab.types import Exit

THERE = np.array((3.0, -2.0, 99.0))
HIGH = still(np.array((2.0, 2.0, 4.0)), 0.5)


def up(**more):
    ghost = Ghost(ground=True, **more)
    return ghost.fly(9.0, TakeOff(2.0))


# Take-off ---------------------------------------------------------------------------------------------


def test_a_take_off_climbs_straight_up_and_ends_at_its_height():
    ghost = up()
    assert [x[1] for x in ghost.said("mode")] == ["ground", "taking off", "flying"]
    np.testing.assert_allclose(ghost.way()[:, :2], 0.0, atol=1e-9)
    assert ghost.reference.r[2] == pytest.approx(2.0, abs=0.05)
    assert ghost.flies[0] == "CommandFilter medium"


@pytest.mark.parametrize("height", [0.4, 10.5, float("nan"), "high"])
def test_a_take_off_to_a_height_that_is_none_is_refused(height):
    ghost = Ghost(ground=True).fly(0.2, TakeOff(height))
    assert "take 0.5 to 10 m" in ghost.said("refused")[0][2]
    assert ghost.report.mode == "ground"
    assert ghost.command.f_d == 0.0


@pytest.mark.parametrize(
    ("belief", "said"),
    [
        ({"reliable": False}, "no measurement of late"),
        ({"r": np.full(3, np.nan)}, "the estimate is no number"),
    ],
)
def test_nobody_takes_off_on_an_estimate_that_cannot_be_trusted(belief, said):
    ghost = Ghost(ground=True)
    ghost.tick()
    ghost.tick(TakeOff(2.0), **belief)
    assert said in ghost.said("refused")[0][2]
    assert ghost.report.mode == "ground"


def test_a_take_off_out_of_the_area_or_in_the_air_is_refused():
    low = Area(SQUARE.border, 0.5, 1.5)
    ghost = Ghost(ground=True, area=low).fly(0.2, TakeOff(2.0))
    assert "0.5 m above" in ghost.said("refused")[0][2]
    ghost = Ghost().fly(0.2, TakeOff(2.0))
    assert ghost.said("refused")[0][2] == "it is not on the ground, but flying."


def test_an_order_that_is_told_again_while_it_is_obeyed_changes_nothing():
    ghost = Ghost(ground=True).fly(9.0, always=(TakeOff(2.0),))
    assert len(ghost.said("mode")) == 3
    ghost.fly(1.0, always=(Land(),))
    assert [x[1] for x in ghost.said("mode")][3:] == ["landing"]
    assert {x[1] for x in ghost.said("refused")} == {"TakeOff"}  # once it was up


@pytest.mark.flight
def test_a_take_off_in_wind_stays_over_its_place_and_that_of_the_mpc_controller_does_not():
    wind = CALM._replace(mean=np.array((6.0, 0.0, 0.0)))
    scenario = errand(TakeOff(2.0), Wait(2.0), seconds=8.0, wind=wind)
    ours, theirs = (
        np.linalg.norm(flown(scenario, lifts=x).r[:, :2], axis=1).max() for x in ("", "MpcController")
    )  # fmt: skip
    assert ours < 0.8
    assert theirs > 2.0


# Landing ----------------------------------------------------------------------------------------------


def test_who_lands_home_flies_there_and_turns_before_it_sinks():
    ghost = up().fly(12.0, HIGH).fly(12.0, LandHome())
    way = ghost.way()
    sinks = np.flatnonzero(way[:, 2] < 1.9)[-1]
    first = np.flatnonzero((way[:, 2] < 3.8) & (np.arange(len(way)) * DT > 21.0))[0]
    assert np.linalg.norm(way[first, :2]) < 0.1
    assert abs(ghost.references[first].heading) < 0.1
    assert np.linalg.norm(way[sinks, :2]) < 0.1
    assert [x[1] for x in ghost.said("mode")][3:] == ["going home", "landing"]


def test_who_lands_there_goes_by_the_place_and_not_by_its_height():
    ghost = up().fly(25.0, LandThere(THERE, 1.0))
    np.testing.assert_allclose(ghost.reference.r[:2], THERE[:2], atol=0.1)
    assert wrap(ghost.reference.heading - 1.0) == pytest.approx(0.0, abs=0.1)
    assert ghost.report.mode == "landing"


def test_a_place_to_land_at_is_held_against_the_area_and_must_be_a_number():
    zone = NoFly(((2.0, -3.0), (4.0, -3.0), (4.0, -1.0), (2.0, -1.0)), name="pond")
    ghost = up(area=Area(SQUARE.border, 0.5, 8.0, no_fly=(zone,)))
    ghost.fly(0.1, LandThere(THERE, 0.0)).fly(0.1, LandThere(THERE * np.nan, 0.0))
    said = [x[2] for x in ghost.said("refused")]
    assert "no-fly zone 'pond'" in said[0]
    assert "only numbers" in said[1]
    assert ghost.report.mode == "flying"


def test_while_it_lands_goals_and_other_parts_are_refused():
    ghost = (
        up().fly(0.1, Land()).fly(0.1, HIGH).fly(0.1, Use("limits", "slow")).fly(0.1, LandHome())
    )
    assert [x[2] for x in ghost.said("refused")] == ["it is landing"] * 2
    assert ghost.said("limits")[-1][2] == "refused: it is landing"
    ghost = Ghost(ground=True).fly(0.1, Land())
    assert "already" in ghost.said("refused")[0][2]


def test_an_estimate_that_never_comes_near_enough_delays_a_landing_and_does_not_prevent_it():
    ghost = up().fly(0.1, LandHome())
    for _ in range(round(8.0 / DT)):
        ghost.tick(r=ghost.reference.r + np.array((0.5, 0.0, 0.0)))
    assert ghost.report.mode == "landing"


def test_motors_go_off_after_two_seconds_of_hardly_any_thrust_and_stay_off():
    ghost = up().fly(1.0, Land())
    for _ in range(round(12.0 / DT)):  # the ground holds it where it is
        ghost.tick(r=np.array((0.0, 0.0, 2.0)), v=np.zeros(3))
    assert ghost.report.over == "landed"
    assert ghost.report.mode == "landed"
    assert ghost.command.f_d == 0.0
    ghost.fly(0.5, HIGH, TakeOff(2.0))
    assert ghost.command.f_d == 0.0
    assert ghost.report.mode == "landed"


def test_who_starts_in_the_air_flies_hover_thrust_first_and_goes_on_as_it_moves():
    start = believing((1.0, 2.0, 5.0), (1.0, 0.0, 0.0), heading=0.7)
    ghost = Ghost(start=start)
    ghost.tick()
    np.testing.assert_allclose(ghost.reference.r, start.r, atol=1e-12)
    np.testing.assert_allclose(ghost.reference.v, start.v, atol=1e-12)
    assert ghost.reference.heading == pytest.approx(heading(start.R))
    assert ghost.command.f_d == pytest.approx(3.5 * 9.81)
    assert ghost.report.mode == "flying"


@pytest.mark.flight
@pytest.mark.parametrize("airframe", ["F450", "F550", "X500"])
def test_every_aircraft_flies_an_errand_and_lands_where_it_was_told_softly(airframe):
    scenario = errand(
        TakeOff(1.5), still((1.0, 0.0, 2.5)), LandThere(np.array((1.0, 1.5, 0.0)), 0.5),
        airframe=airframe, seconds=60.0,
    )._replace(sensors=load("hover").sensors)  # fmt: skip
    log = flown(scenario, "AlphaBetaGamma")
    assert log.exit is Exit.LANDED, log.reason
    assert modes(log)[-3:] == ["going home", "landing", "landed"]
    np.testing.assert_allclose(log.r[-1, :2], (1.0, 1.5), atol=0.25)
    contact = np.flatnonzero((log.r[:, 2] < 1e-3) & (log.t > at(log, "mode", "landing")))[0]
    assert -log.v[contact - 1, 2] < 1.0
    assert 1.5 < log.t[-1] - log.t[contact] < 5.0
    assert not events(log, "safety", "refused")


@pytest.mark.flight
def test_a_load_that_nobody_told_of_is_lifted_and_landed():
    heavy = (Fault("payload", 999.0, value=0.5),)
    log = flown(errand(TakeOff(2.0), Wait(3.0), Land(), faults=heavy))
    assert log.exit is Exit.LANDED, log.reason
