"""Contestants side by side: warmed up, run in turn in rounds of one run, medians and ratios printed."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from statistics import median

from tqdm import tqdm

Run = Callable[[float], float]  # simulated seconds → error at the end [m]


def speed(run: Run, seconds: float) -> float:
    """Simulated seconds per CPU second of one run."""
    start = time.process_time()
    run(seconds)
    return seconds / (time.process_time() - start)


def compare(
    flown: Mapping[str, tuple[Run, float]], pairs: Sequence[tuple[int, int]], rounds: int
) -> None:
    """Warm every contestant up, then measure all of them in turn, and print medians and ratios.

    Parameters
    ----------
    flown : mapping
        Name → (what flies, simulated seconds of one round).
    pairs : sequence of (int, int)
        Which contestant is divided by which, by their places.
    rounds : int
        How many.
    """
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
    for a, b in pairs:
        ratio = median(x / y for x, y in zip(found[names[a]], found[names[b]], strict=True))
        print(f"  {ratio:7.1f} x  {names[a]}  /  {names[b]}")
