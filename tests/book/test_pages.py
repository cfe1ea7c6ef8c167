"""The sources of the book: labs as pages, the syllabus, the records. No Sphinx is run here."""

import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "grader"))  # for the small lab

import labs

from grader.build import ROOT
from grader.build_book import lab_page, library_digest, syllabus, write_pages
from uavlab.errors import BadFile
from uavlab.exercises import exercises


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    return labs.write(tmp_path_factory.mktemp("lab"))


def test_a_lab_page_shows_stubs_and_hides_where_the_answers_come_from(lab):
    page = lab_page(lab)
    cards = page.split("```{code-cell}")
    for exercise in exercises("heading"):
        assert f"{{exercise}} {exercise.name}: {exercise.points:g} points, {exercise.reads}" in page
        taking = [c for c in cards if f"from uavlab.solutions.heading import {exercise.name}" in c]
        assert len(taking) == 1
        assert ":tags: [remove-cell]" in taking[0]
    assert "raise NotImplementedError" not in page
    assert "%exercise" not in page


def test_a_lab_page_has_the_question_and_not_the_rubric(lab):
    page = lab_page(lab)
    assert "Why is a heading no yaw?" in page
    assert "says the teacher" not in page


def test_tags_of_cells_reach_the_page(lab):
    assert ":tags: [viz, hide-input]" in lab_page(lab)


def test_a_page_is_run_again_when_the_library_changes(lab, tmp_path):
    (tmp_path / "uavlab").mkdir()
    source = tmp_path / "uavlab" / "so3.py"
    source.write_text("a = 1")
    before = library_digest(tmp_path)
    assert library_digest(tmp_path) == before
    source.write_text("a = 2")
    assert library_digest(tmp_path) != before
    assert lab_page(lab, before) != lab_page(lab, library_digest(tmp_path))


def test_the_syllabus_lists_every_exercise_with_reading_points_and_their_sum(lab):
    written = syllabus("# Syllabus\n\n<!-- exercises -->\n", [lab])
    total = sum(x.points for x in exercises("heading")) + 2
    assert f"[The lab](labs/heading.md), {total:g} points." in written
    for exercise in exercises("heading"):
        row = f"| [`{exercise.name}`](exercise-{exercise.name}) | {exercise.reads} | {exercise.points:g} |"
        assert row in written
    assert "| question: why not yaw |  | 2 |" in written


def test_a_syllabus_without_its_mark_is_refused(lab):
    with pytest.raises(BadFile, match="must have the line '<!-- exercises -->' once"):
        syllabus("# Syllabus\n", [lab])


def test_only_what_changed_is_written_and_what_is_gone_is_removed(lab, tmp_path):
    write_pages(tmp_path, [lab], ROOT)
    page = tmp_path / "labs" / "heading.md"
    before = page.stat().st_mtime_ns
    (tmp_path / "old.md").write_text("# Old")
    write_pages(tmp_path, [lab], ROOT)
    assert page.stat().st_mtime_ns == before
    assert not (tmp_path / "old.md").exists()
    write_pages(tmp_path, [], ROOT)
    assert not page.exists()


def test_chapters_and_labs_stand_in_the_order_of_the_course(tmp_path, lab):
    write_pages(tmp_path, [lab], ROOT)
    index = (tmp_path / "index.md").read_text("utf-8")
    assert "@chapters@" not in index
    assert "labs/heading" in index


def test_a_record_has_context_choice_and_price_on_one_screen():
    records = sorted((ROOT / "book" / "decisions").glob("[0-9]*.md"))
    assert len(records) >= 7
    for number, record in enumerate(records, start=1):
        text = record.read_text("utf-8")
        assert record.name.startswith(f"{number:03d}-")
        assert text.startswith(f"# {number}. ")
        assert len(text.splitlines()) <= 40
        for part in ("**Context.**", "**Choice.**", "**Price.**"):
            assert text.count(part) == 1
