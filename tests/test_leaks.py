"""What students get holds no answer: not a function that would pass as one, and not a line of one."""

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from answers import reference
from shipped_functions import passes

from grader.canaries import ROOT, canaries
from grader.leaks import find_leaks, secret_lines
from uavlab.exercises import STEMS, all_exercises


@pytest.fixture(scope="module")
def tried(tmp_path_factory):
    """Exercise → shipped function or class → whether it passes.

    In a process of its own with the compiler off: compiled code does not look where it reads when the shapes are wrong.
    """
    command = [sys.executable, str(Path(__file__).with_name("shipped_functions.py"))]
    at_work = [
        subprocess.Popen(
            [*command, *some],
            # Whatever a function does when it is called like this.
            cwd=tmp_path_factory.mktemp("anywhere"),
            env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for some in (STEMS[0::2], STEMS[1::2])
    ]
    table = {}
    for process in at_work:
        out, err = process.communicate()
        assert process.returncode == 0, err
        table |= json.loads(out.splitlines()[-1])
    return table


def test_the_search_sees_functions_methods_and_what_is_compiled(tried):
    called = {name for of in tried.values() for name in of}
    assert len(called) > 50
    for name in (
        "so3.angle",
        "plant.vectors.apply",
        "parts.paths.circle",
        "frames.moved",
    ):
        assert f"uavlab.{name}" in called
    assert not any(name.startswith("uavlab.solutions") for name in called)


@pytest.mark.parametrize("exercise", list(all_exercises()), ids=lambda x: x.name)
def test_no_shipped_function_passes_as_an_answer_to(exercise, tried):
    passed = tried[exercise.name]
    assert passed, "nothing was tried"
    assert [name for name, is_answer in passed.items() if is_answer] == []


@pytest.mark.parametrize("exercise", list(all_exercises()), ids=lambda x: x.name)
def test_the_search_for_functions_would_find_an_answer_to(exercise):
    assert passes(exercise, reference(exercise))


# Text -------------------------------------------------------------------------------------------------


def zipped(path, files):
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


@pytest.mark.parametrize(
    "room", ["uavlab/solutions", "grader/hidden", "grader/mutants", "grader/variants"]
)
def test_the_search_for_text_finds_each_kind_of_secret(room, tmp_path):
    secret = next(p for p in canaries().values() if p.is_relative_to(ROOT / room))
    text = secret.read_text("utf-8")
    lines = [s for s in secret_lines() if s in text]
    assert len(lines) > 10
    whole = zipped(tmp_path / "whole.whl", {"uavlab/notes.py": text})
    inside = zipped(tmp_path / "archive.zip", {"uavlab.whl": whole.read_bytes()})
    for file in (whole, inside):
        assert any("canary-" in s for s in find_leaks([file]))
    # One line is enough, also in a notebook, where quotes and backslashes are escaped.
    cell = {"cell_type": "code", "source": ["x = 1\n", f"    {lines[-1]}\n"]}
    book = zipped(tmp_path / "book.zip", {"lab.ipynb": json.dumps({"cells": [cell]})})
    assert find_leaks([book]) == [
        f"book.zip/lab.ipynb has a line of {secret_lines()[lines[-1]]}: {lines[-1]}"
    ]


def test_a_clean_archive_has_no_leaks(tmp_path):
    text = (ROOT / "uavlab" / "so3.py").read_text("utf-8")
    assert find_leaks([zipped(tmp_path / "a.whl", {"uavlab/so3.py": text})]) == []
