"""Where a flight may not be: safety area, no-fly zones and obstacles of a log, and how they stand in a replay."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uavlab.flight.log import Log
from uavlab.flight.worlds import told
from uavlab.so3 import about_z
from uavlab.types import Array, Vec3
from uavlab.views import style


class Zone(NamedTuple):
    """An upright prism."""

    border: Array  # (K, 2) [m] corners, in order, world of the start
    low: float  # [m]; −inf: from the ground, and from below it
    high: float  # [m]; inf: as high as one can see
    name: str


class Guards(NamedTuple):
    """What a log tells of where it may not be flown."""

    area: Zone | None  # outside of it one may not be
    no_fly: tuple[Zone, ...]  # inside of these one may not be
    obstacles: Array  # (M, 4) x, y, radius, height [m]

    def __bool__(self) -> bool:
        return self.area is not None or bool(self.no_fly) or len(self.obstacles) > 0

    @property
    def extents(self) -> list[tuple[Vec3, Vec3]]:
        """Lowest and highest corner of each thing [m], each (3,); what has no end up or down counts from the ground."""
        found = []
        for zone in [*self.no_fly, *([self.area] if self.area else [])]:
            low, high = (x if np.isfinite(x) else 0.0 for x in (zone.low, zone.high))
            corners = zone.border.min(axis=0), zone.border.max(axis=0)
            found.append((np.array([*corners[0], low]), np.array([*corners[1], max(low, high)])))
        for x, y, radius, height in self.obstacles.tolist():
            low, high = [x - radius, y - radius, 0.0], [x + radius, y + radius, height]
            found.append((np.array(low), np.array(high)))
        return found


def guards_of(log: Log) -> Guards:
    """What `log.meta` tells; empty for a log that tells nothing."""
    given = log.meta.get("area") or {}
    area = _zone(given, "area") if given.get("border") is not None else None
    zones = tuple(
        _zone(x, str(x.get("name") or f"no-fly zone {k + 1}"))
        for k, x in enumerate(given.get("no_fly") or [])
    )
    obstacles = np.asarray(log.meta.get("obstacles") or [], dtype=float).reshape(-1, 4)
    return Guards(area, zones, obstacles)


def settled(log: Log) -> Log:
    """The log with its area told in the world of the start; one that is told there already comes back unchanged.

    A hypothesis may drift against the start. What counts is where its world lay when it began to fly, or, if it never
    did, when it was first reliable.

    Parameters
    ----------
    log : Log
        As flown: not yet `uavlab.flight.worlds.told`.
    """
    area, w = log.meta.get("area") or {}, log.worlds
    if area.get("world") not in w.names:
        return log
    turn, r = _world(log, w.names.index(area["world"]))
    R = about_z(turn)

    def moved(zone: dict[str, Any]) -> dict[str, Any]:
        border = (np.asarray(zone["border"], dtype=float) - r[:2]) @ R[:2, :2]
        heights = {x: zone[x] - r[2] for x in ("low", "high") if zone.get(x) is not None}
        return zone | {"border": border.tolist()} | heights

    zones = [moved(x) for x in area.get("no_fly") or []]
    return log._replace(meta=log.meta | {"area": moved(area) | {"no_fly": zones, "world": ""}})


def _world(log: Log, k: int) -> tuple[float, Vec3]:
    """World of the start → world of hypothesis `k`: its turn [rad] and shift (3,) [m]."""
    w = log.worlds
    if (w.flies == k).any():
        i = int(np.argmax(w.flies == k))
        return float(w.shift_heading[i]), w.shift_r[i]
    if not w.reliable[:, k].any():
        return 0.0, np.zeros(3)
    i, now = int(np.argmax(w.reliable[:, k])), told(log)
    turn = float(w.heading[i, k] - np.arctan2(now.R_e[i, 1, 0], now.R_e[i, 0, 0]))
    return turn, w.r[i, k] - about_z(turn) @ now.r_e[i]


def _zone(zone: dict[str, Any], name: str) -> Zone:
    low, high = zone.get("low"), zone.get("high")
    return Zone(
        np.asarray(zone["border"], dtype=float).reshape(-1, 2),
        -np.inf if low is None else float(low),
        np.inf if high is None else float(high),
        name,
    )


def add_guards(scene: Any, guards: Guards, low: Vec3, high: Vec3, thick: float) -> list[list[str]]:
    """Walls of the area, no-fly prisms, obstacles.

    Parameters
    ----------
    scene : uavlab.views.scene.Scene
        Where to.
    guards : Guards
        Of the log.
    low, high : Vec3
        What is looked at [m]: a zone without an end ends a little beyond.
    thick : float
        [m] of outlines.

    Returns
    -------
    list
        Rows for the legend: colour, text.
    """
    floor, top = float(low[2]), float(high[2]) + 0.15 * float(high[2] - low[2])
    legend = []
    if guards.area is not None:
        _add_prism(scene, "uavlab/area", guards.area, floor, top, thick, style.AREA, 0.07)
        legend.append([style.AREA, "safety area"])
    for k, zone in enumerate(guards.no_fly):
        at = f"uavlab/no-fly {k + 1}"
        _add_prism(scene, at, zone, floor, top, thick, style.NO_FLY, 0.28, lid=True)
    for k, (x, y, radius, height) in enumerate(guards.obstacles.tolist()):
        _add_obstacle(scene, f"uavlab/obstacle {k + 1}", x, y, radius, height)
    legend += [[style.NO_FLY, "no-fly zone"]] if guards.no_fly else []
    legend += [[style.OBSTACLE, "obstacle"]] if len(guards.obstacles) else []
    return legend


def _add_prism(
    scene: Any, at: str, zone: Zone, floor: float, top: float, thick: float, color: str,
    opacity: float, *, lid: bool = False,
) -> None:  # fmt: skip
    """Walls, outlines at both heights and along the edges; a lid, if it is asked for."""
    from uavlab.views.scene import look, mesh, tubes

    z0, z1 = max(zone.low, floor), min(zone.high, max(top, zone.low + 1.0))
    n = len(zone.border)
    bottom = np.column_stack([zone.border, np.full(n, z0)])
    upper = np.column_stack([zone.border, np.full(n, z1)])
    k = np.arange(n)
    ahead = (k + 1) % n
    faces = np.concatenate([
        np.stack([k, ahead, ahead + n], axis=1), np.stack([k, ahead + n, k + n], axis=1)
    ])  # fmt: skip
    if lid:
        faces = np.concatenate([faces, triangles(zone.border) + n])
    scene.add(f"{at}/walls", mesh(np.concatenate([bottom, upper]), faces), look(color, opacity))
    pairs = [(bottom, bottom[ahead]), (upper, upper[ahead]), (bottom, upper)]
    edges = [np.array(ends) for a, b in pairs for ends in zip(a, b, strict=True)]
    scene.add(f"{at}/outline", tubes(edges, thick), look(color, 0.8))


def _add_obstacle(scene: Any, at: str, x: float, y: float, radius: float, height: float) -> None:
    from uavlab.views.scene import cone, look

    shape, r, R = cone(np.array([x, y, 0.0]), np.array([x, y, height]), radius, radius)
    scene.add(at, shape, look(style.OBSTACLE, 0.85))
    scene.place(at, r, R)


def triangles(border: Array) -> Array:
    """A polygon cut into triangles, ear by ear: corners (K, 2) in order → indices, shape (K − 2, 3)."""
    x, y = np.asarray(border, dtype=float).T
    turn = np.sign(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))

    def cross(a: int, b: int, c: int) -> float:
        return float(turn * ((x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a])))

    def ear(a: int, b: int, c: int, others: list[int]) -> bool:
        if cross(a, b, c) <= 0.0:
            return False
        return not any(
            min(cross(a, b, p), cross(b, c, p), cross(c, a, p)) >= 0.0
            for p in others
            if p not in {a, b, c}
        )

    left, found = list(range(len(x))), []
    while len(left) > 3:
        corners = list(zip([left[-1], *left[:-1]], left, [*left[1:], left[0]], strict=True))
        a, b, c = next((e for e in corners if ear(*e, left)), corners[0])  # of a bad one: any
        found.append((a, b, c))
        left.remove(b)
    return np.array([*found, tuple(left)], dtype=int)
