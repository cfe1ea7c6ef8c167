"""A small lab to build: its text asks for all of lab 02 and nothing else."""

from pathlib import Path

from grader.build import ROOT
from grader.build_lab import Lab, read_lab
from uavlab.exercises import exercises

FRONT = "---\nkernelspec:\n  display_name: Python 3\n  name: python3\n---\n"
IMPORTS = """\
import numpy as np
import uavlab
from uavlab import frames
from uavlab.errors import BadInput
from uavlab.so3 import about_z, hat
from uavlab.types import Mat3, Vec3
"""
QUESTION = """\
+++ {"question": "why-not-yaw", "points": 2}

Why is a heading no yaw?

+++ {"rubric": "why-not-yaw"}

It needs no sequence of angles, says the teacher.

+++

The end.
"""


def code(source: str, tags: str = "") -> str:
    """A code cell as an author writes it."""
    return (
        f"```{{code-cell}} ipython3\n{f':tags: [{tags}]' if tags else ''}\n{source.strip()}\n```\n"
    )


def text(*, imports: str = IMPORTS, extra: str = "", leave_out: str = "") -> str:
    """A whole lab, or one with a mistake in it."""
    asked = "\n".join(
        code(f"%exercise {x.name}") for x in exercises("heading") if x.name != leave_out
    )
    drawing = code("print(heading_rate(np.eye(3), np.ones(3)))", "viz, hide-input")
    return "\n".join([FRONT, "# Lab 02", code(imports), asked, drawing, extra, QUESTION])


def write(folder: Path, content: str | None = None, solutions: str | None = None) -> Lab:
    """Write a lab below `folder` and read it as the build does."""
    path = folder / "course" / "labs" / "02_heading" / "heading.md"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text() if content is None else content, encoding="utf-8")
    answers = ROOT / "uavlab" / "solutions" / "heading.py"
    if solutions is not None:
        answers = folder / "heading.py"
        answers.write_text(solutions, encoding="utf-8")
    return read_lab(path, exercises("heading"), answers)
