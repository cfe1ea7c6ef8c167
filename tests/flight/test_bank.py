"""A bank of filters in closed loop: a switch moves nobody, one filter for everything moves by metres."""

from dataclasses import replace

import numpy as np
import pytest

import uavlab
from uavlab.errors import BadInput, UnknownName
from uavlab.flight.fill import fill
from uavlab.flight.worlds import flown_by, told
from uavlab.parts.bank import BankEstimator, chosen
from uavlab.parts.missions import InWorld, Waypoints
from uavlab.parts.priority import FixedPriority
from uavlab.scenarios.estimation import bank_mind, gnss_to_rtk, naive_mind, through_a_door
from uavlab.sensors import Outage
from uavlab.types import Exit

TWO = chosen("gnss", "rtk")
AT = 120  # tick of the switch


def flown(offset=(1.5, -1.0, 0.8), mind=None, mission=None, seconds=2.4):
    """Hover on GNSS; corrections arrive at 0.7 s, RTK is asked for at 1.2 s."""
    scenario = gnss_to_rtk()
    rtk = scenario.sensors["rtk"]._replace(
        corrections_lost=(Outage(0.0, 0.7),), offset=np.array(offset)
    )
    return uavlab.fly(
        scenario._replace(
            duration=seconds,
            sensors={**scenario.sensors, "rtk": rtk},
            mission=mission or scenario.mission,
            mind=mind or bank_mind(TWO, ((0.0, "gnss"), (0.01 * AT, "rtk"))),
        ),
        seed=3,
    )


@pytest.fixture(scope="module")
def bank():
    return flown()


@pytest.mark.flight
def test_the_mission_gets_the_filter_that_it_asks_for(bank):
    assert [name for _, _, name in flown_by(bank)] == ["", "gnss", "rtk"]
    assert bank.exit is Exit.DONE


@pytest.mark.flight
def test_metres_between_two_receivers_do_not_move_an_aircraft_that_switches(bank):
    level = flown(offset=(0.0, 0.0, 0.0))
    jump = np.linalg.norm(bank.r_d[AT] - bank.r_d[AT - 1])
    assert jump > 0.5
    assert np.linalg.norm(bank.r - level.r, axis=1).max() < 1e-9


@pytest.mark.flight
def test_a_switch_is_no_step_of_the_error_and_hardly_a_kick(bank):
    stayed = flown(mind=bank_mind(TWO, ((0.0, "gnss"),)))
    error = [x.r_e - x.r_d for x in map(told, (bank, stayed))]
    assert np.abs(error[0][AT] - error[1][AT]).max() < 1e-9
    assert np.linalg.norm(bank.r - stayed.r, axis=1)[: AT + 25].max() < 0.02


@pytest.mark.flight
def test_one_filter_that_hears_both_receivers_moves_by_the_metres_between_them():
    far, level = (flown(offset, naive_mind(TWO)) for offset in ((1.5, -1.0, 0.8), (0.0, 0.0, 0.0)))
    away = np.linalg.norm(far.r - level.r, axis=1)
    assert away[:70].max() < 1e-9
    assert away[-1] > 1.0


@pytest.mark.flight
def test_goals_that_are_told_in_the_world_of_a_filter_that_does_not_fly_are_reached_there():
    goal = Waypoints(((0.0, (0.0, 0.0, 3.0), 0.0),))
    log = flown(mission=InWorld(goal, "gnss"), seconds=3.5)
    gnss = log.worlds.r[-1, log.worlds.names.index("gnss")]
    assert flown_by(log)[-1][2] == "rtk"
    assert np.linalg.norm(gnss - (0.0, 0.0, 3.0)) < 0.6
    assert np.linalg.norm(log.r_e[-1] - (0.0, 0.0, 3.0)) > 0.8  # which is elsewhere for RTK


@pytest.mark.flight
def test_behind_the_door_the_map_flies_and_the_mission_hears_nothing_of_it():
    log = uavlab.fly(through_a_door(2.5), seed=1)
    names = [name for _, _, name in flown_by(log)]
    assert log.exit is Exit.DONE
    assert names[-1] in {"slam", "flow+slam"}
    switch = flown_by(log)[-1][0]
    assert 2.5 < switch < 4.2
    k = round(100 * switch)
    assert np.linalg.norm(log.r_d[k] - log.r_d[k - 1]) > 0.5
    back = told(log).r_d
    assert np.linalg.norm(back[k] - back[k - 1]) < 0.1
    assert np.linalg.norm(log.r[-1] - (3.0, 1.0, 2.0)) < 2.0


@pytest.mark.flight
@pytest.mark.parametrize("scenario", [gnss_to_rtk(), through_a_door(3.0)], ids=lambda s: s.name)
def test_the_stand_in_flies_where_the_answers_are_missing(scenario):
    part = fill(BankEstimator, {}, only_mine=True)
    assert part.part == FixedPriority()
    assert set(part.provenance.values()) == {"stand-in"}
    log = uavlab.fly(scenario._replace(duration=7.0), uavlab.stack("F450", part), seed=1)
    assert log.exit is Exit.DONE
    assert np.linalg.norm(told(log).r_e[-1] - log.r[-1]) < 3.0


def test_a_request_for_a_filter_that_is_not_in_the_bank_is_refused_by_name():
    with pytest.raises(UnknownName, match="'rtk'"):
        fill(BankEstimator, setup=TWO, requests=((0.0, "rkt"),))
    with pytest.raises(UnknownName, match="'slam'"):
        chosen("slma")


def test_requests_that_run_backwards_in_time_are_refused():
    with pytest.raises(BadInput, match="times of requests must grow"):
        replace(fill(BankEstimator).part, requests=((2.0, "rtk"), (1.0, "gnss")))
