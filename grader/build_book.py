"""Build the book: pages, labs as pages with stubs instead of answers, and the syllabus with its points.

Sphinx runs in ``build/book-src``, where everything is put together. A file there changes only when its text does, so a
second build runs what changed and no more.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from grader.build import ROOT, find_labs, lab_paths
from grader.build_campaigns import campaigns_page
from grader.build_lab import Cell, Lab
from grader.build_reproductions import reproductions_page
from uavlab.errors import BadFile
from uavlab.exercises import STEMS, Exercise

FRONT_MATTER = (
    "---\nfile_format: mystnb\nkernelspec:\n  display_name: Python 3\n  name: python3\n---\n"
)
PAGES = {".md", ".py", ".bib", ".css", ".svg"}
PICTURES = {".png"}


def build_book(out: Path = ROOT / "build" / "book", *, root: Path = ROOT) -> Path:
    """Write the book as web pages that ask the network for nothing.

    Parameters
    ----------
    out : Path
        Where the pages go.
    root : Path
        The checkout.

    Returns
    -------
    Path
        Its first page.

    Raises
    ------
    BadFile
        A lab does not hold together, or Sphinx warned of something.
    """
    stage = out.with_name(out.name + "-src")
    labs = find_labs(root=root) if lab_paths(root) else []
    write_pages(stage, labs, root)
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html"]
    doctrees = out.with_name(out.name + "-doctrees")
    # A backend that is set would keep the labs' pictures out of their pages: the kernel must choose its own.
    around = {k: v for k, v in os.environ.items() if k != "MPLBACKEND"}
    if subprocess.call([*command, "-d", str(doctrees), str(stage), str(out)], env=around):
        # Else the next run finds nothing changed, says nothing, and passes.
        shutil.rmtree(doctrees, ignore_errors=True)
        raise BadFile(
            f"the book was not built; what Sphinx says above names file and line in {stage}."
        )
    _take_along(stage / "labs", out / "labs")
    return out / "index.html"


def write_pages(stage: Path, labs: Sequence[Lab], root: Path) -> None:
    """Put every source of the book below `stage`; rewrite what changed, remove what is gone."""
    book = root / "book"
    pages = {
        str(p.relative_to(book)): p.read_text(encoding="utf-8")
        for p in sorted(book.rglob("*"))
        if p.suffix in PAGES and "__pycache__" not in p.parts
    }
    digest = library_digest(root)
    pages |= {f"labs/{lab.stem}.md": lab_page(lab, digest) for lab in labs}
    pages["contributing.md"] = (root / "CONTRIBUTING.md").read_text(encoding="utf-8")
    pages["syllabus.md"] = syllabus((root / "course" / "syllabus.md").read_text("utf-8"), labs)
    page = pages["reproductions.md"]
    pages["reproductions.md"] = reproductions_page(page, book / "reproductions")
    pages["campaigns.md"] = campaigns_page(pages["campaigns.md"], book / "campaigns")
    order = [name for stem in STEMS for name in (stem, f"labs/{stem}") if f"{name}.md" in pages]
    pages["index.md"] = pages["index.md"].replace("@chapters@", "\n".join(order))
    for name, text in pages.items():
        _write(stage / name, text)
    for picture in (p for p in book.rglob("*") if p.suffix in PICTURES):
        _copy(picture, stage / picture.relative_to(book))
    for old in stage.rglob("*.md"):
        if str(old.relative_to(stage)) not in pages:
            old.unlink()


def lab_page(lab: Lab, digest: str = "") -> str:
    """The lab as a page of the book: stubs instead of answers, no rubrics.

    Parameters
    ----------
    lab : Lab
        As `find_labs` reads it.
    digest : str
        Of the library; a page is run again when it changes.

    Returns
    -------
    str
        MyST Markdown. Hidden cells take the reference answers in, so that the pictures are those of a right answer.
    """
    parts = [FRONT_MATTER, _code(f"# uavlab {digest}", "remove-cell")]
    parts += [part for cell in lab.cells for part in _page_parts(lab, cell)]
    return "\n".join(parts)


def _page_parts(lab: Lab, cell: Cell) -> Iterator[str]:
    if cell.kind == "text":
        yield f"+++\n\n{cell.source}\n"
    elif cell.kind == "code":
        yield _code(cell.source, *cell.tags)
    elif cell.kind == "exercise":
        yield _card(lab.exercises[cell.name])
        yield _code(f"from uavlab.solutions.{lab.stem} import {cell.name}", "remove-cell")
    elif cell.kind == "question":
        yield f"+++\n\n:::{{admonition}} Question ({_points(cell.points)})\n{cell.source}\n:::\n"


def _card(exercise: Exercise) -> str:
    stub = exercise.source().rstrip("\n").rpartition("\n")[0]
    return (
        f"+++\n\n::::{{exercise}} {exercise.name}: {_points(exercise.points)}, {exercise.reads}\n"
        f":label: exercise-{exercise.name}\n:nonumber:\n\n```python\n{stub}\n```\n::::\n"
    )


def _code(source: str, *tags: str) -> str:
    head = f":tags: [{', '.join(tags)}]\n" if tags else ""
    return f"```{{code-cell}} ipython3\n{head}{source}\n```\n"


def syllabus(prose: str, labs: Sequence[Lab]) -> str:
    """The syllabus with the exercises, their reading and their points in place of its mark."""
    mark = "<!-- exercises -->"
    if prose.count(mark) != 1:
        raise BadFile(f"course/syllabus.md must have the line {mark!r} once, where the tables go.")
    return prose.replace(mark, "\n".join(_table(lab) for lab in labs))


def _table(lab: Lab) -> str:
    title = next((c.source for c in lab.cells if c.source.startswith("# ")), f"# {lab.name}")
    rows = [
        (f"[`{x.name}`](exercise-{x.name})", x.reads, f"{x.points:g}")
        for x in lab.exercises.values()
    ]
    rows += [
        (f"question: {c.name.replace('-', ' ')}", "", f"{c.points:g}")
        for c in lab.cells
        if c.kind == "question"
    ]
    total = sum(float(row[2]) for row in rows)
    heading = title.splitlines()[0].removeprefix("# ")
    lines = [f"## {heading}", "", f"[The lab](labs/{lab.stem}.md), {_points(total)}.", ""]
    lines += ["| exercise | reading | points |", "|---|---|---:|"]
    return "\n".join([*lines, *(f"| {' | '.join(row)} |" for row in rows), ""])


def _points(points: float) -> str:
    return f"{points:g} point{'s' * (points != 1)}"


def library_digest(root: Path) -> str:
    """A short hash of everything that a lab's outputs depend on."""
    files = sorted(p for p in (root / "uavlab").rglob("*") if p.suffix in {".py", ".toml", ".html"})
    return hashlib.sha256(b"".join(p.read_bytes() for p in files)).hexdigest()[:16]


def _write(path: Path, text: str) -> None:
    if path.is_file() and path.read_text(encoding="utf-8") == text:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def _copy(path: Path, target: Path) -> None:
    if not target.is_file() or target.read_bytes() != path.read_bytes():
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)


def _take_along(labs: Path, out: Path) -> None:
    """Copy what the labs wrote beside themselves (3D replays and their script), which pages show in frames."""
    shown = "".join(p.read_text(encoding="utf-8") for p in out.glob("*.html"))
    for path in [p for p in labs.rglob("*") if p.suffix in {".html", ".js", ".png"}]:
        target = out / path.relative_to(labs)
        if path.suffix != ".js" and path.stem not in shown:  # of a flight that looked otherwise
            path.unlink()
            target.unlink(missing_ok=True)
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
