"""Where the functions of a part come from, and that one is told."""

import builtins
import importlib
from dataclasses import dataclass

import numpy as np
import pytest

import uavlab
from uavlab.errors import BadInput, UnknownName
from uavlab.exercises import all_exercises, find
from uavlab.flight import fill as door
from uavlab.flight.fill import Filled, fill, stack, unfinished
from uavlab.limits import limit_group
from uavlab.parts.controllers import HeadingController, TiltAxis
from uavlab.parts.trackers import CommandFilter
from uavlab.types import Exit


def attitude_with_heading(f_d, heading_d):
    return np.eye(3)


def parasitic_yaw_rate(R, omega):
    raise NotImplementedError("parasitic_yaw_rate is not finished yet: write it.")


@dataclass(frozen=True)
class GeometricController(TiltAxis):
    """Somebody's own."""


class Written:
    """A lab's answer that is a whole part; a stand-in for the reference, so that no test hangs on it."""

    @staticmethod
    def part(mass=1.0, gains="soft"):
        return TiltAxis(mass)


@pytest.fixture
def without_solutions(monkeypatch):
    real = importlib.import_module

    def no_solutions(name, *rest):
        if name.startswith("uavlab.solutions"):
            raise ModuleNotFoundError(f"No module named {name!r}", name="uavlab.solutions")
        return real(name, *rest)

    monkeypatch.setattr(door.importlib, "import_module", no_solutions)


def test_mine_comes_first_then_the_reference_and_a_stub_does_not_count():
    part, provenance = fill(HeadingController, globals(), mass=1.0)
    assert provenance == {
        "attitude_with_heading": "mine",
        "yaw_rate_from_heading_rate": "reference",
        "parasitic_yaw_rate": "reference",
    }
    assert part.attitude_with_heading is attitude_with_heading


def test_a_reference_that_was_imported_is_not_called_mine():
    given = {"attitude_with_heading": door.reference("heading", "attitude_with_heading")}
    provenance = fill(HeadingController, given, mass=1.0).provenance
    assert provenance["attitude_with_heading"] == "reference"


@pytest.mark.usefixtures("without_solutions")
def test_without_the_solutions_the_stand_in_flies_and_says_so():
    part, provenance = fill(HeadingController, globals(), mass=1.5)
    assert part == TiltAxis(1.5)
    missing = "yaw_rate_from_heading_rate, parasitic_yaw_rate"
    assert provenance == {f"HeadingController without {missing}": "stand-in"}
    log = uavlab.fly(uavlab.scenarios.load("hover")._replace(duration=0.1))
    assert set(log.meta["provenance"].values()) == {"stand-in"}


def test_the_references_may_be_left_out():
    assert isinstance(fill(HeadingController, {}, only_mine=True, mass=1.0).part, TiltAxis)


def test_every_stub_that_a_student_gets_is_known_as_unfinished():
    for exercise in all_exercises():
        space = dict(vars(importlib.import_module(exercise.stub.__module__)))
        code = f"from __future__ import annotations\n{exercise.source()}"
        exec(compile(code, exercise.name, "exec"), space)
        assert unfinished(space[exercise.name]), exercise.name


def test_an_answer_that_is_only_partly_written_counts_as_one():
    def heading_rate(R, omega):
        if R is None:
            raise NotImplementedError("this is not finished yet")
        return len(R)

    assert not unfinished(heading_rate)
    assert not unfinished(builtins.len)


def test_a_spec_answers_nothing_but_that_it_is_unfinished():
    with pytest.raises(NotImplementedError, match="heading_rate is not finished yet"):
        find("heading_rate")(np.eye(3), np.zeros(3))


def test_a_stack_has_one_part_for_each_slot():
    mind = stack("F450", TiltAxis(1.0), CommandFilter(bandwidth=1.0))
    assert mind.tracker.bandwidth == 1.0
    assert mind.provenance["AlphaBetaGamma"] == "stand-in"
    assert mind.provenance["TiltAxis"] == "mine"
    with pytest.raises(BadInput, match="which is taken already"):
        stack("F450", TiltAxis(1.0), TiltAxis(2.0))
    with pytest.raises(BadInput, match="slot None"):
        stack("F450", Filled(object(), {}))


def test_a_part_is_told_the_mass_of_its_airframe():
    assert stack("T650", HeadingController).controller.mass == 3.5


# Parts that are answers as a whole -------------------------------------------------------------------


def unfinished_class():
    class GeometricController:
        slot = "controller"

        def step(self, memory, estimate, reference, dt):
            raise NotImplementedError("GeometricController is not finished yet: write it.")

    return GeometricController


@pytest.fixture
def with_answers(monkeypatch):
    """The reference of every part is a part that can be told from others."""
    monkeypatch.setattr(door, "reference", lambda _stem, _name: CommandFilter)


