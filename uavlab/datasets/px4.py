"""PX4 logs (ULog), told in our axes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from uavlab.datasets import conventions
from uavlab.errors import BadFile
from uavlab.types import Array

_MAGIC = b"ULog\x01\x12\x35"
_INVALID = 2**31 - 1  # what PX4 writes as relative time of a sensor that gave nothing


class PX4Log(NamedTuple):
    """One PX4 log: sensors, what EKF2 made of them, what was asked. World ENU, body FLU, times from the log's start.

    Streams have times of their own. A stream that the log lacks is empty (zero rows).
    """

    t_imu: Array  # (N,) [s]
    gyro: Array  # (N, 3) angular velocity [rad/s], body, raw
    accel: Array  # (N, 3) specific force [m/s²], body; +g along z at rest
    t_mag: Array  # (M,) [s]
    mag: Array  # (M, 3) magnetic field [gauss], body
    t_baro: Array  # (B,) [s]
    baro: Array  # (B,) height above sea level by pressure [m]
    t: Array  # (A,) [s] of attitude
    q: Array  # (A, 4) [w, x, y, z] body → world, by EKF2
    R: Array  # (A, 3, 3) the same as matrices
    omega: Array  # (A, 3) [rad/s], body, as the autopilot logged it: gyro less EKF2's bias; NaN if not logged
    t_heading: Array  # (H,) [s]
    heading: Array  # (H,) [rad] that the autopilot logged beside its position
    t_d: Array  # (D,) [s] of the attitude set-point
    R_d: Array  # (D, 3, 3) body → world
    t_omega_d: Array  # (W,) [s] of the rate set-point
    omega_d: Array  # (W, 3) [rad/s], body
    meta: dict[str, Any]  # source, hardware, software, start [s] on the autopilot's clock


def read_px4(path: str | os.PathLike[str], *, allow_cut: bool = False) -> PX4Log:
    """Read a PX4 log and tell it in our axes (`uavlab.datasets.conventions`).

    Parameters
    ----------
    path : path-like
        A .ulg file.
    allow_cut : bool
        Read what comes before the end or the damage of a log that lost power.

    Raises
    ------
    BadFile
        Missing, empty, not a ULog, cut short, or without attitude or inertial sensors.
    """
    path = Path(path)
    topics, info, start = _topics(path, _whole(path, allow_cut))
    imu = _Topic(path, topics, "sensor_combined", start)
    attitude = _Topic(path, topics, "vehicle_attitude", start)
    q = attitude.vectors("q", 4)
    mag, baro = imu.magnetometer(topics), imu.barometer(topics)
    position = _Topic(path, topics, "vehicle_local_position", start, needed=False)
    wanted = _Topic(path, topics, "vehicle_attitude_setpoint", start, needed=False)
    rates = _Topic(path, topics, "vehicle_rates_setpoint", start, needed=False)
    yaw = "yaw" if position.has("yaw") else "heading"
    return PX4Log(
        t_imu=imu.t,
        gyro=conventions.flu_from_frd(imu.vectors("gyro_rad")),
        accel=conventions.flu_from_frd(imu.vectors("accelerometer_m_s2")),
        t_mag=mag[0],
        mag=mag[1],
        t_baro=baro[0],
        baro=baro[1],
        t=attitude.t,
        q=conventions.quaternion_from_ned_frd(q),
        R=conventions.attitude_from_ned_frd(conventions.matrices_from_quaternions(q)),
        omega=_logged_rates(path, topics, start, attitude),
        t_heading=position.t,
        heading=conventions.heading_from_compass(position.column(yaw)),
        t_d=wanted.t,
        R_d=conventions.attitude_from_ned_frd(
            conventions.matrices_from_quaternions(wanted.vectors("q_d", 4))
        ),
        t_omega_d=rates.t,
        omega_d=conventions.flu_from_frd(
            np.stack([rates.column(k) for k in ("roll", "pitch", "yaw")], axis=1)
        ),
        meta={
            "source": path.name,
            "hardware": str(info.get("ver_hw", "not logged")),
            "software": f"{info.get('sys_name', 'PX4')} {str(info.get('ver_sw', ''))[:8]}".strip(),
            "start": start * 1e-6,
        },
    )


def _whole(path: Path, allow_cut: bool) -> bytes:
    """The log's bytes, its messages walked by their lengths: pyulog goes on silently, or for ever."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BadFile(f"{path} cannot be read: {error.strerror or error}.") from None
    if not content:
        raise BadFile(f"{path} is empty; a PX4 log starts with 'ULog'.")
    if not content.startswith(_MAGIC):
        raise BadFile(f"{path} is not a PX4 log: it starts with {content[:7]!r}, not {_MAGIC!r}.")
    at = _end_of_whole_messages(content)
    if at != len(content) and not allow_cut:
        raise BadFile(
            f"{path} is cut short or damaged: after byte {at} of {len(content)} there is no whole message. "
            "Copy it again, or read what comes before with read_px4(path, allow_cut=True)."
        )
    return content[:at]


