"""Random faults of all kinds, with sizes that an aircraft may meet."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, pi
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from uavlab.flight.fault import BROKEN, FIELDS, HOW, KINDS, Fault
from uavlab.plant.airframe import Airframe
from uavlab.types import Vec3

NOISY = ("lost", "frozen", "jump", "bias", "late")  # kinds that concern an instrument
# Error that comes at once, largest size, in the unit of the field; what is not here stays right.
ERRORS: Mapping[str, float] = {
    "imu.accel": 3.0, "imu.gyro": 0.5, "ahrs.R": 0.2, "magnetometer.m": 0.3, "barometer.z": 3.0,
    "rangefinder.d": 2.0, "gnss.r": 5.0, "gnss.v": 2.0, "rtk.r": 5.0, "rtk.v": 2.0, "flow.v_B": 2.0,
    "slam.r": 3.0, "slam.R": 0.5, "mocap.r": 3.0, "mocap.R": 0.2,
}  # fmt: skip
_Range: TypeAlias = tuple[float, float]


class Sizes(NamedTuple):
    """How large faults are, from and to."""

    errors: Mapping[str, float] = ERRORS
    grows: float = 5.0  # [s] in which an error that grows reaches that size
    lasts: _Range = (0.2, 5.0)  # [s], of what passes
    stays: float = 0.4  # share of the faults that do not pass
    late: _Range = (0.05, 1.0)  # [s]
    gust: _Range = (3.0, 8.0)  # [m/s], its peak
    rise: _Range = (1.0, 4.0)  # [s] that it takes
    motor: _Range = (0.7, 0.95)  # share of the thrust that a weak motor makes
    dead: tuple[str, ...] = ("F550",)  # airframes that can lose a whole rotor: five are left
    battery: _Range = (0.8, 0.95)  # share of the thrust that is left
    sag: _Range = (3.0, 10.0)  # [s] in which the rest goes
    payload: _Range = (0.05, 0.15)  # share of the mass


SIZES = Sizes()


def fault(rng: np.random.Generator, airframe: Airframe, aboard: list[str], end: float) -> Fault:
    """One fault of a random kind, that begins before `end` [s].

    Parameters
    ----------
    rng : Generator
        Where chance comes from.
    airframe : Airframe
        What it happens to.
    aboard : list of str
        Its instruments.
    end : float
        When the mission ends, more or less [s].
    """
    kind = str(rng.choice(sorted(KINDS)))
    t = _between(rng, (0.5, end))
    until = inf if rng.random() < SIZES.stays else t + _between(rng, SIZES.lasts)
    if kind in NOISY:
        return _misreading(rng, kind, aboard, t, until)
    made = {
        "nan": lambda: Fault(kind, t, until, str(rng.choice(["", "all"]))),
        "solver": lambda: Fault(kind, t, until),
        "part": lambda: Fault(kind, t, until, str(rng.choice(BROKEN)), str(rng.choice(HOW))),
        "motor": lambda: _motor(rng, airframe, t, until),
        "battery": lambda: Fault(
            kind, t, t + _between(rng, SIZES.sag), "", _between(rng, SIZES.battery)
        ),
        "payload": lambda: Fault(
            kind, t, inf, "", _between(rng, SIZES.payload) * float(airframe.m)
        ),
        "gust": lambda: Fault(kind, t, t + _between(rng, SIZES.rise), "", _gust(rng)),
        "link": lambda: Fault(kind, t, until),
    }
    return made[kind]()


def label(fault: list[Any]) -> str:
    """The line of the table in which a fault counts, from how a log tells it."""
    kind, _, _, what, value = fault
    if kind == "motor":
        return "motor dead" if value == 0.0 else "motor weak"
    if kind in NOISY:
        return f"instrument {kind}"
    return f"{kind} {what} {value}" if kind == "part" else kind


def _misreading(
    rng: np.random.Generator, kind: str, aboard: list[str], t: float, until: float
) -> Fault:
    """Of a random instrument."""
    what = str(rng.choice(aboard))
    if kind in {"lost", "frozen"}:
        return Fault(kind, t, until, what)
    if kind == "late":
        return Fault(kind, t, until, what, _between(rng, SIZES.late))
    field = str(rng.choice([x for x in FIELDS[what] if f"{what}.{x}" in SIZES.errors]))
    n, size = FIELDS[what][field], SIZES.errors[f"{what}.{field}"] * rng.random()
    value = size * _direction(rng, n) / (SIZES.grows if kind == "bias" else 1.0)
    return Fault(kind, t, until, f"{what}.{field}", value if n > 1 else float(value[0]))


def _motor(rng: np.random.Generator, airframe: Airframe, t: float, until: float) -> Fault:
    rotor = str(rng.integers(airframe.n))
    if airframe.name in SIZES.dead and rng.random() < 0.5:
        return Fault("motor", t, until, rotor, 0.0)
    return Fault("motor", t, until, rotor, _between(rng, SIZES.motor))


def _gust(rng: np.random.Generator) -> Vec3:
    """Its peak (3,) [m/s], world; flatter than it is wide."""
    angle, speed = 2.0 * pi * rng.random(), _between(rng, SIZES.gust)
    return speed * np.array((np.cos(angle), np.sin(angle), 0.3 * (2.0 * rng.random() - 1.0)))


def _direction(rng: np.random.Generator, n: int) -> np.ndarray:
    x = rng.normal(size=n)
    return x / np.linalg.norm(x)


def _between(rng: np.random.Generator, limits: tuple[float, float]) -> float:
    return round(float(rng.uniform(*limits)), 2)
