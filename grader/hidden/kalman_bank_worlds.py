"""Hidden checks of lab 03, continued: the worlds of a bank, and what its instruments tell."""

from __future__ import annotations

from typing import Any

import numpy as np

from grader.material import hidden
from uavlab import frames, so3
from uavlab.exercises import draw
from uavlab.exercises.kalman_bank import KalmanBank
from uavlab.exercises.spec import Function, expect_close
from uavlab.frames import Shift
from uavlab.types import (
    Array,
    Attitude,
    Command,
    Estimate,
    Field,
    Fix,
    Flow,
    Height,
    Hypothesis,
    Imu,
    Mat3,
    Pose,
    Range,
    Vec3,
)

CANARY = "canary-3e3052a238110b5ea2f75524"

DT = 0.01
ZERO = np.zeros(3)
ALIKE = 1e-7  # [m], [rad], …: how near two ways of computing the same must be


def at(r: Vec3 = ZERO, v: Vec3 = ZERO, R: Mat3 | None = None, world: str = "") -> Estimate:
    """An estimate of an aircraft that does not accelerate or turn."""
    return Estimate(r, v, ZERO, np.eye(3) if R is None else R, ZERO, world)


def told(a_d: Vec3 = ZERO) -> Command:
    """A command of which only the acceleration matters."""
    return Command(0.0, ZERO, a_d)


def run(
    bank: Any, start: Estimate, plan: list[dict[str, Any]], a_d: Vec3 = ZERO, **more: Any
) -> Any:
    """Memory and hypotheses after one step for each of `plan`."""
    memory, last = bank.init(start), {}
    for readings in plan:
        memory, last = bank.step(memory, readings, told(a_d), DT, **more)
    return memory, last


def same(a: Hypothesis, b: Hypothesis, what: str = "") -> None:
    """Fail the check unless two hypotheses are the same."""
    for one, two in zip(a[:4], b[:4], strict=True):
        expect_close(one, two, what, atol=ALIKE)
    expect_close(a.nis, b.nis, what, atol=ALIKE)
    expect_close(float(a.reliable), float(b.reliable), what)


def turning(P: Array, Q: Array, H: Array, R_z: float) -> tuple[Array, Array]:
    """Gain and covariance after one step of a heading filter that keeps its rate."""
    A = np.array(((1.0, DT), (0.0, 1.0)))
    P = A @ P @ A.T + Q
    K = P @ H / (H @ P @ H + R_z)
    return K, P - np.outer(K, H @ P)


# Worlds -----------------------------------------------------------------------------------------------

FIVE = {
    "gnss": ("gnss.velocity", "gnss.position", "barometer.height"),
    "slam": ("slam.heading", "slam.position", "slam.height"),
    "flow": ("flow.velocity", "rangefinder.height"),
}
NOISE = {
    "gnss.velocity": 0.01,
    "gnss.position": 0.1,
    "barometer.height": 0.2,
    "slam.heading": 1e-3,
    "slam.position": 2e-3,
    "slam.height": 3e-3,
    "flow.velocity": 0.04,
    "rangefinder.height": 1e-3,
}


def everything(rng: np.random.Generator, steps: int) -> list[dict[str, Any]]:
    """Readings of all the instruments in each step, noise and all."""
    plan = []
    for k in range(1, steps + 1):
        t, r, v, flow = k * DT, *(0.3 * rng.normal(size=(2, 3))), 0.1 * rng.normal(size=2)
        R = so3.about_z(0.1 * rng.normal())
        readings = {"gnss": Fix(t, r, v), "slam": Pose(t, -r, R), "flow": Flow(t, flow)}
        readings |= {
            "barometer": Height(t, rng.normal()),
            "rangefinder": Range(t, 1 + rng.random()),
        }
        plan.append(readings)
    return plan


@hidden(KalmanBank)
def members_do_not_know_of_each_other(f: Function, rng: np.random.Generator) -> None:
    """Each member of a bank must do what it would do alone, in whatever order its sources and readings are given."""
    plan, a_d = everything(rng, 3), draw.vector(rng)
    _, all_of_them = run(f(FIVE, NOISE), at(world="gnss"), plan, a_d)
    backwards = [dict(reversed(readings.items())) for readings in plan]
    for name, own in FIVE.items():
        _, alone = run(f({name: own[::-1]}, NOISE), at(world="gnss"), backwards, a_d)
        same(all_of_them[name], alone[name])
    _, first = run(f(FIVE, NOISE), at(), plan[:1])
    expect_close(first["slam"].x[:, 0], plan[0]["slam"].r, atol=ALIKE)


