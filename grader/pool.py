"""Mark many notebooks, some at a time; each process has a place, and so a user id in the box, of its own."""

from __future__ import annotations

import ctypes
import multiprocessing
import resource
import signal
import warnings
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from typing import Any, NamedTuple

from grader.coursework import Submission
from grader.mark import Marks, Options, mark

_PARENT_DEATH = 1  # PR_SET_PDEATHSIG of prctl(2)
_place: int = 0  # of this process; set once when the pool starts it


class Outcome(NamedTuple):
    """What marking one submission gave: marks, or why there are none."""

    submission: Submission
    marks: Marks | None
    error: str = ""
    cpu: float = 0.0  # [s] of the grader's own; the box is counted in the marks


def mark_all(submissions: Sequence[Submission], options: Options, jobs: int) -> Iterator[Outcome]:
    """Mark submissions in up to `jobs` processes; yields each as it is done."""
    if jobs <= 1 or len(submissions) <= 1:
        yield from (_mark(x, options) for x in submissions)
        return
    # Forked, not spawned: the grader has no threads, and its imports cost as much as five submissions.
    context: Any = multiprocessing.get_context("fork")
    places = context.SimpleQueue()
    for place in range(jobs):
        places.put(place)
    with (
        warnings.catch_warnings(),
        ProcessPoolExecutor(jobs, context, initializer=_take, initargs=(places,)) as pool,
    ):
        warnings.simplefilter("ignore", DeprecationWarning)  # numpy's idle threads do not mind
        tasks = {pool.submit(_mark, x, options): x for x in submissions}
        try:
            for task in as_completed(tasks):
                try:
                    yield task.result()
                except BrokenProcessPool as error:
                    yield Outcome(tasks[task], None, f"the grader's process ended ({error})")
        except (KeyboardInterrupt, GeneratorExit):
            for process in context.active_children():  # the pool would wait for what is under way
                process.kill()
            raise


def _take(places: Any) -> None:
    global _place  # noqa: PLW0603  (one number for a process's life; a pool gives no other way)
    _place = places.get()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to answer
    ctypes.CDLL(None).prctl(_PARENT_DEATH, signal.SIGKILL)  # and nobody outlives it


def _mark(submission: Submission, options: Options) -> Outcome:
    before = resource.getrusage(resource.RUSAGE_SELF)
    try:
        marks = mark(submission.graft.notebook, options._replace(place=_place))
    except Exception as error:  # one submission never stops the others
        return Outcome(submission, None, f"{type(error).__name__}: {error}")
    after = resource.getrusage(resource.RUSAGE_SELF)
    own = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Outcome(submission, marks, cpu=own)
