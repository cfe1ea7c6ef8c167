"""The force MPC of lab 06, step by step and in flight."""

from math import inf, nan

import numpy as np
import pytest
from interior_point import solved
from numpy.testing import assert_allclose, assert_array_equal

import uavlab
from uavlab import scenarios
from uavlab.exercises import draw
from uavlab.experiments.landing_detection import errand
from uavlab.flight.metrics import position_error, summary
from uavlab.gains import MpcGains
from uavlab.interfaces import standing_command
from uavlab.limits import ForceLimits
from uavlab.plant import load_airframe
from uavlab.plant.wind import Wind
from uavlab.solutions.mpc import MpcController, build_force_qp, initial_state
from uavlab.types import GRAVITY, Command, Estimate, Reference
from uavlab.weights import HORIZONTAL, VERTICAL

ZERO, DT, MASS = np.zeros(3), 0.01, 2.0
PART, LIMITS = MpcController(MASS), ForceLimits()
LEVEL = Estimate(ZERO, ZERO, ZERO, np.eye(3), ZERO)


def at(r, v=ZERO, a=ZERO) -> Estimate:
    return Estimate(np.array(r, float), np.array(v, float), np.array(a, float), np.eye(3), ZERO)


def stand(r=ZERO, heading=0.0) -> Reference:
    return Reference(np.array(r, float), ZERO, ZERO, ZERO, heading, 0.0)


def after(n, estimate, reference, part=PART, memory=None, dt=DT):
    memory = part.init(estimate, None) if memory is None else memory
    command = None
    for _ in range(n):
        memory, command = part.step(memory, estimate, reference, dt)
    return memory, command


# Step by step -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_what_it_plans_is_the_programme_of_the_exercise(seed):
    rng = np.random.default_rng(seed)
    estimate = at(*(rng.normal(size=(3, 3)) * ((3,), (1.5,), (1.0,))))
    reference = draw.reference(rng)
    memory, _ = after(1, estimate, reference)
    x0 = initial_state(estimate, reference, LIMITS)
    for i, (limits, p, weights) in enumerate((
        (LIMITS.horizontal, 0.0, HORIZONTAL), (LIMITS.horizontal, 0.0, HORIZONTAL),
        (LIMITS.vertical, 0.5, VERTICAL),
    )):  # fmt: skip
        wanted = np.tile((reference.r[i], 0.0, 0.0), (PART.N, 1))  # (44)
        qp = build_force_qp(
            x0[i], wanted, 0.0, limits=limits, N=PART.N, dt=PART.dt, p=p, weights=weights
        )
        assert memory.inputs[i] == pytest.approx(solved(qp)[0], abs=1e-6)


def test_at_the_reference_it_carries_its_weight_and_believes_that_nothing_moves():
    _, command = after(3, LEVEL, stand())
    assert command.f_d == pytest.approx(MASS * GRAVITY)
    assert_allclose(command.omega_d, 0.0, atol=1e-9)
    assert_allclose(
        command.a_d, 0.0, atol=1e-9
    )  # errata of (53): as printed 1 − 1/m of gravity is left


def test_who_sags_gains_mass_and_who_is_pushed_leans_against_it():
    memory, command = after(100, at((0.2, -0.1, -0.5)), stand())
    assert memory.m_e == pytest.approx(MASS + 0.5 * 0.5 * 1.0)  # errata of (37): the sign
    assert_allclose(memory.d_w, (0.02, -0.01, 0.0))
    assert_allclose(memory.d_b, memory.d_w)  # the heading is 0
    _, once = after(1, at((0.2, -0.1, -0.5)), stand())
    assert command.f_d > once.f_d
    fast, _ = after(100, at((0.2, -0.1, -0.5), v=(0.4, 0.0, 0.0)), stand())
    assert_array_equal(fast.d_w, 0.0)  # in flight an error is no disturbance
    assert fast.m_e > MASS
    far, _ = after(100, at((900.0, 0.0, -900.0)), stand(), dt=1.0)
    assert far.d_w[0] == PART.gains.d_max
    assert far.m_e == MASS + PART.gains.m_max


