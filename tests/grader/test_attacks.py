"""Every attack in one class with honest students: nobody gains, nobody loses, nothing is touched."""

from __future__ import annotations

import ast
import hashlib
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple

import psutil
import pytest

from grader import sandbox
from grader.attacks import CLASSES, Attack, Target, attacks, filled
from grader.graft import graft, parse
from grader.mark import Options, mark

ROOT = Path(__file__).resolve().parents[2]
STEM, LAB = "heading", "02_heading"
HONEST = ("honest1", "honest2", "classmate")
TOKEN = "canary_environment_5d1f"
MEMORY = 1531  # MiB; marks the processes of this very class among those of the machine

pytestmark = [pytest.mark.lab, pytest.mark.slow]


class Graded(NamedTuple):
    """What is left when the class has been graded."""

    course: Path
    home: Path
    said: str
    code: int
    before: dict[str, str]  # checksums
    scores: dict[str, dict[str, float]]  # student → grade id → points


def test_every_class_of_attack_has_several():
    counts = Counter(x.kind for x in attacks())
    assert set(counts) == set(CLASSES)
    assert min(counts.values()) >= 2
    assert sum(counts.values()) >= 45
    assert all(x.story for x in attacks())


@pytest.fixture(scope="module")
def graded(tmp_path_factory, isolation, release_course, release, right) -> Graded:
    """The class, graded by the command line in a process of its own."""
    place = tmp_path_factory.mktemp("class")
    course, home = place / "course", place / "home"
    shutil.copytree(release_course, course)
    home.mkdir()
    (home / "canary.txt").write_text("canary_home")
    with (course / "nbgrader_config.py").open("a") as config:
        config.write("c.Judge.call_seconds = 0.5\nc.Judge.cell_seconds = 2.0\n")
        config.write(f"c.Judge.submission_seconds = 5.0\nc.Judge.memory_mb = {MEMORY}\n")
    for name in HONEST:
        folder = _folder(course, name)
        (folder / f"{STEM}.ipynb").write_text(
            json.dumps(filled(Target(release, right, course, folder, STEM), right))
        )
    for one in attacks():
        _hand_in(one, Target(release, right, course, _folder(course, one.name), STEM))
    before = _checksums(course, home)
    command = [sys.executable, "-m", "grader.grade", str(course), LAB, "--jobs", "2"]
    environment = {**os.environ, "HOME": str(home), "SECRET_TOKEN": TOKEN}
    run = subprocess.run(
        command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=600, check=False
    )
    return Graded(course, home, run.stdout + run.stderr, run.returncode, before, _scores(course))


@pytest.mark.parametrize("one", attacks(), ids=lambda x: f"{x.kind}-{x.name}")
def test_an_attack_gets_what_its_code_deserves(graded: Graded, one: Attack):
    checks = {k: v for k, v in graded.scores[one.name].items() if k.startswith("check-")}
    deserved = graded.scores["honest1"] if one.deserves else dict.fromkeys(checks, 0.0)
    assert checks == {k: deserved[k] for k in checks}


@pytest.mark.parametrize("name", HONEST)
def test_an_honest_student_among_attackers_gets_full_marks(graded: Graded, name: str):
    checks = {k: v for k, v in graded.scores[name].items() if k.startswith("check-")}
    assert len(checks) == 6
    assert sum(checks.values()) == 21.0


def test_every_submission_is_graded_and_the_run_says_so(graded: Graded):
    assert graded.code == 0, graded.said
    assert "Traceback" not in graded.said
    assert set(graded.scores) == {*HONEST, *(x.name for x in attacks())}
    for student in graded.scores:
        assert (graded.course / "feedback" / student / LAB / f"{STEM}.html").is_file(), student


def test_no_attack_changes_a_file_outside(graded: Graded):
    assert _checksums(graded.course, graded.home) == graded.before
    assert sorted(p.name for p in graded.home.iterdir() if p.name != ".cache") == ["canary.txt"]
    assert not any(Path(p, "pwned").exists() for p in ("/tmp", "/usr/lib", ROOT, Path.home()))


def test_the_gradebook_is_intact(graded: Graded):
    with sqlite3.connect(graded.course / "gradebook.db") as base:
        assert base.execute("pragma integrity_check").fetchone() == ("ok",)
        (most,) = base.execute("select max(auto_score) from grade").fetchone()
        (few,) = base.execute("select count(*) from assignment").fetchone()
    assert most <= 5.0
    assert few == 1


def test_no_process_is_left_over(graded: Graded):
    sign = f'"RLIMIT_AS": {MEMORY * 2**20}'
    left = [
        p for p in psutil.process_iter(["cmdline"]) if sign in " ".join(p.info["cmdline"] or [])
    ]
    assert left == []


def test_no_hidden_check_mutant_or_solution_leaks(graded: Graded, right: dict[str, str]):
    secret = _lines("hidden") | _lines("mutants")
    public = _lines_of((ROOT / "uavlab" / "exercises" / f"{STEM}.py").read_text())
    public |= {line.strip() for text in right.values() for line in text.splitlines()}
    _nowhere(secret - public, graded, [*(x.name for x in attacks()), *HONEST])
    cheats = [x.name for x in attacks() if not x.deserves and x.name != "cut_in_half"]
    _nowhere(_solution_lines(), graded, cheats)


