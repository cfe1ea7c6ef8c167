"""A scenario from a TOML file; every error names the file, the key, the value, the bound and the cure."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from uavlab.errors import BadFile, BadInput, UavlabError, UnknownName
from uavlab.flight.scenario import SWAPPED, Scenario, Swap, checked, standing
from uavlab.parts import paths
from uavlab.parts.missions import Follow, Waypoints
from uavlab.plant import CALM, Wind, load_airframe
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
_KEYS = ("summary", "airframe", "duration", "start", "mission", "wind", "sensors", "swap", *_RATES)


def load_file(path: str | os.PathLike[str]) -> Scenario:
    """The scenario that a TOML file describes; ``uavlab/scenarios/data/courtyard.toml`` is an example.

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
    except BadInput as error:
        raise BadInput(f"{path.name}: {error}") from None
    except UnknownName as error:
        raise BadInput(f"{path.name}: {error}") from None
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
    _known("the file", table, _KEYS)
    airframe = _text(table, "airframe")
    if airframe.endswith(".toml"):
        airframe = str(path.parent / airframe)
    load_airframe(airframe)
    start = _table(table, "start")
    _known("start", start, ("r", "heading"))
    r = _numbers(start, "start.r", 3, [0.0, 0.0, 0.0])
    if r[2] < 0.0:
        raise BadInput(f"start.r is {r.tolist()} m; z must be ≥ 0, the ground.")
    scenario = Scenario(
        path.stem,
        _text(table, "summary", ""),
        airframe,
        _mission(_table(table, "mission")),
        standing((r[0], r[1], r[2]), _number(start, "start.heading", 0.0)),
        _number(table, "duration"),
        _sensors(_table(table, "sensors")),
        _wind(_table(table, "wind")),
        swaps=_swaps(table),
    )
    rates = {key: _number(table, key) for key in _RATES if key in table}
    return checked(scenario._replace(**rates))


def _mission(table: Mapping[str, Any]) -> Any:
    kinds: dict[str, Callable[[Mapping[str, Any]], Any]] = {
        "waypoints": _waypoints,
        "circle": _circle,
        "lemniscate": _lemniscate,
    }
    kind = _text(table, "mission.kind")
    if kind not in kinds:
        raise UnknownName("mission.kind", kind, kinds)
    return kinds[kind](table)


def _waypoints(table: Mapping[str, Any]) -> Waypoints:
    _known("mission", table, ("kind", "stops"))
    stops = []
    for k, stop in enumerate(_list(table, "mission.stops")):
        where = f"mission.stops[{k}]"
        if not isinstance(stop, Mapping):
            raise BadInput(
                f"{where} is {stop!r}; write {{ t = 0.0, r = [x, y, z], heading = 0.0 }}."
            )
        _known(where, stop, ("t", "r", "heading"))
        x, y, z = _numbers(stop, f"{where}.r", 3).tolist()
        stops.append((
            _number(stop, f"{where}.t"),
            (x, y, z),
            _number(stop, f"{where}.heading", 0.0),
        ))
    return Waypoints(tuple(stops))


def _circle(table: Mapping[str, Any]) -> Follow:
    _known("mission", table, ("kind", "centre", "radius", "rate", "ramp", "heading", "face"))
    centre = _numbers(table, "mission.centre", 3)
    return _follow(table, paths.circle(centre, _number(table, "mission.radius")))


def _lemniscate(table: Mapping[str, Any]) -> Follow:
    keys = ("kind", "centre", "length", "width", "rise", "rate", "ramp", "heading", "face")
    _known("mission", table, keys)
    length, width = (_number(table, f"mission.{key}") for key in ("length", "width"))
    rise = _number(table, "mission.rise", 0.0)
    path = paths.lemniscate(_numbers(table, "mission.centre", 3), length, width, rise)
    return _follow(table, path)


def _follow(table: Mapping[str, Any], path: paths.Path) -> Follow:
    ramp = _number(table, "mission.ramp", 3.0)
    if not ramp > 0.0:
        raise BadInput(f"mission.ramp is {ramp} s; it must be > 0.")
    face = _numbers(table, "mission.face", 3) if "face" in table else None
    heading = _number(table, "mission.heading", 0.0)
    return Follow(path, _number(table, "mission.rate"), ramp, heading, face)


def _wind(table: Mapping[str, Any]) -> Wind:
    _known("wind", table, Wind._fields)
    given: dict[str, Any] = {k: _numbers(table, f"wind.{k}", 3) for k in table if k != "passing"}
    if "passing" in table:
        given["passing"] = _number(table, "wind.passing")
    wind = CALM._replace(**given)
    wind.init(np.random.default_rng(0))  # refuses what cannot be
    return wind


