"""A slot of estimators: all run, one is told; whoever is told next is not felt, and whoever fails is dropped."""

from itertools import permutations
from typing import Any, ClassVar

import numpy as np
import pytest

import uavlab
from uavlab.errors import BadInput, UnknownName
from uavlab.experiments import estimator_swaps
from uavlab.flight.fill import fill
from uavlab.flight.log import UNITS
from uavlab.flight.scenario import Swap
from uavlab.flight.slot import slotted, swappable, with_slots
from uavlab.frames import NO_SHIFT, Shift, compose, heading, inverse, moved, wrap
from uavlab.managers.pair import Pair
from uavlab.parts.bank import BankEstimator, chosen
from uavlab.parts.controllers import HeadingController
from uavlab.parts.estimator_slot import EstimatorSlot
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.missions import InWorld, Waypoints
from uavlab.parts.priority import FixedPriority
from uavlab.parts.vetted import Vetted
from uavlab.so3 import about_z, exp
from uavlab.types import Attitude, Command, Estimate, Fix, Imu, Pose

DT = 0.01
ZERO = np.zeros(3)
START = Estimate(np.array((1.0, 2.0, 3.0)), ZERO, ZERO, about_z(0.3), ZERO)
COMMAND = Command(17.0, ZERO, np.array((0.5, 0.2, -0.1)))
JUMP = Shift(np.array((3.0, -2.0, 0.5)), 0.4)


class Told:
    """An estimator that believes a reading by its name, in its own world, and notes what it heard."""

    slot: ClassVar[str] = "estimator"

    def __init__(self, name, fails=None, honest=True):
        self.name, self.fails, self.honest = name, fails, honest

    def init(self, estimate):
        if self.fails == "init":
            raise RuntimeError("no memory left")
        return estimate, ZERO

    def step(self, memory, readings, command, dt):
        was, _ = memory
        new = readings.get(self.name, was)
        if self.fails == "step" and self.name in readings:
            raise RuntimeError("lost it")
        if self.fails == "nan" and self.name in readings:
            new = new._replace(v=np.array((0.0, np.nan, 0.0)))
        shift = new.shift if self.honest else was.shift
        return (new, command.a_d), new._replace(shift=shift)

    def reframe(self, memory, shift):
        return moved(memory[0], shift), memory[1]

    def hypotheses(self, memory):
        return {}


def stepped(slot, memory, readings, n=1, command=COMMAND):
    out: Any = None
    for _ in range(n):
        memory, out = slot.step(memory, readings, command, DT)
    return memory, out


def two(**fails):
    return EstimatorSlot({name: Told(name, fails.get(name)) for name in ("a", "b")})


READINGS = {"a": START, "b": moved(START, JUMP)._replace(shift=NO_SHIFT)}


# Being told -------------------------------------------------------------------------------------------


def test_whoever_is_told_next_is_told_in_its_own_world_and_the_estimate_says_how_that_lies():
    slot = two()
    memory, before = stepped(slot, slot.init(START), READINGS)
    assert (before.world, before.shift) == ("a", START.shift)
    memory, after = stepped(slot, slot.swap(memory, "b"), READINGS)
    assert after.world == memory.name == "b"
    np.testing.assert_allclose(after.r, READINGS["b"].r)
    np.testing.assert_allclose(after.shift.r, JUMP.r, atol=1e-12)
    assert after.shift.heading == pytest.approx(JUMP.heading)
    memory, back = stepped(slot, slot.swap(memory, "a"), READINGS)
    np.testing.assert_allclose(back.shift.r, 0.0, atol=1e-12)
    assert wrap(back.shift.heading) == pytest.approx(0.0)


def test_a_shift_that_does_not_change_stays_the_same_object_so_that_the_loop_moves_nobody():
    slot = two()
    memory, first = stepped(slot, slot.init(START), READINGS)
    _, later = stepped(slot, memory, READINGS, n=3)
    assert first.shift is START.shift is later.shift
    memory, swapped = stepped(slot, slot.swap(memory, "b"), READINGS)
    _, again = stepped(slot, memory, READINGS)
    assert again.shift is swapped.shift