def test_a_disturbance_of_the_body_turns_with_it_and_one_of_the_world_does_not():
    memory = PART.init(LEVEL, None)._replace(d_w=np.array((1.0, 0, 0)), d_b=np.array((0, 2.0, 0)))
    for heading in (0.0, 1.0):
        Rz = np.array((
            (np.cos(heading), -np.sin(heading), 0.0), (np.sin(heading), np.cos(heading), 0.0), (0.0, 0.0, 1.0),
        ))  # fmt: skip
        _, command = PART.step(memory, LEVEL._replace(R=Rz), stand(heading=heading), DT)
        d = np.array((1.0, 0, 0)) + Rz @ (0, 2.0, 0)
        assert_allclose(command.a_d, (MASS * GRAVITY * np.eye(3)[2] + d) / MASS - (0, 0, GRAVITY))


def test_a_jump_of_the_estimate_is_answered_within_the_jerk():
    memory, before = after(5, LEVEL, stand())
    inputs = [memory.inputs]
    for _ in range(30):
        memory, command = PART.step(memory, at((5.0, 0.0, 0.0)), stand(), DT)
        inputs.append(memory.inputs)
    slew = np.abs(np.diff(np.array(inputs), axis=0))[:, :2]
    assert slew.max() == pytest.approx(5.0 * DT)
    assert np.linalg.norm(command.omega_d) < 1.2
    assert before.f_d == pytest.approx(command.f_d)


@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_what_is_no_number_flies_on_with_the_plan_before(bad):
    reference = stand((3.0, 0.0, 0.0))
    memory, _ = after(40, LEVEL, reference)
    plan = memory.plans
    new, command = PART.step(memory, at((bad, 0.0, 0.0)), reference, DT)
    assert PART.failures(new) == 1
    assert new.inputs[0] == plan[0].z[1]  # shifted by a step
    assert_array_equal(new.d_w, memory.d_w)
    assert new.m_e == memory.m_e
    assert np.isfinite((command.f_d, *command.omega_d, *command.a_d)).all()
    new, command = PART.step(new, at((0.0, 0.0, 0.0), v=(bad, 0.0, 0.0)), reference, DT)
    assert PART.failures(new) == 1  # that speed keeps no limit: the reference's counts (45)
    assert np.isfinite((command.f_d, *command.omega_d, *command.a_d)).all()
    for worse, wish in (
        (LEVEL._replace(R=np.full((3, 3), bad)), reference),
        (LEVEL, reference._replace(heading=bad)),
        (LEVEL, reference._replace(a=np.full(3, bad))),
    ):
        later, told = PART.step(new, worse, wish, DT)
        assert PART.failures(later) == PART.failures(new) + 1
        assert told is new.command
    _, fine = PART.step(later, LEVEL, reference, DT)
    assert np.isfinite((fine.f_d, *fine.omega_d, *fine.a_d)).all()


def test_without_any_plan_it_asks_for_no_acceleration_of_its_own():
    memory, command = PART.step(PART.init(LEVEL, None), at((nan, nan, nan)), stand(), DT)
    assert PART.failures(memory) == 1
    assert command.f_d == pytest.approx(MASS * GRAVITY)


def test_a_command_beyond_the_limits_is_taken_over_as_the_limit():
    wild = Command(30.0, np.ones(3), np.array((9.0, -9.0, 0.5)))
    memory = PART.init(LEVEL, wild)
    assert_array_equal(memory.inputs, (2.0, -2.0, 0.5))
    _, first = PART.step(memory, LEVEL, stand(), DT)
    assert_allclose(first.f_d, wild.f_d)
    assert standing_command(MASS).f_d == PART.init(LEVEL, None).command.f_d


# One that follows -------------------------------------------------------------------------------------


FOLLOWS = MpcController(MASS, gains=MpcGains(follows=True))


