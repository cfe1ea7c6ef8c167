"""A still picture of a flight in space: what a page shows where the replay cannot run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from uavlab.flight.log import Log
from uavlab.types import Array
from uavlab.views import fences, story, style
from uavlab.views.cast import cast, drawn_scale, frame_of, guards_in, rotor_places

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def picture(logs: Log | Sequence[Log] | Mapping[str, Log], *, moments: int = 5) -> Figure:
    """Paths in perspective, with the aircraft at some moments along them.

    Parameters
    ----------
    logs : Log, or several, or a mapping of label to Log
        The first is drawn with its reference; the others are ghosts.
    moments : int
        How many times the aircraft of the first flight is drawn.
    """
    flights = cast(logs)
    with style.styled() as plt:
        figure = plt.figure(figsize=(7, 4.6))
        at: Any = figure.add_axes((0.0, 0.1, 0.96, 0.9), projection="3d")
        for k, (label, log) in enumerate(flights.items()):
            if len(log.t):
                _flight(at, label, log, k, alone=len(flights) == 1)
        first = next(iter(flights.values()))
        if len(first.t):
            _aircraft(at, first, drawn_scale(flights), moments)
        _room(at, flights)
        rows = len(at.get_legend_handles_labels()[1])
        small = {"fontsize": 7, "labelspacing": 0.2} if rows > 5 else {}
        at.legend(loc="upper left", **small)
        style.stamp(figure, [line for log in flights.values() for line in style.small_print(log)])
    return figure


def _flight(at: Any, label: str, log: Log, k: int, *, alone: bool) -> None:
    """One path, its shadow on the ground, and its end; one that is alone has the colours of its modes."""
    color = style.SERIES[k % len(style.SERIES)]
    x, y, z = log.r.T
    if k == 0 and style.seen(log.r_d):
        at.plot(*log.r_d.T, "--", color=style.REFERENCE, lw=1, label="asked")
    at.plot(x, y, np.full_like(z, min(0.0, z.min())), color="#CCCCCC", lw=1)
    paths = list(story.pieces(log)) if alone else []
    for rows, shade, mode in paths or [(slice(None), color, label)]:
        known = at.get_legend_handles_labels()[1]
        at.plot(*log.r[rows].T, color=shade, label="_" if mode in known else mode or label)
    if not log.exit.good:
        at.plot(x[-1:], y[-1:], z[-1:], "X", color=style.GHOST, ms=8, label=log.exit.name.lower())


def _aircraft(at: Any, log: Log, scale: float, moments: int) -> None:
    """Arms, rotors and nose at some moments."""
    places, _, radius = rotor_places(log)
    ring = np.linspace(0, 2 * np.pi, 25)
    circle = radius * np.stack([np.cos(ring), np.sin(ring), 0 * ring], axis=1)
    for i in np.linspace(0, len(log.t) - 1, moments).astype(int):

        def told(points: Array, i: int = i) -> Array:
            return (scale * points) @ log.R[i].T + log.r[i]

        for place in places:
            at.plot(*told(np.array([np.zeros(3), place])).T, color="#333333", lw=1.5, clip_on=False)
            at.plot(*told(place + circle).T, color="#666666", lw=0.8, clip_on=False)
        nose = np.array([np.zeros(3), [1.3 * np.linalg.norm(places[0]), 0, 0]])
        at.plot(*told(nose).T, color=style.GHOST, lw=2, clip_on=False)


def _room(at: Any, flights: Mapping[str, Log]) -> None:
    """Equal scales, a level view, quiet walls."""
    low, high = frame_of(flights)
    fences.draw_space(at, guards_in(flights), low, high)
    at.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    at.set_xlim(low[0], high[0])
    at.set_ylim(low[1], high[1])
    at.set_zlim(low[2], high[2])
    at.set_box_aspect(high - low, zoom=1.15)
    at.view_init(elev=24, azim=-60)
    for axis, side in zip("xyz", high - low, strict=True):
        at.locator_params(axis=axis, nbins=max(2, round(6 * side / max(high - low))))
    for axis in (at.xaxis, at.yaxis, at.zaxis):
        axis.set_pane_color((1, 1, 1, 0))
