"""Submissions that try to cheat, or to break the grader: one module for each class of `CLASSES`.

They are run in one class beside honest students (tests/grader/test_attacks.py): none may gain a point, touch or
read a file outside its box, cost anybody else anything, or leave a process behind.
"""

from __future__ import annotations

import copy
import importlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

CLASSES = (
    "reading", "patching", "ipython", "frames", "exhausting", "outside", "forging", "damaging", "files", "copying",
    "browser",
)  # fmt: skip
REPLACING = ("reading", "frames", "forging", "copying")  # classes that replace an answer by another
LIE = "def {name}(*arguments, **more):\n    return {value}\n"

_found: list[Attack] = []


class Target(NamedTuple):
    """What an attacker knows: the lab that was handed out, right answers to some of it, and where things lie."""

    release: dict[str, Any]  # notebook
    right: dict[str, str]  # exercise → right answer
    course: Path
    folder: Path  # submitted/<me>/<assignment>
    stem: str  # of the lab

    @property
    def file(self) -> Path:
        """Where the submission belongs."""
        return self.folder / f"{self.stem}.ipynb"


Maker = Callable[
    [Target], bytes | None
]  # the file, or None when it has written to target.folder itself


class Attack(NamedTuple):
    """One hostile or broken submission."""

    name: str
    kind: str
    story: str  # what it tries
    make: Maker
    deserves: (
        bool  # True: the right answers are in it, and must count; False: nothing in it is right
    )


def attack(kind: str, *, deserves: bool = False) -> Callable[[Maker], Maker]:
    """Enter a function that makes a submission; its docstring says what it tries."""

    def enter(make: Maker) -> Maker:
        story = " ".join((make.__doc__ or "").split())
        _found.append(Attack(make.__name__, kind, story, make, deserves))
        return make

    return enter


def code(kind: str, name: str, story: str, source: str) -> None:
    """Enter an attack that is one piece of code, run where it can do most: first of all, or over a lie."""

    def make(target: Target) -> bytes:
        after = next(iter(target.right)) if kind in REPLACING else ""
        return submit(target, extra=source, after=after)

    _found.append(Attack(name, kind, " ".join(story.split()), make, False))


def answer(kind: str, name: str, story: str, source: str) -> None:
    """Enter an attack that is the answer to the first exercise; ``{name}`` is its name."""

    def make(target: Target) -> bytes:
        exercise = next(iter(target.right))
        return submit(target, answers={exercise: source.replace("{name}", exercise)})

    _found.append(Attack(name, kind, " ".join(story.split()), make, False))


def lies(target: Target, value: str = "0.0") -> dict[str, str]:
    """An answer to every exercise that always says the same."""
    return {name: LIE.format(name=name, value=value) for name in target.right}


def filled(target: Target, answers: dict[str, str]) -> dict[str, Any]:
    """The released notebook with these answers."""
    notebook = copy.deepcopy(target.release)
    for cell in notebook["cells"]:
        name = cell["id"].removeprefix("answer-")
        if cell["id"].startswith("answer-") and name in answers:
            cell["source"] = answers[name]
    return notebook


def submit(
    target: Target, answers: dict[str, str] | None = None, extra: str = "", after: str = ""
) -> bytes:
    """A file with these answers (else lies), and a cell of one's own before everything or after an answer."""
    notebook = filled(target, lies(target) if answers is None else answers)
    ids = [c["id"] for c in notebook["cells"]]
    if extra:
        notebook["cells"].insert(ids.index(f"answer-{after}") + 1 if after else 0, own(extra))
    return json.dumps(notebook).encode()


def own(source: str, kind: str = "code", **more: Any) -> dict[str, Any]:
    """A cell that is not in the release."""
    cell: dict[str, Any] = {
        "cell_type": kind,
        "id": "mine",
        "metadata": {},
        "source": source,
        **more,
    }
    return cell | ({"outputs": [], "execution_count": None} if kind == "code" else {})


def attacks() -> list[Attack]:
    """All of them, by class."""
    for name in CLASSES:
        importlib.import_module(f"grader.attacks.{name}")
    return sorted(_found, key=lambda x: CLASSES.index(x.kind))
