"""Dead reckoning: how fast an aircraft is by its accelerometer, since the estimate stood on measurements last."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from uavlab.frames import Shift
from uavlab.so3 import about_z
from uavlab.types import GRAVITY, Estimate, Imu, Mat3, Vec3

K_V, K_B = (
    2.0,
    1.0,
)  # [1/s], [1/s²]: both poles at −1 1/s, so that half a second of a wrong speed teaches little
FAR = 2.0  # [m/s] between the estimate and what was reckoned: the one jumped, or the other ran away
TRUST = 10.0  # [s] for which it is worth something: an offset of 0.2 m/s² of which half is learned makes 1 m/s of it
SILENCE = 20.0  # times as quickly it loses its worth while nothing is read
_G = np.array((0.0, 0.0, GRAVITY))
_G.setflags(write=False)


class Reckoned(NamedTuple):
    """What is known without any measurement of place or speed."""

    v: Vec3  # (3,) [m/s], world of the estimate
    offset: Vec3  # (3,) [m/s²] of the accelerometer, body, as far as it was learned
    age: float = 0.0  # [s] since there was an estimate

    @property
    def holds(self) -> bool:
        """Whether the velocity is still worth something."""
        return self.age < TRUST


def begun(v: Vec3) -> Reckoned:
    """It begins at a velocity [m/s], with an accelerometer without offset."""
    return Reckoned(v, np.zeros(3))


def reckoned(
    m: Reckoned, estimate: Estimate, good: bool, R: Mat3, readings: Mapping[str, Any], dt: float
) -> Reckoned:
    """One tick of `dt` [s].

    Parameters
    ----------
    m : Reckoned
        Of the tick before.
    estimate : Estimate
        Of which the velocity is looked at if it is `good`: then the offset is learned from it.
    good : bool
        Whether it is finite, and stands on measurements.
    R : Mat3
        The attitude (3, 3), body → world, as far as it is known.
    readings : mapping
        Of which ``imu`` is looked at.
    """
    imu = readings.get("imu")
    read = isinstance(imu, Imu) and isfinite(imu.accel @ imu.accel)
    v = m.v
    if isinstance(imu, Imu) and read:
        v = v + (R @ (imu.accel - m.offset) - _G) * dt
    if not good:
        return m._replace(v=v, age=m.age + (dt if read else SILENCE * dt))
    off = estimate.v - v
    if not read or off @ off > FAR * FAR:
        return Reckoned(estimate.v, m.offset)
    return Reckoned(v + K_V * dt * off, m.offset - K_B * dt * (off @ R))


def reframed(m: Reckoned, shift: Shift) -> Reckoned:
    """The same, told in the new world."""
    return m._replace(v=about_z(shift.heading) @ m.v)
