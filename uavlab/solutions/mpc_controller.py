"""Lab 06, the reference answers: the controller that looks ahead (MRS Sec. 5.7), with a programme for each axis.

The limits of x and y belong to axes. These stay where they were at `init`, whatever world the estimate is told in.

Beyond the exercise it can follow. With (44) the plan brakes for a reference that moves, the aircraft lags by 1.2 m at
1 m/s, the mass learns the lag, and swings. So newer mrs_uav_controllers plan along what the tracker predicts;
``gains.follows`` carries the reference on by its own velocity, and learns from nothing that is a way to go.
"""

# canary-06a3f9d27c51be84d9e2705b

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import hypot, sqrt
from typing import ClassVar, NamedTuple

import numpy as np

from uavlab import frames
from uavlab.gains import MpcGains
from uavlab.interfaces import Memory, standing_command
from uavlab.limits import AxisLimits, ForceLimits
from uavlab.parts.controllers import Handover, fading, limited_tilt
from uavlab.qp import QP, Plan
from uavlab.so3 import about_z, hat, vee
from uavlab.solutions.mpc_qp import build_force_qp, initial_state
from uavlab.solvers import Affine, Solver, affine
from uavlab.types import GRAVITY, Array, Command, Estimate, Mat3, Reference, Shift, Vec3
from uavlab.weights import HORIZONTAL, VERTICAL, ForceWeights

E3 = np.array((0.0, 0.0, 1.0))
CALM = 0.3  # [m/s] horizontal speed above which a position error is no disturbance (MRS software)
LIGHTEST = 0.1  # of the mass that was told: m_max is more than a small aircraft weighs
FADE = 0.5  # [s] with which the difference to the command before us fades
P_UP = 0.5  # lag of the vertical model (MRS software)


class Ahead(NamedTuple):
    """Memory of `MpcController`. Its own axes are those of the world in which it began."""

    plans: tuple[Plan | None, ...]  # of x, y, z, own axes; None before the first
    inputs: Vec3  # (3,) [m/s²] applied last, own axes
    d_w: Vec3  # (3,) [N], own axes
    d_b: Vec3  # (3,) [N], heading frame
    m_e: float  # [kg]
    axes: float  # [rad] heading of the own axes in the world
    failed: int  # steps that flew on an old plan
    handover: Handover
    command: Command  # the last one, for when not even an attitude is known


@lru_cache(maxsize=16)
def programme(
    limits: AxisLimits,
    N: int,
    dt: float,
    p: float,
    weights: ForceWeights,
    period: float,
    follows: bool = False,
) -> tuple[Affine, Solver]:
    """The programme of an axis, factored once.

    It is one of (position error, velocity, acceleration, last input), and of the velocity of the reference if it
    ``follows``.
    """
    ahead = dt * np.arange(1, N + 1)

    def build(x0: Array, last: float, v: float = 0.0) -> QP:
        wanted = np.zeros((N, 3))  # (44), with the origin at the reference
        wanted[:, 0], wanted[:, 1] = v * ahead, v
        return build_force_qp(
            x0, wanted, last, limits=limits, N=N, dt=dt, p=p, weights=weights, period=period
        )

    steps = (1.0, min(1.0, limits.a), 1.0)
    sizes = ((3,), (), ())
    family = affine(build, sizes if follows else sizes[:2], steps if follows else steps[:2])
    return family, Solver(family.qp)


