"""The page of campaigns: records of enough flights, made with the settings of now."""

import json
from pathlib import Path

import pytest

from grader.build_campaigns import MARK, campaigns_page
from uavlab.campaigns import NAMES, find_campaign
from uavlab.campaigns.record import load_record

FOLDER = Path(__file__).parents[2] / "book" / "campaigns"


@pytest.mark.parametrize("name", NAMES)
def test_every_campaign_has_a_record_of_a_thousand_flights_with_the_settings_of_now(name):
    kept, campaign = load_record(FOLDER / f"{name}.json"), find_campaign(name)
    assert kept.runs >= 1000
    assert kept.settings == json.loads(json.dumps(campaign.settings))
    assert f"--runs {kept.runs}" in kept.command


def test_the_page_tells_each_campaign_with_its_command_and_its_table():
    page = campaigns_page(f"# Title\n\n{MARK}\n", FOLDER)
    assert MARK not in page
    for name in NAMES:
        kept = load_record(FOLDER / f"{name}.json")
        assert f"`{kept.command}`" in page
        assert find_campaign(name).title in page


def test_a_campaign_that_was_not_flown_yet_is_named(tmp_path):
    page = campaigns_page(f"{MARK}\n", tmp_path)
    assert all(f"Not flown yet: {name}" in page for name in NAMES)
