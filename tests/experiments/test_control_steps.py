"""Steps near the limits (000-1, 000-2), fewer than in the book: kept by the reference, flown by the aircraft."""

import numpy as np
import pytest

from uavlab.experiments import steps
from uavlab.experiments.steps import (
    ALIKE,
    LONGEST,
    PRINTED,
    UNLIKE,
    error,
    limit_rows,
    off_line,
    step_flight,
    stops,
    times,
)


@pytest.fixture(scope="module")
def spatial():
    return step_flight(LONGEST["three axes"], UNLIKE, sizes=(6.0,))


def test_steps_go_back_and_forth_and_grow():
    places = stops(LONGEST["one axis"], (1.0, 2.0, 4.0), ALIKE)
    assert [place[1][0] for place in places] == [0.0, 1.0, -1.0, 3.0, 3.0]
    assert np.all(np.diff([place[0] for place in places]) > 0.9)


def test_what_a_log_does_not_keep_is_told_again(spatial):
    assert spatial.wanted[:, 0] == pytest.approx(spatial.log.r_d, abs=1e-9)
    assert spatial.wanted[:, 2] == pytest.approx(spatial.log.a_d, abs=1e-9)
    assert spatial.failures == 0


def test_a_step_in_space_keeps_its_limits_goes_straight_and_arrives(spatial):
    assert all(row.met for row in limit_rows(spatial, slice(0, 2), PRINTED, ""))
    assert off_line(spatial) < 1e-3
    assert error(spatial).max() < 0.3
    (there,) = times(spatial)
    assert 2.0 < there < 4.0
    assert 0.5 < spatial.throttle.max() < 0.9


def test_a_number_outside_its_band_comes_with_the_reason(monkeypatch, spatial):
    monkeypatch.setattr(steps, "step_flight", lambda *_args, **_kw: spatial)
    for run in (steps.run_one_axis, steps.run_three_axes):
        outcome = run(1, (6.0,))
        assert len(outcome.panels) == 6
        assert all(row.note for row in outcome.rows if row.met is False)
