"""What the judge judges with, lab by lab: hidden checks, known wrong answers, right answers, and random inputs.

The four decorators mark the functions of ``grader/hidden``, ``grader/mutants`` and ``grader/variants``; the four
look-ups find them again by the exercise that they were written for. None of this is ever shipped.

The inputs of a function are the arguments of a call. Those of a class are a play: a function of the class that makes
an object, calls its methods, and returns what they gave, without the memory::

    def play(make):
        filter = make(bandwidth=2.0)
        memory = filter.init(0.0)
        memory, first = filter.step(memory, 1.0, 0.01)
        return first, filter.step(memory, 1.0, 0.01)[1]

Mutants and variants of a class are classes that are made in the same way.
"""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np

from uavlab.exercises.spec import Check, CheckFunction, Exercise, Function

Arguments = tuple[Any, ...]  # of one call of a function; a dict at the end holds the keywords
Play = Callable[
    [Function], Any
]  # of a class: makes an object, calls its methods, gives all that is plain
Inputs = Arguments | Play
Sampler = Callable[[np.random.Generator], Sequence[Inputs]]


@dataclass(frozen=True)
class Hidden:
    """A check that only the grader has. Its sentence reaches the student, its inputs do not."""

    exercise: str
    check: Check


@dataclass(frozen=True)
class Mutant:
    """A wrong answer that students are known to give, and what to tell them."""

    exercise: str
    run: Function
    hint: str


@dataclass(frozen=True)
class Variant:
    """A right answer that is written in another way than the reference."""

    exercise: str
    run: Function


@dataclass(frozen=True)
class Sample:
    """Random inputs, or plays, that tell every mutant of an exercise from every other, and from the reference."""

    exercise: str
    draw: Sampler


def hidden(exercise: Exercise, *, weight: float = 1.0) -> Callable[[CheckFunction], Hidden]:
    """Mark a hidden check: ``(answer, rng) -> None`` with a docstring, the sentence that a failure earns."""

    def mark(run: CheckFunction) -> Hidden:
        if not inspect.getdoc(run):
            raise TypeError(f"hidden check {run.__name__} needs a docstring: its feedback")
        return Hidden(exercise.name, Check(run.__name__, run, weight))

    return mark


def mutant(exercise: Exercise, *, hint: str) -> Callable[[Function], Mutant]:
    """Mark a wrong answer, with the hint that an answer like it earns."""
    return lambda run: Mutant(exercise.name, run, hint)


def variant(exercise: Exercise) -> Callable[[Function], Variant]:
    """Mark a right answer."""
    return lambda run: Variant(exercise.name, run)


def sample(exercise: Exercise) -> Callable[[Sampler], Sample]:
    """Mark the source of random inputs for an exercise."""
    return lambda draw: Sample(exercise.name, draw)


def hidden_checks(exercise: Exercise) -> list[Check]:
    """The hidden checks of an exercise, in the order in which they are written down."""
    return [x.check for x in _of(exercise, "hidden", Hidden)]


def mutants(exercise: Exercise) -> list[Mutant]:
    """The known wrong answers to an exercise."""
    return list(_of(exercise, "mutants", Mutant))


def variants(exercise: Exercise) -> list[Variant]:
    """The other right answers to an exercise."""
    return list(_of(exercise, "variants", Variant))


def samples(exercise: Exercise, rng: np.random.Generator) -> list[Inputs]:
    """Fresh random inputs of an exercise."""
    return [y for x in _of(exercise, "mutants", Sample) for y in x.draw(rng)]


def call(f: Function, inputs: Inputs) -> Any:
    """What `f` gives: ``f(*inputs)``, with a dict at the end taken as keywords; or what a play makes of it."""
    if not isinstance(inputs, tuple):
        return inputs(f)
    arguments = inputs
    if arguments and isinstance(arguments[-1], dict):
        return f(*arguments[:-1], **arguments[-1])
    return f(*arguments)


Kind = TypeVar("Kind", Hidden, Mutant, Variant, Sample)


def _of(exercise: Exercise, room: str, kind: type[Kind]) -> Iterator[Kind]:
    """Everything of one kind that a module holds for an exercise."""
    return (x for x in _contents(room, exercise.stem, kind) if x.exercise == exercise.name)


@lru_cache
def _contents(room: str, stem: str, kind: type[Kind]) -> tuple[Kind, ...]:
    """Everything of one kind that ``grader.<room>.<stem>`` holds."""
    module = importlib.import_module(f"grader.{room}.{stem}")
    return tuple(x for x in vars(module).values() if isinstance(x, kind))