def _swaps(table: Mapping[str, Any]) -> tuple[Swap, ...]:
    """Who takes over, and when; the parts themselves are the mind's."""
    swaps, given = [], table.get("swap", [])
    if not (isinstance(given, list) and all(isinstance(x, Mapping) for x in given)):
        _refuse("swap", given, "tables [[swap]] with t, slot and name")
    for k, swap in enumerate(given):
        where = f"swap[{k}]"
        _known(where, swap, Swap._fields)
        t, slot = _number(swap, f"{where}.t"), _text(swap, f"{where}.slot")
        if t < 0.0:
            raise BadInput(f"{where}.t is {t} s; it must be ≥ 0.")
        if slot not in SWAPPED:
            raise UnknownName(f"{where}.slot", slot, SWAPPED)
        swaps.append(Swap(t, slot, _text(swap, f"{where}.name")))
    return tuple(swaps)


def _sensors(table: Mapping[str, Any]) -> dict[str, Any]:
    """The kit, and on top of it what the file says of each instrument."""
    if not table:
        return laboratory()
    kit = _text(table, "sensors.kit", "")
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
    _known(where, figures, sensor._fields)
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
    return _array(where, value) if isinstance(value, list) else _one(where, value)


def _intervals(where: str, value: Any) -> tuple[Outage, ...]:
    return tuple(Outage(*_pair(where, one)) for one in _as_list(where, value))


def _records(kind: Any) -> Callable[[str, Any], Any]:
    def read(where: str, value: Any) -> Any:
        return tuple(_record(where, kind, one) for one in _as_list(where, value))

    return read


def _switch(where: str, value: Any) -> bool:
    return value if isinstance(value, bool) else _refuse(where, value, "true or false")


def _record(where: str, kind: Any, value: Any) -> Any:
    if not isinstance(value, Mapping):
        raise BadInput(f"{where} holds {value!r}; write {{ {', '.join(kind._fields)} }}.")
    _known(where, value, kind._fields)
    missing = [k for k in kind._fields if k not in kind._field_defaults and k not in value]
    if missing:
        raise BadInput(f"{where}: {missing[0]} is missing in {dict(value)}; add it.")
    return kind(**{
        k: _field(f"{where}.{k}", kind._field_defaults.get(k), v) for k, v in value.items()
    })


def _field(where: str, usual: Any, value: Any) -> Any:
    """A field of a record: of the kind that it usually is."""
    if isinstance(usual, bool):
        return _switch(where, value)
    return _array(where, value) if isinstance(value, list) else _one(where, value)


# What a TOML value may be ------------------------------------------------------------------------------


def _known(where: str, table: Mapping[str, Any], keys: tuple[str, ...]) -> None:
    for key in table:
        if key not in keys:
            raise UnknownName(f"key of {where}", key, keys)


def _get(table: Mapping[str, Any], where: str, default: Any = None) -> Any:
    value = table.get(where.rsplit(".", 1)[-1], default)
    if value is None:
        raise BadInput(f"{where} is missing; add it.")
    return value


def _table(table: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = table.get(key, {})
    if not isinstance(value, Mapping):
        raise BadInput(f"{key} is {value!r}; write a table [{key}].")
    return value


def _text(table: Mapping[str, Any], where: str, default: str | None = None) -> str:
    value = _get(table, where, default)
    if not isinstance(value, str):
        raise BadInput(f"{where} is {value!r}; write a text in quotes.")
    return value


def _list(table: Mapping[str, Any], where: str) -> list[Any]:
    return _as_list(where, _get(table, where))


def _as_list(where: str, value: Any) -> list[Any]:
    return value if isinstance(value, list) else _refuse(where, value, "a list in [ ]")


def _pair(where: str, value: Any) -> Any:
    x = _array(where, value)
    return x.tolist() if x.shape == (2,) else _refuse(where, value, "[start, end] in s")


def _number(table: Mapping[str, Any], where: str, default: float | None = None) -> float:
    return _one(where, _get(table, where, default))


def _numbers(table: Mapping[str, Any], where: str, n: int, default: Any = None) -> np.ndarray:
    value = _get(table, where, default)
    x = _array(where, value)
    return x if x.shape == (n,) else _refuse(where, value, f"a list of {n} numbers")


def _one(where: str, value: Any) -> float:
    good = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    return float(value) if good else _refuse(where, value)


def _array(where: str, value: Any) -> np.ndarray:
    """Numbers, or lists of numbers that are equally long."""
    for x in np.ravel(np.array(value, dtype=object)) if isinstance(value, list) else [value]:
        _one(where, x)
    return np.array(value, dtype=float)


def _refuse(where: str, value: Any, wanted: str = "a finite number") -> Any:
    raise BadInput(f"{where} is {value!r}; it must be {wanted}.")


_FIGURES: Mapping[str, Callable[[str, Any], Any]] = {
    **dict.fromkeys(("outages", "dark", "corrections_lost"), _intervals),
    **dict.fromkeys(("rate", "delay", "dropout"), _one),
    "jumps": _records(Jump),
    "disturbances": _records(Disturbance),
    "holds": _records(Hold),
    "outliers": lambda where, value: _record(where, Outliers, value),
    "world": lambda where, value: _record(where, Shift, value),
    "closures": lambda where, value: tuple(_array(where, _as_list(where, value)).tolist()),
    "silent": _switch,
}
