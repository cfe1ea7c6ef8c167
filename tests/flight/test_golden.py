"""Golden flights: the numbers of five flights, kept in golden.toml, so that physics cannot drift unseen.

``make golden`` writes them anew; the difference is read by a person.
"""

import sys
import tomllib
from pathlib import Path

import pytest

import uavlab
from uavlab.parts.controllers import HeadingController

FILE = Path(__file__).with_name("golden.toml")
SCENARIOS = ("takeoff", "step", "circle", "lemniscate", "gusts")
TOLERANCE = 0.02  # of each number, and at least 1e-3 of its unit


def flown(name: str) -> dict[str, float]:
    scenario = uavlab.scenarios.load(name)
    mind = uavlab.stack(scenario.airframe, HeadingController)
    return uavlab.summary(uavlab.fly(scenario, mind, seed=1))


def write() -> None:
    lines = ["# Written by `make golden`: the heading controller with reference answers, seed 1."]
    for name in SCENARIOS:
        lines += ["", f"[{name}]"]
        lines += [f'"{key}" = {value:.4f}' for key, value in flown(name).items()]
    FILE.write_text("\n".join(lines) + "\n")


@pytest.mark.flight
@pytest.mark.parametrize("name", SCENARIOS)
def test_a_golden_flight_keeps_its_numbers(name):
    golden = tomllib.loads(FILE.read_text())[name]
    assert flown(name) == pytest.approx(golden, rel=TOLERANCE, abs=1e-3)


if __name__ == "__main__":
    write()
    sys.stdout.write(FILE.read_text())
