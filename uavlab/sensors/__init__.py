"""From truth to measurement, one file per instrument: bias, noise, rate, delay, drop-out."""

from uavlab.sensors.gnss import Gnss
from uavlab.sensors.imu import ImuSensor
from uavlab.sensors.line import Outage, Sensor
from uavlab.sensors.mocap import Mocap

__all__ = ["Gnss", "ImuSensor", "Mocap", "Outage", "Sensor"]
