"""The shapes of what flies: init, step, reframe, with the memory in the open.

MRS calls these activate, update and switch-odometry-source. Memory is explicit, so *deactivate* is forgetting it,
*reset* is `init`, and a spare part is kept warm by stepping it and dropping its output.

Laws, tested for every part (tests/test_laws.py):

1. pure: same inputs, same outputs, inputs untouched;
2. frame-blind: ``step ∘ reframe = reframe ∘ step`` when the inputs are moved too;
3. bumpless: the first step after ``init`` reproduces the last output;
4. finite over the flight envelope;
5. rate-consistent: halving dt converges.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any, NamedTuple, Protocol, TypeAlias, runtime_checkable

import numpy as np

from uavlab.frames import Shift
from uavlab.orders import Order
from uavlab.types import (
    GRAVITY,
    Attitude,
    Bearings,
    Command,
    Estimate,
    Field,
    Fix,
    Flow,
    Height,
    Hypothesis,
    Imu,
    Pose,
    Range,
    Reference,
    Sectors,
    Sticks,
    Trajectory,
)

Memory: TypeAlias = Any
Reading: TypeAlias = (
    Imu | Fix | Pose | Attitude | Field | Height | Range | Flow | Bearings | Sectors | Sticks
)
Goal: TypeAlias = Reference | Trajectory
Readings: TypeAlias = Mapping[str, Reading]  # by instrument; only what arrived since the last tick


@runtime_checkable
class Estimator(Protocol):
    """Readings and the last command → an estimate.

    An estimator may change the world in which it tells its estimate (a bank of filters does when another one takes
    over). It says so in ``estimate.shift``; the loop then moves the memory of every other part, and nothing is felt.
    """

    def init(self, estimate: Estimate) -> Memory:
        """Memory that continues from `estimate`."""
        ...

    def step(
        self, memory: Memory, readings: Readings, command: Command, dt: float
    ) -> tuple[Memory, Estimate]:
        """One tick of `dt` [s]."""
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """The same memory, told in the new world."""
        ...

    def hypotheses(self, memory: Memory) -> Mapping[str, Hypothesis]:
        """What each filter of a bank believes, by name, in its own world; empty for a single filter."""
        ...


@runtime_checkable
class Tracker(Protocol):
    """A goal → a reference that an aircraft can follow. `goal` is None between the mission's ticks."""

    def init(self, estimate: Estimate, last: Reference | None) -> Memory:
        """Memory that continues from the last reference, else from the estimate."""
        ...

    def step(
        self, memory: Memory, estimate: Estimate, goal: Goal | None, dt: float
    ) -> tuple[Memory, Reference]:
        """One tick of `dt` [s]."""
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """The same memory, told in the new world."""
        ...


@runtime_checkable
class Controller(Protocol):
    """An estimate and a reference → a command."""

    def init(self, estimate: Estimate, last: Command | None) -> Memory:
        """Memory that continues from the last command."""
        ...

    def step(
        self, memory: Memory, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Memory, Command]:
        """One tick of `dt` [s]."""
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """The same memory, told in the new world."""
        ...


@runtime_checkable
class Mission(Protocol):
    """What to do: the estimate → a goal or an order, at the mission's rate; None: the last one still stands."""

    def init(self, estimate: Estimate) -> Memory:
        """Memory of a mission that starts here."""
        ...

    def step(
        self, memory: Memory, estimate: Estimate, dt: float
    ) -> tuple[Memory, Goal | Order | None]:
        """One tick of `dt` [s]."""
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """The same memory, told in the new world."""
        ...


class Event(NamedTuple):
    """Something that a pilot did, or would not do."""

    t: float  # [s] since its `init`
    kind: str  # mode, tracker, controller, estimator, gains, limits, refused, safety, …
    name: str  # of the mode, of the part, of what was refused or seen
    said: str  # what became of it, or why


class Report(NamedTuple):
    """What a pilot is doing."""

    mode: str  # empty: it has none
    events: tuple[Event, ...]  # since `init`
    over: str = ""  # "landed" or "failsafe": the motors may be off; empty: it flies on


@runtime_checkable
class Pilot(Protocol):
    """An estimate, readings and what is asked → a reference and a command: who flies, and whether it may."""

    def init(self, estimate: Estimate, ground: bool) -> Memory:
        """Memory of a flight that begins here: on the ground, or in the air as it is."""
        ...

    def step(
        self,
        memory: Memory,
        estimate: Estimate,
        readings: Readings,
        asked: Sequence[Goal | Order],
        dt: float,
    ) -> tuple[Memory, Reference, Command]:
        """One tick of `dt` [s]; `asked` are the goals and orders of this tick, in their order."""
        ...

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """The same memory, told in the new world."""
        ...

    def report(self, memory: Memory) -> Report:
        """What it does, and what it did."""
        ...


class Stack(NamedTuple):
    """The mind of an aircraft: one part for each slot, and who wrote which function."""

    estimator: Estimator
    tracker: Tracker
    controller: Controller
    provenance: Mapping[str, str] = {}  # function or part → mine, reference or stand-in
    pilot: Pilot | None = (
        None  # who decides what flies; None: tracker and controller fly, nothing is watched
    )


def standing_command(mass: float) -> Command:
    """What an aircraft that hovers at rest is told: its weight as thrust [N], and no rates."""
    return Command(mass * GRAVITY, np.zeros(3), np.zeros(3))


def asks(stem: str) -> Any:
    """A dataclass field for a function that lab `stem` asks a student to write.

    It has no default: `uavlab.flight.fill` finds the student's own, else the reference, else the
    stand-in flies.
    """
    return field(metadata={"stem": stem})
