"""What the log of a managed flight tells: when something happened, and how it met the ground."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.flight.log import Log
from uavlab.flight.metrics import tilt

TOUCH = 0.002  # [m]: as near is on the ground
HIGH = 0.3  # [m]: who has been there was in the air
RAN = "touchdown"  # kind of the event with which the motors go off


class Down(NamedTuple):
    """How a flight came down. Times are not numbers if it did not."""

    contact: float  # [s] first touch of the ground after it was in the air
    off: float  # [s] when its motors went off
    sink: float  # [m/s] downwards, just before the touch
    aside: float  # [m/s] horizontally
    height: float  # [m] when its motors went off
    at: np.ndarray  # (3,) [m] where it touched

    @property
    def after(self) -> float:
        """From touch to motors off [s]."""
        return self.off - self.contact

    @property
    def speed(self) -> float:
        """All of the speed at the touch [m/s]."""
        return float(np.hypot(self.sink, self.aside))


def when(log: Log, kind: str, name: str = "", since: float = 0.0) -> float:
    """When the first event of this kind, and of this name if there is one, happened [s]; NaN: never."""
    for t, what, whom, _ in log.meta.get("events", ()):
        if what == kind and name in {"", whom} and t >= since - 1e-9:
            return float(t)
    return float("nan")


def down(log: Log) -> Down:
    """How it came down."""
    z = log.r[:, 2]
    up = int(np.argmax(z > HIGH)) if (z > HIGH).any() else len(z)
    touched = np.flatnonzero(z[up:] < TOUCH) + up
    off = when(log, RAN)
    k = min(int(np.searchsorted(log.t, off - 1e-9)), len(z) - 1)
    height = np.nan if np.isnan(off) else float(z[k])
    if not touched.size:
        return Down(np.nan, off, np.nan, np.nan, height, np.full(3, np.nan))
    k = int(touched[0])
    v = log.v[k - 1]
    return Down(float(log.t[k]), off, -float(v[2]), float(np.hypot(v[0], v[1])), height, log.r[k])


def leant(log: Log, since: float, until: float) -> float:
    """Largest true tilt between two times [deg]; NaN if it did not fly then."""
    some = (log.t >= since - 1e-9) & (log.t <= until + 1e-9)
    return float(np.rad2deg(tilt(log)[some].max())) if some.any() else float("nan")


def refusals(log: Log) -> list[str]:
    """Why something was refused, each time."""
    return [said for _, kind, _, said in log.meta.get("events", ()) if kind == "refused"]
