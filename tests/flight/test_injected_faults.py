"""Faults: until one begins the flight is what it was, to the last bit; then it does what its line says."""

import tomllib
from dataclasses import dataclass, field
from math import inf, isnan
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import uavlab
from uavlab.errors import BadInput
from uavlab.flight.broken import broken
from uavlab.flight.fault import KINDS, Fault
from uavlab.flight.injected import Injected
from uavlab.flight.log import UNITS
from uavlab.flight.scenario import Scenario, Swap, checked, standing
from uavlab.flight.slot import Slot, slotted
from uavlab.managers.pair import Pair
from uavlab.parts.controllers import Gains, TiltAxis
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.landoff import LandOff
from uavlab.parts.missions import Fly, Waypoints, still
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import Wind, load_airframe
from uavlab.sensors import carry, laboratory
from uavlab.types import Estimate, Trajectory

G, DT = 9.81, 0.01
F450 = load_airframe("F450")
HERE, GOAL = Estimate(*np.zeros((3, 3)), np.eye(3), np.zeros(3)), still(np.ones(3))
FLOWN = [k for k in UNITS if k != "solve"]


@dataclass(frozen=True)
class Witness:
    """An estimator that writes down what reaches it."""

    slot: ClassVar[str] = "estimator"
    inner: Any = field(default_factory=AlphaBetaGamma)
    seen: list = field(default_factory=list)  # readings, step by step

    def init(self, estimate):
        return self.inner.init(estimate)

    def step(self, memory, readings, command, dt):
        self.seen.append(readings)
        return self.inner.step(memory, readings, command, dt)

    def reframe(self, memory, shift):
        return self.inner.reframe(memory, shift)

    def hypotheses(self, memory):
        return {}

    def of(self, name):
        """What arrived of one instrument: (tick, reading)."""
        return [(k + 1, x[name]) for k, x in enumerate(self.seen) if name in x]


def scenario(*faults, seconds=1.0, **changes):
    hover = uavlab.scenarios.load("hover")
    return hover._replace(duration=seconds, faults=faults, **changes)


def flown(*faults, mind=None, seed=3, **changes):
    return uavlab.fly(scenario(*faults, **changes), mind, seed=seed)


def same_until(one, other, k):
    """Whether two flights are the same to the last bit in their first `k` ticks, and no more two ticks later."""

    def same(rows):
        return all(
            np.array_equal(getattr(one, x)[rows], getattr(other, x)[rows], equal_nan=True)
            for x in FLOWN
        )

    return same(slice(0, k)) and not same(slice(k, k + 3))


def readings(*faults, sensors=None, seconds=1.0):
    """What reaches an estimator with these faults, and without: of a flight in which nobody else listens to them."""
    given = []
    for some in (faults, ()):
        witness = Witness()
        mind = uavlab.stack("F450")._replace(estimator=witness)
        sensors = sensors or carry("imu", "mocap", "gnss", "flow", "barometer", "ahrs", "bearings")
        flown(*some, mind=mind, sensors=sensors, seconds=seconds)
        given.append(witness)
    return given


# Until it begins --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "fault",
    [
        Fault("lost", 0.3, what="mocap"),
        Fault("frozen", 0.3, what="mocap"),
        Fault("jump", 0.3, what="mocap", value=(1.0, 0, 0)),
        Fault("bias", 0.3, what="mocap", value=1.0),
        Fault("late", 0.3, what="mocap", value=0.05),
        Fault("nan", 0.3, 0.31),
        Fault("part", 0.3, what="controller", value="nan"),
        Fault("motor", 0.3, what="1", value=0.7),
        Fault("battery", 0.3, 0.6, value=0.9),
        Fault("gust", 0.3, 0.6, value=(3, 0, 0)),
    ],
    ids=lambda x: x.kind,
)
def test_until_a_fault_begins_the_flight_is_the_same_to_the_last_bit(fault):
    assert same_until(flown(fault), flown(), 30)


def test_a_link_a_programme_and_a_load_change_nothing_before_their_time():
    way = Waypoints(((0.0, (0, 0, 2), 0.0), (0.2, (1, 0, 2), 0.0), (0.5, (2, 0, 2), 0.0)))
    heard = flown(mission=way)
    assert same_until(flown(Fault("link", 0.5), mission=way), heard, 50)
    plans = uavlab.stack("F450", "MpcController", "MpcTracker")
    planned = flown(mind=plans, mission=way)
    assert same_until(flown(Fault("solver", 0.5), mind=plans, mission=way), planned, 50)
    carried = flown(Fault("payload", inf, value=0.3))
    assert same_until(flown(Fault("payload", 0.5, value=0.3)), carried, 51)


