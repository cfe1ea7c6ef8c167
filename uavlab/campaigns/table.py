"""The table of a campaign: a text file to which each flight that has ended adds one line of JSON, and nothing else.

A line is written whole and handed to the system at once, so a process that is killed loses none that was written; what
a power cut leaves of the last line is cut off when the table is opened again.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from uavlab.errors import BadFile, BadInput

Row: TypeAlias = dict[
    str, Any
]  # of one flight: its "seed", its "exit", whether it is "bad", and more
SYNC = 1.0  # [s] between two times that the disk itself is asked to keep what it was given


class Head(NamedTuple):
    """The first line of a table: what its numbers depend on."""

    campaign: str
    version: str  # of uavlab
    settings: Mapping[str, Any]  # JSON


@contextmanager
def open_table(path: Path, head: Head) -> Iterator[tuple[dict[int, Row], Callable[[Row], None]]]:
    """The rows that are there, by seed, and a function that adds one. A table that is not there is begun.

    Raises
    ------
    BadInput
        The table cannot be written, or is of another campaign, another version or other settings.
    BadFile
        It is not a table.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    except OSError as error:
        raise BadInput(
            f"cannot write {path}: {error.strerror}. Choose another folder with --out."
        ) from None
    with open(path, "a+b") as file:
        _mend(file)
        file.seek(0)
        there, rows = _parsed(path, file.read())
        if there is not None:
            _same(path, there, head)
        last = 0.0

        def add(row: Row | dict[str, Any]) -> None:
            nonlocal last
            file.write(json.dumps(row, ensure_ascii=False, allow_nan=False).encode() + b"\n")
            file.flush()
            if time.monotonic() - last > SYNC:
                os.fsync(file.fileno())
                last = time.monotonic()

        if there is None:
            add(head._asdict())
        try:
            yield rows, add
        finally:
            os.fsync(file.fileno())


def read_table(path: Path) -> tuple[Head, list[Row]]:
    """Head and rows of a table, by seed; a cut last line is left out.

    Raises
    ------
    BadFile
        There is none, or it is not a table.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise BadFile(f"cannot read {path}: {error.strerror}.") from None
    head, rows = _parsed(path, data[: data.rfind(b"\n") + 1])
    if head is None:
        raise BadFile(f"{path} is empty; `uavlab campaign` writes such a table.")
    return head, [rows[seed] for seed in sorted(rows)]


def _mend(file: Any) -> None:
    """Cut off a last line that has no end: its flight is flown again."""
    file.seek(0)
    data = file.read()
    whole = data.rfind(b"\n") + 1
    if whole < len(data):
        file.truncate(whole)


def _parsed(path: Path, data: bytes) -> tuple[Head | None, dict[int, Row]]:
    head, rows = None, {}
    for k, line in enumerate(data.splitlines(), start=1):
        try:
            told = json.loads(line)
            if head is None:
                head = Head(**told)
            else:
                rows[int(told["seed"])] = told
        except (ValueError, TypeError, KeyError) as error:
            raise BadFile(
                f"{path}, line {k}, is not of a campaign's table ({error}). Move the file away, or mend the line."
            ) from None
    return head, rows


def _same(path: Path, there: Head, asked: Head) -> None:
    """Refuse to mix numbers that were got in different ways."""
    asked = Head(**json.loads(json.dumps(asked._asdict())))
    if there == asked:
        return
    for name in ("campaign", "version"):
        old, new = getattr(there, name), getattr(asked, name)
        if old != new:
            _refuse(path, f"of {name} {old!r}, not {new!r}")
    for key in sorted({*there.settings, *asked.settings}):
        old, new = there.settings.get(key), asked.settings.get(key)
        if old != new:
            _refuse(path, f"of other settings: {key} was {old!r}, and is {new!r}")


def _refuse(path: Path, why: str) -> None:
    raise BadInput(f"{path} is a table {why}. Move it away, or choose another folder with --out.")
