"""Estimators: an alpha-beta-gamma observer, the stand-in that flies until a lab brings something better."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from uavlab.frames import Shift, moved
from uavlab.interfaces import Readings
from uavlab.so3 import exp
from uavlab.types import Command, Estimate, Fix, Hypothesis, Imu, Pose

HEARD = 0.3 + 1e-9  # [s] without a position: longer, and nothing of late stands behind the estimate


@dataclass(frozen=True)
class AlphaBetaGamma:
    """Constant-acceleration observer on positions; attitude as motion capture saw it last, turned on by the gyro.

    Between two fixes it only predicts; after 0.3 s without one the estimate is not ``reliable``. Stand-in: it knows
    neither noise levels nor gravity nor the command, and trusts the cameras' attitude as it comes.
    """

    slot: ClassVar[str] = "estimator"
    position: str = "mocap"  # which instrument's position it follows: mocap or gnss
    bandwidth: float = 12.0  # [rad/s] of the triple real pole

    def init(self, estimate: Estimate) -> tuple[Estimate, float]:
        """Continue from `estimate`; the second number is the time [s] since the last fix."""
        return estimate, 0.0

    def step(
        self, memory: tuple[Estimate, float], readings: Readings, command: Command, dt: float
    ) -> tuple[tuple[Estimate, float], Estimate]:
        """Predict by `dt` [s], then correct with what arrived."""
        was, age = memory
        r, v, a, R, omega = was[:5]
        r, v = r + (v + a * (0.5 * dt)) * dt, v + a * dt
        age += dt

        imu, pose = readings.get("imu"), readings.get("mocap")
        if isinstance(imu, Imu):
            omega = imu.gyro
            R = R @ exp(omega * dt)
        if isinstance(pose, Pose):
            R = pose.R

        fix = readings.get(self.position)
        if isinstance(fix, Pose | Fix):
            # Triple pole at w: the gains of a critically damped third-order observer.
            x = min(self.bandwidth * age, 1.0)
            e = fix.r - r
            r, v, a = r + e * min(3 * x, 1.0), v + e * (3 * x * x / age), a + e * (x**3 / age**2)
            age = 0.0
        estimate = was._replace(r=r, v=v, a=a, R=R, omega=omega, reliable=age <= HEARD)
        return (estimate, age), estimate

    def reframe(self, memory: tuple[Estimate, float], shift: Shift) -> tuple[Estimate, float]:
        """The same belief, told in the new world."""
        return moved(memory[0], shift), memory[1]

    def hypotheses(self, memory: tuple[Estimate, float]) -> Mapping[str, Hypothesis]:
        """It has one belief only."""
        return {}
