"""The laws that every part obeys (uavlab/interfaces.py), each part tested by being in the list."""

import copy
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from uavlab.flight.fill import fill
from uavlab.flight.slot import Slot
from uavlab.frames import Shift, compose, inverse, moved
from uavlab.gains import MpcGains, gain_group
from uavlab.limits import limit_group
from uavlab.orders import Land
from uavlab.parts.adaptive import AdaptiveController
from uavlab.parts.bank import BankEstimator, chosen, fused
from uavlab.parts.complementary import ComplementaryEstimator, CoupledEstimator
from uavlab.parts.controllers import Handover, HeadingController, TiltAxis
from uavlab.parts.emergency import Emergency
from uavlab.parts.errands import Errand
from uavlab.parts.estimator_slot import EstimatorSlot
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.failsafe import Failsafe
from uavlab.parts.landoff import LandOff
from uavlab.parts.line import LineTracker
from uavlab.parts.missions import Follow, InWorld, Waypoints, still
from uavlab.parts.paths import circle, lemniscate
from uavlab.parts.priority import FixedPriority
from uavlab.parts.speed import SpeedTracker
from uavlab.parts.throttle import ThrustCurve
from uavlab.parts.trackers import CommandFilter
from uavlab.parts.vetted import Vetted
from uavlab.so3 import exp
from uavlab.solutions.geometric import GeometricController
from uavlab.solutions.mpc import MpcController, MpcTracker
from uavlab.types import (
    Attitude,
    Command,
    Estimate,
    Field,
    Fix,
    Flow,
    Imu,
    Pose,
    Range,
    Reference,
)

MASS = 2.0
HEADING = fill(HeadingController, mass=MASS)
BANK = fill(BankEstimator, requests=((0.0, "gnss"), (0.02, "slam")))
ESTIMATORS = [
    AlphaBetaGamma(), AlphaBetaGamma(position="gnss"), FixedPriority(), BANK.part,
    fill(BankEstimator, setup=fused(chosen("gnss", "rtk"))).part,
    fill(ComplementaryEstimator, height="mocap").part, fill(CoupledEstimator).part,
    EstimatorSlot({"cameras": AlphaBetaGamma(), "bank": BANK.part, "map": AlphaBetaGamma("slam")}),
    EstimatorSlot({"bank": BANK.part, "satellites": AlphaBetaGamma("gnss")}), Vetted(BANK.part),
    Vetted(EstimatorSlot({"order": FixedPriority(), "bank": BANK.part}), age=0.02, repeats=1),
]  # fmt: skip
TRACKERS = [
    CommandFilter(), MpcTracker(limit_group("medium")), LandOff(2.0), LandOff(), LineTracker(),
    SpeedTracker(limit_group("medium")),
    SpeedTracker(limit_group("fast"), keeps_height=True, keeps_heading=False),
    Slot({"filter": CommandFilter(), "mpc": MpcTracker(limit_group("medium"))}),
]  # fmt: skip
CONTROLLERS = [
    TiltAxis(MASS), HEADING.part, fill(AdaptiveController, mass=MASS).part,
    GeometricController(MASS), GeometricController(MASS, gain_group("T650-sim-2020", "tight")),
    MpcController(MASS), MpcController(MASS, gains=MpcGains(follows=True)),
    Failsafe(MASS, ThrustCurve(0.16, -0.176)), Emergency(MASS),
    Slot({"heading": HEADING.part, "tilt": TiltAxis(MASS)}),
]  # fmt: skip
MISSIONS = [
    Waypoints(((0.0, (0.0, 0.0, 2.0), 0.3), (0.5, (1.0, 2.0, 3.0), -1.0))),
    Follow(circle(np.array([1.0, 2.0, 3.0]), 5.0), 1.4, 3.0),
    Follow(circle(np.zeros(3), 5.0), 1.4, 3.0, face=np.zeros(3)),
    Follow(lemniscate(np.zeros(3), 8.0, 4.0, 0.5), 0.8),
    InWorld(Follow(circle(np.zeros(3), 5.0), 1.4), "map"),
    InWorld(Follow(circle(np.zeros(3), 5.0), 1.4), "nowhere"),
    Errand((still(np.array([1.0, 2.0, 3.0]), 0.3), still(np.zeros(3)), Land())),
]
SHIFT = Shift(np.array([3.0, -2.0, 0.5]), 0.4)
DT = 0.01


def random_estimate(rng: np.random.Generator, tilt: float = 0.5) -> Estimate:
    return Estimate(
        rng.normal(size=3) * 5,
        rng.normal(size=3) * 2,
        rng.normal(size=3),
        exp(np.array([0, 0, rng.uniform(-3, 3)])) @ exp(rng.normal(size=3) * tilt / 2),
        rng.normal(size=3),
        worlds={"map": Shift(rng.normal(size=3), rng.uniform(-3, 3))},
    )


def random_reference(rng: np.random.Generator, near: Estimate) -> Reference:
    v, a, j = rng.normal(size=(3, 3))
    return Reference(near.r + rng.normal(size=3), v, a, j, rng.uniform(-3, 3), rng.normal())


