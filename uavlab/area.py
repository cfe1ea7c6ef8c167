"""Where one may fly: a safety area with no-fly zones (MRS Sec. 7.2).

A safety area is an upright prism: a border, seen from above, between two heights. A no-fly zone is another one, in
which nobody may be. What is asked of an aircraft is held against them before it is flown: a place, the straight way
to it, each point of a trajectory and each way between two. The plane geometry is that of `shapely`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from uavlab.errors import BadInput
from uavlab.polygons import (
    SLACK,
    Prism,
    checked_border,
    first,
    first_crossing,
    first_leaving,
    grown,
    within,
)
from uavlab.types import Array, Reference, Trajectory, Vec3


@dataclass(frozen=True, eq=False)
class NoFly:
    """Where nobody may be. Its border, top and bottom do not belong to it.

    Parameters
    ----------
    border : (K, 2) array-like
        Corners [m] in their order, either way round, world of the area; K ≥ 3, no side crosses another.
    low, high : float
        From which height to which [m]; without them, at every height.
    name : str
        What messages call it.

    Raises
    ------
    BadInput
        One of these is not so.
    """

    border: Array
    low: float = -inf
    high: float = inf
    name: str = ""

    def __post_init__(self) -> None:
        if not (isinstance(self.name, str) and self.name.strip()):
            raise BadInput(
                f"the name of a no-fly zone is {self.name!r}; give it one, for messages."
            )
        where = f"no-fly zone {self.name!r}"
        _hold(
            self, border=checked_border(where, self.border), **_heights(where, self.low, self.high)
        )
        if self.prism(0.0).plan.is_empty:
            raise BadInput(
                f"{where}: border encloses nothing; give it a width of more than {SLACK:g} m."
            )

    def prism(self, margin: float) -> Prism:
        """The zone with each side `margin` [m] farther out; heights are as they are."""
        return Prism(grown(self.border, margin - SLACK), self.low, self.high)

    def told(self) -> dict[str, Any]:
        """Its fields, as JSON knows them."""
        return _told(self)


@dataclass(frozen=True, eq=False)
class Area:
    """Where one may fly. Its border, its lowest and its highest place belong to it.

    Parameters
    ----------
    border : (K, 2) array-like
        Corners [m] in their order, either way round; K ≥ 3, no side crosses another.
    low, high : float
        Lowest and highest place [m] that may be asked for. Take-off and landing are not held against `low`.
    no_fly : tuple of NoFly
        Where nobody may be, in the same world.
    margin : float
        How far inside the border, and outside of no-fly zones, all that is asked for must stay [m], ≥ 0. It counts
        sideways, each side moved by so much; heights are bounds as they stand.
    world : str
        In whose world all of this is told: of a hypothesis, by name; empty: the one in which the flight began.

    Raises
    ------
    BadInput
        One of these is not so, two no-fly zones have one name, or the margin leaves no place to fly.

    Notes
    -----
    MRS checks references and whole trajectories against an area like this one (Sec. 7.2). Who is already outside, or in
    a zone, may still be told to come back: the way out is not held against what it violates where it begins. Who is
    only within the margin is held against the border itself.
    """

    border: Array
    low: float
    high: float
    no_fly: tuple[NoFly, ...] = ()
    margin: float = 0.0
    world: str = ""

    def __post_init__(self) -> None:
        border = checked_border("safety area", self.border)
        heights = _heights("safety area", self.low, self.high)
        margin = _number("safety area: margin", self.margin)
        if not 0.0 <= margin < inf:
            raise BadInput(f"safety area: margin is {margin:g} m; it must be ≥ 0 and finite.")
        if not isinstance(self.world, str):
            raise BadInput(f"safety area: world is {self.world!r}; it must be a name, or empty.")
        _hold(self, border=border, margin=margin, no_fly=_zones(self.no_fly), **heights)
        if self._rooms[0].is_empty:
            raise BadInput(
                f"safety area: margin is {margin:g} m, which leaves nothing of it; take less, or a wider border."
            )

    def why_not_at(self, r: Vec3) -> str:
        """Why one may not be at `r` (3,) [m], world of the area; empty: one may."""
        return self._why_no_place(np.array([r], dtype=float), lambda _: "the place")

    def why_not_between(self, r0: Vec3, r1: Vec3) -> str:
        """Why one who is at `r0` may not fly straight to `r1`, each (3,) [m], world of the area; empty: one may.

        `r0` itself is not judged; see the notes of the class.
        """
        return self._why_no_goal(np.array([r1], dtype=float), r0, lambda _: "the place")

    def why_not(self, goal: Reference | Trajectory, now: Vec3) -> str:
        """Why one who is at `now` may not fly to a goal.

        Parameters
        ----------
        goal : Reference or Trajectory
            World of the area. Of a trajectory, each point counts, the ways between them, and the way to the first.
        now : (3,) array
            Where the aircraft, or its reference, is [m], world of the area.

        Returns
        -------
        str
            The first that is wrong, with its place and the bound; points of a trajectory are counted from 0. Empty: the
            goal may be flown.
        """
        if isinstance(goal, Trajectory):
            return self._why_no_goal(
                np.asarray(goal.r, dtype=float), now, "point {} of the trajectory".format
            )
        return self._why_no_goal(np.array([goal.r], dtype=float), now, lambda _: "the goal")

    def told(self) -> dict[str, Any]:
        """Its fields, as Python's JSON knows them (no bound is an infinity), for a log."""
        return _told(self)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and other processes get the fields, and prepare the geometry anew."""
        return type(self), tuple(getattr(self, x.name) for x in fields(self))

    # From above: first with the margin, then without ---------------------------------------------------

    @cached_property
    def _rooms(self) -> tuple[Any, Any]:
        return grown(self.border, SLACK - self.margin), grown(self.border, SLACK)

    @cached_property
    def _prisms(self) -> tuple[tuple[Prism, Prism], ...]:
        return tuple((zone.prism(self.margin), zone.prism(0.0)) for zone in self.no_fly)

    def _why_no_goal(self, r: Array, now: Vec3, name: Callable[[int], str]) -> str:
        """Why not from `now` to the first of places (N, 3), to the next, and so on."""
        return self._why_no_place(r, name) or self._why_no_way(r, np.asarray(now, float), name)

    def _why_no_place(self, r: Array, name: Callable[[int], str]) -> str:
        """Why not at the first of places (N, 3) that is wrong."""
        if not len(r):
            return "the trajectory has no points; give it one"
        if (k := first(~np.isfinite(r).all(axis=1))) is not None:
            return f"{name(k)}, {_place(r[k])} m, is not finite; give three finite numbers"
        for wrong, said in self._tests(r):
            if (k := first(wrong)) is not None:
                return f"{name(k)}, {_place(r[k])} m, lies {said(r[k])}"
        return ""

    def _tests(self, r: Array) -> Iterator[tuple[Array, Callable[[Vec3], str]]]:
        """Which of places (N, 3) are wrong in each way, shape (N,), and what is said of one that is."""
        import shapely

        room, by = self._rooms[0], f" {self.margin:g} m" if self.margin else ""
        border = "the border of the safety area" if not by else "the margin of the safety area"
        yield (
            ~shapely.intersects_xy(room, r[:, 0], r[:, 1]),
            lambda at: (
                f"{_metres(shapely.distance(room, shapely.Point(at[:2])))} outside {border}; "
                f"keep{by} within its border"
            ),
        )
        yield (
            r[:, 2] < self.low - SLACK,
            lambda at: (
                f"{_metres(self.low - at[2])} below the safety area; keep to {self.low:g} m or more"
            ),
        )
        yield (
            r[:, 2] > self.high + SLACK,
            lambda at: (
                f"{_metres(at[2] - self.high)} above the safety area; keep to {self.high:g} m or less"
            ),
        )
        for zone, (prism, _) in zip(self.no_fly, self._prisms, strict=True):
            said = f"{f'within{by} of' if by else 'in'} {_called(zone)}; keep{by} out of it"
            yield within(r, prism), lambda _, said=said: said

    def _why_no_way(self, r: Array, now: Vec3, name: Callable[[int], str]) -> str:
        """Why not from `now` to the first of the places (N, 3), or from one to the next."""
        if not np.isfinite(now).all():
            return f"where it is, {_place(now)} m, is not finite; wait until that is known"
        ways = np.stack([np.vstack([now, r[:-1]]), r], axis=1)

        def way(k: int) -> str:
            start = f"{name(k - 1)}, " if k else ""
            return f"the way from {start}{_place(ways[k, 0])} m, to {name(k)}, {_place(r[k])} m,"

        if (k := first_leaving(ways, self._rooms)) is not None:
            return f"{way(k)} leaves the safety area; keep within its border"
        for zone, prisms in zip(self.no_fly, self._prisms, strict=True):
            if (k := first_crossing(ways, prisms)) is not None:
                near = f" or its margin of {self.margin:g} m" if self.margin else ""
                return f"{way(k)} crosses {_called(zone)}{near}; fly around it"
        return ""


def from_told(told: Mapping[str, Any]) -> Area:
    """The area of which `Area.told` told; a bound that is None, as strict JSON has it, is no bound.

    Raises
    ------
    BadInput
        A field is missing, not known, or not what it must be.
    """
    try:
        zones = tuple(NoFly(**_unbounded(zone)) for zone in told.get("no_fly", ()))
        return Area(**{**_unbounded(told), "no_fly": zones})
    except TypeError as error:
        raise BadInput(f"this tells no safety area: {error}.") from None


# What is said ------------------------------------------------------------------------------------------


def _place(r: Vec3) -> str:
    return f"({', '.join(f'{round(float(x), 2) + 0.0}' for x in r)})"


def _metres(x: float) -> str:
    return f"{x:.1f} m" if x >= 0.05 else f"{x:.2g} m"


def _called(zone: NoFly) -> str:
    """Its name, and from which height to which it reaches."""
    low = f" from {zone.low:g} m" if zone.low > -inf else ""
    high = f" up to {zone.high:g} m" if zone.high < inf else ""
    return f"the no-fly zone {zone.name!r}{low}{high}"


# What an area may be -----------------------------------------------------------------------------------


def _hold(it: Area | NoFly, **values: Any) -> None:
    for name, value in values.items():
        object.__setattr__(
            it, name, value
        )  # the way in which frozen dataclasses set fields themselves


def _heights(where: str, low: Any, high: Any) -> dict[str, float]:
    low, high = _number(f"{where}: low", low), _number(f"{where}: high", high)
    if not low < high:
        raise BadInput(f"{where}: low is {low:g} m and high is {high:g} m; low must be below high.")
    return {"low": low, "high": high}


def _number(where: str, value: Any) -> float:
    good = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not good or np.isnan(value):
        raise BadInput(f"{where} is {value!r}; it must be a number in m.")
    return float(value)


def _zones(zones: Any) -> tuple[NoFly, ...]:
    names: set[str] = set()
    for k, zone in enumerate(zones):
        if not isinstance(zone, NoFly):
            raise BadInput(f"safety area: no_fly[{k}] is {zone!r}; it must be a NoFly.")
        if zone.name in names:
            raise BadInput(f"safety area: no_fly has two zones named {zone.name!r}; rename one.")
        names.add(zone.name)
    return tuple(zones)


def _told(it: Area | NoFly) -> dict[str, Any]:
    told = {x.name: getattr(it, x.name) for x in fields(it)}
    told["border"] = it.border.tolist()
    if isinstance(it, Area):
        told["no_fly"] = [zone.told() for zone in it.no_fly]
    return told


def _unbounded(told: Mapping[str, Any]) -> dict[str, Any]:
    """What was told, with infinities where there is no bound."""
    none = {"low": -inf, "high": inf}
    return {k: none[k] if k in none and v is None else v for k, v in told.items()}
