"""When something breaks: it lands in an emergency, or falls, and never flies on what is no number."""

from dataclasses import replace

import numpy as np
import pytest
from flights import at, errand, events, finite, flown, modes
from ghost import DT, Ghost, believing

from uavlab.area import Area
from uavlab.flight.fault import Fault
from uavlab.managers.rescue import failsafe, gentle, landing, turned
from uavlab.orders import EmergencyLand, Fall, TakeOff, Unheard
from uavlab.parts.errands import Wait
from uavlab.parts.missions import Waypoints, still
from uavlab.so3 import about_z, exp
from uavlab.types import Attitude, Exit, Imu

NONE = np.full(3, np.nan)
STAY = Waypoints(((0.0, (0.0, 0.0, 2.0), 0.0),))


def hovering(*faults, **more):
    return errand(mission=STAY, start=(0.0, 0.0, 2.0), faults=faults, **{"seconds": 30.0, **more})


# Decisions --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("order", "mode", "who"),
    [(EmergencyLand("smoke"), "emergency", "Emergency"), (Fall("fire"), "failsafe", "TiltAxis")],
)
def test_who_is_asked_to_come_down_does_and_says_why(order, mode, who):
    ghost = Ghost().fly(0.5).fly(0.1, order)
    assert ghost.report.mode == mode
    assert ghost.said("safety") == [("safety", "asked for", order.why)]
    assert ghost.said("mode")[-1] == ("mode", mode, order.why)
    assert ghost.flies[1] == who
    ghost = Ghost(ground=True).fly(0.1, order)
    assert ghost.said("refused")[0][2] == "it is not in the air, but ground."


def test_an_emergency_landing_stops_and_sinks_where_it_is_and_hears_no_goals():
    ghost = Ghost().fly(1.0, still(np.array((5.0, 0.0, 2.0)))).fly(3.0, EmergencyLand())
    there = ghost.reference.r
    ghost.fly(1.0, still(np.zeros(3)))
    np.testing.assert_allclose(ghost.reference.r[:2], there[:2], atol=1e-6)
    assert ghost.reference.r[2] < there[2]
    assert ghost.said("refused")[0][2] == "it is landing in an emergency"


def test_who_commands_and_is_not_heard_for_three_seconds_is_landed_without():
    ghost = Ghost().fly(2.9, always=(Unheard(),))
    assert ghost.report.mode == "flying"
    ghost.fly(0.2).fly(3.1, always=(Unheard(),))  # heard in between
    assert ghost.report.mode == "emergency"
    assert ghost.said("safety")[0][1] == "link"


@pytest.mark.parametrize("broken", [("r",), ("v",), ("a",), ("r", "v", "a"), ("R", "omega")])
def test_an_estimate_that_is_no_number_reaches_no_part_and_after_a_tenth_of_a_second_it_falls(
    broken,
):
    ghost = Ghost().fly(1.0, still(np.array((1.0, 0.0, 2.0))))
    belief = {k: np.full(np.shape(getattr(ghost.estimate, k)), np.nan) for k in broken}
    ghost.fly(0.08, **belief)
    assert ghost.report.mode == "flying"
    ghost.fly(0.06, **belief)
    assert ghost.report.mode == ("failsafe" if broken != ("a",) else "flying")
    ghost.fly(1.0, **belief)
    assert all(np.isfinite(x).all() for ref in ghost.references for x in ref)
    assert all(np.isfinite(x).all() for x in ghost.command)


def test_a_short_gap_in_the_estimate_is_flown_over():
    ghost = Ghost().fly(1.0, still(np.array((1.0, 0.0, 2.0)))).fly(0.08, r=NONE)
    ghost.fly(4.0, r=ghost.memory.estimate.r)
    ghost.fly(3.0)
    np.testing.assert_allclose(ghost.reference.r, (1.0, 0.0, 2.0), atol=0.01)
    assert ghost.report.mode == "flying"


def test_an_attitude_that_is_not_told_is_turned_on_by_the_gyro_and_takes_its_tilt_from_the_autopilot():
    R = about_z(0.5) @ exp(np.array((0.1, -0.2, 0.0)))
    rate = np.array((0.3, 0.1, -0.4))
    turned_on, omega = turned(R, {"imu": Imu(0.0, np.zeros(3), rate)}, DT)
    np.testing.assert_allclose(turned_on, R @ exp(rate * DT), atol=1e-12)
    np.testing.assert_allclose(omega, rate)
    elsewhere = Attitude(0.0, about_z(2.0) @ exp(np.array((0.0, 0.3, 0.0))))
    held, _ = turned(R, {"ahrs": elsewhere}, DT)
    np.testing.assert_allclose(held[2], elsewhere.R[2], atol=1e-12)  # the same tilt
    assert np.arctan2(held[1, 0], held[0, 0]) == pytest.approx(np.arctan2(R[1, 0], R[0, 0]))
    same, omega = turned(R, {"imu": Imu(0.0, np.zeros(3), NONE)}, DT)
    np.testing.assert_allclose(same, R)
    np.testing.assert_allclose(omega, 0.0)


def test_the_mass_that_a_controller_learned_is_that_of_failsafe_and_touch_down_and_a_wild_one_is_not():
    ghost = Ghost("GeometricController", "CommandFilter").fly(0.5)
    learned = ghost.memory.controlling.memory
    for told, believed in ((4.0, 4.0), (90.0, 4.9), (np.nan, 4.9)):
        inner = learned._replace(m_e=told)
        ghost.memory = ghost.memory._replace(
            controlling=ghost.memory.controlling._replace(memory=inner)
        )
        ghost.tick()
        assert ghost.memory.mass == pytest.approx(believed, abs=0.05)


