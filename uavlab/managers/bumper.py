"""The bumper: away from what is near, whatever was asked for (MRS Sec. 7.2; figures of mrs_uav_managers)."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees, inf, isfinite, pi
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
    a: float = 2.0  # [m/s²] with which it can brake: of the limits "medium" (ours); inf: at once
    late: float = 0.4  # [s] until it does: what it is told to fly turns over that slowly (ours)


class Bump(NamedTuple):
    """What the bumper wants."""

    goal: Reference | None = (
        None  # where to fly now, world of the estimate; None: nothing is too near
    )
    said: str = ""  # what was near, with value and bound


FREE = Bump()
SPARE = 1.5  # times the way to stop, of which something must be away (mrs_uav_managers)
SLOW = 0.3  # [m/s] towards something: who was in the bumper's hands may go (ours)


def spaced(v: float, a: float) -> Bumper:
    """The bumper of mrs_uav_managers for an aircraft that may fly at `v` [m/s] and brakes with `a` [m/s²].

    Its distance is longer by 1.5 times the way to stop, however slowly it flies: of the limits "slow", "medium" and
    "fast" 1.95, 7.2 and 13.2 m. The usual `Bumper` takes the speed at which it comes nearer instead (ours): who hovers
    may stand beside a pole.

    Raises
    ------
    BadInput
        A speed below 0, a deceleration that is not above 0, or one that is not finite.
    """
    if not (isfinite(v) and v >= 0.0 and isfinite(a) and a > 0.0):
        raise BadInput(
            f"a bumper for {v} m/s and {a} m/s²; take finite numbers, the second above 0."
        )
    return Bumper(around=Bumper().around + SPARE * v * v / (2.0 * a), a=inf, late=0.0)


def bumped(
    bumper: Bumper,
    sectors: Sectors,
    estimate: Estimate,
    why_not: Callable[[Reference], str] = lambda _goal: "",
    moving: bool = False,
) -> Bump:
    """Whether something is too near, and where to fly then.

    Straight away from the sector that is nearest for the speed at which it comes nearer, until it is as far as it must
    be and ``overshoot`` more; but where something is on the other side, too, no farther than half-way to it. Up and
    down likewise. What is asked for is a place, at which the aircraft stands with the heading that it has.

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
    moving : bool
        Whether it moved away already: then it goes on until it is slow, and half of ``overshoot`` is gained.

    Returns
    -------
    Bump
        If the place that it would fly to is forbidden, it stays where it is.
    """
    move, near = _around(bumper, sectors, estimate, moving)
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


def _around(
    bumper: Bumper, sectors: Sectors, estimate: Estimate, moving: bool
) -> tuple[Vec3, list[str]]:
    """The way (3,) [m], world, horizontally away from what is near, and what that is."""
    d = np.where(np.isnan(sectors.d), inf, sectors.d)
    if not (bumper.around > 0.0 and np.isfinite(d).any()):
        return np.zeros(3), []
    angles, eta = 2.0 * pi * np.arange(d.size) / d.size, heading(estimate.R)
    ways = np.column_stack((np.cos(eta + angles), np.sin(eta + angles)))  # (n, 2), to the sectors
    quicker = np.maximum(ways @ estimate.a[:2], 0.0) * bumper.late  # until it begins to brake
    nearing = np.maximum(ways @ estimate.v[:2] + quicker, 0.0)
    bounds = bumper.around + nearing * bumper.late + SPARE * nearing**2 / (2.0 * bumper.a)
    i = int(np.argmax(bounds - d))
    if d[i] >= bounds[i] and not (moving and _held(bumper, d, nearing)):
        return np.zeros(3), []
    way = _way(float(d[i]), _behind(d, i), float(bounds[i]), bumper.overshoot)
    return -way * np.append(ways[i], 0.0), [
        f"something is {d[i]:.2f} m away, {_side(float(angles[i]))}; bound {bounds[i]:.3g} m"
    ]


def _held(bumper: Bumper, d: Array, nearing: Array) -> bool:
    """Whether who has moved away must go on: still quick, or hardly out of the bound."""
    return bool(
        nearing[np.isfinite(d)].max() > SLOW or d.min() < bumper.around + 0.5 * bumper.overshoot
    )


def _side(angle: float) -> str:
    where = degrees(wrap(angle))
    return f"{abs(where):.0f}° to the {'left' if where > 0 else 'right'}" if angle else "ahead"


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
        A distance that is not finite or below 0, or a deceleration that is not above 0.
    """
    for name, value in bumper._replace(a=0.0)._asdict().items():
        if not (isfinite(value) and value >= 0.0):
            raise BadInput(f"bumper.{name} is {value} m; it must be finite, 0 or more.")
    if not bumper.a > 0.0:
        raise BadInput(f"bumper.a is {bumper.a} m/s²; it must be above 0 (inf: it stops at once).")
    return bumper
