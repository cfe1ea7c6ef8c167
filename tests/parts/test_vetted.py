"""What is no measurement of now is not handed on, and an estimate that nothing stands behind says so."""

from typing import Any, ClassVar

import numpy as np
import pytest

import uavlab
from uavlab.errors import BadInput
from uavlab.frames import Shift, moved
from uavlab.parts.controllers import HeadingController
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.priority import FixedPriority
from uavlab.parts.vetted import Vetted
from uavlab.types import Attitude, Bearings, Command, Estimate, Exit, Fix, Flow, Height, Imu, Pose

DT = 0.01
ZERO = np.zeros(3)
START = Estimate(np.array((1.0, 2.0, 3.0)), ZERO, ZERO, np.eye(3), ZERO)
COMMAND = Command(17.0, ZERO, ZERO)


class Listens:
    """An estimator that remembers what was handed on."""

    slot: ClassVar[str] = "estimator"

    def init(self, estimate):
        return ()

    def step(self, memory, readings, command, dt):
        return tuple(sorted(readings)), START

    def reframe(self, memory, shift):
        return memory

    def hypotheses(self, memory):
        return {}


def pose(t, r=START.r):
    return Pose(t, np.asarray(r, dtype=float), np.eye(3))


def fed(*readings, part=None):
    """Memory and estimate after these readings, one mapping for each tick."""
    part = part or Vetted(Listens())
    memory, out = part.init(START), None
    for x in readings:
        memory, out = part.step(memory, x, COMMAND, DT)
    return memory, out


def wandering(n, first=1):
    """Poses that are never twice the same, one for each tick."""
    return [{"mocap": pose(k * DT, START.r + 1e-3 * k)} for k in range(first, first + n)]


# What is dropped --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "reading", "said"),
    [
        ("mocap", pose(0.01, (np.nan, 0, 0)), "its r is not finite"),
        ("imu", Imu(0.01, ZERO, np.array((0, np.inf, 0))), "its gyro is not finite"),
        ("barometer", Height(0.01, float("nan")), "its z is not finite"),
        ("barometer", Height(float("nan"), 1.0), "its t is not finite"),
        ("ahrs", Attitude(0.01, np.full((3, 3), np.nan)), "its R is not finite"),
    ],
)
def test_a_reading_that_is_not_finite_is_not_handed_on(name, reading, said):
    other = "mocap" if name != "mocap" else "slam"
    memory, _ = fed({name: reading, other: pose(0.01)})
    assert memory.inner == (other,)
    assert Vetted(Listens()).dropped(memory) == {name: said}


def test_the_same_values_are_dropped_when_they_come_for_the_fifth_time_again_and_taken_when_they_move():
    frozen = [{"mocap": pose(k * DT)} for k in range(1, 6)]
    memory, _ = fed(*frozen)
    assert memory.inner == ("mocap",)
    memory, _ = fed(*frozen, {"mocap": pose(0.06)})
    assert memory.inner == ()
    assert memory.why == {"mocap": "it is frozen: the same values 5 times again"}
    memory, _ = fed(*frozen, {"mocap": pose(0.06)}, {"mocap": pose(0.07, START.r + 1e-9)})
    assert memory.inner == ("mocap",)
    assert memory.why == {}


def test_a_slow_instrument_that_is_frozen_is_found_by_its_readings_and_not_by_the_ticks():
    ticks = [{"gnss": Fix(k * DT, START.r, ZERO)} if k % 10 == 0 else {} for k in range(1, 60)]
    assert fed(*ticks[:50])[0].why == {}
    memory, _ = fed(*ticks, {"gnss": Fix(0.6, START.r, ZERO)})
    assert "frozen" in memory.why["gnss"]


@pytest.mark.parametrize(("late", "taken"), [(0.49, True), (0.51, False), (-0.51, False)])
def test_a_reading_older_than_half_a_second_is_dropped_and_so_is_one_from_the_future(late, taken):
    t = 100 * DT
    memory, _ = fed(*wandering(99), {"imu": Imu(t, ZERO, ZERO), "gnss": Fix(t - late, ZERO, ZERO)})
    assert memory.inner == (("gnss", "imu") if taken else ("imu",))
    if not taken:
        assert memory.why["gnss"].endswith("at most 0.5 s are taken")


def test_time_goes_on_when_nothing_arrives_so_that_what_comes_late_is_known_to_be_old():
    memory, _ = fed(*wandering(1), *[{}] * 60, {"gnss": Fix(0.02, ZERO, ZERO)})
    assert memory.why == {"gnss": "it is 0.60 s old; at most 0.5 s are taken"}


def test_a_clock_that_is_wrong_by_years_does_not_make_all_others_old():
    bad = {"gnss": Fix(1e9, ZERO, ZERO)}
    memory, _ = fed(*wandering(5), {**wandering(1, 6)[0], **bad}, *wandering(1, 7))
    assert memory.inner == ("mocap",)
    assert set(memory.why) == {"gnss"}