def test_a_fault_takes_no_chance_from_the_others():
    """What is not broken reads what it would read: the first tick of a loss changes no other instrument."""
    broken, whole = readings(Fault("lost", 0.3, what="gnss"))
    for name in ("imu", "barometer", "flow"):
        for (_, a), (_, b) in zip(broken.of(name), whole.of(name), strict=True):
            assert np.array_equal(np.hstack(a), np.hstack(b))


@pytest.mark.flight
def test_the_same_seed_gives_the_same_flight_whatever_breaks():
    faults = (
        Fault("late", 0.2, 0.6, "mocap", 0.03), Fault("bias", 0.1, what="imu.gyro", value=0.5),
        Fault("motor", 0.5, what="2", value=0.8), Fault("gust", 0.0, 1.0, value=(3, 1, 0)),
        Fault("battery", 0.1, 0.9, value=0.9), Fault("payload", 0.7, value=0.2),
    )  # fmt: skip
    one, two = flown(*faults), flown(*faults)
    assert all(np.array_equal(getattr(one, k), getattr(two, k)) for k in FLOWN)
    assert not np.array_equal(flown(*faults, seed=4).r, one.r)


# Instruments ------------------------------------------------------------------------------------------


def test_nothing_arrives_of_a_lost_instrument_until_it_is_whole_again():
    broken, whole = readings(Fault("lost", 0.3, 0.7, "mocap"))
    arrived = [k for k, _ in broken.of("mocap")]
    assert arrived == [k for k, _ in whole.of("mocap") if not 30 <= k < 70]


def test_a_frozen_instrument_tells_old_values_with_new_times():
    broken, whole = readings(Fault("frozen", 0.3, 0.7, "barometer"))
    last = max(k for k, _ in whole.of("barometer") if k < 30)
    frozen = dict(whole.of("barometer"))[last].z
    for (k, got), (_, true) in zip(broken.of("barometer"), whole.of("barometer"), strict=True):
        assert got.t == true.t
        assert got.z == (frozen if 30 <= k < 70 else true.z)


@pytest.mark.parametrize(
    ("what", "value", "field"),
    [
        ("gnss", (1.0, -2.0, 0.5), "r"),
        ("gnss.v", 0.3, "v"),
        ("imu", (0.5, 0.0, 0.0), "accel"),
        ("imu.gyro", (0.0, 0.0, 0.2), "gyro"),
        ("flow", (0.4, -0.4), "v_B"),
        ("barometer", 2.0, "z"),
    ],
)
def test_a_jump_is_added_to_what_is_read_and_a_bias_grows_to_it(what, value, field):
    name = what.partition(".")[0]
    jump, whole = readings(Fault("jump", 0.3, 0.7, what, value))
    bias, _ = readings(Fault("bias", 0.2, 0.7, what, value))
    for (k, a), (_, b), (_, true) in zip(jump.of(name), bias.of(name), whole.of(name), strict=True):
        off = getattr(a, field) - getattr(true, field)
        np.testing.assert_allclose(off, np.array(value) * (30 <= k < 70), atol=1e-12)
        off = getattr(b, field) - getattr(true, field)
        grown = max(k * DT - 0.2, 0.0) if k < 70 else 0.0
        np.testing.assert_allclose(off, np.array(value) * grown, atol=1e-12)
        others = [x for x in a._fields if x != field]
        assert all(np.array_equal(getattr(a, x), getattr(true, x)) for x in others)


def test_attitudes_and_bearings_are_turned():
    broken, whole = readings(
        Fault("jump", 0.3, what="ahrs", value=np.pi / 2),
        Fault("jump", 0.3, what="bearings", value=(0.0, 0.0, np.pi / 2)),
    )
    quarter = np.array(((0.0, -1, 0), (1, 0, 0), (0, 0, 1)))
    (_, got), (_, true) = broken.of("ahrs")[-1], whole.of("ahrs")[-1]
    np.testing.assert_allclose(got.R, quarter @ true.R, atol=1e-12)
    (_, got), (_, true) = broken.of("bearings")[-1], whole.of("bearings")[-1]
    np.testing.assert_allclose(got.b, true.b @ quarter.T, atol=1e-12)


