"""Say what is installed, compiled, isolated and missing, and what cures it.

Exit code 1 means that something is missing without which no lab runs.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from importlib import metadata, util
from typing import NamedTuple

NAME = "doctor"

_FLIES = (
    "numpy",
    "scipy",
    "numba",
    "matplotlib",
    "meshcat",
    "pooch",
    "pyulog",
    "tqdm",
    "osqp",
    "daqp",
    "shapely",
)
_TEACHES = {  # package → what for, what installs it
    "jupyterlab": ("opening the labs", "pip install 'uavlab[lab]'"),
    "ipywidgets": ("widgets in the labs", "pip install 'uavlab[lab]'"),
    "nbgrader": ("grading a class", "make setup in a checkout"),
    "jupytext": ("building the notebooks", "make setup in a checkout"),
    "playwright": ("tests in a browser", "make setup in a checkout"),
    "sphinx": ("building the book", "make setup in a checkout"),
}


class Finding(NamedTuple):
    """One line of the report."""

    what: str
    state: str  # ok, missing (something does not work) or without (an option is not there)
    said: str
    cure: str = ""


def add(parser: argparse.ArgumentParser) -> None:
    """The arguments: none."""


def run(args: argparse.Namespace) -> int:
    """Print the findings."""
    from uavlab.commands.list_ import print_rows

    rows: list[tuple[str, ...]] = []
    missing = 0
    for title, look in SECTIONS.items():
        found = list(look())
        missing += sum(f.state == "missing" for f in found)
        rows = [(f.state, f.what, f.said + (f"  Cure: {f.cure}" if f.cure else "")) for f in found]
        print(title)
        print_rows(rows)
    print(
        "\nAll that the labs need is there." if not missing else f"\n{missing} things are missing."
    )
    return 1 if missing else 0


def _installed() -> Iterator[Finding]:
    import uavlab

    version = ".".join(map(str, sys.version_info[:3]))
    yield Finding("uavlab", "ok", f"{uavlab.__version__}, {os.path.dirname(uavlab.__file__)}")
    yield Finding("Python", "ok", version)
    for name in _FLIES:
        yield _package(name, "missing", "not installed.", "pip install uavlab")
    for name, (use, cure) in _TEACHES.items():
        yield _package(name, "without", f"not installed; needed for {use}.", cure)


def _package(name: str, state: str, said: str, cure: str) -> Finding:
    try:
        return Finding(name, "ok", metadata.version(name))
    except metadata.PackageNotFoundError:
        return Finding(name, state, said, cure)


def _answers() -> Iterator[Finding]:
    if util.find_spec("uavlab.solutions") is None:
        yield Finding("references", "without", "the students' uavlab: stand-ins fly")
    else:
        yield Finding("references", "ok", "uavlab.solutions is installed")


def _compiled() -> Iterator[Finding]:
    from uavlab import scenarios
    from uavlab.flight.fly import fly

    if util.find_spec("numba") is None:
        yield Finding(
            "plant", "without", "plain Python, a hundred times slower.", "pip install numba"
        )
        return
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0":
        yield Finding(
            "plant", "without", "the compiler is switched off.", "unset NUMBA_DISABLE_JIT"
        )
        return
    calm = scenarios.load("hover")._replace(duration=0.1)
    start = time.perf_counter()
    fly(calm)
    first = time.perf_counter() - start
    long = calm._replace(duration=10.0)
    start = time.perf_counter()
    fly(long)
    speed = long.duration / (time.perf_counter() - start)
    how = "taken from the cache" if first < 3.0 else "compiled now; the next start is quick"
    yield Finding(
        "plant", "ok", f"{how}: first flight after {first:.1f} s, then {speed:.0f}× real time"
    )


def _isolated() -> Iterator[Finding]:
    path = shutil.which("bwrap")
    if path is None:
        said = "not installed; a class cannot be graded."
        yield Finding("bubblewrap", "without", said, "apt install bubblewrap")
        return
    version = _said(path, "--version") or "?"
    box = (path, "--ro-bind", "/", "/", "--unshare-all", "--", "/bin/sh", "-c", "echo in")
    if _said(*box) == "in":
        yield Finding("bubblewrap", "ok", f"{version}, and it may make a box")
        return
    said = f"{version}, but it may not make a box here."
    yield Finding("bubblewrap", "without", said, "allow user namespaces, or run as root")


def _browser() -> Iterator[Finding]:
    for name in ("chromium", "chromium-browser", "google-chrome"):
        if shutil.which(name):
            yield Finding("browser", "ok", _said(name, "--version") or name)
            return
    yield Finding(
        "browser", "without", "no chromium: tests of pages are skipped.", "apt install chromium"
    )


def _data() -> Iterator[Finding]:
    from uavlab.datasets import about, fetch, names
    from uavlab.datasets.store import FOLDER, cache
    from uavlab.errors import BadFile

    folder = os.environ.get(FOLDER)
    if not folder:
        there = sum((cache() / about(name).path).is_file() for name in names())
        said = (
            f"{there} of {len(names())} files in {cache()}; the others are fetched when asked for"
        )
        yield Finding("data", "ok", said)
        return
    bad = []
    for name in names():
        try:
            fetch(name)
        except BadFile as error:
            bad.append(str(error))
    if bad:
        said = f"{FOLDER}={folder}: {len(bad)} of {len(names())} files missing or changed. {bad[0]}"
        yield Finding("data", "without", said)
    else:
        yield Finding("data", "ok", f"{FOLDER}={folder}: all {len(names())} files, hashes right")


def _said(*words: str) -> str:
    """The first line that a program prints; nothing if it fails."""
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.strip().splitlines()[0] if done.stdout.strip() else ""


SECTIONS: dict[str, Callable[[], Iterator[Finding]]] = {
    "installed": _installed,
    "answers": _answers,
    "compiled": _compiled,
    "isolated": _isolated,
    "browser": _browser,
    "data": _data,
}
