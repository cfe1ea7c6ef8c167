"""Thousands of seeded flights by one command: a plan of seeds, a table with a row for each flight, and its summary."""

from uavlab.campaigns.run import here, processes, run
from uavlab.campaigns.spec import NAMES, Campaign, find_campaign
from uavlab.campaigns.table import Head, Row, read_table

__all__ = [
    "NAMES",
    "Campaign",
    "Head",
    "Row",
    "find_campaign",
    "here",
    "processes",
    "read_table",
    "run",
]
