"""What every instrument shares: when it samples, what is lost, and how late a reading arrives."""

from __future__ import annotations

from math import floor, isfinite
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from uavlab.errors import BadInput
from uavlab.interfaces import Reading
from uavlab.types import Mat3, Vec3

_SLACK = 1e-6  # of a sample period: times are sums of ticks


class Truth(Protocol):
    """What an instrument may look at: the fields of `uavlab.plant.World` that can be sensed."""

    @property
    def t(self) -> float: ...  # noqa: D102
    @property
    def r(self) -> Vec3: ...  # noqa: D102
    @property
    def v(self) -> Vec3: ...  # noqa: D102
    @property
    def R(self) -> Mat3: ...  # noqa: D102
    @property
    def omega(self) -> Vec3: ...  # noqa: D102
    @property
    def a(self) -> Vec3: ...  # noqa: D102


@runtime_checkable
class Sensor(Protocol):
    """Truth → readings. All that an instrument remembers is its memory; all chance comes from `rng`."""

    def init(self, rng: np.random.Generator) -> Any:
        """Memory of an instrument that has just been switched on."""
        ...

    def step(
        self, memory: Any, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[Any, Reading | None]:
        """The reading that arrives in this tick of `dt` [s], if one does."""
        ...


class Line(NamedTuple):
    """The way from an instrument to the mind."""

    taken: int = 0  # samples that were due until now
    last: float = -1.0  # [s], when the last one was taken; −1: none yet
    under_way: tuple[Reading, ...] = ()  # oldest first


class Outage(NamedTuple):
    """A time without readings."""

    start: float  # [s]
    end: float  # [s]


def due(line: Line, t: float, rate: float) -> tuple[Line, float]:
    """Whether a sample is due at time `t`, and the time since the one before.

    Returns
    -------
    Line
        With the sample counted.
    float
        [s] since the last sample; 0 for the first one, −1 if none is due. An instrument faster than the control loop
        gives one sample per tick.
    """
    number = floor(t * rate + _SLACK) + 1
    if number <= line.taken:
        return line, -1.0
    since = t - line.last if line.last >= 0.0 else 0.0
    return line._replace(taken=number, last=t), since


def send(line: Line, reading: Reading) -> Line:
    """Put a reading on its way."""
    return line._replace(under_way=(*line.under_way, reading))


def receive(line: Line, t: float, delay: float) -> tuple[Line, Reading | None]:
    """The oldest reading that has arrived at time `t`, being `delay` [s] under way."""
    if not line.under_way or line.under_way[0].t + delay > t + 1e-9:
        return line, None
    return line._replace(under_way=line.under_way[1:]), line.under_way[0]


def lost(t: float, chance: float, dropout: float, outages: tuple[Outage, ...]) -> bool:
    """Whether a sample taken at `t` [s] never arrives; `chance` is uniform in [0, 1)."""
    return chance < dropout or any(a <= t < b for a, b in outages)


def check_line(
    name: str, rate: float, delay: float, dropout: float, outages: tuple[Outage, ...]
) -> None:
    """Refuse what no instrument can have.

    Raises
    ------
    BadInput
        The rate is not positive, the delay negative, drop-out not a probability, or an outage ends before it starts.
    """
    if not (isfinite(rate) and rate > 0.0):
        raise BadInput(f"{name}: rate is {rate} Hz; it must be > 0.")
    if not (isfinite(delay) and delay >= 0.0):
        raise BadInput(f"{name}: delay is {delay} s; it must be ≥ 0.")
    if not 0.0 <= dropout <= 1.0:
        raise BadInput(f"{name}: dropout is {dropout}; a probability lies between 0 and 1.")
    for start, end in outages:
        if not start <= end:
            raise BadInput(f"{name}: the outage from {start} to {end} s ends before it starts.")


def check_sizes(name: str, **sizes: object) -> None:
    """Refuse noise that is negative or not finite, and time constants that are not positive.

    Raises
    ------
    BadInput
        Names the field, its value and the bound.
    """
    for field, value in sizes.items():
        try:
            x = np.asarray(value, dtype=float)
        except (TypeError, ValueError):
            raise BadInput(f"{name}: {field} is {value!r}; numbers are needed.") from None
        low_ok = (x > 0.0).all() if field.endswith("tau") else (x >= 0.0).all()
        if x.shape not in {(), (3,)} or not np.isfinite(x).all() or not low_ok:
            bound = "> 0" if field.endswith("tau") else "≥ 0"
            raise BadInput(f"{name}: {field} is {value}; one number or three, finite and {bound}.")
