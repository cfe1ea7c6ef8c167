"""A quadratic program at a glance: what its matrices are made of, which rows hold the plan back, and at what price."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from uavlab.errors import BadInput
from uavlab.qp import QP, Plan
from uavlab.types import Array
from uavlab.views import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FREE, HELD, SOFT = "#BBBBBB", style.GHOST, style.SERIES[3]  # rows: idle, hard at work, soft at work
CLOSE = 1e-6  # of a row's own size, or of the largest multiplier: nearer than that is equal
OUT = 0.2  # of the way from l to u: how far outside of its bounds a row is drawn at most


def plot_qp(qp: QP, plan: Plan) -> Figure:
    """What a QP is made of, and how its plan sits in it.

    Parameters
    ----------
    qp : QP
        With n variables and m rows.
    plan : Plan
        What a solver made of it. If that is not an answer, the picture says so.

    Returns
    -------
    Figure
        P above A, their entries by size; the plan; and beside each row of A where it lies between its bounds, and
        its multiplier. Rows at work stand out, soft ones in a colour of their own; a square is a row that is missed.

    Raises
    ------
    BadInput
        The plan is not one for this problem.
    """
    n, m = len(qp.q), len(qp.l)
    if np.shape(plan.z) != (n,) or np.shape(plan.y) != (m,):
        raise BadInput(
            f"the QP has {n} variables and {m} rows, the plan {np.size(plan.z)} and {np.size(plan.y)}: "
            "it is the plan of another problem."
        )
    with style.styled() as plt:
        figure = plt.figure(figsize=(10.0, 7.0), layout="constrained")
        share = float(np.clip(n / max(m, 1), 0.3, 1.0))
        spaces = figure.add_gridspec(2, 3, height_ratios=(share, 1.0), width_ratios=(1.0, 1.1, 1.1))
        top, below = figure.add_subplot(spaces[0, 0]), figure.add_subplot(spaces[1, 0])
        _matrix(top, qp.P, f"P ({n} × {n})")
        _matrix(below, qp.A, f"A ({m} × {n})")
        _plan(figure.add_subplot(spaces[0, 1:]), plan)
        places = figure.add_subplot(spaces[1, 1], sharey=below)
        _places(places, qp, plan)
        _multipliers(figure.add_subplot(spaces[1, 2], sharey=below), qp, plan)
        _legend(figure)
        style.stamp(figure, [_said(qp, plan)])
    return figure


def working(qp: QP, plan: Plan) -> Array:
    """Which rows hold the plan back: their multiplier is not zero. Shape (m,), True or False."""
    return np.abs(plan.y) > CLOSE * max(1.0, float(np.abs(plan.y).max(initial=0.0)))


def missed(qp: QP, plan: Plan) -> Array:
    """By how much the plan misses each row, shape (m,), in the row's own unit; 0 where it is kept."""
    Az = qp.A @ plan.z
    return np.maximum(np.maximum(Az - qp.u, qp.l - Az), 0.0)


def place(qp: QP, plan: Plan) -> Array:
    """Where each row lies between its bounds, shape (m,): 0 at l, 1 at u.

    Without one of the bounds the other one's size stands for the way between them; without both it is in the middle.
    """
    Az, l, u = qp.A @ plan.z, qp.l, qp.u
    low, high = np.isfinite(l), np.isfinite(u)
    size = np.maximum(1.0, np.abs(np.where(low, l, np.where(high, u, 0.0))))
    wide = np.where(low & high, u - np.where(low, l, 0.0), size)
    wide = np.where(wide > 0.0, wide, size)
    from_l = (Az - np.where(low, l, 0.0)) / wide
    from_u = 1.0 - (np.where(high, u, 0.0) - Az) / wide
    found = np.where(low, from_l, np.where(high, from_u, 0.5))
    return np.where(low & high & (l == u), 0.5 + from_l, found)


def _said(qp: QP, plan: Plan) -> str:
    """The small print: what came out, and how many rows are at work."""
    soft = np.isfinite(qp.soft)
    at_work, off = working(qp, plan), missed(qp, plan) > CLOSE
    head = plan.status if plan.ok else f"NO ANSWER ({plan.status}); drawn is the warm start"
    return (
        f"{head} · cost {plan.cost:.6g} · {plan.iterations} iterations · "
        f"{np.sum(at_work)} of {len(qp.l)} rows at work; {np.sum(soft)} rows are soft, "
        f"{np.sum(at_work & soft)} of them at work, {np.sum(off & soft)} missed"
    )


