"""Slots for a flight: parts by name, and who wrote what in them; and what a scenario's swaps need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from uavlab.errors import BadInput, UnknownName
from uavlab.flight.fill import Filled, author, fill, told
from uavlab.flight.known import slot_of
from uavlab.flight.scenario import SWAPPED, Scenario
from uavlab.interfaces import Stack
from uavlab.parts.estimator_slot import EstimatorSlot
from uavlab.parts.slot import Slot
from uavlab.parts.vetted import Vetted
from uavlab.plant import load_airframe

__all__ = ["EstimatorSlot", "Slot", "slotted", "swappable", "swapped", "with_slots"]


def slotted(parts: Mapping[str, Any], first: str = "") -> Filled:
    """A `Slot` of these parts, or an `EstimatorSlot` if they are estimators, and who wrote what in them.

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
        As `Slot` and `EstimatorSlot`.
    """
    plain, provenance = {}, {}
    for name, given in parts.items():
        filled = given if isinstance(given, Filled) else None
        plain[name] = filled.part if filled else given
        wrote = filled.provenance if filled else {type(given).__name__: author(type(given))}
        provenance |= {f"{name}.{what}": who for what, who in wrote.items()}
    estimators = all(getattr(x, "slot", None) == "estimator" for x in plain.values())
    make = EstimatorSlot if plain and estimators else Slot
    return Filled(make(plain, first), provenance)


def swappable(scenario: Scenario, mind: Stack) -> None:
    """Refuse a scenario whose swaps this mind cannot obey. What a pilot flies is his own; he refuses in flight.

    Raises
    ------
    BadInput
        A slot of the mind is no `Slot` or `EstimatorSlot` or bank, or has no part of that name.
    """
    for swap in scenario.swaps:
        if mind.pilot is not None and swap.slot != "estimator":
            continue
        part = getattr(mind, swap.slot)
        where = f"scenario {scenario.name!r}: at {swap.t:g} s {swap.name!r} is to take over as {swap.slot}"
        names = swapped(part)
        if not names:
            kind = "EstimatorSlot" if swap.slot == "estimator" else "Slot"
            raise BadInput(
                f"{where}, but the {swap.slot} is {type(part).__name__} alone. "
                f"Put a uavlab.flight.slot.{kind} there that has both."
            )
        if swap.name not in names:
            unknown = UnknownName(f"part of the {swap.slot}'s slot", swap.name, names)
            raise BadInput(f"{where}: {unknown}")


def swapped(part: Any) -> tuple[str, ...]:
    """Whom a swap of this part may name; empty if it is one part alone."""
    return tuple(part.parts) if isinstance(part, Slot) else tuple(getattr(part, "names", ()))


def with_slots(scenario: Scenario, mind: Stack) -> Stack:
    """The same mind with a `Slot` wherever the scenario swaps a part and there is none.

    In such a slot are the part that is there, by the name of its class, and those that the swaps name, which must be
    known to `uavlab.flight.fill.fill`. Estimators go into an `EstimatorSlot`, inside of a `Vetted` if there is one;
    filters of a bank are swapped by the bank itself. Trackers and controllers of a pilot are his own.

    Raises
    ------
    BadInput
        A swap names a part that nobody knows, or one of another slot.
    """
    for slot in SWAPPED:
        old: Any = getattr(mind, slot)
        has = swapped(old)
        asked = [x.name for x in scenario.swaps if x.slot == slot and x.name not in has]
        flown = mind.pilot is not None and slot != "estimator"
        if flown or not asked or isinstance(old, Slot | EstimatorSlot):
            continue
        vetted = old if isinstance(old, Vetted) else None
        if vetted is not None:
            old = vetted.estimator
        try:
            made = _slot_of(slot, old, dict.fromkeys(asked), load_airframe(scenario.airframe))
        except (UnknownName, BadInput) as error:
            raise BadInput(f"scenario {scenario.name!r}, swaps of the {slot}: {error}") from None
        was = type(old).__name__
        more = {k: v for k, v in made.provenance.items() if not k.startswith(f"{was}.")}
        part = made.part if vetted is None else replace(vetted, estimator=made.part)
        mind = mind._replace(**{slot: part}, provenance={**mind.provenance, **more})
    return mind


def _slot_of(slot: str, old: Any, asked: Mapping[str, None], airframe: Any) -> Filled:
    """The old part, by the name of its class, and those that are asked for, by theirs."""
    was = type(old).__name__
    parts: dict[str, Any] = {was: old}
    for name in asked:
        if name != was:
            has = slot_of(name)
            if has != slot:
                raise BadInput(f"{name} is {'an' if has[0] == 'e' else 'a'} {has}.")
            parts[name] = fill(name, **told(name, airframe))
    return slotted(parts)
