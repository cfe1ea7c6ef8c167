"""Lab 06, hidden checks, continued: the controller, from what it tells an aircraft that is held, and in flight."""

from __future__ import annotations

from typing import Any

import numpy as np

from grader.hidden.mpc_course import *  # noqa: F403  the tracker
from grader.material import hidden
from uavlab import frames, so3
from uavlab.exercises import draw
from uavlab.exercises.mpc import MpcController
from uavlab.exercises.mpc_checks import flown
from uavlab.exercises.mpc_parts_checks import BRISK, STILL, at_rest, commanded, fly, lean, stand
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.gains import MpcGains
from uavlab.limits import AxisLimits, ForceLimits
from uavlab.types import GRAVITY, Array, Command, Estimate, Reference, Shift
from uavlab.weights import HORIZONTAL, VERTICAL, ForceWeights

CANARY = "canary-dae29abf2f99be6782ca7925"

DT = 0.02
QUIET = MpcGains(k_iw=0.0, k_ib=0.0, k_m=0.0)


def held(part: Any, x: Estimate, wanted: Reference, steps: int) -> tuple[Any, Command]:
    """The last command of some steps in which an aircraft is held, and the memory after it."""
    memory, got = part.init(x, None), None
    for _ in range(steps):
        memory, got = part.step(memory, x, wanted, DT)
    return memory, commanded(got)


def counted(part: Any, memory: Any) -> int:
    """How many failures there were."""
    return int(numbers(part.failures(memory), ()))


# Held fast: what it learns ----------------------------------------------------------------------------


@hidden(MpcController, weight=2.0)
def learns_what_pushes_it_away(f: Function, rng: np.random.Generator) -> None:
    """A position error that stays must add up to a force against it, to a limit, and a_d is free of it."""
    mass, e, n = float(rng.uniform(2.0, 4.0)), np.zeros(3), 20
    e[:2] = rng.uniform(0.1, 0.3, size=2) * rng.choice((-1.0, 1.0), size=2)
    eta = draw.angle(rng)
    x, goal = at_rest(e, eta), stand(STILL, eta)
    _, before = held(f(mass, gains=QUIET), x, goal, n)
    for gains in (QUIET._replace(k_iw=2.0), QUIET._replace(k_ib=3.0)):
        _, u = held(f(mass, gains=gains), x, goal, n)
        d = (gains.k_iw + gains.k_ib) * e[:2] * n * DT
        off = 0.15 * np.linalg.norm(d) / mass
        expect(np.abs(u.a_d[:2] - d / mass).max() < off, "a_d is not free of disturbances.")
        push = (_force(u, eta) - _force(before, eta)) * mass * GRAVITY
        expect(np.abs(push + d).max() < 0.2 * np.linalg.norm(d), "It does not push against it.")
    gains = QUIET._replace(k_iw=500.0, d_max=1.5)
    _, u = held(f(mass, gains=gains), x, goal, n)
    expect_close(u.a_d[:2] * mass, 1.5 * np.sign(e[:2]), "It has another limit.", atol=0.02)


def _force(u: Command, heading: float) -> Any:
    """Direction of the force, x and y, world, that a level aircraft was told to lean to."""
    _, leaning = lean(u, 5.0)
    return so3.about_z(heading)[:2, :2] @ leaning


@hidden(MpcController)
def turns_what_turns_with_it(f: Function, rng: np.random.Generator) -> None:
    """After a turn, what stays in the world must be as before, and what turns with the nose must have turned."""
    mass, way, n = float(rng.uniform(2.0, 4.0)), draw.angle(rng), 15
    e = 0.3 * np.array((np.cos(way), np.sin(way), 0.0))
    eta, turn = draw.angle(rng), float(rng.uniform(1.0, 2.5))
    for gains, by in ((QUIET._replace(k_iw=4.0), 0.0), (QUIET._replace(k_ib=4.0), turn)):
        part = f(mass, gains=gains)
        memory, u = held(part, at_rest(e, eta), stand(STILL, eta), n)
        expect(np.linalg.norm(u.a_d[:2]) > 0.02, "It has learned nothing.")
        _, got = part.step(memory, at_rest(STILL, eta + turn), stand(STILL, eta + turn), DT)
        want = so3.about_z(by)[:2, :2] @ u.a_d[:2]
        expect_close(commanded(got).a_d[:2], want, "It points elsewhere.", atol=0.02)


