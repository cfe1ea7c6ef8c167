"""One definition of each exercise: the stub, its points, its reading and its public checks.

The stub's signature and docstring become the answer cell of the lab; the checks are what the student runs, what the
grader runs again with other numbers, and what the tests run against reference, stub, mutants and variants.

A stub may be a class. Then a check gets the class, makes an object of it and calls its methods; ``Memory`` that these
take and give is the student's own, to be held and handed back but not looked into (`uavlab.exercises.classes`).
"""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType
from typing import Any

import numpy as np

from uavlab.errors import CheckFailed, UnknownName
from uavlab.exercises.classes import Method, class_source, methods_of
from uavlab.types import Array

STEMS = (
    "dynamics",
    "heading",
    "kalman_bank",
    "complementary",
    "identification",
    "mpc",
    "geometric",
)  # the labs that exist, in order; their numbers are the positions

Function = Callable[..., Any]  # what a student writes: a function, or a class
CheckFunction = Callable[[Function, np.random.Generator], None]


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

    stub: Function
    points: float
    reads: str  # paper and equation
    checks: list[Check] = field(default_factory=list)

    @property
    def name(self) -> str:
        """The name that the student's function has."""
        return self.stub.__name__

    @property
    def stem(self) -> str:
        """The lab it belongs to; the classes of a long one stand in a file of their own, ``<stem>_parts``."""
        return self.stub.__module__.rsplit(".", 1)[-1].removesuffix("_parts")

    @property
    def is_class(self) -> bool:
        """Whether a class is asked for, not a function."""
        return isinstance(self.stub, type)

    @cached_property
    def methods(self) -> dict[str, Method]:
        """The public methods of the class that is asked for, by name; of a function, none."""
        return methods_of(self.stub) if isinstance(self.stub, type) else {}

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
        if isinstance(self.stub, type):
            return class_source(self.stub, self.unfinished)
        lines = textwrap.dedent(inspect.getsource(self.stub)).splitlines()
        start = next(i for i, s in enumerate(lines) if s.startswith(("def ", "class ")))
        text = "\n".join(lines[start:]).rstrip()
        if text.endswith("..."):
            text = text[:-3].rstrip()
        return f'{text}\n    raise NotImplementedError("{self.unfinished}")\n'

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """A stub answers nothing."""
        raise NotImplementedError(self.unfinished)


def exercise(*, points: float, reads: str) -> Callable[[Function], Exercise]:
    """Declare an exercise: put this above a stub with a full signature and docstring and the body ``...``.

    Of a class, every method that is asked for has these.
    """

    def declare(stub: Function) -> Exercise:
        made = Exercise(stub, points, reads)
        if made.is_class and not made.methods:
            raise TypeError(f"{made.name} asks for a class without a public method")
        return made

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


class WrongForm(CheckFailed):
    """An answer that is not numbers of the shape asked for; `asked` says what is, and nothing of the inputs."""

    def __init__(self, message: str, asked: str) -> None:
        self.asked = asked
        super().__init__(message)


def numbers(got: Any, shape: tuple[int, ...]) -> Array:
    """`got` as a plain float64 copy, or fail the check: numbers of this shape, all finite, are asked for.

    What `got` says of itself does not count: subclasses and objects that compare as they like are
    copied to a plain array, or refused.
    """
    asked = f"Numbers of shape {shape} are asked for." if shape else "One number is asked for."
    try:
        raw = np.array(got, copy=True, subok=False)
    except Exception:  # ragged lists, and objects that refuse to be an array
        raw = np.array(None)
    if raw.dtype.kind not in "fiu":
        raise WrongForm(f"{asked} This is a {type(got).__name__}.", asked)
    if raw.shape != shape:
        raise WrongForm(f"{asked} This one has shape {raw.shape}.", asked)
    plain = raw.astype(float)
    if not np.isfinite(plain).all():
        asked = f"{asked} Every number must be finite."
        raise WrongForm(f"{asked} This is {plain}.", asked)
    return plain


def expect_close(
    got: Any, want: Any, message: str = "", *, atol: float = 1e-9, rtol: float = 1e-9
) -> None:
    """Fail the check unless `got` has the shape of `want`, is finite, and agrees with it."""
    wish = np.array(want, dtype=float)
    have = numbers(got, wish.shape)
    worst = float(np.max(np.abs(have - wish) - rtol * np.abs(wish), initial=0.0))
    if not worst <= atol:
        raise CheckFailed(message or f"Expected {wish}, got {have} (off by {worst:.3g}).")