def _end_of_whole_messages(content: bytes) -> int:
    """Where the last whole message ends. Each starts with its length (2 bytes, little-endian) and a capital letter."""
    at = 16
    while at + 3 <= len(content):
        size = content[at] + 256 * content[at + 1]
        if not (size and 65 <= content[at + 2] <= 90 and at + 3 + size <= len(content)):
            return at
        at += 3 + size
    return min(at, len(content))


def _topics(path: Path, content: bytes) -> tuple[dict[str, dict[str, Array]], dict[str, Any], int]:
    """Columns by topic (first instance), the log's information, its start [µs]."""
    import contextlib
    import io

    import pyulog

    try:
        with contextlib.redirect_stdout(io.StringIO()):  # pyulog prints what it does not know
            log = pyulog.ULog(io.BytesIO(content))  # type: ignore[arg-type]
    except Exception as error:  # pyulog raises whatever its parsing meets
        raise BadFile(f"{path} is not a whole PX4 log ({type(error).__name__}: {error}).") from None
    topics = {d.name: d.data for d in reversed(log.data_list) if d.multi_id == 0}
    return topics, log.msg_info_dict, log.start_timestamp


class _Topic:
    """One topic of a log, its rows in strictly increasing time."""

    def __init__(
        self, path: Path, topics: dict[str, Any], name: str, start: int, needed: bool = True
    ) -> None:
        if needed and not len(topics.get(name, {}).get("timestamp", ())):
            raise BadFile(
                f"{path} has no topic {name!r}, without which it cannot be read; "
                f"it has: {', '.join(sorted(topics)) or 'nothing'}."
            )
        self.path, self.name, self.start, self.data = path, name, start, topics.get(name, {})
        stamps = np.asarray(self.data.get("timestamp", ()), dtype=np.int64)
        self.rows = np.flatnonzero(stamps > np.maximum.accumulate(np.r_[-1, stamps])[:-1])
        self.t = (stamps[self.rows] - start) * 1e-6

    def has(self, column: str) -> bool:
        return column in self.data

    def column(self, name: str) -> Array:
        """A column, as float64, shape (rows,); an empty one if the topic is not there."""
        if not self.data:
            return np.zeros(0)
        if name not in self.data:
            raise BadFile(
                f"{self.path}: topic {self.name!r} has no field {name!r}; it has: {', '.join(self.data)}."
            )
        return np.asarray(self.data[name], dtype=float)[self.rows]

    def vectors(self, name: str, n: int = 3) -> Array:
        """The array field `name`, shape (rows, n)."""
        return np.stack([self.column(f"{name}[{i}]") for i in range(n)], axis=1)

    def sensed(self, clock: str, values: Array) -> tuple[Array, Array]:
        """Samples of a slower sensor inside this topic, each once, at its own time; none if it never gave one."""
        relative = self.column(clock)
        t = self.t + relative * 1e-6
        t, first = np.unique(np.where(relative == _INVALID, -np.inf, t), return_index=True)
        keep = np.isfinite(t)
        return t[keep], values[first[keep]]

    def magnetometer(self, topics: dict[str, Any]) -> tuple[Array, Array]:
        """Times [s] and field [gauss], FLU: inside sensor_combined until 2018, a topic of its own since."""
        if self.has("magnetometer_ga[0]"):
            field = conventions.flu_from_frd(self.vectors("magnetometer_ga"))
            return self.sensed("magnetometer_timestamp_relative", field)
        own = _Topic(self.path, topics, "vehicle_magnetometer", self.start, needed=False)
        return own.t, conventions.flu_from_frd(own.vectors("magnetometer_ga"))

    def barometer(self, topics: dict[str, Any]) -> tuple[Array, Array]:
        """Times [s] and height [m], likewise."""
        if self.has("baro_alt_meter"):
            return self.sensed("baro_timestamp_relative", self.column("baro_alt_meter"))
        own = _Topic(self.path, topics, "vehicle_air_data", self.start, needed=False)
        return own.t, own.column("baro_alt_meter")


def _logged_rates(path: Path, topics: dict[str, Any], start: int, attitude: _Topic) -> Array:
    """Body rates less bias at the attitude's times: beside it until 2019, a topic of its own since."""
    if attitude.has("rollspeed"):
        columns = [attitude.column(k) for k in ("rollspeed", "pitchspeed", "yawspeed")]
        return conventions.flu_from_frd(np.stack(columns, axis=1))
    own = _Topic(path, topics, "vehicle_angular_velocity", start, needed=False)
    if not len(own.t):
        return np.full((len(attitude.t), 3), np.nan)
    rates = conventions.flu_from_frd(own.vectors("xyz"))
    return np.stack([np.interp(attitude.t, own.t, rates[:, i]) for i in range(3)], axis=1)
