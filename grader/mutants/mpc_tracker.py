"""Known wrong answers of lab 06, continued: trackers, each the reference with something around it that is wrong."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from grader.hidden.mpc_course import ramp
from grader.material import Play, mutant, sample
from uavlab import frames
from uavlab.exercises import draw
from uavlab.exercises.mpc import MpcTracker
from uavlab.exercises.mpc_parts_checks import at_rest, between, stand, wanted
from uavlab.limits import AxisLimits, Limits
from uavlab.solutions.mpc import MpcTracker as Right
from uavlab.types import Reference, Shift, Trajectory

CANARY = "canary-f0c127673b6af8399642f54c"

DT = 0.05


def asked(
    f: Any, limits: Limits, last: Reference | None, goals: dict[int, Any], steps: int, told: tuple[int, ...],
    shift: Shift | None = None,
) -> list[Any]:  # fmt: skip
    """What a tracker wants at some steps, to as many digits as two trackers cannot share by chance."""
    part = f(limits)
    lost = at_rest(np.array((3.0, -2.0, 1.0)), 0.5)._replace(v=0.2 * np.ones(3))
    memory, said = part.init(lost, last), []
    for k in range(steps):
        if shift is not None and k == steps // 2:
            memory = part.reframe(memory, shift)
        memory, got = part.step(memory, lost, goals.get(k), DT)
        said += list(wanted(got)) if k in told else []
    return [said, part.failures(memory)]


@sample(MpcTracker)
def courses(rng: np.random.Generator) -> list[Play]:
    limits, r = between(rng), draw.vector(rng, 2.0)
    up, down = np.array((3.0, -2.0, 2.5)), np.array((3.0, -2.0, -2.5))
    last = stand(r, 2.9)
    moving = last._replace(
        v=0.3 * rng.normal(size=3), a=0.2 * rng.normal(size=3), j=0.2 * rng.normal(size=3)
    )
    far = stand(r + up, -2.9)
    way, goal = (
        ramp(rng, r, 0.7, 3.0),
        stand(r + draw.direction(rng))._replace(v=0.4 * draw.direction(rng)),
    )
    bad = way._replace(r=way.r * np.nan)
    shift = Shift(draw.vector(rng, 3.0), 0.5 * np.pi)
    see = partial(asked, limits=limits)
    return [
        partial(see, last=last, goals={0: far, 24: stand(r + down, 2.0)}, steps=44, told=(0, 5, 20, 40, 43)),
        partial(see, last=moving, goals={0: goal}, steps=16, told=(0, 1, 15)),
        partial(see, last=None, goals={}, steps=8, told=(0, 7)),
        partial(see, last=last, goals={0: way, 2: goal._replace(r=goal.r * np.nan)}, steps=24, told=(1, 12, 23)),
        partial(see, last=last, goals={0: far, 3: bad}, steps=12, told=(11,), shift=shift),
        partial(see, last=last, goals={0: stand(r, -1.5)}, steps=30, told=(29,)),
    ]  # fmt: skip


class Around:
    """The reference, and what a mistake makes of its limits, goals and references."""

    def __init__(self, limits, N=40, dt=0.2):
        self.right = Right(self.limits(limits), N, dt)

    def limits(self, limits):
        return limits

    def goal(self, goal, memory):
        return goal

    def last(self, estimate, last):
        return last

    def out(self, out, before, dt):
        return out

    def init(self, estimate, last):
        return self.right.init(estimate, self.last(estimate, last)), None

    def step(self, memory, estimate, goal, dt):
        goal = self.goal(goal, memory)
        inner, out = self.right.step(memory[0], estimate, goal, dt)
        out = self.out(out, memory[1], dt)
        return (inner, out), out

    def reframe(self, memory, shift):
        out = None if memory[1] is None else frames.moved(memory[1], shift)
        return self.right.reframe(memory[0], shift), out

    def failures(self, memory):
        return self.right.failures(memory[0])


def every(limits, **more):
    """Limits with something else on all four axes."""
    named = ("horizontal", "up", "down", "heading")
    return limits._replace(**{
        k: getattr(limits, k)._replace(**{d: s * getattr(getattr(limits, k), d) for d, s in more.items()})
        for k in named
    })  # fmt: skip


# Limits -----------------------------------------------------------------------------------------------


@mutant(MpcTracker, hint="It sinks like it climbs: down has limits of its own.")
class sinks_as_it_climbs(Around):
    def limits(self, limits):
        return limits._replace(down=limits.up)


@mutant(MpcTracker, hint="Up and down have changed places: up bounds what is above 0.")
class upside_down_limits(Around):
    def limits(self, limits):
        return limits._replace(up=limits.down, down=limits.up)


@mutant(MpcTracker, hint="The vertical keeps the horizontal limits: it has its own.")
class horizontal_for_the_vertical(Around):
    def limits(self, limits):
        return limits._replace(up=limits.horizontal, down=limits.horizontal)


@mutant(MpcTracker, hint="Speeds are not limited.")
class any_speed(Around):
    def limits(self, limits):
        return every(limits, v=9.0)


@mutant(MpcTracker, hint="Accelerations are not limited.")
class any_acceleration(Around):
    def limits(self, limits):
        return every(limits, a=9.0)


@mutant(MpcTracker, hint="Jerk and snap are not limited.")
class any_jerk(Around):
    def limits(self, limits):
        return every(limits, j=20.0, s=20.0)


@mutant(MpcTracker, hint="Plans keep half of the limits: they may be made use of.")
class half_of_it(Around):
    def limits(self, limits):
        return every(limits, v=0.5, a=0.5)


@mutant(MpcTracker, hint="The heading has no limits: it is an axis like the others.")
class any_turn(Around):
    def limits(self, limits):
        return limits._replace(heading=AxisLimits(30.0, 60.0, 600.0, 6000.0))


# The model --------------------------------------------------------------------------------------------


@mutant(MpcTracker, hint="The position moves by v dt alone (Euler): a dt²/2 is missing.")
class euler_tracker(Around):
    def out(self, out, before, dt):
        return out if before is None else out._replace(r=before.r + before.v * dt)


@mutant(
    MpcTracker, hint="The model has moved on before it is told: the first reference is that of now."
)
class a_tick_ahead(Around):
    def step(self, memory, estimate, goal, dt):
        inner, _ = self.right.step(memory[0], estimate, goal, dt)
        _, out = self.right.step(inner, estimate, None, dt)
        return (inner, out), out


@mutant(
    MpcTracker, hint="Acceleration and jerk of the reference are zero: tell those of the model."
)
class no_derivatives(Around):
    def out(self, out, before, dt):
        return out._replace(a=np.zeros(3), j=np.zeros(3))


@mutant(MpcTracker, hint="The reference follows the estimate: after init the estimate is not used.")
class drawn_to_the_estimate(Around):
    def step(self, memory, estimate, goal, dt):
        inner, out = self.right.step(memory[0], estimate, goal, dt)
        out = out._replace(r=out.r + 0.1 * (estimate.r - out.r))
        return (inner, out), out


@mutant(
    MpcTracker, hint="It begins at the estimate though there was a reference: continue from that."
)
class begins_at_the_estimate(Around):
    def last(self, estimate, last):
        return None


@mutant(MpcTracker, hint="It begins without the acceleration and jerk of the last reference.")
class begins_without_acceleration(Around):
    def last(self, estimate, last):
        return last and last._replace(a=np.zeros(3), j=np.zeros(3))


@mutant(
    MpcTracker,
    hint="It begins at rest where the estimate is: without a last reference take its velocity, too.",
)
class begins_at_rest(Around):
    def last(self, estimate, last):
        return last or stand(estimate.r, frames.heading(estimate.R))


# Goals ------------------------------------------------------------------------------------------------


@mutant(MpcTracker, hint="Of a trajectory its first point is held: go along it.")
class holds_the_first_point(Around):
    def goal(self, goal, memory):
        return stand(goal.r[0], goal.heading[0]) if isinstance(goal, Trajectory) else goal


@mutant(
    MpcTracker, hint="Of a trajectory its last point is flown to at once: its points have times."
)
class flies_to_the_last_point(Around):
    def goal(self, goal, memory):
        return stand(goal.r[-1], float(goal.heading[-1])) if isinstance(goal, Trajectory) else goal


@mutant(MpcTracker, hint="The trajectory is flown without its headings.")
class no_headings(Around):
    def goal(self, goal, memory):
        return (
            goal._replace(heading=0.0 * goal.heading + goal.heading[0])
            if isinstance(goal, Trajectory)
            else goal
        )


@mutant(MpcTracker, hint="The trajectory begins too late: its time 0 is when it is given.")
class late_on_the_trajectory(Around):
    def goal(self, goal, memory):
        return goal._replace(t=goal.t + 1.0) if isinstance(goal, Trajectory) else goal


@mutant(
    MpcTracker, hint="A goal that moves is taken for one at rest: it goes on with its velocity."
)
class goal_at_rest(Around):
    def goal(self, goal, memory):
        return goal._replace(v=np.zeros(3)) if isinstance(goal, Reference) else goal


@mutant(MpcTracker, hint="A goal is forgotten after a step: None means as before.")
class forgets_its_goal(Around):
    def goal(self, goal, memory):
        return (
            goal if goal is not None or memory[1] is None else stand(memory[1].r, memory[1].heading)
        )


@mutant(MpcTracker, hint="The heading of the goal is not used.")
class heading_kept(Around):
    def goal(self, goal, memory):
        was = 2.9 if memory[1] is None else memory[1].heading
        return goal._replace(heading=was, heading_rate=0.0) if isinstance(goal, Reference) else goal


@mutant(MpcTracker, hint="The heading is not wrapped: tell it within ±π.")
class heading_not_wrapped(Around):
    def out(self, out, before, dt):
        if before is None:
            return out
        return out._replace(heading=before.heading + frames.wrap(out.heading - before.heading))


# Worlds and failures ----------------------------------------------------------------------------------


@mutant(
    MpcTracker,
    hint="reframe does nothing: the model, its plans and its goal are told in the world.",
)
class tracker_not_reframed(Around):
    def reframe(self, memory, shift):
        return memory


@mutant(MpcTracker, hint="reframe leaves the goal behind: it is told in the world, too.")
class goal_left_behind(Around):
    def init(self, estimate, last):
        inner, _ = super().init(estimate, last)
        return inner, None, None, False

    def step(self, memory, estimate, goal, dt):
        again = memory[2] if memory[3] and goal is None else goal
        (inner, out), _ = super().step(memory[:2], estimate, again, dt)
        return (inner, out, goal if isinstance(goal, Reference) else memory[2], False), out

    def reframe(self, memory, shift):
        return (*super().reframe(memory[:2], shift), memory[2], True)


@mutant(MpcTracker, hint="reframe shifts without turning: the worlds are turned, too.")
class shifted_only(Around):
    def reframe(self, memory, shift):
        return super().reframe(memory, shift._replace(heading=0.0))


@mutant(MpcTracker, hint="Failures of the tracker are not counted.")
class no_failures_counted(Around):
    def failures(self, memory):
        return 0


@mutant(MpcTracker, hint="A goal that is not finite raises an error: pass it over.")
class raises_for_a_bad_goal(Around):
    def goal(self, goal, memory):
        if goal is not None and not np.isfinite(np.sum(goal.r)):
            raise ValueError("a goal that is not finite")
        return goal


@mutant(MpcTracker, hint="A goal that is not finite makes it forget the old one: go on to that.")
class stops_for_a_bad_goal(Around):
    def step(self, memory, estimate, goal, dt):
        inner = memory[0]
        if goal is not None and not np.isfinite(np.sum(goal.r)):
            inner, _ = self.right.step(inner, estimate, goal, 1e-6)
            here = memory[1]
            goal = stand(here.r, here.heading)
        inner, out = self.right.step(inner, estimate, goal, dt)
        return (inner, out), out
