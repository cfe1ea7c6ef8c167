"""Fill the parts with functions: mine, else the reference's, else a stand-in flies. The one door to the solutions.

A part declares the functions that it needs with `uavlab.interfaces.asks`. Some parts are answers as a whole: these go
by their name. Where all of it comes from is kept, and printed under every plot: an old bug of one's own should be seen,
not suspected.
"""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, NamedTuple

from uavlab.errors import BadInput, UavlabError
from uavlab.flight import known
from uavlab.flight.known import ASKED
from uavlab.gains import MpcGains, mpc_gains_for
from uavlab.interfaces import Stack
from uavlab.parts.controllers import TiltAxis
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import load_airframe

MINE, REFERENCE, STAND_IN = "mine", "reference", "stand-in"


SLOTS = ("estimator", "tracker", "controller")
LIMITS = "medium"  # the group of limits of a part that has none by itself


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
    Part: type | str,
    mine: Mapping[str, Any] | None = None,
    *,
    only_mine: bool = False,
    **parameters: Any,
) -> Filled:
    """Build a part from the functions that can be found for it, or find the whole part by its name.

    Parameters
    ----------
    Part : type or str
        A dataclass whose functions are declared with `asks`; or a part that a lab asks for as a whole,
        such as ``"GeometricController"``, by its name or as a class; or the name of a class in `mine`, of a part that
        comes with uavlab, or of one that another package brings (`uavlab.flight.known`).
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
        part's ``stand_in`` flies instead of the whole. A part by name that is nobody's answer comes from
        ``"uavlab"`` or from the package that brought it.

    Raises
    ------
    UnknownName
        Nobody has a part of this name.
    BadInput
        A parameter is missing, or is none of the part; or another package's part cannot be had.
    """
    if isinstance(Part, str) or not any("stem" in x.metadata for x in _fields(Part)):
        return _whole(Part, mine or {}, only_mine, parameters)
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
    if missing and not hasattr(Part, "stand_in"):
        raise BadInput(
            f"{Part.__name__} needs {', '.join(missing)}, and nobody has it; write it, or give the class a stand_in."
        )
    if missing:  # all or nothing: half a part of each kind would be neither
        said = f"{Part.__name__} without {', '.join(missing)}"
        return Filled(Part.stand_in(**parameters), {said: STAND_IN})  # type: ignore[attr-defined]
    return Filled(Part(**functions, **parameters), provenance)


def exchanged(mind: Stack, slot: str, filled: Filled) -> Stack:
    """The same mind with another part in one slot.

    Raises
    ------
    BadInput
        The part belongs into another slot.
    """
    has = getattr(filled.part, "slot", None)
    if has != slot:
        raise BadInput(
            f"{', '.join(filled.provenance)} is no {slot}" + (f" but a {has}." if has else ".")
        )
    old = getattr(mind, slot)
    gone = {type(old).__name__, *(x.name for x in _fields(old))}
    kept = {name: who for name, who in mind.provenance.items() if name not in gone}
    return mind._replace(**{slot: filled.part, "provenance": kept | filled.provenance})


def _whole(
    Part: type | str, mine: Mapping[str, Any], only_mine: bool, parameters: Mapping[str, Any]
) -> Filled:
    """A part that somebody wrote as a whole."""
    if isinstance(Part, type) and not (Part.__name__ in ASKED and unfinished(Part)):
        return Filled(_made(Part, parameters), {Part.__name__: author(Part)})
    name = Part if isinstance(Part, str) else Part.__name__
    own = mine.get(name)
    if callable(own) and not unfinished(own):
        return Filled(_made(own, parameters), {name: author(own)})
    if name not in ASKED:
        return _known(name, mine, only_mine, parameters)
    known.unambiguous(name)
    asked = ASKED[name]
    if not only_mine and (found := reference(asked.stem, name)) is not None:
        return Filled(_made(found, parameters), {name: REFERENCE})
    return Filled(_stand_in(asked.slot, parameters.get("mass")), {name: STAND_IN})


def _known(
    name: str, mine: Mapping[str, Any], only_mine: bool, parameters: Mapping[str, Any]
) -> Filled:
    """A part by name that is no lab's: uavlab's own, or that of another package."""
    part, origin = known.find(name)
    try:
        if any("stem" in x.metadata for x in _fields(part)):
            return fill(part, mine, only_mine=only_mine, **parameters)
        return Filled(_made(part, parameters), {name: origin})
    except UavlabError as error:
        raise BadInput(f"{name}, from {origin}: {error}") from None
    except Exception as error:  # whatever somebody else's code raises
        said = f"{type(error).__name__}: {error}"
        raise BadInput(f"{name}, from {origin}, cannot be made: {said}.") from error