@hidden(MpcController)
def weighs_itself(f: Function, rng: np.random.Generator) -> None:
    """Who hangs below where it is wanted must be heavier than it was told, above lighter, within a limit."""
    mass, n = float(rng.uniform(2.0, 4.0)), 20
    for e_z in (-0.3, 0.3):
        x, goal = at_rest(np.array((0.0, 0.0, e_z))), stand(STILL)
        _, before = held(f(mass, gains=QUIET), x, goal, n)
        _, u = held(f(mass, gains=QUIET._replace(k_m=1.5)), x, goal, n)
        gain = 1.5 * e_z * n * DT
        ratio = u.f_d / before.f_d
        expect(abs(mass * (ratio - 1.0) + gain) < 0.2 * abs(gain), "It believes another mass.")
        _, u = held(f(mass, gains=QUIET._replace(k_m=90.0, m_max=0.7)), x, goal, n)
        want = mass - 0.7 * np.sign(e_z)
        expect(abs(mass * u.f_d / before.f_d - want) < 0.02, "The mass has another limit.")


@hidden(MpcController)
def learns_at_rest_only(f: Function, rng: np.random.Generator) -> None:
    """Above 0.3 m/s a position error is a way to go, and must teach nothing; below, it must."""
    mass, e, turn = 2.0, np.array((0.2, -0.3, 0.0)), draw.angle(rng)
    part = f(mass, gains=QUIET._replace(k_iw=4.0))
    for speed, learns in ((0.2, True), (0.6, False)):
        v = speed * np.array((np.cos(turn), np.sin(turn), 0.0))
        _, u = held(part, at_rest(e)._replace(v=v), stand(STILL), 15)
        expect((np.linalg.norm(u.a_d[:2]) > 0.1) == learns, "It learns at another speed.")


# Held fast: what it does with a reference -------------------------------------------------------------


@hidden(MpcController)
def pushed_ahead_by_the_reference(f: Function, rng: np.random.Generator) -> None:
    """An acceleration of the reference must be added to that of the plan, along each axis."""
    mass, r, a = float(rng.uniform(2.0, 4.0)), draw.vector(rng, 3.0), 0.4 * rng.normal(size=3)
    part, goal = f(mass, gains=QUIET), stand(r + 0.3 * rng.normal(size=3))
    _, before = held(part, at_rest(r), goal, 3)
    _, u = held(part, at_rest(r), goal._replace(a=a), 3)
    expect_close(u.f_d - before.f_d, mass * a[2], "Its thrust has no feed-forward.", atol=0.02)
    first, second = (lean(x, 5.0)[1] * _size(x) for x in (before, u))
    expect_close(second - first, mass * a[:2], "It leans without feed-forward.", atol=0.1)


def _size(u: Command) -> float:
    """Size of the force of a level aircraft, of which it was told the upright part and the lean."""
    sine = np.linalg.norm(lean(u, 5.0)[1])
    return u.f_d / float(np.sqrt(1.0 - sine * sine))


