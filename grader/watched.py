"""An answer that is watched while it is judged: handed copies, asked again, and its memory held shut."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from uavlab.exercises.classes import Method
from uavlab.exercises.spec import Function, WrongForm

NO_METHODS: Mapping[str, Method] = MappingProxyType({})


class Held:
    """A student's memory, which no check looks into."""

    def __init__(self, memory: Any) -> None:
        self.memory = memory


class Watched:
    """An answer that is handed copies, so that what it does to them hurts nobody; and is seen doing it.

    Parameters
    ----------
    answer : callable
        A function, or a class if `methods` are asked for.
    methods : mapping of str to Method
        Of the exercise. Calling the answer then makes an object that has these methods and nothing else.
    """

    def __init__(self, answer: Function, methods: Mapping[str, Method] = NO_METHODS) -> None:
        self.answer, self.methods, self.calls = answer, methods, 0
        self.changed = self.unfinished = False
        self.raised: Exception | None = None  # what the answer raised last

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call the answer on copies of the arguments."""
        got = self.ask(self.answer, args, kwargs)
        return Part(self, got) if self.methods else got

    def ask(self, f: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
        """``f(*args, **kwargs)`` on copies; a change of these is remembered."""
        self.calls += 1
        given, named = copied(args), copied(kwargs)
        try:
            return f(*map(_opened, given), **{k: _opened(v) for k, v in named.items()})
        except Exception as error:
            self.raised = error
            self.unfinished |= isinstance(error, NotImplementedError)
            raise
        finally:
            if not same(given, args) or not same(named, kwargs):
                self.changed = True


class Part:
    """An object of a class that is watched: the methods that were asked for, and nothing else of it."""

    def __init__(self, watched: Watched, made: Any) -> None:
        self._watched, self._made = watched, made
        self._counts = dict.fromkeys(watched.methods, 0)
        for name, method in watched.methods.items():
            setattr(self, name, partial(self._call, method))

    def _call(self, method: Method, *args: Any, **kwargs: Any) -> Any:
        memories, rest = self._once(method, args, kwargs)
        self._counts[method.name] += 1
        count = self._counts[method.name]
        if not method.whole and count & (count - 1) == 0:  # the 1st, 2nd, 4th, 8th … call
            self._ask_again(method, args, kwargs, rest)
        return method.together([Held(x) for x in memories], rest)

    def _once(
        self, method: Method, args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> tuple[list[Any], Any]:
        got = self._watched.ask(getattr(self._made, method.name), args, kwargs)
        apart = method.apart(got)
        if apart is None:
            raise WrongForm(method.asked, method.asked)
        return apart[0], copied(apart[1])  # what it gave may be its memory, too

    def _ask_again(
        self, method: Method, args: tuple[Any, ...], kwargs: dict[str, Any], rest: Any
    ) -> None:
        """The same memory and inputs must give the same again: else the call has changed them, or hides state."""
        try:
            is_same = same(self._once(method, args, kwargs)[1], rest)
        except Exception:
            is_same = False
        if not is_same:
            self._watched.changed = True


def copied(x: Any) -> Any:
    """`x` with new arrays in it, through tuples, lists and dicts."""
    if isinstance(x, np.ndarray):
        return x.copy()
    if isinstance(x, tuple):
        return type(x)(*map(copied, x)) if hasattr(x, "_fields") else tuple(map(copied, x))
    if isinstance(x, dict):
        return {k: copied(v) for k, v in x.items()}
    return list(map(copied, x)) if isinstance(x, list) else x


def same(a: Any, b: Any) -> bool:
    """Whether plain data are the same to the last bit; what is held is not looked into."""
    if a is b or isinstance(a, Held) or isinstance(b, Held):
        return a is b
    if _same_bytes(a, b):  # nearly always, and soon seen
        return True
    if isinstance(a, tuple | list) and isinstance(b, tuple | list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    try:
        first, second = np.asarray(a), np.asarray(b)
        both = first.dtype.kind in "fc" and second.dtype.kind in "fc"
        return np.array_equal(first, second, equal_nan=both)
    except Exception:
        return False


def _same_bytes(a: Any, b: Any) -> bool:
    if not (type(a) is type(b) is np.ndarray) or a.dtype.kind == "O":
        return False
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def _opened(x: Any) -> Any:
    return x.memory if isinstance(x, Held) else x
