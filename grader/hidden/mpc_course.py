"""Lab 06, hidden checks, continued: the tracker, whose reference must be one that can be flown."""

from __future__ import annotations

import numpy as np

from grader.material import hidden
from uavlab import frames
from uavlab.exercises import draw
from uavlab.exercises.mpc import MpcTracker
from uavlab.exercises.mpc_parts_checks import (
    STILL,
    at_rest,
    between,
    expect_within,
    stand,
    track,
    wanted,
)
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.types import Array, Reference, Shift, Trajectory

CANARY = "canary-a420094935af73e18e0e7d38"


def begun(f: Function, rng: np.random.Generator) -> tuple:
    """A tracker that stands somewhere; its memory, its limits, and where it stands."""
    limits, r = between(rng), draw.vector(rng, 3.0)
    part = f(limits)
    return part, part.init(at_rest(r), None), limits, r


@hidden(MpcTracker, weight=2.0)
def up_and_down(f: Function, rng: np.random.Generator) -> None:
    """Climbing and sinking must each keep its own limits, at every tick, and make use of them."""
    part, memory, limits, r = begun(f, rng)
    dt = 0.05
    for sign, steps in ((1.0, 60), (-1.0, 75)):
        goal = r + np.array((0.0, 0.0, 3.0 * sign))
        x = track(part, memory, stand(goal), dt, steps)
        expect_within(x, limits, dt)
        most = limits.up.v if sign > 0.0 else limits.down.v
        expect((sign * x.v[:, 2]).max() > 0.9 * most, "It is slower than it may be.")
        memory = x.memory


@hidden(MpcTracker, weight=2.0)
def there_and_no_further(f: Function, rng: np.random.Generator) -> None:
    """It must be fast on a long way, within its limits at every tick, and not run past its goal."""
    part, memory, limits, r = begun(f, rng)
    dt, way = 0.05, np.array((5.0, -4.0, 1.0)) * rng.choice((-1.0, 1.0), size=3)
    way = way[[*rng.permutation(2).tolist(), 2]]
    x = track(part, memory, stand(r + way), dt, 160)
    expect_within(x, limits, dt)
    along = (x.r - r) * np.sign(way)
    expect((along <= np.abs(way) + 0.1).all(), "It runs past its goal.")
    expect((along >= -0.05).all(), "It sets out the wrong way.")
    expect(np.abs(x.v[:, :2]).max() > 0.85 * limits.horizontal.v, "It is slower than it may be.")
    expect(
        np.abs(x.a[:, :2]).max() > 0.7 * limits.horizontal.a, "It starts more gently than it may."
    )
    expect_close(x.r[-1], r + way, "It does not arrive.", atol=0.05)


@hidden(MpcTracker)
def blind_to_the_estimate(f: Function, rng: np.random.Generator) -> None:
    """Whatever the estimate says after the start, the reference must be the same."""
    part, memory, _, r = begun(f, rng)
    goal = stand(r + 2.0 * draw.direction(rng))
    x = track(part, memory, goal, 0.02, 25)
    lost = at_rest(draw.vector(rng, 20.0), 2.0)._replace(v=draw.vector(rng, 3.0), a=np.ones(3))
    y = track(part, memory, goal, 0.02, 25, lost)
    for one, other in zip(x[:6], y[:6], strict=True):
        expect_close(other, one, "It looks at the estimate.")
    expect(np.linalg.norm(x.r[-1] - x.r[0]) > 1e-3, "It does not move.")


def ramp(rng: np.random.Generator, r: Array, speed: float, T: float) -> Trajectory:
    """A way with a bend, told every half a second; its nose turns along it."""
    t = np.arange(0.0, T + 0.1, 0.5)
    turn, bend = draw.angle(rng), float(rng.uniform(-0.15, 0.15))
    directions = turn + bend * t
    steps = np.column_stack((np.cos(directions), np.sin(directions), 0.1 * np.ones(len(t))))
    places = r + np.vstack((np.zeros(3), np.cumsum(0.5 * speed * steps[:-1], axis=0)))
    return Trajectory(t, places, 0.2 * t)


@hidden(MpcTracker, weight=2.0)
def along_a_trajectory(f: Function, rng: np.random.Generator) -> None:
    """A trajectory must be followed in time, with its headings, within the limits, and held at its end."""
    part, memory, limits, r = begun(f, rng)
    dt, T = 0.04, 4.0
    way = ramp(rng, r, 0.7, T)
    x = track(part, memory, way, dt, 140)
    expect_within(x, limits, dt)
    t = dt * np.arange(140)
    where = np.column_stack([np.interp(t, way.t, way.r[:, i]) for i in range(3)])
    off = np.linalg.norm(x.r - where, axis=1)
    expect(off[t > 2.0].max() < 0.3, "It is late, or early, or elsewhere.")
    expect(off[-1] < 0.1, "It does not stay at the end.")
    nose = np.abs(x.heading - np.interp(t, way.t, way.heading))
    expect(nose[t > 2.0].max() < 0.2, "Its nose is elsewhere.")


@hidden(MpcTracker)
def with_a_goal_that_moves(f: Function, rng: np.random.Generator) -> None:
    """A goal that was given once, with a velocity, goes on with it: it must be caught, and kept."""
    part, memory, limits, r = begun(f, rng)
    dt, v = 0.05, np.append(0.6 * draw.direction(rng)[:2], 0.2)
    goal = stand(r + 0.5 * draw.direction(rng))._replace(v=v)
    x = track(part, memory, goal, dt, 120)
    expect_within(x, limits, dt)
    expect_close(x.r[-1], goal.r + v * (dt * 119), "It is left behind.", atol=0.1)
    expect_close(x.v[-1], v, "It is not as fast.", atol=0.05)


