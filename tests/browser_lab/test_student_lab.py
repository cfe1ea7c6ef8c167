"""A student's evening: lab 01 opens, an answer is typed and checked, a flight is seen, the notebook validated.

One sitting, each fixture a step of it after the one before; the tests look at what each step left.
"""

import io
import json
import re
import sys

import numpy as np
import pytest
from browser import colours, needs_chromium, open_page
from PIL import Image
from servers import outside, serve, until

from grader.build import ROOT
from uavlab.exercises import exercises, find

pytestmark = [pytest.mark.lab, pytest.mark.slow]

FIRST = "rigid_body_rate"
ANSWER = """\
spin = np.cross(state.omega, J @ state.omega)
return StateRate(
    state.v,
    force / m,
    state.R @ hat(state.omega),
    np.linalg.solve(J, torque - spin),
)"""
POP_UPS = ".jp-Dialog, .Toastify__toast"
CELL = ".jp-Notebook .jp-Cell"


class Notebook:
    """The notebook on the screen, in the hands of a student."""

    def __init__(self, page, path):
        self.page, self.path = page, path
        self.cells = json.loads(path.read_text())["cells"]

    def find(self, wanted):
        """The place of the first code cell with this id, or with this in its source."""
        for place, cell in enumerate(self.cells):
            source = "".join(cell["source"])
            if cell["cell_type"] == "code" and (cell["id"] == wanted or wanted in source):
                return place
        raise LookupError(wanted)

    def cell(self, place):
        return self.page.locator(CELL).nth(place)

    def click(self, place):
        """Put the cursor into a cell's code, unfolded if it is folded."""
        cell = self.cell(place)
        cell.scroll_into_view_if_needed()
        if cell.locator(".jp-InputPlaceholder").count():
            cell.locator(".jp-InputPlaceholder").click()
        cell.locator(".cm-line").first.click()
        cell.locator(".cm-editor.cm-focused").wait_for()

    def run(self, place):
        """Click into a cell, press Shift+Enter, wait until it has run; returns what is read below it."""
        prompt = self.cell(place).locator(".jp-InputPrompt")
        before = prompt.inner_text()
        self.click(place)
        self.page.keyboard.press("Shift+Enter")
        done = re.compile(r"\[\d+\]")
        until(lambda: prompt.inner_text() != before and done.search(prompt.inner_text()))
        assert done.search(prompt.inner_text()), f"cell {place} did not end: {prompt.inner_text()}"
        self.wait()
        return self.said(place)

    def wait(self):
        """Until the kernel is there and has nothing to do."""
        self.page.locator("#jp-main-statusbar", has_text="Python 3 (ipykernel) | Idle").wait_for(
            timeout=60_000
        )

    def said(self, place):
        outputs = self.cell(place).locator(".jp-OutputArea")
        return outputs.inner_text().strip() if outputs.count() else ""


@pytest.fixture(scope="module")
def notebook(tmp_path_factory):
    """The student's lab 01 as ``make lab`` opens it, with a kernel that is ready."""
    needs_chromium()
    folder = tmp_path_factory.mktemp("student")
    build = [sys.executable, "-m", "grader.build", "--course", str(folder / "course")]
    data = {"UAVLAB_DATA": str(folder)}  # no recorded flights, and none fetched
    with (
        serve([*build, "--open", "dynamics"], folder, cwd=ROOT, environment=data) as server,
        open_page(f"{server[0]}?token={server[1]}", size=(1400, 900)) as page,
    ):
        page.get_by_role("heading", name="Lab 01").wait_for(timeout=60_000)
        notebook = Notebook(page, folder / "student" / "01_dynamics" / "dynamics.ipynb")
        notebook.wait()
        yield notebook


@pytest.fixture(scope="module")
def opened(notebook):
    """What is on the screen before anything is touched."""
    page = notebook.page
    return {
        "text": page.locator("body").inner_text(),
        "names": page.locator("[title]").evaluate_all("all => all.map(x => x.title)"),
        "pop-ups": page.locator(POP_UPS).all_inner_texts(),
    }


@pytest.fixture(scope="module")
def unfinished(notebook, opened):
    """What the check says before there is an answer."""
    notebook.run(notebook.find("import uavlab"))
    notebook.run(notebook.find(f"answer-{FIRST}"))
    return notebook.run(notebook.find(f"check-{FIRST}"))


