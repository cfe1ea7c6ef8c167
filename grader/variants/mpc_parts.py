"""Right answers to lab 06, continued: controllers and trackers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from grader.material import variant
from grader.mutants.mpc_qps import force
from uavlab.exercises.mpc import MpcController, MpcTracker
from uavlab.frames import heading, moved, wrap
from uavlab.gains import MpcGains
from uavlab.limits import AxisLimits, ForceLimits
from uavlab.qp import QP
from uavlab.so3 import about_z
from uavlab.solutions.mpc import MpcTracker as Right
from uavlab.solvers import Solver, affine
from uavlab.types import GRAVITY, Command, Reference, Shift, Trajectory
from uavlab.weights import HORIZONTAL, VERTICAL

CANARY = "canary-b038d3ff18b15a83ee0e99d8"

# Controllers ------------------------------------------------------------------------------------------


@lru_cache(maxsize=32)
def solver_of(limits, N, dt, p, weights, period):
    """Of one axis: q and bounds from state and last input, and what solves with them."""

    def build(x0, last):
        still = np.zeros((N, 3))
        return force(
            x0, still, last, limits=limits, N=N, dt=dt, p=p, weights=weights, period=period
        )

    family = affine(build, ((3,), ()), (1.0, 0.5 * limits.a))
    return family, Solver(family.qp)


@variant(MpcController)
@dataclass
class VectorController:
    """All in the world of now: inputs and plans are turned as vectors when it changes. Memory is a dict."""

    mass: float
    limits: ForceLimits = ForceLimits()
    N: int = 26
    dt: float = 0.05
    gains: MpcGains = field(default_factory=MpcGains)

    def most(self):
        return np.array([self.limits.horizontal.a] * 2 + [self.limits.vertical.a])

    def init(self, estimate, last):
        a = np.zeros(3) if last is None else np.clip(last.a_d, -self.most(), self.most())
        return {
            "plan": np.tile(a, (self.N, 1)), "last": a, "world": np.zeros(2), "nose": np.zeros(2),
            "mass": self.mass, "failed": 0, "gap": None, "before": last, "command": last,
        }  # fmt: skip

    def start(self, x, wish):
        out = []
        for i, limits in enumerate((self.limits[0], self.limits[0], self.limits[1])):
            v = wish.v[i] if abs(x.v[i]) >= 1.5 * limits.v else x.v[i]
            a = wish.a[i] if abs(x.a[i]) >= 1.5 * limits.a else x.a[i]
            out.append(np.array([x.r[i] - wish.r[i], v, a]))
        return out

    def planned(self, memory, x, wish, period):
        plan, good = np.vstack([memory["plan"][1:], memory["plan"][-1:]]), True
        for i, x0 in enumerate(self.start(x, wish)):
            kind = (self.limits[1], 0.5, VERTICAL) if i == 2 else (self.limits[0], 0.0, HORIZONTAL)
            if not np.isfinite(x0).all():
                good = False
                continue
            family, solver = solver_of(kind[0], self.N, self.dt, kind[1], kind[2], period)
            found = solver.solve(*family(np.append(x0, memory["last"][i])))
            good = good and found.ok
            if found.ok:
                plan[:, i] = found.z
        return plan, good

    def learned(self, m, x, wish, dt):
        k, e = self.gains, x.r - wish.r
        least = max(self.mass - k.m_max, 0.1 * self.mass)
        m["mass"] = float(np.clip(m["mass"] - k.k_m * e[2] * dt, least, self.mass + k.m_max))
        if np.hypot(*x.v[:2]) <= 0.3:
            back = about_z(-heading(x.R))[:2, :2]
            m["world"] = np.clip(m["world"] + k.k_iw * dt * e[:2], -k.d_max, k.d_max)
            m["nose"] = np.clip(m["nose"] + k.k_ib * dt * back @ e[:2], -k.d_max, k.d_max)

    def step(self, memory, estimate, reference, dt):
        m = dict(memory)
        plan, good = self.planned(m, estimate, reference, dt)
        m["plan"], m["last"] = plan, plan[0]
        if good:
            self.learned(m, estimate, reference, dt)
        own = self.law(m, estimate, reference, plan[0])
        m["failed"] += not good
        if not np.isfinite(np.concatenate([[own.f_d], own.omega_d, own.a_d])).all():
            return m, m["command"] or Command(self.mass * GRAVITY, np.zeros(3), np.zeros(3))
        if m["before"] is not None:
            m["gap"] = [a - b for a, b in zip(m["before"], own, strict=True)]
            m["before"] = None
        elif m["gap"] is not None:
            m["gap"] = [x * math.exp(-dt / 0.5) for x in m["gap"]]
        if m["gap"] is not None:
            own = Command(*(a + b for a, b in zip(own, m["gap"], strict=True)))
        m["command"] = own
        return m, own

    def law(self, m, x, wish, c):
        k, R = self.gains, x.R
        d = np.append(m["world"] + about_z(heading(R))[:2, :2] @ m["nose"], 0.0)
        f = m["mass"] * (wish.a + c + [0.0, 0.0, GRAVITY]) - d
        f[2] = max(f[2], 1.0)
        flat = math.hypot(f[0], f[1])
        if flat > f[2] * math.tan(k.tilt_max):
            f[:2] *= f[2] * math.tan(k.tilt_max) / flat
        b3 = f / math.sqrt(f @ f)
        h = np.array([math.cos(wish.heading), math.sin(wish.heading), 0.0])
        b1 = h - (h @ b3) * b3
        b1 /= math.sqrt(b1 @ b1)
        R_d = np.array([b1, np.cross(b3, b1), b3]).T
        E = R_d.T @ R
        e = 0.5 * np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]])
        omega = -np.array(k.k_R) * e
        omega[2] += wish.heading_rate * (1.0 - R_d[2, 0] ** 2) / R_d[2, 2]
        omega = np.minimum(np.maximum(omega, -np.array(k.rate_max)), k.rate_max)
        thrust = float(f @ R[:, 2])
        return Command(thrust, omega, (thrust * R[:, 2] + d) / m["mass"] - [0.0, 0.0, GRAVITY])

    def reframe(self, memory, shift):
        m, Rz = dict(memory), about_z(shift.heading)
        m["plan"], m["last"], m["world"] = m["plan"] @ Rz.T, Rz @ m["last"], Rz[:2, :2] @ m["world"]
        for name in ("before", "command"):
            m[name] = None if m[name] is None else moved(m[name], shift)
        m["gap"] = None if m["gap"] is None else list(moved(Command(*m["gap"]), shift))
        return m

    def failures(self, memory):
        return int(memory["failed"])


@variant(MpcController)
class LearnsLast(VectorController.run):
    """The same, but learning from the error after the command; that is one step later. The memory is a list."""

    def init(self, estimate, last):
        return [super().init(estimate, last), []]

    def step(self, memory, estimate, reference, dt):
        m = dict(memory[0])
        for x, wish in memory[1]:
            VectorController.run.learned(self, m, x, wish, dt)
        new, out = super().step(m, estimate, reference, dt)
        return [new, [(estimate, reference)] if new["failed"] == m["failed"] else []], out

    def learned(self, m, x, wish, dt):
        pass

    def reframe(self, memory, shift):
        return [
            super().reframe(memory[0], shift),
            [tuple(moved(y, shift) for y in x) for x in memory[1]],
        ]

    def failures(self, memory):
        return super().failures(memory[0])


# Trackers ---------------------------------------------------------------------------------------------


def flow(h):
    A = np.array([[1, h, h * h / 2, h**3 / 6], [0, 1, h, h * h / 2], [0, 0, 1, h], [0, 0, 0, 1.0]])
    return A, np.array([h**4 / 24, h**3 / 6, h * h / 2, h])


@lru_cache(maxsize=64)
def course_of(N, dt, tick, scale):
    """Maps of a plan whose steps grow from a tick to dt, and its solver."""
    spans = np.minimum(tick * 1.25 ** np.arange(N), dt)
    free, push, P, G = [], [], np.eye(4), np.zeros((4, N))
    for k, span in enumerate(spans):
        A, b = flow(span)
        P, G = A @ P, A @ G
        G[:, k] += b
        free.append(P)
        push.append(G)
    free, push = np.array(free), np.array(push)
    tau = scale
    e, f = (
        push[:, 0] + 2 * tau * push[:, 1] + tau**2 * push[:, 2],
        free[:, 0] + 2 * tau * free[:, 1] + tau**2 * free[:, 2],
    )
    w = spans
    H = 2 * (e.T * w) @ e + 2e-3 * (push[:, 3].T * w) @ push[:, 3] + 2e-3 * np.diag(spans)
    rows = np.vstack([push[:, 1], push[:, 2], push[:, 3], np.eye(N)])
    soft = np.concatenate([np.full(N, 1e5), np.full(N, 1e6), np.full(N, 1e7), np.full(N, np.inf)])
    root = np.sqrt(spans)
    scaled = QP(
        H / np.outer(root, root), np.zeros(N), rows / root, -np.ones(4 * N), np.ones(4 * N), soft
    )
    return np.cumsum(spans), (free, push), (e, f, w, tau), root, Solver(scaled)


@variant(MpcTracker)
@dataclass(frozen=True)
class GrowingSteps:
    """Plans whose steps grow, in the world of now; the heading counts on without end. Memory is a tuple."""

    limits: object
    N: int = 40
    dt: float = 0.2

    def axes(self):
        flat, up, down, turn = self.limits[:4]
        small = [min(a, b) for a, b in zip(up, down, strict=True)]
        up, down = [AxisLimits(*x[:2], *small[2:]) for x in (up, down)]
        return ((flat, flat), (flat, flat), (up, down), (turn, turn))

    def init(self, estimate, last):
        x = np.zeros((4, 4))
        if last is None:
            x[:3, 0], x[:3, 1], x[3, 0] = estimate.r, estimate.v, heading(estimate.R)
        else:
            x[:3] = np.array([last.r, last.v, last.a, last.j]).T
            x[3, :2] = last.heading, last.heading_rate
        return x, None, 0.0, np.zeros((4, self.N)), 0

    def wanted(self, goal, age, t, x):
        """Places and headings at times from now."""
        out, v = (
            np.tile(x[:, 0] + 0.7 * x[:, 1] + 0.12 * x[:, 2], (len(t), 1)),
            np.zeros((len(t), 4)),
        )
        if isinstance(goal, Trajectory):
            s = age + t
            for i, way in enumerate([*goal.r.T, np.unwrap(goal.heading)]):
                out[:, i] = np.interp(s, goal.t, way)
                v[:, i] = (np.interp(s + 0.2, goal.t, way) - np.interp(s - 0.2, goal.t, way)) / 0.4
        elif goal is not None:
            v[:, :3], v[:, 3] = goal.v, goal.heading_rate
            out = np.append(goal.r, goal.heading) + v * (age + t)[:, None]
        out[:, 3] += 2 * math.pi * round((x[3, 0] - out[0, 3]) / (2 * math.pi))
        return out, v

    def step(self, memory, estimate, goal, dt):
        x, old, age, plans, failed = memory
        fine = goal is None or all(np.isfinite(np.sum(y)) for y in goal)
        if goal is not None and fine:
            old, age = goal, 0.0
        new, plans = np.zeros((4, 4)), plans.copy()
        told = Reference(*x[:3].T.copy(), wrap(float(x[3, 0])), float(x[3, 1]))
        A, b = flow(dt)
        for i, (up, down) in enumerate(self.axes()):
            scale = max(0.3, 0.3 * max(up.v / down.a, down.v / up.a))
            t, maps, weighed, root, solver = course_of(self.N, self.dt, dt, round(scale, 6))
            places, speeds = self.wanted(old, age, t, x)
            z = self.plan(x[i], places[:, i], speeds[:, i], (up, down), maps, weighed, root, solver)
            failed += z is None
            plans[i] = np.append(plans[i][1:], 0.0) if z is None else z
            new[i] = A @ x[i] + b * plans[i][0]
        return (new, old, age + dt, plans, failed + (not fine)), told

    def plan(self, x, place, speed, limits, maps, weighed, root, solver):
        (free, push), (e, f, w, tau), (up, down) = maps, weighed, limits
        N = len(root)
        most = np.clip(place, x[0] - 9.0 * down.v, x[0] + 9.0 * up.v) + 2 * tau * speed
        q = 2 * (e.T * w) @ (f @ x - most) + 2e-3 * (push[:, 3].T * w) @ (free[:, 3] @ x)
        at = np.concatenate([free[:, k] @ x for k in (1, 2, 3)] + [np.zeros(N)])
        high = np.concatenate([
            np.full(N, s * y) for s, y in zip((0.985, 0.985, 0.99, 1.0), up, strict=True)
        ])
        low = np.concatenate([
            np.full(N, s * y) for s, y in zip((0.985, 0.985, 0.99, 1.0), down, strict=True)
        ])
        found = solver.solve(q / root, -low - at, high - at)
        return found.z / root if found.ok else None

    def reframe(self, memory, shift):
        x, goal, age, plans, failed = memory
        Rz, x, plans = about_z(shift.heading), x.copy(), plans.copy()
        x[:3], plans[:3] = Rz @ x[:3], Rz @ plans[:3]
        x[:3, 0] += shift.r
        x[3, 0] += shift.heading
        return x, None if goal is None else moved(goal, shift), age, plans, failed

    def failures(self, memory):
        return int(memory[4])


@variant(MpcTracker)
class OtherHorizon:
    """The reference with more and shorter steps, asked in its own world and told in that of now."""

    def __init__(self, limits, N=40, dt=0.2):
        self.right = Right(limits, 45, 0.15)

    def init(self, estimate, last):
        return [self.right.init(estimate, last), []]

    def step(self, memory, estimate, goal, dt):
        inner, shifts = memory
        for shift in reversed(shifts):
            back = about_z(-shift.heading)
            goal = goal and moved(goal, Shift(-back @ shift.r, -shift.heading))
        inner, out = self.right.step(inner, estimate, goal, dt)
        for shift in shifts:
            out = moved(out, shift)
        return [inner, shifts], out._replace(heading=wrap(out.heading))

    def reframe(self, memory, shift):
        return [memory[0], [*memory[1], shift]]

    def failures(self, memory):
        return self.right.failures(memory[0])