@hidden(MpcTracker)
def the_short_way_round(f: Function, rng: np.random.Generator) -> None:
    """The nose must turn the short way, across ±π too, within its limits, and be told within ±π."""
    limits, dt = between(rng), 0.06
    part, side = f(limits), float(rng.choice((-1.0, 1.0)))
    start, end = side * rng.uniform(1.6, 2.0), -side * rng.uniform(1.8, 2.2)
    memory = part.init(at_rest(STILL, start), None)
    x = track(part, memory, stand(STILL, end), dt, 100)
    expect((np.abs(x.heading) <= np.pi + 1e-6).all(), "It is told beyond ±π.")
    expect(abs(frames.wrap(float(x.heading[-1]) - end)) < 0.05, "It does not arrive.")
    whole = np.unwrap(np.append(start, x.heading))
    expect(abs(whole[-1] - whole[0]) < np.pi, "It goes the long way round.")
    turn = limits.heading
    expect(np.abs(x.rate).max() < 1.03 * turn.v, "It turns too fast.")
    spin = np.diff(x.rate) / dt
    expect(np.abs(spin).max() < 1.05 * turn.a, "It turns too suddenly.")
    expect_close(np.diff(whole[1:]) / dt, 0.5 * (x.rate[1:] + x.rate[:-1]), atol=0.02)
    expect(np.abs(np.diff(spin)).max() / dt < 1.1 * turn.j, "Its turn jerks.")


@hidden(MpcTracker)
def the_same_course_in_another_world(f: Function, rng: np.random.Generator) -> None:
    """Told in another world, in the middle of its way, it must go on as if nothing had happened; goals move along."""
    shift = Shift(draw.vector(rng, 5.0), 0.5 * np.pi * int(rng.integers(1, 4)))
    for moving in (False, True):
        part, memory, _, r = begun(f, rng)
        goal = ramp(rng, r, 0.7, 3.0) if moving else stand(r + 2.0 * draw.direction(rng), 0.8)
        old = track(part, memory, goal, 0.04, 15).memory
        new = part.reframe(old, shift)
        here, there = track(part, old, None, 0.04, 20), track(part, new, None, 0.04, 20)
        for k in (0, 1, 10, 19):
            heading = float(here.heading[k]), float(here.rate[k])
            want = frames.moved(
                Reference(here.r[k], here.v[k], here.a[k], here.j[k], *heading), shift
            )
            expect_close(there.r[k], want.r, "It is elsewhere.", atol=2e-3)
            expect_close(there.v[k], want.v, "It is faster or slower.", atol=1e-2)
            expect_close(there.a[k], want.a, "It accelerates otherwise.", atol=5e-2)
            off = frames.wrap(float(there.heading[k]) - want.heading)
            expect(abs(off) < 1e-2, "It points elsewhere.")


@hidden(MpcTracker)
def goals_that_are_no_numbers(f: Function, rng: np.random.Generator) -> None:
    """A goal that is not finite must be passed over and counted, and the way to the old one go on."""
    part, memory, _, r = begun(f, rng)
    goal = stand(r + draw.direction(rng))
    x = track(part, memory, goal, 0.05, 20)
    expect(int(numbers(part.failures(x.memory), ())) == 0, "Nothing has failed yet.")
    way = ramp(rng, r, 1.0, 2.0)
    lost = way.r.copy()
    lost[1, 2] = np.nan
    memory = x.memory
    for k, bad in enumerate((goal._replace(r=goal.r * np.nan), way._replace(r=lost))):
        memory, got = part.step(memory, at_rest(STILL), bad, 0.05)
        now = wanted(got)
        expect(np.linalg.norm(now.r - x.r[-1]) < 0.4, "It jumps.")
        expect(int(numbers(part.failures(memory), ())) == k + 1, "It has lost count.")
    y = track(part, memory, None, 0.05, 50)
    expect_close(y.r[-1], goal.r, "It does not go on to the old goal.", atol=0.1)
    expect(int(numbers(part.failures(y.memory), ())) == 2, "It has lost count.")


@hidden(MpcTracker)
def continued_in_motion(f: Function, rng: np.random.Generator) -> None:
    """From a reference in motion it must go on from there: to a rest if there is no goal, and to a goal if there is."""
    limits = between(rng)
    part, dt = f(limits), 0.04
    v, a = 0.3 * draw.direction(rng), 0.2 * draw.direction(rng)
    last = Reference(draw.vector(rng, 3.0), v, a, STILL, draw.angle(rng), 0.0)
    x = track(part, part.init(at_rest(STILL), last), None, dt, 75)
    expect_within(x, limits, dt)
    expect_close(x.v[0], v, "It begins with another velocity.", atol=1e-6)
    expect_close(x.a[0], a, "It begins with another acceleration.", atol=1e-6)
    expect(np.linalg.norm(x.v[-1]) < 0.02, "It does not come to rest.")
    expect(np.linalg.norm(x.r[-1] - last.r) < 2.0, "It goes far before it rests.")
    y = track(part, part.init(at_rest(STILL), last), stand(last.r + v), dt, 85)
    expect_within(y, limits, dt)
    expect_close(y.r[-1], last.r + v, "It does not arrive.", atol=0.05)
