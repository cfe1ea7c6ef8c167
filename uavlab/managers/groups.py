"""Groups: which limits and which gains may be flown in the world of which estimator (MRS Sec. 7).

A tracker with other limits is another part, by another name: "MpcTracker slow"; so is a controller with other gains.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from uavlab.errors import BadInput, UnknownName
from uavlab.limits import ForceLimits

HALF = (
    "half"  # the last word of a tracker's name that leaves an MPC controller room (MRS Sec. 5.7.2)
)
OTHERS = "*"  # stands for every world that is not named


class Allowed(NamedTuple):
    """What may be flown in one world."""

    limits: tuple[str, ...]  # groups of `uavlab.limits`
    gains: tuple[str, ...]  # groups of `uavlab.gains`
    default_limits: str  # taken when those that were flown are not allowed
    default_gains: str


_ALL = ("supersoft", "soft", "tight")
_QUICK = Allowed(("slow", "medium", "fast"), _ALL, "medium", "soft")
_CAMERA = Allowed(("slow", "medium"), _ALL[:2], "slow", "soft")
# World → what may be flown. The limits are the example of mrs_uav_managers of 2020; its gains have no such list, and
# ours goes with the limits. A single estimator has no name: whoever chose it alone trusts it as satellites are trusted.
ALLOWED: Mapping[str, Allowed] = {
    "": _QUICK,
    "gnss": _QUICK,
    "rtk": _QUICK,
    "flow": _CAMERA,
    "slam": _CAMERA,
    "flow+slam": _CAMERA,
    OTHERS: Allowed(("slow",), _ALL[:2], "slow", "supersoft"),
}


def allowed_in(table: Mapping[str, Allowed], world: str) -> Allowed:
    """What may be flown in a world."""
    return table[world] if world in table else table[OTHERS]


def checked(table: Mapping[str, Allowed]) -> Mapping[str, Allowed]:
    """The same table, if every world has an answer.

    Raises
    ------
    BadInput
        Nothing is said of the worlds that are not named, or a default is none of what is allowed.
    """
    if OTHERS not in table:
        raise BadInput(f"allowed has no {OTHERS!r}, which stands for all other worlds; add it.")
    for world, may in table.items():
        for kind in ("limits", "gains"):
            groups, default = getattr(may, kind), getattr(may, f"default_{kind}")
            if default not in groups:
                raise BadInput(
                    f"allowed[{world!r}].default_{kind} is {default!r}; it must be one of {', '.join(groups)}."
                )
    return table


def fallback(
    table: Mapping[str, Allowed], world: str, kind: str, group: str, aboard: Iterable[str]
) -> str:
    """The group of `kind` ("limits" or "gains") that flies on in a world: this one if it may, else the default.

    Parameters
    ----------
    table : mapping of str to Allowed
        By world.
    world : str
        Of the estimate.
    kind, group : str
        What flies now.
    aboard : iterable of str
        The groups for which there are parts; one that is not among them is not chosen.
    """
    may = allowed_in(table, world)
    groups, default, has = getattr(may, kind), getattr(may, f"default_{kind}"), tuple(aboard)
    if group in groups or not has:
        return group
    return next((x for x in (default, *groups) if x in has), group)


def why_not(
    table: Mapping[str, Allowed], world: str, kind: str, group: str, aboard: Iterable[str]
) -> str:
    """Why this group of limits or gains may not be flown now; empty: it may. The parameters are those of `fallback`."""
    has, may = tuple(aboard), allowed_in(table, world)
    if group not in has:
        return str(UnknownName(f"group of {kind} aboard", group, has))
    groups = getattr(may, kind)
    if group not in groups:
        where = f"in the world {world!r}" if world else "with this estimator"
        return f"{group!r} is not allowed {where}; {', '.join(groups)} are."
    return ""


# Names of parts ----------------------------------------------------------------------------------------


def fitting(parts: Mapping[str, Any], base: str, group: str, half: bool = False) -> str:
    """The name of the part that fits best: of this group and halved if there is one, else of its own pace."""
    names = (f"{base} {group} {HALF}", f"{base} {group}", base)
    return next((x for x in names[0 if half else 1 :] if x in parts), base)


def split(name: str, groups: Iterable[str]) -> tuple[str, str]:
    """A name taken apart: what it is, and its group; that is empty if it has none."""
    base, _, last = name.rpartition(" ")
    if last == HALF:
        return split(base, groups)
    return (base, last) if last in tuple(groups) else (name, "")


def groups_of(parts: Mapping[str, Any], groups: Iterable[str]) -> tuple[str, ...]:
    """Those of `groups` of which there are parts."""
    return tuple(x for x in groups if any(split(name, (x,))[1] for name in parts))


def looks_ahead(controller: Any) -> bool:
    """Whether this controller plans within limits, so that who tracks must leave it half of them (MRS Sec. 5.7.2)."""
    return isinstance(getattr(controller, "limits", None), ForceLimits)
