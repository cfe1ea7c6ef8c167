"""What crosses between the judge and a student's process: frames of JSON, and plain data only.

A frame is its length (4 bytes, big-endian) and UTF-8 JSON. Numbers, texts, lists, tuples, dicts, arrays and the
NamedTuples of `RECORDS` cross; nothing else does, and nothing that crosses is ever executed. Both sides
import this module, but only the judge's side has to defend itself: `decode` trusts no size, depth or type.
"""

from __future__ import annotations

import base64
import binascii
import json
import math
import struct
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

MAX_FRAME = 4 * 2**20  # bytes
MAX_DEPTH = 8
MAX_NODES = 50_000  # values in one message
MAX_TEXT = 200  # characters of one text
MAX_NDIM = 4
DTYPES = {"<f8", "<f4", "<i8", "<i4", "|u1", "|b1"}
HEADER = struct.Struct(">I")
# modules of uavlab whose NamedTuples may cross
RECORDS = ("types", "frames", "gains", "limits", "weights", "qp")
_JSON = json.JSONEncoder(separators=(",", ":"))


class ProtocolError(Exception):
    """The other side sent something that is not a message."""


class Odd:
    """Stands for an answer that is not plain data: no check can pass with it."""


# Frames ----------------------------------------------------------------------------------------------


def pack(message: dict[str, Any]) -> bytes:
    """A message as one frame."""
    body = _JSON.encode(message).encode()
    if len(body) > MAX_FRAME:
        raise ProtocolError(f"a message of {len(body)} bytes; at most {MAX_FRAME} are allowed")
    return HEADER.pack(len(body)) + body


def unpack(body: bytes) -> dict[str, Any]:
    """The message in a frame's body."""
    try:
        message = json.loads(body)
    except (ValueError, RecursionError, MemoryError) as error:
        raise ProtocolError(f"not JSON ({type(error).__name__})") from None
    if not isinstance(message, dict):
        raise ProtocolError("a message is a JSON object")
    return message


def length(header: bytes) -> int:
    """The size of the body that this header announces."""
    (size,) = HEADER.unpack(header)
    if not 0 < size <= MAX_FRAME:
        raise ProtocolError(f"a frame of {size} bytes; at most {MAX_FRAME} are allowed")
    return size


# Values → JSON ---------------------------------------------------------------------------------------


@cache
def records() -> dict[str, Any]:
    """The NamedTuples that may cross, by name."""
    found = [x for name in RECORDS for x in vars(import_module(f"uavlab.{name}")).values()]
    return {
        x.__name__: x
        for x in found
        if isinstance(x, type) and issubclass(x, tuple) and hasattr(x, "_fields")
    }


def _array(value: np.ndarray) -> dict[str, Any]:
    plain = np.ascontiguousarray(np.asarray(value)).reshape(np.shape(value))
    if plain.dtype.str not in DTYPES:
        raise TypeError(f"an array of {plain.dtype}")
    data = base64.b64encode(plain.tobytes()).decode()
    return {"a": [plain.dtype.str, list(plain.shape), data]}


def _tuple(value: tuple, arrays: list[np.ndarray]) -> dict[str, Any]:
    fields = [encode(x, arrays) for x in value]
    name = type(value).__name__
    return {"n": [name, fields]} if name in records() else {"t": fields}


_SCALARS: list[tuple[type | tuple[type, ...], Callable[[Any], Any]]] = [
    ((bool, np.bool_), bool),
    ((int, np.integer), int),
    ((float, np.floating), float),
    (str, str),
]


def encode(value: Any, arrays: list[np.ndarray]) -> Any:
    """Plain data as JSON; every array met is appended to `arrays`. Raises TypeError for anything else."""
    if value is None:
        return None
    if isinstance(value, np.ndarray):
        arrays.append(value)
        return _array(value)
    for kinds, plain in _SCALARS:
        if isinstance(value, kinds):
            return plain(value)
    if isinstance(value, tuple):
        return _tuple(value, arrays)
    if isinstance(value, list):
        return {"l": [encode(x, arrays) for x in value]}
    if isinstance(value, Mapping):
        return {"d": {str(k): encode(v, arrays) for k, v in value.items()}}
    raise TypeError(type(value).__name__)


