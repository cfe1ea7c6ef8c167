"""An estimator that sees nothing but beacons: pose of each image, filtered with the IMU (Spica Sec. 6)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.frames import NO_SHIFT, Shift, compose, moved
from uavlab.interfaces import Readings, asks
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.so3 import exp, quaternion_from_rotation, rotation_from_quaternion
from uavlab.types import (
    GRAVITY,
    Array,
    Bearings,
    Command,
    Estimate,
    Hypothesis,
    Imu,
    Mat3,
    Pose,
    Quat,
    Vec3,
)

_G = np.array((0.0, 0.0, GRAVITY))
_G.setflags(write=False)


class Sighted(NamedTuple):
    """Memory of `BeaconEstimator`."""

    estimate: Estimate
    pose: Pose | None  # that of the last image, carried on by what has been flown since
    shift: Shift  # world of the beacons → the estimate's world
    rejected: int  # images without a pose, or with one that cannot be


@dataclass(frozen=True)
class BeaconEstimator:
    """Attitude and position (Spica eq. 12, 11) from bearings to beacons of known places, and an IMU.

    `solve` makes a pose of an image: bearings (n, 3), body, NaN where unseen → attitude body → world and position [m],
    or None.
    """

    slot: ClassVar[str] = "estimator"
    solve: Callable[[Array], tuple[Mat3, Vec3] | None]
    attitude_step: Callable[[Quat, Vec3, Quat, float, float], Quat] = asks("complementary")
    position_observer_step: Callable[..., tuple[Vec3, Vec3]] = asks("complementary")
    gain: float = 1.0  # [1/s] of the attitude filter
    k_p: float = 6.0  # [1/s] of the position observer: two poles at −3 rad/s
    k_v: float = 9.0  # [1/s²]
    reach: float = 2.0  # [m] from the estimate, beyond which a pose is not believed

    @staticmethod
    def stand_in(**_parameters: Any) -> AlphaBetaGamma:
        """What flies while a function is missing."""
        return AlphaBetaGamma()

    def init(self, estimate: Estimate) -> Sighted:
        """Continue from `estimate`, in the world of the beacons."""
        return Sighted(estimate, None, NO_SHIFT, 0)

    def step(
        self, memory: Sighted, readings: Readings, command: Command, dt: float
    ) -> tuple[Sighted, Estimate]:
        """One tick of `dt` [s]: look, turn, push, carry the sighting on."""
        now = self._looked(memory, readings.get("bearings"))
        was, pose, imu = now.estimate, now.pose, readings.get("imu")
        omega, accel = was.omega, was.R.T @ (was.a + _G)
        if isinstance(imu, Imu) and bool(
            np.isfinite(imu.accel).all() and np.isfinite(imu.gyro).all()
        ):
            omega, accel = imu.gyro, imu.accel
        q = quaternion_from_rotation(was.R)
        q_meas = q if pose is None else quaternion_from_rotation(pose.R)
        R = rotation_from_quaternion(self.attitude_step(q, omega, q_meas, self.gain, dt))
        a = R @ accel - _G
        r_meas = None if pose is None else pose.r
        r, v = self.position_observer_step(was.r, was.v, a, r_meas, self.k_p, self.k_v, dt)
        if pose is not None:
            pose = Pose(pose.t, pose.r + v * dt, pose.R @ exp(omega * dt))
        estimate = Estimate(r, v, a, R, omega, was.world, was.shift)
        return now._replace(estimate=estimate, pose=pose), estimate

    def reframe(self, memory: Sighted, shift: Shift) -> Sighted:
        """The same belief, told in the new world; the beacons stay where they are."""
        return Sighted(
            moved(memory.estimate, shift),
            None if memory.pose is None else moved(memory.pose, shift),
            compose(shift, memory.shift),
            memory.rejected,
        )

    def hypotheses(self, memory: Sighted) -> Mapping[str, Hypothesis]:
        """It has one belief only."""
        return {}

    def _looked(self, memory: Sighted, image: Any) -> Sighted:
        """The memory with the pose of a new image, if there is one that can be believed."""
        if not isinstance(image, Bearings):
            return memory
        found = self.solve(image.b)
        if found is None:
            return memory._replace(rejected=memory.rejected + 1)
        pose = moved(Pose(image.t, found[1], found[0]), memory.shift)
        if not float(np.linalg.norm(pose.r - memory.estimate.r)) <= self.reach:
            return memory._replace(rejected=memory.rejected + 1)
        return memory._replace(pose=pose)
