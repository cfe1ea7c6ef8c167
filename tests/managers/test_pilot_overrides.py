"""Who overrides a mission: somebody at the sticks, and the bumper; and when the mission has its way again."""

import numpy as np
import pytest
from flights import KNOWS, Knows, errand, events, finite, flown, modes
from ghost import SQUARE, Ghost, believing

from uavlab.area import Area, NoFly
from uavlab.orders import EmergencyLand, LandHome, Velocity
from uavlab.parts.missions import Waypoints, still
from uavlab.plant.obstacles import Obstacle
from uavlab.sensors import INSTRUMENTS
from uavlab.sensors.remote import Hold
from uavlab.types import Exit, Sectors, Sticks

GOAL = still(np.array((4.0, 0.0, 2.0)))
INF = np.full(8, np.inf)


def sticks(push=(0.0, 0.0, 0.0), turn=0.0, engaged=True, failsafe=False):
    return {"remote": Sticks(0.0, engaged, np.array(push, float), turn, failsafe)}


def near(i=None, d=0.5, up=np.inf, down=np.inf):
    ranges = INF.copy()
    if i is not None:
        ranges[i] = d
    return {"sectors": Sectors(0.0, ranges, down, up)}


# Remote control ---------------------------------------------------------------------------------------


def test_while_somebody_holds_the_sticks_goals_are_not_heard_and_the_sticks_are():
    ghost = Ghost(start=believing(heading=np.pi / 2)).fly(0.5)
    ghost.fly(3.0, always=(GOAL,), readings=sticks((0.5, 0.0, 0.0)))
    assert ghost.report.mode == "manual"
    np.testing.assert_allclose(ghost.reference.v, (0.0, 0.5, 0.0), atol=1e-3)
    assert ghost.said("refused") == [
        ("refused", "Reference", "somebody at the remote control flies")
    ]
    ghost.fly(2.0, readings=sticks((0.0, 0.0, 0.0), turn=1.0))
    assert ghost.reference.heading_rate == pytest.approx(0.2)


def test_who_lets_go_of_the_sticks_hovers_and_who_gives_them_back_too():
    ghost = Ghost().fly(3.0, readings=sticks((1.0, 0.0, 0.0))).fly(4.0, readings=sticks())
    there = ghost.reference.r
    ghost.fly(1.0, readings=sticks())
    assert ghost.report.mode == "manual"
    ghost.fly(2.0, readings=sticks(engaged=False))
    assert ghost.report.mode == "flying"
    np.testing.assert_allclose(ghost.reference.r, there, atol=0.02)
    ghost.fly(10.0, GOAL)
    np.testing.assert_allclose(ghost.reference.r, GOAL.r, atol=0.02)
    assert [x[1] for x in ghost.said("mode")] == ["flying", "manual", "flying"]


def test_sticks_that_are_given_back_in_motion_stop_the_aircraft():
    ghost = Ghost().fly(3.0, readings=sticks((1.0, 0.0, 0.0)))
    ghost.fly(6.0, readings=sticks(engaged=False))
    assert np.linalg.norm(ghost.reference.v) < 0.01


def test_sticks_do_not_fly_out_of_the_area():
    ghost = Ghost(area=SQUARE).fly(20.0, readings=sticks((0.0, 1.0, 0.0)))
    assert ghost.way()[:, 1].max() < 10.0
    assert len(ghost.said("refused")) == 1


def test_the_failsafe_switch_hovers_then_lands_then_falls():
    ghost = Ghost().fly(1.0, GOAL).fly(1.0, always=(GOAL,), readings=sticks(engaged=False, failsafe=True))  # fmt: skip
    assert ghost.report.mode == "manual"
    assert ghost.reference.a[0] < 0.0
    ghost.fly(1.5, readings=sticks(engaged=False, failsafe=True))
    assert ghost.report.mode == "emergency"
    ghost.fly(2.0, readings=sticks(engaged=False, failsafe=True))
    assert ghost.report.mode == "failsafe"
    assert [x[1] for x in ghost.said("safety")] == ["remote", "remote"]


def test_a_failsafe_switch_that_is_off_in_time_gives_back():
    ghost = Ghost().fly(1.0, readings=sticks(engaged=False, failsafe=True))
    ghost.fly(0.5, readings=sticks(engaged=False)).fly(9.0, GOAL)
    assert ghost.report.mode == "flying"
    np.testing.assert_allclose(ghost.reference.r, GOAL.r, atol=0.02)