@pytest.fixture(scope="module")
def checked(notebook, unfinished):
    """What the check says, and in which colours, after the answer was typed over the stub's last line."""
    answer, check = notebook.find(f"answer-{FIRST}"), notebook.find(f"check-{FIRST}")
    notebook.click(answer)
    keyboard = notebook.page.keyboard
    keyboard.press("Control+End")
    keyboard.press("Shift+Home")
    keyboard.type(ANSWER)
    notebook.run(answer)
    said = notebook.run(check)
    green = notebook.cell(check).locator(".jp-OutputArea .ansi-green-fg").all_inner_texts()
    return said, "\n".join(green)


@pytest.fixture(scope="module")
def flown(notebook, checked):
    """The frame with the replay, and what is printed above it."""
    place = notebook.find("views.show(log)")
    said = notebook.run(place)
    frame = notebook.cell(place).locator("iframe")
    frame.scroll_into_view_if_needed()
    return frame, said


@pytest.fixture(scope="module")
def validated(notebook, flown):
    """What Validate says of a notebook with one of its exercises answered."""
    page = notebook.page
    page.get_by_role("button", name="Validate").click()
    dialog = page.locator(".jp-Dialog")
    dialog.wait_for(timeout=100_000)
    page.screenshot(path=notebook.path.with_name("validated.png"))
    said = dialog.inner_text()
    dialog.get_by_role("button", name="Ok").click()
    return said


def test_the_lab_is_open_and_nothing_lies_over_it(opened):
    assert "Lab 01 — What a multirotor is" in opened["text"]
    assert opened["pop-ups"] == []


def test_validate_is_there_and_the_panels_of_teachers_and_class_servers_are_not(opened):
    assert "Validate" in opened["text"]
    shown = "\n".join([opened["text"], *opened["names"]]).lower()
    for name in ("nbgrader", "create assignment", "formgrader", "assignment list", "course list"):
        assert name not in shown


def test_a_check_of_an_unfinished_answer_shows_its_message_and_nothing_else(unfinished):
    assert unfinished == f"NotImplementedError: {find(FIRST).unfinished}"


def test_a_typed_answer_turns_its_check_green(checked):
    said, green = checked
    names = [check.name.replace("_", " ") for check in find(FIRST).checks]
    assert [line.strip() for line in said.splitlines()[:-1]] == [f"✓ {name}" for name in names]
    assert f"{FIRST}: all {len(names)} public checks pass." in said
    assert green.split() == said.split()


def test_the_flight_says_which_part_of_it_the_student_wrote(flown):
    _, said = flown
    assert "the scenario ran to its end" in said
    assert f"{FIRST}: mine" in said
    assert "step_on_so3: mine" not in said


def test_the_replay_is_seen_and_moves(notebook, flown):
    frame, _ = flown
    assert until(lambda: colours(scene(frame)) > 900), "the replay stays blank"
    clock = frame.content_frame.get_by_text(re.compile(r"\d / 12\.0 s"))
    time, before = clock.inner_text(), scene(frame)
    assert until(lambda: clock.inner_text() != time), "the clock of the replay stands still"
    assert until(lambda: (scene(frame) != before).any(axis=2).mean() > 1e-3), "nothing moves"
    notebook.page.screenshot(path=notebook.path.with_name("flown.png"))


def test_validate_names_what_is_unfinished_and_only_that(validated):
    others = [x for x in exercises("dynamics") if x.name != FIRST]
    failed = re.findall(r"uavlab\.check\((\w+)\)", validated)
    assert failed == [x.name for x in others]
    for exercise in others:
        assert f"NotImplementedError: {exercise.unfinished}" in validated
    assert validated.count("You did not provide a response.") == 2  # the two questions
    assert "Traceback" not in validated


def test_validate_has_saved_what_was_typed(notebook, validated):
    cells = json.loads(notebook.path.read_text())["cells"]
    (answer,) = [c for c in cells if c["id"] == f"answer-{FIRST}"]
    source = "".join(answer["source"])
    assert "np.linalg.solve(J, torque - spin)" in source
    assert "NotImplementedError" not in source


def test_no_request_leaves_the_computer_and_no_error_is_met(notebook, validated):
    assert len(notebook.page.requests) > 50
    assert outside(notebook.page.requests) == []
    assert notebook.page.errors == []
    assert notebook.page.locator(POP_UPS).all_inner_texts() == []


def scene(frame):
    """The part of a replay's frame that has no captions, as a picture."""
    picture = np.asarray(Image.open(io.BytesIO(frame.screenshot())).convert("RGB"))
    height, width = picture.shape[:2]
    return picture[int(0.22 * height) : int(0.9 * height), : int(0.8 * width)]
