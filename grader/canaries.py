"""The canaries: a token in every file that no student may see. Leak tests look for them in all that ships."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
SECRET = ("grader/hidden", "grader/mutants", "grader/variants", "uavlab/solutions")
TOKEN = re.compile(r"canary-[0-9a-f]{24}")


def secret_files() -> list[Path]:
    """Every file that is kept from students, of the rooms whose every module must carry a token."""
    return [
        path
        for room in SECRET
        for path in sorted((ROOT / room).glob("*.py"))
        if path.name != "__init__.py"
    ]


def canaries() -> dict[str, Path]:
    """Each token, and the file that it stands in.

    Raises
    ------
    LookupError
        A secret file carries no token, or the token of another file.
    """
    tokens: dict[str, Path] = {}
    for path in secret_files():
        found = set(TOKEN.findall(path.read_text(encoding="utf-8")))
        if len(found) != 1 or found & tokens.keys():
            raise LookupError(f"{path} carries {len(found)} tokens of its own; one is needed.")
        tokens[found.pop()] = path
    return tokens
