"""Which parts fly: those that are wanted and allowed; of those that fail, none."""

from dataclasses import replace

import numpy as np
import pytest
from ghost import PARTS, Fails, Ghost, believing

import uavlab
from uavlab.errors import BadInput
from uavlab.limits import ForceLimits, half_of, limit_group
from uavlab.managers.groups import ALLOWED, OTHERS, Allowed, checked, fallback, fitting, split
from uavlab.managers.pilot import SafePilot
from uavlab.orders import EmergencyLand, TakeOff, Use
from uavlab.parts.missions import still
from uavlab.solutions.mpc import MpcTracker
from uavlab.solvers import unsolved

GOAL = still(np.array((3.0, 0.0, 2.0)))


def kinds(ghost):
    return ghost.said("tracker", "controller", "gains", "limits")[4:]  # behind the first ones


# Groups -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("world", "limits", "gains"),
    [("gnss", "fast", "tight"), ("rtk", "fast", "tight"), ("flow", "slow", "soft"),
     ("slam", "slow", "soft"), ("flow+slam", "slow", "soft"), ("lidar", "slow", "supersoft")],
)  # fmt: skip
def test_groups_that_are_not_allowed_in_the_world_that_flies_give_way_to_its_default(
    world, limits, gains
):
    ghost = Ghost("GeometricController", "MpcTracker")
    ghost.fly(0.1, Use("limits", "fast"), Use("gains", "tight"))
    assert ghost.flies == ("MpcTracker fast", "GeometricController tight")
    ghost.fly(0.1, world=world)
    assert ghost.flies == (f"MpcTracker {limits}", f"GeometricController {gains}")
    new = [x for x in ghost.said("limits", "gains") if x[2] == "taken over"][2:]
    fell = [("limits", limits, "taken over"), ("gains", gains, "taken over")]
    assert new == ([] if limits == "fast" else fell)


def test_a_group_that_is_allowed_in_the_new_world_is_kept_although_it_is_not_its_default():
    ghost = Ghost().fly(0.1, Use("limits", "slow")).fly(0.1, world="gnss")
    assert ghost.flies[0] == "CommandFilter slow"


@pytest.mark.parametrize(
    ("order", "said"),
    [
        (Use("limits", "fast"), "'fast' is not allowed in the world 'flow'; slow, medium are."),
        (Use("gains", "tight"), "'tight' is not allowed in the world 'flow'"),
        (Use("limits", "quick"), "no group of limits aboard named 'quick'"),
        (Use("tracker", "CommandFilter fast"), "'fast' is not allowed"),
        (Use("tracker", "CommandFilterr"), "Did you mean 'CommandFilter'"),
        (Use("tracker", "SpeedTracker"), "no tracker named"),
        (Use("controller", "Emergency"), "no controller named"),
    ],
)
def test_what_is_not_aboard_or_not_allowed_is_refused_with_the_reason(order, said):
    ghost = Ghost("CommandFilter", start=believing(world="flow"))
    ghost.fly(0.1)
    before = ghost.flies
    ghost.fly(0.1, order)
    [(kind, name, why)] = [x for x in ghost.said(order.slot) if x[2].startswith("refused")]
    assert (kind, name) == order[:2]
    assert said in why
    assert ghost.flies == before


def test_another_slot_is_no_slot():
    ghost = Ghost().fly(0.1, Use("engine", "V8"))
    assert "no slot named 'engine'" in ghost.said("refused")[0][2]


def test_behind_an_mpc_controller_the_tracker_keeps_to_half_of_what_that_may_do():
    ghost = Ghost("GeometricController", "MpcTracker", gains="soft").fly(
        0.1, Use("controller", "MpcController")
    )
    assert ghost.flies == ("MpcTracker medium half", "MpcController")
    part = ghost.pilot.trackers.parts["MpcTracker medium half"]
    assert part == MpcTracker(half_of(ForceLimits(), limit_group("medium")))
    ghost.fly(0.1, Use("limits", "fast"))
    assert ghost.flies[0] == "MpcTracker fast half"
    ghost.fly(0.1, Use("controller", "GeometricController"))
    assert ghost.flies == ("MpcTracker fast", "GeometricController soft")


def test_the_line_tracker_keeps_its_own_pace():
    ghost = Ghost("MpcTracker").fly(0.1, Use("tracker", "LineTracker"), Use("limits", "slow"))
    assert ghost.flies[0] == "LineTracker"
    ghost.fly(0.1, Use("tracker", "MpcTracker"))
    assert ghost.flies[0] == "MpcTracker slow"


def test_what_is_asked_for_on_the_ground_flies_when_it_is_up():
    ghost = Ghost(ground=True).fly(0.1, Use("limits", "slow"), Use("controller", "MpcController"))
    ghost.fly(8.0, TakeOff(1.0))
    assert ghost.report.mode == "flying"
    assert ghost.flies == ("CommandFilter slow half", "MpcController")


def test_a_part_by_name_and_group_is_both():
    assert split("MpcTracker slow", ("slow", "fast")) == ("MpcTracker", "slow")
    assert split("MpcTracker slow half", ("slow", "fast")) == ("MpcTracker", "slow")
    assert split("SpeedTracker z", ("slow", "fast")) == ("SpeedTracker z", "")
    assert fitting({"A slow": 0, "A": 0}, "A", "slow", half=True) == "A slow"
    assert fitting({"A": 0}, "A", "slow") == "A"


