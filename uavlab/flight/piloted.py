"""A whole mind with a safe pilot: where airframe, gains, limits and parts meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass, replace
from typing import Any

from uavlab.area import Area
from uavlab.errors import BadInput
from uavlab.flight.fill import SLOTS, STAND_IN, Filled, author, fill, told
from uavlab.flight.scenario import Scenario
from uavlab.flight.slot import slotted
from uavlab.gains import GROUPS as GAINS
from uavlab.gains import OF_AIRFRAME, mpc_gains_for
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
LIMITS = ("medium", "slow", "fast")  # the first one flies first
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
    lifts: str = "MpcController",
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
        controller among them fly first, in place of the MPC tracker and the geometric controller, which stay aboard.
    mine : mapping, optional
        Where answers are looked for first, usually ``globals()``.
    area : Area, optional
        In place of the scenario's.
    safety : Safety, optional
        Limits of the watch. What is said of a thrust curve there is kept; else it is the airframe's.
    allowed : mapping of str to Allowed
        Which groups of limits and gains may be flown in the world of which estimator.
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
    controllers = slotted(_controllers(given["controller"], aircraft, mine))
    estimator, said = _estimator(given["estimator"], flies)
    pilot = SafePilot(
        trackers.part, controllers.part, float(aircraft.m), curve,
        area=area or (flies.area if flies else None),
        safety=safety if safety.curve else safety._replace(curve=curve),
        allowed=allowed, lifts=lifts, lands=lands, **more,
    )  # fmt: skip
    provenance = {**said, **trackers.provenance, **controllers.provenance}
    return Stack(estimator, trackers.part, controllers.part, _shortened(provenance), pilot)


def _given(
    parts: tuple[Any, ...], aircraft: Airframe, mine: Mapping[str, Any] | None
) -> dict[str, dict[str, Filled]]:
    """The parts that were given, by slot and name."""
    found: dict[str, dict[str, Filled]] = {slot: {} for slot in SLOTS}
    for one in parts:
        filled: Any = one
        name = one if isinstance(one, str) else getattr(one, "__name__", "")
        if isinstance(one, type | str):
            filled = fill(one, mine, **told(one, aircraft, mine))
        if not isinstance(filled, Filled):
            filled = Filled(filled, {type(filled).__name__: author(type(filled))})
        slot = getattr(filled.part, "slot", None)
        if slot not in SLOTS:
            raise BadInput(
                f"{type(filled.part).__name__} has slot {slot!r}; a pilot takes {', '.join(SLOTS)}."
            )
        found[slot][name or type(filled.part).__name__] = filled
    if len(found["estimator"]) > 1:
        raise BadInput(
            f"estimators {', '.join(found['estimator'])}; a mind has one. Put them into an EstimatorSlot."
        )
    return found


def _estimator(given: Mapping[str, Filled], flies: Scenario | None) -> tuple[Any, dict[str, str]]:
    """The estimator that was given, that of the scenario's mind, or the stand-in."""
    for name, filled in given.items():
        return filled.part, {name: "uavlab", **filled.provenance}
    if flies is not None and flies.mind is not None:
        mind = flies.mind(flies.airframe)
        return mind.estimator, dict(mind.provenance)
    return AlphaBetaGamma(), {"AlphaBetaGamma": STAND_IN}


def _trackers(given: Mapping[str, Filled], mine: Mapping[str, Any] | None) -> dict[str, Any]:
    """All trackers by name, those that were given first."""
    out: dict[str, Any] = {}
    for name, filled in given.items():
        out |= _paced(name, filled)
    if "MpcTracker" not in given:
        out |= _paced("MpcTracker", fill("MpcTracker", mine, limits=limit_group(LIMITS[0])))
    ours = {
        "LineTracker": LineTracker(),
        UP: LandOff(LIFT),
        DOWN: LandOff(),
        SOON: LandOff(sink=EMERGENCY),
    }
    out |= {name: _ours(part) for name, part in ours.items() if name not in out}
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
    given: Mapping[str, Filled], aircraft: Airframe, mine: Mapping[str, Any] | None
) -> dict[str, Any]:
    """All controllers by name, those that were given first."""
    mass = float(aircraft.m)
    out: dict[str, Any] = dict(given)
    if "GeometricController" not in given:
        sets = GAINS[OF_AIRFRAME.get(aircraft.name, "now")]
        for group in sorted(sets, key=lambda x: x != "soft"):
            filled = fill("GeometricController", mine, mass=mass, gains=sets[group])
            out[f"GeometricController {group}"] = filled
    if "MpcController" not in given:
        out["MpcController"] = fill("MpcController", mine, mass=mass, gains=mpc_gains_for(mass))
    out[RESCUER] = _ours(Emergency(mass))
    return out


def _shortened(provenance: Mapping[str, str]) -> dict[str, str]:
    """Who wrote what, each part once, whatever its groups."""
    return {name.rpartition(".")[2]: who for name, who in provenance.items()}
