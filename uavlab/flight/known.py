"""Every part that goes by a name: those that labs ask for, those that come with uavlab, and those of other packages.

A package brings its own parts by entry points of the group ``uavlab.parts``::

    [project.entry-points."uavlab.parts"]
    MyController = "my_parts:MyController"

Nothing of it is imported before somebody asks for it by name.
"""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Mapping
from importlib.metadata import EntryPoint, distributions
from typing import Any, NamedTuple

from uavlab.errors import BadInput, UnknownName

GROUP = "uavlab.parts"
SLOTS = ("estimator", "tracker", "controller", "mission")
METHODS = ("init", "step", "reframe")  # of every part


class Asked(NamedTuple):
    """A part that a lab asks for as a whole: a class."""

    stem: str  # of the lab
    slot: str


ASKED: Mapping[str, Asked] = {
    "GeometricController": Asked("geometric", "controller"),
    "MpcController": Asked("mpc", "controller"),
    "MpcTracker": Asked("mpc", "tracker"),
}
BUILT_IN: Mapping[str, str] = {  # name → module of uavlab.parts
    "TiltAxis": "controllers",
    "HeadingController": "controllers",
    "AdaptiveController": "adaptive",
    "Failsafe": "failsafe",
    "CommandFilter": "trackers",
    "LandOff": "landoff",
    "LineTracker": "line",
    "SpeedTracker": "speed",
    "AlphaBetaGamma": "estimators",
    "FixedPriority": "priority",
    "BankEstimator": "bank",
    "ComplementaryEstimator": "complementary",
    "CoupledEstimator": "complementary",
}


class Known(NamedTuple):
    """A class that goes by a name, and where it comes from."""

    part: type
    origin: str  # "uavlab", or the package that brought it, with its version


def names() -> list[str]:
    """All names that can be asked for; what is behind those of other packages is not looked at."""
    return list(dict.fromkeys([*ASKED, *BUILT_IN, *(x.name for x in outside())]))


def outside() -> list[EntryPoint]:
    """What other packages say that they bring, by name and package."""
    found: dict[str, list[EntryPoint]] = {}
    for dist in distributions():
        try:
            points = list(dist.entry_points.select(group=GROUP))
            if points:  # of one package that is found twice, the first counts, as for an import
                found.setdefault(dist.name, points)
        except Exception:  # not even its list can be read, and nobody asked for it
            continue
    return sorted((x for xs in found.values() for x in xs), key=lambda x: (x.name, package(x)))


def package(point: EntryPoint) -> str:
    """Name and version of the package that an entry point belongs to."""
    dist = point.dist
    return "a package without a name" if dist is None else f"{dist.name} {dist.version}"


def find(name: str) -> Known:
    """The class behind a name that is not a lab's.

    Parameters
    ----------
    name : str
        Of a part that comes with uavlab, or of an entry point of another package.

    Raises
    ------
    UnknownName
        Nobody has a part of this name.
    BadInput
        An entry point cannot be loaded, is no part, or has a name that is taken; the message says which, why, and
        what to do.
    """
    points = unambiguous(name)
    if name in BUILT_IN:
        module = importlib.import_module(f"uavlab.parts.{BUILT_IN[name]}")
        return Known(getattr(module, name), "uavlab")
    if not points:
        raise UnknownName("part", name, names())
    return Known(loaded(points[0]), package(points[0]))


def unambiguous(name: str) -> list[EntryPoint]:
    """The entry points of this name: one at most, and none if the name is uavlab's.

    Raises
    ------
    BadInput
        The name is taken; see `find`.
    """
    points = [x for x in outside() if x.name == name]
    if points and (why := clash(points[-1])):
        raise BadInput(why)
    return points


def clash(point: EntryPoint) -> str:
    """Why the name of an entry point cannot be used: whose it is already; empty if it can."""
    others = [
        package(x) for x in outside() if x.name == point.name and package(x) != package(point)
    ]
    whose = "uavlab itself" if point.name in {*ASKED, *BUILT_IN} else ", ".join(others)
    if not whose:
        return ""
    return (
        f"{_where(point)}: the name {point.name!r} belongs to {whose}, too. Give the entry point another name, or "
        f"uninstall {package(point)}."
    )


def loaded(point: EntryPoint) -> type:
    """The class of an entry point.

    Raises
    ------
    BadInput
        It cannot be imported, is no class, or is a class that is no part.
    """
    try:
        part = point.load()
    except (Exception, SystemExit) as error:  # somebody else's code: anything may come
        said = " ".join(f"{type(error).__name__}: {error}".split())
        raise BadInput(
            f"{_where(point)} cannot be loaded: {said}. Mend that package, or uninstall it."
        ) from error
    if why := no_part(part):
        raise BadInput(f"{_where(point)} {why} Mend the entry point, or uninstall that package.")
    return part


def no_part(part: Any) -> str:
    """Why this is no class that can fly; empty if it is one."""
    if not isinstance(part, type):
        return f"is {part!r}, no class; let it name the class itself."
    slot = getattr(part, "slot", None)
    if slot not in SLOTS:
        return f'has slot {slot!r}; write slot = "…" in the class, one of {", ".join(SLOTS)}.'
    missing = [x for x in METHODS if not callable(getattr(part, x, None))]
    if missing:
        return f"has no {' and no '.join(missing)}; see uavlab.interfaces for what a {slot} does."
    return ""


def slot_of(name: str) -> str:
    """Where the part of this name belongs.

    Raises
    ------
    UnknownName, BadInput
        As `find`.
    """
    return ASKED[name].slot if name in ASKED else str(find(name).part.slot)  # type: ignore[attr-defined]


def told(part: Any, airframe: Any) -> dict[str, Any]:
    """What a part is told of its aircraft: those of its parameters that are called mass [kg] or curve.

    Parameters
    ----------
    part : callable
        A class; its signature says what it wants to know.
    airframe : Airframe
        From `uavlab.plant.load_airframe`.
    """
    from uavlab.parts.throttle import ThrustCurve

    curve = ThrustCurve(float(airframe.a_t), float(airframe.b_t))
    knows = {"mass": float(airframe.m), "curve": curve}
    try:
        wanted = inspect.signature(part).parameters
    except (TypeError, ValueError):  # a class in C, say
        return {}
    return {key: value for key, value in knows.items() if key in wanted}


def listed() -> list[tuple[str, str, str, str]]:
    """Every part that goes by a name: its name, its slot, where it comes from, and what it is or why it cannot fly."""
    rows = [
        (name, asked.slot, f"lab {asked.stem}", "What this lab asks for: yours, else the answer.")
        for name, asked in ASKED.items()
    ]
    for name in BUILT_IN:
        module = importlib.import_module(f"uavlab.parts.{BUILT_IN[name]}")
        part = getattr(module, name)
        rows.append((name, part.slot, "uavlab", _summary(part)))
    for point in outside():
        try:
            if why := clash(point):
                raise BadInput(why)
            part = loaded(point)
            rows.append((point.name, part.slot, package(point), _summary(part)))  # type: ignore[attr-defined]
        except BadInput as error:
            rows.append((point.name, "broken", package(point), str(error)))
    return rows


def _where(point: EntryPoint) -> str:
    return f"entry point {point.name} = {point.value} of package {package(point)}"


def _summary(part: type) -> str:
    return " ".join(
        str(inspect.getdoc(part) or "It says nothing of itself.").split("\n\n")[0].split()
    )
