"""The public checks of lab 06, continued: what its two parts promise in flight."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.expect import of_shapes
from uavlab.exercises.spec import Function, expect, expect_close
from uavlab.gains import MpcGains
from uavlab.limits import AxisLimits, ForceLimits, Limits
from uavlab.types import GRAVITY, Array, Command, Estimate, Reference, Trajectory, Vec3

G = np.array((0.0, 0.0, GRAVITY))
STILL = np.zeros(3)

# A controller in flight -------------------------------------------------------------------------------


class Flight(NamedTuple):
    """What a controller did with a point that turns as it is told, tick by tick (K,)."""

    r: Array  # (K, 3) [m]
    v: Array  # (K, 3) [m/s]
    a: Array  # (K, 3) [m/s²]
    omega: Array  # (K, 3) commanded [rad/s]
    memory: Any


def commanded(got: Any) -> Command:
    """`got` as plain numbers; fail the check unless it is a command."""
    f_d, omega_d, a_d = of_shapes(got, (), (3,), (3,))
    return Command(float(f_d), omega_d, a_d)


def at_rest(r: Vec3, heading: float = 0.0) -> Estimate:
    """Level, still, at a place [m] with a heading [rad]."""
    return Estimate(r, STILL, STILL, so3.about_z(heading), STILL)


def stand(r: Vec3, heading: float = 0.0) -> Reference:
    """To be at a place [m] with a heading [rad]."""
    return Reference(r, STILL, STILL, STILL, heading, 0.0)


def fly(
    part: Any, start: Estimate, wanted: Callable[[float], Reference], mass: float, dt: float, steps: int,
    push: Vec3 = STILL,
) -> Flight:  # fmt: skip
    """Fly with exact estimates: rates come at once, thrust a little later, and `push` [N] acts on all of it."""
    memory, x, f, log = part.init(start, None), start, mass * GRAVITY, []
    for k in range(steps):
        memory, got = part.step(memory, x, wanted(k * dt), dt)
        u = commanded(got)
        f += (u.f_d - f) * (1.0 - np.exp(-dt / 0.05))
        a = (f * x.R[:, 2] + push) / mass - G
        log.append((x.r, x.v, a, u.omega_d))
        r, v = x.r + x.v * dt + a * (dt * dt / 2), x.v + a * dt
        x = Estimate(r, v, a, x.R @ so3.exp(u.omega_d * dt), u.omega_d)
    r, v, a, omega = (np.array(y) for y in zip(*log, strict=True))
    return Flight(r, v, a, omega, memory)


def lean(got: Any, k_R: float) -> tuple[float, Array]:
    """What a level aircraft was told: thrust [N]; and x and y of its force, as shares of the size of the force."""
    u = commanded(got)
    return u.f_d, np.array((u.omega_d[1], -u.omega_d[0])) / k_R


def hovers_where_it_is_wanted(f: Function, rng: np.random.Generator) -> None:
    """At rest where it is wanted, it must carry its weight, and turn only to where its nose is wanted."""
    mass, r, off = float(rng.uniform(1.0, 5.0)), draw.vector(rng, 5.0), float(rng.uniform(0.1, 0.4))
    part, x = f(mass), at_rest(r, 0.3)
    _, got = part.step(part.init(x, None), x, stand(r, 0.3 + off), 0.01)
    u = commanded(got)
    expect_close(u.f_d, mass * GRAVITY, "It does not carry its weight.", atol=1e-3)
    expect_close(u.omega_d[:2], (0.0, 0.0), "It tilts.", atol=1e-3)
    expect_close(u.omega_d[2], 5.0 * np.sin(off), "It turns at another rate.", atol=1e-2)
    expect_close(u.a_d, STILL, "It believes that it accelerates.", atol=1e-3)
    lifted = stand(r, 0.3)._replace(a=np.array((0.0, 0.0, 1.0)))
    _, got = part.step(part.init(x, None), x, lifted, 0.01)
    expect_close(
        commanded(got).f_d, mass * (GRAVITY + 1.0), "The feed-forward is missing.", atol=1e-2
    )


def takes_over_unnoticed(f: Function, rng: np.random.Generator) -> None:
    """The first command must be the one before."""
    mass = float(rng.uniform(1.0, 5.0))
    last = Command(
        mass * float(rng.uniform(8.0, 11.0)), 0.1 * rng.normal(size=3), 0.2 * rng.normal(size=3)
    )
    part, x = f(mass), at_rest(draw.vector(rng, 3.0))
    _, got = part.step(part.init(x, last), x, stand(x.r + rng.normal(size=3)), 0.01)
    u = commanded(got)
    for now, before in zip(u, last, strict=True):
        expect_close(now, before, "The aircraft feels who flies it.", atol=1e-6)


BRISK = MpcGains((15.0, 15.0, 5.0), k_iw=0.1, k_ib=0.1, k_m=0.1)


def goes_to_a_point(f: Function, rng: np.random.Generator) -> None:
    """A few metres from where it is wanted, it must get there, and never be faster than its limit."""
    mass, turn = float(rng.uniform(2.0, 5.0)), draw.angle(rng)
    way = np.array((2.0 * np.cos(turn), 2.0 * np.sin(turn), rng.uniform(-0.5, 0.5)))
    start, limits = at_rest(draw.vector(rng, 5.0)), ForceLimits(AxisLimits(0.8, 2.0, 5.0, np.inf))
    goal = stand(start.r + way)
    part = f(mass, limits, gains=BRISK)
    flight = fly(part, start, lambda _t: goal, mass, 0.05, 100)
    expect(np.abs(flight.v[:, :2]).max() < 0.8 * 1.15, "It is too fast.")
    expect(np.linalg.norm(flight.r[-1] - goal.r) < 0.2, "It is elsewhere.")


# A tracker by itself ----------------------------------------------------------------------------------


class Course(NamedTuple):
    """What a tracker wanted, tick by tick (K,)."""

    r: Array  # (K, 3) [m]
    v: Array  # (K, 3) [m/s]
    a: Array  # (K, 3) [m/s²]
    j: Array  # (K, 3) [m/s³]
    heading: Array  # (K,) [rad]
    rate: Array  # (K,) [rad/s]
    memory: Any


def wanted(got: Any) -> Reference:
    """`got` as plain numbers; fail the check unless it is a reference."""
    r, v, a, j, heading, rate = of_shapes(got, (3,), (3,), (3,), (3,), (), ())
    return Reference(r, v, a, j, float(heading), float(rate))


def track(
    part: Any, memory: Any, goal: Reference | Trajectory | None, dt: float, steps: int,
    estimate: Estimate | None = None,
) -> Course:  # fmt: skip
    """Give a goal once, and ask for so many references."""
    log = []
    for k in range(steps):
        x = at_rest(STILL) if estimate is None else estimate
        memory, got = part.step(memory, x, goal if k == 0 else None, dt)
        log.append(wanted(got))
    r, v, a, j, heading, rate = (np.array(y) for y in zip(*log, strict=True))
    return Course(r, v, a, j, heading, rate, memory)


def between(rng: np.random.Generator) -> Limits:
    """Limits of a tracker, of which no two axes have the same."""
    v, a = rng.uniform(1.5, 2.5), rng.uniform(1.2, 2.0)
    up = AxisLimits(rng.uniform(1.0, 1.4), rng.uniform(0.9, 1.3), 20.0, 20.0)
    down = AxisLimits(rng.uniform(0.5, 0.7), rng.uniform(0.5, 0.7), 20.0, 20.0)
    turn = AxisLimits(rng.uniform(0.8, 1.2), rng.uniform(1.0, 1.5), 10.0, 10.0)
    return Limits(AxisLimits(v, a, 20.0, 30.0), up, down, turn, (60.0, 60.0, 10.0), 1.0, "")


def expect_within(course: Course, limits: Limits, dt: float, share: float = 1.03) -> None:
    """Fail the check unless a course keeps its limits."""
    flat, up, down = limits.horizontal, limits.up, limits.down
    for k, name in enumerate(("faster", "more accelerated", "more jerked")):
        x = course[1 + k]
        least, most = (-flat[k], -flat[k], -down[k]), (flat[k], flat[k], up[k])
        fits = (x <= share * np.array(most) + 1e-6) & (x >= share * np.array(least) - 1e-6)
        expect(fits.all(), f"It is {name} than it may be.")
    snap, most = np.diff(course.j, axis=0) / dt, np.array((flat.s, flat.s, min(up.s, down.s)))
    expect((np.abs(snap) <= share * most + 1e-6).all(), "It changes its jerk too suddenly.")


def one_moves_the_other(f: Function, rng: np.random.Generator) -> None:
    """Position must change by velocity, velocity by acceleration, acceleration by jerk."""
    limits, dt = between(rng), 0.02
    part, goal = f(limits), stand(3.0 * draw.direction(rng))
    x = track(part, part.init(at_rest(STILL), None), goal, dt, 60)
    moved = x.r[:-1] + x.v[:-1] * dt + x.a[:-1] * (dt**2 / 2)
    expect(np.abs(x.r[1:] - moved).max() < 1e-4, "The position goes its own way.")
    moved = x.v[:-1] + x.a[:-1] * dt + x.j[:-1] * (dt**2 / 2)
    expect(np.abs(x.v[1:] - moved).max() < 3e-4, "The velocity goes its own way.")
    expect(
        np.abs(x.a[1:] - x.a[:-1] - x.j[:-1] * dt).max() < 0.01,
        "The acceleration goes its own way.",
    )
    expect(np.linalg.norm(x.r[-1]) > 0.2, "It does not go anywhere.")


def continues_what_was_wanted(f: Function, rng: np.random.Generator) -> None:
    """The first reference must be the last one, and without a last one the estimate."""
    r, v, a, j = (s * rng.normal(size=3) for s in (3.0, 0.3, 0.2, 0.2))
    last = Reference(r, v, a, j, draw.angle(rng), 0.1)
    part, x = (
        f(between(rng)),
        at_rest(draw.vector(rng, 3.0), 0.4)._replace(v=0.3 * rng.normal(size=3)),
    )
    for before, want in ((last, last), (None, Reference(x.r, x.v, STILL, STILL, 0.4, 0.0))):
        _, got = part.step(part.init(x, before), x, None, 0.01)
        for one, other in zip(wanted(got), want, strict=True):
            expect_close(one, other, "It begins elsewhere.", atol=1e-6)


def arrives_within_its_limits(f: Function, rng: np.random.Generator) -> None:
    """Some metres away it must arrive in due time, within its limits, and stay."""
    limits, dt = between(rng), 0.05
    way = rng.choice((-1.0, 1.0), size=3) * rng.uniform((2.0, 2.0, 1.0), (3.0, 3.0, 1.5))
    part = f(limits)
    x = track(part, part.init(at_rest(STILL), None), stand(way), dt, 120)
    expect_within(x, limits, dt)
    expect(np.linalg.norm(x.r[-1] - way) < 0.05, "It is elsewhere.")
    expect(np.linalg.norm(x.v[-1]) < 0.05, "It does not stay.")
