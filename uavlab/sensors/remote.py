"""The receiver of a remote control: what somebody on the ground does with the sticks, as the scenario tells it."""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple, final

import numpy as np

from uavlab.errors import BadInput
from uavlab.sensors.faults import (
    NO_OUTLIERS,
    Jump,
    Outliers,
    check_faults,
    jumped,
    outlier,
)
from uavlab.sensors.line import (
    Line,
    Outage,
    Truth,
    check_line,
    check_sizes,
    due,
    lost,
    receive,
    send,
)
from uavlab.types import Sticks

_CENTRE = (0.0, 0.0, 0.0)


class Hold(NamedTuple):
    """How the sticks are held from `t` on."""

    t: float  # [s]
    engaged: bool = False  # whether the aircraft is to obey
    push: tuple[float, float, float] = _CENTRE  # forward, left, up, each in [−1, 1]
    turn: float = 0.0  # to the left, in [−1, 1]
    failsafe: bool = False  # whether the switch is on


@final
class Receiver(NamedTuple):
    """Sticks that are held as ``holds`` say, each until the next; not engaged before the first. Figures are ours."""

    rate: float = 50.0  # [Hz]
    delay: float = 0.02  # [s]
    holds: tuple[Hold, ...] = ()  # by time
    tremble: float = 0.0  # standard deviation of the hand, of the way of a stick
    dropout: float = 0.0  # probability that a message is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[
        Jump, ...
    ] = ()  # by, of push and turn (4,), of the way of a stick: a trim that slipped
    outliers: Outliers = (
        NO_OUTLIERS  # size, of the way of a stick: somebody else on the same channel
    )

    def init(self, rng: np.random.Generator) -> Line:
        """Switch on.

        Raises
        ------
        BadInput
            A rate, delay or probability that no link can have; holds that are not in order, or sticks beyond their end.
        """
        check_line("remote", self.rate, self.delay, self.dropout, self.outages)
        check_sizes("remote", tremble=self.tremble)
        check_faults("remote", self.dropout, self.jumps, self.outliers, by=4)
        last = -np.inf
        for k, hold in enumerate(self.holds):
            t, _, push, turn, _ = Hold(*hold)
            if not (isfinite(t) and t > last):
                raise BadInput(f"remote: holds[{k}].t is {t} s after {last} s; times must grow.")
            last = t
            way = np.asarray((*push, turn), dtype=float)
            if way.shape != (4,) or not (np.abs(way) <= 1.0).all():
                raise BadInput(
                    f"remote: holds[{k}] pushes {push} and turns {turn}; sticks go from −1 to 1, "
                    "three for push and one for turn."
                )
        return Line()

    def step(
        self, memory: Line, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[Line, Sticks | None]:
        """What arrives of the sticks now, if something does."""
        line, since = due(memory, world.t, self.rate)
        if since >= 0.0:
            white, chance = rng.standard_normal(4), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                off = jumped(world.t, self.jumps)[0] + outlier(chance, self.outliers, 4)[0]
                line = send(line, self._held(world.t, self.tremble * white + off))
        line, arrived = receive(line, world.t, self.delay)
        return line, arrived  # type: ignore[return-value]

    def _held(self, t: float, shake: np.ndarray) -> Sticks:
        """How the sticks are held at `t` [s]."""
        now = Hold(0.0)
        for hold in self.holds:
            if hold[0] <= t + 1e-9:
                now = Hold(*hold)
        x = np.clip(np.array((*now.push, now.turn), dtype=float) + shake, -1.0, 1.0)
        return Sticks(t, bool(now.engaged), x[:3], float(x[3]), bool(now.failsafe))
