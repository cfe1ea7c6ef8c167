"""What goes wrong with an instrument on purpose: jumps that stay, and outliers that do not.

Chance of a fault is taken from the one number that also decides on drop-out, so that a fault that is switched on leaves
every other reading as it was.
"""

from __future__ import annotations

from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import NO_SHIFT, Shift, compose
from uavlab.sensors.line import Outage
from uavlab.types import Array, Vec3


class Jump(NamedTuple):
    """From time `t` on, `by` is added to what is read, and `turn` to how it is turned. It stays."""

    t: float  # [s]
    by: Any = 0.0  # in the unit of the reading: one number, or as many as it has
    turn: Any = 0.0  # [rad] about the world's z (poses, attitudes); (3,) of an IMU's gyro [rad/s]


class Outliers(NamedTuple):
    """Single readings that are wrong by a given size, in a direction that nobody knows."""

    probability: float = 0.0  # of each reading
    size: float = 0.0  # in the unit of the reading
    turn: float = 0.0  # [rad], of poses, attitudes and bearings; [rad/s] of an IMU's gyro


NO_OUTLIERS = Outliers()


def jumped(t: float, jumps: tuple[Jump, ...]) -> tuple[Any, Any]:
    """The sum of all jumps until `t` [s]: by and turn, 0.0 without any."""
    by: Any = 0.0
    turn: Any = 0.0
    for jump in jumps:
        if t >= jump.t:
            by, turn = by + np.asarray(jump.by, dtype=float), turn + np.asarray(jump.turn)
    return by, turn


def jumped_world(t: float, jumps: tuple[Jump, ...]) -> Shift:
    """All jumps until `t` [s] as one change of world, in their order."""
    shift = NO_SHIFT
    for jump in jumps:
        if t >= jump.t:
            by = np.broadcast_to(np.asarray(jump.by, dtype=float), 3)
            shift = compose(Shift(by, float(jump.turn)), shift)
    return shift


def outlier(chance: float, outliers: Outliers, n: int = 3) -> tuple[Array | float, Vec3 | float]:
    """How wrong this reading is: (n,) in its unit and (3,) [rad]; zeros unless it is an outlier.

    `chance` is the sample's uniform number in [0, 1): low ones are lost, high ones are outliers. The direction comes
    from a generator of its own that `chance` seeds.
    """
    if chance < 1.0 - outliers.probability:
        return 0.0, 0.0
    own = np.random.default_rng(int(chance * 2.0**53))
    direction, axis = own.standard_normal(n), own.standard_normal(3)
    by = outliers.size / np.linalg.norm(direction) * direction
    return by, outliers.turn / np.linalg.norm(axis) * axis


def within(t: float, times: tuple[Outage, ...], after: float = 0.0) -> bool:
    """Whether `t` [s] lies in one of the `times`, or less than `after` [s] behind one."""
    return any(a <= t < b + after for a, b in times)


def check_faults(
    name: str,
    dropout: float,
    jumps: tuple[Jump, ...],
    outliers: Outliers,
    *,
    by: int = 3,
    turn: int = 0,
) -> None:
    """Refuse faults that this instrument cannot have.

    Parameters
    ----------
    name : str
        Of the instrument.
    dropout : float
        Its probability.
    jumps, outliers : tuple of Jump, Outliers
        The faults.
    by, turn : int
        How many numbers a jump of the reading and of its rotation has; 0: such a reading has none.

    Raises
    ------
    BadInput
        Names the field, its value, the bound.
    """
    p = outliers.probability
    if not (p >= 0.0 and dropout + p <= 1.0):
        raise BadInput(
            f"{name}: outliers.probability is {p}; it must lie between 0 and 1 − dropout ({1.0 - dropout:g})."
        )
    for field, n in (("size", by), ("turn", turn)):
        value = getattr(outliers, field)
        if not (isfinite(value) and value >= 0.0) or (value and not n):
            bound = "a finite number ≥ 0" if n else "0: this instrument reads no such thing"
            raise BadInput(f"{name}: outliers.{field} is {value}; it must be {bound}.")
    for jump in jumps:
        if not isfinite(jump.t):
            raise BadInput(f"{name}: a jump is at t = {jump.t} s; it must be finite.")
        check_vectors(f"{name}: jump at {jump.t:g} s", by, by=jump.by)
        check_vectors(f"{name}: jump at {jump.t:g} s", turn, turn=jump.turn)


def check_vectors(name: str, n: int, **values: object) -> None:
    """Refuse what is not one finite number or `n` of them; with `n` = 0, what is not zero.

    Raises
    ------
    BadInput
        Names the field, its value and the bound.
    """
    for field, value in values.items():
        try:
            x = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            raise BadInput(f"{name}: {field} is {value!r}; numbers are needed.") from None
        if n == 0 and x.any():
            raise BadInput(f"{name}: {field} is {value}; this instrument reads no such thing: 0.")
        if x.shape not in {(), (n,)} or not np.isfinite(x).all():
            many = f"one finite number or {n}" if n > 1 else "one finite number"
            raise BadInput(f"{name}: {field} is {value}; it must be {many}.")


def check_times(name: str, **fields: tuple[Outage, ...]) -> None:
    """Refuse intervals that end before they start.

    Raises
    ------
    BadInput
        Names the field and the interval.
    """
    for field, times in fields.items():
        for start, end in times:
            if not start <= end:
                raise BadInput(
                    f"{name}: {field} from {start} to {end} s ends before it starts; swap them."
                )


def check_number(name: str, field: str, value: float, low: float, high: float, unit: str) -> None:
    """Refuse a number outside [`low`, `high`].

    Raises
    ------
    BadInput
        Names the field, its value and the bounds.
    """
    if not (isinstance(value, int | float) and low <= value <= high):
        raise BadInput(
            f"{name}: {field} is {value} {unit}; it must lie between {low:g} and {high:g}."
        )
