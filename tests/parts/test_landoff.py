"""Take-off waits for an aircraft that is held; landing goes below it, until somebody sees that it stands."""

from dataclasses import dataclass

import numpy as np
import pytest

from uavlab.errors import BadInput
from uavlab.experiments.control_flights import flown, law
from uavlab.flight.scenario import Scenario, Swap, standing
from uavlab.flight.slot import Slot
from uavlab.frames import Shift, moved
from uavlab.gains import gains_for
from uavlab.parts.landoff import EMERGENCY, LandOff
from uavlab.parts.line import LineTracker
from uavlab.parts.missions import Waypoints, still
from uavlab.parts.pace import Pace
from uavlab.parts.throttle import ThrustCurve
from uavlab.parts.touchdown import Touchdown
from uavlab.plant import CompiledPlant, World, load_airframe
from uavlab.so3 import about_z
from uavlab.types import Command, Estimate

DT = 0.01
T650 = load_airframe("T650")
CURVE = ThrustCurve(T650.a_t, T650.b_t)
NOWHERE = Waypoints(((0.0, (9.0, 9.0, 9.0), 0.0),))  # these trackers do not listen


def at(r, v=(0.0, 0.0, 0.0), heading=0.0):
    zero = np.zeros(3)
    return Estimate(np.array(r, float), np.array(v, float), zero, about_z(heading), zero)


def stepped(part, memory, estimate, seconds):
    """The references of so many seconds in which the estimate follows exactly, or stays if it is given."""
    seen = []
    for _ in range(round(seconds / DT)):
        memory, x = part.step(memory, estimate or at(memory.now.r), None, DT)
        seen.append(x)
    return memory, seen


def flight(tracker, height, seconds, plant=None):
    start = standing((0.0, 0.0, height))
    scenario = Scenario("landoff", "", "T650", NOWHERE, start, seconds, {})
    return flown(scenario, law(T650.m, gains_for("T650", "soft")), tracker=tracker, plant=plant)


# Take-off ---------------------------------------------------------------------------------------------


def test_a_take_off_climbs_straight_within_its_pace_and_stops_at_its_height():
    part = LandOff(4.0)
    start = at((1.0, 2.0, 0.5), heading=0.7)
    memory, seen = stepped(part, part.init(start, None), None, 15.0)
    r, v, a = (np.array([getattr(x, name) for x in seen]) for name in "rva")
    assert np.allclose(r[:, :2], (1.0, 2.0))
    assert r[-1, 2] == pytest.approx(4.5, abs=1e-3)
    assert r[:, 2].max() < 4.5 + 1e-3
    assert v[:, 2].max() == pytest.approx(1.0)
    assert np.abs(a[:, 2]).max() < 0.3 + 1e-9
    assert {x.heading for x in seen} == {0.7}
    assert part.arrived(memory, at((1.0, 2.0, 4.5)))
    assert not part.arrived(memory, at((1.0, 2.0, 4.0)))


@pytest.mark.parametrize("height", [0.4, 10.1, -1.0, float("nan")])
def test_a_height_that_is_no_take_off_is_refused(height):
    with pytest.raises(BadInput, match=r"0\.5 to 10 m"):
        LandOff(height)


def test_a_pace_that_does_not_move_is_refused():
    with pytest.raises(BadInput, match=r"climb\.v is 0"):
        LandOff(2.0, climb=Pace(0.0, 1.0))
    with pytest.raises(BadInput, match="reach is -1"):
        LandOff(2.0, reach=-1.0)


def test_the_reference_waits_for_an_aircraft_that_is_held_and_goes_on_when_it_comes():
    part = LandOff(3.0)
    memory, seen = stepped(part, part.init(at((0, 0, 0)), None), at((0, 0, 0)), 10.0)
    step = 1.0 * DT
    assert 0.7 < seen[-1].r[2] < 0.7 + step
    assert not seen[-1].v.any()
    _, later = stepped(part, memory, at((0, 0, 0.3)), 10.0)
    assert 1.0 < later[-1].r[2] < 1.0 + step


def test_a_reference_that_is_far_away_may_come_nearer():
    part = LandOff(3.0)
    memory = part.init(at((0, 0, 0)), None)
    _, seen = stepped(part, memory, at((0, 0, 2.9)), 5.0)
    assert seen[-1].r[2] > 2.0


@dataclass(frozen=True)
class Tethered:
    """An aircraft on a line that lets it rise no higher than `length` [m], until `until` [s]."""

    length: float
    until: float
    plant = CompiledPlant(T650)

    def init(self, state):
        return self.plant.init(state)

    def advance(self, world, command, wind, dt, n) -> World:
        world = self.plant.advance(world, command, wind, dt, n)
        if world.t > self.until or world.r[2] < self.length:
            return world
        r, v = world.r.copy(), world.v.copy()
        r[2], v[2] = self.length, min(v[2], 0.0)
        return world._replace(r=r, v=v)


@pytest.mark.flight
def test_the_reference_of_a_tethered_take_off_waits_and_released_it_goes_on():
    log = flight(LandOff(2.0), 0.0, 12.0, Tethered(0.3, 5.0))
    held = log.t < 5.0
    ahead = np.linalg.norm(log.r_d - log.r_e, axis=1)
    assert log.r[held, 2].max() <= 0.3
    assert 0.69 < ahead[held].max() < 0.7 + 1.0 * DT
    assert log.r[-1, 2] == pytest.approx(2.0, abs=0.2)  # what the mass has learned meanwhile fades
    assert log.exit.name == "DONE"


