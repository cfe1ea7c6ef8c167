"""Try every function and class of the students' wheel as an answer to every exercise; print which pass as JSON.

Run by test_leaks.py: ``NUMBA_DISABLE_JIT=1 python shipped_functions.py dynamics heading``, for these labs.
"""

import contextlib
import importlib
import inspect
import io
import json
import pkgutil
import signal
import sys
import warnings
from functools import cache, partial

import numpy as np

import uavlab
from grader.judge import run
from grader.material import hidden_checks
from grader.watched import Watched
from uavlab.exercises import exercises

SLOW = ("uavlab.commands", "uavlab.datasets")  # they fetch, serve and print; no arithmetic in them
PATIENCE = 2.0  # [s] for what is tried; an experiment that is called with whatever there is flies for minutes


class TookTooLong(BaseException):
    """No answer takes that long."""


@contextlib.contextmanager
def alarm(seconds):
    """Stop what is inside after so many seconds."""

    def stop(*_):
        raise TookTooLong

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def modules():
    for item in pkgutil.walk_packages(uavlab.__path__, "uavlab."):
        if not item.name.startswith(("uavlab.solutions", "uavlab.__main__", *SLOW)):
            yield importlib.import_module(item.name)


def functions():
    """Every function that the wheel defines, private ones and methods, too."""
    found = {}
    for module in modules():
        for name, thing in vars(module).items():
            mine = {name: thing}
            if inspect.isclass(thing) and thing.__module__.startswith("uavlab"):
                mine = {f"{name}.{k}": getattr(thing, k, None) for k in vars(thing)}
            for path, value in mine.items():
                home = getattr(value, "__module__", None) or ""
                if inspect.isfunction(value) and home.startswith("uavlab"):
                    found[f"{home}.{path}"] = value
    return found


@cache
def accepts(function, count):
    """Whether `count` values can be given by position."""
    try:
        inspect.signature(function).bind(*range(count))
    except TypeError:
        return False
    return True


def classes():
    """Every class that the wheel defines."""
    return {
        f"{value.__module__}.{name}": value
        for module in modules()
        for name, value in vars(module).items()
        if inspect.isclass(value) and value.__module__.startswith("uavlab")
    }


def made(kind, *args, **kwargs):
    """An object of a class: with what was asked for, else as it comes."""
    try:
        return kind(*args, **kwargs)
    except TypeError:
        return kind()


def passes(exercise, answer):
    """Whether an answer passes every check that counts: the judge without its patience for partial credit."""
    watched = Watched(answer, exercise.methods)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return all(
            run(check, watched, np.random.default_rng(1), public=True).passed
            for check in (*exercise.checks, *hidden_checks(exercise))
            if check.weight > 0
        )


def tried(exercise, functions, classes):
    """Shipped function or class that can be called like the exercise → whether it passes."""
    if exercise.is_class:
        return {
            path: passes(exercise, partial(made, kind))
            for path, kind in classes.items()
            if any(hasattr(kind, name) for name in exercise.methods)
        }
    count = len(inspect.signature(exercise.stub).parameters)
    return {
        path: passes_in_time(exercise, lambda *a, f=f, **k: f(*a, *k.values()))
        for path, f in functions.items()
        if accepts(f, count)
    }


def passes_in_time(exercise, answer):
    """Whether an answer passes, and does not take for ever."""
    try:
        with alarm(PATIENCE):
            return passes(exercise, answer)
    except TookTooLong:
        return False


if __name__ == "__main__":
    with contextlib.redirect_stdout(io.StringIO()):
        known = functions(), classes()
        table = {x.name: tried(x, *known) for stem in sys.argv[1:] for x in exercises(stem)}
    print(json.dumps(table))
