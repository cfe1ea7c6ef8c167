"""A change of the estimator's world: nobody feels it, and a log can be told again as if there had been none."""

import json

import numpy as np
import pytest

import uavlab
from uavlab.flight.log import UNITS, load_log
from uavlab.flight.metrics import heading_error, position_error
from uavlab.flight.worlds import flown_by, told
from uavlab.frames import NO_SHIFT, Shift, compose, inverse, moved
from uavlab.parts.controllers import HeadingController
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.sensors import ImuSensor, Mocap
from uavlab.so3 import about_z
from uavlab.types import Hypothesis

JUMP = Shift(np.array([3.0, -2.0, 0.5]), 0.4)
AT = 300  # tick of the jump


class Jumping:
    """An estimator whose world jumps in mid-flight; whether it says so is its field `honest`."""

    slot = "estimator"

    def __init__(self, jump=JUMP, honest=True):
        self.inner, self.jump, self.honest = AlphaBetaGamma(), jump, honest

    def init(self, estimate):
        return self.inner.init(estimate), 0, NO_SHIFT

    def step(self, memory, readings, command, dt):
        inner, tick, shift = memory
        if shift is not NO_SHIFT:
            command = moved(command, inverse(self.jump))
        inner, estimate = self.inner.step(inner, readings, command, dt)
        tick += 1
        if tick == AT:
            shift = compose(self.jump, NO_SHIFT)
        if shift is not NO_SHIFT:
            there = moved(estimate, self.jump)
            estimate = there._replace(world="b", shift=shift if self.honest else NO_SHIFT)
        return (inner, tick, shift), estimate

    def reframe(self, memory, shift):
        raise NotImplementedError

    def hypotheses(self, memory):
        (x, _), _, _ = memory
        rows = np.stack([x.r, x.v, x.a], axis=1)
        here = Hypothesis(
            rows, np.tile(0.01 * np.eye(3), (3, 1, 1)), np.zeros(2), np.eye(2), 1.0, True
        )
        r, v = moved(x, self.jump)[:2]
        there = here._replace(x=np.stack([r, v, x.a], axis=1), h=np.array([self.jump.heading, 0.0]))
        return {"a": here, "b": there}


def noise_free(seconds=6.0):
    """The gusty circle with instruments that tell the truth."""
    scenario = uavlab.scenarios.load("circle")
    still = dict.fromkeys(
        ("gyro_noise", "gyro_walk", "gyro_turn_on", "accel_noise", "accel_walk", "accel_turn_on"),
        0.0,
    )
    sensors = {"imu": ImuSensor(**still), "mocap": Mocap(noise=0.0, turn_noise=0.0)}
    gusty = uavlab.scenarios.load("gusts").wind
    return scenario._replace(sensors=sensors, duration=seconds, wind=gusty)


@pytest.fixture(scope="module")
def flights():
    scenario = noise_free()
    minds = {
        "calm": AlphaBetaGamma(), "told": Jumping(), "hidden": Jumping(honest=False),
    }  # fmt: skip
    return {
        k: uavlab.fly(scenario, uavlab.stack(scenario.airframe, HeadingController, part))
        for k, part in minds.items()
    }


@pytest.mark.flight
def test_a_jump_of_the_world_that_is_told_does_not_move_the_aircraft(flights):
    away = np.linalg.norm(flights["told"].r - flights["calm"].r, axis=1)
    assert away.max() < 1e-9


@pytest.mark.flight
def test_a_jump_that_is_not_told_moves_it_by_metres(flights):
    log, calm = flights["hidden"], flights["calm"]
    n = min(len(log.t), len(calm.t))
    away = np.linalg.norm(log.r[:n] - calm.r[:n], axis=1)
    assert away[:AT].max() < 1e-9
    assert away.max() > 1.0


