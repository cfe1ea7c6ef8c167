"""Rooms and prisms over polygons: which places lie in them, which ways leave or cross them.

The plane geometry is that of `shapely`, whose questions are vectorised and quick once a polygon is prepared; it is
imported when it is first asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.types import Array

SLACK = 1e-6  # [m]; who is on a border by this much is not beyond it, whatever rounding says


class Prism(NamedTuple):
    """An upright prism, without its surface."""

    plan: Any  # prepared shapely geometry: how it looks from above [m]
    low: float  # [m]
    high: float  # [m]


def checked_border(where: str, border: Any) -> Array:
    """Corners (K, 2) [m] that go once around something and cannot be changed any more.

    Raises
    ------
    BadInput
        They do not; the message begins with `where`.
    """
    import shapely

    try:
        points = np.array(border, dtype=float)
    except (TypeError, ValueError):
        raise BadInput(
            f"{where}: border is {border!r}; it must be points [[x, y], …] in m."
        ) from None
    if points.ndim != 2 or points.shape[1] != 2 or len(points) < 3:
        raise BadInput(f"{where}: border has shape {points.shape}; it must be (K, 2) with K ≥ 3.")
    if (k := first(~np.isfinite(points).all(axis=1))) is not None:
        raise BadInput(f"{where}: border[{k}] is {points[k].tolist()}; it must be finite.")
    plan = shapely.Polygon(points)
    if not plan.is_valid:
        why = shapely.is_valid_reason(plan)
        cure = "list its corners in their order around it"
        raise BadInput(f"{where}: border crosses or touches itself ({why}); {cure}.")
    points.setflags(write=False)
    return points


def grown(border: Array, by: float) -> Any:
    """A polygon with corners (K, 2) [m] and each side moved `by` [m] outwards, prepared for many questions."""
    import shapely

    plan = shapely.Polygon(border).buffer(by, join_style="mitre")
    shapely.prepare(plan)
    return plan


def within(r: Array, prism: Prism) -> Array:
    """Which of places (N, 3) [m] lie in a prism, shape (N,)."""
    import shapely

    level = (r[:, 2] > prism.low + SLACK) & (r[:, 2] < prism.high - SLACK)
    return level & shapely.intersects_xy(prism.plan, r[:, 0], r[:, 1])


def first_leaving(ways: Array, rooms: Sequence[Any]) -> int | None:
    """The first of straight ways (M, 2, 3) [m] that is not wholly in a room, seen from above.

    `rooms` are prepared shapely geometries, the smallest first, for which all ways must be. Only the first way may
    begin outside of it: it is held against the first room in which it begins, if there is one.
    """
    import shapely

    start, way = shapely.Point(ways[0, 0, :2]), shapely.LineString(ways[0, :, :2])
    room = next((x for x in rooms if shapely.covers(x, start)), None)
    if room is not None and not shapely.covers(room, way):
        return 0
    if len(ways) == 1 or shapely.covers(rooms[0], shapely.LineString(ways[:, 1, :2])):
        return None  # thousands of ways in one question
    bad = first(~shapely.covers(rooms[0], shapely.linestrings(ways[1:, :, :2])))
    return None if bad is None else bad + 1


def first_crossing(ways: Array, prisms: Sequence[Prism]) -> int | None:
    """The first of straight ways (M, 2, 3) [m] that meets a prism.

    `prisms` are the prism and smaller ones within it. Only the first way may begin in it: it is held against the
    largest in which it does not begin, if there is one.
    """
    import shapely

    start = ways[:1, 0]
    prism = next((x for x in prisms if not within(start, x)[0]), None)
    if prism is not None and _crossing(ways[:1], prism)[0]:
        return 0
    if len(ways) == 1 or not shapely.intersects(prisms[0].plan, shapely.LineString(ways[:, 1, :2])):
        return None  # thousands of ways in one question
    bad = first(_crossing(ways[1:], prisms[0]))
    return None if bad is None else bad + 1


def _crossing(ways: Array, prism: Prism) -> Array:
    """Which of ways (M, 2, 3) meet a prism, shape (M,)."""
    import shapely

    start, along = ways[:, 0], ways[:, 1] - ways[:, 0]
    bounds = np.array([[prism.low + SLACK], [prism.high - SLACK]])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        share = (bounds - start[:, 2]) / along[:, 2]  # of each way, where it passes bottom and top
    enter, leave = np.maximum(share.min(axis=0), 0.0), np.minimum(share.max(axis=0), 1.0)
    bad = enter <= leave  # never if it is level below or above: both shares are the same infinity
    ends = [start[bad] + share[bad, None] * along[bad] for share in (enter, leave)]
    lines = shapely.linestrings(np.stack(ends, axis=1)[:, :, :2])
    bad[bad] = shapely.intersects(prism.plan, lines)
    return bad


def first(wrong: Any) -> int | None:
    """Index of the first of (N,) that is true; None if none is."""
    k = int(np.argmax(wrong))
    return k if wrong[k] else None
