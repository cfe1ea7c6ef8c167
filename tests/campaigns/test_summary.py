"""Counts and what they are worth."""

import numpy as np
import pytest
from scipy.stats import binomtest

from uavlab.campaigns.summary import cells, counted, wilson


@pytest.mark.parametrize(
    ("count", "of"), [(0, 1000), (1, 1000), (3, 7), (7, 7), (0, 1), (500, 1000)]
)
def test_the_interval_is_that_of_wilson_as_scipy_has_it(count, of):
    oracle = binomtest(count, of).proportion_ci(method="wilson")
    share = wilson(count, of)
    np.testing.assert_allclose((share.low, share.high), oracle, atol=1e-6)


def test_of_no_flights_nothing_is_known():
    assert wilson(0, 0)[2:] == (0.0, 1.0)


def test_no_failure_in_a_thousand_flights_still_leaves_a_few_in_a_thousand():
    assert str(wilson(0, 1000)) == "0 of 1000 (0.0 to 0.4 %)"


ROWS = [
    {"seed": 1, "faults": ["gust"], "exit": "DONE", "bad": False},
    {"seed": 2, "faults": ["gust", "nan", "gust"], "exit": "CRASH", "bad": True},
    {"seed": 3, "faults": [], "exit": "DONE", "bad": False},
]


def test_a_flight_counts_once_in_each_of_its_lines_and_once_in_all():
    summary = counted(ROWS, "fault", lambda x: x["faults"], lambda x: x["exit"])
    assert summary.endings == ("DONE", "CRASH")
    assert [(x.name, x.flights, x.bad.times) for x in summary.lines] == [
        ("gust", 2, 1),
        ("nan", 1, 1),
        ("all flights", 3, 1),
    ]
    table = cells(summary)
    assert table[0] == ("fault", "flights", "DONE", "CRASH", "not as it should [95 %]")
    assert table[2][:4] == ("nan", "1", "·", "1")
