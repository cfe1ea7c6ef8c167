"""A slot: parts by name, one of them flies; another takes over in mid-flight, and nothing is felt (MRS Sec. 7).

Gains and limits are swapped the same way: a controller with other gains is another part, by another name.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadInput, UnknownName
from uavlab.frames import Shift, moved
from uavlab.interfaces import Memory
from uavlab.parts.trackers import carried
from uavlab.types import Command, Estimate, Reference, Trajectory

GIVES: Mapping[str, type] = {"tracker": Reference, "controller": Command}
FIRST, TAKEN = "first", "taken over"  # what a log says of a part
REHEARSED = 2  # steps: the first repeats the last output, and may hide what comes after it


class Flying(NamedTuple):
    """Memory of a `Slot`."""

    name: str  # who flies
    memory: Memory  # of who flies
    last: Any = None  # a command as it went out; a reference as it goes on to the next tick; None: nothing yet
    goal: Any = None  # of a tracker: what it was told last, as it stands at the next tick
    asked: str = ""  # who is to take over at the next step; empty: nobody
    waiting: Memory = None  # of who is asked
    said: str = ""  # why the last swap was refused; empty: it was not
    refused: int = 0  # swaps, since `init`


class _Unfit(Exception):
    """What a part gave cannot be flown."""


@dataclass(frozen=True)
class Slot:
    """A tracker or a controller that is several: parts by name, one of which flies.

    Whoever takes over begins with what its predecessor gave last: a controller with its command, a tracker with its
    reference, carried on by the tick that has passed since, and with the goal that still stands. It is refused if its
    ``init`` or one of its first two steps raises, or gives what is not finite; the predecessor then flies on, and
    ``refused`` and ``said`` of the memory tell of it. Parts must be pure for this, as a law of theirs says: a step that
    was refused leaves no trace.

    Parameters
    ----------
    parts : mapping of str to part
        All trackers or all controllers. `uavlab.flight.slot.slotted` also takes what `uavlab.flight.fill.fill` gives.
    first : str, optional
        Who flies after ``init``; the first of `parts` if it is empty.

    Raises
    ------
    BadInput
        No parts, a name that is no text, or parts that do not belong into one slot.
    UnknownName
        `first` is none of the parts.
    """

    parts: Mapping[str, Any]
    first: str = ""

    def __post_init__(self) -> None:
        if not self.parts:
            raise BadInput("a Slot got no parts; give it {'name': part, …}.")
        for name, part in self.parts.items():
            if not (isinstance(name, str) and name):
                raise BadInput(f"a part of a Slot is named {name!r}; give it a text.")
            has = getattr(part, "slot", None)
            if has not in GIVES or has != self.slot:
                raise BadInput(
                    f"part {name!r} of a Slot is {type(part).__name__} with slot {has!r}; all parts of one Slot must "
                    f"be trackers, or all controllers."
                )
        if self.first:
            self._known(self.first)

    @property
    def slot(self) -> str:
        """Where it belongs: ``"tracker"`` or ``"controller"``."""
        return getattr(next(iter(self.parts.values())), "slot", "")

    def init(self, estimate: Estimate, last: Any) -> Flying:
        """The first part takes over from `last`, a command or a reference; None: it begins at the estimate."""
        name = self.first or next(iter(self.parts))
        return Flying(name, self.parts[name].init(estimate, last), last)

    def swap(self, memory: Flying, name: str, estimate: Estimate) -> Flying:
        """Ask part `name` to take over at the next step.

        Parameters
        ----------
        memory : Flying
            Of this slot.
        name : str
            One of the parts; the one that flies begins anew.
        estimate : Estimate
            Of now.

        Returns
        -------
        Flying
            The same part flies on until the next step; ``asked`` says who is to come. If `name` cannot even begin, it
            is refused here: see ``said``.

        Raises
        ------
        UnknownName
            No part has this name.
        """
        self._known(name)
        try:
            waiting = self.parts[name].init(estimate, memory.last)
        except Exception as error:  # whatever it raises, the other one can fly on
            return _refused(memory, name, error)
        return memory._replace(asked=name, waiting=waiting, said="")

    def step(self, memory: Flying, estimate: Estimate, given: Any, dt: float) -> tuple[Flying, Any]:
        """One tick of `dt` [s] of who flies; `given` is a goal or None for a tracker, a reference for a controller."""
        tracks = self.slot == "tracker"
        goal = memory.goal if tracks and given is None else given
        out = None
        if memory.asked:
            try:
                inner, out = self._rehearsed(memory, estimate, goal, dt)
                memory = memory._replace(
                    name=memory.asked, memory=inner, asked="", waiting=None, said=""
                )
            except Exception as error:  # as above
                memory, out = _refused(memory, memory.asked, error), None
        if out is None:
            inner, out = self.parts[memory.name].step(memory.memory, estimate, given, dt)
            memory = memory._replace(memory=inner)
        if tracks:
            return memory._replace(last=carried(out, dt), goal=_later(goal, dt)), out
        return memory._replace(last=out), out

    def reframe(self, memory: Flying, shift: Shift) -> Flying:
        """Who flies, who is to take over, and what both were told, in the new world."""
        waiting = memory.waiting
        if memory.asked:
            waiting = self.parts[memory.asked].reframe(waiting, shift)
        return memory._replace(
            memory=self.parts[memory.name].reframe(memory.memory, shift),
            waiting=waiting,
            last=None if memory.last is None else moved(memory.last, shift),
            goal=None if memory.goal is None else moved(memory.goal, shift),
        )

    def _known(self, name: str) -> None:
        if name not in self.parts:
            raise UnknownName(f"part of the {self.slot}'s slot", name, self.parts)

    def _rehearsed(
        self, memory: Flying, estimate: Estimate, given: Any, dt: float
    ) -> tuple[Memory, Any]:
        """The first step of who is asked, if that and the next one can be flown."""
        part, now, first = self.parts[memory.asked], memory.waiting, None
        for _ in range(REHEARSED):
            now, out = part.step(now, estimate, given, dt)
            if why := _unfit(out, GIVES[self.slot]):
                raise _Unfit(why)
            first = first or (now, out)
            given = None if self.slot == "tracker" else given
        assert first is not None
        return first


def _refused(memory: Flying, name: str, error: Exception) -> Flying:
    said = f"{type(error).__name__}: {error}"
    said = str(error) if isinstance(error, _Unfit) else f"it raised {said}"
    return memory._replace(
        asked="", waiting=None, said=f"{name}: {said}", refused=memory.refused + 1
    )


def _unfit(out: Any, kind: type) -> str:
    """Why this is no output to fly: the culprit and its value; empty if it is one."""
    if not isinstance(out, kind):
        return f"it gave {type(out).__name__}, no {kind.__name__}"
    for name, value in zip(out._fields, out, strict=True):  # type: ignore[attr-defined]
        if not np.isfinite(np.asarray(value, dtype=float)).all():
            return f"its {name} is {value}"
    return ""


def _later(goal: Any, dt: float) -> Any:
    """A goal as it stands after `dt` [s]."""
    if isinstance(goal, Trajectory):
        return goal._replace(t=goal.t - dt)
    return carried(goal, dt) if isinstance(goal, Reference) else goal
