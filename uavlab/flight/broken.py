"""Broken parts: parts of a mind that raise, or give no numbers, while a fault lasts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from math import nan
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadInput, UnknownName
from uavlab.flight.fault import BROKEN, Fault
from uavlab.interfaces import Stack

KEPT = ("worlds", "shift", "world", "reliable")  # of an estimate: no measured numbers
ALL = "*"  # every part of a slot


class Broken:
    """A part as it is, but for the times at which `failing` says how it fails: ``raises``, ``nan`` or nothing.

    Whoever asks what it is hears what the part is: nobody should fly otherwise because it may break.
    """

    def __init__(self, part: Any, failing: Callable[[], str]) -> None:
        self.part, self.failing = part, failing

    @property
    def __class__(self) -> type:  # type: ignore[override]
        return type(self.part)

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
        if pilot is None or slot == "estimator":
            mind = mind._replace(**_breaking({slot: getattr(mind, slot)}, slot, mine, now))
        else:  # it flies its own parts; those of the stack are not asked
            mind = mind._replace(pilot=replace(pilot, **_breaking(_held(pilot), slot, mine, now)))  # type: ignore[type-var]
    return mind


class _Place(NamedTuple):
    """Where a part is held."""

    field: str
    member: str  # of the slot in that field; empty: the part is there alone
    names: tuple[str, ...]  # by which a fault may call it, the last one without its gains or limits


def _held(pilot: Any) -> dict[str, Any]:
    """What a pilot holds, by field."""
    known = fields(pilot) if is_dataclass(pilot) else ()
    return {x.name: getattr(pilot, x.name) for x in known if x.init}


def _members(held: Any) -> Mapping[str, Any] | None:
    """The parts of a slot, or parts by name; None of a part alone."""
    if isinstance(held, Mapping):
        return held
    parts = getattr(held, "parts", None)
    return parts if isinstance(parts, Mapping) and is_dataclass(held) else None


def _places(held: Mapping[str, Any], slot: str) -> list[_Place]:
    """Every part of this slot, in the order in which it is held; who flies first in a slot comes first."""
    out = []
    for field, part in held.items():
        members = _members(part)
        if members is None:
            has = getattr(part, "slot", None)
            if has == slot or (field == slot and callable(getattr(part, "step", None))):
                out.append(_Place(field, "", (field, type(part).__name__)))
            continue
        names = [x for x, y in members.items() if getattr(y, "slot", None) == slot]
        first = getattr(part, "first", "")
        out += [
            _Place(field, x, (x, x.split()[0])) for x in sorted(names, key=lambda x: x != first)
        ]
    return out


def _breaking(
    held: Mapping[str, Any], slot: str, faults: tuple[Fault, ...], now: Callable[[], float]
) -> dict[str, Any]:
    """What is held, by field, with the parts broken that the faults name; if they name none, the first one.

    "MpcTracker slow" is an MpcTracker with other limits, and breaks with it.
    """
    places = _places(held, slot)
    of: dict[_Place, list[Fault]] = {}
    for fault in faults:
        for place in _meant(fault, slot, places):
            of.setdefault(place, []).append(fault)
    out = dict(held)
    for place, mine in of.items():
        failing = _failing(tuple(mine), now)
        whole = out[place.field]
        if not place.member:
            out[place.field] = Broken(whole, failing)
            continue
        members = dict(_members(whole) or {})
        members[place.member] = Broken(members[place.member], failing)
        alone = isinstance(whole, Mapping)
        out[place.field] = members if alone else replace(whole, parts=members)  # type: ignore[type-var]
    return out


def _meant(fault: Fault, slot: str, places: list[_Place]) -> list[_Place]:
    """The parts that a fault breaks."""
    if fault.of == ALL:
        found = places
    elif fault.of:
        found = [x for x in places if fault.of in x.names]
    else:
        found = [x for x in places if x.names[-1] == places[0].names[-1]]
    if found:
        return found
    known = {name for x in places for name in x.names}
    raise BadInput(
        f"a fault breaks {fault.what!r}: {UnknownName(f'{slot} aboard', fault.of, known)}"
    )


def _failing(faults: tuple[Fault, ...], now: Callable[[], float]) -> Callable[[], str]:
    def how() -> str:
        t = now()
        return next((str(x.value) for x in faults if x.lasts(t)), "")

    return how
