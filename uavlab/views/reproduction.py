"""The figure of an experiment: its panels as they were described, with the verdict in the small print."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import TYPE_CHECKING, Any

from uavlab.views import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# How each kind of line is drawn; what the truth and the papers say looks the same in every figure.
KINDS: dict[str, dict[str, Any]] = {
    "line": {},
    "dashed": {"ls": "--"},
    "points": {"ls": "", "marker": "o", "ms": 3, "alpha": 0.6},
    "truth": {"color": "#BBBBBB", "lw": 4.0, "zorder": 1},
    "paper": {"color": style.REFERENCE, "ls": ":", "lw": 2.0},
}


def plot_outcome(kept: Any, panels: Sequence[Any]) -> Figure:
    """Draw the panels of an experiment.

    Parameters
    ----------
    kept : Record
        Name, source and rows (`uavlab.experiments.record`).
    panels : sequence of Panel
        What to draw (`uavlab.experiments`).

    Returns
    -------
    Figure
        One panel wide, or two from the second on.
    """
    columns = min(2, len(panels))
    rows = ceil(len(panels) / columns)
    with style.styled() as plt:
        size = (5.2 * columns, 3.0 * rows + 0.4)
        figure, axes = plt.subplots(
            rows, columns, figsize=size, layout="constrained", squeeze=False
        )
        for at, panel in zip(axes.flat, panels, strict=False):
            _panel(at, panel)
        for at in axes.flat[len(panels) :]:
            at.set_axis_off()
        judged = [row for row in kept.rows if row.met is not None]
        met = sum(row.met for row in judged)
        said = f"{kept.name} · {kept.source} · {kept.seeds} seeds · {met} of {len(judged)} numbers within their bands"
        style.stamp(figure, [said])
    return figure


def _panel(at: Axes, panel: Any) -> None:
    colors = iter(style.SERIES * 4)
    for line in panel.lines:
        look = KINDS.get(line.kind, {})
        color = look.get("color") or next(colors)
        if line.kind == "band":
            at.fill_between(line.x, line.y, line.y2, color=color, alpha=0.2, lw=0, label=line.label)
        else:
            at.plot(line.x, line.y, label=line.label or None, **{"color": color, **look})
    for x, text in panel.marks:
        at.axvline(x, color="#999999", lw=0.8)
        at.annotate(
            text, (x, 1.0), xycoords=("data", "axes fraction"), fontsize=7, color="#666666",
            rotation=90, va="top", ha="right",
        )  # fmt: skip
    at.set(title=panel.title, xlabel=panel.x, ylabel=panel.y)
    if panel.log_y:
        at.set_yscale("log")
    if panel.equal:
        at.set_aspect("equal", adjustable="datalim")
    if any(line.label for line in panel.lines):
        at.legend()
