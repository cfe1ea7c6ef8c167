"""Settings that all tests share, and how they are spread over workers."""

import os
import re
from pathlib import Path

import hypothesis
import pytest

# Before numpy is imported: else each worker spins on every core.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from uavlab.exercises import STEMS, all_exercises

hypothesis.settings.register_profile("ci", deadline=None, derandomize=True, max_examples=50)
hypothesis.settings.register_profile("dev", deadline=None, max_examples=100)
hypothesis.settings.load_profile("ci" if os.environ.get("CI") else "dev")

# Files whose tests are shared out lab by lab; the tests of any other file run in one worker, for its fixtures' sake.
BY_LAB = {"test_labs", "test_judge", "test_wrong_answers", "test_trivial_answers"}
LAB_OF = {**{stem: stem for stem in STEMS}, **{x.name: x.stem for x in all_exercises()}}


def scope(nodeid: str) -> str:
    """What a test shares a worker with: its file, or its file and its lab."""
    file, _, name = nodeid.partition("::")
    if Path(file).stem not in BY_LAB:
        return file
    told = re.match(r"test_lab_(\d\d)_", name)
    stem = STEMS[int(told[1]) - 1] if told else ""
    words = re.findall(r"\w+", name.partition("[")[2])
    return f"{file} {stem or next((LAB_OF[w] for w in words if w in LAB_OF), '')}"


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """With ``--dist loadfile``, the files in `BY_LAB` are shared out lab by lab."""
    from xdist.scheduler import LoadFileScheduling

    class ByLab(LoadFileScheduling):
        def _split_scope(self, nodeid):
            return scope(nodeid)

    return ByLab(config, log) if config.getvalue("dist") == "loadfile" else None


def cost(item: pytest.Item) -> int:
    """How long the tests of a kind take, roughly."""
    marks = {mark.name for mark in item.iter_markers()}
    return 2 if "lab" in marks else 1 if "slow" in marks else 0


def pytest_collection_modifyitems(items):
    """Long files first: at the end no worker waits for one of them."""
    costs = {}
    for item in items:
        costs[item.path] = max(costs.get(item.path, 0), cost(item))
    items.sort(key=lambda item: -costs[item.path])