# JSON → values ---------------------------------------------------------------------------------------


class Decoder:
    """Rebuilds one message's values; refuses what is too big, too deep or of an unknown kind.

    With ``widen`` (the judge's side) every array becomes float64. ``arrays`` lists them in the order in which
    `encode` met them, each with the bytes that it was made of.
    """

    def __init__(self, *, widen: bool) -> None:
        self.widen = widen
        self.nodes = 0
        self.arrays: list[tuple[np.ndarray, bytes]] = []

    def value(self, data: Any, depth: int = 0) -> Any:
        """One value."""
        self.nodes += 1
        if depth > MAX_DEPTH or self.nodes > MAX_NODES:
            raise ProtocolError("a value too deep or too large")
        if data is None or isinstance(data, bool | int | float | str):
            return _scalar(data)
        if not isinstance(data, dict) or len(data) != 1:
            raise ProtocolError("a value of no known kind")
        ((kind, content),) = data.items()
        if kind == "a":
            return self._array(content)
        if kind == "n":
            return self._record(content, depth)
        if kind == "d":
            return self._dict(content, depth)
        if kind not in ("t", "l") or not isinstance(content, list):
            raise ProtocolError("a value of no known kind")
        items = [self.value(x, depth + 1) for x in content]
        return tuple(items) if kind == "t" else items

    def _record(self, content: Any, depth: int) -> Any:
        if not (isinstance(content, list) and len(content) == 2 and isinstance(content[1], list)):
            raise ProtocolError("a record without a name and fields")
        name, fields = content
        kind = records().get(name) if isinstance(name, str) else None
        if kind is None:
            raise ProtocolError("a record of no known kind")
        items = [self.value(x, depth + 1) for x in fields]
        return kind(*items) if len(items) == len(kind._fields) else tuple(items)

    def _dict(self, content: Any, depth: int) -> dict[str, Any]:
        if not isinstance(content, dict):
            raise ProtocolError("a dictionary that is none")
        return {_scalar(k): self.value(v, depth + 1) for k, v in content.items()}

    def _array(self, content: Any) -> np.ndarray:
        dtype, shape, raw = _parts(content)
        size = math.prod(shape) * np.dtype(dtype).itemsize
        if size != len(raw):
            raise ProtocolError("an array whose shape and size disagree")
        plain = np.frombuffer(raw, dtype).reshape(shape)
        made = plain.astype(np.float64) if self.widen else plain.copy()
        self.arrays.append((made, raw))
        return made


def _parts(content: Any) -> tuple[str, list[int], bytes]:
    if not (isinstance(content, list) and len(content) == 3):
        raise ProtocolError("an array without dtype, shape and data")
    dtype, shape, data = content
    if not (isinstance(dtype, str) and dtype in DTYPES):
        raise ProtocolError("an array of a dtype that may not cross")
    if not (isinstance(shape, list) and len(shape) <= MAX_NDIM):
        raise ProtocolError("an array of a shape that may not cross")
    if not all(type(n) is int and 0 <= n <= MAX_FRAME for n in shape):
        raise ProtocolError("an array of a shape that may not cross")
    if not isinstance(data, str):
        raise ProtocolError("an array without data")
    try:
        return dtype, shape, base64.b64decode(data, validate=True)
    except (binascii.Error, ValueError):
        raise ProtocolError("an array whose data is not base64") from None


def _scalar(data: Any) -> Any:
    if isinstance(data, str) and len(data) > MAX_TEXT:
        raise ProtocolError("a text too long")
    if type(data) is int and abs(data) > 2**53:
        raise ProtocolError("an integer too large")
    return data
