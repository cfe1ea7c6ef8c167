"""Safety area, no-fly zones and obstacles in still pictures: in perspective, from above, from the side."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from uavlab.types import Array, Vec3
from uavlab.views import style
from uavlab.views.guards import Guards, Zone


def draw_space(at: Any, guards: Guards, low: Vec3, high: Vec3) -> None:
    """Outlines in a picture in perspective, as far as they lie between the corners `low` and `high` [m]."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    named = set()
    for points, color, label, width in _lines(guards, low, high):
        inside = _inside(points, low, high)
        if np.isfinite(inside).any():
            at.plot(*inside.T, color=color, label="" if label in named else label, lw=width)
            named.add(label)
    for zone in guards.no_fly:
        if np.all((zone.border >= low[:2]) & (zone.border <= high[:2])):
            z0, z1 = _heights(zone, low[2], high[2])
            walls = [
                [[*p, z0], [*q, z0], [*q, z1], [*p, z1]]
                for p, q in zip(zone.border, np.roll(zone.border, -1, 0), strict=True)
            ]
            at.add_collection3d(Poly3DCollection(walls, facecolor=style.NO_FLY, alpha=0.12, lw=0))


def _heights(zone: Zone, low: float, high: float) -> tuple[float, float]:
    return max(zone.low, float(low)), min(zone.high, float(high))


def _lines(guards: Guards, low: Vec3, high: Vec3) -> Iterator[tuple[Array, str, str, float]]:
    """All outlines: points (N, 3) [m], colour, what it is, width."""
    zones = [(zone, style.NO_FLY, "no-fly zone") for zone in guards.no_fly]
    zones += [(guards.area, style.AREA, "safety area")] if guards.area else []
    for zone, color, label in zones:
        ends = _heights(zone, low[2], high[2])
        closed = np.concatenate([zone.border, zone.border[:1]])
        for z in ends:
            yield np.column_stack([closed, np.full(len(closed), z)]), color, label, 1.1
        for p in zone.border:
            yield np.array([[*p, z] for z in ends]), color, label, 0.8
    turn = np.linspace(0.0, 2 * np.pi, 25)
    for x, y, radius, height in guards.obstacles.tolist():
        ring = np.stack([x + radius * np.cos(turn), y + radius * np.sin(turn)], axis=1)
        for z in (0.0, height):
            yield np.column_stack([ring, np.full(len(ring), z)]), style.OBSTACLE, "obstacle", 1.0
        for p in ring[:-1:4]:
            yield np.array([[*p, 0.0], [*p, height]]), style.OBSTACLE, "obstacle", 0.8


def _inside(points: Array, low: Vec3, high: Vec3) -> Array:
    """A polyline (N, 3), finely cut, NaN where it is not between two corners (3,) [m]."""
    s = np.linspace(0.0, len(points) - 1.0, 60 * (len(points) - 1) + 1)
    fine = np.stack([np.interp(s, np.arange(len(points)), x) for x in points.T], axis=1)
    good = np.all((fine >= low - 1e-9) & (fine <= high + 1e-9), axis=1)
    return np.where(good[:, None], fine, np.nan)


def draw_flat(at: Any, guards: Guards, low: float, high: float, *, up: bool) -> None:
    """Outlines from above (x, y), or, if `up`, from the side (x, z); what has no end ends at `low` and `high` [m]."""
    from matplotlib.patches import Circle, Polygon

    def patch(made: Any, label: str, **how: Any) -> None:
        known = at.get_legend_handles_labels()[1]
        made.set(label="_" if label in known else label, zorder=0.5, **how)
        at.add_patch(made)

    def shape(zone: Zone) -> Any:
        x, ends = zone.border[:, 0], _heights(zone, low, high)
        return _box(x.min(), x.max(), *ends) if up else Polygon(zone.border, closed=True)

    if guards.area:
        patch(shape(guards.area), "safety area", fill=False, ec=style.AREA, lw=1.4)
    for zone in guards.no_fly:
        patch(
            shape(zone), "no-fly zone", fc=f"{style.NO_FLY}30", ec=style.NO_FLY, hatch="//", lw=0.9
        )
    for x, y, radius, height in guards.obstacles.tolist():
        made = _box(x - radius, x + radius, 0.0, height) if up else Circle((x, y), radius)
        patch(made, "obstacle", fc=f"{style.OBSTACLE}90", ec=style.OBSTACLE, lw=0.8)


def _box(x0: float, x1: float, z0: float, z1: float) -> Any:
    from matplotlib.patches import Polygon

    return Polygon([[x0, z0], [x1, z0], [x1, z1], [x0, z1]], closed=True)
