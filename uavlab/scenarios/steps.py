"""The steps of an errand, from a scenario's file: goals and orders for a pilot, one after the other."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from uavlab.errors import BadInput, UnknownName
from uavlab.orders import (
    EmergencyLand,
    Fall,
    Land,
    LandHome,
    LandThere,
    Order,
    TakeOff,
    Use,
    Velocity,
)
from uavlab.parts.errands import Errand, Step, Wait
from uavlab.parts.missions import still
from uavlab.parts.trackers import why_not
from uavlab.scenarios.values import array, get, items, known, number, numbers, refuse, text
from uavlab.types import Trajectory

SLOTS = ("estimator", "tracker", "controller", "gains", "limits")  # of what an order may ask to use
_DONE = ("near", "slow", "turned", "patience")  # when a step is done; see `Errand`
_Steps = tuple[Step, ...]


def errand(table: Mapping[str, Any]) -> Errand:
    """The errand of a table [mission] with ``kind = "errand"`` and ``steps``.

    Raises
    ------
    BadInput, UnknownName
        A step is not one of `KINDS`, or says what it may not: the message names its key.
    """
    known("mission", table, ("kind", "steps", *_DONE))
    steps: list[Step] = []
    for k, step in enumerate(items(table, "mission.steps")):
        where = f"mission.steps[{k}]"
        if not isinstance(step, Mapping):
            raise BadInput(f'{where} is {step!r}; write a table such as {{ do = "land" }}.')
        do = text(step, f"{where}.do")
        if do not in KINDS:
            raise UnknownName(f"{where}.do", do, KINDS)
        kind = KINDS[do]
        known(where, step, ("do", *kind.keys))
        steps += kind.read(step, where)
    try:
        return Errand(steps, **{k: number(table, f"mission.{k}") for k in _DONE if k in table})
    except BadInput as error:
        raise BadInput(f"mission: {error}") from None


class Kind(NamedTuple):
    """A kind of step."""

    keys: tuple[str, ...]  # beside do
    read: Callable[[Mapping[str, Any], str], _Steps]


def _takeoff(step: Mapping[str, Any], where: str) -> _Steps:
    return (TakeOff(_positive(step, f"{where}.height", TakeOff().height)),)


def _goto(step: Mapping[str, Any], where: str) -> _Steps:
    return (still(numbers(step, f"{where}.r", 3), number(step, f"{where}.heading", 0.0)),)


def _follow(step: Mapping[str, Any], where: str) -> _Steps:
    r = array(f"{where}.r", get(step, f"{where}.r"))
    if r.ndim != 2 or r.shape[1] != 3:
        refuse(f"{where}.r", r.tolist(), "places [[x, y, z], …] in m")
    t = numbers(step, f"{where}.t", len(r))
    heading = numbers(step, f"{where}.heading", len(r), [0.0] * len(r))
    way = Trajectory(t, r, heading)
    if why := why_not(way):
        raise BadInput(f"{where}: {why}")
    return (way,)


def _velocity(step: Mapping[str, Any], where: str) -> _Steps:
    free = {key: number(step, f"{where}.{key}") for key in ("z", "heading") if key in step}
    rate = number(step, f"{where}.heading_rate", 0.0)
    order = Velocity(numbers(step, f"{where}.v", 3), heading_rate=rate, **free)
    return order, Wait(_positive(step, f"{where}.time"))


def _there(step: Mapping[str, Any], where: str) -> _Steps:
    return (LandThere(numbers(step, f"{where}.r", 3), number(step, f"{where}.heading", 0.0)),)


def _use(step: Mapping[str, Any], where: str) -> _Steps:
    slot = text(step, f"{where}.slot")
    if slot not in SLOTS:
        raise UnknownName(f"{where}.slot", slot, SLOTS)
    return (Use(slot, text(step, f"{where}.name")),)


def _wait(step: Mapping[str, Any], where: str) -> _Steps:
    return (Wait(_positive(step, f"{where}.time")),)


def _plain(order: Order) -> Kind:
    return Kind((), lambda _step, _where: (order,))


def _positive(table: Mapping[str, Any], where: str, default: float | None = None) -> float:
    value = number(table, where, default)
    return value if value > 0.0 else refuse(where, value, "> 0")


KINDS: Mapping[str, Kind] = {
    "takeoff": Kind(("height",), _takeoff),
    "goto": Kind(("r", "heading"), _goto),
    "follow": Kind(("t", "r", "heading"), _follow),
    "velocity": Kind(("v", "time", "z", "heading", "heading_rate"), _velocity),
    "wait": Kind(("time",), _wait),
    "use": Kind(("slot", "name"), _use),
    "land": _plain(Land()),
    "land home": _plain(LandHome()),
    "land there": Kind(("r", "heading"), _there),
    "emergency": _plain(EmergencyLand()),
    "fall": _plain(Fall()),
}
