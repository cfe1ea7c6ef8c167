"""From truth to measurement, one file per instrument: bias, drift, noise, rate, delay, drop-out, jumps, outliers."""

from uavlab.sensors.ahrs import Ahrs
from uavlab.sensors.barometer import Barometer
from uavlab.sensors.bearings import BeaconCamera
from uavlab.sensors.faults import NO_OUTLIERS, Jump, Outliers
from uavlab.sensors.flow import FlowCamera
from uavlab.sensors.gnss import Gnss
from uavlab.sensors.imu import ImuSensor
from uavlab.sensors.kits import (
    INSTRUMENTS,
    KITS,
    carry,
    guarded,
    indoor,
    laboratory,
    outdoor,
    survey,
)
from uavlab.sensors.line import Outage, Sensor
from uavlab.sensors.magnetometer import Disturbance, Magnetometer, earth_field
from uavlab.sensors.mocap import Mocap
from uavlab.sensors.rangefinder import Rangefinder
from uavlab.sensors.remote import Hold, Receiver
from uavlab.sensors.rtk import Rtk
from uavlab.sensors.sectors import Scanner
from uavlab.sensors.slam import Slam

__all__ = [
    "INSTRUMENTS",
    "KITS",
    "NO_OUTLIERS",
    "Ahrs",
    "Barometer",
    "BeaconCamera",
    "Disturbance",
    "FlowCamera",
    "Gnss",
    "Hold",
    "ImuSensor",
    "Jump",
    "Magnetometer",
    "Mocap",
    "Outage",
    "Outliers",
    "Rangefinder",
    "Receiver",
    "Rtk",
    "Scanner",
    "Sensor",
    "Slam",
    "carry",
    "earth_field",
    "guarded",
    "indoor",
    "laboratory",
    "outdoor",
    "survey",
]