def test_a_reference_stays_inside_although_an_emergency_has_no_room_to_stop():
    area = Area(((-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)), 0.0, 8.0)
    ghost = Ghost(start=believing((0.0, 0.5, 4.0), (4.0, 1.0, 0.0)), area=area)
    ghost.fly(0.3).fly(4.0, EmergencyLand())
    assert (np.abs(ghost.way()[:, :2]) <= 3.0).all()
    assert ghost.way()[:, 0].max() > 2.98
    assert ghost.report.mode == "emergency"


# Flights ----------------------------------------------------------------------------------------------


@pytest.mark.flight
@pytest.mark.parametrize(
    ("fault", "trigger", "exit_"),
    [
        (Fault("part", 3.0, 9.0, "tracker", "raises"), "tracker", Exit.LANDED),
        (Fault("part", 3.0, 9.0, "controller", "nan"), "controller", Exit.LANDED),
        (Fault("part", 3.0, 99.0, "controller.*", "raises"), "controller", Exit.FAILSAFE),
        (Fault("nan", 3.0), "state missing", Exit.FAILSAFE),
        (Fault("nan", 3.0, what="all"), "state missing", Exit.FAILSAFE),
        (Fault("link", 3.0), "link", Exit.LANDED),
    ],
)
def test_a_flight_in_which_something_breaks_ends_on_the_ground_with_motors_off(
    fault, trigger, exit_
):
    log = flown(hovering(fault))
    assert log.exit is exit_, log.reason
    assert events(log, "safety")[0][1] == trigger
    assert log.meta["events"][-1][0] >= 3.0
    down = np.flatnonzero(log.r[:, 2] < 1e-3)[0]
    assert -log.v[down - 1, 2] < 3.0
    assert np.linalg.norm(log.r[-1, :2]) < 1.0
    assert finite(log)


def test_a_fall_from_high_up_is_slower_and_one_from_two_metres_is_that_of_the_failsafe():
    pilot = Ghost().pilot
    law = failsafe(pilot, pilot.mass)
    assert gentle(law, 2.0, 0.0) == law
    for height in (4.0, 6.0, 10.0, 20.0):
        slow = gentle(law, height, 0.0)
        assert slow.rate < law.rate
        assert landing(law, height, 0.0)[0] > landing(slow, height, 0.0)[0]
    # Against the speed of a body that falls evenly: without a rate all of it is v²/2h.
    even = replace(law, rate=1e-9)
    a = 9.81 - even.force(0.0) / law.mass
    assert landing(even, 5.0, 0.0)[0] == pytest.approx(np.sqrt(2 * a * 5.0), rel=0.02)


@pytest.mark.flight
@pytest.mark.parametrize("height", [4.0, 6.0])
def test_who_falls_from_high_up_is_not_broken(height):
    scenario = errand(
        mission=Waypoints(((0.0, (0.0, 0.0, height), 0.0),)), start=(0.0, 0.0, height),
        faults=(Fault("nan", 3.0, what="all"),), seconds=60.0,
    )  # fmt: skip
    log = flown(scenario)
    assert log.exit is Exit.FAILSAFE, log.reason
    assert log.v[:, 2].min() > -2.6
    assert log.t[-1] < 20.0


def test_who_falls_for_want_of_an_estimate_lands_when_there_is_one_again():
    ghost = Ghost().fly(1.0).fly(0.5, r=NONE)
    assert ghost.report.mode == "failsafe"
    there = believing((1.0, 0.0, 5.0), (0.0, 0.0, -1.0))
    ghost.fly(0.9, r=there.r, v=there.v)
    assert ghost.report.mode == "failsafe"
    ghost.fly(0.3, r=there.r, v=there.v)
    assert ghost.report.mode == "emergency"
    assert ghost.flies == ("LandOff emergency", "Emergency")
    np.testing.assert_allclose(ghost.reference.r[:2], there.r[:2], atol=0.01)


@pytest.mark.parametrize("belief", [{"reliable": False}, {"r": NONE}])
def test_who_was_told_to_fall_or_still_misses_an_estimate_falls_on(belief):
    ghost = Ghost().fly(1.0).fly(3.0, Fall())
    assert ghost.report.mode == "failsafe"
    ghost = Ghost().fly(1.0).fly(4.0, **belief)
    assert ghost.report.mode == "failsafe"


@pytest.mark.flight
def test_a_fall_high_up_that_ends_in_time_is_a_landing():
    scenario = errand(
        mission=Waypoints(((0.0, (0.0, 0.0, 6.0), 0.0),)), start=(0.0, 0.0, 6.0),
        faults=(Fault("nan", 3.0, 4.0),),
    )  # fmt: skip
    log = flown(scenario)
    assert log.exit is Exit.LANDED, log.reason
    assert modes(log) == ["flying", "failsafe", "emergency", "landed"]
    assert log.v[:, 2].min() > -2.5


@pytest.mark.flight
def test_a_link_that_is_back_in_time_is_no_matter():
    log = flown(hovering(Fault("link", 2.0, 4.5), seconds=7.0))
    assert log.exit is Exit.DONE
    assert modes(log) == ["flying"]


@pytest.mark.flight
def test_an_estimate_that_is_lost_in_a_take_off_ends_on_the_ground():
    scenario = errand(TakeOff(3.0), Wait(5.0), faults=(Fault("nan", 4.0, what="all"),))
    log = flown(scenario)
    assert log.exit is Exit.FAILSAFE, log.reason
    assert at(log, "mode", "failsafe") == pytest.approx(4.1, abs=0.03)
