"""The page "A part of your own in ten lines": its very text is run, flies, is swapped, and keeps the laws."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pages
import pytest

from uavlab.parts.laws import broken_laws

PAGE = "your-own-part.md"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """What the page leaves behind, and what it printed."""
    old, path, modules = Path.cwd(), list(sys.path), set(sys.modules)
    try:
        os.chdir(tmp_path_factory.mktemp("page"))
        space = pages.run(PAGE)
        yield space
    finally:
        os.chdir(old)
        sys.path[:] = path
        for name in set(sys.modules) - modules:
            if name == "my_parts":
                del sys.modules[name]


def command(folder, *words):
    """The command line, in a process that finds the package as if pip had put it there."""
    return subprocess.run(
        [sys.executable, "-m", "uavlab", *words], capture_output=True, text=True, timeout=120,
        check=False, env={**os.environ, "PYTHONPATH": str(folder)}, cwd=folder,
    )  # fmt: skip


def test_the_controller_has_ten_lines():
    source = "".join(x for x in pages.cells(PAGE) if x.startswith("%%writefile"))
    tree = ast.parse("".join(f"# {x}" if x[0] == "%" else x for x in source.splitlines(True)[:35]))
    mine = next(x for x in tree.body if isinstance(x, ast.ClassDef))
    assert mine.name == "MyController"
    words = 1 if ast.get_docstring(mine) else 0
    lines = {n.lineno for x in mine.body[words:] for n in ast.walk(x) if hasattr(n, "lineno")}
    assert len(lines) <= 10


def test_the_parts_of_the_page_fly_and_the_log_says_whose_they_are(page):
    log = page["uavlab"].fly(page["scenario"]._replace(duration=6.0), page["mind"])
    assert log.exit.name == "DONE"
    assert set(log.meta["provenance"].values()) == {"my-parts 0.1"}
    assert abs(log.r[-1] - [5.0, 3.0, 4.0]).max() < 0.1


def test_each_of_them_takes_over_in_mid_flight(page):
    told = page["log"].meta["swaps"]
    assert page["log"].exit.name == "DONE"
    assert [x[1:] for x in told[3:]] == [
        ["estimator", "MyEstimator", "taken over"],
        ["controller", "MyController", "taken over"],
        ["tracker", "MyTracker", "taken over"],
    ]
    assert abs(page["log"].r[-1] - [5.0, 3.0, 4.0]).max() < 0.1


def test_they_keep_the_laws_and_the_careless_one_does_not(page):
    assert broken_laws(page["MyController"](2.0)) == []
    assert broken_laws(page["MyTracker"]()) == broken_laws(page["MyEstimator"]()) == []
    assert [x[:5] for x in broken_laws(page["Careless"]())] == ["law 1", "law 2"]


def test_the_command_line_flies_and_lists_them(page):
    folder = Path.cwd()
    said = command(folder, "list", "parts").stdout
    assert said.count("my-parts 0.1") == 3
    words = ("--controller", "MyController", "--tracker", "MyTracker", "--estimator", "MyEstimator")
    flown = command(folder, "fly", "step", *words, "--duration", "0.5", "--out", "mine")
    assert flown.returncode == 0, flown.stderr
    assert "flown by MyController=my-parts 0.1, MyTracker=my-parts 0.1" in flown.stdout


def test_the_command_line_swaps_them_from_a_file(page):
    folder = Path.cwd()
    swaps = "\n".join(
        f'[[swap]]\nt = {t}\nslot = "{slot}"\nname = "My{slot.title()}"'
        for t, slot in ((0.1, "tracker"), (0.2, "controller"), (0.3, "estimator"))
    )
    (folder / "swapped.toml").write_text(
        f'airframe = "T650"\nduration = 0.5\n[start]\nr = [0, 0, 2]\n'
        f'[mission]\nkind = "waypoints"\nstops = [{{ t = 0.0, r = [1, 0, 2] }}]\n{swaps}\n'
    )
    flown = command(folder, "fly", "swapped.toml", "--out", "swapped")
    assert flown.returncode == 0, flown.stderr
    for what in ("tracker MyTracker", "controller MyController", "estimator MyEstimator"):
        assert f"{what}: taken over" in flown.stdout