def test_a_late_line_holds_readings_back_and_overtaken_ones_never_arrive():
    broken, whole = readings(Fault("late", 0.3, 0.7, "gnss", 0.25))
    on_time = {k: x.t for k, x in whole.of("gnss")}
    wanted = {k: t for k, t in on_time.items() if not 30 <= k < 70}
    wanted |= {k + 25: t for k, t in on_time.items() if k >= 30 and k + 25 < 70}
    assert {k: x.t for k, x in broken.of("gnss")} == wanted
    assert len(wanted) < len(on_time)


def test_what_is_late_or_frozen_has_the_error_that_was_made_before():
    broken, whole = readings(
        Fault("jump", 0.2, what="barometer", value=5.0), Fault("frozen", 0.5, what="barometer"),
        Fault("late", 0.8, what="barometer", value=0.1),
    )  # fmt: skip
    before = [x.z for k, x in whole.of("barometer") if 20 <= k < 50][-1] + 5.0
    assert [x.z for k, x in broken.of("barometer") if k >= 50] == pytest.approx(
        [before] * sum(k >= 50 for k, _ in broken.of("barometer"))
    )


# The mind ---------------------------------------------------------------------------------------------


def test_an_estimate_without_numbers_ends_a_flight_that_nobody_watches():
    log = flown(Fault("nan", 0.3))
    assert log.exit.name == "NAN"
    assert np.isnan(log.r_e[30]).all()
    assert np.isfinite(log.R_e[30]).all()
    assert not np.isfinite(flown(Fault("nan", 0.3, what="all")).R_e[30]).any()


@pytest.mark.parametrize("slot", ["estimator", "tracker", "controller"])
def test_a_part_that_raises_is_named_and_one_that_gives_no_numbers_too(slot):
    log = flown(Fault("part", 0.3, what=slot, value="raises"))
    assert log.exit.name == "ERROR"
    assert f"the {slot} raised RuntimeError at t = 0.29 s" in log.reason
    assert "is broken, as the scenario says" in log.reason
    log = flown(Fault("part", 0.3, 0.31, what=slot, value="nan"))
    assert (log.exit.name, len(log.t)) == ("NAN", 31)
    first = {"estimator": log.r_e, "tracker": log.r_d, "controller": log.omega_d}[slot]
    assert np.isnan(first[30]).all()
    assert np.isfinite(first[:30]).all()


def test_of_a_slot_the_first_part_breaks_or_the_one_that_is_named():
    laws = {"slack": TiltAxis(F450.m), "stiff": TiltAxis(F450.m, Gains(k_p=12.0))}
    mind = uavlab.stack("F450", Slot(laws))
    swap = Swap(0.2, "controller", "stiff")
    saved = flown(Fault("part", 0.3, what="controller", value="raises"), mind=mind, swaps=(swap,))
    assert saved.exit.name == "DONE"
    for what in ("controller.stiff", "controller.*"):
        log = flown(Fault("part", 0.3, what=what, value="raises"), mind=mind, swaps=(swap,))
        assert log.exit.name == "ERROR"
    refused = flown(
        Fault("part", 0.1, what="controller.stiff", value="raises"), mind=mind, swaps=(swap,)
    )
    assert refused.exit.name == "DONE"
    assert refused.meta["swaps"][-1][3].startswith("refused: stiff: it raised RuntimeError")
    with pytest.raises(
        BadInput, match=r"'controller.stif': no controller aboard .* Did you mean 'stiff'"
    ):
        flown(Fault("part", 0.1, what="controller.stif", value="nan"), mind=mind)


@dataclass(frozen=True)
class Many:
    """A pilot that holds parts in every way there is, and flies a pair of them."""

    trackers: Any
    controllers: Any
    spare: Any

    def __getattr__(self, name):
        return getattr(Pair(self.trackers["slow"], self.controllers), name)


