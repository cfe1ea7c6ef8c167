"""Whoever takes over from whom, the aircraft is not bumped; and the ruler that says so is a ruler."""

from itertools import permutations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from uavlab.experiments import swaps
from uavlab.experiments.swaps import (
    AT,
    FAST,
    ISSUE,
    NEAR,
    SLOW,
    Flight,
    apart,
    circling,
    hovering,
    roams,
)


def log(x, told=()) -> Any:
    """A log of positions along x, one for each tick."""
    r = np.zeros((len(x), 3))
    r[:, 0] = x
    return SimpleNamespace(t=np.arange(len(x)) * swaps.DT, r=r, meta={"swaps": list(told)})


def test_the_distance_of_two_paths_begins_at_the_swap_and_the_way_from_there_too():
    a, b = log(np.linspace(0.0, 1.0, 101)), log(np.zeros(101))
    np.testing.assert_allclose(apart(a, b, 0.5, 0.5), 0.5 + 0.01 * np.arange(50))
    assert roams(a, 0.5, 0.5) == pytest.approx(0.49)


@pytest.mark.parametrize("told", [[[0.5, "controller", "x", "refused: x: its f_d is nan"]], []])
def test_a_swap_that_was_refused_or_a_flight_that_ended_early_is_no_number(told):
    a, b = log(np.zeros(101), told), log(np.zeros(101 if told else 60))
    assert np.isnan(apart(a, b, 0.5, 0.5)).all()
    assert np.isnan(roams(a if told else b, 0.5, 0.5))


@pytest.mark.flight
def test_every_controller_takes_over_from_every_other_in_a_hover():
    flight = Flight(hovering(), "controller", tuple(swaps.controllers()), AT)
    rows, matrix = swaps.hover_rows(flight, 1)
    pairs = [row for row in rows if row.band is NEAR]
    assert len(pairs) == len(matrix) == 20
    assert [row.quantity for row in pairs if not row.met] == []


@pytest.mark.flight
def test_every_tracker_takes_over_from_every_other_on_a_slow_circle():
    rows, found = swaps.circle_rows(Flight(circling(SLOW), "tracker", ISSUE, 8.0), SLOW)
    assert set(found) == set(permutations(ISSUE, 2))
    assert [row.quantity for row in rows if row.met is False] == []


@pytest.mark.flight
def test_at_speed_a_swap_is_not_felt_at_once_and_ends_where_the_new_one_flies():
    names = ("SE(3) tight", "heading")
    flight = Flight(circling(FAST), "controller", names, 8.0)
    _, found = swaps.circle_rows(flight, FAST)
    for a, b in permutations(names, 2):
        assert found[a, b][:30].max() < NEAR.high
        assert found[a, b].max() > 0.2  # their steady errors differ
        assert apart(flight.fly(a, b), flight.fly(b), 8.0, 4.0)[-1] < 0.05
