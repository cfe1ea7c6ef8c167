"""Files that a command writes: all of them or none."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from uavlab.errors import BadInput


@contextmanager
def folder(path: Path) -> Iterator[Path]:
    """A folder to write into; its files appear in `path` when all is well, and nowhere otherwise.

    Raises
    ------
    BadInput
        `path` cannot be a folder.
    """
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        if path.exists() and not path.is_dir():
            raise FileExistsError("it is a file")
        part.mkdir(parents=True)
    except OSError as error:
        why = error.strerror or error
        raise BadInput(
            f"cannot write into {path}: {why}. Choose another folder with --out."
        ) from None
    try:
        yield part
        path.mkdir(exist_ok=True)
        for file in sorted(part.iterdir()):
            file.replace(path / file.name)
    finally:
        shutil.rmtree(part, ignore_errors=True)
