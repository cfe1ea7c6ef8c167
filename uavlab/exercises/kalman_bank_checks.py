"""The public checks of lab 03: what the laws of filters, banks and worlds promise. The exercises are beside it."""

from __future__ import annotations

import numpy as np

from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.expect import expect_name, of_shapes
from uavlab.exercises.spec import Function, expect, expect_close
from uavlab.types import Command, Estimate, Fix, Height, Pose, Shift


def a_throw(f: Function, rng: np.random.Generator) -> None:
    """With p = 1 and no input the acceleration stays, and the axis must fly a parabola."""
    for dt in rng.uniform(0.005, 0.05, size=2):
        A, _ = of_shapes(f(float(dt), 1.0), (3, 3), (3, 1))
        r, v, a = start = rng.normal(size=3)
        T = 20 * dt
        want = (r + v * T + 0.5 * a * T**2, v + a * T, a)
        expect_close(np.linalg.matrix_power(A, 20) @ start, want)


def towards_the_input(f: Function, rng: np.random.Generator) -> None:
    """Held still, the input must become the acceleration, and after each step the share p of the gap is left."""
    dt, p, u = 0.01, float(rng.uniform(0.6, 0.95)), float(rng.uniform(1.0, 3.0))
    A, B = of_shapes(f(dt, p), (3, 3), (3, 1))
    x = rng.normal(size=3)
    for _ in range(5):
        new = A @ x + B[:, 0] * u
        expect_close(u - new[2], p * (u - x[2]))
        expect_close(new[1] - x[1], dt * x[2])
        x = new


def a_steady_turn(f: Function, rng: np.random.Generator) -> None:
    """With p = 1 and no input the rate stays; with another p the share p of it is left, and the input fills it up."""
    for p in (1.0, float(rng.uniform(0.6, 0.95))):
        dt = float(rng.uniform(0.005, 0.05))
        A, B = of_shapes(f(dt, p), (2, 2), (2, 1))
        h, u = rng.normal(size=2), float(rng.uniform(1.0, 3.0))
        expect_close(A @ h, (h[0] + dt * h[1], p * h[1]))
        expect_close(A @ h + B[:, 0] * u, (h[0] + dt * h[1], u + p * (h[1] - u)))


def a_cloud_of_points(f: Function, rng: np.random.Generator) -> None:
    """Points with mean x and covariance P, each moved by the model, must have the mean and covariance that you say."""
    for n, k in ((3, 1), (2, 2)):
        x, P, u, A, B, Q = draw.prediction(rng, n, k)
        got, cov = of_shapes(f(x, P, u, A, B, Q), (n,), (n, n))
        arms = np.sqrt(n) * np.linalg.cholesky(P)
        cloud = np.array([A @ (x + s * arm) + B @ u for arm in arms.T for s in (1.0, -1.0)])
        expect_close(got, cloud.mean(axis=0), "The mean is elsewhere.")
        expect_close(cov - Q, np.cov(cloud.T, bias=True), "The covariance is another one.")


def two_opinions_of_one_number(f: Function, rng: np.random.Generator) -> None:
    """A number that is believed and measured must become the mean of both, weighted by one over their variances."""
    for _ in range(3):
        (x, z), (P, R_z) = rng.normal(size=2), rng.uniform(0.2, 2.0, size=2)
        args = (np.array((x,)), np.array(((P,),)), np.array((z,)), np.eye(1), np.array(((R_z,),)))
        got, cov, nis = of_shapes(f(*args), (1,), (1, 1), ())
        weight = 1.0 / P + 1.0 / R_z
        expect_close(got, ((x / P + z / R_z) / weight,), "The state is another mean.")
        expect_close(cov, ((1.0 / weight,),), "The variance is another one.")
        expect_close(nis, (z - x) ** 2 / (P + R_z), "The innovation is normalised otherwise.")


def each_in_its_own_world(f: Function, rng: np.random.Generator) -> None:
    """Members must start where their instruments say that they are, and not before they hear of them."""
    bank = f({"slam": ("slam.position", "slam.height"), "gnss": ("gnss.position", "gnss.height")}, {
        "slam.position": 0.01, "slam.height": 0.01, "gnss.position": 0.1, "gnss.height": 0.1,
    })  # fmt: skip
    r_slam, r_gnss, still = draw.vector(rng, 5.0), draw.vector(rng, 5.0), np.zeros(3)
    start = Estimate(draw.vector(rng), still, still, np.eye(3), still)
    command, seen = Command(0.0, still, still), {"slam": Pose(0.01, r_slam, np.eye(3))}
    memory, told = bank.step(bank.init(start), seen, command, 0.01)
    expect_close(told["slam"].x[:, 0], r_slam, "The member of the camera is elsewhere.")
    expect_close(told["gnss"].x[:, 0], start.r, "The other one has heard nothing yet.")
    expect(told["slam"].reliable, "The member of the camera has all that it needs.")
    expect(not told["gnss"].reliable, "The other one cannot be flown on yet.")
    seen = {"gnss": Fix(0.02, r_gnss, still)}
    memory, told = bank.step(memory, seen, command, 0.01)
    expect_close(told["gnss"].x[:, 0], r_gnss, "The member of the satellites is elsewhere.")
    expect_close(told["slam"].x[:, 0], r_slam, "The satellites have moved the camera's member.")