def test_a_name_is_found_in_mine_then_in_the_solutions_then_the_stand_in_flies(monkeypatch):
    own = fill("GeometricController", globals(), mass=2.0)
    assert own == (GeometricController(2.0), {"GeometricController": "mine"})
    monkeypatch.setattr(door, "reference", lambda _stem, _name: Written.part)
    stub = {"GeometricController": unfinished_class()}
    assert fill("GeometricController", stub, mass=2.0).provenance == {
        "GeometricController": "reference"
    }
    given_as_class = fill(stub["GeometricController"], mass=2.0)
    assert given_as_class.provenance == {"GeometricController": "reference"}
    alone = fill("GeometricController", stub, only_mine=True, mass=2.0, gains="tight")
    assert alone == (TiltAxis(2.0), {"GeometricController": "stand-in"})


@pytest.mark.usefixtures("without_solutions")
def test_a_stack_by_names_flies_stand_ins_where_nothing_is_installed():
    mind = stack("T650", "MpcController", "MpcTracker", mine={})
    assert mind.controller == TiltAxis(3.5)
    assert mind.tracker == CommandFilter()
    assert mind.provenance == {
        "MpcController": "stand-in",
        "MpcTracker": "stand-in",
        "AlphaBetaGamma": "stand-in",
    }


@pytest.mark.usefixtures("with_answers")
def test_names_and_classes_share_the_slots_of_a_stack():
    mind = stack("T650", "GeometricController", "MpcTracker", mine=globals())
    assert mind.controller == GeometricController(3.5)
    assert mind.provenance["GeometricController"] == "mine"
    assert mind.provenance["MpcTracker"] == "reference"
    with pytest.raises(BadInput, match="which is taken already"):
        stack("T650", GeometricController, "GeometricController", mine=globals())


def test_a_class_that_is_given_is_told_the_mass_and_called_by_its_author(monkeypatch):
    assert stack("T650", GeometricController).controller == GeometricController(3.5)
    assert fill(GeometricController, mass=1.0).provenance == {"GeometricController": "mine"}
    monkeypatch.setattr(GeometricController, "__module__", "uavlab.solutions.geometric")
    assert fill(GeometricController, mass=1.0).provenance == {"GeometricController": "reference"}
    assert stack("T650", GeometricController(1.0)).provenance["GeometricController"] == "reference"


def test_a_wrong_name_or_parameter_is_told_with_what_there_is():
    with pytest.raises(UnknownName, match="Did you mean 'MpcTracker'"):
        fill("MpcTraker")
    with pytest.raises(
        UnknownName, match=r"Known: .*GeometricController, .*MpcController, MpcTracker"
    ):
        stack("T650", "Autopilot")
    with pytest.raises(BadInput, match=r"takes mass, gains; got an unexpected .* 'gain'"):
        fill("GeometricController", globals(), mass=1.0, gain=2.0)
    with pytest.raises(BadInput, match="give mass"):
        fill("GeometricController", {}, only_mine=True)


def test_a_part_without_limits_of_its_own_gets_those_of_a_usual_group():
    @dataclass(frozen=True)
    class MpcTracker(CommandFilter):
        limits: object = None

        def __init__(self, limits):
            object.__setattr__(self, "limits", limits)

    limits = pytest.importorskip("uavlab.limits")
    part, provenance = fill("MpcTracker", {"MpcTracker": MpcTracker})
    assert part.limits == limits.limit_group("medium")
    assert provenance == {"MpcTracker": "mine"}


@pytest.mark.flight
@pytest.mark.parametrize("airframe", ["F450", "T650"])
def test_the_force_mpc_takes_off_and_lands_on_a_light_aircraft_and_on_a_heavy_one(airframe):
    scenario = uavlab.scenarios.load("takeoff")._replace(airframe=airframe)
    log = uavlab.fly(scenario, uavlab.stack(airframe, "MpcController", "MpcTracker"))
    assert log.exit is Exit.DONE, log.reason
    assert abs(log.r[500, 2] - log.r_d[500, 2]) < 0.3


def test_a_tracker_by_name_keeps_to_half_of_what_an_mpc_controller_may_do():
    behind_mpc = stack("T650", "MpcController", "MpcTracker").tracker.limits
    assert behind_mpc.horizontal[:2] == (1.0, 1.0)
    assert behind_mpc.up[:2] == behind_mpc.down[:2] == (1.0, 1.0)
    assert behind_mpc.horizontal.j == limit_group("medium").horizontal.j
    assert stack("T650", "GeometricController", "MpcTracker").tracker.limits == limit_group(
        "medium"
    )
    told = fill("MpcTracker", limits=limit_group("fast"))
    assert stack("T650", "MpcController", told).tracker.limits == limit_group("fast")
