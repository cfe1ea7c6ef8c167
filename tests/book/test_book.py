"""The book, built once into a folder of its own: complete, offline, rendered, and without answers."""

import html
import re

import pytest
from browser import colours, open_browser, screenshot, watch

from grader import build_book
from grader.canaries import TOKEN
from grader.leaks import secret_lines
from uavlab.exercises import STEMS, all_exercises, exercises

pytestmark = pytest.mark.lab

WITH_FORMULAS = (
    "conventions",
    "notation",
    "errata",
    "dynamics",
    "heading",
    "labs/dynamics",
    "labs/heading",
)
READY = "() => window.MathJax?.startup?.promise?.then(() => true) ?? true"


@pytest.fixture(scope="module")
def book(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        # Somebody may be working on the library while this runs.
        patch.setattr(build_book, "library_digest", lambda root: "fixed")
        out = tmp_path_factory.mktemp("book") / "book"
        yield build_book.build_book(out).parent  # it raises on a warning


@pytest.fixture(scope="module")
def pages(book):
    return {
        str(p.relative_to(book).with_suffix("")): html.unescape(p.read_text("utf-8"))
        for p in sorted(book.rglob("*.html"))
        if "_static" not in p.parts and "replays" not in p.parts
    }


@pytest.fixture(scope="module")
def page(book):
    with open_browser() as browser:
        tab = browser.new_context(viewport={"width": 1300, "height": 1000}, offline=True).new_page()
        watch(tab)
        yield tab


def text(page):
    """What one reads: tags and the spans of coloured code taken out."""
    return html.unescape(re.sub(r"<[^>]+>", "", page))


def test_every_page_opens_offline_without_a_request_or_an_error(book, page, pages):
    assert len(pages) > 20
    for name in pages:
        page.goto((book / f"{name}.html").as_uri())
        page.evaluate(READY)
    assert [r for r in page.requests if not r.startswith(("file:", "data:", "blob:"))] == []
    assert page.errors == []


@pytest.mark.parametrize("name", WITH_FORMULAS)
def test_every_formula_is_rendered_on(name, book, page):
    page.goto((book / f"{name}.html").as_uri())
    page.evaluate(READY)
    asked = page.locator(".math").count()
    assert asked > 10
    assert page.locator("mjx-container svg").count() >= asked
    assert page.locator("[data-mjx-error], mjx-merror").count() == 0


def test_each_exercise_is_on_its_labs_page_with_stub_points_and_reading(pages):
    for exercise in all_exercises():
        seen = text(pages[f"labs/{exercise.stem}"])
        unit = "point" if exercise.points == 1 else "points"
        assert f"{exercise.name}: {exercise.points:g} {unit}, {exercise.reads}" in seen
        kind = "class" if exercise.is_class else "def"
        assert re.search(rf"^{kind} {exercise.name}\b", seen, re.MULTILINE)
        assert all(f"    def {name}(" in seen for name in exercise.methods)
        assert exercise.stub.__doc__.splitlines()[0] in seen


def test_no_answer_rubric_or_canary_is_in_the_book(pages):
    secrets = secret_lines()
    assert len(secrets) > 300
    for name, page in pages.items():
        assert "uavlab.solutions" not in page or name in {"errata", *STEMS} | {
            n for n in pages if n.startswith(("decisions/", "contributing"))
        }, name
        assert not TOKEN.search(page), name
        lines = {s.strip() for s in text(page).splitlines()}
        assert {s: secrets[s] for s in lines & secrets.keys()} == {}, name
        assert "What a good answer says" not in page


@pytest.mark.parametrize("stem", STEMS)
def test_a_lab_s_page_shows_the_pictures_of_the_lab(pages, stem):
    shown = re.findall(r'<img[^>]*src="[^"]*_images/', pages[f"labs/{stem}"])
    assert len(shown) >= len(exercises(stem))


def test_the_labs_show_their_flights_in_3d(book, page, pages):
    for name in ("labs/dynamics", "labs/heading"):
        frames = re.findall(r'<iframe[^>]*src="([^"]+)"', pages[name])
        assert frames, name
        for source in frames:
            assert (book / name).parent.joinpath(source).is_file()
        page.goto((book / f"{name}.html").as_uri())
        page.locator("iframe").first.scroll_into_view_if_needed()
        page.frame_locator("iframe").first.locator("canvas").first.wait_for()
        page.wait_for_timeout(2000)
        assert colours(screenshot(page)) > 900


def test_the_errata_print_what_the_functions_of_the_course_compute(pages):
    seen = text(pages["errata"])
    # MRS eq. (19): the closed form of the loss, worst over all directions of the tilt.
    for tilt, lost in ((10, 0.9), (20, 3.6), (30, 8.2), (45, 19.5), (60, 36.9)):
        assert re.search(rf"{tilt}°\s+{lost}°", seen), (tilt, lost)
    # MRS Sec. 8.2: 7 m/s on a circle of 5 m, the turn of 1.4 rad/s told in the body.
    assert re.search(r"-0\.989\s+0\.000\s+0\.990", seen)


def test_the_syllabus_adds_up(pages):
    seen = text(pages["syllabus"])
    for exercise in all_exercises():
        assert exercise.name in seen
        assert exercise.reads in seen


def test_a_second_build_runs_and_writes_no_lab_again(book):
    before = {p: p.stat().st_mtime_ns for p in book.glob("labs/*.html")}
    assert before
    build_book.build_book(book)
    assert {p: p.stat().st_mtime_ns for p in book.glob("labs/*.html")} == before
