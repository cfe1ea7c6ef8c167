"""The fault campaign: what is drawn can be flown, and whatever breaks, a flight ends as it should."""

import json

import numpy as np
import pytest

from uavlab.campaigns import processes, run
from uavlab.campaigns.drawn import ENDS, KINDS, RANGES, drawn
from uavlab.campaigns.faults import CAMPAIGN, row, shown, summed
from uavlab.campaigns.judge import inside
from uavlab.campaigns.run import RAISED, flown
from uavlab.flight.scenario import checked
from uavlab.types import Reference

SEEDS = range(16)
MANY = [drawn(seed) for seed in range(300)]


def test_a_seed_is_a_flight():
    a, b = drawn(7), drawn(7)
    assert repr(a) == repr(b)
    assert repr(a) != repr(drawn(8))
    assert repr(a) != repr(drawn(7, salt=1))


def test_every_flight_that_is_drawn_can_be_flown_and_begins_inside_of_its_area():
    for flight in MANY:
        scenario = checked(flight.scenario)
        home = np.array([[*scenario.start.r[:2], 1.0]])
        assert inside(home, scenario.area.border).all()
        assert not scenario.area.why_not_at(np.array((0.0, 0.0, 1.0)))
        assert all(x.t <= scenario.duration for x in scenario.faults)


def test_all_that_there_is_is_drawn():
    assert {x.scenario.airframe for x in MANY} == set(RANGES.airframes)
    assert {kind for x in MANY for kind in x.kinds} == {*KINDS, *ENDS}
    assert {len(x.scenario.faults) for x in MANY} == {1, 2, 3}
    assert {name for x in MANY for name in x.members} == set(RANGES.members)
    assert {x.spare for x in MANY} == {True, False}
    on_the_ground = np.mean([x.scenario.start.r[2] == 0.0 for x in MANY])
    assert on_the_ground == pytest.approx(RANGES.ground, abs=0.1)


def test_some_goals_lie_outside_and_most_inside():
    goals = [
        bool(x.scenario.area.why_not_at(step.r))
        for x in MANY
        for step in x.scenario.mission.steps
        if isinstance(step, Reference)
    ]
    assert 0.1 < np.mean(goals) < 0.6


@pytest.fixture(scope="module")
def rows():
    return [flown(CAMPAIGN.fly, seed) for seed in SEEDS]


@pytest.mark.slow
@pytest.mark.flight
@pytest.mark.parametrize("seed", SEEDS)
def test_whatever_breaks_it_ends_in_a_state_that_has_a_name_and_nobody_is_hurt(rows, seed):
    one = rows[seed]
    assert not one["bad"], CAMPAIGN.shown(one)
    assert one["exit"] in {"DONE", "LANDED", "FAILSAFE"}
    assert one["faults"]
    assert one["touchdown"] is None or one["touchdown"] < 3.0


@pytest.mark.slow
@pytest.mark.flight
def test_a_row_is_json_and_tells_what_is_needed_to_look_into_it(rows):
    assert json.loads(json.dumps(rows, allow_nan=False)) == rows
    for one in rows:
        told = shown(one)
        assert f"--fly {one['seed']}" in told.command
        assert told.facts["faults"].count(" from ") == len(one["faults"])
    summary = summed(rows)
    assert summary.lines[-1].flights == len(rows)
    assert summary.lines[-1].bad.times == 0
    assert any("Touch-downs" in said for said in summary.said)
    assert summary.worth["Flights that did not end as they should"] == []


@pytest.mark.slow
@pytest.mark.flight
def test_another_process_flies_the_same_numbers(rows, tmp_path):
    short = sorted(SEEDS, key=lambda seed: rows[seed]["flown"])[:3]
    again = run(CAMPAIGN, short, tmp_path / "faults.jsonl", processes(2))
    for one in again:
        assert one | {"wall": 0.0} == rows[one["seed"]] | {"wall": 0.0}


def test_a_flight_that_raised_is_counted_and_shown_like_any_other():
    one = {"seed": 3, "exit": RAISED, "bad": True, "reason": "ValueError: no", "why": "…", "wall": 0.1}  # fmt: skip
    assert summed([one]).lines[-1].bad.times == 1
    assert "ValueError: no" in shown(one).facts["why"]


@pytest.mark.flight
def test_a_flight_that_goes_wrong_is_bad_and_says_why():
    log = CAMPAIGN.log(SEEDS[0])
    broken = log._replace(reason="somebody else flew", r_d=log.r_d * np.nan)
    one = row(broken, SEEDS[0])
    assert one["bad"]
    assert "r_d is not a number" in one["violations"][0]
