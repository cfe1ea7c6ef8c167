"""A built course to grade in, and what to do where student code cannot be isolated."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from grader import sandbox
from grader.build import build, find_labs

STEM, LAB = "heading", "02_heading"


@pytest.fixture(scope="session")
def isolation() -> None:
    """Skip where the sandbox is missing; in CI that is a failure."""
    missing = sandbox.available()
    if missing and os.environ.get("CI"):
        pytest.fail(missing)
    if missing:
        pytest.skip(missing)


@pytest.fixture(scope="session")
def release_course(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A course with lab 02 released. Not to be changed: copy it."""
    course = tmp_path_factory.mktemp("release") / "course"
    build(course, find_labs([STEM]), seed=20_261_101)
    return course


@pytest.fixture(scope="session")
def release(release_course: Path) -> dict:
    """The notebook of lab 02 that students get."""
    return json.loads((release_course / "release" / LAB / f"{STEM}.ipynb").read_text())


@pytest.fixture(scope="session")
def right(release_course: Path) -> dict[str, str]:
    """The right answers of lab 02, by exercise."""
    from grader.classroom import reference_answers

    return reference_answers(release_course, LAB, STEM)
