"""nbgrader's configuration for our judge; a course's own nbgrader_config.py loads it after course_id and root.

An instructor may set ``c.Judge.seed``, ``call_seconds``, ``cell_seconds``, ``submission_seconds`` and
``memory_mb`` in the course's file.
"""

from __future__ import annotations

from pathlib import Path

import nbgrader

from grader.pages import FeedbackExporter
from grader.preprocessor import GraftExporter, Judge

c = get_config()  # type: ignore[name-defined]

# The release: stubs in place of answers.
c.ClearSolutions.text_stub = "*Write your answer here.*"
c.GenerateAssignment.preprocessors = [
    "nbgrader.preprocessors.LockCells",
    "grader.build_release.ClearAnswers",
    "nbgrader.preprocessors.ClearOutput",
    "nbgrader.preprocessors.CheckCellMetadata",
    "nbgrader.preprocessors.ComputeChecksums",
    "nbgrader.preprocessors.SaveCells",
]

# A submission is read through the graft, and judged instead of executed.
c.Autograde.exporter_class = GraftExporter
# The graft leaves nothing of a student's to clear, deduplicate or validate.
c.Autograde.sanitize_preprocessors = ["nbgrader.preprocessors.OverwriteCells"]
c.Autograde.autograde_preprocessors = [
    Judge,
    "nbgrader.preprocessors.SaveAutoGrades",
    "nbgrader.preprocessors.AssignLatePenalties",
]

# nbgrader copies what lies beside a notebook, through links too: only notebooks travel.
c.CourseDirectory.ignore = ["*", ".*"]

# Pages without requests to other hosts: our templates only replace the MathJax that nbconvert fetches from a CDN.
c.HTMLExporter.extra_template_basedirs = [
    str(Path(__file__).resolve().parent / "templates"),
    str(Path(nbgrader.__file__).parent / "server_extensions" / "formgrader" / "templates"),
]
c.HTMLExporter.require_js_url = ""
c.GenerateFeedback.exporter_class = FeedbackExporter
