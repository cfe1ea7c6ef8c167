"""What keeps a flight from harm and what harms it, from a scenario's file: area, no-fly zones, obstacles, faults."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

import numpy as np

from uavlab.area import Area, NoFly
from uavlab.errors import BadInput
from uavlab.flight.fault import Fault
from uavlab.plant.obstacles import Obstacle
from uavlab.scenarios.values import (
    array,
    as_list,
    get,
    known,
    number,
    one,
    record,
    refuse,
    tables_of,
    text,
)

_AREA = ("border", "low", "high", "margin", "world")
_NO_FLY = ("name", "border", "low", "high")


def area(table: Mapping[str, Any]) -> Area | None:
    """The safety area of [area] with the zones of [[no_fly]]; None if there is none.

    Raises
    ------
    BadInput, UnknownName
        A key is not known, or a value is not what it must be: the message names the key.
    """
    zones = tuple(
        _zone(f"no_fly[{k}]", x) for k, x in enumerate(tables_of(table, "no_fly", _NO_FLY))
    )
    given = table.get("area")
    if given is None:
        if zones:
            raise BadInput("no_fly is there but no area; add a table [area] around it.")
        return None
    if not isinstance(given, Mapping):
        raise BadInput(f"area is {given!r}; write a table [area].")
    known("area", given, _AREA)
    values = {
        "border": _border(given, "area.border"),
        **{key: number(given, f"area.{key}") for key in ("low", "high")},
        "margin": number(given, "area.margin", 0.0),
        "world": text(given, "area.world", ""),
    }
    try:
        return Area(no_fly=zones, **values)
    except BadInput as error:
        said = "area." + str(error).removeprefix("safety area: ")
        raise BadInput(said.replace("area.no_fly", "no_fly")) from None


def obstacles(table: Mapping[str, Any]) -> tuple[Obstacle, ...]:
    """What stands there, from [[obstacle]]."""
    given = tables_of(table, "obstacle", Obstacle._fields)
    return tuple(record(f"obstacle[{k}]", Obstacle, x) for k, x in enumerate(given))


def faults(table: Mapping[str, Any]) -> tuple[Fault, ...]:
    """What breaks and when, from [[fault]]; whether it can is for `uavlab.flight.fault.checked_faults` to say."""
    return tuple(
        _fault(f"fault[{k}]", x) for k, x in enumerate(tables_of(table, "fault", Fault._fields))
    )


def _zone(where: str, table: Mapping[str, Any]) -> NoFly:
    name = text(table, f"{where}.name")
    heights = {k: number(table, f"{where}.{k}") for k in ("low", "high") if k in table}
    try:
        return NoFly(_border(table, f"{where}.border"), name=name, **heights)
    except BadInput as error:
        raise BadInput(f"{where}: {error}") from None


def _border(table: Mapping[str, Any], where: str) -> np.ndarray:
    given = as_list(where, get(table, where))
    for k, corner in enumerate(given):
        if array(f"{where}[{k}]", corner).shape != (2,):
            refuse(f"{where}[{k}]", corner, "a corner [x, y] in m")
    return np.array(given, dtype=float).reshape(-1, 2)


def _fault(where: str, table: Mapping[str, Any]) -> Fault:
    kind, t = text(table, f"{where}.kind"), number(table, f"{where}.t")
    until = number(table, f"{where}.until") if "until" in table else inf
    return Fault(kind, t, until, _what(table, f"{where}.what"), _value(table, f"{where}.value"))


def _what(table: Mapping[str, Any], where: str) -> str:
    """A name, or the number of a rotor."""
    given = get(table, where, "")
    whole = isinstance(given, int) and not isinstance(given, bool)
    return str(given) if whole else text(table, where, "")


def _value(table: Mapping[str, Any], where: str) -> Any:
    """How much: a number, some, or a word."""
    given = get(table, where, 0.0)
    if isinstance(given, str):
        return given
    return array(where, given) if isinstance(given, list) else one(where, given)