@hidden(MpcController)
def keeps_to_what_it_may(f: Function, rng: np.random.Generator) -> None:
    """Force and rates must stay within the limits of the gains: tilt and rates, each axis by itself."""
    mass, far = float(rng.uniform(2.0, 4.0)), 30.0 * draw.direction(rng)
    far[2] = 0.0
    part = f(mass, gains=QUIET._replace(tilt_max=0.08))
    goal = stand(far)._replace(a=6.0 * draw.direction(rng) * (1.0, 1.0, 0.0))
    _, u = held(part, at_rest(STILL), goal, 10)
    sine = float(np.linalg.norm(lean(u, 5.0)[1]))
    expect(0.05 < sine < np.sin(0.08) + 1e-3, "It leans too far, or not at all.")
    part = f(mass, gains=QUIET._replace(rate_max=(0.3, 0.2, 0.15)))
    _, u = held(part, at_rest(STILL, 1.0), goal, 10)
    expect((np.abs(u.omega_d) <= np.array((0.3, 0.2, 0.15)) + 1e-9).all(), "It turns too fast.")
    expect(abs(u.omega_d[2]) > 0.14, "It turns too slowly.")


@hidden(MpcController)
def turns_with_the_reference(f: Function, rng: np.random.Generator) -> None:
    """Level, the yaw rate must be that of the reference, and what takes the nose to where it is wanted."""
    mass, eta, off = float(rng.uniform(2.0, 4.0)), draw.angle(rng), float(rng.uniform(-0.8, 0.8))
    rate = draw.pace(rng)
    goal = stand(STILL, frames.wrap(eta + off))._replace(heading_rate=rate)
    _, u = held(f(mass, gains=QUIET._replace(k_R=(5.0, 5.0, 3.0))), at_rest(STILL, eta), goal, 2)
    expect_close(u.omega_d, (0.0, 0.0, rate + 3.0 * np.sin(off)), atol=1e-2)


@hidden(MpcController)
def along_the_axis_that_it_has(f: Function, rng: np.random.Generator) -> None:
    """Tilted, its thrust must be the part of the force along its own axis, and a_d what that thrust makes of it."""
    mass, r = float(rng.uniform(2.0, 4.0)), draw.vector(rng, 3.0)
    R = draw.aimed(rng, 0.5, 0.8)
    x = Estimate(r, STILL, STILL, R, STILL)
    _, u = held(f(mass, gains=QUIET), x, stand(r, frames.heading(R)), 2)
    expect_close(u.f_d, mass * GRAVITY * R[2, 2], "Its thrust is another one.", atol=0.02)
    want = GRAVITY * (R[2, 2] * R[:, 2] - np.eye(3)[2])
    expect_close(u.a_d, want, "It believes in another acceleration.", atol=0.02)
    expect(u.omega_d[:2] @ (R[2, 1], -R[2, 0]) < 0.0, "It tilts further.")


@hidden(MpcController)
def not_fooled_by_a_rough_estimate(f: Function, rng: np.random.Generator) -> None:
    """A velocity or an acceleration that cannot be true must not be answered: that of the reference is planned with."""
    mass, part = 2.0, f(2.0, gains=QUIET)
    for name, size in (("v", 8.0), ("a", 9.0)):
        for axis in range(3):
            rough = at_rest(STILL)
            push = np.zeros(3)
            push[axis] = size * rng.choice((-1.0, 1.0))
            _, u = held(part, rough._replace(**{name: push}), stand(STILL), 12)
            expect_close(u.f_d, mass * GRAVITY, "It answers vertically.", atol=0.1)
            expect_close(lean(u, 5.0)[1], (0.0, 0.0), "It leans.", atol=0.01)
    _, u = held(part, at_rest(STILL)._replace(v=np.array((1.5, 0.0, 0.0))), stand(STILL), 12)
    expect(lean(u, 5.0)[1][0] < -0.05, "It does not brake.")


