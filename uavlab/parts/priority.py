"""Stand-in for a bank of filters: one observer, fed by the first instrument of a fixed list that is still heard."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.frames import NO_SHIFT, Shift, compose, heading, inverse, moved, wrap
from uavlab.interfaces import Readings
from uavlab.parts.estimators import HEARD, AlphaBetaGamma
from uavlab.so3 import about_z
from uavlab.types import Attitude, Command, Estimate, Fix, Hypothesis, Pose

_OBSERVER = AlphaBetaGamma("fix", bandwidth=6.0)


class Anchored(NamedTuple):
    """The observer's memory, and how the instrument that feeds it is moved into the world of the start."""

    observer: tuple[Estimate, float]
    feeds: str  # the instrument that is listened to; "" before the first
    anchor: Shift  # its world → ours
    silent: Mapping[str, float]  # instrument → time [s] since it was heard
    turn: float | None  # [rad] heading of ours less that of the autopilot; None before the first


@dataclass(frozen=True)
class FixedPriority:
    """One alpha-beta-gamma observer, and a list of instruments: the first that was heard lately feeds it.

    A new instrument is taken to be where the estimate is, so the world never changes, and what one instrument was
    wrong by is kept when the next one takes over. With none of them heard for 0.3 s the estimate is not ``reliable``.
    Stand-in: no covariance, no innovation test, no request.
    """

    slot: ClassVar[str] = "estimator"
    order: tuple[str, ...] = ("mocap", "rtk", "gnss", "slam")
    patience: float = 0.3  # [s]: an observer of acceleration cannot wait long
    observer: AlphaBetaGamma = _OBSERVER

    def init(self, estimate: Estimate) -> Anchored:
        """Continue from `estimate`."""
        return Anchored(self.observer.init(estimate), "", NO_SHIFT, {}, None)

    def step(
        self, memory: Anchored, readings: Readings, command: Command, dt: float
    ) -> tuple[Anchored, Estimate]:
        """One tick: who feeds, then the observer."""
        observer, feeds, anchor, silent, turn = memory
        heard: dict[str, Any] = {
            name: x
            for name in self.order
            if isinstance(x := readings.get(name), Fix | Pose) and _sane(x)
        }
        silent = {name: t + dt for name, t in silent.items()} | dict.fromkeys(heard, 0.0)
        fresh = [name for name in self.order if silent.get(name, np.inf) < self.patience]
        last = observer[0]
        if fresh and fresh[0] != feeds and fresh[0] in heard:
            feeds = fresh[0]
            anchor = compose(_pose(last, last), inverse(_pose(heard[feeds], last)))

        told: dict[str, Any] = {k: x for k, x in readings.items() if k == "imu"}
        if feeds in heard:
            told["fix"] = moved(heard[feeds], anchor)
        observer, estimate = self.observer.step(observer, told, command, dt)
        # While one instrument is waited for, another may be heard: the observer knows of the first only.
        quiet = min(silent.values(), default=observer[1])
        estimate = estimate._replace(reliable=quiet <= HEARD)
        seen = readings.get("ahrs") or readings.get("mocap")
        if isinstance(seen, Attitude | Pose) and np.isfinite(seen.R).all():
            turn = wrap(heading(estimate.R) - heading(seen.R)) if turn is None else turn
            estimate = estimate._replace(R=about_z(turn) @ seen.R)
            observer = (estimate, observer[1])
        return Anchored(observer, feeds, anchor, silent, turn), estimate

    def reframe(self, memory: Anchored, shift: Shift) -> Anchored:
        """The same belief, with all worlds moved alike."""
        anchor = memory.anchor
        if memory.feeds:
            anchor = compose(shift, compose(anchor, inverse(shift)))
        return memory._replace(
            observer=self.observer.reframe(memory.observer, shift), anchor=anchor
        )

    def hypotheses(self, memory: Anchored) -> Mapping[str, Hypothesis]:
        """It has one belief only."""
        return {}


def _sane(x: Fix | Pose) -> bool:
    return bool(np.isfinite(x.r).all())


def _pose(x: Estimate | Fix | Pose, last: Estimate) -> Shift:
    """Where something is, as the map from the aircraft's level frame to its world; a fix has the heading we have."""
    return Shift(x.r, heading(last.R if isinstance(x, Fix) else x.R))
