"""The bumper: away from what is near, whatever was asked for (MRS Sec. 7.2; figures of mrs_uav_managers)."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, degrees, inf, isfinite, pi, sin
from typing import NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import heading, wrap
from uavlab.types import Array, Estimate, Reference, Sectors, Vec3


class Bumper(NamedTuple):
    """How near things may be. With 0 it does not look there."""

    around: float = 1.2  # [m] horizontally
    above: float = 1.2  # [m]
    below: float = 0.5  # [m] the lowest height that mrs_uav_managers lets an aircraft fly at
    overshoot: float = 0.2  # [m] farther than needed, so that it does not bump again


class Bump(NamedTuple):
    """What the bumper wants."""

    goal: Reference | None = (
        None  # where to fly now, world of the estimate; None: nothing is too near
    )
    said: str = ""  # what was near, with value and bound


FREE = Bump()


def spaced(v: float, a: float) -> Bumper:
    """The bumper for an aircraft that flies at `v` [m/s] and brakes with `a` [m/s²].

    Its distance is longer by 1.5 times the way to stop: of the limits "slow", "medium" and "fast" 1.95, 7.2 and 13.2 m.

    Raises
    ------
    BadInput
        A speed below 0, a deceleration that is not above 0, or one that is not finite.
    """
    if not (isfinite(v) and v >= 0.0 and isfinite(a) and a > 0.0):
        raise BadInput(
            f"a bumper for {v} m/s and {a} m/s²; take finite numbers, the second above 0."
        )
    return Bumper(around=Bumper().around + 1.5 * v * v / (2.0 * a))


def bumped(
    bumper: Bumper,
    sectors: Sectors,
    estimate: Estimate,
    why_not: Callable[[Reference], str] = lambda _goal: "",
) -> Bump:
    """Whether something is too near, and where to fly then.

    Straight away from the nearest sector, until it is as far as it must be and ``overshoot`` more; but where something
    is on the other side, too, no farther than half-way to it. Up and down likewise. What is asked for is a place, at
    which the aircraft stands with the heading that it has.

    Parameters
    ----------
    bumper : Bumper
        See `checked`.
    sectors : Sectors
        A reading of now.
    estimate : Estimate
        Of now.
    why_not : callable
        Why a goal, world of the estimate, may not be flown to, as `uavlab.area.Area.why_not` says it; empty: it may.

    Returns
    -------
    Bump
        If the place that it would fly to is forbidden, it stays where it is.
    """
    move, near = _around(bumper, sectors, heading(estimate.R))
    up, other = _vertical(bumper, sectors)
    near += other
    if not near:
        return FREE
    move[2] = up
    said = f"{' and '.join(near)}; it moves away"
    zero = np.zeros(3)
    goal = Reference(estimate.r + move, zero, zero, zero, heading(estimate.R), 0.0)
    if why := why_not(goal):
        goal, said = goal._replace(r=estimate.r), f"{' and '.join(near)}; it stays, for {why}"
    return Bump(goal, said)


def _around(bumper: Bumper, sectors: Sectors, eta: float) -> tuple[Vec3, list[str]]:
    """The way (3,) [m], world, horizontally away from what is near, and what that is; `eta` [rad] is the heading."""
    d = np.where(np.isnan(sectors.d), inf, sectors.d)
    i = int(np.argmin(d))
    if not d[i] < bumper.around:
        return np.zeros(3), []
    angle = 2.0 * pi * i / d.size
    way = _way(float(d[i]), _behind(d, i), bumper.around, bumper.overshoot)
    move = -way * np.array((cos(eta + angle), sin(eta + angle), 0.0))
    where = degrees(wrap(angle))
    side = "ahead" if i == 0 else f"{abs(where):.0f}° to the {'left' if where > 0 else 'right'}"
    return move, [f"something is {d[i]:.2f} m away, {side}; bound {bumper.around:g} m"]


def _behind(d: Array, i: int) -> float:
    """The distance on the other side of sector `i` [m]: the shorter of two if none lies just opposite."""
    n = d.size
    return float(min(d[(i + n // 2) % n], d[(i + (n + 1) // 2) % n]))


def _vertical(bumper: Bumper, sectors: Sectors) -> tuple[float, list[str]]:
    """How far to climb [m], and why."""
    down = inf if np.isnan(sectors.down) else sectors.down
    up = inf if np.isnan(sectors.up) else sectors.up
    if down < bumper.below and down <= up:
        said = f"the ground is {down:.2f} m below; bound {bumper.below:g} m"
        return _way(down, up, bumper.below, bumper.overshoot), [said]
    if up < bumper.above:
        said = f"something is {up:.2f} m above; bound {bumper.above:g} m"
        return -_way(up, down, bumper.above, bumper.overshoot), [said]
    return 0.0, []


def _way(near: float, behind: float, bound: float, overshoot: float) -> float:
    """How far to go [m] from what is `near` to be out of its bound, if there is so much room behind."""
    return max(min(bound + overshoot - near, (behind - near) / 2.0), 0.0)


def checked(bumper: Bumper) -> Bumper:
    """The same bumper, if it can be obeyed.

    Raises
    ------
    BadInput
        A distance that is not finite, or below 0.
    """
    for name, value in zip(bumper._fields, bumper, strict=True):
        if not (isfinite(value) and value >= 0.0):
            raise BadInput(f"bumper.{name} is {value} m; it must be finite, 0 or more.")
    return bumper
