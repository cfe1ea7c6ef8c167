"""The published experiments, flown again: one file each, found by the name that the book gives them (``002-4``).

Numbers only: what is drawn is described as `Panel`s, and `uavlab.views` draws them.
"""

from uavlab.experiments.spec import (
    Band,
    Experiment,
    Line,
    Outcome,
    Panel,
    Row,
    all_experiments,
    find_experiment,
)

__all__ = [
    "Band",
    "Experiment",
    "Line",
    "Outcome",
    "Panel",
    "Row",
    "all_experiments",
    "find_experiment",
]