def test_the_way_from_every_world_that_is_known_leads_to_the_one_that_is_told():
    slot = two()
    memory, _ = stepped(slot, slot.init(START), READINGS)
    _, told = stepped(slot, slot.swap(memory, "b"), READINGS)
    assert set(told.worlds) == {"a", "b"}
    np.testing.assert_allclose(moved(READINGS["a"], told.worlds["a"]).r, told.r)
    assert told.worlds["b"] == NO_SHIFT


def test_who_is_not_told_hears_of_the_command_in_its_own_world():
    slot = two()
    memory, _ = stepped(slot, slot.init(START), READINGS)
    memory, _ = stepped(slot, memory, READINGS)
    np.testing.assert_allclose(memory.memories["a"][1], COMMAND.a_d)
    np.testing.assert_allclose(memory.memories["b"][1], about_z(0.4) @ COMMAND.a_d)


def test_a_bank_that_changes_its_own_world_moves_that_of_the_slot_while_it_is_told_and_only_then():
    jumped = {**READINGS, "a": moved(START, JUMP)}
    slot = two()
    memory, _ = stepped(slot, slot.init(START), READINGS)
    _, told = stepped(slot, memory, jumped)
    np.testing.assert_allclose(told.shift.r, JUMP.r)
    memory, before = stepped(slot, slot.swap(memory, "b"), READINGS)
    memory, after = stepped(slot, memory, jumped)
    assert after.shift is before.shift
    np.testing.assert_allclose(moved(jumped["a"], after.worlds["a"]).r, after.r)


def test_worlds_of_the_filters_of_a_bank_are_known_whoever_is_told():
    far = Shift(np.array((7.0, 0.0, 0.0)), -0.2)
    slot = two()
    readings = {**READINGS, "b": READINGS["b"]._replace(worlds={"gnss": far, "a": far})}
    _, told = stepped(slot, slot.init(START), readings)
    wanted = compose(inverse(JUMP), far)
    np.testing.assert_allclose(told.worlds["gnss"].r, wanted.r, atol=1e-12)
    assert told.worlds["a"] == NO_SHIFT  # the member, not the filter by its name


# Failing ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("init", "it raised RuntimeError: no memory left"),
        ("step", "it raised RuntimeError: lost it"),
        ("nan", "its v is not finite"),
    ],
)
def test_a_member_that_fails_is_dropped_with_the_reason_and_a_swap_to_it_is_refused(how, said):
    slot = two(b=how)
    memory, out = stepped(slot, slot.init(START), READINGS)
    assert memory.dropped == {"b": said}
    assert out.world == "a"
    assert "b" not in out.worlds or how == "init"
    with pytest.raises(BadInput, match=f"b runs no more: {said}"):
        slot.swap(memory, "b")
    memory, _ = stepped(slot, memory, READINGS)
    assert slot.news(memory) == ()


@pytest.mark.parametrize("how", ["step", "nan"])
def test_when_the_one_that_is_told_fails_the_next_one_is_laid_onto_its_last_word(how):
    slot = two(a=how)
    start = START._replace(v=np.array((1.0, 0.0, 0.0)))
    memory = slot.init(start)
    memory, before = stepped(slot, memory, {"b": READINGS["b"]})
    memory, after = stepped(slot, memory, READINGS)
    assert (memory.name, after.world, after.reliable) == ("b", "b", True)
    assert [x[0] for x in slot.news(memory)] == ["a", "b"]
    here = moved(after, inverse(after.shift))
    np.testing.assert_allclose(here.r, before.r + DT * before.v, atol=1e-12)
    assert heading(here.R) == pytest.approx(heading(before.R))


def test_with_nobody_left_the_estimate_goes_on_and_says_that_nothing_stands_behind_it():
    slot = two(a="nan", b="step")
    start = START._replace(v=np.array((1.0, 0.0, 0.0)))
    memory, out = stepped(slot, slot.init(start), READINGS, n=50)
    assert set(memory.dropped) == {"a", "b"}
    assert not out.reliable
    np.testing.assert_allclose(out.r, start.r + 0.5 * start.v, atol=1e-9)


