"""Flights: how they end, that they repeat, and what their logs keep."""

import numpy as np
import pytest

import uavlab
from uavlab.errors import BadFile, BadInput, UnknownName
from uavlab.flight.log import UNITS
from uavlab.flight.metrics import headings, position_error
from uavlab.interfaces import Stack
from uavlab.parts.controllers import HeadingController, TiltAxis
from uavlab.parts.missions import Waypoints
from uavlab.types import Command, Exit

BOUNDS = {  # scenario: mean position error [m], worst heading error [deg] that the stand-ins keep
    "hover": (0.01, 0.5),
    "takeoff": (0.02, 0.5),
    "step": (0.06, 18),
    "circle": (0.4, 28),
    "circle-facing": (0.4, 17),
    "lemniscate": (0.15, 5),
    "gusts": (0.3, 1),
    "gnss-to-rtk": (2.5, 8),  # these three name a bank of filters; GNSS is wrong by metres
    "rtk-lost": (2.5, 8),
    "outdoor-indoor": (2.5, 8),
    "errand": (0.5, 8),  # and these two a pilot
    "outdoor-indoor-managed": (0.5, 8),
}


@pytest.fixture(scope="module")
def flights():
    def shorter(scenario):
        return scenario._replace(duration=11.5) if scenario.mind else scenario

    load = uavlab.scenarios.load
    return {name: uavlab.fly(shorter(load(name))) for name in uavlab.scenarios.names()}


@pytest.mark.flight
@pytest.mark.parametrize("name", uavlab.scenarios.names())
def test_every_scenario_is_flown_to_its_end_by_the_stand_ins_or_whom_it_names(flights, name):
    log = flights[name]
    assert log.exit is Exit.DONE, log.reason
    got = uavlab.summary(log)
    assert got["position error, mean [m]"] < BOUNDS[name][0]
    assert got["heading error, worst [deg]"] < BOUNDS[name][1]


@pytest.mark.flight
def test_the_answers_of_lab_02_keep_a_heading_that_the_stand_in_loses(flights):
    scenario = uavlab.scenarios.load("circle")
    log = uavlab.fly(scenario, uavlab.stack(scenario.airframe, HeadingController))
    worst = uavlab.summary(log)["heading error, worst [deg]"]
    assert log.exit is Exit.DONE
    assert worst < 8.0
    assert worst < 0.5 * uavlab.summary(flights["circle"])["heading error, worst [deg]"]


def short(name="hover", seconds=0.5):
    return uavlab.scenarios.load(name)._replace(duration=seconds)


def test_the_same_seed_gives_the_same_bytes_and_another_does_not():
    a, b, c = (uavlab.fly(short("gusts"), seed=s) for s in (7, 7, 8))
    for field in UNITS:
        if field != "solve":
            assert getattr(a, field).tobytes() == getattr(b, field).tobytes(), field
    assert a.r.tobytes() != c.r.tobytes()


def test_another_sensor_does_not_change_what_the_first_ones_say():
    plain = short()
    more = plain._replace(sensors={**plain.sensors, **uavlab.scenarios.load("gusts").sensors})
    assert np.array_equal(uavlab.fly(plain).r_e, uavlab.fly(more).r_e)


class Broken(TiltAxis):
    """A controller that does something else after a tenth of a second."""

    def init(self, estimate, last):
        return 0

    def step(self, memory, estimate, reference, dt):
        command = Command(self.mass * 9.81, np.zeros(3), np.zeros(3))
        return memory + 1, self.wrong(command) if memory > 10 else command

    def reframe(self, memory, shift):
        return memory


class Roller(Broken):
    def wrong(self, command):
        return command._replace(omega_d=np.array([6.0, 0, 0]))


class Dropper(Broken):
    def wrong(self, command):
        return command._replace(f_d=0.0)


class Rocket(Broken):
    def wrong(self, command):
        return command._replace(f_d=40.0)


class NotANumber(Broken):
    def wrong(self, command):
        return command._replace(f_d=float("nan"))


class Raiser(Broken):
    def wrong(self, command):
        raise ZeroDivisionError("one over nothing")


