"""What a reading says of the state: a source is an instrument and a quantity that it tells, such as ``gnss.position``.

A filter that is corrected by a source sees the same numbers whatever the instrument: two of a horizontal position or
velocity, one of a height or heading.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from uavlab import frames
from uavlab.errors import BadInput, UnknownName
from uavlab.types import NO_SHIFT, Array, Mat3, Shift

STATES: dict[str, tuple[list[int] | None, int]] = {
    # quantity → axes (None: the heading), and which derivative; in the order in which a filter should hear them
    "heading_rate": (None, 1),
    "heading": (None, 0),
    "velocity": ([0, 1], 1),
    "position": ([0, 1], 0),
    "height": ([2], 0),
}
INSTRUMENTS = {
    "imu": ("heading_rate",),
    "magnetometer": ("heading",),
    "flow": ("velocity",),
    "gnss": ("velocity", "position", "height"),
    "rtk": ("velocity", "position", "height"),
    "slam": ("heading", "position", "height"),
    "mocap": ("heading", "position", "height"),
    "barometer": ("height",),
    "rangefinder": ("height",),
}
SOURCES = tuple(f"{name}.{what}" for name, told in INSTRUMENTS.items() for what in told)
NORTH = 0.0  # [rad] where the earth's field points, seen from above: along world x


def parted(source: str) -> tuple[str, str]:
    """Instrument and quantity of a source.

    Raises
    ------
    UnknownName
        There is no such source.
    """
    if source not in SOURCES:
        raise UnknownName("source", source, SOURCES)
    instrument, quantity = source.split(".")
    return instrument, quantity


def check_members(members: Mapping[str, Iterable[str]], variances: Mapping[str, float]) -> None:
    """Refuse a bank of filters that cannot be.

    Parameters
    ----------
    members : mapping
        Member → the sources that correct it.
    variances : mapping
        Source → variance of its noise, in the square of its unit.

    Raises
    ------
    UnknownName
        There is no such source, or no variance for it.
    BadInput
        A member without a source, or a variance that is not above 0 and finite.
    """
    for member, own in members.items():
        if not own:
            raise BadInput(f"member {member!r} hears nothing: give it a source.")
        for source in own:
            parted(source)
            if source not in variances:
                raise UnknownName("variance", source, variances)
            if not 0.0 < variances[source] < np.inf:
                raise BadInput(
                    f"the variance of {source} is {variances[source]}; it must be above 0."
                )


def late(i: int, delay: float, n: int) -> Array:
    """Measurement matrix of a state as it was some time ago, if the last derivative stood still since.

    Parameters
    ----------
    i : int
        Which state: 0 position or heading, 1 its rate, …
    delay : float
        Age of the measurement [s].
    n : int
        Number of states: at most position, velocity and acceleration.

    Returns
    -------
    Array
        Shape (1, n). Without delay it picks state `i`.
    """
    powers = np.array((1.0, -delay, 0.5 * delay**2))
    return np.concatenate((np.zeros(i), powers[: n - i]))[None]


def measured(source: str, reading: Any, R: Mat3, climb: float, world: Shift = NO_SHIFT) -> Array:
    """What a reading says of the quantity of a source.

    The heading rate is not among them: it takes MRS eq. (15), which is an exercise of lab 02.

    Parameters
    ----------
    source : str
        One of `SOURCES`, such as ``"gnss.position"``, but not ``"imu.heading_rate"``.
    reading : Fix, Pose, Field, Height, Range or Flow
        Of the source's instrument.
    R : Mat3
        Attitude body → world of the filter that asks, shape (3, 3). A magnetometer asks only for its tilt.
    climb : float
        Vertical velocity [m/s], which optic flow cannot see when the aircraft is tilted.
    world : Shift
        From a world with north along x and the ground at z = 0 to the world of the filter: for instruments that see the
        earth itself.

    Returns
    -------
    Array
        Horizontal position [m] or velocity [m/s], shape (2,); or height [m] or heading [rad], shape (1,). In the world
        of the instrument, or of `R` and `world` where it has none.
    """
    instrument, quantity = parted(source)
    if instrument == "flow":  # v_B = Rᵀ v: its first two rows, solved for the horizontal part of v
        return np.linalg.solve(R[:2, :2].T, reading.v_B - R[2, :2] * climb)
    if instrument == "rangefinder":
        return np.array((world.r[2] + reading.d * R[2, 2],))
    if instrument == "magnetometer":
        field = R @ reading.m
        seen = np.arctan2(field[1], field[0])
        return np.array((frames.heading(R) + NORTH + world.heading - seen,))
    if instrument == "barometer":
        return np.array((reading.z,))
    return _of_fix_or_pose(quantity, reading)


def _of_fix_or_pose(quantity: str, reading: Any) -> Array:
    """What a position fix or a pose says."""
    if quantity == "heading":
        return np.array((frames.heading(reading.R),))
    if quantity == "velocity":
        return reading.v[:2]
    return reading.r[:2] if quantity == "position" else reading.r[2:]
