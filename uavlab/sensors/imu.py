"""The inertial measurement unit: specific force and angular velocity, with noise and wandering bias."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple, final

import numpy as np

from uavlab.sensors.drift import drift_step
from uavlab.sensors.faults import NO_OUTLIERS, Jump, Outliers, check_faults, jumped, outlier
from uavlab.sensors.line import (
    Line,
    Outage,
    Truth,
    check_line,
    check_sizes,
    due,
    lost,
    receive,
    send,
)
from uavlab.types import GRAVITY, Imu, Vec3

_G = np.array((0.0, 0.0, GRAVITY))


class ImuMemory(NamedTuple):
    """Biases, and readings under way."""

    gyro_offset: Vec3  # (3,) [rad/s], drawn when switched on
    accel_offset: Vec3  # (3,) [m/s²]
    gyro_drift: Vec3  # (3,) [rad/s], wandering
    accel_drift: Vec3  # (3,) [m/s²]
    line: Line


@final
class ImuSensor(NamedTuple):
    """Gyroscopes and accelerometers at the centre of mass, along the body axes.

    Noise and bias are those of the MRS Gazebo simulation (mrs_uav_gazebo_simulation 5dc8b8b); rate and delay are ours.
    Density times √rate is the standard deviation of one sample.
    """

    rate: float = 100.0  # [Hz]
    delay: float = 0.0  # [s]
    gyro_noise: float = 1.87e-4  # [rad/s/√Hz]
    gyro_walk: float = 3.88e-5  # [rad/s²/√Hz] drives the bias
    gyro_turn_on: float = 0.0087  # [rad/s], standard deviation of the bias at switch-on
    gyro_tau: float = 1000.0  # [s], correlation time of the bias
    accel_noise: float = 1.86e-3  # [m/s²/√Hz]
    accel_walk: float = 6e-3  # [m/s³/√Hz]
    accel_turn_on: float = 0.196  # [m/s²]
    accel_tau: float = 300.0  # [s]
    dropout: float = 0.0  # probability that a sample is lost
    outages: tuple[Outage, ...] = ()
    jumps: tuple[Jump, ...] = ()  # by: accelerometer bias [m/s²]; turn: gyro bias [rad/s]
    outliers: Outliers = NO_OUTLIERS  # size [m/s²], turn [rad/s]

    def init(self, rng: np.random.Generator) -> ImuMemory:
        """Switch on: draw the offsets.

        Raises
        ------
        BadInput
            A rate, delay, noise or probability that no instrument can have.
        """
        check_line("imu", self.rate, self.delay, self.dropout, self.outages)
        sizes = {k: v for k, v in self._asdict().items() if k.startswith(("gyro", "accel"))}
        check_sizes("imu", **sizes)
        check_faults("imu", self.dropout, self.jumps, self.outliers, turn=3)
        gyro = self.gyro_turn_on * rng.standard_normal(3)
        accel = self.accel_turn_on * rng.standard_normal(3)
        return ImuMemory(gyro, accel, np.zeros(3), np.zeros(3), Line())

    def step(
        self, memory: ImuMemory, world: Truth, dt: float, rng: np.random.Generator
    ) -> tuple[ImuMemory, Imu | None]:
        """The sample that arrives now: specific force Rᵀ(a + g e3) [m/s²] and ω [rad/s], both body."""
        line, since = due(memory.line, world.t, self.rate)
        if since >= 0.0:
            gyro = drift_step(memory.gyro_drift, self.gyro_tau, self.gyro_walk, since, rng)
            accel = drift_step(memory.accel_drift, self.accel_tau, self.accel_walk, since, rng)
            memory = memory._replace(gyro_drift=gyro, accel_drift=accel)
            white, chance = sqrt(self.rate) * rng.standard_normal(6), rng.random()
            if not lost(world.t, chance, self.dropout, self.outages):
                force = world.R.T @ (world.a + _G) + memory.accel_offset + accel
                omega = world.omega + memory.gyro_offset + gyro
                by, turn = jumped(world.t, self.jumps)
                wrong, wrong_turn = outlier(chance, self.outliers)
                force = force + self.accel_noise * white[:3] + by + wrong
                omega = omega + self.gyro_noise * white[3:] + turn + wrong_turn
                line = send(line, Imu(world.t, force, omega))
        line, arrived = receive(line, world.t, self.delay)
        return memory._replace(line=line), arrived  # type: ignore[return-value]
