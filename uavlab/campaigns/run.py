"""Fly the seeds of a campaign that its table does not have yet, on one process or on many: the numbers are the same.

How the flights are spread is one function, an `Executor`: `here` flies them one after the other, `processes(n)` on
n processes. Neither keeps anything: what was flown is in the table, and whoever is killed begins there again.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TypeAlias

from uavlab.campaigns.spec import Campaign
from uavlab.campaigns.table import Row, open_table
from uavlab.errors import BadInput, UavlabError

Executor: TypeAlias = Callable[[Callable[[int], Row], Sequence[int]], Iterator[Row]]
RAISED = "RAISED"  # the exit of a flight that is none: the library itself raised
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def here(fly: Callable[[int], Row], seeds: Sequence[int]) -> Iterator[Row]:
    """One after the other, in this process."""
    return map(fly, seeds)


def processes(jobs: int) -> Executor:
    """On this number of processes, each with one thread; `here` if it is one.

    Raises
    ------
    BadInput
        Fewer than one.
    """
    if jobs < 1:
        raise BadInput(f"--jobs is {jobs}; it must be 1 or more.")
    return here if jobs == 1 else partial(_spread, jobs)


def run(
    campaign: Campaign, seeds: Sequence[int], path: Path, executor: Executor = here
) -> list[Row]:
    """Fly what is missing of `seeds`, and return all their rows.

    Parameters
    ----------
    campaign : Campaign
        What is flown.
    seeds : sequence of int
        Each a flight.
    path : Path
        The table. Rows of other seeds in it stay there.
    executor : Executor
        Who flies; rows arrive in any order.

    Returns
    -------
    list of dict
        In the order of `seeds`. A flight that raised has the exit `RAISED`, and the traceback in ``why``.

    Raises
    ------
    BadInput, BadFile
        The table is another one, or none: see `uavlab.campaigns.table.open_table`.
    """
    from tqdm import tqdm

    with open_table(path, campaign.head) as (rows, add):
        missing = [seed for seed in dict.fromkeys(seeds) if seed not in rows]
        flights = executor(partial(flown, campaign.fly), missing)
        bar = tqdm(total=len(seeds), initial=len(seeds) - len(missing), desc=campaign.name,
                   unit=" flights", disable=None)  # fmt: skip
        with bar:
            for row in flights:
                add(row)
                rows[row["seed"]] = row
                bar.update()
    return [rows[seed] for seed in seeds]


def flown(fly: Callable[[int], Row], seed: int) -> Row:
    """The row of one flight, with its ``seed`` and the ``wall`` time [s] that it took."""
    start = time.perf_counter()
    try:
        row = fly(seed)
    except Exception as error:  # one flight of thousands: kept, seen, and the others go on
        said = f"{type(error).__name__}: {error}"
        row = {"exit": RAISED, "bad": True, "reason": said, "why": traceback.format_exc()}
    return {"seed": seed, **row, "wall": round(time.perf_counter() - start, 3)}


def _spread(jobs: int, fly: Callable[[int], Row], seeds: Sequence[int]) -> Iterator[Row]:
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from concurrent.futures.process import BrokenProcessPool

    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))  # before a worker imports numpy
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_follow_parent)
    try:
        for done in as_completed([pool.submit(fly, seed) for seed in seeds]):
            yield done.result()
    except BrokenProcessPool:
        raise UavlabError(
            "a process that flew was killed. What was flown is in the table: the same command goes on from there, "
            "and with fewer --jobs needs less memory."
        ) from None
    finally:
        pool.shutdown(cancel_futures=True)
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


def _follow_parent() -> None:
    """A worker ends with who started it, and not before: it would wait for work for ever if that one is killed."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # who started it is interrupted, too, and says so once
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
