"""Ghosts in a replay: where each hypothesis of a bank believes the aircraft to be, told in the world of the start."""

from __future__ import annotations

from typing import Any

import numpy as np

from uavlab.flight.log import Log
from uavlab.flight.worlds import flown_by
from uavlab.types import Array
from uavlab.views import props, style
from uavlab.views.scene import Scene

HIDDEN = 1e-3  # size of a ghost that nobody believes in


def add_hypotheses(
    scene: Scene, node: str, log: Log, key: props.Keys, size: float, radius: float
) -> dict[str, Any]:
    """A pale aircraft and a thin trail for each hypothesis, while it is reliable.

    Parameters
    ----------
    scene, node
        Where to draw, and below which path.
    log : Log
        Told in the world of the start.
    key : Keys
        Key frames.
    size, radius : float
        Scale of the aircraft [1], radius of trails [m].

    Returns
    -------
    dict
        For the page: ``ghosts``, the nodes that have a trail, and ``flies``, who flew from when on.
    """
    w, trails = log.worlds, []
    for k in range(len(w.names)):
        seen = w.reliable[key.rows, k]
        if not seen.any():
            continue
        at, color = f"{node}/hypothesis {k}", style.hypothesis(k)
        r = _held(w.r[key.rows, k], seen)
        R = _turned(log.R_e[key.rows], w.heading[key.rows, k])
        props.add_aircraft(scene, f"{at}/aircraft", log, size, ghost=color)
        shown = np.where(seen, 1.0, HIDDEN)
        scene.move(f"{at}/aircraft", key.t, r=r, R=R, scale=np.repeat(shown[:, None], 3, axis=1))
        if props.add_trail(scene, f"{at}/trail", r, radius, color):
            trails.append(at)
    start = float(log.t[0]) if len(log.t) else 0.0
    flies = [
        {"from": round(t - start, 3), "name": name or "the start", "color": _color(w.names, name)}
        for t, _, name in flown_by(log)
    ]
    return {"ghosts": trails, "flies": flies if w.names else []}


def _color(names: tuple[str, ...], name: str) -> str:
    return style.hypothesis(names.index(name)) if name in names else "#999999"


def _held(r: Array, seen: Array) -> Array:
    """Places (K, 3), held where nobody believes in them: the last that was believed in, or the first."""
    good = np.flatnonzero(seen)
    return r[good[(np.searchsorted(good, np.arange(len(r)), side="right") - 1).clip(0)]]


def _turned(R: Array, heading: Array) -> Array:
    """Attitudes (K, 3, 3) turned about the vertical to headings (K,) [rad]."""
    turn = heading - np.arctan2(R[:, 1, 0], R[:, 0, 0])
    c, s, o = np.cos(turn), np.sin(turn), np.zeros(len(turn))
    Rz = np.stack([np.stack([c, -s, o], 1), np.stack([s, c, o], 1), np.stack([o, o, o + 1], 1)], 1)
    return Rz @ R
