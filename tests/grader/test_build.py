"""From text to two notebooks: what the instructor gets, what students get, and what an author is told."""

import json
import re
import shutil
import subprocess
import sys

import labs
import nbformat
import pytest

from grader.build import ROOT, build
from grader.build_notebook import instructor_notebook
from grader.canaries import TOKEN
from uavlab.errors import BadFile
from uavlab.exercises import exercises, find


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    folder = tmp_path_factory.mktemp("built")
    handed_in = folder / "course" / "submitted" / "ada" / "02_heading" / "heading.ipynb"
    handed_in.parent.mkdir(parents=True)
    handed_in.write_text("mine")
    build(folder / "course", [labs.write(folder)])
    return folder / "course"


def notebook(course, version):
    return nbformat.read(course / version / "02_heading" / "heading.ipynb", as_version=4)


def cells(course, version):
    return {c.id: c for c in notebook(course, version).cells}


def run(source, names=None):
    names = {} if names is None else names
    exec(compile(source, "cell", "exec"), names)
    return names


def test_the_students_answer_cell_is_the_stub_and_raises_its_own_message(course):
    released = cells(course, "release")
    names = run(labs.IMPORTS)
    for exercise in exercises("heading"):
        source = released[f"answer-{exercise.name}"].source
        assert source + "\n" == exercise.source()
        with pytest.raises(NotImplementedError, match=re.escape(exercise.unfinished)):
            run(source, names)[exercise.name](*[0.0] * 2)


def test_the_instructors_answers_pass_the_checks_in_the_cells_below_them(course, capsys):
    names = run("")
    for cell in notebook(course, "source").cells:
        if cell.cell_type == "code":
            run(cell.source, names)
    said = capsys.readouterr().out
    for exercise in exercises("heading"):
        assert f"{exercise.name}: all" in said


def test_each_check_cell_is_locked_and_worth_the_points_of_its_exercise(course):
    for version in ("source", "release"):
        built = cells(course, version)
        for exercise in exercises("heading"):
            mark = built[f"check-{exercise.name}"].metadata.nbgrader
            assert (mark.grade, mark.locked, mark.solution) == (True, True, False)
            assert mark.points == exercise.points
            assert mark.grade_id == f"check-{exercise.name}"
            # A test cell that is only a docstring would be worth full marks.
            assert built[f"check-{exercise.name}"].source.startswith("#")


def test_the_rubric_stays_with_the_instructor(course):
    assert "says the teacher" in cells(course, "source")["question-why-not-yaw"].source
    released = cells(course, "release")
    assert "says the teacher" not in json.dumps(notebook(course, "release"))
    assert released["question-why-not-yaw"].source == "*Write your answer here.*"
    mark = released["question-why-not-yaw"].metadata.nbgrader
    assert (mark.grade, mark.solution, mark.points, mark.cell_type) == (True, True, 2, "markdown")
    assert "Why is a heading no yaw?" in released["ask-why-not-yaw"].source
    assert released["ask-why-not-yaw"].metadata.nbgrader.locked


def test_tags_go_through_to_both_versions(course):
    for version in ("source", "release"):
        tagged = [c for c in notebook(course, version).cells if c.metadata.get("tags")]
        assert [c.metadata.tags for c in tagged] == [["viz", "hide-input"]]


def test_nothing_of_an_answer_is_released(course):
    released = (course / "release" / "02_heading" / "heading.ipynb").read_text("utf-8")
    assert "SOLUTION" not in released
    assert not TOKEN.search(released)
    written = (ROOT / "uavlab" / "solutions" / "heading.py").read_text("utf-8")
    bodies = [s.strip() for s in written.splitlines() if s.startswith("    ") and "=" in s]
    assert len(bodies) > 10
    assert [s for s in bodies if json.dumps(s)[1:-1] in released] == []


def test_only_notebooks_lie_in_the_course(course):
    for version in ("source", "release"):
        files = [p.name for p in (course / version).rglob("*") if p.is_file()]
        assert files == ["heading.ipynb"]


def test_two_builds_agree_to_the_byte(course, tmp_path):
    # In another place, from another copy of the text, over an earlier build.
    again = shutil.copytree(course, tmp_path / "course")
    build(again, [labs.write(tmp_path)])
    for version in ("source", "release"):
        name = f"{version}/02_heading/heading.ipynb"
        assert (course / name).read_bytes() == (again / name).read_bytes()


