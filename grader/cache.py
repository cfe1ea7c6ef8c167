"""Marks that were given once, kept by content: grading a class again runs nothing.

The key is a hash of everything that a mark depends on: the student's code, the grader, the library, the seed, the
limits. The files lie in the course directory, where no student's process can reach, and hold our own sentences.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import platform
import sys
from functools import cache
from pathlib import Path
from typing import Any

FOLDER = ".marks"  # below the course directory


@cache
def version() -> str:
    """A hash of the grader and the library: every file that can change a mark."""
    digest = hashlib.sha256(f"{platform.machine()} {sys.version}".encode())
    library = importlib.util.find_spec("uavlab")
    folders = [Path(__file__).parent]
    if library is not None and library.origin is not None:
        folders.append(Path(library.origin).parent)
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            if path.suffix in (".py", ".toml") and "attacks" not in path.parts:
                digest.update(str(path.relative_to(folder)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def key(*parts: Any) -> str:
    """The hash of some JSON-able parts, and of `version`."""
    return hashlib.sha256(json.dumps([version(), *parts], sort_keys=True).encode()).hexdigest()


def load(folder: Path | None, name: str) -> dict[str, Any] | None:
    """What is kept under this key, or None."""
    if folder is None:
        return None
    try:
        kept = json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return kept if isinstance(kept, dict) else None


def save(folder: Path | None, name: str, value: dict[str, Any]) -> None:
    """Keep a value, all of it or nothing."""
    if folder is None:
        return
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    part = folder / f"{name}.{os.getpid()}.part"
    part.write_text(json.dumps(value), encoding="utf-8")
    part.replace(folder / f"{name}.json")