class Unfinished(Broken):
    def wrong(self, command):
        raise NotImplementedError("heading_rate is not finished yet")


@pytest.mark.parametrize(
    ("part", "end"),
    [
        (Roller, Exit.TILT),
        (Dropper, Exit.CRASH),
        (Rocket, Exit.AWAY),
        (NotANumber, Exit.NAN),
        (Raiser, Exit.ERROR),
    ],
)
def test_a_flight_that_ends_badly_ends_with_a_value_that_says_where_and_why(part, end):
    scenario = short(seconds=5.0)._replace(reach=20.0)
    log = uavlab.fly(scenario, uavlab.stack("F450", part(mass=1.7)))
    assert log.exit is end
    assert "at t = " in log.reason
    assert 0 < len(log.t) < 500
    assert all(len(getattr(log, name)) == len(log.t) for name in UNITS)
    if end is Exit.ERROR:
        assert "one over nothing" in log.reason
        assert "ZeroDivisionError" in log.meta["traceback"]


def test_an_unfinished_exercise_says_so_instead_of_ending_a_flight():
    with pytest.raises(NotImplementedError, match="heading_rate is not finished yet"):
        uavlab.fly(short(), uavlab.stack("F450", Unfinished(mass=1.7)))


def test_progress_is_told_and_ends_at_the_end():
    said = []
    uavlab.fly(short(seconds=2.0), progress=lambda t, end: said.append((t, end)))
    assert said == [(0.0, 2.0), (1.0, 2.0), (2.0, 2.0)]


def test_a_log_comes_back_as_it_was_saved(tmp_path):
    log = uavlab.fly(short())
    path = log.save(tmp_path / "flight")
    back = uavlab.load_log(path)
    assert path.name == "flight.npz"
    assert back.exit is log.exit
    assert (back.reason, back.meta) == (log.reason, log.meta)
    assert all(np.array_equal(getattr(log, k), getattr(back, k)) for k in UNITS)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("damage", ["cut", "empty", "text", "other"])
def test_a_damaged_log_is_refused_by_name(tmp_path, damage):
    path = uavlab.fly(short()).save(tmp_path / "flight.npz")
    whole = path.read_bytes()
    if damage == "other":
        np.savez(path, x=np.zeros(3))
    else:
        path.write_bytes({"cut": whole[: len(whole) // 2], "empty": b"", "text": b"hello"}[damage])
    with pytest.raises(BadFile, match=r"flight\.npz is not a (whole )?uavlab log"):
        uavlab.load_log(path)


def test_a_log_that_is_not_there_is_named(tmp_path):
    with pytest.raises(BadFile, match="no log at"):
        uavlab.load_log(tmp_path / "none.npz")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"duration": -1.0}, "duration is -1.0; it must be > 0"),
        ({"physics": 333.0}, "whole multiple"),
        ({"rate": float("nan")}, "rate is nan"),
    ],
)
def test_a_scenario_that_cannot_be_flown_is_refused_with_the_bound(change, said):
    with pytest.raises(BadInput, match=said):
        uavlab.fly(short()._replace(**change))


def test_a_scenario_or_airframe_that_is_not_there_is_answered_with_the_near_one():
    with pytest.raises(UnknownName, match="Did you mean 'circle'"):
        uavlab.scenarios.load("circel")
    with pytest.raises(UnknownName, match="Did you mean 'F450'"):
        uavlab.fly(short()._replace(airframe="F45O"))


def test_waypoints_that_run_backwards_in_time_are_refused():
    with pytest.raises(BadInput, match="times must grow"):
        Waypoints(((1.0, (0, 0, 1), 0.0), (0.0, (0, 0, 2), 0.0)))


def test_the_errors_and_headings_of_a_log_are_those_of_its_arrays(flights):
    log = flights["step"]
    assert position_error(log)[-1] == pytest.approx(np.linalg.norm(log.r[-1] - log.r_d[-1]))
    assert headings(log)[-1] == pytest.approx(np.pi / 2, abs=0.1)


def test_the_stack_is_a_stack():
    assert isinstance(uavlab.stack("F450"), Stack)
