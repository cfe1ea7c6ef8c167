"""nbgrader as the shell, through its Python interface: one process for a whole class."""

from __future__ import annotations

import contextlib
import io
import logging
import shutil
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from nbgrader.api import Gradebook, MissingEntry
from traitlets.config import Config

from grader import cache
from grader.coursework import CLEAN, Coursework
from grader.mark import Options
from grader.steps import CHECK
from grader.tools import offer_programs

NOT_GRADED = "not graded:"  # how the note of a submission begins that the grader failed on


class Row(NamedTuple):
    """One student in the class table."""

    student: str
    scores: dict[str, tuple[float | None, float]]  # exercise or question → points, of how many
    note: str = ""

    @property
    def total(self) -> float:
        """The points so far."""
        return sum(score or 0.0 for score, _ in self.scores.values())

    @property
    def most(self) -> float:
        """The points there are."""
        return sum(points for _, points in self.scores.values())

    @property
    def waiting(self) -> float:
        """Points that a person has still to give."""
        return sum(points for score, points in self.scores.values() if score is None)


class Shell:
    """nbgrader, configured as its own commands are in the course directory."""

    def __init__(self, work: Coursework) -> None:
        from nbgrader.coursedir import CourseDirectory
        from traitlets.config.loader import PyFileConfigLoader

        self.work = work
        offer_programs()
        with _quiet():
            self.config: Config = PyFileConfigLoader(
                "nbgrader_config.py", path=str(work.root)
            ).load_config()
            self._coursedir = CourseDirectory(config=self.config, root=str(work.root))
        self._coursedir.assignment_id = work.assignment

    def options(self) -> Options:
        """How the course's configuration wants it marked."""
        from grader.preprocessor import Judge

        return Judge(config=self.config).options(self.work.root)

    def autograde(self) -> str:
        """Grade every clean notebook that is not graded; returns what nbgrader complained of."""
        from nbconvert.exporters import NotebookExporter
        from nbgrader.converters import Autograde

        config = Config(self.config)
        config.Autograde.exporter_class = NotebookExporter  # these are grafted already
        self._coursedir.submitted_directory = CLEAN
        return self._run(Autograde(coursedir=self._coursedir, config=config))

    def feedback(self) -> str:
        """Write the feedback pages that are not there or older than a person's points and comments.

        Returns what nbgrader complained of.
        """
        from nbgrader.converters import GenerateFeedback

        from grader.pages import offer_mathjax

        notes, given = self.work.root / cache.FOLDER, self._given()
        for student, name in given.items():
            if cache.load(notes, f"feedback-{self.work.assignment}-{student}") != {"of": name}:
                shutil.rmtree(self.work.folder("feedback", student), ignore_errors=True)
        said = self._run(GenerateFeedback(coursedir=self._coursedir, config=self.config))
        for student, name in given.items():
            if self.work.folder("feedback", student).is_dir():
                cache.save(notes, f"feedback-{self.work.assignment}-{student}", {"of": name})
        offer_mathjax(self.work.root)
        return said

    def _given(self) -> dict[str, str]:
        """Student → a hash of what persons gave and wrote; nbgrader does not see when that changes."""
        with self._gradebook() as gradebook:
            return {
                str(s.student.id): cache.key(sorted(_by_hand(s), key=str))
                for s in gradebook.assignment_submissions(self.work.assignment)
            }

    def export(self) -> Path:
        """Write grades.csv of the whole course."""
        from nbgrader.plugins import CsvExportPlugin

        path = self.work.root / "grades.csv"
        with _quiet(), self._gradebook() as gradebook:
            plugin = CsvExportPlugin(config=self.config)
            plugin.to = str(path)
            plugin.export(gradebook)
        return path

    def row(self, student: str, note: str = "") -> Row:
        """What the gradebook says of a student's submission."""
        if not self.work.folder("autograded", student).is_dir():
            note = f"{NOT_GRADED} nbgrader failed" + (f"; {note}" if note else "")
        with self._gradebook() as gradebook:
            try:
                submission = gradebook.find_submission(self.work.assignment, student)
            except MissingEntry:
                return Row(student, {}, note)
            grades = [g for book in submission.notebooks for g in book.grades]
            found = {g.name: (_score(g), float(g.max_score)) for g in grades}
        order = self._cells()
        scores = {x.removeprefix(CHECK): found[x] for x in order if x in found}
        return Row(student, scores, note)

    def _cells(self) -> list[str]:
        cells = [c for book in self.work.released.values() for c in book["cells"]]
        return [str(c["metadata"].get("nbgrader", {}).get("grade_id")) for c in cells]

    def _gradebook(self) -> Any:
        return Gradebook(self._coursedir.db_url, self._coursedir.course_id)

    @staticmethod
    def _run(converter: Any) -> str:
        from nbgrader.converters import NbGraderException

        with _quiet() as said:
            handler = logging.StreamHandler(said)
            handler.setLevel(logging.ERROR)
            converter.log.addHandler(handler)
            try:
                converter.start()
            except NbGraderException:
                return said.getvalue().strip() or "nbgrader failed"
            finally:
                converter.log.removeHandler(handler)
        return ""


def _score(grade: Any) -> float | None:
    """The points of a graded cell; None while a person has to give them."""
    waiting = grade.needs_manual_grade or (grade.auto_score is None and grade.manual_score is None)
    return None if waiting and grade.auto_score is None else float(grade.score)


def _by_hand(submission: Any) -> Iterator[tuple[Any, ...]]:
    """What persons gave and wrote, cell by cell."""
    for book in submission.notebooks:
        yield from ((book.name, g.name, g.manual_score, g.extra_credit) for g in book.grades)
        yield from ((book.name, c.name, c.manual_comment) for c in book.comments)


@contextlib.contextmanager
def _quiet() -> Iterator[io.StringIO]:
    """Keep nbgrader's chatter off the terminal."""
    said = io.StringIO()
    logger = logging.getLogger("traitlets")
    level, propagate = logger.level, logger.propagate
    logger.propagate = False
    try:
        with contextlib.redirect_stderr(io.StringIO()), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its own, of its dependencies
            yield said
    finally:
        logger.setLevel(level)
        logger.propagate = propagate
