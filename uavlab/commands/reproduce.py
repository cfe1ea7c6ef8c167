"""Run a published experiment again: paper, ours, band and verdict of each number, and its figure.

Seeds are fixed: the same command prints the same numbers. A number outside its band is shown as such. Exit code 1 means
that some number is.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from uavlab.errors import BadInput, UavlabError

NAME = "reproduce"


class Run(NamedTuple):
    """What became of one experiment: a record and a picture, or why there is none."""

    name: str
    record: Any = None
    figure: Path | None = None
    seconds: float = 0.0
    why: str = ""


def add(parser: argparse.ArgumentParser) -> None:
    """The arguments."""
    parser.add_argument("names", nargs="*", metavar="NAME", help="such as 002-4; --list says which")
    parser.add_argument("--list", action="store_true", dest="listed", help="say which there are")
    parser.add_argument("--all", action="store_true", dest="every", help="run all of them")
    parser.add_argument("--seeds", type=int, metavar="N", help="runs behind a number (20 or more)")
    parser.add_argument(
        "--jobs", type=int, metavar="N", default=1, help="experiments at the same time (1)"
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", default=Path("reproductions"),
        help="where figures and records go (reproductions)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """List, or run and print."""
    from uavlab.experiments import all_experiments, find_experiment

    if args.listed:
        _list()
        return 0
    names = [find_experiment(name).name for name in args.names]
    if args.every:
        names = [x.name for x in all_experiments()]
    if not names:
        raise BadInput("name an experiment, or say --all. Try: uavlab reproduce --list")
    if args.seeds is not None and args.seeds < 1:
        raise BadInput(f"--seeds is {args.seeds}; it must be 1 or more.")
    if args.jobs < 1:
        raise BadInput(f"--jobs is {args.jobs}; it must be 1 or more.")
    _make(args.out)
    worst = 0
    for done in _runs(names, args.seeds, args.out, args.jobs):
        _print(done)
        worst = max(worst, 0 if done.record is not None and done.record.met else 1)
    return worst


def _make(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(
            f"cannot write into {out}: {error.strerror}. Choose another folder with --out."
        ) from None


def _list() -> None:
    from uavlab.commands.list_ import print_rows
    from uavlab.experiments import all_experiments

    print_rows([(x.name, x.source, x.title) for x in all_experiments()], indent="")


def _runs(names: list[str], seeds: int | None, out: Path, jobs: int) -> Iterator[Run]:
    """Each experiment in order, as it is done."""
    if jobs == 1:
        for name in names:
            yield once(name, seeds, out)
        return
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        yield from pool.map(once, names, [seeds] * len(names), [out] * len(names))


def once(name: str, seeds: int | None, out: Path) -> Run:
    """Run one experiment; write its figure and its record into `out`.

    Parameters
    ----------
    name : str
        As in the list.
    seeds : int, optional
        Runs behind a number; the experiment's own number without.
    out : Path
        A folder.
    """
    os.environ.setdefault("MPLBACKEND", "Agg")
    from uavlab import views
    from uavlab.experiments import find_experiment
    from uavlab.experiments.record import record, save_record

    experiment = find_experiment(name)
    start = time.perf_counter()
    try:
        outcome = experiment.outcome(seeds)
    except UavlabError as error:  # real flights that are not here, answers that are not installed
        return Run(name, why=" ".join(str(error).split()))
    seconds = time.perf_counter() - start
    kept = record(experiment, seeds or experiment.seeds, outcome)
    figure = None
    if outcome.panels:
        dpi = (
            90 if len(outcome.panels) <= 6 else 55
        )  # figures are kept with the book: not too large
        figure = views.save(views.plot_outcome(kept, outcome.panels), out / f"{name}.png", dpi=dpi)
    save_record(kept, out / f"{name}.json")
    return Run(name, kept, figure, seconds)


def _print(done: Run) -> None:
    from uavlab.commands.list_ import print_rows
    from uavlab.experiments.table import HEAD, cells

    if done.record is None:
        print(f"{done.name}: not run. {done.why}\n", flush=True)
        return
    kept = done.record
    print(f"{kept.name}  {kept.title}  ({kept.source}; {kept.seeds} seeds, {done.seconds:.0f} s)")
    print_rows([HEAD, *(cells(row) for row in kept.rows)])
    for row in kept.rows:
        if row.note:
            print(f"  · {row.quantity}: {row.note}")
    for remark in kept.remarks:
        print(f"  · {remark}")
    print(f"  {done.figure}\n" if done.figure else "", flush=True)