@pytest.mark.flight
def test_on_a_tether_only_the_integral_of_the_controller_pulls_harder_and_harder():
    waits, pulls = (flight(LandOff(3.0, reach=x), 0.0, 6.0, Tethered(0.3, 9.0)) for x in (0.7, 9.0))
    gains, e = gains_for("T650", "soft"), 0.7 + 0.01
    growth = (
        gains.k_m * e * (9.81 + gains.k_p[2] * e)
    )  # [N/s]: the mass that (37) learns, and its force
    assert np.ptp(waits.f_d[waits.t >= 5.0]) < growth
    assert pulls.f_d[-1] > waits.f_d[-1] + 10.0


# Landing ----------------------------------------------------------------------------------------------


def test_a_landing_stops_first_and_then_sinks():
    part = LandOff()
    last = still(np.array((0.0, 0.0, 5.0)))._replace(v=np.array((2.0, 1.0, 0.0)))
    _, seen = stepped(part, part.init(at((0, 0, 5.0)), last), None, 6.0)
    moving = [x for x in seen if np.linalg.norm(x.v[:2]) > 0.05 + 0.02]
    assert all(x.r[2] == 5.0 for x in moving)
    assert np.hypot(*seen[-1].r[:2]) == pytest.approx(5.0 / (2.0 * 2.0), abs=0.02)  # v²/2a
    assert min(x.v[2] for x in seen) == pytest.approx(-0.5)
    assert max(np.abs(x.a[2]) for x in seen) < 0.3 + 1e-9


def test_a_reference_that_lands_goes_a_metre_below_what_stands_and_no_farther():
    part = LandOff()
    _, seen = stepped(part, part.init(at((0, 0, 0.1)), None), at((0, 0, 0.0)), 20.0)
    assert seen[-1].r[2] == pytest.approx(-1.0, abs=1e-3)
    assert all(x.v[2] <= 0.0 for x in seen)


def test_an_emergency_is_brisker():
    def depth(pace):
        part = LandOff(sink=pace)
        return stepped(part, part.init(at((0, 0, 9.0)), None), None, 1.0)[1][-1].r[2]

    assert depth(EMERGENCY) < depth(LandOff().sink)


def test_a_climb_goes_on_in_another_world_to_the_same_place():
    part, shift = LandOff(2.0), Shift(np.array((5.0, -2.0, 3.0)), 1.0)
    memory, _ = stepped(part, part.init(at((1, 0, 0)), None), None, 1.0)
    here, _ = stepped(part, memory, None, 9.0)
    there, _ = stepped(part, part.reframe(memory, shift), None, 9.0)
    np.testing.assert_allclose(there.now.r, moved(here.now, shift).r, atol=1e-9)


@pytest.mark.flight
def test_one_aircraft_goes_up_along_a_line_and_down_with_a_tracker_for_each():
    slot = Slot({"up": LandOff(1.0), "line": LineTracker(), "down": LandOff()})
    swaps = (Swap(4.0, "tracker", "line"), Swap(9.0, "tracker", "down"))
    goal = Waypoints(((0.0, (2.0, 1.0, 1.5), 0.5),))
    start = standing((0.0, 0.0, 0.0))
    scenario = Scenario("day", "", "T650", goal, start, 16.0, {}, swaps=swaps)
    log = flown(scenario, law(T650.m, gains_for("T650", "soft")), tracker=slot)
    assert [told[3] for told in log.meta["swaps"]] == ["first", "taken over", "taken over"]
    np.testing.assert_allclose(log.r[890], (2.0, 1.0, 1.5), atol=0.15)
    np.testing.assert_allclose(log.r[-1], (2.0, 1.0, 0.0), atol=0.15)
    assert np.linalg.norm(log.r - log.r_d, axis=1)[:900].max() < 0.3


# Touch-down -------------------------------------------------------------------------------------------


def after(masses, part=None):
    """Ticks until it says so, while the thrust carries these masses [kg]; None: never."""
    part = part or Touchdown(3.5, CURVE)
    memory = part.init()
    for k, m in enumerate(masses):
        memory, down = part.step(memory, Command(m * 9.81, np.zeros(3), np.zeros(3)), DT)
        if down:
            return k + 1
    return None


def test_an_aircraft_stands_when_its_thrust_has_carried_less_than_half_of_it_for_two_seconds():
    assert after([1.7] * 1000) == 200
    assert after([1.8] * 1000) is None


def test_a_moment_of_more_thrust_begins_the_two_seconds_anew():
    assert after([1.7] * 150 + [2.0] + [1.7] * 1000) == 351


def test_idle_counts_as_standing_whatever_the_curve_says():
    idles = ThrustCurve(0.12, 0.0)
    assert after([0.0] * 1000, Touchdown(3.5, idles)) == 200
    assert after([-1.0] * 1000) == 200


def test_a_curve_of_another_aircraft_is_refused():
    with pytest.raises(BadInput, match="hover at throttle 1"):
        Touchdown(15.0, CURVE)
    with pytest.raises(BadInput, match=r"share is 1\.5"):
        Touchdown(3.5, CURVE, share=1.5)
