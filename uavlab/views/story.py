"""What happened in a flight, as its log tells it: in which mode it was, who flew, what broke, and what was said."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from uavlab.flight.log import Log
from uavlab.flight.worlds import flown_by
from uavlab.managers import modes
from uavlab.parts.slot import FIRST, TAKEN
from uavlab.views import style

FAILSAFE = "Failsafe"  # the part that flies then
SLOTS = ("tracker", "controller", "estimator", "limits", "gains")
_GRAVE = ("safety", "bumper", "remote", "touchdown", "mode")  # who speaks first of one instant


class Moment(NamedTuple):
    """Something that happened at once: an event of a log."""

    t: float  # [s]
    kind: str  # mode, tracker, …, refused, safety, bumper, remote, touchdown
    name: str  # of mode, part, group, trigger, or of what was refused
    said: str  # what became of it, or why

    @property
    def taken(self) -> bool:
        """Whether a part, gains or limits took over in flight."""
        return self.kind in SLOTS and self.said == TAKEN

    @property
    def first(self) -> bool:
        """Whether it only tells how the flight began."""
        return self.said == FIRST or (self.kind == "mode" and self.t <= 0.0)

    @property
    def refused(self) -> bool:
        """Whether something was asked that was not done."""
        return self.kind == "refused" or self.said.startswith("refused")

    @property
    def color(self) -> str:
        """Of its mark."""
        if self.kind == "mode":
            return style.mode(self.name)
        if self.refused:
            return style.MARKS["refused"]
        return style.MARKS.get(self.kind, style.MARKS["swap"])

    @property
    def sentence(self) -> str:
        """What is read of it, without its time."""
        if self.kind == "mode":
            return f"mode {self.name}: {self.said}" if self.said else f"mode {self.name}"
        if self.kind == "refused":
            return f"{self.name} refused: {self.said.removeprefix('refused: ')}"
        if self.kind in SLOTS:
            return f"{self.kind} {self.name}: {self.said}"
        return ": ".join(x for x in (self.kind, self.name, self.said) if x)


class Band(NamedTuple):
    """Something that lasted."""

    start: float  # [s]
    end: float  # [s]
    name: str


def moments(log: Log) -> list[Moment]:
    """The events of a log until its last tick, in order, of one instant by gravity; of an older log, its swaps."""
    told = log.meta.get("events") or log.meta.get("swaps") or []
    last = float(log.t[-1]) if len(log.t) else -np.inf
    found = [Moment(float(t), str(kind), str(name), str(said)) for t, kind, name, said in told]
    found = [x for x in found if x.t <= last + 1e-6]
    return sorted(found, key=lambda x: (round(x.t, 6), _gravity(x)))


def news(log: Log) -> list[Moment]:
    """The events without those that only tell how it began."""
    return [x for x in moments(log) if not x.first]


def spoken(log: Log) -> list[Moment]:
    """The news, with nothing said twice in one instant: a change of mode often has the words of its trigger."""
    found: list[Moment] = []
    for x in news(log):
        again = any(x.said and y.said == x.said and x.t - y.t < 1e-6 for y in found[-4:])
        found.append(x._replace(said="") if again and x.kind == "mode" else x)
    return found


def _gravity(x: Moment) -> int:
    return _GRAVE.index(x.kind) if x.kind in _GRAVE else len(_GRAVE) + x.refused


def bands(log: Log, kind: str) -> list[Band]:
    """From when to when each mode lasted, or each part of a slot flew, in order; to the end of the log.

    Under a failsafe neither tracker nor controller flies; it does.
    """
    if not len(log.t):
        return []
    starts = [
        (x.t, FAILSAFE if x.kind != kind else x.name)
        for x in moments(log)
        if (x.kind == kind and _begins(x)) or (kind in SLOTS[:2] and _falls(x))
    ]
    if not starts and kind == "estimator" and log.worlds.names:
        return [Band(a, b, name or "the start") for a, b, name in flown_by(log)]
    if not starts:
        return []
    last = float(log.t[-1])
    ends = [t for t, _ in starts[1:]] + [last]
    made = [Band(t, min(end, last), name) for (t, name), end in zip(starts, ends, strict=True)]
    return [x for x in made if x.end > x.start or x is made[-1]]


def _falls(x: Moment) -> bool:
    return x.kind == "mode" and x.name == modes.FAILSAFE


def _begins(x: Moment) -> bool:
    return x.kind == "mode" or x.said in {FIRST, TAKEN}


def rows(log: Log) -> dict[str, list[Band]]:
    """The bands of the modes and of every slot of which the log tells anything."""
    return {kind: made for kind in ("mode", *SLOTS) if (made := bands(log, kind))}


def faults(log: Log) -> list[Band]:
    """What was broken, and when: each with what it was, in words."""
    last = float(log.t[-1]) if len(log.t) else 0.0
    found = []
    for kind, t, until, what, value in log.meta.get("faults") or []:
        start, end = float(t or 0.0), last if until is None else min(float(until), last)
        if start <= last:
            found.append(Band(start, max(start, end), _broken(str(kind), str(what), value)))
    return found


def _broken(kind: str, what: str, value: Any) -> str:
    """A fault in a few words: its kind, what it strikes, and how hard."""
    words = [kind, what]
    if isinstance(value, str):
        words.append(value)
    elif value is not None and np.any(np.asarray(value, dtype=float)):
        numbers = np.atleast_1d(np.asarray(value, dtype=float))
        words.append(", ".join(f"{x:g}" for x in numbers))
    elif kind in {"motor", "battery"}:
        words.append("0")  # a share of nothing at all says much
    return " ".join(x for x in words if x)


def has_modes(log: Log) -> bool:
    """Whether a pilot with modes flew, and the log has a tick."""
    return bool(bands(log, "mode"))


def eventful(log: Log) -> bool:
    """Whether there is a story to tell: a mode, a swap, a refusal, a fault."""
    return bool(has_modes(log) or news(log) or log.meta.get("faults"))


def pieces(log: Log) -> Iterator[tuple[slice, str, str]]:
    """The flight cut where its mode changes: rows of the log, colour, and the mode; nothing without modes.

    Pieces touch: each begins where the one before ends. What came before the first mode is blue, as a flown path is.
    """
    made = bands(log, "mode")
    if not made:
        return
    cuts = np.searchsorted(log.t, [x.start - 1e-9 for x in made]).tolist()
    if cuts[0] > 0:
        yield slice(0, cuts[0] + 1), style.FLOWN, ""
    for x, a, b in zip(made, cuts, [*cuts[1:], len(log.t) - 1], strict=True):
        if a <= b:
            yield slice(a, b + 1), style.mode(x.name), x.name
