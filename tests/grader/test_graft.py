"""The release notebook is the truth; only answers and own cells come from a submission."""

from __future__ import annotations

import copy
import json
import os
from pathlib import Path

import pytest

from grader.graft import MAX_FILE, METADATA, NOTE_ID, OWN, Notebook, graft, graft_file, parse
from grader.markdown import harmless


def _cell(name: str, source: str, kind: str = "code", **mark) -> dict:
    cell = {"cell_type": kind, "id": name, "metadata": {}, "source": source}
    if mark:
        cell["metadata"]["nbgrader"] = {"grade_id": name, **mark}
    return cell | ({"outputs": [], "execution_count": None} if kind == "code" else {})


@pytest.fixture
def release() -> Notebook:
    """A lab with one exercise and one question."""
    cells = [
        _cell("lab-0", "# A lab", "markdown"),
        _cell("lab-1", "import numpy as np"),
        _cell("answer-f", "def f(x):\n    raise NotImplementedError", solution=True),
        _cell("check-f", "check(f)", grade=True, locked=True, points=3),
        _cell("question-why", "*Write here.*", "markdown", grade=True, solution=True, points=2),
    ]
    return {"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": cells}


def _grafted(release: Notebook, change) -> tuple[dict[str, str], list[str]]:
    """Sources by cell id, in order, and the notes, after `change` has been made to a copy of the release."""
    mine = copy.deepcopy(release)
    change(mine["cells"])
    made = graft(release, parse(json.dumps(mine).encode()))
    return {c["id"]: c["source"] for c in made.notebook["cells"]}, made.notes


def test_an_answer_comes_from_the_submission_and_a_check_does_not(release):
    def change(cells):
        cells[2]["source"], cells[3]["source"] = "def f(x):\n    return x", "pass"

    sources, notes = _grafted(release, change)
    assert sources["answer-f"] == "def f(x):\n    return x"
    assert sources["check-f"] == "check(f)"
    assert notes == []


def test_points_types_and_metadata_stay_those_of_the_release(release):
    mine = copy.deepcopy(release)
    mine["metadata"] = {"kernelspec": {"name": "bash"}}
    mine["cells"][3]["metadata"]["nbgrader"]["points"] = 1000
    mine["cells"][2]["cell_type"] = "markdown"
    made = graft(release, parse(json.dumps(mine).encode())).notebook
    assert made["cells"][3]["metadata"]["nbgrader"]["points"] == 3
    assert made["cells"][2]["cell_type"] == "code"
    assert "kernelspec" not in made["metadata"]


def test_own_cells_stay_behind_the_cell_they_followed(release):
    def change(cells):
        cells.insert(2, _cell("mine", "helper = 1"))
        cells.insert(0, _cell("first", "early = 1"))

    sources, _ = _grafted(release, change)
    own = [n for n in sources if n.startswith(OWN)]
    assert list(sources) == [
        own[0], "lab-0", "lab-1", own[1], "answer-f", "check-f", "question-why",
    ]  # fmt: skip
    assert [sources[n] for n in own] == ["early = 1", "helper = 1"]


def test_of_two_answers_the_last_that_was_changed_counts(release):
    def change(cells):
        stub = copy.deepcopy(cells[2])
        cells[2]["source"] = "def f(x):\n    return x"
        cells.append(stub)

    sources, notes = _grafted(release, change)
    assert sources["answer-f"] == "def f(x):\n    return x"
    assert "2 cells" in notes[0]


def test_an_answer_whose_cell_was_deleted_is_found_where_it_is_defined(release):
    def change(cells):
        cells[2] = _cell("mine", "y = 1\ndef f(x):\n    return y")

    sources, notes = _grafted(release, change)
    assert sources["answer-f"] == "y = 1\ndef f(x):\n    return y"
    assert not any(n.startswith(OWN) for n in sources)
    assert "found in another cell" in notes[0]


def test_a_deleted_answer_is_the_stub_and_is_said_to_be_missing(release):
    sources, notes = _grafted(release, lambda cells: cells.pop(2))
    assert "NotImplementedError" in sources["answer-f"]
    assert notes == ["The cell answer-f is missing from the submission."]


