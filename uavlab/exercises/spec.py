"""One definition of each exercise: the stub, its points, its reading and its public checks.

The stub's signature and docstring become the answer cell of the lab; the checks are what the student runs, what the
grader runs again with other numbers, and what the tests run against reference, stub, mutants and variants.
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import numpy as np

from uavlab.errors import CheckFailed, UnknownName

STEMS = ("dynamics", "heading")  # the labs that exist, in order; their numbers are the positions

CheckFunction = Callable[[Callable[..., Any], np.random.Generator], None]


@dataclass(frozen=True)
class Check:
    """One law that an answer must obey. Its docstring is the sentence that a wrong answer earns."""

    name: str
    run: CheckFunction
    weight: float = (
        1.0  # share of the exercise's points; 0 for a fixed example that could be copied
    )

    @property
    def sentence(self) -> str:
        """The feedback: the first paragraph of the check's docstring, in one line."""
        return " ".join(inspect.getdoc(self.run).split("\n\n")[0].split())  # type: ignore[union-attr]


@dataclass(frozen=True)
class Exercise:
    """A function (or a class) that a student writes."""

    stub: Callable[..., Any]
    points: float
    reads: str  # paper and equation
    checks: list[Check] = field(default_factory=list)

    @property
    def name(self) -> str:
        """The name that the student's function has."""
        return self.stub.__name__

    @property
    def stem(self) -> str:
        """The lab it belongs to."""
        return self.stub.__module__.rsplit(".", 1)[-1]

    @property
    def unfinished(self) -> str:
        """The one message of a stub that nobody has filled in."""
        return f"{self.name} is not finished yet: write it in its answer cell ({self.reads})."

    def check(self, run: CheckFunction | None = None, *, weight: float = 1.0) -> Any:
        """Add a public check: ``@exercise.check`` or ``@exercise.check(weight=0)``."""

        def add(run: CheckFunction) -> CheckFunction:
            if not inspect.getdoc(run):
                raise TypeError(
                    f"check {run.__name__} of {self.name} needs a docstring: its feedback"
                )
            self.checks.append(Check(run.__name__, run, weight))
            return run

        return add if run is None else add(run)

    def source(self) -> str:
        """The stub as the student sees it: signature, docstring, and its one message."""
        lines = textwrap.dedent(inspect.getsource(self.stub)).splitlines()
        start = next(i for i, s in enumerate(lines) if s.startswith(("def ", "class ")))
        text = "\n".join(lines[start:]).rstrip()
        if text.endswith("..."):
            text = text[:-3].rstrip()
        return f'{text}\n    raise NotImplementedError("{self.unfinished}")\n'

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """A stub answers nothing."""
        raise NotImplementedError(self.unfinished)


def exercise(*, points: float, reads: str) -> Callable[[Callable[..., Any]], Exercise]:
    """Declare an exercise: put this above a stub with a full signature and docstring and the body ``...``."""

    def declare(stub: Callable[..., Any]) -> Exercise:
        return Exercise(stub, points, reads)

    return declare


def lab(stem: str) -> ModuleType:
    """The module that defines the exercises of one lab.

    Raises
    ------
    UnknownName
        There is no such lab.
    """
    import importlib

    if stem not in STEMS:
        raise UnknownName("lab", stem, STEMS)
    return importlib.import_module(f"uavlab.exercises.{stem}")


def exercises(stem: str) -> list[Exercise]:
    """The exercises of one lab, in the order in which they are written down."""
    return [x for x in vars(lab(stem)).values() if isinstance(x, Exercise) and x.stem == stem]


def all_exercises() -> Iterator[Exercise]:
    """Every exercise of every lab, in order."""
    for stem in STEMS:
        yield from exercises(stem)


def find(name: str) -> Exercise:
    """The exercise with this name.

    Raises
    ------
    UnknownName
        There is no such exercise.
    """
    known = {x.name: x for x in all_exercises()}
    if name not in known:
        raise UnknownName("exercise", name, known)
    return known[name]


# What checks are written with -------------------------------------------------------------------------


def expect(condition: object, message: str) -> None:
    """Fail the check with `message` unless `condition` holds."""
    if not condition:
        raise CheckFailed(message)


def expect_close(
    got: Any, want: Any, message: str = "", *, atol: float = 1e-9, rtol: float = 1e-9
) -> None:
    """Fail the check unless `got` has the shape of `want`, is finite, and agrees with it.

    Compared on plain float64 copies: what `got` says of itself does not count.
    """
    said = f"{message} " if message else ""
    try:
        have = np.array(got, dtype=float, copy=True, subok=False)
    except (TypeError, ValueError):
        raise CheckFailed(f"{said}The answer is a {type(got).__name__}, not numbers.") from None
    wish = np.array(want, dtype=float, copy=True, subok=False)
    if have.shape != wish.shape:
        raise CheckFailed(f"{said}The answer has shape {have.shape}; {wish.shape} is asked for.")
    if not np.isfinite(have).all():
        raise CheckFailed(f"{said}The answer is not finite: {have}.")
    worst = float(np.max(np.abs(have - wish) - rtol * np.abs(wish), initial=0.0))
    if not worst <= atol:
        raise CheckFailed(message or f"Expected {wish}, got {have} (off by {worst:.3g}).")