def test_a_pilots_parts_break_inside_it():
    stiff = TiltAxis(F450.m, Gains(k_p=12.0))
    laws = {"law": TiltAxis(F450.m), "stiff": stiff, "law tight": stiff}
    pilot: Any = Many({"slow": CommandFilter(1.0)}, Slot(laws), TiltAxis(F450.m))
    mind = uavlab.stack("F450")._replace(pilot=pilot)

    def ends(what, value):
        return flown(Fault("part", 0.3, what=what, value=value), mind=mind)

    assert "the tracker raised RuntimeError" in ends("tracker", "raises").reason
    assert "the tracker raised RuntimeError" in ends("tracker.slow", "raises").reason
    assert ends("controller", "nan").exit.name == "NAN"
    assert ends("controller.law", "nan").exit.name == "NAN"
    assert ends("controller.law tight", "nan").exit.name == "DONE"
    assert ends("controller.stiff", "nan").exit.name == "DONE"  # it does not fly
    assert ends("controller.spare", "raises").exit.name == "DONE"
    assert ends("controller.*", "nan").exit.name == "NAN"
    assert np.isnan(ends("estimator", "nan").r_e[30]).all()
    slot: Any = broken(
        mind, (Fault("part", 0.3, what="controller", value="nan"),), lambda: 1.0
    ).pilot
    failing = {
        name: isnan(law.step(law.init(HERE, None), HERE, GOAL, DT)[1].f_d)
        for name, law in slot.controllers.parts.items()
    }
    assert failing == {"law": True, "stiff": False, "law tight": True}
    assert isinstance(slot.controllers.parts["law"], TiltAxis)
    with pytest.raises(
        BadInput, match=r"no controller aboard named 'MpcController'.*law, law tight, spare, stiff"
    ):
        ends("controller.MpcController", "nan")


@dataclass(frozen=True)
class Counted:
    """A part, and how often it had no plan."""

    inner: Any
    slot: str
    failed: list = field(default_factory=list)

    def init(self, estimate, last):
        return self.inner.init(estimate, last)

    def step(self, *given):
        memory, out = self.inner.step(*given)
        self.failed.append(self.inner.failures(memory))
        return memory, out


def test_while_no_programme_finds_a_plan_both_mpc_parts_fly_on_old_ones():
    whole = uavlab.stack("F450", "MpcController", "MpcTracker")
    tracker, controller = Counted(whole.tracker, "tracker"), Counted(whole.controller, "controller")
    mind: Any = whole._replace(tracker=tracker, controller=controller)
    way = Waypoints(((0.0, (1.0, 0.0, 2.0), 0.0),))
    log = flown(Fault("solver", 0.3, 0.5), mind=mind, mission=way)
    assert log.exit.name == "DONE"
    for failed in (tracker.failed, controller.failed):
        assert failed == [0] * 30 + list(range(1, 21)) + [20] * 50


# Motors, battery, load, air ---------------------------------------------------------------------------


def test_a_dead_motor_runs_down_and_the_log_shows_its_true_thrust():
    log = flown(Fault("motor", 0.3, what="1", value=0.0), seconds=0.4)
    lag = np.exp(-2.0 * DT * np.arange(10) / F450.motor_tau)  # thrust goes with the square of speed
    np.testing.assert_allclose(log.rotors[30:40, 1], log.rotors[30, 1] * lag, rtol=1e-9)


def test_the_autopilot_notices_a_dead_motor_after_a_fifth_of_a_second_and_stops_the_opposite_one():
    still = uavlab.scenarios.load("hover")._replace(airframe="F550")
    faults = (Fault("motor", 0.3, what="0", value=0.0),)
    log = uavlab.fly(still._replace(duration=1.0, faults=faults), seed=3)
    assert log.rotors[50, 1] >= load_airframe("F550").thrust_min  # told to idle, at the least
    assert log.rotors[60, 1] < 0.01
    weak = (Fault("motor", 0.3, what="0", value=0.1),)
    kept = uavlab.fly(still._replace(duration=1.0, faults=weak), seed=3)
    assert kept.rotors[60, 1] >= load_airframe("F550").thrust_min


def test_thrust_sags_with_the_battery_and_stays_where_it_ends():
    faults = (Fault("battery", 0.2, 2.2, value=0.8),)
    injected = Injected(faults, F450)
    shares = [injected.damage.shares(t)[0] for t in (0.0, 0.2, 1.2, 2.2, 9.0)]
    assert shares == pytest.approx([1.0, 1.0, 0.9, 0.8, 0.8])
    log = flown(*faults, seconds=6.0)
    assert log.f_d[-100:].mean() == pytest.approx(F450.m * G / 0.8, rel=0.01)
    assert log.rotors[-100:].sum(axis=1).mean() == pytest.approx(F450.m * G, rel=0.01)


