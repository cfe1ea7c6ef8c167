"""Fly thousands of seeded flights: a table on the screen; a row for each flight, a summary and a page in a folder.

Whoever stops it loses nothing: the same command goes on where it was. `--fly K` flies the flight of seed K again, and
writes its log and replay. Exit code 1 means that some flight did not end as it should.
"""

from __future__ import annotations

import argparse
import shlex
import time
from pathlib import Path
from typing import Any

from uavlab.errors import BadInput

NAME = "campaign"
FLIGHTS = "flights"  # the folder of those that were flown again, one for each seed


def add(parser: argparse.ArgumentParser) -> None:
    """The arguments."""
    parser.add_argument("campaign", metavar="NAME", help="faults: random flights, random faults")
    for flag, kind, letter, said in (
        ("--runs", int, "N", "flights (1000)"),
        ("--jobs", int, "N", "processes that fly (1)"),
        ("--seed", int, "S", "of the first flight; the others follow (0)"),
        ("--fly", int, "K", "fly the flight of seed K again, and look at it"),
        ("--out", Path, "DIR", "where to write (campaigns/NAME)"),
    ):
        parser.add_argument(flag, type=kind, metavar=letter, help=said)
    parser.set_defaults(runs=1000, jobs=1, seed=0)


def run(args: argparse.Namespace) -> int:
    """Fly, print, write."""
    from uavlab.campaigns import find_campaign

    campaign = find_campaign(args.campaign)
    for flag, least in (("runs", 1), ("jobs", 1), ("seed", 0), ("fly", 0)):
        value = getattr(args, flag)
        if value is not None and value < least:
            raise BadInput(f"--{flag} is {value}; it must be {least} or more.")
    out = args.out or Path("campaigns") / campaign.name
    return _again(campaign, args.fly, out) if args.fly is not None else _flown(campaign, args, out)


def _again(campaign: Any, seed: int, out: Path) -> int:
    """One flight, to be looked at."""
    from uavlab.campaigns.run import flown
    from uavlab.commands import fly

    row, log = flown(campaign.fly, seed), campaign.log(seed)
    told = campaign.shown(row)
    print(told.title)
    for name, said in told.facts.items():
        print(f"  {name}: {said}")
    fly.show(log)
    fly.write(log, out / FLIGHTS / str(seed))
    return int(row["bad"])


def _flown(campaign: Any, args: argparse.Namespace, out: Path) -> int:
    from uavlab.campaigns import processes, run
    from uavlab.campaigns.record import Record, save_record
    from uavlab.campaigns.summary import cells
    from uavlab.commands.list_ import print_rows

    seeds = range(args.seed, args.seed + args.runs)
    start = time.perf_counter()
    rows = run(campaign, seeds, out / f"{campaign.name}.jsonl", processes(args.jobs))
    seconds = time.perf_counter() - start
    summary = campaign.summed(rows)
    told = f"uavlab campaign {campaign.name} --runs {args.runs} --seed {args.seed}"
    head = campaign.head
    kept = Record(head.campaign, head.version, head.settings, told, args.runs, summary)

    print_rows(cells(summary), indent="")
    for said in summary.said:
        print(f"  · {said}")
    for heading, some in summary.worth.items():
        print(f"{heading}: {len(some)}")
        for row in some[:SHOWN]:
            print(f"  {campaign.shown(row).title}")
    walls = sum(row["wall"] for row in rows)
    print(f"{args.runs} flights in {seconds:.0f} s; one takes {walls / len(rows):.2f} s")
    save_record(kept, out / f"{campaign.name}.json")
    where = "" if args.out is None else f" --out {shlex.quote(str(args.out))}"
    _page(campaign, kept, out, where)
    return int(any(row["bad"] for row in rows))


SHOWN = 20  # flights under each heading that the screen shows; the page has them all


def _page(campaign: Any, kept: Any, out: Path, where: str) -> None:
    from uavlab.campaigns.page import page

    def shown(row: dict[str, Any]) -> Any:
        replay = f"{FLIGHTS}/{row['seed']}/replay.html"
        command = f"uavlab campaign {campaign.name} --fly {row['seed']}{where}"
        there = (out / replay).is_file()
        return campaign.shown(row)._replace(command=command, replay=replay if there else "")

    said = [f"{kept.runs} flights: {kept.command}, version {kept.version}."]
    path = out / f"{campaign.name}.html"
    path.write_text(page(campaign.title, said, kept.summary, shown), encoding="utf-8")
    print(path)
