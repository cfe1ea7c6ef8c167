"""The remote control: somebody on the ground takes over, gives back, or wants it down (MRS Sec. 7.2).

The figures are those of mrs_uav_managers unless it says "ours".
"""

from __future__ import annotations

from math import isfinite, sqrt
from typing import NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import heading
from uavlab.orders import Velocity
from uavlab.so3 import about_z
from uavlab.types import Estimate, Reference, Sticks

HOVER, EMERGENCY, FAILSAFE = "hover", "emergency", "failsafe"
STAGES = ("", HOVER, EMERGENCY, FAILSAFE)  # one after the other, while the failsafe switch is on


class Remote(NamedTuple):
    """What the sticks mean."""

    v: float = 1.0  # [m/s] of a stick that is pushed all the way
    turn: float = 0.2  # [rad/s] likewise
    dead: float = 0.05  # of the way: less is let go (ours)
    a: float = 1.0  # [m/s²] with which it stops when they are let go: of the limits "slow" (ours)
    pause: float = 2.0  # [s] at least, between two stages of the failsafe switch
    silence: float = 1.0  # [s] after which nobody holds them any more (ours)


class Held(NamedTuple):
    """What is remembered of the sticks. No place is among it, so it is the same in every world."""

    sticks: Sticks | None = None  # as heard last
    age: float = 0.0  # [s] since then
    engaged: bool = False
    free: bool = False  # engaged, and the sticks are let go
    stage: int = 0  # of `STAGES`
    since: float = 0.0  # [s] since it was reached


class Wish(NamedTuple):
    """What the sticks want in this tick."""

    engaged: bool  # whether the aircraft obeys them, and nobody else
    asked: Velocity | Reference | None  # to be flown from now on; None: what was asked last
    stage: str  # one of `STAGES`: how the failsafe switch wants it to come down; engaged or not
    said: str  # what has changed; empty: nothing


def heard(
    remote: Remote, memory: Held, sticks: Sticks | None, estimate: Estimate, dt: float
) -> tuple[Held, Wish]:
    """One tick of somebody at the sticks.

    Pushed, they ask for a velocity in the frame of the heading, anew in every tick. Let go, they ask once for the place
    where the aircraft will have stopped. With the failsafe switch on, it first hovers, then lands in an emergency,
    then falls, `pause` apart; switched off in time, a hover is all there was.

    Parameters
    ----------
    remote : Remote
        See `checked`.
    memory : Held
        ``Held()`` at first.
    sticks : Sticks or None
        What arrived in this tick.
    estimate : Estimate
        Of now.
    dt : float
        [s] since the tick before.
    """
    age = 0.0 if sticks is not None else memory.age + dt
    last = sticks or memory.sticks
    silent = age > remote.silence - 1e-9
    engaged = last is not None and last.engaged and not silent
    stage, since = _escalated(remote, memory, last is not None and last.failsafe, silent, dt)
    asked, free = None, False
    if engaged and last is not None:
        free = _let_go(remote, last)
        if not free:
            asked = _velocity(remote, last, estimate)
        elif not memory.free:
            asked = _stopped(remote, estimate)
    said = _changed(remote, memory, engaged, silent, stage)
    wish = Wish(engaged, asked, STAGES[stage], said)
    return Held(last, age, engaged, free, stage, since), wish


def _escalated(
    remote: Remote, memory: Held, on: bool, silent: bool, dt: float
) -> tuple[int, float]:
    """The stage of the failsafe switch, and how long it has been reached [s]."""
    stage, since = memory.stage, memory.since + dt
    if silent:  # nobody knows how the switch is now
        return stage, since
    if on and (stage == 0 or (stage < len(STAGES) - 1 and since > remote.pause - 1e-9)):
        return stage + 1, 0.0
    if not on and STAGES[stage] == HOVER:
        return 0, 0.0
    return stage, since


def _let_go(remote: Remote, sticks: Sticks) -> bool:
    return float(np.abs(sticks.push).max()) < remote.dead and abs(sticks.turn) < remote.dead


def _velocity(remote: Remote, sticks: Sticks, estimate: Estimate) -> Velocity:
    """What they ask for, told in the world of the estimate."""
    push = np.clip(sticks.push, -1.0, 1.0)
    turn = min(max(sticks.turn, -1.0), 1.0)
    v = about_z(heading(estimate.R)) @ (remote.v * push)
    return Velocity(v, heading_rate=remote.turn * turn)


def _stopped(remote: Remote, estimate: Estimate) -> Reference:
    """Where it stands once it has braked."""
    v = estimate.v
    r = estimate.r + v * (sqrt(v @ v) / (2.0 * remote.a))
    zero = np.zeros(3)
    return Reference(r, zero, zero, zero, heading(estimate.R), 0.0)


def _changed(remote: Remote, memory: Held, engaged: bool, silent: bool, stage: int) -> str:
    """What is to be told of this tick."""
    if stage > memory.stage:
        held = f"for {remote.pause:g} s more" if memory.stage else "now"
        return f"the failsafe switch is on {held}: {STAGES[stage]}"
    if engaged and not memory.engaged:
        return "the remote control takes over"
    if memory.engaged and not engaged:
        why = f"it has been silent for {remote.silence:g} s" if silent else "it was let go"
        return f"the remote control gives back: {why}"
    return ""


def checked(remote: Remote) -> Remote:
    """The same remote control, if it can be flown with.

    Raises
    ------
    BadInput
        A number that is not finite or not above 0, or a dead zone that is all of the way.
    """
    for name, value in zip(remote._fields, remote, strict=True):
        if not (isfinite(value) and value > 0.0):
            raise BadInput(f"remote.{name} is {value}; it must be a finite number above 0.")
    if not remote.dead < 1.0:
        raise BadInput(f"remote.dead is {remote.dead}; it must be below 1: the sticks end there.")
    return remote
