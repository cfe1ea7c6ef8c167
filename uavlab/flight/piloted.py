"""A whole mind with a safe pilot: where airframe, gains, limits and parts meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass, replace
from typing import Any, NamedTuple

from uavlab.area import Area
from uavlab.errors import BadInput, UnknownName
from uavlab.flight.fill import SLOTS, STAND_IN, Filled, author, fill, told
from uavlab.flight.scenario import Scenario
from uavlab.flight.slot import slotted
from uavlab.gains import GROUPS as GAINS
from uavlab.gains import OF_AIRFRAME, MpcGains, mpc_gains_for
from uavlab.interfaces import Stack
from uavlab.limits import ForceLimits, Limits, half_of, limit_group
from uavlab.managers.groups import ALLOWED, HALF, Allowed
from uavlab.managers.pilot import SafePilot
from uavlab.managers.safety import Safety
from uavlab.managers.takeover import DOWN, RESCUER, SOON, SPEED, UP
from uavlab.parts.emergency import Emergency
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.landoff import EMERGENCY, LandOff
from uavlab.parts.line import LineTracker
from uavlab.parts.speed import SpeedTracker
from uavlab.parts.throttle import ThrustCurve
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import Airframe, load_airframe

LIFT = 1.5  # [m] of a take-off that names no height; an order does
LIMITS = ("medium", "slow", "fast")  # the first of them fly first
SPEEDS = {
    SPEED: (False, False), f"{SPEED} z": (True, False), f"{SPEED} heading": (False, True),
    f"{SPEED} z heading": (True, True),
}  # fmt: skip


def piloted(
    scenario: Scenario | str,
    *parts: Any,
    mine: Mapping[str, Any] | None = None,
    area: Area | None = None,
    safety: Safety | None = None,
    allowed: Mapping[str, Allowed] = ALLOWED,
    gains: str = "",
    lifts: str = "",
    lands: str = "",
    **more: Any,
) -> Stack:
    """A mind that takes off, lands, refuses, and comes down when something breaks: `SafePilot` and all its parts.

    Parameters
    ----------
    scenario : Scenario or str
        Of a scenario come airframe, safety area, and the estimator of its mind if it has one; or the airframe's name.
    *parts : type, str, Filled or part
        An estimator, and trackers and controllers, each as `uavlab.stack` takes them. The first tracker and the first
        controller among them fly first, instead of the MPC tracker and the geometric controller, which stay aboard.
        A class or a name flies in all groups of limits or gains that it can have; an object flies as it is.
    mine : mapping, optional
        Where answers are looked for first, usually ``globals()``.
    area : Area, optional
        In place of the scenario's.
    safety : Safety, optional
        Limits of the watch. What is said of a thrust curve there is kept; else it is the airframe's.
    allowed : mapping of str to Allowed
        Which groups of limits and gains may be flown in the world of which estimator.
    gains : str
        The group of gains that flies first. If nothing is said it is "soft"; where the stand-in of an estimator may fly
        "supersoft", for that lags, and with its soft gains an F550 swings itself up behind it.
    lifts, lands : str
        The controllers of take-off and landing; empty: the one that is wanted.
    **more
        Other fields of `SafePilot`: ``bumper``, ``remote``, ``unsteered``.

    Raises
    ------
    BadInput, UnknownName
        A part cannot be had, or belongs into no slot; two estimators; a figure is none.
    """
    flies = scenario if isinstance(scenario, Scenario) else None
    name = scenario if isinstance(scenario, str) else scenario.airframe
    aircraft = load_airframe(name)
    curve = ThrustCurve(float(aircraft.a_t), float(aircraft.b_t))
    safety = safety or Safety()
    given = _given(parts, aircraft, mine)
    trackers = slotted(_trackers(given["tracker"], mine))
    estimator = _estimator(given["estimator"], flies)
    gains = gains or ("supersoft" if _lags(estimator.part) else "soft")
    controllers = slotted(_controllers(given["controller"], aircraft, mine, gains))
    pilot = SafePilot(
        trackers.part, controllers.part, float(aircraft.m), curve,
        area=area or (flies.area if flies else None),
        safety=safety if safety.curve else safety._replace(curve=curve),
        allowed=allowed, lifts=lifts, lands=lands, **more,
    )  # fmt: skip
    provenance = {**estimator.provenance, **trackers.provenance, **controllers.provenance}
    return Stack(estimator.part, trackers.part, controllers.part, _shortened(provenance), pilot)


class _Given(NamedTuple):
    """A part that was given."""

    filled: Filled
    what: Any  # a class or a name, which flies in groups; None: an object, which flies as it is


def _given(
    parts: tuple[Any, ...], aircraft: Airframe, mine: Mapping[str, Any] | None
) -> dict[str, dict[str, _Given]]:
    """The parts that were given, by slot and name."""
    found: dict[str, dict[str, _Given]] = {slot: {} for slot in SLOTS}
    for one in parts:
        named = isinstance(one, type | str)
        filled: Any = fill(one, mine, **told(one, aircraft, mine)) if named else one
        if not isinstance(filled, Filled):
            filled = Filled(filled, {type(filled).__name__: author(type(filled))})
        kind = type(filled.part).__name__
        slot = getattr(filled.part, "slot", None)
        if slot not in SLOTS:
            raise BadInput(f"{kind} has slot {slot!r}; a pilot takes {', '.join(SLOTS)}.")
        name = one if isinstance(one, str) else getattr(one, "__name__", kind)
        if name in found[slot]:
            raise BadInput(
                f"two parts are called {name}; give one of them, or a class of your own."
            )
        found[slot][name] = _Given(filled, one if named else None)
    if len(found["estimator"]) > 1:
        names = ", ".join(found["estimator"])
        raise BadInput(f"estimators {names}; a mind has one. Put them into an EstimatorSlot.")
    return found


def _estimator(given: Mapping[str, _Given], flies: Scenario | None) -> Filled:
    """The estimator that was given, that of the scenario's mind, or the stand-in."""
    for one in given.values():
        return one.filled
    if flies is not None and flies.mind is not None:
        mind = flies.mind(flies.airframe)
        theirs = {type(x).__name__ for x in (mind.tracker, mind.controller)}
        return Filled(
            mind.estimator, {k: who for k, who in mind.provenance.items() if k not in theirs}
        )
    return Filled(AlphaBetaGamma(), {"AlphaBetaGamma": STAND_IN})