def random_readings(rng: np.random.Generator, near: Estimate) -> dict[str, Any]:
    return {
        "imu": Imu(0.0, rng.normal(size=3), rng.normal(size=3)),
        "mocap": Pose(0.0, near.r + 0.01 * rng.normal(size=3), near.R),
        "gnss": Fix(0.0, near.r + rng.normal(size=3), near.v),
        "rtk": Fix(0.0, near.r + rng.normal(size=3), near.v, 0.02),
        "slam": Pose(0.0, rng.normal(size=3), exp(np.array([0, 0, rng.uniform(-3, 3)])) @ near.R),
        "ahrs": Attitude(0.0, exp(np.array([0, 0, rng.uniform(-3, 3)])) @ near.R),
        "magnetometer": Field(0.0, near.R.T @ np.array([0.1, 0.4, -0.9])),
        "flow": Flow(0.0, (near.R.T @ near.v)[:2]),
        "rangefinder": Range(0.0, abs(near.r[2]) / near.R[2, 2]),
    }


def told(readings: dict[str, Any], shift: Shift) -> dict[str, Any]:
    return {k: moved(x, shift) for k, x in readings.items()}


COMMAND = Command(MASS * 9.81, np.array([0.1, -0.2, 0.3]), np.array([0.5, 0.2, -0.1]))


class Case(NamedTuple):
    """A part, a memory, and inputs to step it with."""

    part: Any
    memory: Any
    inputs: tuple
    moved_inputs: tuple

    def step(self) -> tuple:
        return self.part.step(self.memory, *self.inputs, DT)


@cache  # of all parts at once: what a seed draws is drawn once, and no step may change it
def cases(seed: int) -> list[Case]:
    rng = np.random.default_rng(seed)
    found = []
    estimate = random_estimate(rng)
    there = moved(estimate, SHIFT)
    for part in ESTIMATORS:
        memory = part.init(estimate._replace(worlds={}))
        for k in range(seed % 4):  # from the first tick on, and behind a change of filters
            early = {n: x._replace(t=k * DT) for n, x in random_readings(rng, estimate).items()}
            memory, _ = part.step(memory, early, COMMAND, DT)
        readings = random_readings(rng, estimate)
        readings = {name: x._replace(t=(seed % 4) * DT) for name, x in readings.items()}
        inputs = (readings, COMMAND)
        other = (told(readings, SHIFT), moved(COMMAND, SHIFT))
        found.append(Case(part, memory, inputs, other))
    for part in TRACKERS:
        goal, last = random_reference(rng, estimate), random_reference(rng, estimate)
        other = (there, moved(goal, SHIFT))
        found.append(Case(part, part.init(estimate, last), (estimate, goal), other))
    for part in CONTROLLERS:
        x = random_reference(rng, estimate)
        memory = part.init(estimate, COMMAND)
        if rng.random() < 0.5:  # also in the middle of a hand-over
            memory, _ = part.step(memory, estimate, x, DT)
        found.append(Case(part, memory, (estimate, x), (there, moved(x, SHIFT))))
    for part in MISSIONS:
        memory, _ = part.step(part.init(estimate), estimate, 0.7)
        found.append(Case(part, memory, (estimate,), (there,)))
    return found


def same(a: Any, b: Any, atol: float = 0.0) -> bool:
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k], atol) for k in a)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y, atol) for x, y in zip(a, b, strict=True))
    if a is None or b is None:
        return a is b
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    return np.allclose(a, b, rtol=0, atol=atol, equal_nan=True)


def finite(x: Any) -> bool:
    if isinstance(x, dict):
        return all(map(finite, x.values()))
    if isinstance(x, tuple):
        return all(map(finite, x))
    return isinstance(x, str) or bool(np.isfinite(x).all())


NAMES = [f"{type(c.part).__name__}-{i}" for i, c in enumerate(cases(0))]
every_part = pytest.mark.parametrize("which", range(len(NAMES)), ids=NAMES)


def test_the_references_fly_in_the_heading_controller_that_the_laws_are_tested_on():
    assert set(HEADING.provenance.values()) == {"reference"}
    assert set(BANK.provenance.values()) == {"reference"}


@every_part
def test_a_step_twice_gives_the_same_and_leaves_its_inputs_alone(which):
    for seed in range(5):
        case = cases(seed)[which]
        before = copy.deepcopy((case.memory, case.inputs))
        assert same(case.step(), case.step())
        assert same(before, (case.memory, case.inputs))


@every_part
def test_a_step_and_a_change_of_world_may_be_swapped(which):
    for seed in range(10):
        case = cases(seed)[which]
        memory, out = case.step()
        other = case.part.reframe(case.memory, SHIFT)
        memory_b, out_b = case.part.step(other, *case.moved_inputs, DT)
        assert same(expected(case.part, out), out_b, 1e-9)
        assert same(case.part.reframe(memory, SHIFT), memory_b, 1e-9)


