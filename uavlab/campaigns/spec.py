"""What a campaign is: how a seed is flown, what its numbers depend on, and what is made of its rows."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from uavlab import __version__
from uavlab.campaigns.page import Shown
from uavlab.campaigns.summary import Summary
from uavlab.campaigns.table import Head, Row
from uavlab.errors import UnknownName

NAMES = ("faults",)  # each a module of this room, with a CAMPAIGN


class Campaign(NamedTuple):
    """What is flown, again and again. Its functions are those of a module: else a worker could not find them."""

    name: str
    title: str
    fly: Callable[[int], Row]  # a seed → its row, of JSON
    settings: Mapping[str, Any]  # all that a row depends on but the seed and the version; JSON
    log: Callable[[int], Any]  # a seed → the `Log` of its flight
    summed: Callable[[list[Row]], Summary]  # what became of it
    shown: Callable[[Row], Shown]  # what is told of one flight

    @property
    def head(self) -> Head:
        """The first line of its table."""
        return Head(self.name, __version__, self.settings)


def find_campaign(name: str) -> Campaign:
    """The campaign of this name.

    Raises
    ------
    UnknownName
        There is none.
    """
    if name not in NAMES:
        raise UnknownName("campaign", name, NAMES)
    return importlib.import_module(f"uavlab.campaigns.{name}").CAMPAIGN
