"""A slot: whoever takes over is not felt, whoever cannot is refused; what nobody can obey does not take off."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

import uavlab
from uavlab.errors import BadInput, UnknownName
from uavlab.experiments.swaps import SOME, jumped
from uavlab.flight.fill import MINE, REFERENCE, fill
from uavlab.flight.log import UNITS
from uavlab.flight.scenario import Swap
from uavlab.flight.slot import Slot, slotted, swappable, with_slots
from uavlab.frames import Shift, moved
from uavlab.interfaces import standing_command
from uavlab.parts.controllers import Gains, HeadingController, TiltAxis
from uavlab.parts.missions import still
from uavlab.parts.trackers import CommandFilter, carried
from uavlab.so3 import about_z
from uavlab.types import Estimate, Trajectory

DT, MASS = 0.01, 1.7
ZERO = np.zeros(3)
HERE = Estimate(np.array((1.0, 2.0, 3.0)), np.array((0.5, 0.0, 0.1)), ZERO, about_z(0.3), ZERO)
GOAL = still(np.array((2.0, 2.0, 3.0)), 0.5)._replace(v=np.array((1.0, 0.0, 0.0)))
SHIFT = Shift(np.array((3.0, -2.0, 0.5)), 0.4)
LAWS = {"slack": TiltAxis(MASS), "stiff": TiltAxis(MASS, Gains(k_p=12.0))}
WAYS: Any = {"slow": CommandFilter(1.0), "quick": CommandFilter(4.0)}


@dataclass(frozen=True)
class Bad:
    """A controller that fails where it is told to."""

    slot: ClassVar[str] = "controller"
    where: str

    def init(self, estimate, last):
        if self.where == "init":
            raise RuntimeError("no memory left")
        return 0

    def step(self, memory, estimate, reference, dt):
        if self.where == "step":
            raise NotImplementedError("step is not finished yet")
        if self.where == "nothing":
            return memory, None
        bad = self.where == "nan" or (self.where == "second" and memory)
        command = standing_command(MASS)
        return memory + 1, command._replace(f_d=float("inf")) if bad else command

    def reframe(self, memory, shift):
        return memory


def stepped(slot, memory, *inputs, n=1):
    out: Any = None
    for _ in range(n):
        memory, out = slot.step(memory, *inputs, DT)
    return memory, out


# Taking over ------------------------------------------------------------------------------------------


def test_a_controller_that_takes_over_repeats_the_last_command_and_flies_on_by_its_own_law():
    slot = Slot(LAWS)
    memory, last = stepped(slot, slot.init(HERE, None), HERE, GOAL, n=5)
    memory = slot.swap(memory, "stiff", HERE)
    assert (memory.name, memory.asked) == ("slack", "stiff")
    memory, first = stepped(slot, memory, HERE, GOAL)
    assert (memory.name, memory.asked, memory.refused) == ("stiff", "", 0)
    for a, b in zip(first, last, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-12)
    _, later = stepped(slot, memory, HERE, GOAL, n=2000)
    alone = LAWS["stiff"]
    _, fresh = alone.step(alone.init(HERE, None), HERE, GOAL, DT)
    assert later.f_d == pytest.approx(fresh.f_d, abs=1e-6)


def test_a_tracker_that_takes_over_goes_on_where_the_last_reference_went():
    slot = Slot(WAYS)
    memory, last = stepped(slot, slot.init(HERE, None), HERE, GOAL, n=50)
    memory, first = stepped(slot, slot.swap(memory, "quick", HERE), HERE, None)
    there = carried(last, DT)
    np.testing.assert_allclose(first.r, there.r, atol=1e-12)
    np.testing.assert_allclose(first.v, there.v, atol=1e-12)
    assert memory.name == "quick"


def test_a_tracker_that_takes_over_is_told_the_goal_that_still_stands():
    slot = Slot(WAYS)
    memory, _ = stepped(slot, slot.init(HERE, None), HERE, GOAL)
    memory, _ = stepped(slot, memory, HERE, None, n=99)
    memory, _ = stepped(slot, slot.swap(memory, "quick", HERE), HERE, None, n=1000)
    np.testing.assert_allclose(memory.last.r, GOAL.r + 11.0 * GOAL.v, atol=1e-3)


def test_a_trajectory_that_was_given_once_goes_on_under_the_new_tracker():
    slot = Slot(WAYS)
    x = np.linspace(0.0, 20.0, 21)
    way = Trajectory(x, np.outer(x, (1.0, 0.0, 0.0)), np.zeros(21))
    memory, _ = stepped(slot, slot.init(HERE, None), HERE, way)
    memory, _ = stepped(slot, memory, HERE, None, n=99)
    memory, _ = stepped(slot, slot.swap(memory, "quick", HERE), HERE, None, n=900)
    np.testing.assert_allclose(memory.last.r, (10.0, 0.0, 0.0), atol=1e-3)


@pytest.mark.parametrize(("slot", "name"), [(Slot(LAWS), "stiff"), (Slot(WAYS), "quick")])
def test_a_world_that_changes_between_the_request_and_the_step_is_not_felt(slot, name):
    memory, _ = stepped(slot, slot.init(HERE, None), HERE, GOAL, n=5)
    asked = slot.swap(memory, name, HERE)
    there = slot.reframe(asked, SHIFT)
    _, out = stepped(slot, asked, HERE, GOAL, n=3)
    _, out_there = stepped(slot, there, moved(HERE, SHIFT), moved(GOAL, SHIFT), n=3)
    for a, b in zip(moved(out, SHIFT), out_there, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


# Refused ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("init", "bad: it raised RuntimeError: no memory left"),
        ("step", "bad: it raised NotImplementedError: step is not finished yet"),
        ("nothing", "bad: it gave NoneType, no Command"),
        ("nan", "bad: its f_d is inf"),
        ("second", "bad: its f_d is inf"),
    ],
)
def test_a_part_that_cannot_fly_is_refused_and_the_old_one_flies_on_as_if_nothing_was(where, said):
    slot = Slot({**LAWS, "bad": Bad(where)})
    memory, _ = stepped(slot, slot.init(HERE, None), HERE, GOAL)
    alone, wanted = stepped(slot, memory, HERE, GOAL)
    after, out = stepped(slot, slot.swap(memory, "bad", HERE), HERE, GOAL)
    assert (after.name, after.said, after.refused, after.asked) == ("slack", said, 1, "")
    assert after.memory == alone.memory
    np.testing.assert_array_equal(np.hstack(out), np.hstack(wanted))
    again = slot.swap(after, "stiff", HERE)
    assert (again.said, again.refused) == ("", 1)


def test_a_name_that_is_not_in_the_slot_is_answered_with_the_near_one():
    slot = Slot(LAWS)
    with pytest.raises(UnknownName, match=r"controller's slot named 'stif'.*'stiff'"):
        slot.swap(slot.init(HERE, None), "stif", HERE)
    with pytest.raises(UnknownName):
        Slot(LAWS, "soft")


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({}, "no parts"),
        ({"": TiltAxis(MASS)}, "named ''"),
        ({"a": TiltAxis(MASS), "b": CommandFilter()}, "'b' of a Slot is CommandFilter.*one Slot"),
        ({"a": 3}, "'a' of a Slot is int with slot None"),
        ({"a": uavlab.stack("F450").estimator}, "slot 'estimator'"),
    ],
)
def test_parts_that_do_not_belong_together_are_refused_by_name(parts, said):
    with pytest.raises(BadInput, match=said):
        Slot(parts)


# In flight --------------------------------------------------------------------------------------------


def flight(*swaps, seconds=0.5):
    return uavlab.scenarios.load("hover")._replace(duration=seconds, swaps=swaps)


def mind():
    laws = slotted({**LAWS, "bad": Bad("step"), "heading": fill(HeadingController, mass=MASS)})
    return uavlab.stack("F450", laws, slotted(WAYS))


def test_a_flight_swaps_at_its_times_and_its_log_says_who_flew(tmp_path):
    scenario = flight(
        Swap(0.3, "controller", "bad"), Swap(0.1, "controller", "stiff"), Swap(0.1, "tracker", "quick"),
    )  # fmt: skip
    log = uavlab.fly(scenario, mind())
    told = log.meta["swaps"]
    assert [x[:3] for x in told] == [
        [0.0, "tracker", "slow"], [0.0, "controller", "slack"], [0.1, "tracker", "quick"],
        [0.1, "controller", "stiff"], [pytest.approx(0.3), "controller", "bad"],
    ]  # fmt: skip
    assert [x[3] for x in told[:4]] == ["first", "first", "taken over", "taken over"]
    assert told[4][3].startswith("refused: bad: it raised NotImplementedError")
    assert log.exit.name == "DONE"
    assert uavlab.load_log(log.save(tmp_path / "swapped")).meta == log.meta


def test_who_wrote_which_part_of_a_slot_is_kept():
    kept = mind().provenance
    assert kept["slack.TiltAxis"] == MINE
    assert kept["heading.attitude_with_heading"] == REFERENCE


def test_a_slot_that_swaps_nothing_flies_as_its_part_alone():
    scenario = flight()
    one = uavlab.fly(scenario, uavlab.stack("F450", Slot({"only": TiltAxis(MASS)})), seed=3)
    other = uavlab.fly(scenario, uavlab.stack("F450", TiltAxis(MASS)), seed=3)
    assert all(np.array_equal(getattr(one, k), getattr(other, k)) for k in UNITS if k != "solve")
    assert "swaps" not in other.meta


@pytest.mark.parametrize(
    ("swap", "said"),
    [
        (Swap(0.1, "tracker", "fast"), "no part of the tracker's slot named 'fast'"),
        (Swap(-1.0, "tracker", "slow"), r"swaps\[0\].t is -1.0 s; it must be ≥ 0"),
        (Swap(float("nan"), "tracker", "slow"), r"swaps\[0\].t is nan"),
        (Swap(0.1, "estimator", "gnss"), r"the estimator is AlphaBetaGamma alone"),
    ],
)
def test_a_swap_that_nobody_can_obey_does_not_take_off(swap, said):
    with pytest.raises(BadInput, match=said):
        uavlab.fly(flight(swap), mind())


def test_a_mind_without_a_slot_is_told_where_one_is_missing():
    with pytest.raises(
        BadInput, match=r"the controller is TiltAxis alone. Put a uavlab.flight.slot"
    ):
        uavlab.fly(flight(Swap(0.1, "controller", "stiff")), uavlab.stack("F450"))


def test_two_swaps_of_one_slot_in_one_tick_are_refused():
    twice = Swap(0.1, "tracker", "quick"), Swap(0.101, "tracker", "slow")
    with pytest.raises(BadInput, match=r"swaps\[1\]: a second tracker"):
        uavlab.fly(flight(*twice), mind())


def test_a_plain_mind_gets_a_slot_for_the_parts_that_a_scenario_names():
    scenario = flight(Swap(0.1, "controller", "MpcController"), Swap(0.2, "controller", "TiltAxis"))
    made = with_slots(scenario, uavlab.stack("F450"))
    swappable(scenario, made)
    assert list(made.controller.parts) == ["TiltAxis", "MpcController"]
    assert made.provenance["MpcController.MpcController"] == REFERENCE
    assert isinstance(made.tracker, CommandFilter)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("MpcControler", "'hover', swaps of the controller: .*Did you mean 'MpcController'"),
        ("MpcTracker", "'hover', swaps of the controller: MpcTracker is a tracker"),
    ],
)
def test_a_part_that_nobody_knows_or_of_another_slot_is_refused_for_a_plain_mind(name, said):
    with pytest.raises(BadInput, match=said):
        with_slots(flight(Swap(0.1, "controller", name)), uavlab.stack("F450"))


@pytest.mark.flight
@pytest.mark.parametrize("swaps", [(), SOME], ids=["none", "five"])
def test_a_world_that_jumps_does_not_move_an_aircraft_with_slots_in_both_places(swaps):
    there, here = jumped(swaps)
    assert len(there.t) == len(here.t)
    assert np.linalg.norm(there.r - here.r, axis=1).max() < 1e-9
    assert np.linalg.norm(there.r_e - here.r_e, axis=1).max() > 3.0
