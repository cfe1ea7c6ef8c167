"""Goals: what may not be flown is refused with its reason, and the flight holds what it flew."""

import numpy as np
import pytest
from ghost import DT, SQUARE, Ghost, believing

from uavlab.area import Area, NoFly
from uavlab.frames import Shift, moved
from uavlab.orders import In, LandThere, TakeOff, Use, Velocity
from uavlab.parts.missions import still
from uavlab.types import Trajectory

GOAL = still(np.array((3.0, 2.0, 2.0)), 0.4)


def way(*points, seconds=10.0):
    t = np.linspace(0.0, seconds, len(points))
    return Trajectory(t, np.array(points, float), np.zeros(len(points)))


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        (still(np.array((12.0, 0.0, 2.0))), r"the goal, \(12.0, 0.0, 2.0\) m, lies 2.0 m outside"),
        (still(np.array((0.0, 0.0, 9.0))), "1.0 m above"),
        (still(np.array((0.0, np.nan, 2.0))), r"r\[1\] of the reference is nan"),
        (way((0, 0, 2), (0, 5, 2), (0, 11, 2)), "point 2 of the trajectory"),
        (way((0, 0, 2), (0, 5, 2))._replace(t=np.array((1.0, 0.0))), "backwards in time"),
    ],
)
def test_a_goal_that_may_not_be_flown_is_refused_and_the_flight_holds_what_it_flew(goal, said):
    import re

    ghost = Ghost(area=SQUARE).fly(3.0, GOAL).fly(7.0, goal)
    [(_, name, why)] = ghost.said("refused")
    assert name == type(goal).__name__
    assert re.search(said, why)
    np.testing.assert_allclose(ghost.reference.r, GOAL.r, atol=1e-3)
    assert ghost.report.mode == "flying"


def test_a_mission_that_asks_for_the_same_again_and_again_is_answered_once():
    out = still(np.array((12.0, 0.0, 2.0)))
    ghost = Ghost(area=SQUARE).fly(3.0, always=(out,))
    assert len(ghost.said("refused")) == 1
    ghost.fly(0.3, still(np.array((0.0, -20.0, 2.0))))
    assert len(ghost.said("refused")) == 2


def test_the_way_counts_too_and_starts_where_the_reference_is():
    zone = NoFly(((4.0, -1.0), (6.0, -1.0), (6.0, 1.0), (4.0, 1.0)), name="pond")
    area = Area(SQUARE.border, 0.5, 8.0, no_fly=(zone,))
    ghost = Ghost(area=area).fly(1.0, still(np.array((8.0, 0.0, 2.0))))
    assert "crosses the no-fly zone 'pond'" in ghost.said("refused")[0][2]
    ghost.fly(5.0, still(np.array((0.0, 4.0, 2.0)))).fly(5.0, still(np.array((8.0, 4.0, 2.0))))
    np.testing.assert_allclose(ghost.reference.r, (8.0, 4.0, 2.0), atol=0.05)


def test_a_goal_in_the_world_of_a_hypothesis_is_flown_to_there():
    shift = Shift(np.array((1.0, -2.0, 0.3)), 0.5)
    ghost = Ghost(start=believing(worlds={"map": shift}))
    ghost.fly(10.0, In("map", GOAL))
    np.testing.assert_allclose(ghost.reference.r, moved(GOAL, shift).r, atol=1e-3)
    assert not ghost.said("refused")


def test_an_unknown_world_is_refused_with_those_that_are_known():
    ghost = Ghost(start=believing(worlds={"map": Shift(np.ones(3), 0.0)}, world="gnss"))
    ghost.fly(0.1, In("mop", GOAL))
    said = ghost.said("refused")[0]
    assert said[1] == "In"
    assert "Did you mean 'map'? Known: gnss, map." in said[2]


def test_a_goal_is_held_against_an_area_that_is_told_in_another_world():
    there = Area(SQUARE.border, 0.5, 8.0, world="map")
    shift = Shift(np.array((100.0, 0.0, 0.0)), 0.0)
    start = believing((100.0, 0.0, 2.0), worlds={"map": shift})
    ghost = Ghost(start=start, area=there)
    ghost.fly(0.1, still(np.array((95.0, 0.0, 2.0)))).fly(0.1, still(np.array((85.0, 0.0, 2.0))))
    [(_, _, why)] = ghost.said("refused")
    assert "(-15.0, 0.0, 2.0) m, lies 5.0 m outside" in why
    ghost.fly(0.1, still(np.array((94.0, 0.0, 2.0))), worlds={})
    assert "told in the world 'map', and nobody knows now where that lies" in ghost.said("refused")[-1][2]  # fmt: skip


def test_on_the_ground_a_goal_is_refused_and_while_it_takes_off_the_last_one_waits():
    ghost = Ghost(ground=True)
    ghost.tick(GOAL)
    assert "take off first" in ghost.said("refused")[0][2]
    ghost.fly(1.0, TakeOff(2.0)).fly(1.0, still(np.zeros(3))).fly(12.0, GOAL)
    assert ghost.report.mode == "flying"
    np.testing.assert_allclose(ghost.reference.r, GOAL.r, atol=0.01)
    assert len(ghost.said("refused")) == 1