@pytest.mark.parametrize("seed", range(4))
def test_one_that_follows_plans_along_the_velocity_of_the_reference(seed):
    rng = np.random.default_rng(seed)
    estimate = at(*(rng.normal(size=(3, 3)) * ((3,), (1.5,), (1.0,))))
    reference = draw.reference(rng)
    memory, _ = after(1, estimate, reference, FOLLOWS)
    x0 = initial_state(estimate, reference, LIMITS)
    t = FOLLOWS.dt * np.arange(1, FOLLOWS.N + 1)
    for i, (limits, p, weights) in enumerate((
        (LIMITS.horizontal, 0.0, HORIZONTAL), (LIMITS.horizontal, 0.0, HORIZONTAL),
        (LIMITS.vertical, 0.5, VERTICAL),
    )):  # fmt: skip
        r, v = reference.r[i], reference.v[i]
        wanted = np.column_stack((r + v * t, np.full(FOLLOWS.N, v), np.zeros(FOLLOWS.N)))
        qp = build_force_qp(
            x0[i], wanted, 0.0, limits=limits, N=FOLLOWS.N, dt=FOLLOWS.dt, p=p, weights=weights
        )
        assert memory.inputs[i] == pytest.approx(solved(qp)[0], abs=1e-6)


def test_one_that_follows_asks_for_nothing_beside_a_reference_that_moves_as_it_does():
    v = np.array((0.7, -0.4, 0.5))
    moving = stand()._replace(v=v)
    _, command = after(1, at((0.0, 0.0, 0.0), v=v), moving, FOLLOWS)
    assert command.f_d == pytest.approx(MASS * GRAVITY)
    _, lags = after(1, at((0.0, 0.0, 0.0), v=v), moving)  # (44) brakes
    assert lags.f_d < MASS * (GRAVITY - 0.5)


def test_one_that_follows_learns_from_who_is_blown_away_and_not_from_who_comes_back():
    goal = stand()
    for speed, learns in ((1.0, True), (0.2, True), (-1.0, False)):
        memory, _ = after(10, at((0.5, 0.0, 0.5), v=(speed, 0.0, speed)), goal, FOLLOWS)
        assert (memory.d_w[0] > 0.0) == learns
        assert (memory.m_e < MASS) == learns
    fast = goal._replace(v=np.array((0.0, 0.0, 2.5)))  # that nobody may follow
    memory, _ = after(10, at((0.0, 0.0, -0.5), v=(0.0, 0.0, 2.0)), fast, FOLLOWS)
    assert memory.m_e == MASS


def test_one_that_follows_flies_its_old_plan_on_when_nobody_knows_how_fast_the_reference_is():
    memory, _ = after(20, LEVEL, stand((3.0, 0.0, 0.0)), FOLLOWS)
    lost = stand((3.0, 0.0, 0.0))._replace(v=np.array((nan, 0.0, 0.0)))
    new, command = FOLLOWS.step(memory, LEVEL, lost, DT)
    assert FOLLOWS.failures(new) == 1
    assert new.inputs[0] == memory.plans[0].z[1]
    assert np.isfinite((command.f_d, *command.omega_d, *command.a_d)).all()


@pytest.mark.flight
def test_one_that_follows_comes_back_from_an_errand_that_the_other_falls_from():
    told, speed = load_airframe("T650").m, 1.5
    fell, flew = (
        errand(MpcController(told, gains=MpcGains(follows=x)), 0, speed) for x in (False, True)
    )
    assert fell.exit is uavlab.Exit.CRASH
    assert flew.exit is uavlab.Exit.DONE
    assert np.abs(flew.r[:, 2] - flew.r_d[:, 2]).max() < 0.5


# In flight --------------------------------------------------------------------------------------------


def flown(name, *, mission=None, **changes):
    scenario = scenarios.load(name)._replace(**changes)
    return uavlab.fly(scenario, uavlab.stack(scenario.airframe, "MpcController"))


@pytest.mark.flight
def test_it_flies_a_step_within_its_limits():
    log = flown("step", duration=20.0)
    assert log.exit is uavlab.Exit.DONE
    assert position_error(log)[-1] < 0.03
    assert (
        np.abs(log.v).max() < 2.0 * 1.05
    )  # the rows bind the plan; the aircraft lags by its attitude
    assert summary(log)["tilt, worst [deg]"] < 30.0


@pytest.mark.flight
def test_it_learns_a_steady_wind():
    wind = Wind(np.array((4.0, 2.0, 0.0)))
    log = flown("hover", duration=60.0, wind=wind)
    error = position_error(log)
    early, late = error[(log.t > 2) & (log.t < 8)].mean(), error[log.t > 50].mean()
    assert late < 0.05
    assert late < 0.5 * early
    assert np.abs(log.a_d[log.t > 50]).mean() < 0.1