def test_helpers_of_the_reference_come_along_inside_the_marked_region(course):
    source = cells(course, "source")["answer-attitude_with_heading"].source
    helpers, stub = source.split("def attitude_with_heading")
    assert "def _thrust_axis" in helpers
    assert helpers.strip().startswith("### BEGIN SOLUTION")
    assert helpers.strip().endswith("### END SOLUTION")
    assert "_thrust_axis" not in stub.split("### BEGIN SOLUTION", maxsplit=1)[0]


MISTAKES = {
    "an exercise is missing": (
        labs.text(leave_out="with_heading"),
        r"heading\.md:1: .*does not ask for with_heading: add a code cell '%exercise with_heading'",
    ),
    "an exercise is asked twice": (
        labs.text(extra=labs.code("%exercise heading_rate")),
        r"heading\.md:\d+: heading_rate is asked twice, first in line 18; keep one",
    ),
    "an unknown exercise": (
        labs.text(extra=labs.code("%exercise yaw_rate")),
        r"heading\.md:\d+: no exercise 'yaw_rate' in uavlab\.exercises\.heading; it has heading_rate",
    ),
    "more than the marker": (
        labs.text(extra=labs.code("%exercise heading_rate\nprint(1)")),
        r"heading\.md:\d+: an exercise cell has the one line",
    ),
    "an answer in the lab": (
        labs.text(extra=labs.code("### BEGIN SOLUTION")),
        r"heading\.md:\d+: answers are written in .*heading\.py, not in the lab",
    ),
    "no Python": (labs.text(extra=labs.code("def (")), r"heading\.md:\d+: .*not Python"),
    "a directive of Sphinx": (
        labs.text(extra=":::{note}\nHear!\n:::"),
        r"heading\.md:\d+: ':::\{' is shown raw by JupyterLab",
    ),
    "another kernel": (
        labs.text().replace("name: python3", "name: octave"),
        r"heading\.md:1: .*'octave'.*'python3'",
    ),
    "points below zero": (
        labs.text().replace('"points": 2', '"points": -2'),
        r"heading\.md:\d+: question 'why-not-yaw' has -2 points; allowed is",
    ),
    "a rubric without its question": (
        labs.text().replace('"rubric": "why', '"rubric": "how'),
        r"heading\.md:\d+: a rubric for 'how-not-yaw', but no such question above it",
    ),
    "front matter that is no YAML": ("---\n{a: [}\n---\n# Lab\n", r"heading\.md:1: .*not a MyST"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_an_author_is_told_file_line_and_cure_of(mistake, tmp_path):
    content, said = MISTAKES[mistake]
    with pytest.raises(BadFile, match=said):
        labs.write(tmp_path, content)


def test_the_line_that_an_error_names_is_the_line_of_the_cell(tmp_path):
    content = labs.text(extra=labs.code("%exercise yaw_rate"))
    with pytest.raises(BadFile) as error:
        labs.write(tmp_path, content)
    line = int(re.search(r"md:(\d+):", str(error.value))[1])
    assert "yaw_rate" in "".join(content.splitlines()[line - 1 : line + 2])


SOLUTIONS = (ROOT / "uavlab" / "solutions" / "heading.py").read_text("utf-8")


def test_a_signature_that_differs_from_the_reference_is_refused(tmp_path):
    other = SOLUTIONS.replace("def heading_rate(R: Mat3,", "def heading_rate(Q: Mat3,")
    with pytest.raises(
        BadFile, match=r"heading\.py:\d+: heading_rate differs(.|\n)*R: Mat3(.|\n)*Q: Mat3"
    ):
        instructor_notebook(labs.write(tmp_path, solutions=other))


def test_a_reference_that_is_missing_is_refused(tmp_path):
    with pytest.raises(BadFile, match="has no heading_rate"):
        instructor_notebook(
            labs.write(tmp_path, solutions=SOLUTIONS.replace("def heading_rate", "def other_rate"))
        )


def test_a_name_that_the_lab_does_not_import_is_refused(tmp_path):
    lab = labs.write(tmp_path, labs.text(imports=labs.IMPORTS.replace("about_z, ", "")))
    with pytest.raises(BadFile, match=r"heading\.md:\d+: the answer to with_heading uses about_z"):
        instructor_notebook(lab)


def test_a_name_that_means_something_else_in_the_lab_is_refused(tmp_path):
    other = SOLUTIONS.replace(
        "from uavlab.so3 import about_z, hat",
        "from uavlab.so3 import hat\nfrom numpy import sin as about_z",
    )
    assert other != SOLUTIONS
    with pytest.raises(
        BadFile, match=r"means numpy\.sin by about_z, and the lab uavlab\.so3\.about_z"
    ):
        instructor_notebook(labs.write(tmp_path, solutions=other))


def split_answers(tmp_path, **files):
    """A lab whose helper of with_heading lies in a file of its own, beside others."""
    helper = "def _turned(R, angle):\n    return about_z(angle) @ R\n"
    used = SOLUTIONS.replace(
        "return about_z(heading - heading_o) @ R_o", "return _turned(R_o, heading - heading_o)"
    )
    assert used != SOLUTIONS
    lab = labs.write(tmp_path, solutions=used)
    for name, text in {"turns": helper, **files}.items():
        lab.solutions.with_name(f"heading_{name}.py").write_text(text, encoding="utf-8")
    return lab


def test_answers_may_fill_several_files_and_their_helpers_come_along(tmp_path):
    book = instructor_notebook(split_answers(tmp_path))
    (cell,) = [c for c in book.cells if c.id == "answer-with_heading"]
    assert "def _turned(R, angle):" in cell.source.split("def with_heading")[0]


def test_two_helpers_of_one_name_in_two_files_are_refused(tmp_path):
    lab = split_answers(tmp_path, other="def _turned(R, angle):\n    return R\n")
    with pytest.raises(
        BadFile, match=r"heading_turns\.py:1: _turned is something else in heading_other\.py"
    ):
        instructor_notebook(lab)


def test_a_constant_that_is_bound_together_with_another_comes_along(tmp_path):
    both = SOLUTIONS.replace("PARALLEL = 1e-9", "PARALLEL, OTHER = 1e-9, 1")
    book = instructor_notebook(labs.write(tmp_path, solutions=both))
    assert any("PARALLEL, OTHER = 1e-9, 1" in c.source for c in book.cells)


def test_a_broken_lab_leaves_the_last_build_as_it_was(course, tmp_path):
    def notebooks():
        return {p: p.read_bytes() for p in course.rglob("*.ipynb")}

    before = notebooks()
    bad = labs.write(tmp_path, solutions=SOLUTIONS.replace("def heading_rate", "def other_rate"))
    with pytest.raises(BadFile):
        build(course, [bad])
    assert notebooks() == before


def test_what_an_instructor_keeps_in_the_course_survives_a_build(course):
    handed_in = course / "submitted" / "ada" / "02_heading" / "heading.ipynb"
    assert handed_in.read_text() == "mine"


def test_a_lab_that_is_not_there_is_one_line_and_exit_code_two(tmp_path):
    command = [
        sys.executable,
        "-m",
        "grader.build",
        "--course",
        str(tmp_path / "c"),
        "--lab",
        "hedding",
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "no lab named 'hedding'. Did you mean 'heading'?" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "c").exists()


def test_every_lab_of_the_course_reads_and_its_answers_fit_in():
    from grader.build import find_labs

    for lab in find_labs():
        ids = {c.id for c in instructor_notebook(lab).cells}
        assert {f"answer-{name}" for name in lab.exercises} <= ids
        assert find(next(iter(lab.exercises))).stem == lab.stem


def test_the_settings_of_a_course_are_written_once_with_a_secret_seed_of_its_own(tmp_path):
    lab = labs.write(tmp_path / "lab")
    seeds = []
    for name in ("here", "there"):
        build(tmp_path / name, [lab])
        seeds.append(re.search(r"c\.Judge\.seed = (\d+)", settings(tmp_path / name)).group(1))
    assert seeds[0] != seeds[1]
    mine = settings(tmp_path / "here") + "c.CourseDirectory.course_id = 'ours'\n"
    (tmp_path / "here" / "nbgrader_config.py").write_text(mine)
    build(tmp_path / "here", [lab])
    assert settings(tmp_path / "here") == mine


def settings(course):
    return (course / "nbgrader_config.py").read_text()
