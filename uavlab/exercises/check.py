"""`check`: what a student calls below an answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from uavlab.errors import CheckFailed
from uavlab.exercises.spec import Check, Exercise, find


def failure(check: Check, answer: Callable[..., Any], rng: np.random.Generator) -> str | None:
    """Why `answer` does not pass `check`, or None if it does. Raises NotImplementedError for a stub."""
    try:
        check.run(answer, rng)
    except NotImplementedError:
        raise
    except CheckFailed as wrong:
        detail = str(wrong)
        return (
            f"{check.sentence} {detail}" if detail and detail != check.sentence else check.sentence
        )
    except Exception as error:  # the student's own error: shown as it is
        return f"{check.sentence} (Your code raised {type(error).__name__}: {error})"
    return None


def check(answer: Callable[..., Any], *, seed: int = 0) -> None:
    """Run the public checks of an exercise on `answer` and say what was found.

    Parameters
    ----------
    answer : callable
        Your function or class; its name says which exercise it answers.
    seed : int
        Other random inputs, if you like. The grader uses its own.

    Raises
    ------
    NotImplementedError
        The answer is still the stub.
    CheckFailed
        At least one check did not pass.
    """
    spec = (
        answer if isinstance(answer, Exercise) else find(getattr(answer, "__name__", str(answer)))
    )
    wrong = 0
    for item in spec.checks:
        why = failure(item, answer, np.random.default_rng(seed))
        print(
            f"  {'✓' if why is None else '✗'} {item.name.replace('_', ' ')}"
            + (f": {why}" if why else "")
        )
        wrong += why is not None
    if wrong:
        raise CheckFailed(
            f"{spec.name}: {wrong} of {len(spec.checks)} public checks did not pass; see above."
        )
    print(
        f"{spec.name}: all {len(spec.checks)} public checks pass. ({spec.points:g} points; reads {spec.reads})"
    )
