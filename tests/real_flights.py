"""Whether the real recordings are at hand: tests that need one skip without; on CI that is a failure."""

import os

import pytest

from uavlab import datasets
from uavlab.errors import BadFile


def recording(name):
    """Path of a dataset from the folder UAVLAB_DATA; no test goes to the network for it."""
    if not os.environ.get("UAVLAB_DATA"):
        why = "no real flights: set UAVLAB_DATA to the folder that holds them"
        if os.environ.get("CI") == "true":
            pytest.fail(why)
        pytest.skip(why)
    try:
        return datasets.fetch(name)
    except BadFile as error:
        pytest.fail(str(error))
