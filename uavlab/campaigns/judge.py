"""What a flight must keep to, whatever breaks in it: told from its log, which holds the truth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from uavlab.flight.log import UNITS, Log
from uavlab.flight.worlds import told
from uavlab.types import Array, Exit, Vec3

SOFT = 3.0  # [m/s], the touch-down that the feet bear; a harder one is a crash
ESTIMATE = {"r_e", "v_e", "R_e"}  # what may be no number while an estimator is told to fail
LOW = {"taking off", "going home", "landing", "emergency", "failsafe"}  # modes that go below `low`
ABOVE = 1e-6  # [m], rounding


def touch_down(log: Log) -> float | None:
    """Speed of the hardest touch-down [m/s]; None if it never came down."""
    down = (log.r[1:, 2] <= 0.0) & (log.r[:-1, 2] > 0.0)
    speeds = [_speed(log, int(k)) for k in np.flatnonzero(down)]
    return max(speeds, default=None)


def _speed(log: Log, k: int) -> float:
    """At the ground, which it meets within the tick after `k`."""
    v: Vec3 = log.v[k]
    within = float(log.r[k, 2] / max(-v[2], 1e-9))
    return float(np.linalg.norm(v + log.a[k] * min(within, log.meta["dt"])))


def modes(log: Log) -> list[tuple[float, str]]:
    """The modes that the pilot went through, and since when [s]."""
    return [(t, name) for t, kind, name, _ in log.meta.get("events", []) if kind == "mode"]


def mode_of(log: Log) -> Array:
    """The mode in each tick, shape (N,); empty before the first."""
    out = np.full(len(log.t), "", dtype="<U20")
    for t, name in modes(log):
        out[log.t >= t - 1e-9] = name
    return out