def test_nothing_of_the_machine_or_of_the_judge_leaks(graded: Graded):
    _nowhere({TOKEN, "canary_home", "SQLite format 3", "root:x:0"}, graded, list(graded.scores))
    for name in ("text_of_the_inputs", "kind_of_the_error"):
        checks = [c for c in _cells(graded, name) if c["id"].startswith("check-")]
        assert not re.search(r"canary|Leak\d", json.dumps([c["outputs"] for c in checks]))


def test_nothing_of_a_student_runs_in_the_grader_s_browser(graded: Graded):
    clean = _active(graded, "honest1")
    for name in ("prose", "outputs", "names_and_code"):
        extra = _active(graded, name) - clean
        assert not extra, (name, extra)


def test_the_attack_would_succeed_if_the_solutions_were_not_covered(
    isolation, release, right, monkeypatch, tmp_path
):
    """So that a gain of zero means something."""
    one = next(x for x in attacks() if x.name == "import_solutions")
    data = one.make(Target(release, right, tmp_path, tmp_path, STEM))
    notebook = graft(release, parse(data)).notebook
    assert _gain(notebook) == 0.0
    monkeypatch.setattr(sandbox, "_mask", list)
    assert _gain(notebook) == 4.0


def _gain(notebook: dict) -> float:
    return sum(x["score"] for x in mark(notebook, Options()).checks.values())


# Helpers ----------------------------------------------------------------------------------------------


def _folder(course: Path, student: str) -> Path:
    folder = course / "submitted" / student / LAB
    folder.mkdir(parents=True)
    return folder


def _hand_in(one: Attack, target: Target) -> None:
    data = one.make(target)
    if data is not None:
        target.file.write_bytes(data)


def _checksums(course: Path, home: Path) -> dict[str, str]:
    """Of everything that grading must not change: what was handed out and in, the home, the solutions."""
    folders = [
        course / "source",
        course / "release",
        course / "submitted",
        home,
        ROOT / "uavlab" / "solutions",
    ]
    found = {}
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            if any(part in ("__pycache__", ".cache") for part in path.parts):
                continue
            found[str(path)] = _fingerprint(path)
    return found


def _fingerprint(path: Path) -> str:
    status = path.lstat()
    kind = f"{status.st_mode} {status.st_size} {status.st_mtime_ns if not path.is_dir() else ''}"
    if path.is_symlink() or not path.is_file() or status.st_size > 10**8:
        return kind
    return kind + hashlib.sha256(path.read_bytes()).hexdigest()


def _scores(course: Path) -> dict[str, dict[str, float]]:
    from nbgrader.api import Gradebook

    with Gradebook(f"sqlite:///{course}/gradebook.db") as book:
        return {
            s.student.id: {g.name: g.score for n in s.notebooks for g in n.grades}
            for s in book.assignment_submissions(LAB)
        }


class _Active(HTMLParser):
    """Collects what a browser would run, load or follow."""

    def __init__(self) -> None:
        super().__init__()
        self.found: Counter[str] = Counter()

    def handle_starttag(self, tag, attrs):
        if tag in (
            "script",
            "iframe",
            "img",
            "svg",
            "base",
            "style",
            "object",
            "embed",
            "details",
            "table",
            "link",
        ):
            self.found[tag] += 1
        for name, value in attrs:
            own = name in ("href", "src", "srcdoc", "background") and not (value or "").startswith(
                "#"
            )
            if own or name.startswith("on"):
                self.found[f"{tag} {name}={value}"] += 1


def _active(graded: Graded, student: str) -> Counter[str]:
    parser = _Active()
    parser.feed((graded.course / "feedback" / student / LAB / f"{STEM}.html").read_text())
    return parser.found


def _cells(graded: Graded, student: str) -> list[dict]:
    path = graded.course / "autograded" / student / LAB / f"{STEM}.ipynb"
    return json.loads(path.read_text())["cells"]


def _lines(room: str) -> set[str]:
    return _lines_of((ROOT / "grader" / room / f"{STEM}.py").read_text())


def _solution_lines() -> set[str]:
    return _lines_of((ROOT / "uavlab" / "solutions" / f"{STEM}.py").read_text())


def _lines_of(source: str) -> set[str]:
    """Lines of code that say something; no prose: the sentences of checks are meant to be read."""
    prose = {
        n
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        for n in range(node.lineno, (node.end_lineno or node.lineno) + 1)
    }
    lines = enumerate(source.splitlines(), 1)
    code = (x.strip() for i, x in lines if i not in prose)
    return {x for x in code if len(x) >= 30 and not x.startswith(("#", "import ", "from ", "def "))}


def _nowhere(secrets: set[str], graded: Graded, students: list[str]) -> None:
    """None of these texts is in what was released, graded or sent back."""
    assert secrets
    folders = [graded.course / "release"]
    folders += [graded.course / step / s for s in students for step in ("autograded", "feedback")]
    for folder in folders:
        for path in (p for p in folder.rglob("*") if p.is_file()):
            text = path.read_bytes().decode(errors="replace")
            text += (
                json.dumps(text)
                if path.suffix != ".ipynb"
                else "\n".join(_strings(json.loads(text)))
            )
            assert not [s for s in secrets if s in text], path


def _strings(node: object) -> list[str]:
    if isinstance(node, str):
        return [node]
    if isinstance(node, dict):
        return [x for pair in node.items() for part in pair for x in _strings(part)]
    return [x for part in node for x in _strings(part)] if isinstance(node, list) else []