def turning(omega, seconds, seen=""):
    """What is left when the only member has failed and the aircraft turns: gyro, and an attitude by that name."""
    slot = EstimatorSlot({"a": Told("a", "step")})
    memory, _ = stepped(slot, slot.init(START), READINGS)
    R = START.R
    out: Any = None
    for k in range(round(seconds / DT)):
        R = R @ exp(omega * DT)
        read: dict[str, Any] = {"imu": Imu(DT * k, ZERO, omega)}
        if seen:
            kind = {"ahrs": Attitude(DT * k, R), "mocap": Pose(DT * k, ZERO, R)}[seen]
            read = {seen: kind}
        memory, out = slot.step(memory, read, COMMAND, DT)
    return out, R


@pytest.mark.parametrize("seen", ["", "ahrs", "mocap"])
def test_with_nobody_left_the_estimate_still_turns_with_the_aircraft(seen):
    omega = np.array((0.8, -0.5, 0.0))
    out, R = turning(omega, 1.0, seen)
    assert not out.reliable
    np.testing.assert_allclose(out.R[2], R[2], atol=1e-9)  # the vertical, as the body sees it
    assert np.arccos(R[2, 2]) > 0.5


def test_nobody_is_asked_who_has_heard_nothing_lately():
    slot = EstimatorSlot({"a": Told("a"), "deaf": AlphaBetaGamma("rtk")})
    memory, out = stepped(slot, slot.init(START), READINGS, n=40)
    assert "deaf" not in out.worlds
    with pytest.raises(BadInput, match="deaf is not reliable now; ask again when it is"):
        slot.swap(memory, "deaf")


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({}, "no parts"),
        ({"": AlphaBetaGamma()}, "named ''"),
        ({"a": AlphaBetaGamma(), "b": 3}, "'b' of an EstimatorSlot is int with slot None"),
        ({"a": uavlab.stack("F450").tracker}, "slot 'tracker'"),
    ],
)
def test_what_is_no_estimator_is_refused_by_name(parts, said):
    with pytest.raises(BadInput, match=said):
        EstimatorSlot(parts)


def test_a_name_that_nobody_has_is_answered_with_the_near_one():
    slot = EstimatorSlot({"cameras": AlphaBetaGamma(), "satellites": AlphaBetaGamma("gnss")})
    with pytest.raises(UnknownName, match="Did you mean 'cameras'"):
        slot.swap(slot.init(START), "camera")
    with pytest.raises(UnknownName):
        EstimatorSlot(slot.parts, "mocap")


# Reliable ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [AlphaBetaGamma("rtk"), FixedPriority()])
def test_an_observer_is_reliable_while_a_position_was_heard_in_the_last_0_3_s(part):
    fix = {"rtk": Fix(0.0, START.r, ZERO)}
    memory, out = stepped(part, part.init(START), {}, n=30)
    assert out.reliable
    memory, out = stepped(part, memory, {})
    assert not out.reliable
    memory, out = stepped(part, memory, fix)
    assert out.reliable
    assert stepped(part, memory, {}, n=30)[1].reliable
    assert not stepped(part, memory, {}, n=31)[1].reliable


def test_an_observer_with_a_second_instrument_stays_reliable_when_the_first_falls_silent():
    part = FixedPriority()
    both = {"rtk": Fix(0.0, START.r, ZERO), "gnss": Fix(0.0, START.r, ZERO)}
    memory, _ = stepped(part, part.init(START), both)
    for k in range(100):
        heard = {"gnss": both["gnss"]} if k % 10 == 9 else {}
        memory, out = stepped(part, memory, heard)
        assert out.reliable


def test_a_bank_is_not_reliable_while_none_of_its_filters_is():
    bank = fill(BankEstimator, setup=chosen("gnss", "rtk")).part
    memory, out = stepped(bank, bank.init(START), {}, n=30)
    assert out.reliable  # on what it was given
    assert not stepped(bank, memory, {})[1].reliable


# In flight --------------------------------------------------------------------------------------------


@pytest.mark.flight
def test_every_estimator_takes_over_from_every_other_across_metres_and_the_aircraft_stays():
    """The experiment of the book, with one seed."""
    rows, found = estimator_swaps.rows_of(estimator_swaps.quiet(), 1, True)
    judged = [row for row in rows if row.band is not None]
    assert set(found) == set(permutations(estimator_swaps.NAMES, 2))
    assert [row.quantity for row in judged if not row.met] == []
    assert len(judged) == 6
    jumps = [float(row.note.split("jumps by ")[1].removesuffix(" m")) for row in judged]
    assert min(jumps) > 3.0


