"""IPython's magics, translated to Python on the judge's side by IPython's own transformer.

Only cells that may hold a magic are given to it, and only a few of those: it reads a cell again for each magic.
"""

from __future__ import annotations

import re

MAX_MAGICS = 50  # in one notebook

MOST_WORK = 500_000  # characters of a cell, times its magics: it is read again for each

_ASSIGNED = re.compile(r"=[ \t]*[%!]")  # x = %magic


def magics(source: str) -> int:
    """How many lines may hold a magic. Line by line: the search stays linear in what a student sends."""
    lines = [line.strip() for line in source.splitlines()]
    return sum(
        line[:1] in {"%", "!", "?"} or line.endswith("?") or bool(_ASSIGNED.search(line))
        for line in lines
        if line
    )


class Translator:
    """Translates the cells of one notebook."""

    def __init__(self) -> None:
        self._left = MAX_MAGICS

    def python(self, source: str) -> str:
        """The cell as plain Python; a cell that cannot be translated stays as it is."""
        count = magics(source)
        if not count or count > self._left or count * len(source) > MOST_WORK:
            return source
        self._left -= count
        from IPython.core.inputtransformer2 import TransformerManager

        try:
            return TransformerManager().transform_cell(source)
        except Exception:  # whatever IPython stumbles over is the student's to see, as it stands
            return source