@hidden(MpcController)
def survives_what_is_no_number(f: Function, rng: np.random.Generator) -> None:
    """Estimates that are not numbers must be flown through on the old plan, counted, and forgotten."""
    part, x = f(2.0, gains=QUIET), at_rest(draw.vector(rng, 2.0))
    turn = draw.angle(rng)
    goal = stand(x.r + 3.0 * np.array((np.cos(turn), np.sin(turn), 0.02)))
    memory, got = part.init(x, None), None
    for _ in range(25):
        memory, got = part.step(memory, x, goal, DT)
    expect(counted(part, memory) == 0, "Nothing has failed yet.")
    before, lost = commanded(got), x.r.copy()
    leaning = lean(before, 5.0)[1]
    expect(np.linalg.norm(leaning) > 0.1, "It does not set out.")
    lost[int(rng.integers(2))] = np.nan
    for k in range(3):
        memory, got = part.step(memory, x._replace(r=lost), goal, DT)
        u = commanded(got)
        expect(counted(part, memory) == k + 1, "It has lost count.")
        off = np.linalg.norm(lean(u, 5.0)[1] - leaning)
        expect(off < 0.05 * (k + 1), "It leaves its plan.")
        expect(abs(u.f_d - before.f_d) < 2.0, "The thrust jumps.")
    memory, got = part.step(memory, x, goal, DT)
    expect(counted(part, memory) == 3, "This one was good.")
    expect_close(commanded(got).f_d, before.f_d, "It does not recover.", atol=1.0)


@hidden(MpcController)
def the_plan_of_each_axis(f: Function, rng: np.random.Generator) -> None:
    """Where no limit binds, each axis must have the first input of its own best plan, as long as asked for."""
    mass, N, dt = 2.0, int(rng.integers(12, 30)), float(rng.uniform(0.04, 0.08))
    e, v = 0.06 * rng.uniform(0.5, 1.0, size=3), 0.05 * rng.normal(size=3)
    e[2], v[2] = rng.uniform(0.1, 0.2), rng.uniform(0.0, 0.1)  # further: there a lag counts
    side = rng.choice((-1.0, 1.0), size=3)
    e, v = e * side, v * side
    part = f(mass, N=N, dt=dt, gains=QUIET)
    _, u = held(part, at_rest(e)._replace(v=v), stand(STILL), 30)
    best = np.array([
        _first(
            np.array((e[i], v[i], 0.0)), N, dt, *((0.5, VERTICAL) if i == 2 else (0.0, HORIZONTAL))
        )
        for i in range(3)
    ])
    expect(
        abs(u.f_d / mass - GRAVITY - best[2]) < 0.02 + 0.05 * abs(best[2]), "Another vertical plan."
    )
    flat = lean(u, 5.0)[1] * _size(u) / mass
    expect(np.abs(flat - best[:2]).max() < 0.02 + 0.05 * np.abs(best[:2]).max(), "Another plan.")


def _first(x0: Array, N: int, dt: float, p: float, weights: ForceWeights) -> float:
    """The first input of the best plan to the origin, without limits."""
    root = np.sqrt(np.array([*[weights.Q] * (N - 1), weights.S]))
    M = [(flown(np.zeros(3), e, dt, p) * root).ravel() for e in np.eye(N)]
    free = (flown(x0, np.zeros(N), dt, p) * root).ravel()
    return float(np.linalg.lstsq(np.transpose(M), -free)[0][0])


# Worlds and flights -----------------------------------------------------------------------------------


@hidden(MpcController)
def the_same_in_another_world(f: Function, rng: np.random.Generator) -> None:
    """Told everything in another world, in the middle of a flight, it must go on as if nothing had happened."""
    quarter = 0.5 * np.pi * int(rng.integers(1, 4))
    shift = Shift(draw.vector(rng, 5.0), quarter)
    part = f(2.0, gains=QUIET._replace(k_iw=3.0, k_ib=2.0))
    x = at_rest(0.2 * draw.vector(rng), 0.3)._replace(v=0.1 * rng.normal(size=3))
    goal = stand(1.5 * draw.direction(rng), 0.5)
    last = Command(21.0, 0.3 * rng.normal(size=3), rng.normal(size=3))
    old = part.init(x, last)
    for _ in range(6):
        old, _ = part.step(old, x, goal, DT)
    new, there, moved = part.reframe(old, shift), frames.moved(x, shift), frames.moved(goal, shift)
    for _ in range(4):
        old, here = part.step(old, x, goal, DT)
        new, other = part.step(new, there, moved, DT)
        want, got = frames.moved(commanded(here), shift), commanded(other)
        expect(np.linalg.norm(want.a_d) > 0.05, "It has forgotten what it took over.")
        expect_close(got.f_d, want.f_d, "The thrust jumps.", atol=0.02)
        expect_close(got.omega_d, want.omega_d, "The rates jump.", atol=0.02)
        expect_close(got.a_d, want.a_d, "a_d jumps.", atol=0.02)