def test_a_load_of_which_nobody_was_told_sags_and_springs_up_when_it_drops():
    log = flown(Fault("payload", 5.0, value=0.34), seconds=6.0)
    sag = 0.34 * G / (F450.m * Gains().k_p)  # [m] a law without an integral hangs lower
    assert log.r_d[499, 2] - log.r[499, 2] == pytest.approx(sag, abs=0.01)
    assert log.a[501, 2] == pytest.approx(0.34 * G / F450.m, abs=0.15)
    assert abs(log.r_d[-1, 2] - log.r[-1, 2]) < 0.5 * sag


def test_a_gust_is_one_minus_cosine_and_adds_to_the_wind():
    log = flown(Fault("gust", 0.2, 0.8, value=(4.0, -2.0, 1.0)))
    t = np.arange(100) * DT
    shape = np.where((t >= 0.2) & (t < 0.8), 0.5 * (1.0 - np.cos(2 * np.pi * (t - 0.2) / 0.6)), 0.0)
    np.testing.assert_allclose(log.wind, np.outer(shape, (4.0, -2.0, 1.0)), atol=1e-9)
    assert log.wind[50] == pytest.approx((4.0, -2.0, 1.0))


def test_what_is_asked_while_the_link_is_down_is_heard_when_it_is_up_again():
    way = Waypoints(((0.0, (0, 0, 2), 0.0), (0.3, (1, 0, 2), 0.0)))
    log = flown(Fault("link", 0.2, 0.6), mission=way, start=uavlab.scenarios.load("hover").start)
    whole = flown(mission=way)
    np.testing.assert_allclose(log.v_d[:60, 0], whole.v_d[:60, 0] * (np.arange(60) < 20), atol=1e-9)
    np.testing.assert_allclose(
        log.r_d[60:, 0] - log.r_d[60, 0], whole.r_d[30:70, 0] - whole.r_d[30, 0], atol=1e-3
    )


@pytest.mark.parametrize(("value", "good"), [(0.7, True), (0.0, False)], ids=["weak", "dead"])
def test_a_quadrotor_flies_with_a_weak_motor_and_falls_with_a_dead_one(value, good):
    log = flown(Fault("motor", 0.5, what="0", value=value), seconds=4.0)
    assert log.exit.good is good


@pytest.mark.flight
@pytest.mark.parametrize("law", ["TiltAxis", "GeometricController"])
@pytest.mark.parametrize("rotor", ["0", "4"])
@pytest.mark.parametrize(
    ("speed", "wind"), [(0.0, 0.0), (4.0, 0.0), (0.0, 5.0)], ids=["hover", "forward", "wind"]
)
def test_a_hexacopter_with_a_dead_rotor_lands_softly(law, rotor, speed, wind):
    t = np.array((0.0, 4.0))
    way = Trajectory(t, np.outer(t, (speed, 0, 0)) + np.array((0, 0, 5.0)), np.zeros(2))
    start = standing((0.0, 0.0, 5.0))._replace(v=np.array((speed, 0.0, 0.0)))
    hexa = Scenario(
        "dead", "", "F550", Fly(way), start, 18.0, laboratory(), Wind(np.array((0.0, wind, 0.0))),
        swaps=(Swap(4.0, "tracker", "down"),), faults=(Fault("motor", 2.0, what=rotor),),
    )  # fmt: skip
    trackers = slotted({"way": CommandFilter(4.0), "down": LandOff()})
    laws = () if law == "TiltAxis" else (law,)
    log = uavlab.fly(hexa, uavlab.stack("F550", trackers, *laws), seed=1)
    assert log.exit.name == "DONE"
    down = int(np.argmax(log.r[:, 2] <= 0.0))
    assert down > 1000
    # It may touch twice; what it cannot bear would have ended it with Exit.CRASH.
    assert np.linalg.norm(log.v[down - 50 : down], axis=1).max() < (1.0 if not laws else 2.5)


