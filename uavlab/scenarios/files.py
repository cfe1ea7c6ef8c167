"""A scenario from a TOML file; every error names the file, the key, the value, the bound and the cure."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from uavlab.area import Area
from uavlab.errors import BadFile, BadInput, UavlabError, UnknownName
from uavlab.flight.piloted import piloted
from uavlab.flight.scenario import SWAPPED, Scenario, Swap, checked, standing
from uavlab.interfaces import Stack
from uavlab.plant import CALM, Wind, load_airframe
from uavlab.scenarios.guards import area, faults, obstacles
from uavlab.scenarios.tasks import mission
from uavlab.scenarios.values import (
    array,
    as_list,
    known,
    number,
    numbers,
    one,
    pair,
    record,
    switch,
    table_of,
    tables_of,
    text,
)
from uavlab.sensors import (
    INSTRUMENTS,
    KITS,
    Disturbance,
    Hold,
    Jump,
    Outage,
    Outliers,
    laboratory,
)
from uavlab.types import Shift

DATA = Path(__file__).parent / "data"
_RATES = ("rate", "physics", "mission_rate", "reach")
_TABLES = ("start", "mission", "wind", "sensors", "swap", "area", "no_fly", "obstacle", "fault")
_KEYS = ("summary", "airframe", "duration", "pilot", *_TABLES, *_RATES)


def load_file(path: str | os.PathLike[str]) -> Scenario:
    """The scenario that a TOML file describes; ``courtyard.toml`` and ``campus.toml`` in ``data`` are examples.

    Parameters
    ----------
    path : str or path
        Of a file that ends in ``.toml``. All figures in SI units and radians.

    Raises
    ------
    BadFile
        The file is missing or is not TOML.
    BadInput
        A key is missing or not known, or its value is not what it must be.
    """
    path = Path(path)
    table = _read(path)
    try:
        return _scenario(path, table)
    except (BadInput, UnknownName) as error:
        said = re.sub(r"\b(fault|obstacle|swap)s\[", r"\1[", str(error))  # as the file calls them
        raise BadInput(f"{path.name}: {said}") from None
    except UavlabError as error:
        raise BadFile(f"{path.name}: {error}") from None


def _read(path: Path) -> Mapping[str, Any]:
    import tomllib

    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadFile(f"cannot read the scenario {path}: {error.strerror}.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise BadFile(f"{path} is not TOML: {error}.") from None


def _scenario(path: Path, table: Mapping[str, Any]) -> Scenario:
    known("the file", table, _KEYS)
    airframe = text(table, "airframe")
    if airframe.endswith(".toml"):
        airframe = str(path.parent / airframe)
    load_airframe(airframe)
    start = table_of(table, "start")
    known("start", start, ("r", "heading"))
    r = numbers(start, "start.r", 3, [0.0, 0.0, 0.0])
    if r[2] < 0.0:
        raise BadInput(f"start.r is {r.tolist()} m; z must be ≥ 0, the ground.")
    fence, pilot = area(table), switch("pilot", table.get("pilot", False))
    scenario = Scenario(
        path.stem,
        text(table, "summary", ""),
        airframe,
        mission(table_of(table, "mission"), pilot),
        standing((r[0], r[1], r[2]), number(start, "start.heading", 0.0)),
        number(table, "duration"),
        _sensors(table_of(table, "sensors")),
        _wind(table_of(table, "wind")),
        mind=partial(safe_mind, area=fence) if pilot else None,
        swaps=_swaps(table),
        faults=faults(table),
        area=fence,
        obstacles=obstacles(table),
    )
    rates = {key: number(table, key) for key in _RATES if key in table}
    return checked(scenario._replace(**rates))


def safe_mind(airframe: str, area: Area | None = None) -> Stack:
    """Who flies a scenario with ``pilot = true``: the safe pilot with all its parts, in its area."""
    return piloted(airframe, area=area)


def _wind(table: Mapping[str, Any]) -> Wind:
    known("wind", table, Wind._fields)
    given: dict[str, Any] = {k: numbers(table, f"wind.{k}", 3) for k in table if k != "passing"}
    if "passing" in table:
        given["passing"] = number(table, "wind.passing")
    wind = CALM._replace(**given)
    wind.init(np.random.default_rng(0))  # refuses what cannot be
    return wind


def _swaps(table: Mapping[str, Any]) -> tuple[Swap, ...]:
    """Who takes over, and when; the parts themselves are the mind's."""
    swaps = []
    for k, swap in enumerate(tables_of(table, "swap", Swap._fields)):
        where = f"swap[{k}]"
        t, slot = number(swap, f"{where}.t"), text(swap, f"{where}.slot")
        if t < 0.0:
            raise BadInput(f"{where}.t is {t} s; it must be ≥ 0.")
        if slot not in SWAPPED:
            raise UnknownName(f"{where}.slot", slot, SWAPPED)
        swaps.append(Swap(t, slot, text(swap, f"{where}.name")))
    return tuple(swaps)


def _sensors(table: Mapping[str, Any]) -> dict[str, Any]:
    """The kit, and on top of it what the file says of each instrument."""
    if not table:
        return laboratory()
    kit = text(table, "sensors.kit", "")
    if kit and kit not in KITS:
        raise UnknownName("sensors.kit", kit, KITS)
    carried = KITS[kit]() if kit else {}
    for name, figures in table.items():
        if name == "kit":
            continue
        if name not in INSTRUMENTS:
            raise UnknownName("instrument", name, INSTRUMENTS)
        carried[name] = _instrument(f"sensors.{name}", INSTRUMENTS[name](), figures)
    return carried


def _instrument(where: str, sensor: Any, figures: Any) -> Any:
    if not isinstance(figures, Mapping):
        raise BadInput(f"{where} is {figures!r}; write a table [{where}].")
    known(where, figures, sensor._fields)
    given = {key: _figure(f"{where}.{key}", key, value) for key, value in figures.items()}
    sensor = sensor._replace(**given)
    try:
        sensor.init(np.random.default_rng(0))  # refuses what cannot be, by name
    except (TypeError, ValueError) as error:
        raise BadInput(f"{where}: {error}") from None
    return sensor


def _figure(where: str, key: str, value: Any) -> Any:
    """A figure of an instrument, as its configuration wants it."""
    read = _FIGURES.get(key)
    if read is not None:
        return read(where, value)
    return array(where, value) if isinstance(value, list) else one(where, value)


def _intervals(where: str, value: Any) -> tuple[Outage, ...]:
    return tuple(Outage(*pair(where, times)) for times in as_list(where, value))


def _records(kind: Any) -> Callable[[str, Any], Any]:
    def read(where: str, value: Any) -> Any:
        return tuple(record(where, kind, x) for x in as_list(where, value))

    return read


_FIGURES: Mapping[str, Callable[[str, Any], Any]] = {
    **dict.fromkeys(("outages", "dark", "corrections_lost"), _intervals),
    **dict.fromkeys(("rate", "delay", "dropout"), one),
    "jumps": _records(Jump),
    "disturbances": _records(Disturbance),
    "holds": _records(Hold),
    "outliers": lambda where, value: record(where, Outliers, value),
    "world": lambda where, value: record(where, Shift, value),
    "closures": lambda where, value: tuple(array(where, as_list(where, value)).tolist()),
    "silent": switch,
}
