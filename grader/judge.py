"""The judge: one answer to one exercise → a verdict. Trusted, pure, and the only place where points are made.

The answer is any callable; in the grader it is a proxy that calls the student's function in the sandbox. Nothing that
the answer says gets into the verdict but one class name: feedback is made of our own sentences.
"""

from __future__ import annotations

import warnings
import zlib
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from grader.material import Inputs, Mutant, call, hidden_checks, mutants, samples
from grader.watched import Watched, copied
from uavlab.errors import CheckFailed
from uavlab.exercises.spec import Check, Exercise, Function, WrongForm, numbers

PURITY = "inputs_are_left_alone"
PURITY_WEIGHT = 0.5
PURITY_SENTENCE = (
    "The arrays that a function is given belong to its caller: work on a copy, do not change them."
)

MEMORY_SENTENCE = (
    "The same memory and the same inputs must give the same output again: work on copies, change neither "
    "the memory nor the arrays that a method is given, and keep nothing elsewhere."
)


class Result(NamedTuple):
    """What one check said."""

    name: str
    passed: bool
    sentence: str  # the law, and how it was broken; free of the inputs
    weight: float  # share of the points; 0 for an example
    public: bool  # the student has it too


class Verdict(NamedTuple):
    """What an answer is worth, and why."""

    exercise: str
    score: float  # 0 to points, to the hundredth
    points: float
    results: tuple[Result, ...]
    hint: str  # what to tell the student; empty when all is well
    finished: bool  # False for a stub


def judge(exercise: Exercise, answer: Function, seed: int) -> Verdict:
    """Run every check of an exercise on an answer.

    Parameters
    ----------
    exercise : Exercise
        What was asked.
    answer : callable
        What was answered: a function, or a class. A proxy must do to its arguments what the call in the sandbox
        did to them.
    seed : int
        From zero up. The same seed gives the same inputs, check by check.

    Returns
    -------
    Verdict
        With partial credit for each check that passed, by weight.
    """
    watched = Watched(answer, exercise.methods)
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # a warning is not a mistake
        results = [
            run(x, watched, _rng(seed, exercise, x.name), public=True) for x in exercise.checks
        ]
        hidden = hidden_checks(exercise)
        results += [run(x, watched, _rng(seed, exercise, x.name), public=False) for x in hidden]
        results.append(_purity(watched, results))
        score = _score(exercise.points, results)
        finished = score > 0.0 or not watched.unfinished
        hint = "" if all(x.passed for x in results) else exercise.unfinished
        if hint and finished:
            hint = recognise(exercise, watched, seed) or next(
                x.sentence for x in results if not x.passed
            )
    return Verdict(exercise.name, score, exercise.points, tuple(results), hint, finished)


def run(check: Check, answer: Function, rng: np.random.Generator, *, public: bool) -> Result:
    """One check, whatever the answer does."""
    try:
        check.run(answer, rng)
    except WrongForm as wrong:
        why = f" {wrong.asked}"
    except CheckFailed:
        why = ""
    except Exception as error:
        # Which error it was would carry hidden inputs out, a letter at a time.
        why = f" (Your code raised {_name(error) if public else 'an error'}.)"
        if error is not getattr(answer, "raised", error):  # the check could not read what came back
            why = " (What it returns has not the form that the docstring asks for: the types of its fields.)"
    else:
        return Result(check.name, True, check.sentence, check.weight, public)
    return Result(check.name, False, check.sentence + why, check.weight, public)


Outcome = list[np.ndarray] | None  # None: it raised, or gave something else than finite numbers


def recognise(exercise: Exercise, answer: Function, seed: int) -> str:
    """The hint of the known wrong answer that `answer` agrees with on fresh random inputs, or nothing."""
    inputs = samples(exercise, _rng(seed, exercise, "hint"))
    said = [outcome(answer, x) for x in inputs]
    for known in mutants(exercise):
        kept = _kept(known, seed)
        if all(
            agree(a, _said(known, kept, i, x))
            for i, (a, x) in enumerate(zip(said, inputs, strict=True))
        ):
            return known.hint
    return ""


@lru_cache(maxsize=2048)
def _kept(known: Mutant, seed: int) -> dict[int, Outcome]:
    """What a known wrong answer said to the inputs of a seed, by their place: a class of students shares the seed."""
    return {}


def _said(known: Mutant, kept: dict[int, Outcome], place: int, inputs: Inputs) -> Outcome:
    if place not in kept:
        kept[place] = outcome(known.run, inputs)
    return kept[place]


def outcome(f: Function, inputs: Inputs) -> Outcome:
    """What an answer gives for some inputs, as plain arrays."""
    try:
        return list(_arrays(call(f, copied(inputs))))
    except Exception:
        return None


def _arrays(got: Any) -> Iterator[np.ndarray]:
    """What was got, field by field; texts and truth values as numbers."""
    if isinstance(got, str):
        yield np.array([float(ord(c)) for c in got])
    elif got is None or isinstance(got, bool):
        yield np.array([] if got is None else float(got))
    elif isinstance(got, dict):
        for key in sorted(got):
            yield from _arrays(key)
            yield from _arrays(got[key])
    elif isinstance(got, tuple) or (isinstance(got, list) and not _is_array(got)):
        for x in got:
            yield from _arrays(x)
    else:
        yield numbers(got, np.shape(got))


def _is_array(got: list[Any]) -> bool:
    try:
        return np.asarray(got).dtype.kind in "fiu"
    except ValueError:  # ragged
        return False


def agree(a: Outcome, b: Outcome) -> bool:
    """Whether two outcomes are the same to seven digits."""
    if a is None or b is None:
        return a is b
    return len(a) == len(b) and all(
        x.shape == y.shape and np.allclose(x, y, rtol=1e-7, atol=1e-9)
        for x, y in zip(a, b, strict=True)
    )


def _rng(seed: int, exercise: Exercise, name: str) -> np.random.Generator:
    """A generator of its own for each check: a new check does not change the inputs of the others."""
    return np.random.default_rng((seed, zlib.crc32(f"{exercise.name}/{name}".encode())))


def _score(points: float, results: list[Result]) -> float:
    """Share of the points, by weight."""
    won = sum(x.weight for x in results if x.passed)
    return round(points * won / sum(x.weight for x in results), 2)


def _purity(answer: Watched, results: list[Result]) -> Result:
    """Leaving the inputs alone counts for an answer that does something right."""
    earned = any(x.passed and x.weight for x in results)
    law = MEMORY_SENTENCE if answer.methods else PURITY_SENTENCE
    said = law if earned or answer.changed else "This counts once another check passes."
    return Result(PURITY, earned and not answer.changed, said, PURITY_WEIGHT, False)


def _name(error: Exception) -> str:
    """Class name of an exception, if it is one: a student can call a class what they like."""
    name = type(error).__name__
    return name if name.isidentifier() and len(name) < 50 else "an error"