# Refused ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (Fault("loss", 1.0), "no kind of fault named 'loss'. Did you mean 'lost'"),
        (Fault("lost", 1.0, what="gnss"), "no instrument aboard named 'gnss'.*imu, mocap"),
        (Fault("jump", 1.0, what="imu.giro"), "no field of imu named 'giro'. Did you mean 'gyro'"),
        (Fault("nan", -1.0), "t is -1.0; it must be a time ≥ 0"),
        (Fault("nan", float("nan")), "t is nan"),
        (Fault("nan", 2.0, 1.0), "until is 1 s; it must be later than t = 2 s"),
        (Fault("nan", 1.0, what="some"), "what is 'some'; it must be '' or 'all'"),
        (
            Fault("jump", 1.0, what="mocap", value=(1, 2)),
            r"value is \(1, 2\); it must be a number, or 3",
        ),
        (Fault("bias", 1.0, what="mocap", value="much"), "value is 'much'"),
        (Fault("late", 1.0, what="mocap"), "value is 0.0; it must be > 0 s"),
        (Fault("part", 1.0, what="pilot", value="nan"), "no slot named 'pilot'"),
        (Fault("part", 1.0, what="tracker"), "value is 0.0; it must be 'raises' or 'nan'"),
        (Fault("motor", 1.0, what="4"), "what is '4'; F450 has rotors 0 to 3"),
        (Fault("motor", 1.0, what="", value=0.5), "what is ''; F450 has rotors"),
        (Fault("motor", 1.0, what="1", value=1.2), "a share from 0 to 1"),
        (Fault("battery", 1.0, value=0.9), "until is missing"),
        (Fault("payload", 1.0, value=-0.5), "must be > 0 kg"),
        (Fault("payload", 1.0, what="0", value=0.5), "what is '0'; it must be ''"),
        (Fault("gust", 1.0, 2.0, value=3.0), "three numbers in m/s"),
        (Fault("gust", 1.0, value=(1, 0, 0)), "until is missing"),
    ],
)
def test_what_cannot_break_so_is_refused_by_name(fault, said):
    with pytest.raises(
        BadInput, match=rf"scenario 'hover': faults\[0\] \('{fault.kind}'\).*{said}"
    ):
        checked(scenario(fault))


def test_all_that_is_wrong_is_named_at_once():
    faults = Fault("nan", -1.0), Fault("link", 1.0), Fault("motor", 1.0, what="9", value=2.0)
    with pytest.raises(BadInput) as error:
        flown(*faults)
    said = str(error.value)
    assert "faults[0]" in said
    assert "faults[1]" not in said
    assert said.count("faults[2]") == 2


def test_a_world_of_ones_own_cannot_lose_a_motor_and_says_so():
    class Toy:
        def init(self, state):
            raise AssertionError

    toy = Toy()
    broken = scenario(
        Fault("nan", 0.1), Fault("motor", 0.1, what="0"), Fault("payload", 1.0, value=0.1)
    )
    with pytest.raises(
        BadInput, match=r"faults\[1\] \('motor'\), faults\[2\] \('payload'\) .* Toy"
    ):
        uavlab.fly(broken, plant=toy)


# Told -------------------------------------------------------------------------------------------------


def test_the_log_tells_the_faults_as_json_can_hold_them(tmp_path):
    faults = Fault("jump", 0.3, what="mocap", value=np.array((0.1, 0, 0))), Fault("link", 0.2, 0.4)
    log = flown(*faults)
    assert log.meta["faults"] == [
        ["jump", 0.3, 1.0, "mocap", [0.1, 0, 0]],
        ["link", 0.2, 0.4, "", 0.0],
    ]
    assert uavlab.load_log(log.save(tmp_path / "broken")).meta == log.meta
    assert "faults" not in flown().meta


def test_the_faults_of_the_book_can_be_flown():
    page = (Path(__file__).parents[2] / "book" / "faults.md").read_text("utf-8")
    rows = tomllib.loads(page.split("```toml\n")[1].split("```")[0])["fault"]
    assert [x["kind"] for x in rows] == ["jump", "motor"]
    checked(scenario(*(Fault(**x) for x in rows)))
    assert all(f'    "{kind}": ' in page for kind in KINDS)


def test_the_command_line_lists_every_kind(capsys):
    from uavlab.__main__ import main

    assert main(["list", "faults"]) == 0
    said = capsys.readouterr().out
    assert all(kind in said for kind in KINDS)
