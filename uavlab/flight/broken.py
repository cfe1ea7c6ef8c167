"""Broken parts: parts of a mind that raise, or give no numbers, while a fault lasts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from math import nan
from typing import Any

import numpy as np

from uavlab.errors import BadInput, UnknownName
from uavlab.flight.fault import BROKEN, Fault
from uavlab.interfaces import Stack

KEPT = ("worlds", "shift", "world", "reliable")  # of an estimate: no measured numbers
ALL = "*"  # every part of a slot


class Broken:
    """A part as it is, but for the times at which `failing` says how it fails: ``raises``, ``nan`` or nothing."""

    def __init__(self, part: Any, failing: Callable[[], str]) -> None:
        self.part, self.failing = part, failing

    def init(self, *given: Any) -> Any:
        """As the part's, or it raises."""
        self._raise()
        return self.part.init(*given)

    def step(self, *given: Any) -> Any:
        """As the part's, or it raises, or what it gives is no number.

        Raises
        ------
        RuntimeError
            While it is to raise.
        """
        self._raise()
        memory, out = self.part.step(*given)
        return memory, no_numbers(out) if self.failing() == "nan" else out

    def __getattr__(self, name: str) -> Any:
        return getattr(self.part, name)

    def _raise(self) -> None:
        if self.failing() == "raises":
            raise RuntimeError(f"{type(self.part).__name__} is broken, as the scenario says")


def no_numbers(out: Any) -> Any:
    """An estimate, a reference or a command, of which every number is NaN."""
    return out._replace(**{
        name: nan if np.ndim(value) == 0 else np.full(np.shape(value), nan)
        for name, value in out._asdict().items()
        if name not in KEPT
    })


def broken(mind: Stack, faults: tuple[Fault, ...], now: Callable[[], float]) -> Stack:
    """The mind with every part replaced that is to fail, in its own slots and in those of its pilot.

    Parameters
    ----------
    mind : Stack
        What flies.
    faults : tuple of Fault
        All of the flight.
    now : callable
        The time [s].

    Raises
    ------
    BadInput
        A slot has no part of the name that is to fail.
    """
    for slot in BROKEN:
        mine = tuple(x for x in faults if x.kind == "part" and x.name == slot)
        if not mine:
            continue
        pilot = mind.pilot
        parts = {} if pilot is None else _slots(pilot, slot)
        if parts:  # the pilot flies its own; those of the stack are not asked
            mind = mind._replace(pilot=replace(pilot, **{  # type: ignore[type-var]
                name: _breaking(part, slot, mine, now) for name, part in parts.items()
            }))  # fmt: skip
        else:
            mind = mind._replace(**{slot: _breaking(getattr(mind, slot), slot, mine, now)})
    return mind


def _slots(pilot: Any, slot: str) -> dict[str, Any]:
    """The fields of a pilot that hold parts of this slot."""
    if not is_dataclass(pilot):
        return {}
    held = {x.name: getattr(pilot, x.name) for x in fields(pilot) if x.init}
    return {name: part for name, part in held.items() if getattr(part, "slot", None) == slot}


def _breaking(part: Any, slot: str, faults: tuple[Fault, ...], now: Callable[[], float]) -> Any:
    """The part or, of a slot of several, those that the faults name; the first one if they name none."""
    members = getattr(part, "parts", None)
    if not (isinstance(members, Mapping) and is_dataclass(part)):
        alone = type(part).__name__
        _known(slot, faults, (alone,))
        return Broken(part, _failing(faults, now))
    _known(slot, faults, members)
    first = getattr(part, "first", "") or next(iter(members))
    changed = dict(members)
    for name in members:
        mine = tuple(x for x in faults if (x.of or first) in {name, ALL})
        if mine:
            changed[name] = Broken(members[name], _failing(mine, now))
    return replace(part, parts=changed)  # type: ignore[type-var]


def _known(slot: str, faults: tuple[Fault, ...], names: Any) -> None:
    for fault in faults:
        if fault.of not in {"", ALL, *names}:
            unknown = UnknownName(f"part of the {slot}'s slot", fault.of, names)
            raise BadInput(f"a fault breaks {fault.what!r}: {unknown}")


def _failing(faults: tuple[Fault, ...], now: Callable[[], float]) -> Callable[[], str]:
    def how() -> str:
        t = now()
        return next((str(x.value) for x in faults if x.lasts(t)), "")

    return how