def _colors(qp: QP, plan: Plan) -> Array:
    soft = np.isfinite(qp.soft)
    return np.where(working(qp, plan), np.where(soft, SOFT, HELD), FREE)


def _matrix(at: Axes, M: Array, title: str) -> None:
    """The entries of a matrix by size; zeros stay white."""
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap, LogNorm

    size = np.abs(np.asarray(M, dtype=float))
    filled = size > 0.0
    at.set_title(f"{title}: {filled.mean() if size.size else 0.0:.0%} filled")
    at.grid(visible=False)
    if not filled.any():
        return style.nothing_to_draw(at, "all zero")
    low, high = size[filled].min(), size.max()
    shown = np.ma.masked_where(~filled, size)
    norm = LogNorm(max(low, 1e-6 * high), high if high > low else 2.0 * high)
    blues = ListedColormap(colormaps["Blues"](np.linspace(0.25, 1.0, 200)))  # seen even where small
    image = at.imshow(shown, aspect="auto", cmap=blues, norm=norm, interpolation="nearest")
    at.set(xlabel="variable", ylabel="row")
    at.figure.colorbar(image, ax=at, shrink=0.9, pad=0.02, label="size of the entry")


def _plan(at: Axes, plan: Plan) -> None:
    at.set(title=f"the plan z ({len(plan.z)}): {plan.status}", xlabel="variable", ylabel="value")
    color = style.FLOWN if plan.ok else FREE
    at.axhline(0.0, color="#BBBBBB", lw=0.8)
    at.vlines(np.arange(len(plan.z)), 0.0, plan.z, color=color, lw=1.0)
    at.plot(plan.z, ".", color=color)


def _places(at: Axes, qp: QP, plan: Plan) -> None:
    """A dot for each row, between the lines that are its bounds."""
    rows, where = np.arange(len(qp.l)), np.clip(place(qp, plan), -OUT, 1.0 + OUT)
    colors, off = _colors(qp, plan), missed(qp, plan) > CLOSE
    at.set(title="A z between its bounds", xticks=(0, 1), xlim=(-OUT - 0.05, 1.05 + OUT))
    at.set_xticklabels(("l", "u"))
    at.axvspan(0.0, 1.0, color="#F3F6FA", lw=0)
    for chosen, mark in ((~off, "o"), (off, "s")):
        at.scatter(where[chosen], rows[chosen], s=14, c=colors[chosen], marker=mark, zorder=3)


def _multipliers(at: Axes, qp: QP, plan: Plan) -> None:
    """A bar for each row, and the price at which a soft row gives way."""
    from matplotlib.ticker import SymmetricalLogLocator

    rows, soft = np.arange(len(qp.l)), np.isfinite(qp.soft)
    most = max(1.0, float(np.abs(plan.y).max(initial=0.0)))
    at.set(title="multipliers y", xlabel="y (below 0: l holds, above 0: u does)")
    at.barh(rows, plan.y, color=_colors(qp, plan), height=0.8)
    at.axvline(0.0, color="#888888", lw=0.8)
    at.set_axisbelow(True)
    near = soft & (qp.soft <= 3.0 * most)
    for side in (-1.0, 1.0):
        at.plot(side * qp.soft[near], rows[near], "|", color=SOFT, ms=5)
    at.set_xscale("symlog", linthresh=1.0)
    at.set_xlim(-4.0 * most, 4.0 * most)
    at.xaxis.set_major_locator(SymmetricalLogLocator(base=100.0, linthresh=1.0))


def _legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    looks = (
        ("idle", FREE, "o"), ("hard, at work", HELD, "o"), ("soft, at work", SOFT, "o"),
        ("missed", SOFT, "s"), ("price of a soft row", SOFT, "|"),
    )  # fmt: skip
    handles = [
        Line2D([], [], color=color, marker=mark, ls="", label=label) for label, color, mark in looks
    ]
    figure.legend(handles=handles, loc="outside upper right", ncols=5, handletextpad=0.1)
