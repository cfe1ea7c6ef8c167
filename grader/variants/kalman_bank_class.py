"""Right answers to lab 03, continued: banks of filters."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, isfinite, pi, sin

import numpy as np

from grader.material import variant
from uavlab.exercises.kalman_bank import KalmanBank
from uavlab.frames import compose, heading, moved, wrap
from uavlab.so3 import about_z, exp
from uavlab.sources import STATES, check_members, measured
from uavlab.types import NO_SHIFT, Estimate, Fix, Flow, Hypothesis, Range

CANARY = "canary-1d65d6be078164c2e4e974ee"


class Member:
    """One member: a dense filter of the eleven states of (6), an object that is copied before it changes."""

    def __init__(self, x, P, sources, own):
        self.x, self.P = x, P
        self.silent = dict.fromkeys(sources, 0.0 if own else inf)
        self.mean = dict.fromkeys(sources, 1.0)
        self.reliable, self.rejected = own, 0

    def copy(self):
        new = Member(self.x.copy(), self.P.copy(), (), self.reliable)
        new.silent, new.mean, new.rejected = dict(self.silent), dict(self.mean), self.rejected
        return new

    def told(self):
        x, P = self.x[:9].reshape(3, 3), self.P
        blocks = np.array([P[i : i + 3, i : i + 3] for i in (0, 3, 6)])
        nis = float(np.mean(list(self.mean.values())))
        return Hypothesis(
            x.copy(), blocks, self.x[9:].copy(), P[9:, 9:].copy(), nis, bool(self.reliable)
        )


@variant(KalmanBank)
@dataclass
class DenseBank:
    """All eleven states of (6) in one filter for each member, in a loop, with the simple form of the correction."""

    members: dict
    variances: dict
    p: tuple = (0.9, 0.9, 1.0)
    q_xy: tuple = (0.1, 1.0, 1.0)
    q_z: tuple = (0.1, 1.0, 1.0)
    q_heading: tuple = (0.01, 1.0)
    start: tuple = (1.0, 1.0, 1.0, 0.1, 0.1)
    gate: float = 25.0
    forget: float = 0.05
    limits: tuple = (2.0, 4.0)
    patience: float = 1.0
    tilt: float = 0.52

    def __post_init__(self):
        check_members(self.members, self.variances)

    def init(self, estimate):
        rate = self.rate(estimate.R, estimate.omega)
        flat = np.column_stack([estimate.r, estimate.v, estimate.a]).ravel()
        x = np.concatenate([flat, [heading(estimate.R), rate]])
        P = np.diag(np.array([*self.start[:3] * 3, *self.start[3:]]) ** 2.0)
        made = {k: Member(x, P, own, k == estimate.world) for k, own in self.members.items()}
        return {
            "t": None,
            "last": {},
            "R": estimate.R,
            "omega": estimate.omega,
            "world": NO_SHIFT,
            "of": made,
        }

    @staticmethod
    def rate(R, omega):
        return (omega[1] * R[2, 1] + omega[2] * R[2, 2]) / (1.0 - R[2, 0] ** 2)

    def step(self, memory, readings, command, dt, flies=""):
        m = {
            **memory,
            "last": dict(memory["last"]),
            "of": {k: x.copy() for k, x in memory["of"].items()},
        }
        good = self.screen(m, readings, dt)
        if "imu" in good:
            m["omega"] = good["imu"].gyro
        m["R"] = good["attitude"].R if "attitude" in good else m["R"] @ exp(m["omega"] * dt)
        eta = m["of"][flies].x[9] if flies else None
        for x in m["of"].values():
            self.predict(x, about_z(x.x[9] - eta) @ command.a_d if flies else command.a_d, dt)
            for what in STATES:
                for source in sorted(s for s in x.silent if s.endswith("." + what)):
                    if source.split(".")[0] in good:
                        self.correct(x, source, what, good[source.split(".")[0]], m)
            well = all(s <= self.patience for s in x.silent.values())
            top = self.limits[1] if x.reliable else self.limits[0]
            x.reliable = well and all(mean < top for mean in x.mean.values())
        return m, {k: x.told() for k, x in m["of"].items()}

    def screen(self, m, readings, dt):
        now = None if m["t"] is None else m["t"] + dt
        good = {}
        for k, x in readings.items():
            fine = isfinite(sum(float(np.sum(part)) for part in x)) and x.t > m["last"].get(k, -inf)
            if fine and (now is None or abs(now - x.t) <= self.patience):
                good[k] = x
                m["last"][k] = x.t
                continue
            for member in m["of"].values():
                hears = k == "attitude" or any(s.split(".")[0] == k for s in member.silent)
                member.rejected += int(hears)
        heard = [x.t for x in good.values()] + ([] if now is None else [now])
        m["t"] = max(heard) if heard else None
        return good

    def predict(self, x, u, dt):
        A, B, q = np.zeros((11, 11)), np.zeros((11, 3)), []
        for axis, (p, more) in enumerate(
            zip((self.p[0], self.p[0], self.p[1]), (self.q_xy, self.q_xy, self.q_z), strict=True)
        ):
            i, left = 3 * axis, p ** (100.0 * dt)
            A[i : i + 3, i : i + 3] = [[1, dt, dt * dt / 2], [0, 1, dt], [0, 0, left]]
            B[i + 2, axis] = 1 - left
            q += more
        A[9:, 9:] = [[1, dt], [0, self.p[2] ** (100.0 * dt)]]
        x.x = A @ x.x + B @ u
        x.x[9] = (x.x[9] + pi) % (2 * pi) - pi
        x.P = A @ x.P @ A.T + dt * np.diag([*q, *self.q_heading])
        x.silent = {k: s + dt for k, s in x.silent.items()}

    def correct(self, x, source, what, reading, m):
        R_z, R = self.variances[source], m["R"]
        steep = isinstance(reading, Flow | Range) and R[2, 2] < cos(self.tilt)
        unsure = isinstance(reading, Fix) and what != "velocity" and reading.std > 3.0 * R_z**0.5
        if steep or unsure:
            x.rejected += 1
            return
        own = about_z(x.x[9] - heading(R)) @ R
        z = (
            [self.rate(R, reading.gyro)]
            if what == "heading_rate"
            else measured(source, reading, own, x.x[7], m["world"])
        )
        axes, i = STATES[what]
        starts = [9] if axes is None else [3 * axis for axis in axes]
        size, late = 2 if axes is None else 3, max(m["t"] - reading.t, 0.0)
        H = np.zeros((len(starts), 11))
        for row, first in enumerate(starts):
            H[row, first + i : first + size] = (1.0, -late, late**2 / 2)[: size - i]
        nu = np.asarray(z) - H @ x.x
        nu = np.array([wrap(float(nu[0]))]) if what == "heading" else nu
        if x.silent[source] > self.patience:
            self.begin(x, [first + i for first in starts], nu, R_z, what)
        else:
            S = H @ x.P @ H.T + R_z * np.eye(len(nu))
            nis = float(nu @ np.linalg.solve(S, nu)) / len(nu)
            x.mean[source] = (1 - self.forget) * x.mean[source] + self.forget * min(nis, self.gate)
            if nis > self.gate:
                x.rejected += 1
                return
            K = np.linalg.solve(S, H @ x.P).T
            x.x, x.P = x.x + K @ nu, (np.eye(11) - K @ H) @ x.P
        x.x[9] = (x.x[9] + pi) % (2 * pi) - pi
        x.silent[source] = 0.0

    def begin(self, x, states, nu, R_z, what):
        told = [
            s
            for s, t in x.silent.items()
            if t <= self.patience and s.endswith(("velocity", "position"))
        ]
        if what == "heading" and not told:
            c, s = cos(nu[0]), sin(nu[0])
            for i in (1, 2):
                x.x[i], x.x[i + 3] = c * x.x[i] - s * x.x[i + 3], s * x.x[i] + c * x.x[i + 3]
        for state, step in zip(states, nu, strict=True):
            x.x[state] += step
            x.P[state], x.P[:, state] = 0.0, 0.0
            x.P[state, state] = R_z

    def reframe(self, memory, shift):
        new = {}
        for k, x in memory["of"].items():
            r, v, a = x.x[:9].reshape(3, 3).T
            there = moved(Estimate(r, v, a, about_z(x.x[9]), np.zeros(3)), shift)
            new[k] = x.copy()
            new[k].x[:9] = np.column_stack(there[:3]).ravel()
            new[k].x[9] = heading(there.R)
        world = compose(shift, memory["world"])
        return {**memory, "of": new, "R": about_z(shift.heading) @ memory["R"], "world": world}

    def rejected(self, memory):
        return {k: int(x.rejected) for k, x in memory["of"].items()}


@variant(KalmanBank)
class BankOfBanks:
    """A bank for each member: they do not know of each other anyway. Only who flies is told to all."""

    def __init__(self, members, variances, **more):
        self.own = {k: DenseBank.run({k: tuple(s)}, variances, **more) for k, s in members.items()}

    def init(self, estimate):
        return tuple(bank.init(estimate) for bank in self.own.values())

    def step(self, memory, readings, command, dt, flies=""):
        turn = None
        if flies:
            turn = memory[list(self.own).index(flies)]["of"][flies].x[9]
        new, told = [], {}
        for (name, bank), m in zip(self.own.items(), memory, strict=True):
            mine = command
            if turn is not None:
                mine = command._replace(a_d=about_z(m["of"][name].x[9] - turn) @ command.a_d)
            m, said = bank.step(m, readings, mine, dt)
            new.append(m)
            told |= said
        return tuple(new), told

    def reframe(self, memory, shift):
        return tuple(
            bank.reframe(m, shift) for bank, m in zip(self.own.values(), memory, strict=True)
        )

    def rejected(self, memory):
        counts = [bank.rejected(m) for bank, m in zip(self.own.values(), memory, strict=True)]
        return {k: n for one in counts for k, n in one.items()}
