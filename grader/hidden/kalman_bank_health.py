"""Hidden checks of lab 03, continued: what a bank rejects, and when it calls a member reliable."""

from __future__ import annotations

from typing import Any

import numpy as np

from grader.hidden.kalman_bank_worlds import ALIKE, DT, ZERO, at, run, same, told
from grader.material import hidden
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.kalman_bank import KalmanBank
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.types import Attitude, Fix, Flow, Height, Hypothesis, Imu, Pose, Range

CANARY = "canary-b119d9bc28a0852c4289a24b"

UP = {"up": ("barometer.height",)}
AROUND = {"g": ("gnss.position", "gnss.height"), "s": ("slam.heading", "slam.position")}
NOISE = {"gnss.position": 0.04, "gnss.height": 0.04, "slam.heading": 0.01, "slam.position": 0.01}


def counted(
    f: Function, members: Any, noise: Any, good: list[Any], bad: dict[str, Any], R: Any
) -> Any:
    """What is rejected of `bad`, once it has changed no state; and what is believed."""
    bank = f(members, noise)
    memory, _ = run(bank, at(R=R, world=next(iter(members))), good)
    _, calm = bank.step(memory, {"attitude": Attitude(0.5, R)}, told(), DT)
    memory, after = bank.step(memory, {"attitude": Attitude(0.5, R), **bad}, told(), DT)
    for name, x in calm.items():
        for one, two in zip(x[:4], after[name][:4], strict=True):
            expect_close(
                two, one, "A reading that must be rejected has changed something.", atol=ALIKE
            )
    return bank.rejected(memory), after


@hidden(KalmanBank)
def what_cannot_be_is_counted(f: Function, rng: np.random.Generator) -> None:
    """What is not finite or runs backwards must be rejected by those who hear it, and counted once each."""
    r = draw.vector(rng)
    good = [
        {"gnss": Fix(k * DT, r, ZERO), "slam": Pose(k * DT, r, np.eye(3))} for k in range(49, 50)
    ]
    nan, far = r + np.array((np.nan, 0.0, 0.0)), r + 40.0
    for bad, want in (
        ({"gnss": Fix(0.5, nan, ZERO)}, {"g": 1, "s": 0}),
        ({"gnss": Fix(np.nan, r + 0.1, ZERO)}, {"g": 1, "s": 0}),
        ({"slam": Pose(0.49, r + 0.1, np.eye(3))}, {"g": 0, "s": 1}),
        ({"slam": Pose(0.2, r + 0.1, np.eye(3)), "gnss": Fix(0.3, r + 0.1, ZERO)}, {"g": 1, "s": 1}),
        ({"gnss": Fix(9.0, r + 0.1, ZERO)}, {"g": 1, "s": 0}),
        ({"gnss": Fix(0.5, far, ZERO)}, {"g": 2, "s": 0}),
        ({"gnss": Fix(0.5, r + 0.1, ZERO, std=0.7)}, {"g": 2, "s": 0}),
        ({"barometer": Height(0.5, np.nan)}, {"g": 0, "s": 0}),
    ):  # fmt: skip
        said, after = counted(f, AROUND, NOISE, good, bad, np.eye(3))
        expect(said == want, "The count is wrong.")
        expect_close(after["g"].x[:, 0], r, atol=0.2)


@hidden(KalmanBank)
def tilted_too_far(f: Function, rng: np.random.Generator) -> None:
    """What looks down must be rejected beyond the tilt that was set, and used within it."""
    low, noise = (
        {"low": ("flow.velocity", "rangefinder.height")},
        {"flow.velocity": 0.04, "rangefinder.height": 0.01},
    )
    good = [
        {"flow": Flow(k * DT, np.zeros(2)), "rangefinder": Range(k * DT, 2.0)}
        for k in range(49, 50)
    ]
    bad = {"flow": Flow(0.5, rng.uniform(0.1, 0.3, size=2)), "rangefinder": Range(0.5, 2.4)}
    said, after = counted(f, low, noise, good, bad, draw.tilted(rng, 0.56, 0.9))
    expect(said == {"low": 2 + 2 * len(good)}, "The count is wrong.")
    R = draw.tilted(rng, 0.2, 0.5)
    memory, last = run(f(low, noise), at(R=R), good)
    expect(f(low, noise).rejected(memory) == {"low": 0}, "It was not tilted too far.")
    expect_close(last["low"].x[2, 0], 2.0 * R[2, 2], atol=0.1)
    expect(after["low"].x[2, 0] < 1.0, "")