def test_a_trajectory_that_the_tracker_cannot_fly_is_refused_and_it_flies_on():
    ghost = Ghost().fly(1.0, Use("tracker", "LineTracker"), GOAL)
    ghost.fly(10.0, way((0, 0, 2), (1, 0, 2)))
    [(_, name, why)] = ghost.said("refused")
    assert name == "Trajectory"
    assert "LineTracker flies to one place" in why
    np.testing.assert_allclose(ghost.reference.r, GOAL.r, atol=0.01)


# Velocities -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("limits", ["slow", "medium", "fast"])
@pytest.mark.parametrize(
    "v", [(9.0, 0.0, 0.0), (-3.0, 8.0, 0.0), (0.0, 0.0, 5.0), (1.0, 0.0, -2.0)]
)
def test_a_velocity_that_leads_out_of_the_area_ends_before_its_border(limits, v):
    ghost = Ghost(area=SQUARE).fly(0.1, Use("limits", limits))
    ghost.fly(15.0, always=(Velocity(np.array(v)),))
    r = ghost.way()
    assert (np.abs(r[:, :2]) <= 10.0).all()
    assert ((r[:, 2] >= 0.5) & (r[:, 2] <= 8.0)).all()
    assert np.linalg.norm(ghost.reference.v) < 0.05
    assert ghost.said("refused")[0][1] == "Velocity"
    edge = min(10.0 - np.abs(r[-1, :2]).max(), r[-1, 2] - 0.5, 8.0 - r[-1, 2])
    assert edge < 4.0  # it came near
    assert len(ghost.said("refused")) == 1


def test_who_has_stopped_before_a_border_may_fly_away_from_it():
    ghost = Ghost(area=SQUARE).fly(15.0, always=(Velocity(np.array((4.0, 0.0, 0.0))),))
    stopped = ghost.reference.r[0]
    ghost.fly(2.0, always=(Velocity(np.array((-2.0, 0.0, 0.0))),))
    assert ghost.reference.r[0] < stopped - 2.0


def test_a_velocity_may_leave_height_and_heading_free_or_ask_for_them():
    ghost = Ghost().fly(4.0, always=(Velocity(np.array((1.0, 0.0, 0.0)), z=3.0, heading=0.8),))
    assert ghost.flies[0] == "SpeedTracker z heading medium"
    assert ghost.reference.r[2] == pytest.approx(3.0, abs=0.05)
    assert ghost.reference.heading == pytest.approx(0.8, abs=0.01)
    np.testing.assert_allclose(ghost.reference.v[:2], (1.0, 0.0), atol=1e-3)
    ghost.fly(2.0, always=(Velocity(np.array((0.0, 0.0, 0.5)), heading_rate=0.2),))
    assert ghost.flies[0] == "SpeedTracker medium"
    assert ghost.reference.heading_rate == pytest.approx(0.2)
    assert ghost.reference.v[2] == pytest.approx(0.5, abs=1e-3)


def test_who_commands_velocities_and_falls_silent_is_stopped_and_the_place_counts_again():
    ghost = Ghost().fly(2.0, always=(Velocity(np.array((2.0, 0.0, 0.0))),)).fly(4.0)
    assert ghost.flies[0] == "CommandFilter medium"
    assert np.linalg.norm(ghost.reference.v) < 0.01
    there = ghost.reference.r
    ghost.fly(2.0)
    np.testing.assert_allclose(ghost.reference.r, there, atol=0.01)


@pytest.mark.parametrize(
    ("order", "said"),
    [
        (Velocity(np.array((np.inf, 0.0, 0.0))), "v is"),
        (Velocity(np.zeros(3), z=float("nan")), "z is nan"),
    ],
)
def test_a_velocity_that_is_no_number_is_refused(order, said):
    ghost = Ghost().fly(0.1, order)
    assert said in ghost.said("refused")[0][2]
    assert ghost.flies[0] == "CommandFilter medium"


def test_a_goal_that_moves_and_is_told_once_ends_before_the_border():
    moving = GOAL._replace(v=np.array((2.0, 0.0, 0.0)))
    ghost = Ghost(area=SQUARE).fly(20.0, moving)
    assert ghost.way()[:, 0].max() <= 10.0
    assert np.linalg.norm(ghost.reference.v) < 0.05
    assert ghost.way()[:, 0].max() > 7.0


@pytest.mark.parametrize(
    "asked",
    [
        GOAL._replace(r=np.zeros(2)), GOAL._replace(r="here"), GOAL._replace(heading="north"),
        GOAL._replace(v=None), Trajectory(None, None, None), In("", GOAL._replace(r=np.zeros(2))),
        In("", "there"), Velocity("fast"), Velocity(np.zeros(2)), Velocity(np.zeros(3), heading="up"),
        LandThere("home", 0.0), LandThere(np.zeros(2), 0.0), LandThere(np.zeros(3), None),
        TakeOff(None), Use("limits", None),
    ],
)  # fmt: skip
@pytest.mark.parametrize("ground", [False, True])
def test_what_is_made_of_something_else_than_numbers_is_refused_and_ends_no_flight(asked, ground):
    ghost = Ghost(ground=ground, area=SQUARE).fly(0.1, asked, always=(asked,))
    refusals = [x for x in ghost.report.events if x.kind == "refused" or "refused" in x.said]
    assert refusals
    assert ghost.report.mode == ("ground" if ground else "flying")


def test_a_pilot_knows_only_goals_and_orders():
    ghost = Ghost()
    ghost.tick("up")
    assert ghost.said("refused") == [("refused", "str", "'up' is no goal and no order.")]
    assert ghost.memory.t == pytest.approx(DT)
