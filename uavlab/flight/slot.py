"""A slot: parts by name, one of them flies; another takes over in mid-flight, and nothing is felt (MRS Sec. 7).

Gains and limits are swapped the same way: a controller with other gains is another part, by another name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadInput, UnknownName
from uavlab.flight.fill import ASKED, Filled, author, fill
from uavlab.flight.scenario import SWAPPED, Scenario, Swap
from uavlab.frames import Shift, moved
from uavlab.interfaces import Memory, Stack
from uavlab.parts.trackers import carried
from uavlab.plant import load_airframe
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
        All trackers or all controllers. `slotted` also takes what `uavlab.flight.fill.fill` gives.
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


def slotted(parts: Mapping[str, Any], first: str = "") -> Filled:
    """A `Slot` of these parts, and who wrote what in them.

    Parameters
    ----------
    parts : mapping of str to part or Filled
        By name, as a swap calls them.
    first : str
        Who flies first; the first one if it is empty.

    Returns
    -------
    Filled
        For `uavlab.stack`. Its provenance says of each function or part where it comes from, ``name.part=who``.

    Raises
    ------
    BadInput, UnknownName
        As `Slot`.
    """
    plain, provenance = {}, {}
    for name, given in parts.items():
        filled = given if isinstance(given, Filled) else None
        plain[name] = filled.part if filled else given
        wrote = filled.provenance if filled else {type(given).__name__: author(type(given))}
        provenance |= {f"{name}.{what}": who for what, who in wrote.items()}
    return Filled(Slot(plain, first), provenance)


# In flight --------------------------------------------------------------------------------------------


def swappable(scenario: Scenario, mind: Stack) -> None:
    """Refuse a scenario whose swaps this mind cannot obey.

    Raises
    ------
    BadInput
        A slot of the mind is no `Slot`, or has no part of that name.
    """
    for swap in scenario.swaps:
        part = getattr(mind, swap.slot)
        where = f"scenario {scenario.name!r}: at {swap.t:g} s {swap.name!r} is to take over as {swap.slot}"
        if not isinstance(part, Slot):
            raise BadInput(
                f"{where}, but the {swap.slot} is {type(part).__name__} alone. "
                "Put a uavlab.flight.slot.Slot there that has both."
            )
        if swap.name not in part.parts:
            unknown = UnknownName(f"part of the {swap.slot}'s slot", swap.name, part.parts)
            raise BadInput(f"{where}: {unknown}")


def with_slots(scenario: Scenario, mind: Stack) -> Stack:
    """The same mind with a `Slot` wherever the scenario swaps a part and there is none.

    In such a slot are the part that is there, by the name of its class, and those that the swaps name, which must be
    known to `uavlab.flight.fill.fill`.

    Raises
    ------
    BadInput
        A swap names a part that nobody knows, or one of another slot.
    """
    mass = float(load_airframe(scenario.airframe).m)
    for slot in SWAPPED:
        old: Any = getattr(mind, slot)
        asked = [x.name for x in scenario.swaps if x.slot == slot]
        if not asked or isinstance(old, Slot):
            continue
        was = type(old).__name__
        told: Any = {"mass": mass} if slot == "controller" else {}
        try:
            for x in asked:
                if x in ASKED and ASKED[x].slot != slot:
                    raise BadInput(f"{x} is a {ASKED[x].slot}.")
            made = slotted({was: old} | {x: fill(x, **told) for x in asked if x != was})
        except (UnknownName, BadInput) as error:
            raise BadInput(f"scenario {scenario.name!r}, swaps of the {slot}: {error}") from None
        more = {k: v for k, v in made.provenance.items() if not k.startswith(f"{was}.")}
        mind = mind._replace(**{slot: made.part}, provenance={**mind.provenance, **more})
    return mind


class Swapping:
    """The swaps of one flight: which are still to come, and what became of the others."""

    def __init__(self, swaps: Sequence[Swap], mind: Stack) -> None:
        self.to_come = sorted(swaps, key=lambda x: x.t)
        self.parts = {name: getattr(mind, name) for name in SWAPPED}
        self.told: list[list[Any]] = []  # [s], slot, part, what became of it
        self.asked: Swap | None = None
        for name, part in self.parts.items():
            if isinstance(part, Slot):
                self.told.append([0.0, name, part.first or next(iter(part.parts)), FIRST])

    def ask(self, slot: str, memory: Memory, estimate: Estimate, t: float) -> Memory:
        """Before the step of `slot` at `t` [s]: who is due is asked to take over."""
        self.asked = next((x for x in self.to_come if x.slot == slot and x.t <= t + 1e-9), None)
        if self.asked is None:
            return memory
        self.to_come.remove(self.asked)
        return self.parts[slot].swap(memory, self.asked.name, estimate)

    def hear(self, memory: Memory, t: float) -> None:
        """After that step: what became of it."""
        if self.asked is not None:
            outcome = f"refused: {memory.said}" if memory.said else TAKEN
            self.told.append([t, self.asked.slot, self.asked.name, outcome])
