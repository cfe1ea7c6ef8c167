"""A scenario: everything that a flight needs; it may name the mind that flies it if nobody brings another."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from uavlab.area import Area
from uavlab.errors import BadInput
from uavlab.flight.fault import Fault, checked_faults
from uavlab.interfaces import Mission, Stack
from uavlab.plant import CALM, Wind, load_airframe
from uavlab.plant.obstacles import Obstacle, checked_obstacles, hit
from uavlab.types import State

SWAPPED = ("estimator", "tracker", "controller")  # slots whose parts may be swapped in flight


class Swap(NamedTuple):
    """Another part takes over in mid-flight; the mind must have a `uavlab.flight.slot.Slot` there."""

    t: float  # [s] from take-off
    slot: str  # estimator, tracker or controller
    name: str  # of the part, in its slot


class Scenario(NamedTuple):
    """A named flight. Rates are data; change any field with ``scenario._replace(...)``."""

    name: str
    summary: str  # one sentence
    airframe: str  # a name of `uavlab.plant.airframe_names`, or the path of a TOML file
    mission: Mission
    start: State
    duration: float  # [s]
    sensors: Mapping[str, Any]  # instrument by name
    wind: Wind = CALM
    rate: float = 100.0  # [Hz] of estimator, tracker and controller
    physics: float = 1000.0  # [Hz] of the plant
    mission_rate: float = 100.0  # [Hz]
    reach: float = 500.0  # [m] from the start; beyond, the flight ends with Exit.AWAY
    mind: Callable[[str], Stack] | None = None  # airframe → who flies if nobody else is named
    swaps: tuple[Swap, ...] = ()  # who takes over, and when
    faults: tuple[Fault, ...] = ()  # what breaks, and when
    area: Area | None = None  # in which a pilot stays; None: everywhere
    obstacles: tuple[Obstacle, ...] = ()  # what stands in the way


def checked(scenario: Scenario) -> Scenario:
    """The same scenario, or a `BadInput` that names what cannot be flown."""
    for name in ("duration", "rate", "physics", "mission_rate", "reach"):
        value = getattr(scenario, name)
        if not (np.isfinite(value) and value > 0):
            raise BadInput(f"scenario {scenario.name!r}: {name} is {value}; it must be > 0.")
    for fast, slow in (("physics", "rate"), ("rate", "mission_rate")):
        ratio = getattr(scenario, fast) / getattr(scenario, slow)
        if abs(ratio - round(ratio)) > 1e-9 or ratio < 1:
            raise BadInput(
                f"scenario {scenario.name!r}: {fast} ({getattr(scenario, fast):g} Hz) must be a whole "
                f"multiple of {slow} ({getattr(scenario, slow):g} Hz)."
            )
    _check_swaps(scenario)
    checked_faults(scenario)
    _check_places(scenario)
    return scenario


def _check_places(scenario: Scenario) -> None:
    """Whether the aircraft starts where it may fly, beside all that stands there."""
    who, area, r = f"scenario {scenario.name!r}", scenario.area, scenario.start.r
    try:
        checked_obstacles(scenario.obstacles)
    except BadInput as error:
        raise BadInput(f"{who}: {error}") from None
    if scenario.obstacles:
        arm = float(load_airframe(scenario.airframe).arm)
        if it := hit(scenario.obstacles, r, arm):
            raise BadInput(
                f"{who}: the start, {r.tolist()} m, is less than the arm of {arm:g} m from the obstacle at "
                f"({it.x:g}, {it.y:g}) m; start farther away."
            )
    if area is None:
        return
    if not isinstance(area, Area):
        raise BadInput(f"{who}: area is {area!r}; it must be a uavlab.area.Area, or None.")
    standing_ = np.array([r[0], r[1], max(r[2], area.low)]) if r[2] <= 0.0 else r  # to take off
    if not area.world and (why := area.why_not_at(standing_)):
        raise BadInput(f"{who}: where it starts: {why}; or move the area.")


def _check_swaps(scenario: Scenario) -> None:
    taken: set[tuple[int, str]] = set()
    for k, swap in enumerate(scenario.swaps):
        where = f"scenario {scenario.name!r}: swaps[{k}]"
        if not (np.isfinite(swap.t) and swap.t >= 0.0):
            raise BadInput(f"{where}.t is {swap.t} s; it must be ≥ 0.")
        if swap.slot not in SWAPPED:
            raise BadInput(f"{where}.slot is {swap.slot!r}; it must be {' or '.join(SWAPPED)}.")
        tick = (round(swap.t * scenario.rate), swap.slot)
        if tick in taken:
            raise BadInput(
                f"{where}: a second {swap.slot} is to take over at {swap.t:g} s; leave a tick between them."
            )
        taken.add(tick)


def standing(r: tuple[float, float, float], heading: float = 0.0) -> State:
    """At rest at `r` [m], level, with `heading` [rad]."""
    from uavlab.so3 import about_z

    return State(np.array(r, dtype=float), np.zeros(3), about_z(heading), np.zeros(3))
