"""A bank of filters over time: what each hypothesis believes beside the truth, which one flies, and how well it is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from uavlab.errors import BadInput
from uavlab.flight.log import Log
from uavlab.flight.metrics import headings
from uavlab.flight.worlds import flown_by, told
from uavlab.types import Array
from uavlab.views import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def plot_bank(log: Log) -> Figure:
    """Every hypothesis of a bank beside the truth, with three standard deviations, and the one that flies.

    On the left the numbers as they were told, each in the world of its filter: the estimate jumps at a switch. On the
    right the error of each hypothesis, laid into the world in which the flight began: nothing jumps.

    Parameters
    ----------
    log : Log
        A flight with a bank of filters.

    Returns
    -------
    Figure
        x, y, z [m] and heading [deg], normalised innovations, and who flew, over t [s].

    Raises
    ------
    BadInput
        The flight had no bank.
    """
    log = style.whole(log)
    if not log.worlds.names:
        raise BadInput("this flight had no bank of filters: there are no hypotheses to draw.")
    with style.styled() as plt:
        figure, axes = plt.subplots(
            5, 2, figsize=(10, 9.5), sharex=True, layout="constrained", height_ratios=(1, 1, 1, 1, 0.8)
        )  # fmt: skip
        flight = told(log)
        for i in range(3):
            _told(axes[i, 0], log, i)
            _error(axes[i, 1], flight, i)
        _told_heading(axes[3, 0], log)
        _heading_error(axes[3, 1], flight)
        _health(axes[4, 0], log)
        _flies(axes[4, 1], log)
        for at in axes.flat:
            for start, _, _ in flown_by(log)[1:]:
                at.axvline(start, color="#999999", lw=0.8, ls=":", zorder=0)
        for at in axes[-1]:
            at.set_xlabel("time [s]")
        handles = dict(zip(*reversed(axes[0, 0].get_legend_handles_labels()), strict=True))
        figure.legend(
            handles.values(), handles.keys(), loc="outside upper center", ncols=len(handles)
        )
        style.stamp(figure, style.small_print(log))
    return figure


def _seen(log: Log, k: int, values: Array) -> Array:
    """Values of hypothesis `k`, NaN where it is not reliable."""
    return np.where(log.worlds.reliable[:, k], values, np.nan)


def _banded(at: Axes, log: Log, k: int, values: Array, three: Array) -> None:
    """One hypothesis and its three standard deviations."""
    color, name = style.hypothesis(k), log.worlds.names[k]
    values = _seen(log, k, values)
    at.fill_between(log.t, values - three, values + three, color=color, alpha=0.18, lw=0)
    at.plot(log.t, values, color=color, lw=1.1, label=f"{name} ± 3σ")


def _scaled(at: Axes) -> None:
    """Scale by the lines: the band of a filter that nobody flies on may be very wide."""
    rows = [np.asarray(line.get_ydata(), dtype=float) for line in at.lines]
    values = np.concatenate([y[np.isfinite(y)] for y in rows])
    low, high = float(values.min()), float(values.max())
    room = 0.25 * max(high - low, 1e-3)
    at.set_ylim(low - room, high + room)


def _told(at: Axes, log: Log, i: int) -> None:
    w = log.worlds
    at.set_title(f"{'xyz'[i]} as it was told, each in its own world [m]")
    at.plot(log.t, log.r[:, i], color="#BBBBBB", lw=4, label="truth, world of the start")
    for k in range(len(w.names)):
        _banded(at, log, k, w.r[:, k, i], 3 * w.std[:, k, i])
    at.plot(log.t, log.r_e[:, i], "k--", lw=0.9, label="estimate that flies")
    _scaled(at)


def _error(at: Axes, flight: Log, i: int) -> None:
    w = flight.worlds
    at.set_title(f"error in {'xyz'[i]}, told in the world of the start [m]")
    at.axhline(0, color="#BBBBBB", lw=4)
    for k in range(len(w.names)):
        _banded(at, flight, k, w.r[:, k, i] - flight.r[:, i], 3 * w.std[:, k, i])
    at.plot(flight.t, flight.r_e[:, i] - flight.r[:, i], "k--", lw=0.9)
    _scaled(at)


def _told_heading(at: Axes, log: Log) -> None:
    w, deg = log.worlds, float(np.rad2deg(1.0))
    at.set_title("heading as it was told [deg]")
    at.plot(log.t, deg * np.unwrap(headings(log)), color="#BBBBBB", lw=4)
    for k in range(len(w.names)):
        _banded(at, log, k, deg * np.unwrap(w.heading[:, k]), 3 * deg * w.heading_std[:, k])
    eta = np.unwrap(np.arctan2(log.R_e[:, 1, 0], log.R_e[:, 0, 0]))
    at.plot(log.t, deg * eta, "k--", lw=0.9)
    _scaled(at)


def _heading_error(at: Axes, flight: Log) -> None:
    w, deg = flight.worlds, float(np.rad2deg(1.0))
    at.set_title("error in heading, told in the world of the start [deg]")
    at.axhline(0, color="#BBBBBB", lw=4)
    true = headings(flight)
    for k in range(len(w.names)):
        error = (w.heading[:, k] - true + np.pi) % (2 * np.pi) - np.pi
        _banded(at, flight, k, deg * error, 3 * deg * w.heading_std[:, k])
    _scaled(at)


def _health(at: Axes, log: Log) -> None:
    w = log.worlds
    at.set_title("normalised innovation squared, per degree of freedom")
    at.axhline(1.0, color="#BBBBBB", lw=4)
    for k in range(len(w.names)):
        at.plot(log.t, w.nis[:, k].clip(1e-3), color=style.hypothesis(k), lw=1.0)
    at.set_yscale("log")


def _flies(at: Axes, log: Log) -> None:
    """A row for each hypothesis: thin while it is reliable, thick while it flies."""
    w = log.worlds
    at.set_title("reliable (thin) and flying (thick)")
    dt = float(log.t[1] - log.t[0]) if len(log.t) > 1 else 0.0
    for k in range(len(w.names)):
        for mask, height in ((w.reliable[:, k], 0.16), (w.flies == k, 0.7)):
            at.broken_barh(
                _runs(log.t, mask, dt), (k - height / 2, height), color=style.hypothesis(k)
            )
    at.set_yticks(range(len(w.names)), w.names)
    at.set_ylim(len(w.names) - 0.4, -0.6)
    at.grid(visible=False, axis="y")


def _runs(t: Array, mask: Array, dt: float) -> list[tuple[float, float]]:
    """Where `mask` holds, as (start, length) [s]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [(float(t[a]), float(t[b - 1] - t[a]) + dt) for a, b in edges.reshape(-1, 2)]
