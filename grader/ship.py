"""What is handed out: the students' wheel, the wheel with the solutions, and the students' archive.

``python -m grader.ship`` writes all three into dist/. The same sources give the same bytes. Nothing is written when the
search of `grader.leaks` finds an answer, a hidden check or a known mistake in what students would get.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from grader.build import ROOT, build, find_labs, say
from grader.leaks import find_leaks
from uavlab.errors import BadFile, UavlabError

DIST = ROOT / "dist"
HANDOUT = Path(__file__).parent / "handout"
EPOCH = "1767225600"  # 2026-01-01: the date on every file, unless SOURCE_DATE_EPOCH says another

SOLUTIONS = """\
[build-system]
requires = ["hatchling>=1.27"]
build-backend = "hatchling.build"

[project]
name = "uavlab-solutions"
version = "{version}"
description = "The reference answers of uavlab, for instructors and for those who only fly"
requires-python = "{python}"
license = "{licence}"
dependencies = ["uavlab=={version}"]

[tool.hatch.build.targets.wheel]
packages = ["uavlab"]
"""


class Shipment(NamedTuple):
    """The three files."""

    students: Path  # wheel without solutions
    solutions: Path  # wheel with nothing else
    archive: Path  # notebooks, the first wheel, and how to start


def ship(out: Path = DIST, *, root: Path = ROOT) -> Shipment:
    """Build the wheels and the archive into `out`.

    Returns
    -------
    Shipment
        The files.

    Raises
    ------
    BadFile
        A lab or a wheel cannot be built, or something secret would get out.
    """
    with tempfile.TemporaryDirectory(prefix="uavlab-ship-") as folder:
        work = Path(folder)
        build(work / "course", find_labs(root=root))
        students = build_wheel(copy_library(root, work / "library"), work)
        solutions = build_wheel(copy_solutions(root, work / "solutions"), work)
        archive = write_archive(work / "uavlab-students.zip", work / "course", students, root)
        if found := find_leaks([students, archive]):
            raise BadFile("nothing was shipped, since it would leak:\n  " + "\n  ".join(found))
        out.mkdir(parents=True, exist_ok=True)
        return Shipment(*(_move(x, out) for x in (students, solutions, archive)))


def copy_library(root: Path, target: Path) -> Path:
    """What the students' wheel is made of, and not a file more."""
    target.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(root / name, target / name)
    skip = shutil.ignore_patterns("solutions", "__pycache__", "*.nbi", "*.nbc")
    shutil.copytree(root / "uavlab", target / "uavlab", ignore=skip)
    return target


def copy_solutions(root: Path, target: Path) -> Path:
    """A second project with the solutions alone, in the same package and of the same version."""
    project = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]
    target.mkdir()
    text = SOLUTIONS.format(
        version=project["version"], python=project["requires-python"], licence=project["license"]
    )
    (target / "pyproject.toml").write_text(text, encoding="utf-8")
    shutil.copy(root / "LICENSE", target / "LICENSE")
    skip = shutil.ignore_patterns("__pycache__")
    shutil.copytree(root / "uavlab" / "solutions", target / "uavlab" / "solutions", ignore=skip)
    return target


def build_wheel(project: Path, out: Path) -> Path:
    """The wheel of one project, the same bytes for the same files."""
    environment = {**os.environ, "SOURCE_DATE_EPOCH": os.environ.get("SOURCE_DATE_EPOCH", EPOCH)}
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(out)]
    before = set(out.glob("*.whl"))
    done = subprocess.run(
        command, cwd=project, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise BadFile(f"the wheel of {project.name} was not built:\n{done.stdout}{done.stderr}")
    return (set(out.glob("*.whl")) - before).pop()


def write_archive(path: Path, course: Path, wheel: Path, root: Path) -> Path:
    """Zip the released notebooks, the students' wheel, the tested versions, and how to start."""
    top = path.stem
    files = {f"{top}/{p.name}": p.read_bytes() for p in HANDOUT.iterdir() if p.is_file()}
    files[f"{top}/{wheel.name}"] = wheel.read_bytes()
    files[f"{top}/constraints.txt"] = tested_versions(root / "requirements.lock").encode()
    release = course / "release"
    for notebook in release.rglob("*.ipynb"):
        files[f"{top}/{notebook.relative_to(release).as_posix()}"] = notebook.read_bytes()
    date = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", EPOCH)))[:6]
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            item = zipfile.ZipInfo(name, date)
            item.compress_type, item.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(item, files[name])
    return path


def tested_versions(lock: Path) -> str:
    """The lock as constraints for pip: ``name==version`` with its markers, hashes left out."""
    lines = re.findall(r"^([\w.-]+==[^\\\n]+)", lock.read_text(encoding="utf-8"), re.MULTILINE)
    return "".join(f"{line.strip()}\n" for line in lines)


def _move(file: Path, out: Path) -> Path:
    """Into `out`, whole or not at all, in place of other versions of the same thing."""
    part = out / f"{file.name}.part"
    shutil.copyfile(file, part)
    for old in out.glob(f"{file.name.split('-')[0]}-*{file.suffix}"):
        if file.suffix == ".whl":
            old.unlink()
    return part.replace(out / file.name)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; 0 if all went well, 2 if the input was wrong."""
    parser = argparse.ArgumentParser(prog="python -m grader.ship", description=__doc__)
    parser.add_argument("--out", type=Path, default=DIST, help="where the three files go")
    options = parser.parse_args(arguments)
    try:
        shipment = ship(options.out)
    except UavlabError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for path in shipment:
        say(f"{path} ({path.stat().st_size / 1024:.0f} kB)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