@pytest.mark.flight
def test_a_swap_that_is_not_said_would_be_felt():
    """The ruler: the same swap by an estimator that keeps it to itself."""

    class Silent(EstimatorSlot):
        def step(self, memory, readings, command, dt):
            memory, out = super().step(memory, readings, command, dt)
            return memory, out._replace(shift=NO_SHIFT)

    scenario = uavlab.scenarios.load("hover")._replace(
        sensors=estimator_swaps.quiet(), duration=2.0, swaps=(Swap(1.0, "estimator", "map"),)
    )
    bank = fill(BankEstimator, setup=chosen("slam")).part
    slot = Silent({"cameras": AlphaBetaGamma(), "map": bank})
    log = uavlab.fly(scenario, uavlab.stack("F450", slot, HeadingController))
    assert np.linalg.norm(log.r[-1] - log.r[100]) > 1.0


@pytest.mark.flight
def test_goals_in_the_world_of_a_member_that_is_not_told_are_reached_there():
    goal = Waypoints(((0.0, (3.5, -2.0, 2.5), 0.0),))  # half a metre from the start
    kit = estimator_swaps.quiet()
    mission = InWorld(goal, "receiver")
    scenario = uavlab.scenarios.load("hover")._replace(sensors=kit, mission=mission, duration=4.0)
    parts = {
        "cameras": AlphaBetaGamma(),
        "receiver": fill(BankEstimator, setup=chosen("rtk")),
        "map": fill(BankEstimator, setup=chosen("slam")),
    }
    mind = uavlab.stack("F450", slotted(parts), HeadingController)
    log = uavlab.fly(scenario._replace(swaps=(Swap(2.0, "estimator", "map"),)), mind)
    there = log.r[-1] + np.array((3.0, -2.0, 0.5))
    np.testing.assert_allclose(there, (3.5, -2.0, 2.5), atol=0.08)


@pytest.mark.flight
def test_a_slot_of_one_flies_as_that_one_alone():
    scenario = uavlab.scenarios.load("hover")._replace(duration=0.5)
    one = uavlab.fly(scenario, uavlab.stack("F450", EstimatorSlot({"x": AlphaBetaGamma()})))
    other = uavlab.fly(scenario, uavlab.stack("F450"))
    assert all(np.array_equal(getattr(one, k), getattr(other, k)) for k in UNITS if k != "solve")


def test_an_estimator_that_breaks_in_flight_is_in_the_log_with_who_came_after_it():
    scenario = uavlab.scenarios.load("hover")._replace(duration=0.1)
    slot = EstimatorSlot({"bad": Told("mocap", "step"), "good": AlphaBetaGamma()})
    log = uavlab.fly(scenario, uavlab.stack("F450", slot))
    assert [x[2:] for x in log.meta["swaps"]] == [
        ["bad", "first"], ["bad", "dropped: it raised RuntimeError: lost it"], ["good", "taken over"]
    ]  # fmt: skip


# Asked for by a scenario ------------------------------------------------------------------------------


def hover(*swaps):
    return uavlab.scenarios.load("hover")._replace(swaps=swaps, duration=0.2)


def test_a_plain_mind_gets_a_slot_for_the_estimators_that_a_scenario_names():
    scenario = hover(Swap(0.1, "estimator", "FixedPriority"))
    mind = with_slots(scenario, uavlab.stack("F450"))
    swappable(scenario, mind)
    assert list(mind.estimator.parts) == ["AlphaBetaGamma", "FixedPriority"]
    assert uavlab.fly(scenario, mind).meta["swaps"][-1][2:] == ["FixedPriority", "taken over"]


def test_a_bank_takes_a_swap_among_its_filters_by_itself_and_refuses_one_that_it_has_not():
    bank = fill(BankEstimator, setup=chosen("gnss", "rtk"))
    mind = uavlab.stack("F450", bank)
    scenario = hover(Swap(0.1, "estimator", "rtk"))
    assert with_slots(scenario, mind) is mind
    swappable(scenario, mind)
    with pytest.raises(BadInput, match="no part of the estimator's slot named 'slam'"):
        swappable(hover(Swap(0.1, "estimator", "slam")), mind)