@dataclass(frozen=True)
class MpcController:
    """A force by looking ahead within limits, an attitude by feedback (MRS Sec. 5.7)."""

    slot: ClassVar[str] = "controller"
    mass: float
    limits: ForceLimits = ForceLimits()
    N: int = 26
    dt: float = 0.05
    gains: MpcGains = MpcGains()

    def init(self, estimate: Estimate, last: Command | None) -> Memory:
        """Nothing pushes, the mass is nominal; the first command is `last`."""
        a = np.zeros(3) if last is None else last.a_d
        most = np.array((
            self.limits.horizontal.a,
            self.limits.horizontal.a,
            self.limits.vertical.a,
        ))
        command = standing_command(self.mass) if last is None else last
        return Ahead(
            (None,) * 3, a.clip(-most, most), np.zeros(3), np.zeros(3), self.mass, 0.0, 0,
            Handover(last, None), command,
        )  # fmt: skip

    def step(
        self, memory: Memory, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Memory, Command]:
        """Plan each axis, learn from the error of now, and turn the force into rates."""
        if not _numbers(estimate.R, reference.a, reference.heading, reference.heading_rate):
            return memory._replace(failed=memory.failed + 1), memory.command  # there is no attitude
        H = about_z(memory.axes)
        takes_over = memory.handover.last is not None  # then that command flies on for this step
        period = 0.0 if takes_over else dt
        plans, c, solved = self._planned(memory, estimate, reference, period)
        m = memory._replace(plans=plans, inputs=c)
        m = self._learned(m, estimate, reference, period) if solved else m
        k, R, heading = self.gains, estimate.R, frames.heading(estimate.R)
        d = H @ m.d_w + about_z(heading) @ m.d_b  # (35), errata: H belongs here, once
        f = m.m_e * (reference.a + H @ c + GRAVITY * E3) - d  # (39)
        f = limited_tilt(f, k.tilt_max)
        R_d = _projected(f, reference.heading)  # (18)-(20): what the MRS software takes
        omega_d = -np.array(k.k_R) * vee(0.5 * (R_d.T @ R - R.T @ R_d))  # (24), (25)
        yaw_rate = reference.heading_rate * (1.0 - R_d[2, 0] ** 2) / R_d[2, 2]  # (31), closed form
        omega_d[2] += yaw_rate
        omega_d = omega_d.clip(np.negative(k.rate_max), k.rate_max)
        f_d = float(f @ R[:, 2])
        a_d = (f_d * R[:, 2] + d) / m.m_e - GRAVITY * E3  # (53), errata: m_e g, not g
        handover, command = fading(memory.handover, Command(f_d, omega_d, a_d), dt, FADE)
        failed = memory.failed + (not solved)
        return m._replace(failed=failed, handover=handover, command=command), command

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """The own axes stay, and have another heading; commands are told in the new world."""
        last, rest = (None if x is None else frames.moved(x, shift) for x in memory.handover)
        return memory._replace(
            axes=memory.axes + shift.heading,
            handover=Handover(last, rest),
            command=frames.moved(memory.command, shift),
        )

    def failures(self, memory: Memory) -> int:
        """Steps since `init` in which an axis had no new plan."""
        return memory.failed

    def _planned(
        self, memory: Ahead, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[tuple[Plan | None, ...], Vec3, bool]:
        """Plans and first inputs (3,) of the three axes [m/s²], and whether all are new."""
        with np.errstate(invalid="ignore"):  # what is no number is seen to below
            if memory.axes:
                back = Shift(np.zeros(3), -memory.axes)
                estimate, reference = frames.moved(estimate, back), frames.moved(reference, back)
            x0 = initial_state(estimate, reference, self.limits)  # (45)
            x0[:, 0] -= reference.r
        if self.gains.follows:
            x0[~np.isfinite(reference.v)] = np.nan  # there is nothing that one could follow
        flat, up = self.limits
        kinds = ((flat, 0.0, HORIZONTAL), (flat, 0.0, HORIZONTAL), (up, P_UP, VERTICAL))
        plans, c, solved = list(memory.plans), np.zeros(3), True
        for i, (limits, p, weights) in enumerate(kinds):
            family, solver = programme(limits, self.N, self.dt, p, weights, dt, self.gains.follows)
            new, now = None, np.append(x0[i], memory.inputs[i])
            if self.gains.follows:
                now = np.append(now, reference.v[i])
            if _numbers(x0[i]):
                new = solver.solve(*family(now), memory.plans[i])
            if new is None or not new.ok:
                solved, new = False, _shifted(memory.plans[i])
            plans[i] = new
            c[i] = 0.0 if new is None else new.z[0]
        return tuple(plans), c, solved

    def _learned(self, m: Ahead, estimate: Estimate, reference: Reference, dt: float) -> Ahead:
        """Disturbances and mass, one step later (MRS eq. 35, 37)."""
        k, e_p = self.gains, estimate.r - reference.r
        m_e, flat_rests = m.m_e, hypot(estimate.v[0], estimate.v[1]) > CALM
        up_rests = False
        if self.gains.follows:
            off = estimate.v - reference.v
            flat_rests = _on_its_way(e_p[:2], off[:2])
            too_fast = abs(reference.v[2]) > self.limits.vertical.v  # then who lags is not heavy
            up_rests = too_fast or _on_its_way(e_p[2:], off[2:])
        if not up_rests:
            m_e = m.m_e - k.k_m * float(e_p[2]) * dt  # (37), errata: who is heavy sags
        m_e = min(max(m_e, self.mass - k.m_max, LIGHTEST * self.mass), self.mass + k.m_max)
        if flat_rests:
            return m._replace(m_e=m_e)
        flat = np.array((e_p[0], e_p[1], 0.0))  # the height belongs to the mass
        d_w = m.d_w + k.k_iw * dt * (about_z(-m.axes) @ flat)  # (35)
        d_b = m.d_b + k.k_ib * dt * (about_z(-frames.heading(estimate.R)) @ flat)
        return m._replace(d_w=d_w.clip(-k.d_max, k.d_max), d_b=d_b.clip(-k.d_max, k.d_max), m_e=m_e)


def _numbers(*given: Array | float) -> bool:
    """Whether all of it is finite."""
    return all(np.isfinite(x).all() for x in given)


def _on_its_way(e: Array, off: Array) -> bool:
    """Whether an error `e` [m] is a way to go: it shrinks, at more than CALM [m/s]. Who is blown away learns."""
    return sqrt(off @ off) > CALM and float(e @ off) <= 0.0


def _shifted(plan: Plan | None) -> Plan | None:
    """The plan of a step before, one step later."""
    return None if plan is None else plan._replace(z=np.append(plan.z[1:], plan.z[-1]))


def _projected(f: Vec3, heading: float) -> Mat3:
    """Attitude with the thrust along `f`, and a nose that keeps as near to the heading as it can (18)-(20)."""
    b3 = f / np.linalg.norm(f)
    b2 = hat(b3) @ (np.cos(heading), np.sin(heading), 0.0)  # never zero: the tilt is limited
    b2 = b2 / np.linalg.norm(b2)
    return np.array((hat(b2) @ b3, b2, b3)).T
