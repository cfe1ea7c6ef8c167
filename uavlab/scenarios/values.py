"""What a value of a TOML file may be. Each reader returns it, or raises `BadInput` with its key, itself and the cure.

``where`` is the whole key, such as ``mission.centre`` or ``swap[1].t``; its last word is looked up in the table.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any

import numpy as np

from uavlab.errors import BadInput, UnknownName


def known(where: str, table: Mapping[str, Any], keys: tuple[str, ...]) -> None:
    """Refuse a table with a key that is none of `keys`, with `UnknownName`."""
    for key in table:
        if key not in keys:
            raise UnknownName(f"key of {where}", key, keys)


def get(table: Mapping[str, Any], where: str, default: Any = None) -> Any:
    """Anything; without a default it must be there."""
    value = table.get(where.rsplit(".", 1)[-1], default)
    if value is None:
        raise BadInput(f"{where} is missing; add it.")
    return value


def table_of(table: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """A table; an empty one if it is not there."""
    value = table.get(key, {})
    if not isinstance(value, Mapping):
        raise BadInput(f"{key} is {value!r}; write a table [{key}].")
    return value


def tables_of(table: Mapping[str, Any], key: str, keys: tuple[str, ...]) -> list[Mapping[str, Any]]:
    """Tables [[key]] that have no keys but `keys`; none if it is not there."""
    value = table.get(key, [])
    if not (isinstance(value, list) and all(isinstance(x, Mapping) for x in value)):
        refuse(key, value, f"tables [[{key}]] with {', '.join(keys)}")
    for k, one_of_them in enumerate(value):
        known(f"{key}[{k}]", one_of_them, keys)
    return value


def text(table: Mapping[str, Any], where: str, default: str | None = None) -> str:
    """A text."""
    value = get(table, where, default)
    if not isinstance(value, str):
        raise BadInput(f"{where} is {value!r}; write a text in quotes.")
    return value


def number(table: Mapping[str, Any], where: str, default: float | None = None) -> float:
    """A finite number."""
    return one(where, get(table, where, default))


def numbers(table: Mapping[str, Any], where: str, n: int, default: Any = None) -> np.ndarray:
    """A list of n finite numbers, shape (n,)."""
    value = get(table, where, default)
    x = array(where, value)
    return x if x.shape == (n,) else refuse(where, value, f"a list of {n} numbers")


def items(table: Mapping[str, Any], where: str) -> list[Any]:
    """A list of anything."""
    return as_list(where, get(table, where))


# The same of a value that was looked up already ---------------------------------------------------------


def as_list(where: str, value: Any) -> list[Any]:
    """A list of anything."""
    return value if isinstance(value, list) else refuse(where, value, "a list in [ ]")


def pair(where: str, value: Any) -> tuple[float, float]:
    """Two times [s]."""
    x = array(where, value)
    return tuple(x.tolist()) if x.shape == (2,) else refuse(where, value, "[start, end] in s")


def one(where: str, value: Any) -> float:
    """A finite number."""
    good = isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    return float(value) if good else refuse(where, value)


def array(where: str, value: Any) -> np.ndarray:
    """Finite numbers, or lists of them that are equally long."""
    for x in np.ravel(np.array(value, dtype=object)) if isinstance(value, list) else [value]:
        one(where, x)
    return np.array(value, dtype=float)


def switch(where: str, value: Any) -> bool:
    """True or false."""
    return value if isinstance(value, bool) else refuse(where, value, "true or false")


def record(where: str, kind: Any, value: Any) -> Any:
    """A table with the fields of a NamedTuple, as one."""
    if not isinstance(value, Mapping):
        raise BadInput(f"{where} holds {value!r}; write {{ {', '.join(kind._fields)} }}.")
    known(where, value, kind._fields)
    missing = [k for k in kind._fields if k not in kind._field_defaults and k not in value]
    if missing:
        raise BadInput(f"{where}: {missing[0]} is missing in {dict(value)}; add it.")
    return kind(**{
        k: _field(f"{where}.{k}", kind._field_defaults.get(k), v) for k, v in value.items()
    })


def _field(where: str, usual: Any, value: Any) -> Any:
    """A field of a record: of the kind that it usually is."""
    if isinstance(usual, bool):
        return switch(where, value)
    return array(where, value) if isinstance(value, list) else one(where, value)


def refuse(where: str, value: Any, wanted: str = "a finite number") -> Any:
    """Raise what is raised if a value is not what is wanted."""
    raise BadInput(f"{where} is {value!r}; it must be {wanted}.")
