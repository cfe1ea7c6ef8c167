"""The failsafe comes down level on nothing but an attitude."""

from dataclasses import replace

import numpy as np
import pytest

from uavlab import so3
from uavlab.errors import BadInput
from uavlab.frames import heading
from uavlab.parts.failsafe import Failsafe
from uavlab.parts.missions import still
from uavlab.parts.throttle import ThrustCurve
from uavlab.plant import CompiledPlant, load_airframe
from uavlab.plant.world import total_force
from uavlab.solutions.dynamics import throttle_from_force
from uavlab.types import Command, Estimate, State

DT = 0.01
T650 = load_airframe("T650")
CURVE = ThrustCurve(T650.a_t, T650.b_t)
PART = Failsafe(T650.m, CURVE)
BLIND = np.full(3, np.nan)
ASKED = still(BLIND)  # no reference


def believed(R, r=BLIND, v=BLIND):
    return Estimate(r, v, BLIND, R, np.zeros(3))


def commands(part, R, seconds, last=None):
    memory, seen = part.init(believed(R), last), []
    for _ in range(round(seconds / DT)):
        memory, x = part.step(memory, believed(R), ASKED, DT)
        seen.append(x)
    return seen


def test_it_begins_a_little_below_the_throttle_of_hover_and_closes_it_at_a_fixed_rate():
    T = np.array([throttle_from_force(x.f_d, *CURVE) for x in commands(PART, np.eye(3), 10.0)])
    hover = T650.a_t * np.sqrt(T650.m * 9.81) + T650.b_t
    assert T[0] == pytest.approx(0.98 * hover)
    np.testing.assert_allclose(np.diff(T), -0.015 * DT, atol=1e-12)


def test_at_the_end_of_the_throttle_it_asks_for_none():
    far = commands(Failsafe(T650.m, CURVE, rate=0.5), np.eye(3), 4.0)
    assert throttle_from_force(far[-1].f_d, *CURVE) == pytest.approx(0.0, abs=1e-12)
    assert np.isfinite([x.f_d for x in far]).all()


def test_where_it_is_and_how_fast_and_what_was_wanted_do_not_count():
    R = so3.exp(np.array((0.2, -0.1, 2.0)))
    a, b = PART.init(believed(R), None), PART.init(believed(R, np.ones(3), np.ones(3)), None)
    _, x = PART.step(a, believed(R), ASKED, DT)
    _, y = PART.step(b, believed(R, np.ones(3), np.ones(3)), still(np.ones(3), 1.0), DT)
    np.testing.assert_array_equal(np.hstack(x), np.hstack(y))
    assert np.isfinite(np.hstack(x)).all()


def test_it_turns_to_level_and_back_to_the_heading_at_which_it_took_over():
    plant = CompiledPlant(T650)
    R = so3.exp(np.array((0.0, 0.0, 1.0))) @ so3.exp(np.array((0.3, -0.2, 0.0)))
    world = plant.init(State(np.array((0.0, 0.0, 50.0)), np.zeros(3), R, np.array((0.0, 0.0, 1.0))))
    memory = PART.init(believed(R), None)
    for _ in range(300):
        memory, x = PART.step(memory, believed(world.R), ASKED, DT)
        world = plant.advance(world, x)
    assert np.degrees(np.arccos(world.R[2, 2])) < 0.1
    assert heading(world.R) == pytest.approx(heading(R), abs=0.01)


def test_it_takes_over_without_a_jump_and_has_let_go_of_the_last_command_soon():
    last = Command(50.0, np.array((1.0, 0.0, 0.0)), np.zeros(3))
    taken, fresh = commands(PART, np.eye(3), 1.0, last), commands(PART, np.eye(3), 1.0)
    assert taken[0].f_d == pytest.approx(50.0)
    assert abs(taken[50].f_d - fresh[50].f_d) < 0.01 * (50.0 - fresh[0].f_d)


def test_a_mass_that_was_learned_carries_more():
    light, heavy = (commands(replace(PART, mass=m), np.eye(3), 0.01)[0].f_d for m in (3.5, 4.0))
    assert heavy / light == pytest.approx(4.0 / 3.5, rel=0.02)


@pytest.mark.parametrize(
    "wrong", [{"mass": 0.0}, {"mass": np.nan}, {"share": 1.1}, {"rate": 0.0}, {"tau": -1.0}]
)
def test_numbers_with_which_nothing_comes_down_are_refused(wrong):
    with pytest.raises(BadInput):
        replace(PART, **wrong)
    with pytest.raises(BadInput, match="a_t"):
        Failsafe(3.5, ThrustCurve(0.0, 0.1))


def test_who_leans_against_the_wind_is_carried_away_by_less_of_it():
    plant, wind, carried = CompiledPlant(T650), np.array((4.0, 0.0, 0.0)), []
    hovers = State(np.array((0.0, 0.0, 9.0)), np.zeros(3), np.eye(3), np.zeros(3))
    drag = float(total_force(T650, hovers, T650.m * 9.81, wind)[0] / T650.m)  # [m/s²]
    for lean in ((0.0, 0.0), (-drag, 0.0)):
        part = replace(PART, lean=lean)
        world = plant.init(hovers)
        memory = part.init(believed(world.R), None)
        for _ in range(300):
            seen = believed(world.R)._replace(omega=world.omega)
            memory, command = part.step(memory, seen, ASKED, DT)
            world = plant.advance(world, command, wind, DT, 10)
        carried.append(float(world.v[0]))
    assert carried[0] > 0.5
    assert abs(carried[1]) < 0.4 * carried[0]


@pytest.mark.parametrize("lean", [(3.0, 0.0), (np.nan, 0.0), (0.0, np.inf)])
def test_a_lean_that_is_steep_or_no_number_is_refused(lean):
    with pytest.raises(BadInput, match="lean is"):
        replace(PART, lean=lean)
