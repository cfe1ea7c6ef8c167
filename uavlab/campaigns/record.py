"""The record of a campaign: what became of it, as JSON that is small enough to be kept with the book."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from uavlab.campaigns.summary import Line, Share, Summary
from uavlab.errors import BadFile


class Record(NamedTuple):
    """What was flown, by which command, and what became of it."""

    campaign: str
    version: str
    settings: Mapping[str, Any]
    command: str
    runs: int
    summary: Summary


def save_record(kept: Record, path: Path) -> Path:
    """Write a record, whole or not at all."""
    summary = kept.summary._asdict()
    summary["lines"] = [x._asdict() | {"bad": x.bad._asdict()} for x in kept.summary.lines]
    told = kept._asdict() | {"summary": summary}
    part = path.with_name(f"{path.name}.part")
    part.write_text(json.dumps(told, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return part.replace(path)


def load_record(path: Path) -> Record:
    """Read a record that `save_record` wrote.

    Raises
    ------
    BadFile
        The file is missing, or not such a record.
    """
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        x = told["summary"]
        lines = tuple(Line(**(line | {"bad": Share(**line["bad"])})) for line in x["lines"])
        tuples = {k: tuple(x[k]) for k in ("endings", "said")}
        return Record(**(told | {"summary": Summary(**(x | tuples | {"lines": lines}))}))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadFile(
            f"{path} is not the record of a campaign ({error}). `uavlab campaign` writes one."
        ) from None