def _made(Part: Callable[..., Any], parameters: Mapping[str, Any]) -> Any:
    """The part with these parameters; limits and gains that it was not told are usual ones, for its mass."""
    has = inspect.signature(Part).parameters
    told = dict(parameters)
    if "limits" in has and has["limits"].default is inspect.Parameter.empty:
        from uavlab.limits import limit_group

        told.setdefault("limits", limit_group(LIMITS))
    if "mass" in told and "gains" in has and isinstance(has["gains"].default, MpcGains):
        told.setdefault("gains", mpc_gains_for(told["mass"]))
    try:
        inspect.signature(Part).bind(**told)
    except TypeError as error:
        said = f"{getattr(Part, '__name__', Part)} takes {', '.join(has) or 'no parameters'}"
        raise BadInput(f"{said}; {error}.") from None
    return Part(**told)


def _stand_in(slot: str, mass: float | None) -> Any:
    """What flies where nothing better was found."""
    if slot == "controller":
        if mass is None:
            raise BadInput("the stand-in of a controller must know the mass; give mass=… [kg].")
        return TiltAxis(mass)
    return AlphaBetaGamma() if slot == "estimator" else CommandFilter()


def _fields(Part: Any) -> tuple[Any, ...]:
    return fields(Part) if is_dataclass(Part) else ()


def told(Part: type | str, airframe: Any, mine: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """What `fill` should tell a part of its aircraft: what its signature asks for of mass [kg] and thrust curve.

    Parameters
    ----------
    Part : type or str
        As for `fill`.
    airframe : Airframe
        From `uavlab.plant.load_airframe`.
    mine : mapping, optional
        As for `fill`.

    Raises
    ------
    UnknownName, BadInput
        There is no part of this name.
    """
    if isinstance(Part, type) and not (Part.__name__ in ASKED and unfinished(Part)):
        return known.told(Part, airframe)
    name = Part if isinstance(Part, str) else Part.__name__
    own = (mine or {}).get(name)
    if callable(own) and not unfinished(own):
        return known.told(own, airframe)
    if name not in ASKED:
        return known.told(known.find(name).part, airframe)
    return {"mass": float(airframe.m)} if ASKED[name].slot == "controller" else {}


def stack(airframe: str, *parts: Any, mine: Mapping[str, Any] | None = None) -> Stack:
    """The mind of an aircraft: the given parts, and stand-ins in the slots that they leave free.

    Parameters
    ----------
    airframe : str
        Whose mass and thrust curve the parts are told, if they ask for it.
    *parts : type, str, Filled or part
        At most one for each slot (``estimator``, ``tracker``, ``controller``). A class or a name, such as
        ``"MpcTracker"``, is filled with `fill`; an object flies as it is. A tracker that comes by this name keeps
        to half of what an MPC controller may do (MRS Sec. 5.7.2).
    mine : mapping, optional
        Where `fill` looks first, usually ``globals()``.

    Raises
    ------
    BadInput
        A part without a slot, or two for one slot; or another package's part cannot be had.
    UnknownName
        No airframe, or no part, of this name.
    """
    aircraft = load_airframe(airframe)
    slots: dict[str, Any] = {}
    provenance: dict[str, str] = {}
    for given in parts:
        filled: Any = given
        if isinstance(given, type | str):
            filled = fill(given, mine, **told(given, aircraft, mine))
        if not isinstance(filled, Filled):
            filled = Filled(filled, {type(filled).__name__: author(type(filled))})
        slot = getattr(filled.part, "slot", None)
        if slot not in SLOTS or slot in slots:
            raise BadInput(
                f"{type(filled.part).__name__} has slot {slot!r}"
                + (", which is taken already" if slot in slots else "")
                + "; a stack has one estimator, one tracker and one controller."
            )
        slots[slot] = filled.part
        provenance |= filled.provenance
    for slot in SLOTS:
        if slot not in slots:
            slots[slot] = _stand_in(slot, float(aircraft.m))
            provenance[type(slots[slot]).__name__] = STAND_IN
    mind = Stack(**slots, provenance=provenance)
    return slowed(mind) if "MpcTracker" in parts else mind


def slowed(mind: Stack) -> Stack:
    """The same mind, its tracker within half of what its controller may do, if both have limits (MRS Sec. 5.7.2)."""
    from uavlab.limits import ForceLimits, Limits, half_of

    theirs, ours = (getattr(x, "limits", None) for x in (mind.controller, mind.tracker))
    if not (isinstance(theirs, ForceLimits) and isinstance(ours, Limits)):
        return mind
    if not is_dataclass(mind.tracker) or isinstance(mind.tracker, type):
        return mind
    return mind._replace(tracker=replace(mind.tracker, limits=half_of(theirs, ours)))
