"""Estimators that fly the answers of the complementary lab: attitude and position indoors, and the coupled pair."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.frames import Shift, moved
from uavlab.interfaces import Readings, asks
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.so3 import quaternion_from_rotation, rotation_from_quaternion
from uavlab.types import (
    GRAVITY,
    Command,
    CoupledGains,
    Estimate,
    Fix,
    Height,
    Hypothesis,
    Imu,
    Pose,
    Quat,
    Vec3,
    VerticalGains,
    VerticalMemory,
)

_G = np.array((0.0, 0.0, GRAVITY))
_G.setflags(write=False)
# The field of the earth at 50° north, in units of its size: north (our y) and down.
FIELD = np.array((0.0, 0.42, -0.91))
FIELD.setflags(write=False)


class Held(NamedTuple):
    """Memory of `ComplementaryEstimator`."""

    estimate: Estimate
    vertical: VerticalMemory
    pose: Pose | None  # the last one that the cameras sent
    height: float | None  # [m], the last one of the barometer


@dataclass(frozen=True)
class ComplementaryEstimator:
    """Attitude and position from slow camera poses and an IMU (Spica 6.1), height from a barometer (Bangura 4).

    A pose is held until the next one arrives, carried on by what has been flown since: the answers are called with a
    measurement at every tick.
    """

    slot: ClassVar[str] = "estimator"
    attitude_step: Callable[[Quat, Vec3, Quat, float, float], Quat] = asks("complementary")
    position_observer_step: Callable[..., tuple[Vec3, Vec3]] = asks("complementary")
    vertical_step: Callable[..., VerticalMemory] = asks("complementary")
    height: str = "barometer"  # the instrument that measures height: barometer or mocap
    gain: float = 5.0  # [1/s] of the attitude filter
    k_p: float = 8.0  # [1/s] of the position observer: two poles at −4 rad/s
    k_v: float = 16.0  # [1/s²]
    vertical: VerticalGains = VerticalGains()

    @staticmethod
    def stand_in(**_parameters: Any) -> AlphaBetaGamma:
        """What flies while one of the three functions is missing."""
        return AlphaBetaGamma()

    def init(self, estimate: Estimate) -> Held:
        """Continue from `estimate`."""
        return Held(
            estimate, VerticalMemory(float(estimate.r[2]), float(estimate.v[2]), 0.0), None, None
        )

    def step(
        self, memory: Held, readings: Readings, command: Command, dt: float
    ) -> tuple[Held, Estimate]:
        """One tick of `dt` [s]: turn, push, correct."""
        was, pose, height = memory.estimate, memory.pose, memory.height
        imu, seen, high = readings.get("imu"), readings.get("mocap"), readings.get(self.height)
        omega, turn, accel = was.omega, np.zeros(3), was.R.T @ (was.a + _G)
        if isinstance(imu, Imu):
            omega, turn, accel = imu.gyro, imu.gyro, imu.accel
        if isinstance(seen, Pose):
            pose = seen
        if isinstance(high, Height | Pose):
            height = high.z if isinstance(high, Height) else float(high.r[2])
        q, k = quaternion_from_rotation(was.R), self.gain
        q_meas = q if pose is None else quaternion_from_rotation(pose.R)
        R = rotation_from_quaternion(self.attitude_step(q, turn, q_meas, k, dt))
        a = R @ accel - _G
        r_meas = None if pose is None else pose.r
        r, v = self.position_observer_step(was.r, was.v, a, r_meas, self.k_p, self.k_v, dt)
        vertical = self.vertical_step(memory.vertical, R, accel, height, dt, gains=self.vertical)
        r, v = np.array((r[0], r[1], vertical.z)), np.array((v[0], v[1], vertical.v_z))
        if pose is not None:  # carried on by what is flown until the next one
            seen_q = quaternion_from_rotation(pose.R)
            turned = self.attitude_step(seen_q, turn, seen_q, k, dt)
            pose = Pose(pose.t, pose.r + v * dt, rotation_from_quaternion(turned))
        a = a - np.array((0.0, 0.0, vertical.b_z))
        estimate = was._replace(r=r, v=v, a=a, R=R, omega=omega)
        return Held(estimate, vertical, pose, height), estimate

    def reframe(self, memory: Held, shift: Shift) -> Held:
        """The same belief, told in the new world."""
        up = float(shift.r[2])
        return Held(
            moved(memory.estimate, shift),
            memory.vertical._replace(z=memory.vertical.z + up),
            None if memory.pose is None else moved(memory.pose, shift),
            None if memory.height is None else memory.height + up,
        )

    def hypotheses(self, memory: Held) -> Mapping[str, Hypothesis]:
        """It has one belief only."""
        return {}


class Flown(NamedTuple):
    """Memory of `CoupledEstimator`."""

    filters: Any  # the memory of the coupled filter
    estimate: Estimate
    awake: bool  # an inertial sample has arrived


@dataclass(frozen=True)
class CoupledEstimator:
    """The coupled filters (Bangura II) as an estimator: IMU, magnetometer, barometer, and a velocity that may drop out.

    Position is the sum of the velocities, drawn to the fixes while there are some.
    """

    slot: ClassVar[str] = "estimator"
    CoupledFilter: Callable[..., Any] = asks("complementary")
    c: float = 0.0794  # drag coefficient of the rotors (Bangura V-A)
    gains: CoupledGains = CoupledGains()
    velocity: str = "gnss"  # the instrument that measures velocity over ground
    k_r: float = 0.5  # [1/s] position towards a fix

    @staticmethod
    def stand_in(**_parameters: Any) -> AlphaBetaGamma:
        """What flies while the class is missing."""
        return AlphaBetaGamma(position="gnss")

    def _filter(self) -> Any:
        return self.CoupledFilter(FIELD, self.c, self.gains, 0.5, self.velocity)

    def init(self, estimate: Estimate) -> Flown:
        """Continue from `estimate`."""
        return Flown(self._filter().init(estimate), estimate, False)

    def step(
        self, memory: Flown, readings: Readings, command: Command, dt: float
    ) -> tuple[Flown, Estimate]:
        """One tick of `dt` [s]."""
        was = memory.estimate
        filters, out = self._filter().step(memory.filters, readings, command, dt)
        if not memory.awake and "imu" not in readings:
            return memory, was
        r = was.r + out.v * dt
        fix = readings.get(self.velocity)
        if isinstance(fix, Fix) and bool(np.isfinite(fix.r).all()):
            r = r + min(self.k_r * 0.1, 1.0) * (fix.r - r)  # fixes come ten times a second
        r = np.array((r[0], r[1], out.z))
        estimate = was._replace(r=r, v=out.v, a=out.a, R=out.R, omega=out.omega)
        return Flown(filters, estimate, True), estimate

    def reframe(self, memory: Flown, shift: Shift) -> Flown:
        """The same belief, told in the new world."""
        filters = self._filter().reframe(memory.filters, shift)
        return memory._replace(filters=filters, estimate=moved(memory.estimate, shift))

    def hypotheses(self, memory: Flown) -> Mapping[str, Hypothesis]:
        """It has one belief only."""
        return {}
