"""``make demo``: two labs from source to grade, and what was answered seen flying in 3D.

Builds and releases both labs, hands in what a sample class of seven would, grades it in the sandbox, writes
feedback and grades.csv, flies a right and a wrong answer to lab 02, and says where everything lies.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from grader import classroom, mark
from grader.build import ROOT, build, find_labs
from grader.grade import grade
from grader.graft import graft_file
from grader.remote import Remote
from grader.sandbox import Limits, SandboxMissing
from grader.table import class_table
from uavlab import Log, fly, scenarios, stack, summary, views
from uavlab.errors import UavlabError
from uavlab.parts.controllers import HeadingController
from uavlab.scenarios import Scenario

DEMO = ROOT / "build" / "demo"
LABS = ("dynamics", "heading")
FLYERS = ("ada", "ben")  # right, and with wrong signs
PARTS = ("attitude_with_heading", "yaw_rate_from_heading_rate", "parasitic_yaw_rate")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demo; 0 if all went well, 2 if it could not."""
    parser = argparse.ArgumentParser(prog="python -m grader.demo", description=__doc__)
    parser.add_argument("--to", type=Path, default=DEMO, help="where it is written, made anew")
    to = parser.parse_args(arguments).to.resolve()
    start = time.perf_counter()
    try:
        course, flights = to / "course", to / "flights"
        shutil.rmtree(to, ignore_errors=True)
        step(1, "build both labs and release them")
        labs = find_labs(LABS)
        build(course, labs, seed=1)
        step(2, f"hand in what a class of {len(classroom.CLASS)} answers")
        for lab in labs:
            classroom.hand_in(course, lab.name, lab.stem)
        for student in classroom.CLASS:
            print(f"      {student.name:5s} {student.story}")
        step(3, "grade in the sandbox, write feedback and grades.csv")
        tables = [(lab.name, class_table(grade(course, lab.name))) for lab in labs]
        step(4, "fly a right and a wrong answer to lab 02, still in the sandbox")
        shown = show_flights(course, flights)
    except (UavlabError, SandboxMissing) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for name, table in tables:
        print(f"\n\033[1m{name}\033[0m\n{table}")
    print_where(course, shown)
    print(f"\ndone in {time.perf_counter() - start:.0f} s")
    return 0


def step(number: int, what: str) -> None:
    """One line of progress."""
    print(f"\n\033[1m[{number}/4] {what}\033[0m", flush=True)


def show_flights(course: Path, folder: Path) -> list[Path]:
    """Fly each of `FLYERS` around the circle; write logs, plots and one replay with both."""
    folder.mkdir(parents=True, exist_ok=True)
    scenario = scenarios.load("circle")
    logs = {name: fly_answers(course, name, scenario) for name in FLYERS}
    paths = [log.save(folder / f"{name}.npz") for name, log in logs.items()]
    for name, log in logs.items():
        path = folder / f"{name}.png"
        views.plot_flight(log).savefig(path, dpi=100)
        paths.append(path)
    path = folder / "both.png"
    views.plot_compare(logs).savefig(path, dpi=100)
    return [views.replay(logs, folder / "both.html"), path, *paths]


def fly_answers(course: Path, student: str, scenario: Scenario) -> Log:
    """Fly a scenario with a student's answers to lab 02: the simulator here, the answers in the box."""
    release = course / "release" / "02_heading" / "heading.ipynb"
    submitted = course / "submitted"
    path = submitted / student / "02_heading" / "heading.ipynb"
    grafted = graft_file(json.loads(release.read_text()), path, submitted)
    with Remote(mark.steps_of(grafted.notebook), Limits()) as remote:
        mine = {name: remote.answer(name) for name in PARTS}
        log = fly(scenario, stack(scenario.airframe, HeadingController, mine=mine))
    found = summary(log)
    print(
        f"      {student:5s} {log.exit.name}: heading error "
        f"{found['heading error, worst [deg]']:.0f}° at worst, position error "
        f"{found['position error, mean [m]']:.2f} m in the mean"
    )
    return log


def print_where(course: Path, shown: Sequence[Path]) -> None:
    """Where everything lies."""
    replay, *rest = shown
    print("\n3D replay (open it in a browser)")
    print(f"  {replay}")
    print("plots and logs")
    for path in rest:
        print(f"  {path}")
    print("feedback pages")
    for path in sorted((course / "feedback").glob("*/*/*.html")):
        print(f"  {path}")
    print("grades")
    print(f"  {course / 'grades.csv'}")


if __name__ == "__main__":
    sys.exit(main())
