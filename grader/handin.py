"""What students really put into ``submitted/``: copies with (1) in their names, wrong folders, archives."""

from __future__ import annotations

import os
import re
import unicodedata
from pathlib import Path

MOST = 8  # names in one note


def find_notebook(folder: Path, name: str) -> tuple[Path, list[str]]:
    """The file that is graded as ``<name>.ipynb``, and what an instructor should know about it.

    If it is not there, the only notebook in the folder is taken for it; what else lies there is named.
    Links are not followed here; the file itself is checked when it is read.
    """
    wanted = folder / f"{name}.ipynb"
    try:
        there = sorted(x.name for x in os.scandir(folder) if x.name != "timestamp.txt")
    except OSError:
        return wanted, []
    others = [x for x in there if x != wanted.name and not x.startswith(".")]
    notebooks = [x for x in others if x.lower().endswith(".ipynb")]
    if wanted.name in there:
        return wanted, [f"also there, not graded: {named(notebooks)}"] if notebooks else []
    if len(notebooks) == 1:
        return folder / notebooks[0], [f"{notebooks[0]!r} was taken for {wanted.name}"]
    if others:
        return wanted, [f"{wanted.name} is missing; there is {named(others)}"]
    return wanted, [f"{wanted.name} is missing; the folder is empty"]


def left_out(submitted: Path, assignment: str, graded: set[str]) -> list[str]:
    """What lies in ``submitted/`` and is not graded as `assignment`, one sentence each."""
    said = []
    for folder in sorted(submitted.iterdir()) if submitted.is_dir() else []:
        if not folder.is_dir() or folder.is_symlink():
            said.append(f"submitted/{folder.name!r} is no folder of a student")
            continue
        names = sorted(x.name for x in os.scandir(folder))
        near = [x for x in names if x != assignment and x.lower() == assignment.lower()]
        loose = [x for x in names if x.lower().endswith(".ipynb")]
        if near:
            said.append(f"submitted/{folder.name}/{near[0]} should be called {assignment}")
        elif loose and folder.name not in graded:
            said.append(
                f"submitted/{folder.name} holds {named(loose)}, which belongs into a folder {assignment}"
            )
    return said


def plain_name(name: str) -> str:
    """A name that nbgrader takes for a student's, made of one that it does not."""
    ascii_ = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    return re.sub(r"[^A-Za-z0-9_@+-]+", "-", ascii_).strip("-") or "student"


def named(names: list[str]) -> str:
    """Some names, quoted; not all of a long list."""
    more = f" and {len(names) - MOST} more" if len(names) > MOST else ""
    return ", ".join(map(repr, names[:MOST])) + more
