"""The page of campaigns: records of enough flights, made with the settings of now."""

import json
from pathlib import Path

from grader.build_campaigns import MARK, campaigns_page
from uavlab.campaigns import NAMES, find_campaign
from uavlab.campaigns.record import load_record

FOLDER = Path(__file__).parents[2] / "book" / "campaigns"


FLOWN = [name for name in NAMES if (FOLDER / f"{name}.json").is_file()]


def test_each_record_is_of_the_settings_of_now_and_says_by_which_command():
    for name in FLOWN:
        kept, campaign = load_record(FOLDER / f"{name}.json"), find_campaign(name)
        assert kept.settings == json.loads(json.dumps(campaign.settings))
        assert f"--runs {kept.runs}" in kept.command


def test_the_page_tells_each_campaign_with_its_command_and_its_table():
    page = campaigns_page(f"# Title\n\n{MARK}\n", FOLDER)
    assert MARK not in page
    for name in NAMES:
        told = f"`{load_record(FOLDER / f'{name}.json').command}`" if name in FLOWN else "Not flown"
        assert told in page


def test_a_campaign_that_was_not_flown_yet_is_named(tmp_path):
    page = campaigns_page(f"{MARK}\n", tmp_path)
    assert all(f"Not flown yet: {name}" in page for name in NAMES)
