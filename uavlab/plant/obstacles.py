"""Obstacles: upright cylinders that stand on the ground."""

from __future__ import annotations

from typing import NamedTuple


class Obstacle(NamedTuple):
    """A tree, a pole, a tower."""

    x: float  # [m] of its axis, world
    y: float  # [m]
    radius: float  # [m]
    height: float  # [m]
