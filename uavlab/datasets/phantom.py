"""The Phantom 4 flights of Hurwitz and Klein: RTK tracks (GT.csv) and Xsens DOT inertial units (IMU_*.csv)."""

from __future__ import annotations

import csv
import os
from pathlib import Path
from typing import NamedTuple

import numpy as np

from uavlab.datasets import conventions
from uavlab.errors import BadFile
from uavlab.types import Array

RTK_COLUMNS = (
    "time", "distance(meters)", "speed(m/s)", "compass_heading(degrees)", "pitch(degrees)",
    "roll(degrees)", "height_above_takeoff(meters)", "North", "East", "Down",
)  # fmt: skip
DOT_COLUMNS = (
    "time", "Euler_X", "Euler_Y", "Euler_Z", "Acc_X", "Acc_Y", "Acc_Z", "Gyr_X", "Gyr_Y", "Gyr_Z",
)  # fmt: skip


class RtkTrack(NamedTuple):
    """What the aircraft itself recorded at 10 Hz. World ENU with its origin on the ground below the first fix."""

    t: Array  # (N,) [s]
    r: Array  # (N, 3) [m]; z is height above take-off
    R: Array  # (N, 3, 3) body (FLU) → world
    heading: Array  # (N,) [rad], from the aircraft's compass; true or magnetic north is not said
    speed: Array  # (N,) [m/s], as recorded
    distance: Array  # (N,) [m] from the take-off point, as recorded
    meta: dict[str, str]


class DotImu(NamedTuple):
    """What one Xsens DOT recorded at 120 Hz, in the axes of its own case: z up, x and y not known in the aircraft.

    Its world has z up and an arbitrary heading, and its clock is its own: both stay as they are. Align them from
    the data.
    """

    t: Array  # (N,) [s], its own clock
    accel: Array  # (N, 3) specific force [m/s²], case
    gyro: Array  # (N, 3) [rad/s], case
    R: Array  # (N, 3, 3) case → its own world, by Xsens' filter
    meta: dict[str, str]


def read_rtk(path: str | os.PathLike[str]) -> RtkTrack:
    """Read a ``GT.csv``: north, east, down and compass, pitch, roll in degrees → ENU and matrices.

    Raises
    ------
    BadFile
        Missing, empty, cut short, or not such a table.
    """
    x = _table(Path(path), RTK_COLUMNS)
    compass, pitch, roll = np.deg2rad(x[:, 3:6]).T  # pitch up and roll right are positive
    r = conventions.enu_from_ned(x[:, 7:10])
    r[:, 2] += x[0, 6] - r[0, 2]  # Down starts at zero; height above take-off has only decimetres
    R = conventions.attitude_from_ned_frd(
        conventions.matrices_from_tait_bryan(compass, pitch, roll)
    )
    heading = conventions.heading_from_compass(compass)
    return RtkTrack(x[:, 0], r, R, heading, x[:, 2], x[:, 1], {"source": _source(path)})


def read_dot(path: str | os.PathLike[str]) -> DotImu:
    """Read an ``IMU_*.csv``: degrees → radians and matrices; axes, world heading and clock stay the unit's own.

    Raises
    ------
    BadFile
        Missing, empty, cut short, or not such a table.
    """
    x = _table(Path(path), DOT_COLUMNS)
    roll, pitch, yaw = np.deg2rad(x[:, 1:4]).T
    R = conventions.matrices_from_tait_bryan(yaw, pitch, roll)
    return DotImu(x[:, 0], x[:, 4:7], np.deg2rad(x[:, 7:10]), R, {"source": _source(path)})


def columns_of(path: Path) -> tuple[str, ...]:
    """The names in the first line of a table; empty for an empty file."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            return tuple(name.strip() for name in next(csv.reader(file), ()))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise BadFile(f"{path} cannot be read as a table: {error}.") from None


def _source(path: str | os.PathLike[str]) -> str:
    return "/".join(Path(path).parts[-3:])


def _table(path: Path, columns: tuple[str, ...]) -> Array:
    """The numbers of a table with exactly these columns, (N, len(columns)), its times increasing."""
    found = columns_of(path)
    if not found:
        raise BadFile(f"{path} is empty; its first line should be: {', '.join(columns)}.")
    if found != columns:
        raise BadFile(
            f"{path} has the columns {', '.join(found)[:120]}; needed are: {', '.join(columns)}."
        )
    rows = []
    with open(path, newline="", encoding="utf-8") as file:
        for number, row in enumerate(csv.reader(file), start=1):
            if number > 1 and row:
                rows.append(_numbers(path, number, row, len(columns)))
    if not rows:
        raise BadFile(f"{path} has no rows below its column names; it is cut short.")
    x = np.array(rows)
    back = np.flatnonzero(np.diff(x[:, 0]) <= 0)
    if back.size:
        raise BadFile(f"{path}: time does not increase from line {back[0] + 2} to the next.")
    return x


def _numbers(path: Path, number: int, row: list[str], n: int) -> list[float]:
    if len(row) != n:
        raise BadFile(
            f"{path}: line {number} has {len(row)} of {n} numbers; the file is cut short or damaged there."
        )
    try:
        values = [float(x) for x in row]
    except ValueError as error:
        raise BadFile(f"{path}: line {number}: {error}.") from None
    if not np.isfinite(values).all():
        raise BadFile(f"{path}: line {number} has a value that is not finite.")
    return values
