"""A wrong estimate is wrong by what was asked for, and the flights on it are measured as a ruler would."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from uavlab import so3
from uavlab.experiments import mistaken, noise_and_jump
from uavlab.experiments.mistaken import AT, GAINS, HEIGHT, JUMP, RATE, Mistaken, flown, jump, noise
from uavlab.flight.metrics import tilt
from uavlab.flight.scenario import standing
from uavlab.interfaces import standing_command
from uavlab.plant import CompiledPlant, load_airframe

N = 4000


def test_noise_is_white_of_the_size_that_was_asked_for_and_the_same_for_the_same_seed():
    drawn = noise(3, np.full(N, 2.0), axes=3)
    np.testing.assert_allclose(drawn.std(axis=0), 2.0, rtol=0.05)
    assert abs(np.corrcoef(drawn[1:, 0], drawn[:-1, 0])[0, 1]) < 0.05
    np.testing.assert_array_equal(drawn, noise(3, np.full(N, 2.0), axes=3))
    assert np.abs(drawn - noise(4, np.full(N, 2.0), axes=3)).max() > 1.0


def test_noise_of_two_axes_leaves_the_height_alone_and_held_noise_stays():
    drawn = noise(0, np.ones(25), hold=10)
    assert drawn.shape == (25, 6)
    assert not drawn[:, [2, 5]].any()
    assert (np.diff(drawn, axis=0) == 0.0).all(axis=1).sum() == 22


def test_noise_may_grow_in_flight():
    sizes = np.repeat((0.0, 1.0), N)
    drawn = noise(1, sizes)
    assert not drawn[:N].any()
    np.testing.assert_allclose(drawn[N:, :2].std(axis=0), 1.0, rtol=0.05)


def test_the_estimate_is_the_truth_and_its_error_and_nobody_is_told():
    error = jump()
    assert np.unique(error[:, 0]).tolist() == [0.0, JUMP]
    world = CompiledPlant(load_airframe("T650")).init(standing((1, 1, 1)))
    _, reading = mistaken.Truth().step(None, world, 0.01, np.random.default_rng(0))
    part, seen = Mistaken(error), []
    memory, readings = part.init(reading), cast("Any", {"truth": reading})
    for _ in range(len(error) + 5):
        memory, estimate = part.step(memory, readings, standing_command(1.0), 0.01)
        seen.append(estimate)
    assert all(x.shift is reading.shift for x in seen)
    np.testing.assert_array_equal([x.r[0] for x in seen][: len(error)], 1.0 + error[:, 0])
    assert seen[-1].r[0] == 1.0 + JUMP
    assert part.reframe(memory, reading.shift) == memory
    assert part.hypotheses(memory) == {}


def test_the_asked_thrust_axis_is_read_from_the_rates():
    R, R_d = (so3.exp(np.array(w)) for w in ((0.2, -0.1, 0.0), (0.0, 0.3, 0.0)))
    e_R = so3.vee(0.5 * (R_d.T @ R - R.T @ R_d))
    log: Any = SimpleNamespace(omega_d=-(np.array(GAINS.k_R) * e_R)[None])
    there = R @ mistaken.asked_axis(log, "SE(3)")[0]
    np.testing.assert_allclose(there, R_d[:, 2], atol=0.01)  # a little yaw is missing, too


def test_a_lean_is_told_about_both_axes():
    R = np.stack([so3.exp(np.array((0.0, 0.4, 0.0))), so3.exp(np.array((-0.2, 0.0, 0.0)))])
    np.testing.assert_allclose(mistaken.lean(R), ((0.4, 0.0), (0.0, 0.2)), atol=1e-12)


def test_without_noise_nothing_moves():
    for name in mistaken.CONTROLLERS:
        hover = noise_and_jump.measured(flown(name, noise(0, np.zeros(100)), 1.0), name)
        assert hover.tilt < 1e-6
        assert hover.drift < 1e-6
        assert not hover.ended


def test_one_noisy_hover_tells_the_two_controllers_apart():
    error = noise(0, np.ones(round(8.0 * RATE)))
    found = {}
    for name in mistaken.CONTROLLERS:
        found[name] = noise_and_jump.measured(flown(name, error, 8.0), name)
    assert found["SE(3)"].asked > 4.0 * found["MPC"].asked
    assert found["SE(3)"].asked == pytest.approx(noise_and_jump.predicted(1.0), rel=0.2)
    assert found["MPC"].drift < 3.0


def test_the_controller_that_knows_the_mass_keeps_it():
    known = mistaken.controller(mistaken.TOLD)
    assert known.gains.k_m == 0.0
    assert mistaken.controller("MPC").gains.k_m > 0.0


def test_a_jump_is_flown_out_within_the_limits_of_mpc_and_at_the_tilt_limit_by_se3():
    mpc, se3 = (noise_and_jump.reaction(name) for name in mistaken.CONTROLLERS)
    assert mpc.speed < 2.1
    assert mpc.acceleration < 2.1
    assert mpc.tilt < 13.0
    assert mpc.overshoot < 0.3
    assert 45.0 < se3.tilt < 61.0
    assert se3.speed > 2.0 * mpc.speed
    for x in (mpc, se3):
        assert x.log.r[-1, 0] == pytest.approx(-JUMP, abs=0.3)
        assert x.log.r[0, 2] == HEIGHT
        still = x.log.t < AT
        assert tilt(x.log)[still].max() < 1e-6


def test_the_time_to_settle_is_read_from_the_last_time_outside():
    x = noise_and_jump.reaction("MPC")
    after = x.log.t > AT + x.settled
    assert np.abs(x.away[after]).max() <= 0.05 * JUMP
    assert abs(x.away[np.flatnonzero(after)[0] - 1]) > 0.05 * JUMP
