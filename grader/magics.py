"""IPython's magics, translated to Python on the judge's side by IPython's own transformer.

Only cells that may hold a magic are given to it, and only a few of those: it reads a cell again for each magic.
"""

from __future__ import annotations

import re

MAX_MAGICS = 50  # in one notebook

_MAGIC = re.compile(r"^\s*(?:%|!|\?|.*\?\s*$)|=\s*[%!]", re.MULTILINE)


class Translator:
    """Translates the cells of one notebook."""

    def __init__(self) -> None:
        self._left = MAX_MAGICS

    def python(self, source: str) -> str:
        """The cell as plain Python; a cell that cannot be translated stays as it is."""
        count = len(_MAGIC.findall(source))
        if not count or count > self._left:
            return source
        self._left -= count
        from IPython.core.inputtransformer2 import TransformerManager

        try:
            return TransformerManager().transform_cell(source)
        except (SyntaxError, RuntimeError, RecursionError, ValueError):
            return source