@hidden(KalmanBank, weight=3.0)  # one of four methods, and flights rest on it
def the_same_bank_in_another_world(f: Function, rng: np.random.Generator) -> None:
    """Moved to another world, with what its instruments tell, a bank must go on as it would have."""
    members = {**FIVE, "north": ("magnetometer.heading", "imu.heading_rate", "rangefinder.height")}
    bank = f(members, {**NOISE, "magnetometer.heading": 0.01, "imu.heading_rate": 0.01})
    shift, a_d = Shift(draw.vector(rng, 3.0), draw.angle(rng)), draw.vector(rng)
    R = draw.tilted(rng, 0.1, 0.4)
    plan = everything(rng, 4)
    for k, readings in enumerate(plan, 1):
        readings["attitude"] = Attitude(k * DT, R)
        readings["magnetometer"] = Field(k * DT, R.T @ np.array((0.5, 0.1 * rng.normal(), -0.8)))
        readings["imu"] = Imu(k * DT, ZERO, draw.vector(rng, 0.1))
    memory, here = run(bank, at(R=R), plan[:2], a_d)
    moved = bank.reframe(memory, shift)
    for readings in plan[2:]:
        memory, here = bank.step(memory, readings, told(a_d), DT)
        over = {k: frames.moved(x, shift) if hasattr(x, "r") or k in {"attitude", "barometer"} else x
                for k, x in readings.items()}  # fmt: skip
        moved, there = bank.step(moved, over, frames.moved(told(a_d), shift), DT)
        turn = so3.about_z(shift.heading)
        for name in members:
            want = turn @ here[name].x
            want[:, 0] += shift.r
            expect_close(there[name].x, want, atol=ALIKE)
            expect_close(
                frames.wrap(there[name].h[0] - here[name].h[0] - shift.heading), 0.0, atol=ALIKE
            )
            expect_close(there[name].P, here[name].P, atol=ALIKE)
    expect_close(here["slam"].x[:, 0], plan[-1]["slam"].r, atol=2.0)


@hidden(KalmanBank)
def the_input_in_each_world(f: Function, rng: np.random.Generator) -> None:
    """What the controller asks for in the world of who flies must be turned into the world of each member."""
    members = {
        "slam": ("slam.heading", "slam.position"),
        "gnss": ("gnss.velocity", "gnss.position"),
    }
    turn, a_d = float(rng.uniform(0.5, 2.5)), draw.vector(rng, 2.0)
    seen = {"gnss": Fix(DT, ZERO, ZERO), "slam": Pose(DT, ZERO, so3.about_z(turn))}
    start = at(v=draw.vector(rng))
    for flies, angles in (("gnss", (turn, 0.0)), ("slam", (0.0, -turn)), ("", (0.0, 0.0))):
        bank = f(members, NOISE, p=(0.8, 0.7, 1.0))
        memory, before = run(bank, start, [seen])
        _, after = bank.step(memory, {}, told(a_d), DT, flies)
        for name, angle in zip(members, angles, strict=True):
            share = np.array((0.8, 0.8, 0.7))
            want = share * before[name].x[:, 2] + (1.0 - share) * (so3.about_z(angle) @ a_d)
            expect_close(after[name].x[:, 2], want, atol=ALIKE)


@hidden(KalmanBank)
def turned_along_at_the_start(f: Function, rng: np.random.Generator) -> None:
    """A member that hears its heading for the first time must turn its velocity along."""
    v, R = draw.vector(rng, 3.0), so3.about_z(draw.angle(rng))
    turn = float(rng.uniform(1.0, 2.5))
    bank = f({"slam": FIVE["slam"]}, NOISE)
    seen = Pose(DT, draw.vector(rng, 4.0), so3.about_z(turn) @ R)
    _, last = run(bank, at(v=v, R=R), [{"slam": seen}])
    expect_close(last["slam"].x[:, 1], so3.about_z(turn) @ v, atol=ALIKE)
    expect_close(last["slam"].x[:, 0], seen.r, atol=ALIKE)
    expect_close(np.diagonal(last["slam"].P[:, 0])[0], NOISE["slam.position"], atol=ALIKE)
    expect_close(last["slam"].P_h[0], (NOISE["slam.heading"], 0.0), atol=ALIKE)


# Instruments ------------------------------------------------------------------------------------------


@hidden(KalmanBank)
def tilted_instruments(f: Function, rng: np.random.Generator) -> None:
    """On a tilted aircraft, flow, range and field must be turned into the member's world, by its own heading."""
    members = {
        "low": ("slam.heading", "flow.velocity", "rangefinder.height"),
        "north": ("magnetometer.heading",),
    }
    bank = f(members, {**NOISE, "magnetometer.heading": 0.01})
    for _ in range(2):
        R, turn, v = draw.tilted(rng, 0.2, 0.45), draw.angle(rng), draw.vector(rng, 2.0)
        high = float(rng.uniform(1.0, 3.0))
        flow = (R.T @ so3.about_z(-turn) @ v)[:2]  # the aircraft flies with v in the world of slam
        readings = {
            "attitude": Attitude(DT, so3.about_z(draw.angle(rng)) @ R),
            "slam": Pose(DT, ZERO, so3.about_z(turn) @ R), "flow": Flow(DT, flow),
            "rangefinder": Range(DT, high / R[2, 2]), "magnetometer": Field(DT, R.T @ (0.4, 0.0, -0.9)),
        }  # fmt: skip
        _, last = run(bank, at(v=np.array((0.0, 0.0, v[2])), R=R), [readings])
        expect_close(last["low"].x[:, 1], v, "The flow is taken for something else.", atol=ALIKE)
        expect_close(last["low"].x[2, 0], high, "The range is taken for a height.", atol=ALIKE)
        off = frames.wrap(last["north"].h[0] - frames.heading(R))
        expect_close(off, 0.0, "The field is told in the body.", atol=ALIKE)


