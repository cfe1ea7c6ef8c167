"""What nbgrader runs instead of its own `Execute`, and how it reads a submission.

Both are set by `grader.nbgrader_config` through nbgrader's public configuration, so that ``nbgrader autograde`` and
formgrader's button grade as `grader.grade` does.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, cast

import nbformat
from nbconvert.exporters import NotebookExporter
from nbformat import NotebookNode
from nbgrader.preprocessors import NbGraderPreprocessor
from traitlets import Float, Integer

from grader import cache, mark
from grader.graft import graft_file
from grader.sandbox import Limits


class GraftExporter(NotebookExporter):
    """Reads a submission grafted onto its release notebook; any other notebook as it is."""

    def from_filename(
        self, filename: str, resources: Any = None, **kwargs: Any
    ) -> tuple[NotebookNode, dict[str, Any]]:
        """Read and convert one file. The submitted file itself is never changed."""
        coursedir = self.parent.coursedir  # type: ignore[union-attr]
        known = resources["nbgrader"]
        student, assignment = known["student"], known["assignment"]
        root = Path(coursedir.format_path(coursedir.submitted_directory, "", "")).resolve()
        folder = Path(coursedir.format_path(coursedir.submitted_directory, student, assignment))
        if Path(filename).parent != folder:
            return super().from_filename(filename, resources=resources, **kwargs)
        release = Path(coursedir.format_path(coursedir.release_directory, ".", assignment))
        truth = json.loads((release / os.path.basename(filename)).read_text(encoding="utf-8"))
        grafted = graft_file(truth, Path(filename), root)
        for note in grafted.notes:
            self.log.warning("%s: %s", student, note)
        notebook = cast(NotebookNode, nbformat.from_dict(grafted.notebook))
        return self.from_notebook_node(notebook, resources, **kwargs)


class Judge(NbGraderPreprocessor):
    """Marks a notebook: the judge outside, the student's code in the sandbox."""

    seed = Integer(mark.SEED, help="Decides the random inputs of the checks.").tag(config=True)
    call_seconds = Float(Limits().call, help="Time for one call of an answer.").tag(config=True)
    cell_seconds = Float(Limits().cell, help="Time for one cell.").tag(config=True)
    submission_seconds = Float(
        Limits().submission, help="Time for all that a submission runs."
    ).tag(config=True)
    memory_mb = Integer(Limits().memory // 2**20, help="Memory of a submission.").tag(config=True)

    def options(self, course: Path) -> mark.Options:
        """How this course is marked."""
        limits = Limits(
            call=self.call_seconds,
            cell=self.cell_seconds,
            submission=self.submission_seconds,
            memory=self.memory_mb * 2**20,
        )
        return mark.Options(seed=self.seed, limits=limits, cache=course / cache.FOLDER)

    def preprocess(self, nb: NotebookNode, resources: Any) -> tuple[NotebookNode, Any]:
        """Put verdicts into the outputs of the check cells.

        Raises
        ------
        SandboxMissing
            Student code cannot be isolated here; nothing is graded.
        """
        course = Path(self.parent.parent.coursedir.root)  # type: ignore[union-attr]
        plain = json.loads(json.dumps(nb))
        mark.write(plain, mark.mark(plain, self.options(course)))
        return cast(NotebookNode, nbformat.from_dict(plain)), resources
