"""From truth to measurement, one file per instrument: bias, drift, noise, rate, delay, drop-out, jumps, outliers."""

from uavlab.sensors.faults import NO_OUTLIERS, Jump, Outliers
from uavlab.sensors.flow import FlowCamera
from uavlab.sensors.gnss import Gnss
from uavlab.sensors.imu import ImuSensor
from uavlab.sensors.line import Outage, Sensor
from uavlab.sensors.mocap import Mocap
from uavlab.sensors.rtk import Rtk
from uavlab.sensors.slam import Slam

__all__ = [
    "NO_OUTLIERS",
    "FlowCamera",
    "Gnss",
    "ImuSensor",
    "Jump",
    "Mocap",
    "Outage",
    "Outliers",
    "Rtk",
    "Sensor",
    "Slam",
]