@hidden(KalmanBank)
def the_gyro_turns_the_heading(f: Function, rng: np.random.Generator) -> None:
    """The gyro must turn the heading by (15), on a tilted aircraft and across the seam at ±π, and know how well."""
    R, R_z = draw.aimed(rng, 0.3, 0.6), 0.02
    R = so3.about_z(np.pi - 0.01 - frames.heading(R)) @ R
    bank = f(
        {"gyro": ("imu.heading_rate",)}, {"imu.heading_rate": R_z}, q_heading=(0.02, 0.7), gate=1e3
    )
    h, P, H = np.array((np.pi - 0.01, 0.0)), 0.01 * np.eye(2), np.array((0.0, 1.0))
    memory = bank.init(at(R=R, world="gyro"))
    for k in range(1, 7):
        omega = draw.vector(rng, 0.1) + np.array((0.0, 0.5, 1.0))
        readings = {"imu": Imu(k * DT, ZERO, omega), "attitude": Attitude(k * DT, R)}
        memory, last = bank.step(memory, readings, told(), DT)
        K, P = turning(P, DT * np.diag((0.02, 0.7)), H, R_z)
        rate = (omega[1] * R[2, 1] + omega[2] * R[2, 2]) / (1.0 - R[2, 0] ** 2)
        h = np.array((h[0] + DT * h[1], h[1]))
        h += K * (rate - h[1])
        expect_close(frames.wrap(last["gyro"].h[0] - h[0]), 0.0, atol=ALIKE)
        expect_close(last["gyro"].h[1], h[1], atol=ALIKE)
        expect_close(last["gyro"].P_h, P, atol=ALIKE)


@hidden(KalmanBank)
def a_heading_at_the_seam(f: Function, rng: np.random.Generator) -> None:
    """A heading of just below π that is measured just above −π is a small surprise: it must not turn all around."""
    R_z = float(rng.uniform(0.005, 0.02))
    bank = f({"slam": ("slam.heading",)}, {"slam.heading": R_z})
    for side in (1.0, -1.0):
        eta, step = side * (np.pi - 0.02), side * 0.05
        h, P, H = np.array((eta, 0.0)), 0.01 * np.eye(2), np.array((1.0, 0.0))
        memory = bank.init(at(R=so3.about_z(eta), world="slam"))
        for k in range(1, 4):
            seen = Pose(k * DT, ZERO, so3.about_z(eta + step))
            memory, last = bank.step(memory, {"slam": seen}, told(), DT)
            K, P = turning(P, DT * np.diag((0.01, 1.0)), H, R_z)
            h = np.array((h[0] + DT * h[1], h[1]))
            h += K * (eta + step - h[0])
            expect_close(last["slam"].h, (frames.wrap(h[0]), h[1]), atol=ALIKE)


@hidden(KalmanBank)
def late_readings(f: Function, rng: np.random.Generator) -> None:
    """A fix that arrives late must correct what was true when it was taken."""
    late, (r, v) = 0.05, rng.normal(size=(2, 3))
    bank = f({"g": FIVE["gnss"]}, NOISE, gate=1e4)
    plan: list[dict[str, Any]] = [{"barometer": Height(k * DT, 0.0)} for k in range(1, 11)]
    plan[-1]["gnss"] = Fix(10 * DT - late, r, v)
    _, last = run(bank, at(world="g"), plan)
    A, Q = (
        np.array(((1.0, DT, DT**2 / 2), (0.0, 1.0, DT), (0.0, 0.0, 0.9))),
        DT * np.diag((0.1, 1.0, 1.0)),
    )
    P = np.eye(3)
    for _ in range(10):
        P = A @ P @ A.T + Q
    H = np.array(((1.0, -late, late**2 / 2), (0.0, 1.0, -late)))
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + np.diag((0.1, 0.01)))
    expect_close(last["g"].x[0], K @ (r[0], v[0]), atol=ALIKE)
    expect_close(last["g"].x[1], K @ (r[1], v[1]), atol=ALIKE)
    expect_close(last["g"].P[0], P - K @ H @ P, atol=ALIKE)
