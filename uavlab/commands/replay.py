"""Show flights in 3D: a log of uavlab (.npz), a PX4 log (.ulg), a GT.csv, or the name of a data set.

The first is solid, the others fly along as ghosts.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from uavlab.errors import BadInput

NAME = "replay"


def add(parser: argparse.ArgumentParser) -> None:
    """The arguments."""
    parser.add_argument(
        "logs", nargs="+", metavar="LOG", help="a file, or a data set of `uavlab list`"
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="the page to write (in replays/)")
    parser.add_argument("--open", action="store_true", help="open it in the browser")


def run(args: argparse.Namespace) -> int:
    """Read, write the page, say where it is."""
    from uavlab import views
    from uavlab.datasets import read_flight

    out = args.out
    if out is not None and (out.suffix.lower() != ".html" or out.is_dir()):
        raise BadInput(f"--out is {out}; it must be a file that ends in .html.")
    flights = {
        label: read_flight(log) for label, log in zip(_labels(args.logs), args.logs, strict=True)
    }
    try:
        page = views.replay(flights, out)
    except OSError as error:
        why = error.strerror or error
        raise BadInput(f"cannot write the page: {why}. Choose another place with --out.") from None
    for log in flights.values():
        if "citation" in log.meta:
            print(f"{log.meta['licence']}: {log.meta['citation']}")
    print(page)
    if args.open:
        import webbrowser

        webbrowser.open(page.resolve().as_uri())
    return 0


def _labels(logs: list[str]) -> list[str]:
    """A short label for each, all different."""
    labels: list[str] = []
    for k, log in enumerate(logs):
        stem = Path(log).stem if Path(log).suffix else log
        short = Path(log).parent.name if stem in {"log", "GT"} and Path(log).parent.name else stem
        labels.append(f"{short} {k + 1}" if short in labels else short)
    return labels
