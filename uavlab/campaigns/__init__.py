"""Thousands of seeded flights by one command: a plan of seeds, a table with a row for each flight, and its summary."""

from uavlab.campaigns.run import Campaign, here, processes, run
from uavlab.campaigns.table import Head, Row, read_table

__all__ = ["Campaign", "Head", "Row", "here", "processes", "read_table", "run"]
