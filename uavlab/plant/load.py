"""Airframes from TOML files in which every number has a unit and a source."""

from __future__ import annotations

import os
from collections.abc import Mapping
from math import isfinite, pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadFile, BadInput, UnknownName
from uavlab.plant.airframe import Airframe, build_airframe

DATA = Path(__file__).parent / "data"


class _Rule(NamedTuple):
    """What a key of the TOML file must hold."""

    unit: str
    low: float  # least allowed
    high: float  # most allowed
    length: int = 1  # 0: as many as there are rotors


_RULES = {
    "mass": _Rule("kg", 1e-3, 500.0),
    "inertia": _Rule("kg m²", 1e-8, 500.0, 3),
    "arm": _Rule("m", 1e-3, 10.0),
    "angles": _Rule("deg", -360.0, 360.0, 0),
    "spins": _Rule("1", -1.0, 1.0, 0),
    "torque_ratio": _Rule("m", 1e-6, 1.0),
    "thrust_coefficient": _Rule("N/rpm²", 1e-14, 1.0),
    "speed_min": _Rule("rpm", 0.0, 1e6),
    "speed_max": _Rule("rpm", 1.0, 1e6),
    "motor_tau": _Rule("s", 1e-4, 10.0),
    "drag_body": _Rule("N s²/m²", 0.0, 100.0),
    "drag_rotor": _Rule("1/√m", 0.0, 100.0),
    "rate_gain": _Rule("1/s", 0.0, 1000.0, 3),
    "propeller_radius": _Rule("m", 1e-3, 10.0),
}
_RPM = 2.0 * pi / 60.0  # [rad/s] per rpm
_SI = {"deg": pi / 180.0, "rpm": _RPM, "N/rpm²": 1.0 / _RPM**2}


def airframe_names() -> list[str]:
    """Names of the airframes that come with uavlab."""
    return sorted(path.stem for path in DATA.glob("*.toml"))


def load_airframe(name: str | os.PathLike[str]) -> Airframe:
    """An airframe by name, or from a TOML file of your own.

    Parameters
    ----------
    name : str or path
        One of `airframe_names` (upper or lower case), or the path of a file that ends in ``.toml``.

    Raises
    ------
    UnknownName
        No airframe has this name.
    BadFile
        The file is missing or is not TOML.
    BadInput
        A number is missing, has the wrong unit, or is out of bounds.
    """
    if not isinstance(name, str | os.PathLike):
        raise UnknownName("airframe", name, airframe_names())
    text = os.fspath(name)
    if text.endswith(".toml"):
        path = Path(text)
    else:
        known = {stem.lower(): stem for stem in airframe_names()}
        if text.lower() not in known:
            raise UnknownName("airframe", text, known.values())
        path = DATA / f"{known[text.lower()]}.toml"
    table = _read_toml(path)
    return build_airframe(path.stem, **{key: _quantity(table, key, path) for key in _RULES})


def _read_toml(path: Path) -> Mapping[str, Any]:
    import tomllib

    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadFile(f"cannot read the airframe {path}: {error.strerror}.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise BadFile(f"{path} is not TOML: {error}.") from None


def _quantity(table: Mapping[str, Any], key: str, path: Path) -> Any:
    """The number (or list) under `key`, checked, in SI."""
    rule, entry = _RULES[key], table.get(key)
    where = f"{path.name}: {key}"
    if not isinstance(entry, Mapping) or not {"value", "unit", "source"} <= set(entry):
        shape = f'{key} = {{ value = …, unit = "{rule.unit}", source = "…" }}'
        said = "is missing" if entry is None else f"is {entry!r}"
        raise BadInput(f"{where} {said}; write {shape}.")
    if entry["unit"] != rule.unit:
        raise BadInput(f"{where} is in {entry['unit']!r}; convert it to {rule.unit!r}.")
    value: Any = entry["value"]
    many: list[Any] = value if isinstance(value, list) and rule.length != 1 else [value]
    if rule.length != 1 and (value is not many or len(many) != (rule.length or len(many))):
        raise BadInput(f"{where} is {value!r}; a list of {rule.length or 'all rotors'} is needed.")
    for x in many:
        number = isinstance(x, int | float) and not isinstance(x, bool) and isfinite(x)
        if not number or not rule.low <= x <= rule.high:
            raise BadInput(
                f"{where} has the value {x!r}; allowed are {rule.low:g} to {rule.high:g} {rule.unit}."
            )
    factor = _SI.get(rule.unit, 1.0)
    return np.array(many, dtype=float) * factor if rule.length != 1 else float(many[0]) * factor
