"""The fence: a safety area seen from the world of the estimate, whichever that is (MRS Sec. 7.2)."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from uavlab.area import Area
from uavlab.frames import NO_SHIFT, Shift, inverse, moved
from uavlab.interfaces import Goal
from uavlab.so3 import about_z
from uavlab.types import Estimate, Reference, Vec3

CLEAR = 0.01  # [m] inside the border: where a reference is put that would leave it


def way_in(area: Area, estimate: Estimate) -> Shift | None:
    """The way from the world of the estimate to that of the area; None while nobody knows it."""
    if area.world == "":
        return NO_SHIFT if estimate.shift is NO_SHIFT else inverse(estimate.shift)
    if area.world == estimate.world:
        return NO_SHIFT
    if area.world in estimate.worlds:
        return inverse(estimate.worlds[area.world])
    return None


def unknown(area: Area, estimate: Estimate) -> str:
    """What is said of a goal while nobody knows where the area is."""
    known = ", ".join(sorted(estimate.worlds)) or "none"
    return f"the safety area is told in the world {area.world!r}, and nobody knows now where that lies (known: {known})"


def why_not(area: Area | None, estimate: Estimate, goal: Goal, now: Vec3) -> str:
    """Why a goal, told in the world of the estimate, may not be flown to by who is at `now` (3,) [m]; empty: it may."""
    if area is None:
        return ""
    shift = way_in(area, estimate)
    if shift is None:
        return unknown(area, estimate)
    if shift is NO_SHIFT:
        return area.why_not(goal, now)
    return area.why_not(moved(goal, shift), point(now, shift))


def point(r: Vec3, shift: Shift) -> Vec3:
    """A place (3,) [m], told in another world."""
    return r if shift is NO_SHIFT else about_z(shift.heading) @ r + shift.r


def fenced(area: Area | None, estimate: Estimate, reference: Reference) -> Reference:
    """The reference itself; or the nearest one inside, if it has left the area (not: below it) or is in a no-fly zone.

    What leads out of the area is refused before it is flown. This is for what nobody can refuse: a landing that needs
    more room to stop than there is, or the centimetres by which a tracker goes beyond a goal on the border.
    """
    shift = None if area is None else way_in(area, estimate)
    if area is None or shift is None:
        return reference
    r = point(reference.r, shift)
    xy = _kept(area, r)
    if xy is None and r[2] <= area.high:
        return reference
    x, y = xy or r[:2]
    there = point(np.array((x, y, min(r[2], area.high))), inverse(shift))
    out = there - reference.r
    size = float(out @ out)
    v = reference.v
    if size > 0.0:  # what leads farther out is taken off
        n = out / np.sqrt(size)
        v = v - n * min(float(v @ n), 0.0)
    zero = np.zeros(3)
    return reference._replace(r=there, v=v, a=zero, j=zero)


def _kept(area: Area, r: Vec3) -> tuple[float, float] | None:
    """The nearest allowed place to `r`, world of the area, if it is not allowed itself."""
    import shapely

    room, inner, zones = _plans(area)
    x, y, at = float(r[0]), float(r[1]), None
    if not shapely.contains_xy(room, x, y):
        at = _nearest(inner, x, y)
    for low, high, zone, outer in zones:
        x, y = at or (x, y)
        if low < r[2] < high and shapely.contains_xy(zone, x, y):
            at = _nearest(outer, x, y)
    return at


def _nearest(line: Any, x: float, y: float) -> tuple[float, float]:
    import shapely

    at = line.interpolate(line.project(shapely.Point(x, y)))
    return float(at.x), float(at.y)


@lru_cache(maxsize=32)
def _plans(area: Area) -> tuple[Any, Any, tuple[tuple[float, float, Any, Any], ...]]:
    """The area and its zones from above, and the lines to which what is outside is brought."""
    import shapely

    room = shapely.Polygon(area.border)
    inner = room.buffer(-CLEAR, join_style="mitre")
    zones = []
    for zone in area.no_fly:
        plan = shapely.Polygon(zone.border)
        outer = plan.buffer(CLEAR, join_style="mitre").exterior
        shapely.prepare(plan)
        zones.append((zone.low, zone.high, plan, outer))
    shapely.prepare(room)
    return room, (room if inner.is_empty else inner).boundary, tuple(zones)
