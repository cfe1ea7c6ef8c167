"""Time plots and paths of a flight. Every function returns its figure and shows nothing by itself."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from uavlab.errors import BadInput
from uavlab.flight.log import Log
from uavlab.flight.metrics import heading_error, headings, position_error, tilt
from uavlab.flight.worlds import told
from uavlab.parts.slot import FIRST, TAKEN
from uavlab.types import GRAVITY, Array
from uavlab.views import fences, story, style
from uavlab.views.cast import in_view
from uavlab.views.guards import guards_of, settled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def plot_flight(log: Log) -> Figure:
    """Everything of one flight over time: errors, heading, tilt, rotors, thrust, wind.

    Parameters
    ----------
    log : Log
        Whole or ended early. What was not recorded (NaN) is said in its panel.

    Returns
    -------
    Figure
        Eight panels over t [s].
    """
    panels = (
        _position_error, _velocity_error, _heading, _heading_error,
        _tilt, _estimate_error, _rotors, _wind,
    )  # fmt: skip
    with style.styled() as plt:
        figure, axes = plt.subplots(4, 2, figsize=(10, 9), sharex=True, layout="constrained")
        flight = told(log)
        for panel, at in zip(panels, axes.flat, strict=True):
            panel(at, flight)
            _mark_end(at, log)
            _mark_swaps(at, log)
        _name_swaps(axes[2, 0], log)  # the tilt: it has no legend
        for at in axes[-1]:
            at.set_xlabel("time [s]")
        style.stamp(figure, style.small_print(log))
    return figure


def save(figure: Figure, path: str | os.PathLike[str], dpi: int = 110) -> Path:
    """Write a figure as a picture, whole or not at all, and close it."""
    import matplotlib.pyplot as plt

    path = Path(path)
    part = path.with_name(f"{path.stem}.part{path.suffix}")
    figure.savefig(part, dpi=dpi)
    plt.close(figure)
    return part.replace(path)


def plot_heading(log: Log) -> Figure:
    """Heading asked and flown, its error, and the tilt that makes it hard, over t [s]."""
    with style.styled() as plt:
        figure, axes = plt.subplots(3, 1, figsize=(7, 5.4), sharex=True, layout="constrained")
        log = told(log)
        for panel, at in zip((_heading, _heading_error, _tilt), axes, strict=True):
            panel(at, log)
            _mark_end(at, log)
        axes[-1].set_xlabel("time [s]")
        style.stamp(figure, style.small_print(log))
    return figure


def plot_path(log: Log, *, reference: bool = True, heading_every: float | None = None) -> Figure:
    """The path from above and from the side, in metres, with the nose's direction along it.

    Parameters
    ----------
    log : Log
        The flight.
    reference : bool
        Draw the path that was asked, too.
    heading_every : float, optional
        Time between two arrows of heading [s]; about twenty in all if it is not given.
    """
    log = told(settled(style.whole(log)))
    with style.styled() as plt:
        figure, (top, side) = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
        for at, (i, j) in ((top, (0, 1)), (side, (0, 2))):
            if reference and style.seen(log.r_d):
                at.plot(log.r_d[:, i], log.r_d[:, j], "--", color=style.REFERENCE, label="asked")
            _way(at, log, i, j)
            _ends(at, log, i, j)
            at.set(xlabel="x [m]", ylabel=f"{'xyz'[j]} [m]")
            at.set_aspect("equal", adjustable="datalim")
            _fence(at, log, i, j)
        _noses(top, log, heading_every)
        top.set_title("from above")
        side.set_title("from the side")
        names = top.get_legend_handles_labels()
        if len(names[1]) > 4:
            figure.legend(*names, loc="outside upper center", ncols=min(len(names[1]), 10))
        else:
            top.legend(loc="best")
        style.stamp(figure, style.small_print(log))
    return figure


def plot_compare(
    logs: Mapping[str, Log], quantities: Mapping[str, Callable[[Log], Array]] | None = None
) -> Figure:
    """Several flights over each other, told apart by their labels.

    Parameters
    ----------
    logs : mapping of str to Log
        Label → flight.
    quantities : mapping of str to callable, optional
        Name with unit → a function of a log (`told` in the world of the start) that gives (N,) values. Position
        error [m], heading error [deg] and tilt [deg] if it is not given.

    Raises
    ------
    BadInput
        There is nothing to compare.
    """
    if not logs:
        raise BadInput("plot_compare got no flights; give it {'label': log, …}.")
    quantities = quantities or {
        "position error [m]": position_error,
        "heading error [deg]": lambda log: np.rad2deg(heading_error(log)),
        "tilt [deg]": lambda log: np.rad2deg(tilt(log)),
    }
    with style.styled() as plt:
        figure, axes = plt.subplots(
            len(quantities), 1, figsize=(8, 1.2 + 1.8 * len(quantities)),
            sharex=True, layout="constrained", squeeze=False,
        )  # fmt: skip
        for at, (name, of) in zip(axes[:, 0], quantities.items(), strict=True):
            for k, (label, log) in enumerate(logs.items()):
                color = style.SERIES[k % len(style.SERIES)]
                at.plot(log.t, of(told(log)), color=color, label=label)
                _mark_end(at, log, color)
            at.set_title(name)
        axes[0, 0].legend(loc="best", ncols=min(4, len(logs)))
        axes[-1, 0].set_xlabel("time [s]")
        style.stamp(
            figure,
            [f"{label}: {line}" for label, g in logs.items() for line in style.small_print(g)],
        )
    return figure


# One panel each ------------------------------------------------------------------------------------


def _components(at: Axes, log: Log, values: Array, name: str) -> None:
    """A vector over time: its norm and its three components."""
    at.set_title(name)
    if not style.seen(values):
        return style.nothing_to_draw(at)
    at.plot(log.t, np.linalg.norm(values, axis=1), color="#BBBBBB", lw=3.5, label="norm")
    for i in range(3):
        at.plot(log.t, values[:, i], color=style.XYZ[i], label="xyz"[i])
    at.legend(loc="upper right", ncols=4)
    _headroom(at)


def _position_error(at: Axes, log: Log) -> None:
    _components(at, log, log.r - log.r_d, "position error [m]")


def _velocity_error(at: Axes, log: Log) -> None:
    _components(at, log, log.v - log.v_d, "velocity error [m/s]")


def _estimate_error(at: Axes, log: Log) -> None:
    _components(at, log, log.r_e - log.r, "error of the estimated position [m]")


def _wind(at: Axes, log: Log) -> None:
    _components(at, log, log.wind, "wind [m/s]")


def _heading(at: Axes, log: Log) -> None:
    at.set_title("heading [deg]")
    flown = np.rad2deg(np.unwrap(headings(log)))
    if style.seen(log.heading_d):  # on the turn that is nearest to what was flown
        asked = flown - np.rad2deg(heading_error(log))
        at.plot(log.t, asked, "--", color=style.REFERENCE, label="asked")
    at.plot(log.t, flown, color=style.FLOWN, label="flown")
    at.legend(loc="best", ncols=2)


def _heading_error(at: Axes, log: Log) -> None:
    at.set_title("heading error [deg]")
    if not style.seen(log.heading_d):
        return style.nothing_to_draw(at)
    at.axhline(0, color="#BBBBBB", lw=0.8)
    at.plot(log.t, np.rad2deg(heading_error(log)), color=style.FLOWN)


def _tilt(at: Axes, log: Log) -> None:
    at.set_title("tilt of the thrust axis [deg]")
    at.plot(log.t, np.rad2deg(tilt(log)), color=style.FLOWN)
    at.set_ylim(bottom=0)


def _rotors(at: Axes, log: Log) -> None:
    at.set_title("thrust of each rotor [N]")
    if not log.rotors.size or not style.seen(log.rotors):
        return style.nothing_to_draw(at)
    for i in range(log.rotors.shape[1]):
        at.plot(log.t, log.rotors[:, i], color=style.SERIES[i % 8], lw=1, label=str(i + 1))
    mass = log.meta.get("mass")
    if mass:
        at.axhline(mass * GRAVITY / log.rotors.shape[1], color="#999999", lw=0.8, ls=":")
    at.legend(loc="upper right", ncols=log.rotors.shape[1])
    _headroom(at)


def _headroom(at: Axes) -> None:
    """Room above the curves for one row of legend."""
    low, high = at.get_ylim()
    at.set_ylim(low, high + 0.22 * (high - low))


def _mark_end(at: Axes, log: Log, color: str = style.GHOST) -> None:
    """A line where a flight ended before its time."""
    if not log.exit.good and len(log.t):
        at.axvline(log.t[-1], color=color, lw=1, ls=":")


def _swaps(log: Log) -> list[tuple[float, str, bool]]:
    """When parts took over in flight, who, and whether they were let."""
    told = log.meta.get("swaps", [])
    return [(t, name, out == TAKEN) for t, _, name, out in told if out != FIRST]


def _mark_swaps(at: Axes, log: Log) -> None:
    """A line where another part took over; dotted where it was refused."""
    for t, _, taken in _swaps(log):
        at.axvline(t, color="#444444", lw=1, ls="--" if taken else ":")


def _name_swaps(at: Axes, log: Log) -> None:
    """Who took over, along the lines of one panel."""
    for t, name, taken in _swaps(log):
        said = name if taken else f"{name} refused"
        at.annotate(
            said, (t, 0.04), xycoords=("data", "axes fraction"), xytext=(2, 0), fontsize=7,
            textcoords="offset points", rotation=90, va="bottom", color="#555555",
        )  # fmt: skip


def _way(at: Axes, log: Log, i: int, j: int) -> None:
    """The path that was flown, in the colours of its modes if it has any."""
    for rows, color, mode in list(story.pieces(log)) or [(slice(None), style.FLOWN, "flown")]:
        known = at.get_legend_handles_labels()[1]
        label = "_" if mode in known else mode or "flown"
        at.plot(log.r[rows, i], log.r[rows, j], color=color, label=label)


def _fence(at: Axes, log: Log, i: int, j: int) -> None:
    """Area, no-fly zones and obstacles, as far as the path stays in sight."""
    around = guards_of(log)
    if not (around and len(log.t)):
        return
    low, high = in_view({"flown": log})
    room = 0.06 * float((high - low).max())
    fences.draw_flat(at, around, float(min(low[2], 0.0)), float(high[2]) + 2 * room, up=j == 2)
    at.set_aspect("equal", adjustable="box")
    at.set_xlim(low[i] - room, high[i] + room)
    at.set_ylim(low[j] - room, high[j] + room)


def _ends(at: Axes, log: Log, i: int, j: int) -> None:
    """A ring at the start, and a cross where a flight ended badly."""
    if not len(log.t):
        return
    at.plot(log.r[0, i], log.r[0, j], "o", mfc="white", mec=style.FLOWN, ms=6, label="start")
    if not log.exit.good:
        at.plot(
            log.r[-1, i], log.r[-1, j], "X", color=style.GHOST, ms=8, label=log.exit.name.lower()
        )


def _noses(at: Axes, log: Log, every: float | None) -> None:
    """Short arrows along the path in the direction of heading."""
    if len(log.t) < 2:
        return
    span = float(log.t[-1] - log.t[0])
    times = np.arange(log.t[0], log.t[-1], every or max(span / 20, 1e-3))
    rows = np.searchsorted(log.t, times).clip(0, len(log.t) - 1)
    eta = headings(log)[rows]
    at.quiver(
        log.r[rows, 0], log.r[rows, 1], np.cos(eta), np.sin(eta),
        color="#444444" if story.bands(log, "mode") else style.FLOWN, width=0.004, scale=22, headwidth=4, zorder=3,
    )  # fmt: skip
