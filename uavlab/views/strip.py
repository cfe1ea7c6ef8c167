"""The story in a replay: a trail in the colours of modes, marks where something happened, and what the page tells."""

from __future__ import annotations

from typing import Any

import numpy as np

from uavlab.flight.log import Log
from uavlab.views import props, story, style
from uavlab.views.scene import Scene, ball, box, look

_MARKED = ("safety", "bumper")  # and whatever took over


def trail_colors(log: Log, key: props.Keys) -> list[str] | None:
    """The colour of the mode at each key frame; None if the log tells of no modes."""
    colors = np.full(len(log.t), "", dtype="<U7")
    for rows, color, _ in story.pieces(log):
        colors[rows] = color
    return colors[key.rows].tolist() if len(colors) and colors[0] else None


def add_marks(scene: Scene, node: str, log: Log, size: float) -> list[list[Any]]:
    """A ball where a part took over, a cube where safety stepped in.

    Parameters
    ----------
    scene, node
        Where to draw, and below which path.
    log : Log
        Told in the world of the start.
    size : float
        [m] of a mark.

    Returns
    -------
    list
        For the page: from when on [s] which node is seen.
    """
    made = []
    for k, x in enumerate(m for m in story.news(log) if m.taken or m.kind in _MARKED):
        at, row = f"{node}/event {k}", int(np.searchsorted(log.t, x.t - 1e-9))
        cube = box((1.7 * size, 1.7 * size, 1.7 * size))
        scene.add(at, ball(size) if x.taken else cube, look(x.color, 0.85))
        scene.place(at, log.r[min(row, len(log.t) - 1)])
        made.append([_since(log, x.t), at])
    return made


def page_story(log: Log) -> dict[str, Any] | None:
    """What the page needs for its caption and its strip; None if there is nothing to tell.

    Returns
    -------
    dict
        ``rows``, by mode and slot: bands [start, end, name, colour]. ``events``: [t, sentence, colour, rank], those
        that tell only how it began left out; ``faults``: bands, too. Times [s] from the first tick.
    """
    if not (len(log.t) and story.eventful(log)):
        return None
    grave = [x for x in story.news(log) if x.kind == "safety"][-1:]
    return {
        "rows": {
            kind: [_band(log, x, kind) for x in made] for kind, made in story.rows(log).items()
        },
        "events": [[_since(log, x.t), x.sentence, x.color, x.kind] for x in story.spoken(log)],
        "faults": [_band(log, x, "fault") for x in story.faults(log)],
        "why": "".join(f"{x.t:.1f} s  {x.sentence}" for x in grave),
        "inks": {name: [color, style.ink(color)] for name, color in style.MODES.items()},
    }


def _band(log: Log, x: story.Band, kind: str) -> list[Any]:
    color = {"mode": style.mode(x.name), "fault": style.MARKS["fault"]}.get(kind, "")
    return [_since(log, x.start), _since(log, x.end), x.name, color]


def _since(log: Log, t: float) -> float:
    return round(t - float(log.t[0]), 3)


def legend(log: Log, fences: list[list[str]], *, alone: bool) -> list[list[str]]:
    """Rows for the legend: colour, text; of modes, of `fences`, of marks."""
    seen = {x.name for x in story.bands(log, "mode")} if alone else set()
    rows = [[color, name] for name, color in style.MODES.items() if name in seen] + fences
    told = story.news(log)
    rows += (
        [[style.MARKS["swap"], "another took over (ball)"]] if any(x.taken for x in told) else []
    )
    for kind, text in (("safety", "safety stepped in (cube)"), ("bumper", "bumper (cube)")):
        rows += [[style.MARKS[kind], text]] if any(x.kind == kind for x in told) else []
    return rows