def one_member_is_one_filter(f: Function, rng: np.random.Generator) -> None:
    """A bank of one that hears heights must do what the equations of one filter do."""
    R_z, a_d, still = float(rng.uniform(0.2, 0.4)), float(rng.uniform(1.0, 2.0)), np.zeros(3)
    members, noise = {"up": ("barometer.height",)}, {"barometer.height": R_z}
    bank = f(members, noise, q_z=(0.2, 0.5, 2.0), gate=1e3)
    start = Estimate(draw.vector(rng), still, still, np.eye(3), still, world="up")
    memory, command = bank.init(start), Command(0.0, still, np.array((0.0, 0.0, a_d)))
    x, P = np.array((start.r[2], 0.0, 0.0)), np.eye(3)
    A = np.array(((1.0, 0.01, 5e-5), (0.0, 1.0, 0.01), (0.0, 0.0, 0.9)))
    for k in range(1, 9):
        z = float(rng.normal())
        memory, told = bank.step(memory, {"barometer": Height(0.01 * k, z)}, command, 0.01)
        x, P = A @ x + (0.0, 0.0, 0.1 * a_d), A @ P @ A.T + np.diag((2e-3, 5e-3, 2e-2))
        K = P[:, 0] / (P[0, 0] + R_z)
        x, P = x + K * (z - x[0]), P - np.outer(K, P[0])
        expect_close(told["up"].x[2], x, "Its height, climb or acceleration is another one.")
        expect_close(told["up"].P[2], P, "Its covariance is another one.")


def a_source_that_is_not_there(f: Function, rng: np.random.Generator) -> None:
    """A source that nobody knows must raise a LookupError when the bank is made."""
    f({"good": ("gnss.position",)}, {"gnss.position": 1.0})
    for members in ({"bad": ("gps.position",)}, {"bad": ("flow.height",)}):
        try:
            f(members, {"gps.position": 1.0, "flow.height": 1.0})
        except LookupError:
            continue
        expect(False, f"{members} was taken.")


def requested_or_left(f: Function, rng: np.random.Generator) -> None:
    """A reliable request is obeyed, an unreliable one is not; the unreliable is left, the nearly as good is kept."""
    names = [str(x) for x in rng.permutation(["gnss", "rtk", "slam", "flow"])]
    spreads = np.cumprod(rng.uniform(2.5, 4.0, size=4))
    told = {
        name: draw.hypothesis(rng, spread=float(s), reliable=i != 1)
        for i, (name, s) in enumerate(zip(names, spreads, strict=True))
    }
    best, sick, _, last = names
    expect_name(f(told, best, last), last, "The request was not obeyed.")
    expect_name(f(told, best, sick), best, "It flies on a hypothesis that is not reliable.")
    expect_name(f(told, sick, ""), best, "The best of the others should fly.")
    expect_name(f(told, last, ""), best, "The best one should fly.")
    told[sick] = draw.hypothesis(rng, spread=float(0.7 * spreads[0]))
    expect_name(f(told, best, ""), best, "One that is hardly better should not take over.")


def one_aircraft(f: Function, rng: np.random.Generator) -> None:
    """The shift must take position and heading of the first to those of the second."""
    for _ in range(3):
        a, b = draw.hypothesis(rng), draw.hypothesis(rng)
        r, turn = of_shapes(f(a, b), (3,), ())
        c, s = np.cos(turn), np.sin(turn)
        x, y, z = a.x[:, 0]
        expect_close((c * x - s * y + r[0], s * x + c * y + r[1], z + r[2]), b.x[:, 0])
        nose = np.exp(1j * (a.h[0] + turn - b.h[0]))
        expect_close((nose.real, nose.imag), (1.0, 0.0), "The noses point elsewhere.")


def as_the_aircraft_sees_it(f: Function, rng: np.random.Generator) -> None:
    """Ahead, to the left, above: seen from the aircraft, the reference must be where it was, and move as it did."""
    for _ in range(2):
        old, r, eta = draw.reference(rng), draw.vector(rng, 5.0), draw.angle(rng)
        shift = Shift(draw.vector(rng, 3.0), draw.angle(rng))
        got = of_shapes(f(old, shift), (3,), (3,), (3,), (3,), (), ())
        r_new = so3.about_z(shift.heading) @ r + shift.r
        before, after = so3.about_z(-eta), so3.about_z(-eta - shift.heading)
        expect_close(after @ (got[0] - r_new), before @ (old.r - r), "It is elsewhere.")
        for was, now in zip(old[1:4], got[1:4], strict=True):
            expect_close(after @ now, before @ was, "It moves another way.")
        expect_close(got[4] - shift.heading, old.heading, "It points elsewhere.")
        expect_close(got[5], old.heading_rate, "It turns at another rate.")
