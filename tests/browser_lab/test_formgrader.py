"""A teacher's hour: formgrader shows a graded class, a person gives points and a comment, the feedback page has both.

One sitting in lab 02: each fixture is a step of it, after the one before.
"""

import json
import os
import sys

import pytest
from browser import needs_chromium, open_page, watch
from servers import outside, serve, until

from grader import sandbox
from grader.build import build, find_labs
from grader.classroom import CLASS, Student, filled, hand_in
from grader.grade import grade

pytestmark = [pytest.mark.lab, pytest.mark.slow]

LAB, STEM, QUESTION = "02_heading", "heading", "question-why-not-yaw"
RATE = "check-heading_rate"
HINT = "Hint: The heading rate has the wrong sign when the aircraft is tilted"
SUM = 25  # points of the lab
COMMENT = r"Right, but say which $\eta$ you mean."
BITE = (
    "<script>window.bitten = 1</script><img src='http://192.0.2.1/x' onerror='window.bitten = 1'>"
    "<svg onload='window.bitten = 1'></svg> [click](javascript:window.bitten=1) "
    r"![seen](http://192.0.2.1/y) $\href{javascript:window.bitten=1}{x}$"
)


def biting(notebook, answers):
    """Right answers; to the questions, and in a cell of its own, HTML that would run in the reader's browser."""
    whole = json.loads(filled(notebook, answers))
    for cell in whole["cells"]:
        if cell["id"].startswith("question-"):
            cell["source"] = f"My answer. {BITE}"
    own = {"cell_type": "markdown", "id": "own", "metadata": {}, "source": f"My notes. {BITE}"}
    whole["cells"].insert(3, own)
    return json.dumps(whole).encode()


ADA, BEN = CLASS[:2]  # right, and with wrong signs
MIA = Student("mia", "a page that bites", biting)


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """Lab 02, built and graded for three."""
    needs_chromium()
    if missing := sandbox.available():
        (pytest.fail if os.environ.get("CI") == "true" else pytest.skip)(missing)
    course = tmp_path_factory.mktemp("teacher") / "course"
    build(course, find_labs([STEM]))
    hand_in(course, LAB, STEM, (ADA, BEN, MIA))
    grade(course, LAB, say=lambda _: None)
    return course


@pytest.fixture(scope="module")
def page(course):
    """Formgrader's first page, from a Jupyter server in the course directory."""
    command = [sys.executable, "-m", "jupyter_server", "--no-browser", "--allow-root"]
    with (
        serve(command, course.parent, cwd=course) as (address, token),
        open_page(f"{address}formgrader?token={token}", size=(1300, 900)) as page,
    ):
        yield page


@pytest.fixture(scope="module")
def table(page):
    """The rows of the table of submissions: number → its cells."""
    page.get_by_role("link", name="Manual Grading").first.click()
    page.get_by_role("link", name=LAB).click()
    page.get_by_role("link", name=STEM, exact=True).click()
    rows = page.locator("tbody tr", has_text="Submission #")
    rows.nth(2).wait_for()
    return {row.split("\t")[1]: row.split("\t")[2:] for row in rows.all_inner_texts()}


@pytest.fixture(scope="module")
def submission(page, table):
    """The page of Ben's submission, with its formulas drawn and its points loaded."""
    (number,) = [name for name, row in table.items() if row[0] == f"14 / {SUM}"]
    page.get_by_role("link", name=number).click()
    ready(page)
    return page


@pytest.fixture(scope="module")
def marked(submission, course):
    """What the gradebook has after a person has typed points, gone on with Tab, and typed a comment."""
    page = submission
    page.locator(f"#{QUESTION}").click()
    page.keyboard.type("1.5")
    for _ in range(2):  # over the extra credit
        before = focused(page)
        page.keyboard.press("Tab")
        assert until(lambda before=before: focused(page) != before, 10), "Tab does not go on"
    assert focused(page) == f"{QUESTION}-comment"
    page.keyboard.type(COMMENT)
    page.keyboard.press("Escape")
    until(lambda: gradebook(course, BEN.name)[1] == COMMENT, 20)
    page.screenshot(path=course / "marked.png")
    return gradebook(course, BEN.name)


