"""Fill the parts with functions: mine, else the reference's, else a stand-in flies. The one door to the solutions.

A part declares the functions that it needs with `uavlab.interfaces.asks`. Where they come from is kept, and printed
under every plot: an old bug of one's own should be seen, not suspected.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, NamedTuple

from uavlab.errors import BadInput
from uavlab.interfaces import Stack
from uavlab.parts.controllers import TiltAxis
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import load_airframe

MINE, REFERENCE, STAND_IN = "mine", "reference", "stand-in"


class Filled(NamedTuple):
    """A part that can fly, and who wrote what in it."""

    part: Any
    provenance: dict[str, str]  # function or part → mine, reference or stand-in


def unfinished(answer: Any) -> bool:
    """Whether `answer` is a stub that nobody has filled in: all that it does is say so.

    A class counts as unfinished as long as one of its public methods is: it could not fly.
    """
    if isinstance(answer, type):
        public = [value for name, value in vars(answer).items() if not name.startswith("_")]
        return any(unfinished(x) for x in public if not isinstance(x, type))
    code = getattr(answer, "__code__", None)
    if code is None or code.co_names != ("NotImplementedError",):
        return False
    return any(isinstance(c, str) and "is not finished yet" in c for c in code.co_consts)


def author(function: Any) -> str:
    """Who wrote a function that was given: a reference that was imported stays a reference."""
    home = str(getattr(function, "__module__", ""))
    return REFERENCE if home.startswith("uavlab.solutions") else MINE


def reference(stem: str, name: str) -> Callable[..., Any] | None:
    """The reference answer, if the solutions of this lab are installed."""
    try:
        module = importlib.import_module(f"uavlab.solutions.{stem}")
    except ModuleNotFoundError as missing:
        if str(missing.name).startswith("uavlab.solutions"):
            return None
        raise
    return getattr(module, name, None)


def fill(
    Part: type, mine: Mapping[str, Any] | None = None, *, only_mine: bool = False, **parameters: Any
) -> Filled:
    """Build a part from the functions that can be found for it.

    Parameters
    ----------
    Part : type
        A dataclass whose functions are declared with `asks`.
    mine : mapping, optional
        Where to look first, by name: usually ``globals()`` of a notebook. Stubs do not count.
    only_mine : bool
        Do not look for references.
    **parameters
        The part's other fields, such as ``mass`` [kg].

    Returns
    -------
    Filled
        The part, and the provenance of each of its functions. If one is missing everywhere, the
        part's ``stand_in`` flies instead of the whole.
    """
    functions, provenance, missing = {}, {}, []
    for item in fields(Part):
        stem = item.metadata.get("stem")
        if stem is None:
            continue
        own = (mine or {}).get(item.name)
        if callable(own) and not unfinished(own):
            functions[item.name], provenance[item.name] = own, author(own)
        elif not only_mine and (found := reference(stem, item.name)) is not None:
            functions[item.name], provenance[item.name] = found, REFERENCE
        else:
            missing.append(item.name)
    if missing:  # all or nothing: half a part of each kind would be neither
        said = f"{Part.__name__} without {', '.join(missing)}"
        return Filled(Part.stand_in(**parameters), {said: STAND_IN})  # type: ignore[attr-defined]
    return Filled(Part(**functions, **parameters), provenance)


def stack(airframe: str, *parts: Any, mine: Mapping[str, Any] | None = None) -> Stack:
    """The mind of an aircraft: the given parts, and stand-ins in the slots that they leave free.

    Parameters
    ----------
    airframe : str
        Whose mass the parts are told.
    *parts : type, Filled or part
        At most one for each slot (``estimator``, ``tracker``, ``controller``). A class is filled with
        `fill`; an object flies as it is.
    mine : mapping, optional
        Where `fill` looks first, usually ``globals()``.

    Raises
    ------
    BadInput
        A part without a slot, or two for one slot.
    """
    mass = float(load_airframe(airframe).m)
    slots: dict[str, Any] = {}
    provenance: dict[str, str] = {}
    for given in parts:
        wants_mass = isinstance(given, type) and any(f.name == "mass" for f in fields(given))
        told: dict[str, Any] = {"mass": mass} if wants_mass else {}
        filled = fill(given, mine, **told) if isinstance(given, type) else given
        if not isinstance(filled, Filled):
            filled = Filled(filled, {type(filled).__name__: MINE})
        slot = getattr(filled.part, "slot", None)
        if slot not in {"estimator", "tracker", "controller"} or slot in slots:
            raise BadInput(
                f"{type(filled.part).__name__} has slot {slot!r}"
                + (", which is taken already" if slot in slots else "")
                + "; a stack has one estimator, one tracker and one controller."
            )
        slots[slot] = filled.part
        provenance |= filled.provenance
    for slot, part in (
        ("estimator", AlphaBetaGamma()),
        ("tracker", CommandFilter()),
        ("controller", TiltAxis(mass)),
    ):
        if slot not in slots:
            slots[slot] = part
            provenance[type(part).__name__] = STAND_IN
    return Stack(**slots, provenance=provenance)
