"""The book's page of reproductions, from the records that ``uavlab reproduce`` wrote into ``book/reproductions``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from uavlab.experiments import all_experiments
from uavlab.experiments.record import Record, load_record
from uavlab.experiments.table import HEAD, cells, verdict

MARK = "<!-- reproductions -->"


def reproductions_page(prose: str, folder: Path) -> str:
    """The page: what the paper printed and what we got, one section for each experiment.

    Parameters
    ----------
    prose : str
        The page as it is written, with `MARK` where the results go.
    folder : Path
        With the records and figures.

    Returns
    -------
    str
        MyST Markdown. An experiment without a record is named as such.
    """
    kept = {x.name: folder / f"{x.name}.json" for x in all_experiments()}
    records = [load_record(path) for path in kept.values() if path.is_file()]
    parts = [_overview(records)]
    parts += [_section(x, folder) for x in records]
    if absent := [name for name, path in kept.items() if not path.is_file()]:
        parts.append(f"Not run yet: {', '.join(absent)}.\n")
    return prose.replace(MARK, "\n".join(parts))


def _overview(records: list[Record]) -> str:
    judged = [row for x in records for row in x.rows if row.met is not None]
    met = sum(bool(row.met) for row in judged)
    lines = [
        f"{met} of {len(judged)} numbers lie within their bands.\n",
        "| experiment | what | source | within the band |",
        "|---|---|---|---:|",
    ]
    for x in records:
        of = [row for row in x.rows if row.met is not None]
        count = f"{sum(bool(row.met) for row in of)} of {len(of)}"
        lines.append(f"| [{x.name}](#experiment-{x.name}) | {x.title} | {x.source} | {count} |")
    return "\n".join(lines) + "\n"


def _section(x: Record, folder: Path) -> str:
    return "\n".join(_lines(x, folder)) + "\n"


def _lines(x: Record, folder: Path) -> Iterator[str]:
    yield f"(experiment-{x.name})="
    yield f"## {x.name} · {x.title}\n"
    yield f"{x.source}. `uavlab reproduce {x.name}`, {_seeds(x.seeds)}, version {x.version}.\n"
    yield f"| {' | '.join(HEAD)} |"
    yield "|---|---|---|---|---|"
    for row in x.rows:
        told = [cell.replace("|", "\\|") for cell in cells(row)]
        told[-1] = f"**{told[-1].lower()}**" if row.met is False else verdict(row)
        yield f"| {' | '.join(told)} |"
    yield ""
    yield from (f"- {row.quantity}: {row.note}" for row in x.rows if row.note)
    yield from (f"- {remark}" for remark in x.remarks)
    if (folder / f"{x.name}.png").is_file():
        yield f"\n![{x.title}: what was flown](reproductions/{x.name}.png)"


def _seeds(count: int) -> str:
    return f"{count} seed{'s' * (count != 1)}"