def test_nobody_takes_over_from_an_emergency_or_on_the_ground():
    ghost = Ghost().fly(0.1, EmergencyLand()).fly(1.0, readings=sticks((1.0, 0.0, 0.0)))
    assert ghost.report.mode == "emergency"
    ghost = Ghost(ground=True).fly(1.0, readings=sticks((1.0, 0.0, 0.0)))
    assert ghost.report.mode == "ground"


# Bumper -----------------------------------------------------------------------------------------------


def test_it_moves_away_from_what_is_near_and_stays_there_while_it_is():
    ghost = Ghost().fly(1.0)
    ghost.tick(GOAL, readings=near(0, 0.5))
    assert ghost.report.mode == "evading"
    ghost.fly(4.0, always=(GOAL,), readings=near(0, 1.19))
    assert ghost.reference.r[0] < -0.2
    assert {x[2] for x in ghost.said("refused")} == {"it moves away from what is near"}
    assert len(ghost.said("refused")) == 1
    ghost.tick(readings=near())
    assert ghost.report.mode == "flying"
    assert [x[1] for x in ghost.said("bumper")] == ["near", "free"]


def test_who_evades_on_the_way_home_goes_on_home():
    ghost = Ghost().fly(9.0, GOAL).fly(1.0, LandHome())
    ghost.fly(1.0, readings=near(4, 0.4)).fly(0.1, readings=near())
    assert ghost.report.mode == "going home"
    ghost.fly(14.0)
    assert ghost.report.mode == "landing"
    np.testing.assert_allclose(ghost.reference.r[:2], 0.0, atol=0.11)


def test_what_was_near_and_is_not_measured_any_more_is_forgotten_after_a_second():
    ghost = Ghost().fly(0.5, readings=near(2)).fly(0.9)
    assert ghost.report.mode == "evading"
    ghost.fly(0.2)
    assert ghost.report.mode == "flying"


def test_it_does_not_evade_out_of_the_area():
    zone = NoFly(((-4.0, -4.0), (-0.2, -4.0), (-0.2, 4.0), (-4.0, 4.0)), name="wall")
    area = Area(SQUARE.border, 0.5, 8.0, no_fly=(zone,))
    ghost = Ghost(area=area).fly(2.0, readings=near(0, 0.3))
    np.testing.assert_allclose(ghost.reference.r, (0.0, 0.0, 2.0), atol=1e-6)
    assert "it stays, for" in ghost.said("bumper")[0][2]


def test_a_velocity_gives_way_to_the_bumper():
    ghost = Ghost().fly(2.0, always=(Velocity(np.array((1.0, 0.0, 0.0))),))
    ghost.fly(4.0, always=(Velocity(np.array((1.0, 0.0, 0.0))),), readings=near(0, 1.0))
    assert ghost.report.mode == "evading"
    assert ghost.flies[0] == "CommandFilter medium"
    assert np.linalg.norm(ghost.reference.v) < 0.3


# Flights ----------------------------------------------------------------------------------------------


@pytest.mark.flight
def test_a_pole_in_the_way_is_not_flown_into():
    mission = Waypoints(((0.0, (8.0, 0.0, 2.0), 0.0),))
    scenario = errand(mission=mission, start=(0.0, 0.0, 2.0), seconds=12.0)._replace(
        sensors={KNOWS: Knows(), "sectors": INSTRUMENTS["sectors"]()},
        obstacles=(Obstacle(4.0, 0.0, 0.3, 5.0),),
    )
    log = flown(scenario)
    assert log.exit is Exit.DONE, log.reason
    assert "evading" in modes(log)
    apart = np.hypot(log.r[:, 0] - 4.0, log.r[:, 1]) - 0.3
    assert apart.min() > 0.5
    assert finite(log)


@pytest.mark.flight
def test_somebody_flies_a_bit_and_gives_back():
    remote = INSTRUMENTS["remote"]()._replace(
        holds=(
            Hold(2.0, True, (1.0, 0.0, 0.0), 0.0, False),
            Hold(5.0, False, (0.0,) * 3, 0.0, False),
        )
    )
    mission = Waypoints(((0.0, (0.0, 0.0, 2.0), 0.0),))
    scenario = errand(mission=mission, start=(0.0, 0.0, 2.0), seconds=12.0)._replace(
        sensors={KNOWS: Knows(), "remote": remote}
    )
    log = flown(scenario)
    assert log.exit is Exit.DONE, log.reason
    assert modes(log) == ["flying", "manual", "flying"]
    assert log.r[:, 0].max() > 2.0
    np.testing.assert_allclose(log.r[-1], (0.0, 0.0, 2.0), atol=0.1)
    assert not events(log, "safety")