def expected(part: Any, out: Any) -> Any:
    """What comes out when all worlds are moved: of an estimator, those of its other hypotheses, too."""
    there = moved(out, SHIFT)
    if part not in ESTIMATORS:
        return there
    back = inverse(SHIFT)
    return there._replace(worlds={k: compose(s, back) for k, s in there.worlds.items()})


@every_part
def test_every_output_is_finite_over_the_envelope(which):
    for seed in range(50):
        case = cases(seed)[which]
        assert finite(case.step()[1])


@pytest.mark.parametrize("part", CONTROLLERS, ids=lambda p: type(p).__name__)
def test_a_controller_that_takes_over_repeats_the_last_command_and_then_lets_go(part):
    rng = np.random.default_rng(3)
    estimate = random_estimate(rng)
    reference = random_reference(rng, estimate)
    memory, first = part.step(part.init(estimate, COMMAND), estimate, reference, DT)
    assert same(first, COMMAND, 1e-12)
    for _ in range(2000):
        memory, later = part.step(memory, estimate, reference, DT)
    if isinstance(
        part, AdaptiveController | GeometricController | MpcController | Failsafe | Emergency
    ):  # it has learned meanwhile, or comes down: another command is right
        assert memory.handover == Handover(None, None)
        return
    _, fresh = part.step(part.init(estimate, None), estimate, reference, DT)
    assert same(later, fresh, 1e-6)


@pytest.mark.parametrize("part", TRACKERS, ids=lambda p: type(p).__name__)
def test_a_tracker_that_takes_over_repeats_the_last_reference(part):
    rng = np.random.default_rng(4)
    estimate = random_estimate(rng)
    last, goal = random_reference(rng, estimate), random_reference(rng, estimate)
    _, first = part.step(part.init(estimate, last), estimate, goal, DT)
    assert same(first[:3], last[:3], 1e-12)
    assert first.heading == last.heading


@pytest.mark.parametrize("part", ESTIMATORS, ids=lambda p: type(p).__name__)
def test_an_estimator_that_takes_over_continues_the_last_estimate(part):
    zero = np.zeros(3)
    last = random_estimate(np.random.default_rng(5))._replace(v=zero, a=zero, omega=zero)
    _, first = part.step(part.init(last), {}, COMMAND, DT)
    for name in ("r", "v", "R", "omega"):  # the acceleration may follow the command at once
        assert same(getattr(first, name), getattr(last, name), 1e-12)


def flown_reference(tracker: Any, dt: float) -> Reference:
    """Where the tracker is after a second of chasing a moving goal."""
    start = Estimate(np.zeros(3), np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3))
    goal = still(np.array([2.0, -1.0, 1.0]), 1.0)._replace(v=np.array([0.5, 0, 0]))
    memory = tracker.init(start, None)
    for k in range(round(1.0 / dt)):
        memory, _ = tracker.step(memory, start, goal if k == 0 else None, dt)
    return tracker.step(memory, start, None, dt)[1]


@pytest.mark.parametrize("part", TRACKERS, ids=lambda p: type(p).__name__)
def test_a_tracker_converges_when_its_step_is_halved(part):
    coarse, middle, fine = (flown_reference(part, dt).r for dt in (0.02, 0.01, 0.005))
    rounding = 1e-12  # of those that are exact at any step
    assert np.linalg.norm(fine - middle) < 0.7 * np.linalg.norm(middle - coarse) + rounding
    assert np.linalg.norm(fine - middle) < 0.05


def handed_over(part: Any, dt: float) -> float:
    """Thrust half a second after a hand-over."""
    rng = np.random.default_rng(6)
    estimate = random_estimate(rng)
    reference = random_reference(rng, estimate)
    memory = part.init(estimate, COMMAND)
    for _ in range(round(0.5 / dt) + 1):
        memory, command = part.step(memory, estimate, reference, dt)
    return command.f_d


@pytest.mark.parametrize("part", CONTROLLERS, ids=lambda p: type(p).__name__)
def test_a_hand_over_takes_the_same_time_at_any_rate(part):
    assert handed_over(part, 0.01) == pytest.approx(handed_over(part, 0.005), abs=1e-9)


def observed(dt: float) -> np.ndarray:
    """Position after a second of observing constant acceleration at a fixed rate of fixes."""
    part = AlphaBetaGamma()
    a = np.array([0.5, 0.0, -0.3])
    memory = part.init(Estimate(np.zeros(3), np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3)))
    every = round(0.02 / dt)
    for k in range(1, round(1.0 / dt) + 1):
        t = k * dt
        pose = {"mocap": Pose(t, a * t * t / 2, np.eye(3))} if k % every == 0 else {}
        memory, estimate = part.step(memory, pose, COMMAND, dt)
    return estimate.r


def test_an_estimator_gives_the_same_at_any_rate_when_the_fixes_are_the_same():
    assert observed(0.01) == pytest.approx(observed(0.005), abs=1e-9)
    assert observed(0.01) == pytest.approx(np.array([0.25, 0.0, -0.15]), abs=1e-3)
