"""The page of a campaign: one HTML file that asks the network for nothing, and tells how to see a flight again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from typing import NamedTuple

from uavlab.campaigns.summary import Summary, cells
from uavlab.campaigns.table import Row

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; color: #222 }
table { border-collapse: collapse; margin: 1rem 0 }
th, td { padding: .2rem .7rem; text-align: right; border-bottom: 1px solid #ddd }
th:first-child, td:first-child { text-align: left }
tr:last-child td { font-weight: bold }
details { border-bottom: 1px solid #ddd; padding: .3rem 0 }
summary { cursor: pointer }
code { background: #f3f3f3; padding: .1rem .4rem; user-select: all }
.none { color: #bbb }
"""


class Shown(NamedTuple):
    """One flight, as the page shows it."""

    title: str  # in a line
    facts: Mapping[str, str]  # what opens when it is clicked
    command: str  # that flies it again
    replay: str = ""  # page of its flight, if it is there; relative to this one


def page(title: str, said: Sequence[str], summary: Summary, shown: Callable[[Row], Shown]) -> str:
    """The page.

    Parameters
    ----------
    title : str
        Its headline.
    said : sequence of str
        Paragraphs that come first: what was flown, and by which command.
    summary : Summary
        What became of it.
    shown : callable
        What is told of a flight.
    """
    parts = [f"<h1>{escape(title)}</h1>", *(f"<p>{escape(x)}</p>" for x in said)]
    parts += _table(cells(summary))
    parts += [f"<p>{escape(x)}</p>" for x in summary.said]
    for heading, rows in summary.worth.items():
        parts.append(f"<h2>{escape(heading)}: {len(rows)}</h2>")
        parts += [_flight(shown(row)) for row in rows] or ["<p>None.</p>"]
    body = "\n".join(parts)
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(title)}</title>\n'
        f"<style>{STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def _table(rows: Sequence[tuple[str, ...]]) -> Iterator[str]:
    yield "<table>"
    for k, row in enumerate(rows):
        tag = "th" if k == 0 else "td"
        told = (f"<{tag}{' class=none' * (x == '·')}>{escape(x)}</{tag}>" for x in row)
        yield f"<tr>{''.join(told)}</tr>"
    yield "</table>"


def _flight(x: Shown) -> str:
    facts = "".join(f"<br>{escape(k)}: {escape(v)}" for k, v in x.facts.items() if v)
    link = f'<a href="{escape(x.replay)}">replay</a> · ' if x.replay else ""
    return (
        f"<details><summary>{escape(x.title)}</summary>"
        f"<p>{link}fly it again: <code>{escape(x.command)}</code>{facts}</p></details>"
    )
