"""What an aircraft is asked to do, from the table [mission] of a scenario's file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from uavlab.errors import BadInput, UnknownName
from uavlab.parts import paths
from uavlab.parts.missions import Follow, Waypoints
from uavlab.scenarios.steps import errand
from uavlab.scenarios.values import items, known, number, numbers, text


def mission(table: Mapping[str, Any], pilot: bool) -> Any:
    """The mission of the kind that ``mission.kind`` names; `pilot` says whether there is one to obey orders.

    Raises
    ------
    BadInput, UnknownName
        A key is missing or not known, or a value is not what it must be: the message names the key.
    """
    kinds: dict[str, Callable[[Mapping[str, Any]], Any]] = {
        "waypoints": _waypoints,
        "circle": _circle,
        "lemniscate": _lemniscate,
        "errand": errand,
    }
    kind = text(table, "mission.kind")
    if kind not in kinds:
        raise UnknownName("mission.kind", kind, kinds)
    if kind == "errand" and not pilot:
        raise BadInput(
            "mission.kind is 'errand', whose orders only a pilot obeys; add pilot = true."
        )
    return kinds[kind](table)


def _waypoints(table: Mapping[str, Any]) -> Waypoints:
    known("mission", table, ("kind", "stops"))
    stops = []
    for k, stop in enumerate(items(table, "mission.stops")):
        where = f"mission.stops[{k}]"
        if not isinstance(stop, Mapping):
            raise BadInput(
                f"{where} is {stop!r}; write {{ t = 0.0, r = [x, y, z], heading = 0.0 }}."
            )
        known(where, stop, ("t", "r", "heading"))
        x, y, z = numbers(stop, f"{where}.r", 3).tolist()
        stops.append((
            number(stop, f"{where}.t"),
            (x, y, z),
            number(stop, f"{where}.heading", 0.0),
        ))
    return Waypoints(tuple(stops))


def _circle(table: Mapping[str, Any]) -> Follow:
    known("mission", table, ("kind", "centre", "radius", "rate", "ramp", "heading", "face"))
    centre = numbers(table, "mission.centre", 3)
    return _follow(table, paths.circle(centre, number(table, "mission.radius")))


def _lemniscate(table: Mapping[str, Any]) -> Follow:
    keys = ("kind", "centre", "length", "width", "rise", "rate", "ramp", "heading", "face")
    known("mission", table, keys)
    length, width = (number(table, f"mission.{key}") for key in ("length", "width"))
    rise = number(table, "mission.rise", 0.0)
    path = paths.lemniscate(numbers(table, "mission.centre", 3), length, width, rise)
    return _follow(table, path)


def _follow(table: Mapping[str, Any], path: paths.Path) -> Follow:
    ramp = number(table, "mission.ramp", 3.0)
    if not ramp > 0.0:
        raise BadInput(f"mission.ramp is {ramp} s; it must be > 0.")
    face = numbers(table, "mission.face", 3) if "face" in table else None
    heading = number(table, "mission.heading", 0.0)
    return Follow(path, number(table, "mission.rate"), ramp, heading, face)
