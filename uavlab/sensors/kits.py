"""What an aircraft carries: the instruments by name, and the usual kits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from uavlab.errors import UnknownName
from uavlab.sensors.ahrs import Ahrs
from uavlab.sensors.barometer import Barometer
from uavlab.sensors.bearings import BeaconCamera
from uavlab.sensors.flow import FlowCamera
from uavlab.sensors.gnss import Gnss
from uavlab.sensors.imu import ImuSensor
from uavlab.sensors.magnetometer import Magnetometer
from uavlab.sensors.mocap import Mocap
from uavlab.sensors.rangefinder import Rangefinder
from uavlab.sensors.remote import Receiver
from uavlab.sensors.rtk import Rtk
from uavlab.sensors.sectors import Scanner
from uavlab.sensors.slam import Slam

# The name under which a scenario carries an instrument is the name under which its readings arrive.
INSTRUMENTS: Mapping[str, type[Any]] = {
    "imu": ImuSensor,
    "ahrs": Ahrs,
    "magnetometer": Magnetometer,
    "barometer": Barometer,
    "rangefinder": Rangefinder,
    "gnss": Gnss,
    "rtk": Rtk,
    "flow": FlowCamera,
    "slam": Slam,
    "mocap": Mocap,
    "bearings": BeaconCamera,
    "sectors": Scanner,
    "remote": Receiver,
}


def carry(*names: str, **instruments: Any) -> dict[str, Any]:
    """Instruments by name, as a scenario wants them: `names` as they come, `instruments` as they are given.

    Raises
    ------
    UnknownName
        No instrument has this name.
    """
    for name in names:
        if name not in INSTRUMENTS:
            raise UnknownName("instrument", name, INSTRUMENTS)
    return {**{name: INSTRUMENTS[name]() for name in names}, **instruments}


def laboratory() -> dict[str, Any]:
    """A laboratory with cameras on its walls."""
    return carry("imu", "mocap")


def indoor() -> dict[str, Any]:
    """Indoors without cameras: a map of one's own, optic flow and a rangefinder, no satellites."""
    return carry("imu", "ahrs", "barometer", "rangefinder", "flow", "slam")


def outdoor() -> dict[str, Any]:
    """Under open sky: a plain satellite receiver and what every autopilot has."""
    return carry("imu", "ahrs", "magnetometer", "barometer", "rangefinder", "gnss")


def survey() -> dict[str, Any]:
    """Everything that a bank of filters can use, indoors and out."""
    return {**outdoor(), **indoor(), **carry("rtk")}


def guarded() -> dict[str, Any]:
    """A laboratory, and what a pilot listens to beside the estimate: what is near, and who holds the sticks."""
    return {**laboratory(), **carry("sectors", "remote")}


KITS: Mapping[str, Callable[[], dict[str, Any]]] = {
    "laboratory": laboratory,
    "indoor": indoor,
    "outdoor": outdoor,
    "survey": survey,
    "guarded": guarded,
}
