"""What can go wrong at the edges, each with the culprit, the value, the bound and the cure."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class UavlabError(Exception):
    """The base of every error that uavlab raises on purpose."""


class BadInput(UavlabError, ValueError):
    """A value outside what is allowed: wrong shape, NaN, not a rotation, out of bounds."""


class UnknownName(UavlabError, LookupError):
    """A name that is not in the list; the message says which are, and which one is near."""

    def __init__(self, kind: str, name: object, known: Iterable[str]) -> None:
        self.kind, self.name, self.known = kind, name, sorted(known)
        near = difflib.get_close_matches(str(name), self.known, n=1, cutoff=0.5)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        super().__init__(f"no {kind} named {name!r}.{hint} Known: {', '.join(self.known)}.")


class BadFile(UavlabError, OSError):
    """A file that is missing, cut short, or not what its name promises."""


class CheckFailed(UavlabError, AssertionError):
    """An exercise's check did not pass; the message is the feedback for its author."""
