"""``make bench``: flights beside RotorPy and MuJoCo, controllers, filters and programmes beside those of others."""

from __future__ import annotations

import argparse

from benchmarks import control, filters, mpc, ours, peers
from benchmarks.rounds import Run, compare


def contestants() -> dict[str, tuple[Run, float]]:
    """Name → (what flies, simulated seconds of one round: about half a CPU second)."""
    return {
        "uavlab fly(): sensors, estimator, tracker, controller, log; 1 kHz": (ours.whole(), 30),
        "uavlab lean loop, numpy stand-in at 100 Hz, 1 kHz": (ours.lean(), 30),
        "uavlab lean loop, numpy stand-in at 100 Hz, 100 Hz": (ours.lean(100.0), 30),
        "uavlab compiled plant alone, 1 kHz": (ours.plant_alone(), 300),
        "RotorPy Environment.run, 100 Hz": (peers.rotorpy_run(), 2),
        "RotorPy lean loop, 100 Hz": (peers.rotorpy_lean(100.0), 2),
        "RotorPy lean loop, 1 kHz": (peers.rotorpy_lean(1000.0), 0.5),
        "MuJoCo RK4 1 kHz, rate loop at 1 kHz in Python": (peers.mujoco(1000.0), 8),
        "MuJoCo RK4 1 kHz, rate loop at 100 Hz in Python": (peers.mujoco(100.0), 15),
    }


def main() -> None:
    """One report, or all of them."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("what", nargs="?", choices=("all", *REPORTS), default="all")
    parser.add_argument("--rounds", type=int, default=7)
    asked = parser.parse_args()
    for name, report in REPORTS.items():
        if asked.what in {"all", name}:
            report(asked.rounds)


def flights(rounds: int) -> None:
    """Whole flights and lean loops beside other simulators."""
    pairs = [(0, 4), (1, 6), (1, 5), (2, 5), (0, 6), (0, 5), (1, 7), (1, 8), (0, 7), (0, 8)]
    compare(contestants(), pairs, rounds)


REPORTS = {
    "flights": flights,
    "control": control.report,
    "filters": filters.report,
    "mpc": mpc.report,
}


if __name__ == "__main__":
    main()