@hidden(KalmanBank)
def half_of_a_position_is_none(f: Function, rng: np.random.Generator) -> None:
    """A position is weighed as a whole: if x and y together are too surprising, neither may be used."""
    bank = f({"g": ("gnss.position",)}, {"gnss.position": 0.04}, gate=9.0)
    for off, taken in ((4.8, False), (3.6, True)):
        S = 1.0 + DT**2 + DT**4 / 4 + DT * 0.1 + 0.04
        seen = Fix(DT, np.array((off * np.sqrt(S), 0.1, 0.0)), ZERO)
        memory, last = run(bank, at(world="g"), [{"gnss": seen}])
        expect(bank.rejected(memory) == {"g": 0 if taken else 1}, "")
        want = seen.r[:2] * (1.0 - 0.04 / S) if taken else np.zeros(2)
        expect_close(last["g"].x[:2, 0], want, atol=ALIKE)


@hidden(KalmanBank)
def lost_and_found(f: Function, rng: np.random.Generator) -> None:
    """A source that was silent for too long makes its member unreliable; what it says then is taken as it is."""
    bank = f(
        {"b": ("barometer.height", "gnss.position")},
        {"barometer.height": 0.1, "gnss.position": 0.1},
        patience=0.055,
    )
    z, r = float(rng.uniform(20.0, 40.0)), draw.vector(rng, 30.0)
    memory, last = bank.init(at(world="b")), {}
    seen = []
    for k in range(1, 11):
        readings: dict[str, Any] = (
            {"barometer": Height(k * DT, z if k == 9 else 0.0)} if k in {1, 9, 10} else {}
        )
        readings |= {"gnss": Fix(k * DT, r, ZERO)} if k == 8 else {}
        memory, last = bank.step(memory, readings, told(), DT)
        seen.append((last["b"].reliable, numbers(last["b"].x, (3, 3))[:, 0]))
    expect(
        [bool(x[0]) for x in seen] == [True] * 5 + [False] * 3 + [True] * 2,
        "Reliable at the wrong times.",
    )
    expect_close(seen[8][1][2], z, "It is not taken as it is.", atol=ALIKE)
    expect_close(seen[7][1][0], r[0], "It is not taken as it is.", atol=ALIKE)
    expect(
        bank.rejected(memory) == {"b": 1}, "The one after that does not fit, and must be rejected."
    )


@hidden(KalmanBank)
def the_running_mean_and_its_limits(f: Function, rng: np.random.Generator) -> None:
    """The health must be the running mean of normalised innovations, rejected ones up to the gate, with hysteresis."""
    forget, R_z = 0.2, 0.5
    bank = f(UP, {"barometer.height": R_z}, forget=forget, limits=(1.5, 3.0), gate=16.0)
    surprises = np.array((1.0, 8.0, 60.0, 2.0, 3.0, 0.1, 0.1, 0.1, 0.1)) * rng.uniform(0.95, 1.05)
    memory, x, P, mean, reliable = bank.init(at(world="up")), np.zeros(3), np.eye(3), 1.0, True
    A, Q = (
        np.array(((1.0, DT, DT**2 / 2), (0.0, 1.0, DT), (0.0, 0.0, 0.9))),
        DT * np.diag((0.1, 1.0, 1.0)),
    )
    for k, nis in enumerate(surprises, 1):
        x, P = A @ x, A @ P @ A.T + Q
        S = P[0, 0] + R_z
        z = x[0] + np.sqrt(nis * S)
        memory, last = bank.step(memory, {"barometer": Height(k * DT, z)}, told(), DT)
        mean += forget * (min(nis, 16.0) - mean)
        reliable = mean < (3.0 if reliable else 1.5)
        if nis < 16.0:
            K = P[:, 0] / S
            x, P = x + K * (z - x[0]), P - np.outer(K, P[0])
        expect_close(last["up"].nis, mean, "The mean is another one.", atol=ALIKE)
        expect(last["up"].reliable == reliable, "Reliable at the wrong times.")
        expect_close(last["up"].x[2], x, atol=ALIKE)