def test_what_may_be_nan_or_constant_is_handed_on():
    unseen = np.array(((np.nan,) * 3, (0.0, 0.0, -1.0)))
    memory, _ = fed({"bearings": Bearings(0.01, unseen), "sectors": (1.0, float("inf")), "x": 3})
    assert memory.inner == ("bearings", "sectors", "x")
    memory, _ = fed(*({"state": START} for _ in range(9)))
    assert memory.inner == ("state",)


# Reliable ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "reading",
    [
        lambda t: pose(t, (t, 0, 0)), lambda t: Fix(t, np.full(3, t), ZERO), lambda t: START,
        lambda t: Flow(t, np.full(2, t)), lambda t: Bearings(t, np.full((1, 3), t)),
    ],
)  # fmt: skip
def test_half_a_second_without_a_place_and_the_estimate_is_not_reliable_until_there_is_one(reading):
    heard = {"it": reading(0.01)}
    assert fed(heard, *[{}] * 50)[1].reliable
    assert not fed(heard, *[{}] * 51)[1].reliable
    assert fed(heard, *[{}] * 51, {"it": reading(0.53)})[1].reliable


def test_an_instrument_that_measures_no_place_does_not_make_an_estimate_reliable():
    heights = [{"barometer": Height(k * DT, 1e-3 * k)} for k in range(1, 60)]
    assert not fed(*heights)[1].reliable


def test_a_frozen_instrument_is_as_good_as_none():
    _, out = fed(*({"mocap": pose(k * DT)} for k in range(1, 100)))
    assert not out.reliable


def test_an_estimator_that_does_not_trust_itself_is_believed():
    part = Vetted(AlphaBetaGamma())
    assert not fed(*[{}] * 31, part=part)[1].reliable


# As a part --------------------------------------------------------------------------------------------


def test_what_is_remembered_of_a_frozen_instrument_moves_with_the_world():
    part = Vetted(Listens())
    memory, _ = fed(*({"mocap": pose(k * DT)} for k in range(1, 6)))
    shift = Shift(np.array((3.0, -2.0, 0.5)), 0.4)
    there = part.reframe(memory, shift)
    _, here = part.step(memory, {"mocap": pose(0.06)}, COMMAND, DT)
    memory, _ = part.step(there, {"mocap": moved(pose(0.06), shift)}, COMMAND, DT)
    assert "frozen" in memory.why["mocap"]
    assert here is not None


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"estimator": 3}, "Vetted takes an estimator; got int"),
        ({"estimator": AlphaBetaGamma(), "age": 0.0}, "age is 0.0 s"),
        ({"estimator": AlphaBetaGamma(), "age": float("inf")}, "age is inf s"),
        ({"estimator": AlphaBetaGamma(), "repeats": 0}, "repeats is 0"),
    ],
)
def test_what_cannot_vet_is_refused(how, said):
    with pytest.raises(BadInput, match=said):
        Vetted(**how)


class Stuck:
    """Cameras that send the same pose again and again for a while."""

    def __init__(self, inner, start, end):
        self.inner, self.start, self.end = inner, start, end

    def init(self, rng):
        return self.inner.init(rng), None

    def step(self, memory, world, dt, rng):
        inner, kept = memory
        inner, reading = self.inner.step(inner, world, dt, rng)
        if reading is not None and self.start <= world.t < self.end:
            kept = kept or reading
            return (inner, kept), kept._replace(t=reading.t)
        return (inner, None), reading


def stuck(estimator):
    """A flight to the side on GNSS behind cameras that hang from 1 s to 4 s."""
    scenario = uavlab.scenarios.load("gusts")._replace(duration=4.0)
    kit = {**scenario.sensors, "mocap": Stuck(scenario.sensors["mocap"], 1.0, 4.0)}
    mind = uavlab.stack("F450", estimator, HeadingController)
    return uavlab.fly(scenario._replace(sensors=kit), mind)


@pytest.mark.flight
def test_cameras_that_hang_throw_an_aircraft_off_course_unless_somebody_vets_them():
    """Behind a vetted one, the next instrument in the order is heard."""
    plain = stuck(FixedPriority())
    vetted: Any = stuck(Vetted(FixedPriority()))
    away = [np.linalg.norm(x.r - x.r[0], axis=1).max() for x in (plain, vetted)]
    assert vetted.exit is Exit.DONE
    assert away[0] > 2.0 * away[1]


@pytest.mark.flight
def test_an_estimator_that_gets_good_readings_flies_the_same_when_vetted():
    scenario = uavlab.scenarios.load("step")._replace(duration=2.0)
    minds = [uavlab.stack("T650", x) for x in (AlphaBetaGamma(), Vetted(AlphaBetaGamma()))]
    a, b = (uavlab.fly(scenario, mind) for mind in minds)
    assert np.array_equal(a.r, b.r)