def _lags(estimator: Any) -> bool:
    """Whether the stand-in of an estimator may fly: alone, behind a doorkeeper, or among others."""
    within = [
        getattr(estimator, "estimator", None),
        *dict(getattr(estimator, "parts", {})).values(),
    ]
    return isinstance(estimator, AlphaBetaGamma) or any(_lags(x) for x in within if x is not None)


def _trackers(given: Mapping[str, _Given], mine: Mapping[str, Any] | None) -> dict[str, Filled]:
    """All trackers by name, those that were given first."""
    out: dict[str, Filled] = {}
    for name, one in given.items():
        out |= {name: one.filled} if one.what is None else _paced(name, one.filled)
    if "MpcTracker" not in given:
        out |= _paced("MpcTracker", fill("MpcTracker", mine, limits=limit_group(LIMITS[0])))
    line, up, down, soon = LineTracker(), LandOff(LIFT), LandOff(), LandOff(sink=EMERGENCY)
    for name, part in (("LineTracker", line), (UP, up), (DOWN, down), (SOON, soon)):
        out.setdefault(name, _ours(part))
    for name, (z, nose) in SPEEDS.items():
        one = SpeedTracker(limit_group(LIMITS[0]), keeps_height=z, keeps_heading=nose)
        out |= _paced(name, _ours(one))
    return out


def _ours(part: Any) -> Filled:
    """A part that comes with uavlab."""
    return Filled(part, {type(part).__name__: "uavlab"})


def _paced(name: str, filled: Filled) -> dict[str, Filled]:
    """A tracker with each group of limits, whole and leaving an MPC controller room; alone if it has its own pace."""
    part: Any = filled.part
    if not is_dataclass(part) or isinstance(part, type):
        return {name: filled}
    out = {}
    for group in LIMITS:
        whole = limit_group(group)
        half = half_of(ForceLimits(), whole)
        for which, limits in ((group, whole), (f"{group} {HALF}", half)):
            if isinstance(getattr(part, "limits", None), Limits):
                paced = replace(part, limits=limits)
            elif type(part) is CommandFilter:
                paced = replace(part, v_max=limits.horizontal.v, heading_rate_max=limits.heading.v)
            else:
                return {name: filled}
            out[f"{name} {which}"] = filled._replace(part=paced)
    return out


def _controllers(
    given: Mapping[str, _Given], aircraft: Airframe, mine: Mapping[str, Any] | None, first: str
) -> dict[str, Filled]:
    """All controllers by name, those that were given first; the geometric one with each group of gains."""
    mass, se3 = float(aircraft.m), "GeometricController"
    out: dict[str, Filled] = {}
    for name in dict.fromkeys((*given, se3)):
        what = given[name].what if name in given else se3
        if name != se3 or what is None:
            filled = given[name].filled
            out[name] = filled if what is None else _following(filled)
            continue
        sets = GAINS[OF_AIRFRAME.get(aircraft.name, "now")]
        if first not in sets:
            raise UnknownName(f"group of gains of {aircraft.name}", first, sets)
        for group in sorted(sets, key=lambda x: x != first):
            out[f"{se3} {group}"] = fill(what, mine, mass=mass, gains=sets[group])
    if "MpcController" not in given:
        gains = mpc_gains_for(mass)
        out["MpcController"] = _following(fill("MpcController", mine, mass=mass, gains=gains))
    return {**out, RESCUER: _ours(Emergency(mass))}


def _following(filled: Filled) -> Filled:
    """An MPC controller that plans along references that move, if it can: `uavlab reproduce mpc-errands`."""
    part: Any = filled.part
    gains = getattr(part, "gains", None)
    if not is_dataclass(part) or isinstance(part, type) or not isinstance(gains, MpcGains):
        return filled
    return filled._replace(part=replace(part, gains=gains._replace(follows=True)))


def _shortened(provenance: Mapping[str, str]) -> dict[str, str]:
    """Who wrote what, each part once, whatever its groups."""
    return {name.rpartition(".")[2]: who for name, who in provenance.items()}
