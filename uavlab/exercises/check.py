"""`check`: what a student calls below an answer."""

from __future__ import annotations

import sys
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
        try:
            why = failure(item, answer, np.random.default_rng(seed))
        except NotImplementedError as unfinished:
            raise _brief(NotImplementedError(str(unfinished))) from None
        title = item.name.replace("_", " ")
        _say(f"  ✓ {title}" if why is None else f"  ✗ {title}: {why}", good=why is None)
        wrong += why is not None
    if wrong:
        raise _brief(
            CheckFailed(
                f"{spec.name}: {wrong} of {len(spec.checks)} public checks did not pass; see above."
            )
        )
    passed = f"{spec.name}: all {len(spec.checks)} public checks pass."
    _say(f"{passed} ({spec.points:g} points; reads {spec.reads})", good=True)


def _say(line: str, *, good: bool) -> None:
    """Print in green or red where colours are shown: in a notebook and on a terminal."""
    shown = sys.stdout.isatty() or type(sys.stdout).__module__.startswith("ipykernel")
    print(f"\x1b[{32 if good else 31}m{line}\x1b[0m" if shown else line)


def _brief(error: Exception) -> Exception:
    """The same error, of which a notebook shows the message and not the way through this file."""
    said = f"\x1b[31m{type(error).__name__}\x1b[0m: {error}"
    vars(error)["_render_traceback_"] = lambda: [said]  # IPython asks the error for this
    return error
