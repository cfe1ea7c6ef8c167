"""A student's prose, made harmless for the browser of the person who grades it.

nbconvert passes raw HTML, and links of any scheme, through to the page. So no tag, no link and no picture of a
student's gets into one: what would become one is left as readable text.
"""

from __future__ import annotations

import re

_TAG = re.compile(r"<(?=[A-Za-z/!?])")  # only these make a tag, a comment or an automatic link
_LINK = re.compile(r"\](?=[(\[:])")  # [label](target), [label][reference], [reference]: target


_ADDRESS = re.compile(r"(?<=[A-Za-z]):(?=//)")  # https://… becomes a link by itself


_MOST, _MARKS = 20_000, 2_000  # characters, and marks among them, of a text that is laid out
_GAP = re.compile(r"[ \t]{100,}")


def harmless(text: str) -> str:
    """The same text without anything that a browser would run, load or follow.

    What would take the page's maker long to lay out is shown as it was typed, as code.
    """
    text = _GAP.sub(" " * 99, text)
    if len(text) > _MOST or sum(map(text.count, "\\$*_`[]")) > _MARKS:
        text = "\n".join(f"    {line}" for line in text.splitlines())
    text = _TAG.sub("< ", text.replace("\x00", ""))
    return _ADDRESS.sub(": ", _LINK.sub(r"]\\", text))
