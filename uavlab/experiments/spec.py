"""What an experiment is: what the paper printed, what we got, the band in which both agree, and pictures to look at."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from math import isfinite
from typing import NamedTuple

from uavlab.errors import BadInput, UnknownName
from uavlab.types import Array

# Where experiments are written down, in the order in which they are listed. A module defines EXPERIMENTS, a tuple.
MODULES: tuple[str, ...] = (
    "kalman_bank",
    "real_attitude",
    "real_drag",
    "real_velocity",
    "bench_tests",
    "adaptive_mass",
    "attitude_fit",
    "drag_sweep",
    "coupled",
    "coupled_wind",
    "coupled_starts",
    "bearing_pose",
    "steps",
    "circles",
    "compliance",
    "disturbances",
    "spica_flight",
    "misprints",
    "noise_and_jump",
    "landing_detection",
    "mpc_errands",
    "failsafe_fall",
    "managed_landings",
    "managed_worlds",
    "safety_triggers",
    "swaps",
    "estimator_swaps",
)

LEAST_SEEDS = 20  # a number of chance is a mean over at least so many flights


class Band(NamedTuple):
    """What is accepted: low ≤ ours ≤ high. An infinite end is open."""

    low: float
    high: float


class Row(NamedTuple):
    """One number of a paper, and ours."""

    quantity: str  # what was measured, in words, with its unit: "wind error [m/s]"
    paper: str  # as printed, or "—" where the paper prints none
    ours: float
    band: Band | None = None  # None: told, not judged
    spread: float | None = None  # standard deviation over the seeds
    note: str = ""  # why it is not met, or where the band comes from

    @property
    def met(self) -> bool | None:
        """Whether ours lies within the band; None where nothing is judged. A number that is not finite is not met."""
        if self.band is None:
            return None
        return isfinite(self.ours) and self.band.low <= self.ours <= self.band.high


class Line(NamedTuple):
    """One line, band or cloud of points in a picture."""

    label: str
    x: Array  # (n,)
    y: Array  # (n,)
    kind: str = "line"  # line, points, truth, paper, dashed, or band (then `y2` is its other edge)
    y2: Array | None = None  # (n,)


class Panel(NamedTuple):
    """One picture: axes with their names and units, and what is in it."""

    title: str
    x: str  # name and unit
    y: str
    lines: tuple[Line, ...]
    marks: tuple[tuple[float, str], ...] = ()  # vertical lines: where, and what happened there
    log_y: bool = False
    equal: bool = False  # the same scale on both axes, for maps


class Outcome(NamedTuple):
    """What an experiment gave."""

    rows: tuple[Row, ...]
    panels: tuple[Panel, ...] = ()
    remarks: tuple[
        str, ...
    ] = ()  # sentences: what flew, what was assumed, what was not met and why

    @property
    def met(self) -> bool:
        """Whether every row that is judged lies within its band."""
        return all(row.met is not False for row in self.rows)


class Experiment(NamedTuple):
    """A published experiment that can be run again."""

    name: str  # as in the book: "002-4"
    title: str
    source: str  # paper, section, figure or table
    run: Callable[[int], Outcome]  # number of seeds → outcome
    seeds: int = LEAST_SEEDS  # how many by default; 1 where nothing is left to chance

    def outcome(self, seeds: int | None = None) -> Outcome:
        """Run it.

        Parameters
        ----------
        seeds : int, optional
            How many seeded runs a number is the mean of.

        Raises
        ------
        BadInput
            Less than one.
        """
        count = self.seeds if seeds is None else seeds
        if count < 1:
            raise BadInput(f"experiment {self.name}: {count} seeds; at least 1 is needed.")
        return self.run(count)


def all_experiments() -> Iterator[Experiment]:
    """Every experiment, in the order of the book."""
    for module in MODULES:
        yield from importlib.import_module(f"uavlab.experiments.{module}").EXPERIMENTS


def find_experiment(name: str) -> Experiment:
    """The experiment with this name.

    Raises
    ------
    UnknownName
        There is none; the message says which there are.
    """
    known = {x.name: x for x in all_experiments()}
    if name not in known:
        raise UnknownName("experiment", name, known)
    return known[name]
