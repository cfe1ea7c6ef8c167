"""The record of an experiment: its numbers as JSON, so that a page can be made of them without flying again."""

from __future__ import annotations

import json
import os
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

from uavlab import __version__
from uavlab.errors import BadFile
from uavlab.experiments.spec import Band, Experiment, Outcome, Row


class Record(NamedTuple):
    """What was got, when asked with how many seeds, and by which version."""

    name: str
    title: str
    source: str
    seeds: int
    version: str
    rows: tuple[Row, ...]
    remarks: tuple[str, ...]

    @property
    def met(self) -> bool:
        """Whether every row that is judged lies within its band."""
        return all(row.met is not False for row in self.rows)


def record(experiment: Experiment, seeds: int, outcome: Outcome) -> Record:
    """The record of an outcome; its pictures are drawn apart."""
    e = experiment
    return Record(e.name, e.title, e.source, seeds, __version__, outcome.rows, outcome.remarks)


def save_record(kept: Record, path: str | os.PathLike[str]) -> Path:
    """Write a record as JSON, whole or not at all."""
    path = Path(path)
    told = kept._asdict() | {"rows": [_told(row) for row in kept.rows]}
    part = path.with_name(f"{path.name}.part")
    part.write_text(json.dumps(told, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return part.replace(path)


def load_record(path: str | os.PathLike[str]) -> Record:
    """Read a record that `save_record` wrote.

    Raises
    ------
    BadFile
        The file is missing, or not such a record.
    """
    try:
        told = json.loads(Path(path).read_text(encoding="utf-8"))
        rows = tuple(_row(row) for row in told["rows"])
        return Record(**(told | {"rows": rows, "remarks": tuple(told["remarks"])}))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadFile(
            f"{path} is not the record of an experiment ({error}). `uavlab reproduce --out` writes one."
        ) from None


def _told(row: Row) -> dict[str, Any]:
    band = None if row.band is None else [_number(x) for x in row.band]
    return row._asdict() | {"band": band, "ours": _number(row.ours), "spread": _number(row.spread)}


def _row(told: dict[str, Any]) -> Row:
    band = None if told["band"] is None else Band(*(float(x) for x in told["band"]))
    spread = None if told["spread"] is None else float(told["spread"])
    return Row(**(told | {"band": band, "ours": float(told["ours"]), "spread": spread}))


def _number(x: float | None) -> float | str | None:
    """To six digits, which no change of processor touches; what JSON has no word for, as text."""
    if x is None:
        return None
    return float(f"{x:.6g}") if isfinite(x) else str(float(x))
