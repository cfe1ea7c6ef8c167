"""The summary of a campaign: how often each thing ended in each way, and how sure one may be of that."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import sqrt
from typing import NamedTuple

from uavlab.campaigns.table import Row

Z = 1.959964  # of a normal distribution: 95 % lie within ± this


class Share(NamedTuple):
    """How often something happened."""

    of: int
    times: int
    low: float  # the Wilson interval of its probability, 95 %
    high: float

    def __str__(self) -> str:
        return f"{self.times} of {self.of} ({100 * self.low:.1f} to {100 * self.high:.1f} %)"


class Line(NamedTuple):
    """A line of the table: those flights that have one thing in common."""

    name: str
    flights: int
    endings: Mapping[str, int]  # ending → flights
    bad: Share  # of the flights, those that did not end as they should


class Summary(NamedTuple):
    """What became of a campaign."""

    first: str  # what the lines are
    endings: tuple[str, ...]  # the columns
    lines: tuple[Line, ...]  # the last one is of all flights
    said: tuple[str, ...] = ()  # sentences beside the table
    worth: Mapping[str, Sequence[Row]] = {}  # flights worth a look, under their headings


def wilson(count: int, of: int, z: float = Z) -> Share:
    """The score interval of Wilson (1927): it stays within 0 and 1, and says something of a count of 0, too."""
    if of == 0:
        return Share(0, 0, 0.0, 1.0)
    p, n = count / of, of
    middle = p + z * z / (2 * n)
    half = z * sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    scale = 1 + z * z / n
    low = 0.0 if count == 0 else (middle - half) / scale
    high = 1.0 if count == n else (middle + half) / scale
    return Share(of, count, low, high)


def counted(
    rows: Sequence[Row],
    first: str,
    groups: Callable[[Row], Iterable[str]],
    ending: Callable[[Row], str],
) -> Summary:
    """Count the rows of a campaign.

    Parameters
    ----------
    rows : sequence of dict
        One for each flight.
    first : str
        What the lines of the table are.
    groups : callable
        The lines in which a flight counts; twice the same counts once.
    ending : callable
        Its column. Whether it did not end as it should is its ``bad``.
    """
    of: dict[str, list[Row]] = {}
    for row in rows:
        for name in dict.fromkeys(groups(row)):
            of.setdefault(name, []).append(row)
    endings = tuple(x for x, _ in Counter(ending(row) for row in rows).most_common())
    of = {name: of[name] for name in sorted(of)} | {"all flights": list(rows)}
    lines = []
    for name, some in of.items():
        counts = Counter(ending(row) for row in some)
        share = wilson(sum(row["bad"] for row in some), len(some))
        lines.append(Line(name, len(some), {x: counts[x] for x in endings}, share))
    return Summary(first, endings, tuple(lines))


def cells(summary: Summary) -> list[tuple[str, ...]]:
    """The table as text: a head, and a row for each line."""
    rows: list[tuple[str, ...]] = [
        (summary.first, "flights", *summary.endings, "not as it should [95 %]")
    ]
    for x in summary.lines:
        counts = (str(x.endings[k] or "·") for k in summary.endings)
        rows.append((x.name, str(x.flights), *counts, str(x.bad)))
    return rows
