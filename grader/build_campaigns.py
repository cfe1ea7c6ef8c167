"""The book's page of campaigns, from the records that ``uavlab campaign`` wrote into ``book/campaigns``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from uavlab.campaigns import NAMES, Campaign, find_campaign
from uavlab.campaigns.record import Record, load_record
from uavlab.campaigns.summary import cells

MARK = "<!-- campaigns -->"


def campaigns_page(prose: str, folder: Path) -> str:
    """The page: one section for each campaign that there is.

    Parameters
    ----------
    prose : str
        The page as it is written, with `MARK` where the results go.
    folder : Path
        With the records.

    Returns
    -------
    str
        MyST Markdown. A campaign without a record is named as such.
    """
    parts = []
    for name in NAMES:
        path = folder / f"{name}.json"
        if path.is_file():
            parts.append("\n".join(_lines(find_campaign(name), load_record(path))))
        else:
            parts.append(f"Not flown yet: {name}.\n")
    return prose.replace(MARK, "\n".join(parts))


def _lines(campaign: Campaign, x: Record) -> Iterator[str]:
    yield f"(campaign-{x.campaign})="
    yield f"## {campaign.title}\n"
    yield f"`{x.command}`, version {x.version}.\n"
    table = [[cell.replace("|", "\\|") for cell in row] for row in cells(x.summary)]
    yield f"| {' | '.join(table[0])} |"
    yield f"|---|{'---:|' * (len(table[0]) - 1)}"
    yield from (f"| {' | '.join(row)} |" for row in table[1:])
    yield ""
    yield from (f"- {said}" for said in x.summary.said)
    for heading, rows in x.summary.worth.items():
        yield f"\n### {heading}\n"
        yield from (_flight(campaign, row) for row in rows)
        yield "" if rows else "None.\n"


def _flight(campaign: Campaign, row: dict) -> str:
    told = campaign.shown(row)
    facts = "; ".join(f"{k}: {v}" for k, v in told.facts.items() if v)
    return f"- {told.title}. {facts}. `{told.command}`"