@hidden(KalmanBank)
def nothing_heard_nothing_held(f: Function, rng: np.random.Generator) -> None:
    """A reading counts in the step in which it arrives, and in no other; between readings a member only predicts."""
    bank = f(AROUND, NOISE, p=(0.8, 0.7, 0.9))
    r, v, a = rng.normal(size=(3, 3))
    memory = bank.init(at(r=r, v=v, world="g"))
    seen = {
        "gnss": Fix(DT, r, v),
        "slam": Pose(DT, r, so3.about_z(0.3)),
        "imu": Imu(DT, ZERO, ZERO),
    }
    memory, before = bank.step(memory, seen, told(a), DT)
    memory, after = bank.step(memory, {}, told(a), 2 * DT)
    left = np.array((0.8, 0.8, 0.7)) ** 2
    for name in AROUND:
        x, P = before[name].x, before[name].P
        want = (
            x[:, 0] + 2 * DT * x[:, 1] + 2 * DT**2 * x[:, 2],
            x[:, 1] + 2 * DT * x[:, 2],
            left * x[:, 2] + (1 - left) * a,
        )
        expect_close(after[name].x, np.column_stack(want), atol=ALIKE)
        A = np.array(((1.0, 2 * DT, 2 * DT**2), (0.0, 1.0, 2 * DT), (0.0, 0.0, 0.64)))
        expect_close(
            after[name].P[0], A @ P[0] @ A.T + 2 * DT * np.diag((0.1, 1.0, 1.0)), atol=ALIKE
        )
        h = before[name].h
        expect_close(after[name].h, (h[0] + 2 * DT * h[1], 0.81 * h[1]), atol=ALIKE)
        expect_close(after[name].nis, before[name].nis)


@hidden(KalmanBank)
def who_is_known_at_the_start(f: Function, rng: np.random.Generator) -> None:
    """At the start the member whose world it is must be reliable; the others once they have heard all sources."""
    start = at(r=draw.vector(rng), v=draw.vector(rng), R=so3.about_z(draw.angle(rng)))
    bank = f(AROUND, NOISE, start=(0.5, 0.4, 0.3, 0.2, 0.1))
    _, last = run(bank, start._replace(world="s"), [{}])
    expect((last["g"].reliable, last["s"].reliable) == (False, True), "Reliable are others.")
    for x in last.values():
        near(x, start.r + DT * start.v)
    half = {"slam": Pose(DT, start.r, start.R), "gnss": Fix(DT, start.r, start.v, std=99.0)}
    memory, last = run(bank, start, [half])
    expect((last["g"].reliable, last["s"].reliable) == (False, True), "Reliable are others.")
    _, last = bank.step(memory, {"gnss": Fix(2 * DT, start.r, start.v)}, told(), DT)
    expect((last["g"].reliable, last["s"].reliable) == (True, True), "Both have heard all.")
    _, again = run(bank, start, [half, {"gnss": Fix(2 * DT, start.r, start.v)}])
    for name, x in last.items():
        same(x, again[name])


def near(x: Hypothesis, r: Any) -> None:
    """Fail the check unless a hypothesis is there, and as sure of it as `start` says after one step."""
    expect_close(x.x[:, 0], r, atol=ALIKE)
    P = 0.25 + DT**2 * 0.16 + DT**4 / 4 * 0.09 + DT * 0.1
    expect_close(x.P[:, 0, 0], (P, P, P), atol=ALIKE)
