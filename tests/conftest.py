"""Settings that all tests share, and how they are spread over workers."""

import os
import re
from pathlib import Path

import hypothesis
import pytest

from uavlab.exercises import STEMS

hypothesis.settings.register_profile("ci", deadline=None, derandomize=True, max_examples=50)
hypothesis.settings.register_profile("dev", deadline=None, max_examples=100)
hypothesis.settings.load_profile("ci" if os.environ.get("CI") else "dev")

# Files whose tests are shared out lab by lab; the tests of any other file run in one worker, for its fixtures' sake.
BY_LAB = {"test_labs", "test_judge", "test_wrong_answers", "test_trivial_answers"}


def group(item: pytest.Item) -> str:
    """What the test has to share a worker with."""
    name = item.nodeid.split("::")[0]
    if Path(name).stem not in BY_LAB:
        return name
    given = getattr(item, "callspec", None)
    known = given.params if given else {}
    told = re.match(r"test_lab_(\d\d)_", item.name)
    if told:
        return f"{name}/{STEMS[int(told[1]) - 1]}"
    return f"{name}/{known.get('stem') or getattr(known.get('x'), 'stem', '')}"


def cost(item: pytest.Item) -> int:
    """How long the tests of a kind take, roughly."""
    marks = {mark.name for mark in item.iter_markers()}
    return 2 if "lab" in marks else 1 if "slow" in marks else 0


@pytest.hookimpl(tryfirst=True)  # before xdist reads the groups
def pytest_collection_modifyitems(items):
    """Group the tests for ``--dist loadgroup``, long files first: at the end no worker waits for one of them."""
    costs = {}
    for item in items:
        item.add_marker(pytest.mark.xdist_group(group(item)))
        costs[item.path] = max(costs.get(item.path, 0), cost(item))
    items.sort(key=lambda item: -costs[item.path])