@pytest.mark.flight
def test_a_log_keeps_the_numbers_as_they_were_told_and_tells_them_again_without_the_jump(flights):
    log, calm = flights["told"], flights["calm"]
    step = np.linalg.norm(np.diff(log.r_d, axis=0), axis=1)
    assert step[AT - 1] > 1.0  # as told, it jumps
    assert np.delete(step, AT - 1).max() < 0.1
    back = told(log)
    for name in ("r_e", "v_e", "R_e", "r_d", "v_d", "a_d", "heading_d"):
        np.testing.assert_allclose(getattr(back, name), getattr(calm, name), atol=1e-9)
    np.testing.assert_allclose(position_error(log), position_error(calm), atol=1e-9)
    np.testing.assert_allclose(heading_error(log), heading_error(calm), atol=1e-9)


@pytest.mark.flight
def test_a_log_says_which_hypothesis_flew_and_lays_them_all_into_one_world(flights):
    log = flights["told"]
    assert log.worlds.names == ("a", "b")
    assert [x for _, _, x in flown_by(log)] == ["", "b"]
    assert flown_by(log)[1][0] == pytest.approx(AT * 0.01)
    back = told(log).worlds
    np.testing.assert_allclose(back.r[1:, 0], log.worlds.r[1:, 0], atol=1e-9)
    np.testing.assert_allclose(back.r[:, 1], log.worlds.r[:, 0], atol=1e-9)
    np.testing.assert_allclose(back.v[:, 1], log.worlds.v[:, 0], atol=1e-9)
    np.testing.assert_allclose(back.heading[:, 1], 0.0, atol=1e-9)
    assert not back.shift_r.any()


@pytest.mark.flight
def test_a_log_told_twice_is_the_log_told_once(flights):
    once = told(flights["told"])
    twice = told(once)
    for name in UNITS:
        np.testing.assert_array_equal(getattr(once, name), getattr(twice, name))
    np.testing.assert_allclose(once.worlds.r, twice.worlds.r, atol=1e-12)


def test_a_single_filter_has_no_hypotheses_and_tells_nothing_anew():
    log = uavlab.fly(uavlab.scenarios.load("hover")._replace(duration=0.1))
    assert log.worlds.names == ()
    assert log.worlds.r.shape == (10, 0, 3)
    assert np.array_equal(told(log).r_d, log.r_d)


@pytest.mark.flight
def test_worlds_come_back_as_they_were_saved(flights, tmp_path):
    log = flights["told"]
    back = load_log(log.save(tmp_path / "worlds"))
    assert back.worlds.names == log.worlds.names
    for a, b in zip(back.worlds[1:], log.worlds[1:], strict=True):
        assert np.array_equal(a, b)
        assert a.dtype == b.dtype


def test_a_log_of_version_1_is_still_read(tmp_path):
    log = uavlab.fly(uavlab.scenarios.load("hover")._replace(duration=0.1))
    head = {"version": 1, "units": UNITS, "exit": "DONE", "reason": "", "meta": log.meta}
    path = tmp_path / "old.npz"
    np.savez(path, head=np.array(json.dumps(head)), **{k: getattr(log, k) for k in UNITS})
    old = load_log(path)
    assert np.array_equal(old.r, log.r)
    assert len(old.worlds.flies) == 0
    assert told(old) is old


def test_a_hypothesis_that_never_flew_is_laid_onto_the_estimate_where_it_was_first_reliable():
    log = uavlab.fly(uavlab.scenarios.load("hover")._replace(duration=0.5))
    n = len(log.t)
    turn = about_z(JUMP.heading)
    there = log.r_e @ turn.T + JUMP.r
    first = uavlab.flight.worlds.room(n, ("slam",))
    believed = first._replace(
        r=there[:, None] + np.linspace(0, 1, n)[:, None, None] * [0, 0, 1.0],
        heading=np.full((n, 1), JUMP.heading)
        + np.arctan2(log.R_e[:, 1, 0], log.R_e[:, 0, 0])[:, None],
        reliable=(np.arange(n) >= 20)[:, None],
    )
    back = told(log._replace(worlds=believed)).worlds
    np.testing.assert_allclose(back.r[20, 0], log.r_e[20], atol=1e-12)
    np.testing.assert_allclose(back.r[-1, 0] - log.r_e[-1], [0, 0, 1 - 20 / (n - 1)], atol=1e-3)
