"""How every picture looks: one palette, quiet axes, and the small print that says what was flown."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from uavlab.flight.log import Log
from uavlab.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Told apart by the colour-blind, and in grey.
FLOWN = "#0072B2"
REFERENCE = "#444444"
ESTIMATE = "#009E73"
GHOST = "#D55E00"
XYZ = ("#C8402F", "#2E8B3D", "#3465C4")  # x, y, z, as the axes of a frame are drawn
SERIES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7F6000", "#444444")

# The modes of a pilot (uavlab.managers.modes). Any two are told apart with any of the three kinds of colour blindness;
# flying is the blue of every flown path, and what is grave is darker and redder.
MODES = {
    "ground": "#BDBDBD", "taking off": "#56B4E9", "flying": FLOWN, "going home": "#E08AC0", "landing": "#009E73",
    "landed": "#707070", "emergency": "#E69F00", "failsafe": "#A51C1C", "manual": "#F0E442", "evading": "#4B1E7A",
}  # fmt: skip
# Marks of what happened at once, and of what may not be flown into.
MARKS = {
    "safety": "#A51C1C", "bumper": "#4B1E7A", "remote": "#8A7A00", "touchdown": "#009E73", "refused": "#8A8A8A",
    "swap": "#222222", "fault": "#B0561C",
}  # fmt: skip
AREA, NO_FLY, OBSTACLE = "#2F7F86", "#C8402F", "#85888C"

RC: Any = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#888888",
    "axes.grid": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.7,
    "lines.linewidth": 1.4,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 1.4,
    "legend.columnspacing": 1.0,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "figure.dpi": 100,
}


@contextmanager
def styled() -> Iterator[Any]:
    """The house style of matplotlib, for as long as a picture is drawn; yields `matplotlib.pyplot`."""
    import matplotlib.pyplot as plt

    with plt.rc_context(RC):
        yield plt


def title(log: Log) -> str:
    """What was flown, in one line: scenario, airframe, seed."""
    meta = log.meta
    words = [str(meta.get("scenario", "flight"))]
    if meta.get("airframe"):
        words.append(str(meta["airframe"]))
    if meta.get("seed") is not None:
        words.append(f"seed {meta['seed']}")
    return " · ".join(words)


def ending(log: Log) -> str:
    """How it ended, in one line."""
    return f"{log.exit.name}: {log.reason or log.exit.value}"


def provenance(log: Log) -> str:
    """Whose functions flew, in one line; empty for a recorded flight."""
    of = log.meta.get("provenance") or {}
    return ", ".join(f"{name}={who}" for name, who in of.items())


def small_print(log: Log) -> list[str]:
    """The lines that stand under every picture of a flight."""
    lines = [f"{title(log)} · {ending(log)}", provenance(log), str(log.meta.get("note", ""))]
    return [line for line in lines if line]


def stamp(figure: Figure, lines: list[str]) -> None:
    """Print `lines` small under the figure, and make room for them."""
    import textwrap

    width = int(figure.get_figwidth() * 17)  # characters of 7 point that fit
    text = "\n".join(row for line in lines for row in textwrap.wrap(line, width))
    height = (0.135 * (text.count("\n") + 1) + 0.04) / figure.get_figheight()
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.set(rect=(0, height, 1, 1 - height))  # type: ignore[call-arg]
    figure.text(0.008, 0.006, text, fontsize=7, color="#777777", va="bottom", linespacing=1.3)


def seen(values: Array) -> bool:
    """Whether there is anything to draw: at least one finite number."""
    return bool(np.isfinite(values).any())


def whole(log: Log) -> Log:
    """The log up to the last tick whose true pose is finite."""
    good = np.isfinite(log.r).all(axis=1) & np.isfinite(log.R).all(axis=(1, 2))
    bad = np.flatnonzero(~good)
    n = int(bad[0]) if bad.size else len(log.t)
    if n == len(log.t):
        return log
    arrays = {k: v[:n] for k, v in log._asdict().items() if isinstance(v, np.ndarray)}
    return log._replace(**arrays, worlds=log.worlds.cut(n))


def mode(name: str) -> str:
    """The colour of a mode of a pilot; that of any flown path if nobody knows it."""
    return MODES.get(name, FLOWN)


def ink(color: str) -> str:
    """Black or white: which of them is read on ``#rrggbb``."""
    r, g, b = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    return "#111111" if 0.299 * r + 0.587 * g + 0.114 * b > 140 else "#FFFFFF"


def hypothesis(k: int) -> str:
    """The colour of hypothesis `k` of a bank; never that of the flown path."""
    return SERIES[1 + k % (len(SERIES) - 1)]


def nothing_to_draw(axes: Axes, why: str = "not recorded") -> None:
    """Say inside an empty panel that it is empty on purpose."""
    axes.text(0.5, 0.5, why, transform=axes.transAxes, ha="center", color="#999999")
    axes.set_yticks([])