def test_a_slot_goes_inside_of_what_vets_the_readings():
    mind = uavlab.stack("F450", Vetted(AlphaBetaGamma()))
    made = with_slots(hover(Swap(0.1, "estimator", "FixedPriority")), mind)
    assert isinstance(made.estimator, Vetted)
    assert made.estimator.names == ("AlphaBetaGamma", "FixedPriority")


def test_a_part_of_another_slot_is_no_estimator():
    with pytest.raises(BadInput, match="swaps of the estimator: TiltAxis is a controller"):
        with_slots(hover(Swap(0.1, "estimator", "TiltAxis")), uavlab.stack("F450"))


def test_trackers_and_controllers_of_a_pilot_are_his_own_matter_and_estimators_are_not():
    mind = uavlab.stack("F450")
    mind = mind._replace(pilot=Pair(mind.tracker, mind.controller))
    scenario = hover(Swap(0.1, "controller", "soft"), Swap(0.1, "estimator", "FixedPriority"))
    made = with_slots(scenario, mind)
    swappable(scenario, made)
    assert made.controller is mind.controller
    assert isinstance(made.estimator, EstimatorSlot)


def request(bank, name, seconds=1.2):
    """A bank on both receivers, asked in flight for one of them at 1 s."""
    scenario = uavlab.scenarios.load("gnss-to-rtk")
    rtk = scenario.sensors["rtk"]._replace(corrections_lost=(), refix=0.0)
    kit = {**scenario.sensors, "rtk": rtk}
    scenario = scenario._replace(
        sensors=kit, duration=seconds, swaps=(Swap(1.0, "estimator", name),)
    )
    return uavlab.fly(scenario, uavlab.stack("F450", bank, HeadingController))


@pytest.mark.flight
def test_a_bank_is_asked_for_a_filter_in_flight_and_the_request_stands():
    setup = chosen("gnss", "rtk")
    for part in (
        fill(BankEstimator, setup=setup, requests=((0.0, "gnss"),)).part,
        Vetted(fill(BankEstimator, setup=setup, requests=((0.0, "gnss"),)).part),
    ):
        log = request(part, "rtk")
        assert log.meta["swaps"] == [[1.0, "estimator", "rtk", "taken over"]]
        names = [log.worlds.names[k] for k in log.worlds.flies[[99, -1]]]
        assert names == ["gnss", "rtk"]


def test_a_bank_refuses_a_filter_that_is_not_reliable_and_one_that_it_has_not():
    bank = fill(BankEstimator, setup=chosen("gnss", "slam")).part
    here = START._replace(world="gnss")  # its filter has started
    memory = bank.init(here)
    with pytest.raises(BadInput, match="slam is not reliable now"):
        bank.swap(memory, "slam")
    with pytest.raises(UnknownName, match="no filter of the bank named 'rtk'"):
        bank.swap(memory, "rtk")
    assert bank.swap(memory, "").asked == ((0.0, ""),)
    assert bank.swap(bank.init(START), "slam").asked == ((0.0, "slam"),)  # nobody flies yet


def test_a_filter_of_the_bank_that_is_told_may_be_asked_for_and_of_no_other():
    banks = {k: fill(BankEstimator, setup=chosen(k, "slam")).part for k in ("gnss", "rtk")}
    slot = EstimatorSlot({"one": banks["gnss"], "two": banks["rtk"]})
    memory = slot.init(START)
    assert slot.swap(memory, "gnss").memories["one"].asked == ((0.0, "gnss"),)
    with pytest.raises(BadInput, match="rtk is no filter of one, which is told"):
        slot.swap(memory, "rtk")


def test_an_observer_hears_no_requests():
    log = uavlab.fly(
        hover(), uavlab.stack("F450", FixedPriority())
    )  # and a swap does not even take off
    assert "swaps" not in log.meta
    with pytest.raises(BadInput, match="the estimator is FixedPriority alone"):
        uavlab.fly(hover(Swap(0.1, "estimator", "rtk")), uavlab.stack("F450", FixedPriority()))
    with pytest.raises(BadInput, match="FixedPriority hears no requests"):
        Vetted(FixedPriority()).swap(Vetted(FixedPriority()).init(START), "rtk")
