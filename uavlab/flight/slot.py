"""Slots for a flight: parts by name, and who wrote what in them; and what a scenario's swaps need."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uavlab.errors import BadInput, UnknownName
from uavlab.flight.fill import ASKED, Filled, author, fill
from uavlab.flight.scenario import SWAPPED, Scenario
from uavlab.interfaces import Stack
from uavlab.parts.slot import Slot
from uavlab.plant import load_airframe

__all__ = ["Slot", "slotted", "swappable", "with_slots"]


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