def test_a_fallback_for_which_there_is_no_part_is_not_chosen():
    table = {OTHERS: Allowed(("slow", "medium"), ("soft",), "slow", "soft")}
    assert fallback(table, "gnss", "limits", "fast", ("medium", "fast")) == "medium"
    assert fallback(table, "gnss", "limits", "fast", ()) == "fast"


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"gnss": ALLOWED["gnss"]}, r"no '\*'"),
        ({OTHERS: ALLOWED["flow"]._replace(default_limits="fast")}, "default_limits is 'fast'"),
    ],
)
def test_a_table_that_leaves_a_world_without_an_answer_is_none(table, said):
    with pytest.raises(BadInput, match=said):
        checked(table)


# Parts that fail --------------------------------------------------------------------------------------


@pytest.mark.parametrize("how", ["raises", "nan"])
@pytest.mark.parametrize("slot", ["tracker", "controller"])
def test_a_part_that_fails_is_landed_from_at_once_without_it(slot, how):
    other = PARTS[slot == "tracker"]
    ghost = Ghost(Fails(slot, how), other).fly(0.1)
    assert ghost.report.mode == "flying"
    ghost.fly(1.0, GOAL)
    assert ghost.report.mode == "emergency"
    assert ghost.flies == ("LandOff emergency", "Emergency")
    [(_, trigger, why)] = ghost.said("safety")
    assert trigger == slot
    assert "Fails" in why
    assert all(np.isfinite(x).all() for ref in ghost.references for x in ref)


def test_a_stub_that_nobody_has_finished_is_no_failure_in_flight():
    ghost = Ghost(Fails("controller", "unfinished"), "CommandFilter")
    with pytest.raises(NotImplementedError, match="not finished"):
        ghost.fly(1.0)


@pytest.mark.parametrize("slot", ["tracker", "controller"])
@pytest.mark.parametrize("how", ["raises", "nan"])
def test_who_fails_in_an_emergency_too_leaves_it_to_the_failsafe(slot, how):
    ghost = Ghost()
    field = f"{slot}s"
    names = {"tracker": "LandOff emergency", "controller": "Emergency"}
    parts = {**getattr(ghost.pilot, field).parts, names[slot]: Fails(slot, how, after=20)}
    ghost.pilot = replace(ghost.pilot, **{field: replace(getattr(ghost.pilot, field), parts=parts)})
    ghost.fly(0.2).fly(1.0, EmergencyLand("a test"))
    assert [x[1] for x in ghost.said("mode")] == ["flying", "emergency", "failsafe"]
    assert [x[1] for x in ghost.said("safety")] == ["asked for", slot]


@pytest.mark.parametrize("slot", ["tracker", "controller"])
def test_an_emergency_that_cannot_even_begin_is_a_fall(slot):
    ghost = Ghost()
    field, name = f"{slot}s", {"tracker": "LandOff emergency", "controller": "Emergency"}[slot]
    parts = {**getattr(ghost.pilot, field).parts, name: Fails(slot, "raises", after=0)}
    ghost.pilot = replace(ghost.pilot, **{field: replace(getattr(ghost.pilot, field), parts=parts)})
    ghost.fly(0.2).tick(EmergencyLand("a test"))
    assert ghost.report.mode == "failsafe"


def test_a_part_that_is_asked_for_and_cannot_fly_is_refused_and_not_asked_for_again():
    ghost = Ghost("CommandFilter", "TiltAxis", Fails("controller", "raises", after=0))
    ghost.fly(0.5, Use("controller", "Fails")).fly(0.5, Use("limits", "slow"))
    [(_, name, why)] = [x for x in ghost.said("controller") if x[2].startswith("refused")]
    assert name == "Fails"
    assert "out of order" in why
    assert ghost.flies == ("CommandFilter slow", "TiltAxis")
    assert ghost.report.mode == "flying"


def test_who_finds_no_plan_to_begin_with_does_not_take_over():
    ghost = Ghost("CommandFilter", "TiltAxis").fly(0.5, GOAL)
    with unsolved():
        ghost.fly(0.5, Use("tracker", "MpcTracker")).fly(0.5, Use("controller", "MpcController"))
    assert ghost.flies == ("CommandFilter medium", "TiltAxis")
    refused = [x for x in ghost.said("tracker", "controller") if x[2].startswith("refused")]
    assert [x[1] for x in refused] == ["MpcTracker medium", "MpcController"]
    assert all("it finds no plan to begin with" in x[2] for x in refused)
    ghost.fly(0.5, Use("tracker", "MpcTracker"), Use("controller", "MpcController"))
    assert ghost.flies == ("MpcTracker medium half", "MpcController")


# What a pilot is made of ------------------------------------------------------------------------------


def test_a_pilot_without_a_part_that_it_needs_is_none():
    pilot = uavlab.piloted("T650", *PARTS).pilot
    assert isinstance(pilot, SafePilot)
    left = {k: v for k, v in pilot.trackers.parts.items() if k != "LandOff"}
    with pytest.raises(BadInput, match="missing: LandOff"):
        replace(pilot, trackers=replace(pilot.trackers, parts=left))
    for change, said in (
        ({"lifts": "Nobody"}, "lifts or lands"), ({"mass": 100.0}, "hover"),
        ({"unsteered": 0.0}, "unsteered"), ({"trackers": pilot.controllers}, "trackers"),
    ):  # fmt: skip
        with pytest.raises(BadInput, match=said):
            replace(pilot, **change)