@pytest.fixture(scope="module")
def feedback(page, marked, course):
    """Graded once more, Ben's feedback page: opened as a file, without a network."""
    grade(course, LAB, say=lambda _: None)
    context = page.context.browser.new_context(offline=True)
    found = context.new_page()
    watch(found)
    found.goto(f"file://{course}/feedback/{BEN.name}/{LAB}/{STEM}.html")
    found.locator("mjx-container").first.wait_for()
    found.get_by_text(HINT).scroll_into_view_if_needed()
    found.screenshot(path=course / "feedback.png")
    yield found
    context.close()


def test_the_class_is_listed_with_its_points(table):
    assert sorted(row[0] for row in table.values()) == [f"{p} / {SUM}" for p in (14, 21, 21)]
    assert all(row[1].endswith("/ 21") and row[2] == "0 / 4" for row in table.values())


def test_a_graded_submission_shows_its_points_its_checks_and_its_hint(submission):
    cell = submission.locator(".cell", has=submission.locator(f"#{RATE}"))
    said = " ".join(cell.inner_text().split())
    assert "heading_rate: 0 of 4 points ✓ level flight ✗ derivative of the heading" in said
    assert HINT in said
    assert cell.locator(f"#{RATE}").get_attribute("placeholder") == "0"
    assert submission.locator("#check-with_heading").get_attribute("placeholder") == "3"


def test_a_question_waits_for_a_person_with_a_field_for_points_and_one_for_a_comment(submission):
    cell = submission.locator(".nbgrader_cell", has=submission.locator(f"#{QUESTION}"))
    assert "Because the two are not the same angle" in cell.inner_text()
    assert "needs_manual_grade" in cell.locator(f"#{QUESTION}").get_attribute("class")
    assert cell.locator("textarea").get_attribute("id") == f"{QUESTION}-comment"


def test_formulas_are_drawn(submission):
    assert submission.locator("mjx-container svg").count() > 20
    assert (
        "$" not in submission.locator(".text_cell", has_text="Theory in ten minutes").inner_text()
    )


def test_points_and_a_comment_given_by_hand_are_in_the_gradebook(marked):
    assert marked == (1.5, COMMENT)


def test_the_feedback_page_has_points_comment_hint_and_formulas_without_a_network(feedback):
    said = " ".join(feedback.locator("body").inner_text().split())
    assert f"{STEM} (Score: 15.5 / {SUM}.0)" in said
    assert "Right, but say which" in said
    assert HINT in said
    assert feedback.locator("mjx-container svg").count() > 20
    assert outside(feedback.requests) == []
    assert feedback.errors == []


def test_what_a_student_writes_does_not_run_in_the_browser_of_its_reader(page, marked, course):
    page.goto(
        f"{page.url.partition('/submissions')[0]}/submissions/{notebook_id(course, MIA.name)}/"
    )
    ready(page)
    said = page.locator("#notebook").first.inner_text()
    assert said.count("My answer.") == 2
    assert said.count("My notes.") == 1
    assert page.evaluate("window.bitten") is None
    assert page.locator("a[href^='javascript'], svg [href^='javascript']").count() == 0


def test_no_request_leaves_the_computer_and_no_error_is_met(page, marked):
    assert outside(page.requests) == []
    assert page.errors == []


def ready(page):
    page.locator("mjx-container").first.wait_for()
    page.wait_for_function("formgrader.loaded && formgrader.grades.loaded && MathJax.loaded")


def focused(page):
    return page.evaluate("document.activeElement.id")


def gradebook(course, student):
    """Points and comment that a person gave for the question."""
    from nbgrader.api import Gradebook

    with Gradebook(f"sqlite:///{course}/gradebook.db") as book:
        points = book.find_grade(QUESTION, STEM, LAB, student).manual_score
        return points, book.find_comment(QUESTION, STEM, LAB, student).manual_comment


def notebook_id(course, student):
    """How formgrader calls a submitted notebook."""
    from nbgrader.api import Gradebook

    with Gradebook(f"sqlite:///{course}/gradebook.db") as book:
        return book.find_submission_notebook(STEM, LAB, student).id
