"""Who is in the picture, how big, and where: shared by the still picture and the replay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from uavlab.errors import BadInput
from uavlab.flight.log import Log
from uavlab.flight.worlds import told
from uavlab.types import Array, Vec3
from uavlab.views import style
from uavlab.views.guards import Guards, guards_of, settled

QUAD_X = (
    np.pi / 4,
    3 * np.pi / 4,
    -3 * np.pi / 4,
    -np.pi / 4,
)  # what is drawn for a log without airframe


def cast(logs: Log | Sequence[Log] | Mapping[str, Log]) -> dict[str, Log]:
    """Flights by label, each told in the world in which it began and cut where its pose stops being finite.

    Raises
    ------
    BadInput
        There is no flight, or something that is not a `Log`.
    """
    if isinstance(logs, Log):
        named = {"flown": logs}
    elif isinstance(logs, Mapping):
        named = {str(k): v for k, v in logs.items()}
    else:
        named = {("flown" if k == 0 else f"flight {k + 1}"): log for k, log in enumerate(logs)}
    if not named:
        raise BadInput(
            "there is no flight to draw; give a Log, a list of them, or {'label': log, …}."
        )
    for label, log in named.items():
        if not isinstance(log, Log):
            raise BadInput(f"{label!r} is a {type(log).__name__}; a uavlab Log is needed.")
    return {label: told(settled(style.whole(log))) for label, log in named.items()}


def rotor_places(log: Log) -> tuple[Array, Array, float]:
    """Where the rotors are.

    Returns
    -------
    tuple
        Places (n, 3) [m] in the body; spins (n,), +1 for a rotor that turns clockwise, seen from above (its drag
        pushes the airframe counter-clockwise, as in `uavlab.plant.Airframe`); radius [m].
    """
    angles = np.asarray(log.meta.get("angles") or QUAD_X, dtype=float)
    n = len(angles)
    arm = float(log.meta.get("arm") or 0.25)
    spins = np.asarray(log.meta.get("spins") or [(-1) ** k for k in range(n)], dtype=float)
    places = arm * np.stack([np.cos(angles), np.sin(angles), np.zeros(n)], axis=1)
    gap = 2 * arm * np.sin(np.pi / max(n, 2))  # between neighbours, so that discs do not overlap
    return places, spins, float(min(0.44 * gap, 0.62 * arm))


def drawn_scale(flights: Mapping[str, Log]) -> float:
    """By how much aircraft are drawn larger than they are, so that they are seen on a long path."""
    low, high = in_view(flights)
    arm = float(next(iter(flights.values())).meta.get("arm") or 0.25)
    scale = 0.055 * float(np.linalg.norm(high - low)) / arm
    return max(1.0, round(scale, 1 if scale < 10 else 0))


def bounds(flights: Mapping[str, Log]) -> tuple[Vec3, Vec3]:
    """Lowest and highest corner of all that was flown and asked [m], each (3,).

    What was asked below the ground does not count: who lands is asked down until the ground is felt.
    """
    points = [log.r for log in flights.values()] + [log.r_d for log in flights.values()]
    rows = np.concatenate([p[np.isfinite(p).all(axis=1)] for p in points] or [np.zeros((0, 3))])
    if not len(rows):
        return np.zeros(3), np.zeros(3)
    flown = [log.r[:, 2] for log in flights.values()]
    least = min([0.0, *(float(z.min()) for z in flown if np.isfinite(z).all() and len(z))])
    low = rows.min(axis=0)
    return np.array([low[0], low[1], max(low[2], least)]), rows.max(axis=0)


def guards_in(flights: Mapping[str, Log]) -> Guards:
    """Area, no-fly zones and obstacles of the first flight."""
    return guards_of(next(iter(flights.values())))


def in_view(flights: Mapping[str, Log], most: float = 2.5) -> tuple[Vec3, Vec3]:
    """`bounds`, and of the first flight's area, zones and obstacles what leaves the aircraft in sight.

    A side grows to a wall that is near: none is moved so far that the picture is wider than `most` times the longest
    side that was flown. What is farther away is not looked for.
    """
    low, high = bounds(flights)
    room = (most - 1.0) / 2.0 * max(float((high - low).max()), 2.0)
    least, greatest = low - room, high + room
    for a, b in guards_in(flights).extents:
        if (a < greatest).all() and (b > least).all():
            low = np.where(a >= least, np.minimum(low, a), low)
            high = np.where(b <= greatest, np.maximum(high, b), high)
    return low, high


def frame_of(flights: Mapping[str, Log], least: float = 2.0) -> tuple[Vec3, Vec3]:
    """What is `in_view`, with the ground in it, a margin, and no side shorter than `least` [m]."""
    low, high = in_view(flights)
    low = np.array([low[0], low[1], min(0.0, low[2])])
    room = 0.06 * float(np.linalg.norm(high - low))  # an aircraft at the edge is inside
    margin = np.maximum(room, (least - (high - low)) / 2)
    low, high = low - margin, high + margin
    if low[2] < 0.0 <= low[2] + margin[2] + 1e-9:  # the floor stays the floor
        high[2], low[2] = high[2] - low[2], 0.0
    return low, high
