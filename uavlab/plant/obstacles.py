"""Obstacles: upright cylinders that stand on the ground."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, isfinite
from typing import Any, NamedTuple

from uavlab.errors import BadInput
from uavlab.types import Vec3


class Obstacle(NamedTuple):
    """A tree, a pole, a tower."""

    x: float  # [m] of its axis, world
    y: float  # [m]
    radius: float  # [m]
    height: float  # [m]


def hit(obstacles: Sequence[Obstacle], r: Vec3, radius: float) -> Obstacle | None:
    """The first obstacle that something round has hit.

    Parameters
    ----------
    obstacles : sequence of Obstacle
        What stands there.
    r : Vec3
        Its middle (3,) [m], world.
    radius : float
        Its size [m]: a ball, so that nothing depends on how it leans. Just touching is no hit.
    """
    for it in obstacles:
        aside = max(hypot(r[0] - it.x, r[1] - it.y) - it.radius, 0.0)
        above = max(r[2] - it.height, 0.0)
        if hypot(aside, above) < radius:
            return it
    return None


def checked_obstacles(obstacles: Any) -> None:
    """Refuse what cannot stand anywhere.

    Raises
    ------
    BadInput
        Names the first that is wrong, its field, the value and the bound.
    """
    for k, it in enumerate(obstacles):
        if not isinstance(it, Obstacle):
            raise BadInput(f"obstacles[{k}] is {it!r}; it must be an Obstacle.")
        for name, value in it._asdict().items():
            if not isfinite(value):
                raise BadInput(f"obstacles[{k}]: {name} is {value} m; it must be finite.")
            if name in {"radius", "height"} and not value > 0.0:
                raise BadInput(f"obstacles[{k}]: {name} is {value} m; it must be > 0.")
