"""What is handed out, tried where the checkout cannot be seen: it imports, flies, and has no answers in it."""

import json
import re
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

from grader import ship
from grader.build import ROOT
from grader.leaks import find_leaks, members
from uavlab.errors import BadFile

pytestmark = pytest.mark.slow

FLY = """
import importlib.util, json, sys
import uavlab
log = uavlab.fly(uavlab.scenarios.load("hover"))
from uavlab.parts.controllers import HeadingController
from uavlab.flight.fill import fill
print(json.dumps({
    "where": uavlab.__file__,
    "grader": importlib.util.find_spec("grader") is not None,
    "solutions": importlib.util.find_spec("uavlab.solutions") is not None,
    "exit": log.exit.name,
    "off": float(abs(log.r[-1] - log.r_d[-1]).max()),
    "flown_by": sorted(set(log.meta["provenance"].values())),
    "filled_by": sorted(set(fill(HeadingController, mass=3.5).provenance.values())),
}))
"""


@pytest.fixture(scope="module")
def shipment(tmp_path_factory):
    return ship.ship(tmp_path_factory.mktemp("dist"))


class Clean:
    """An environment with the locked packages and without the checkout."""

    def __init__(self, folder):
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
        self.folder, self.python = folder, folder / "bin" / "python"
        # A line in a .pth adds the packages of this environment, and not what their own .pth files lead to.
        site = next(folder.glob("lib/python*/site-packages"))
        (site / "locked.pth").write_text(sysconfig.get_path("purelib") + "\n")

    def pip(self, *arguments):
        command = [shutil.which("uv", path=Path(sys.executable).parent), "pip", *arguments]
        command += ["--python", str(self.python), "--quiet"]
        subprocess.run(command, check=True)

    def run(self, source):
        done = subprocess.run(
            [str(self.python), "-c", source],
            cwd=self.folder,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def clean(shipment, tmp_path_factory):
    environment = Clean(tmp_path_factory.mktemp("clean") / "venv")
    environment.pip("install", "--no-deps", str(shipment.students))
    return environment


@pytest.mark.flight
def test_students_fly_on_stand_ins_and_the_second_wheel_flips_to_the_references(clean, shipment):
    alone = clean.run(FLY)
    assert alone["where"].startswith(str(clean.folder))
    assert not alone["grader"]
    assert not alone["solutions"]
    assert (alone["exit"], alone["flown_by"]) == ("DONE", ["stand-in"])
    assert alone["off"] < 0.5
    assert alone["filled_by"] == ["stand-in"]

    clean.pip("install", "--no-deps", str(shipment.solutions))
    both = clean.run(FLY)
    assert both["solutions"]
    assert both["filled_by"] == ["reference"]

    clean.pip("uninstall", "uavlab-solutions")
    again = clean.run(FLY)
    assert not again["solutions"]
    assert again["filled_by"] == ["stand-in"]


def test_every_shipped_module_imports_without_the_solutions(clean):
    walk = """
import importlib, json, pkgutil, uavlab
names = [m.name for m in pkgutil.walk_packages(uavlab.__path__, "uavlab.")]
[importlib.import_module(n) for n in names if not n.endswith("__main__")]
print(json.dumps(names))
"""
    names = clean.run(walk)
    assert "uavlab.plant.kernel" in names
    assert not any(n.startswith("uavlab.solutions") for n in names)


def test_students_get_no_answer_hidden_check_or_known_mistake(shipment):
    assert find_leaks([shipment.students, shipment.archive]) == []
    # The same search finds the solutions where they are meant to be.
    assert any("canary-" in s for s in find_leaks([shipment.solutions]))


def test_the_archive_holds_the_released_labs_the_wheel_and_how_to_start(shipment):
    names = {n.split("uavlab-students/")[1] for n, _ in members("a", shipment.archive.read_bytes())}
    direct = set(zipfile.ZipFile(shipment.archive).namelist())
    for name in ("README.md", "start.py", "constraints.txt", "01_dynamics/dynamics.ipynb",
                 "02_heading/heading.ipynb", shipment.students.name):  # fmt: skip
        assert f"uavlab-students/{name}" in direct
    assert not any("solutions" in n for n in names)
    # The wheel inside is the wheel beside it.
    with zipfile.ZipFile(shipment.archive) as archive:
        inside = archive.read(f"uavlab-students/{shipment.students.name}")
        versions = archive.read("uavlab-students/constraints.txt").decode()
    assert inside == shipment.students.read_bytes()
    assert re.search(r"^numpy==[\d.]+", versions, re.MULTILINE)
    assert "sha256" not in versions


def test_the_solutions_wheel_holds_the_solutions_alone_and_asks_for_the_same_version(shipment):
    with zipfile.ZipFile(shipment.solutions) as wheel:
        code = [n for n in wheel.namelist() if ".dist-info/" not in n]
        meta = next(n for n in wheel.namelist() if n.endswith("METADATA"))
        said = wheel.read(meta).decode()
    assert code
    assert all(n.startswith("uavlab/solutions/") for n in code)
    version = shipment.students.name.split("-")[1]
    assert f"Requires-Dist: uavlab=={version}" in said


def test_nothing_is_written_when_it_would_leak(tmp_path, monkeypatch):
    monkeypatch.setattr(ship, "find_leaks", lambda files: ["a file carries a canary"])
    with pytest.raises(BadFile, match=r"nothing was shipped(.|\n)*a file carries a canary"):
        ship.ship(tmp_path / "dist")
    assert not (tmp_path / "dist").exists()


@pytest.fixture(scope="module")
def commanded(tmp_path_factory):
    """The folder that the command wrote, and what it said."""
    folder = tmp_path_factory.mktemp("commanded")
    done = subprocess.run(
        [sys.executable, "-m", "grader.ship", "--out", str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return folder, done.stdout


def test_the_command_prints_three_files(commanded):
    folder, said = commanded
    assert len(list(folder.iterdir())) == 3
    assert "uavlab-students.zip" in said


def test_the_same_sources_give_the_same_bytes(shipment, commanded):
    for one in shipment:
        assert one.read_bytes() == (commanded[0] / one.name).read_bytes()
