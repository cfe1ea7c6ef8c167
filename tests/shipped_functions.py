"""Try every function and class of the students' wheel as an answer to every exercise; print the points as JSON.

Run by test_leaks.py: ``NUMBA_DISABLE_JIT=1 python shipped_functions.py``.
"""

import contextlib
import importlib
import inspect
import io
import json
import pkgutil
from functools import partial

import uavlab
from grader.judge import judge
from uavlab.exercises import all_exercises

SLOW = ("uavlab.commands", "uavlab.datasets")  # they fetch, serve and print; no arithmetic in them


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


def class_scores(exercise, known):
    return {
        path: judge(exercise, partial(made, kind), seed=1).score
        for path, kind in known.items()
        if any(hasattr(kind, name) for name in exercise.methods)
    }


def scores(exercise, known):
    count = len(inspect.signature(exercise.stub).parameters)
    return {
        path: judge(exercise, lambda *a, f=f, **k: f(*a, *k.values()), seed=1).score
        for path, f in known.items()
        if accepts(f, count)
    }


if __name__ == "__main__":
    known = functions()
    with contextlib.redirect_stdout(io.StringIO()):
        kinds = classes()
        table = {
            x.name: class_scores(x, kinds) if x.is_class else scores(x, known)
            for x in all_exercises()
        }
    print(json.dumps(table))
