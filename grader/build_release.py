"""The nbgrader course: instructor's notebooks in source/, students' in release/, one configuration."""

from __future__ import annotations

import contextlib
import io
import logging
import secrets
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import nbformat
from nbgrader.preprocessors import ClearSolutions

from grader.tools import offer_programs
from uavlab.errors import BadFile
from uavlab.exercises import find

CONFIG = '''"""The settings of this course: written once by grader.build, and from then on yours to change."""

import importlib.util
from pathlib import Path

c = get_config()
c.CourseDirectory.course_id = "uavlab"
c.CourseDirectory.root = str(Path(__file__).resolve().parent)
load_subconfig(importlib.util.find_spec("grader.nbgrader_config").origin)

# Decides the random inputs of the checks. No other course has it: keep it to yourself, and keep it all term.
c.Judge.seed = {seed}
'''


class ClearAnswers(ClearSolutions):
    """Puts the exercise's stub in place of the answer: its docstring and its own unfinished message."""

    def preprocess_cell(
        self, cell: nbformat.NotebookNode, resources: Any, cell_index: int
    ) -> tuple[nbformat.NotebookNode, Any]:
        """Clear one cell."""
        grade_id = cell.metadata.get("nbgrader", {}).get("grade_id", "")
        if grade_id.startswith("answer-"):
            cell.source = find(grade_id.removeprefix("answer-")).source().rstrip("\n")
            return cell, resources
        return super().preprocess_cell(cell, resources, cell_index)


def write_course(course: Path, notebooks: Mapping[str, str], seed: int | None = None) -> None:
    """Put the instructor's notebooks and the configuration into the course directory.

    Parameters
    ----------
    course : Path
        Made when missing; what the instructor keeps there (settings, submissions, gradebook) stays.
    notebooks : mapping of str to str
        Path below ``source/`` → text.
    seed : int, optional
        Of the checks' random inputs, for a course that is new; a secret one if there is no number.
    """
    course.mkdir(parents=True, exist_ok=True)
    settings = course / "nbgrader_config.py"
    if not settings.exists():
        _replace(settings, CONFIG.format(seed=secrets.randbelow(2**31) if seed is None else seed))
    for name, text in notebooks.items():
        path = course / "source" / name
        # nbgrader copies whatever lies beside a notebook into the release: nothing may.
        shutil.rmtree(path.parent, ignore_errors=True)
        path.parent.mkdir(parents=True)
        _replace(path, text)


def release(course: Path, assignment: str) -> Path:
    """Have nbgrader write the students' version of one assignment.

    Parameters
    ----------
    course : Path
        A directory that `write_course` wrote.
    assignment : str
        ``<nn>_<stem>``.

    Returns
    -------
    Path
        The released folder.

    Raises
    ------
    BadFile
        nbgrader refused; the message has what it said.
    """
    api = _api(course)
    result = api.generate_assignment(assignment, force=True, create=True)
    if not result["success"]:
        said = f"{result.get('log') or ''}\n{result.get('error') or ''}".strip()
        raise BadFile(f"nbgrader could not release {assignment}:\n{said}")
    return course / "release" / assignment


def _api(course: Path) -> Any:
    """The programming interface of nbgrader, set up as its command line would be in `course`."""
    from nbgrader.apps import NbGraderAPI
    from nbgrader.coursedir import CourseDirectory
    from traitlets.config.loader import PyFileConfigLoader

    with contextlib.redirect_stderr(io.StringIO()):
        config = PyFileConfigLoader("nbgrader_config.py", path=str(course)).load_config()
    offer_programs()
    logging.getLogger("traitlets").setLevel(logging.ERROR)
    return NbGraderAPI(coursedir=CourseDirectory(config=config), config=config)


def _replace(path: Path, text: str) -> None:
    """Write the whole file or nothing of it."""
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)
