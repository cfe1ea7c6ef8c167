"""The one definition of every exercise; what the labs, the grader, the book and the tests read."""

from uavlab.exercises.check import check, failure
from uavlab.exercises.spec import (
    STEMS,
    Check,
    Exercise,
    WrongForm,
    all_exercises,
    exercise,
    exercises,
    expect,
    expect_close,
    find,
    numbers,
)

__all__ = [
    "STEMS",
    "Check",
    "Exercise",
    "WrongForm",
    "all_exercises",
    "check",
    "exercise",
    "exercises",
    "expect",
    "expect_close",
    "failure",
    "find",
    "numbers",
]
