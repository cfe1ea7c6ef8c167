"""The rules of the house that no other tool holds."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import uavlab

ROOT = Path(__file__).parents[1]
SOURCES = sorted((ROOT / "uavlab").rglob("*.py")) + sorted((ROOT / "grader").glob("*.py"))


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_file_is_one_noun_of_at_most_350_lines(path):
    assert len(path.read_text().splitlines()) <= 350


def longest(tree: ast.AST) -> int:
    """Most code lines of a function: its lines without its docstring."""
    most = 0
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            doc = node.body[0] if ast.get_docstring(node) else None
            words = doc.end_lineno - doc.lineno + 1 if doc else 0
            most = max(most, node.end_lineno - node.lineno + 1 - words)
    return most


@pytest.mark.parametrize("path", SOURCES, ids=lambda p: str(p.relative_to(ROOT)))
def test_no_function_is_longer_than_60_lines_of_code(path):
    assert longest(ast.parse(path.read_text())) <= 60


def test_every_name_that_uavlab_offers_is_there():
    assert len(uavlab.__all__) <= 25
    for name in uavlab.__all__:
        assert getattr(uavlab, name) is not None
    with pytest.raises(AttributeError, match="flyy"):
        uavlab.flyy  # noqa: B018


@pytest.mark.parametrize(
    "said", ["import uavlab", "import uavlab; uavlab.check, uavlab.State, uavlab.stack"]
)
def test_importing_uavlab_waits_with_everything_heavy(said):
    heavy = "numba scipy matplotlib meshcat pooch pyulog"
    probe = f"{said}; import sys; print([m for m in '{heavy}'.split() if m in sys.modules])"
    out = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_no_notebook_is_committed_and_no_large_file():
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    files = [ROOT / f for f in listed.stdout.split("\0") if f]
    assert not [f for f in files if f.suffix == ".ipynb"]
    large = [f.name for f in files if f.is_file() and f.stat().st_size > 300_000]
    assert not large


def test_what_a_changed_library_means_is_in_the_changelog():
    text = (ROOT / "CHANGELOG.md").read_text()
    for audience in ("### Students", "### Instructors", "### Developers"):
        assert audience in text


def public_functions():
    """(file, node) of every public function and method; of the answers, the exercises speak."""
    for path in sorted((ROOT / "uavlab").rglob("*.py")):
        if path.parent.name == "solutions":
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
                yield path, node


ARRAYS = {"Vec3", "Mat3", "Quat", "Array"}


def test_a_public_function_that_returns_an_array_says_its_unit_or_frame_or_shape():
    silent = []
    for path, node in public_functions():
        returns = ast.unparse(node.returns) if node.returns else ""
        doc = (ast.get_docstring(node) or "").lower()
        told = any(mark in doc for mark in ("[", "(3", "(n", "(4", "shape", "body", "world"))
        if returns in ARRAYS and doc and not told:
            silent.append(f"{path.relative_to(ROOT)}:{node.lineno} {node.name}")
    assert not silent
