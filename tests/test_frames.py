"""Headings, and changes of world."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uavlab import frames, so3
from uavlab.frames import Shift
from uavlab.types import Estimate, State

angles = st.floats(-10.0, 10.0)
shifts = st.builds(
    lambda x, y, z, h: Shift(np.array([x, y, z]), h), *[st.floats(-50, 50)] * 3, st.floats(-3, 3)
)


@given(angles, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_turning_the_world_turns_the_heading(psi, x, y):
    R = so3.exp(np.array([x, y, 0.2]))
    turned = frames.heading(so3.about_z(psi) @ R)
    assert frames.wrap(turned - frames.heading(R) - psi) == pytest.approx(0.0, abs=1e-12)


@given(angles)
def test_wrap_changes_by_whole_turns_into_half_a_turn(a):
    w = frames.wrap(a)
    assert -np.pi <= w < np.pi
    assert (a - w) / (2 * np.pi) == pytest.approx(round((a - w) / (2 * np.pi)), abs=1e-9)


@given(shifts, shifts)
def test_composed_shifts_move_like_one_after_the_other(a, b):
    x = State(np.array([1.0, 2, 3]), np.array([4.0, 5, 6]), so3.exp(np.ones(3)), np.ones(3))
    once = frames.moved(x, frames.compose(b, a))
    twice = frames.moved(frames.moved(x, a), b)
    for p, q in zip(once, twice, strict=True):
        assert p == pytest.approx(q, abs=1e-9)


@given(shifts)
def test_a_shift_and_its_inverse_leave_all_as_it_was(a):
    x = State(np.array([1.0, 2, 3]), np.array([4.0, 5, 6]), so3.exp(np.ones(3)), np.ones(3))
    for p, q in zip(frames.moved(frames.moved(x, a), frames.inverse(a)), x, strict=True):
        assert p == pytest.approx(q, abs=1e-9)


def test_distances_do_not_depend_on_the_world():
    shift = Shift(np.array([3.0, -2.0, 0.5]), 0.4)
    x = State(np.array([1.0, 2, 3]), np.ones(3), np.eye(3), np.ones(3))
    y = x._replace(r=np.array([4.0, -2.0, 3.0]))
    there = np.linalg.norm(frames.moved(x, shift).r - frames.moved(y, shift).r)
    assert there == pytest.approx(5.0)


def test_a_field_that_is_not_known_is_refused():
    class Smell(NamedTuple):
        strength: float

    with pytest.raises(TypeError, match="strength"):
        frames.moved(Smell(1.0), Shift(np.zeros(3), 0.0))


@given(shifts)
def test_an_estimate_remembers_where_its_world_went(shift):
    x = Estimate(np.ones(3), np.zeros(3), np.zeros(3), np.eye(3), np.zeros(3), "gnss")
    there = frames.moved(x, shift)
    assert there.world == "gnss"
    back = frames.moved(there, frames.inverse(there.shift))
    assert back.r == pytest.approx(x.r, abs=1e-9)
    assert back.shift.r == pytest.approx(np.zeros(3), abs=1e-9)
    assert frames.wrap(back.shift.heading) == pytest.approx(0.0, abs=1e-9)