@hidden(MpcController)
def lets_go_of_the_last_command(f: Function, rng: np.random.Generator) -> None:
    """What the last command had of its own must fade smoothly, and be gone after some seconds."""
    part, x, goal = f(2.0, gains=QUIET), at_rest(STILL), stand(np.array((0.2, 0.1, 0.0)))
    last = Command(2.0 * GRAVITY + 4.0, 0.3 * rng.normal(size=3), STILL)
    memory, thrusts = part.init(x, last), []
    for _ in range(150):
        memory, got = part.step(memory, x, goal, DT)
        thrusts.append(commanded(got).f_d)
    expect_close(thrusts[0], last.f_d, "The first thrust is another one.", atol=1e-3)
    expect(abs(thrusts[-1] - 2.0 * GRAVITY) < 0.05, "It holds on to what it took over.")
    expect(abs(thrusts[5] - 2.0 * GRAVITY) > 1.0, "It lets go at once.")
    expect(np.abs(np.diff(thrusts)).max() < 0.4, "The thrust jumps.")


@hidden(MpcController, weight=2.0)
def within_its_limits_in_flight(f: Function, rng: np.random.Generator) -> None:
    """In flight, speed, acceleration and jerk must keep their limits, and be made use of."""
    v, a, j = rng.uniform((0.8, 1.0, 3.0), (1.2, 1.6, 5.0))
    limits, mass = ForceLimits(AxisLimits(v, a, j, np.inf)), float(rng.uniform(2.0, 5.0))
    way = np.array((4.0, rng.uniform(-3.0, 3.0), 0.3 * rng.normal()))
    way[:2] = way[:2][:: int(rng.choice((-1, 1)))]
    part, start = f(mass, limits, gains=BRISK), at_rest(draw.vector(rng, 3.0))
    goal = stand(start.r + way)
    flight = fly(part, start, lambda _t: goal, mass, DT, 140)
    fast = np.abs(flight.v[:, :2]).max()
    expect(fast < 1.12 * v, "It is too fast.")
    expect(fast > 0.9 * v, "It is too slow.")
    expect(np.abs(flight.a[:, :2]).max() < 1.3 * a, "It accelerates too much.")
    jerk = np.abs(np.diff(flight.a[:, :2], axis=0)).max() / DT
    expect(jerk < 1.4 * j, "It jerks.")
    expect(jerk > 0.5 * j, "It hesitates.")


@hidden(MpcController)
def against_a_wind(f: Function, rng: np.random.Generator) -> None:
    """A steady push must not keep it away, whichever integral answers it."""
    mass, push = 3.0, 1.5 * draw.direction(rng) * (1.0, 1.0, 0.0)
    gains = BRISK._replace(k_iw=2.0, k_ib=0.0)
    if rng.random() < 0.5:
        gains = BRISK._replace(k_iw=0.0, k_ib=2.0)
    start = at_rest(draw.vector(rng, 2.0), draw.angle(rng))
    goal = stand(start.r, frames.heading(start.R))
    flight = fly(f(mass, gains=gains), start, lambda _t: goal, mass, 0.04, 200, push=push)
    off = np.linalg.norm((flight.r - goal.r)[:, :2], axis=1)
    expect(off[-1] < 0.06, "It is blown away.")
