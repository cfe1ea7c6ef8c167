"""``make bench``: flights beside RotorPy and MuJoCo, filters beside filterpy and ahrs, in rounds of one run."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from statistics import median

from tqdm import tqdm

from benchmarks import filters, ours, peers

Run = Callable[[float], float]


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


def speed(run: Run, seconds: float) -> float:
    """Simulated seconds per CPU second of one run."""
    start = time.process_time()
    run(seconds)
    return seconds / (time.process_time() - start)


def main() -> None:
    """Flights, filters, or both."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("what", nargs="?", choices=("all", "flights", "filters"), default="all")
    parser.add_argument("--rounds", type=int, default=7)
    asked = parser.parse_args()
    if asked.what != "filters":
        flights(asked.rounds)
    if asked.what != "flights":
        filters.report(asked.rounds)


def flights(rounds: int) -> None:
    """Warm every contestant up, then measure all of them in turn, and print medians and ratios."""
    flown = contestants()
    ends = {name: run(seconds) for name, (run, seconds) in flown.items()}
    found: dict[str, list[float]] = {name: [] for name in flown}
    for _ in tqdm(range(rounds), desc="rounds"):
        for name, (run, seconds) in flown.items():
            found[name].append(speed(run, seconds))

    print(
        f"\nsimulated s per CPU s, median of {rounds} rounds [min, max]; error at the end of a round"
    )
    for name, each in found.items():
        print(
            f"  {median(each):9.2f}  [{min(each):8.2f}, {max(each):8.2f}]  {ends[name]:5.2f} m  {name}"
        )
    print("\nratios, median of the rounds' ratios")
    names = list(flown)
    pairs = [(0, 4), (1, 6), (1, 5), (2, 5), (0, 6), (0, 5), (1, 7), (1, 8), (0, 7), (0, 8)]
    for a, b in pairs:
        ratio = median(x / y for x, y in zip(found[names[a]], found[names[b]], strict=True))
        print(f"  {ratio:7.1f} x  {names[a]}  /  {names[b]}")


if __name__ == "__main__":
    main()
