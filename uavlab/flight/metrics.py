"""What a flight was worth: errors, tilt, effort."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from uavlab.flight.log import Log
from uavlab.flight.worlds import told
from uavlab.types import Array


def position_error(log: Log) -> Array:
    """Distance of the true position from the reference [m], shape (N,), whatever world the reference was told in."""
    return np.linalg.norm(log.r - told(log).r_d, axis=1)


def headings(log: Log) -> Array:
    """True heading [rad], shape (N,) (MRS eq. 3)."""
    return np.arctan2(log.R[:, 1, 0], log.R[:, 0, 0])


def heading_error(log: Log) -> Array:
    """True heading less the wanted one [rad], in [−π, π), shape (N,)."""
    return (headings(log) - told(log).heading_d + np.pi) % (2 * np.pi) - np.pi


def tilt(log: Log) -> Array:
    """Angle between the thrust axis and the vertical [rad], shape (N,)."""
    return np.arctan2(np.hypot(log.R[:, 0, 2], log.R[:, 1, 2]), log.R[:, 2, 2])


def summary(log: Log, after: float = 0.0) -> dict[str, float]:
    """The numbers by which flights are compared, over what was flown after `after` [s].

    Returns
    -------
    dict
        By name and unit; NaN where nothing was flown.
    """
    use = log.t >= after
    e, h, speed = (
        position_error(log)[use],
        heading_error(log)[use],
        np.linalg.norm(log.v, axis=1)[use],
    )

    def of(f: Callable[[Array], float], x: Array, unit: float = 1.0) -> float:
        return unit * float(f(x)) if x.size else float("nan")

    deg = float(np.rad2deg(1.0))

    return {
        "flown [s]": float(log.t[-1] + log.meta.get("dt", 0.0)) if len(log.t) else 0.0,
        "position error, mean [m]": of(np.mean, e),
        "position error, worst [m]": of(np.max, e),
        "heading error, rms [deg]": of(lambda x: np.sqrt(np.mean(x**2)), h, deg),
        "heading error, worst [deg]": of(lambda x: np.max(np.abs(x)), h, deg),
        "speed, worst [m/s]": of(np.max, speed),
        "tilt, worst [deg]": of(np.max, tilt(log)[use], deg),
        "rotor thrust, worst [N]": of(np.max, log.rotors[use]),
    }
