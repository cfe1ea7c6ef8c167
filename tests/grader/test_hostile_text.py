"""Texts that were made to cost the grader time, or to do something in the browser of the person who reads them."""

import time

import browser
import pytest
from nbconvert.filters import markdown2html

from grader.magics import Translator
from grader.markdown import harmless
from grader.pages import _coloured

SECONDS = 2.0  # against half a minute and more before


@pytest.mark.parametrize(
    "source",
    ["\n" * 48000 + "x=1", " " * 90000 + "x", ("%time x\n" + "y = 2\n" * 300) * 49, "a?" * 20000],
    ids=["lines", "blanks", "magics", "questions"],
)
def test_looking_for_magics_takes_no_time(source):
    start = time.perf_counter()
    Translator().python(source)
    assert time.perf_counter() - start < SECONDS


def test_a_cell_that_ipython_stumbles_over_stays_as_it_is():
    assert Translator().python(',$?=%"""') == ',$?=%"""'


@pytest.mark.parametrize(
    "source", [" \n" * 4000 + "x=1", "a." * 12000], ids=["gaps", "one long line"]
)
def test_colouring_takes_no_time_and_loses_no_text(source):
    start = time.perf_counter()
    assert "x=1" in _coloured(source) or "a.a." in _coloured(source)
    assert time.perf_counter() - start < SECONDS


@pytest.mark.parametrize(
    "text", ["\\[" * 12000, " " * 24000 + "x", "*a" * 9000], ids=["tex", "gap", "stars"]
)
def test_laying_out_takes_no_time(text):
    start = time.perf_counter()
    markdown2html(harmless(text))
    assert time.perf_counter() - start < SECONDS


PAGE = """<!DOCTYPE html><html><body>{script}<p id="p">$\\mmlToken{{mtext}}[href="javascript:void(document.title='run')"
 style="position:fixed" id="mine"]{{see}}$ and $\\alpha^2$</p></body></html>"""


@pytest.mark.lab
def test_a_formula_cannot_link_to_a_script(tmp_path):
    from jinja2 import Environment, FileSystemLoader

    from grader.build import ROOT
    from grader.pages import offer_mathjax

    offer_mathjax(tmp_path)
    template = Environment(loader=FileSystemLoader(ROOT / "grader" / "templates" / "feedback"))
    script = template.get_template("mathjax.html.j2").module.mathjax()
    page = tmp_path / "feedback" / "ada" / "lab" / "lab.html"
    page.parent.mkdir(parents=True)
    page.write_text(PAGE.format(script=script))
    with browser.open_page(page.as_uri()) as shown:
        shown.wait_for_function("document.querySelectorAll('mjx-container').length == 2")
        assert not shown.query_selector("mjx-container a")
        assert not shown.query_selector("#mine")
        shown.click("mjx-container")
        assert shown.title() != "run"