def test_an_import_added_to_the_lab_s_own_cell_is_kept_beside_it(release):
    def change(cells):
        cells[1]["source"] = "import numpy as np\nimport math"

    sources, _ = _grafted(release, change)
    assert sources["lab-1"] == "import numpy as np"
    assert "import numpy as np\nimport math" in sources.values()


def test_a_cell_that_claims_a_check_s_name_is_dropped(release):
    sources, _ = _grafted(
        release, lambda cells: cells.append(_cell("x", "1000", grade_id="check-f"))
    )
    assert "1000" not in sources.values()


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b'{"cells": [', "not JSON"),
        (b"\xff\xfe\x00", "not JSON"),
        (b"[" * 100_000, "not JSON"),
        (b"[]", "no list of cells"),
        (b'{"nbformat": 3, "cells": []}', "format 4"),
    ],
)
def test_a_file_that_is_no_notebook_gives_the_release_and_a_note(release, tmp_path, data, why):
    path = tmp_path / "lab.ipynb"
    path.write_bytes(data)
    made = graft_file(release, path, tmp_path)
    assert made.readable is False
    assert why in made.notes[0]
    assert [c["id"] for c in made.notebook["cells"]] == [
        NOTE_ID,
        *(c["id"] for c in release["cells"]),
    ]
    assert made.notebook["metadata"][METADATA]["readable"] is False
    assert path.read_bytes() == data


def test_links_pipes_folders_and_giants_are_not_opened(release, tmp_path):
    root = tmp_path / "submitted"
    root.mkdir()
    secret = tmp_path / "secret.ipynb"
    secret.write_text(json.dumps(release))
    (root / "link.ipynb").symlink_to(secret)
    (root / "loop.ipynb").symlink_to("loop.ipynb")
    os.link(secret, root / "hard.ipynb")
    os.mkfifo(root / "pipe.ipynb")
    (root / "folder.ipynb").mkdir()
    with (root / "giant.ipynb").open("wb") as file:
        file.truncate(MAX_FILE + 1)
    for name in ("link", "loop", "hard", "pipe", "folder", "giant", "missing"):
        assert not graft_file(release, root / f"{name}.ipynb", root).readable, name


def test_a_folder_that_is_a_link_is_not_followed(release, tmp_path):
    root = tmp_path / "submitted"
    (root / "ada").mkdir(parents=True)
    (root / "ada" / "lab.ipynb").write_text(json.dumps(release))
    (root / "eve").symlink_to("ada")
    assert graft_file(release, root / "ada" / "lab.ipynb", root).readable
    assert not graft_file(release, root / "eve" / "lab.ipynb", root).readable


@pytest.mark.parametrize(
    "text",
    [
        "<script>alert(1)</script>",
        "<img src=x onerror=alert(1)>",
        "[x](javascript:alert(1))",
        "[x][r]\n\n[r]: javascript:alert(1)",
        "![x](http://elsewhere.invalid/x.png)",
        "https://elsewhere.invalid",
        "<https://elsewhere.invalid>",
        "`a` <b onclick=x> $<script>$ <!-- x -->",
    ],
)
def test_prose_has_no_active_markup_on_a_page(text):
    from nbconvert.filters import markdown2html

    page = markdown2html(harmless(text))
    for sign in ("<script", "<img", "<a ", "<b ", "<!--"):
        assert sign not in page


def test_harmless_prose_is_left_alone():
    text = "Because $a < b$ and `x[0] <= 2`, *so*:\n\n1. one\n2. two & three"
    assert harmless(text) == text


def test_every_cell_of_the_real_lab_survives_a_graft_of_itself(release_course: Path):
    path = release_course / "release" / "02_heading" / "heading.ipynb"
    truth = json.loads(path.read_text())
    made = graft(truth, parse(path.read_bytes()))
    assert [c["id"] for c in made.notebook["cells"]] == [c["id"] for c in truth["cells"]]
    assert made.notes == []
