"""Who overrides a mission: somebody at a remote control, and the bumper (MRS Sec. 7.2)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from uavlab.managers import fence
from uavlab.managers.bumper import bumped
from uavlab.managers.goals import given, halt, now, steer
from uavlab.managers.memory import Evading, Piloting, changed, noted
from uavlab.managers.modes import EMERGENCY, EVADING, FLYING, GOING_HOME, IN_AIR, MANUAL
from uavlab.managers.remote import FAILSAFE as DROP
from uavlab.managers.remote import HOVER, Wish, heard
from uavlab.managers.rescue import fall, land_now
from uavlab.managers.takeover import tuned
from uavlab.orders import Velocity
from uavlab.types import Estimate, Sectors, Sticks

if TYPE_CHECKING:
    from uavlab.managers.pilot import SafePilot

BLIND = 1.0  # [s] without a reading of what is near, after which nothing is (ours)


def handled(
    pilot: SafePilot, m: Piloting, estimate: Estimate, readings: Mapping[str, Any], dt: float
) -> Piloting:
    """What the sticks want, if there are any."""
    sticks = readings.get("remote")
    if sticks is None and m.held.sticks is None:
        return m
    held, wish = heard(
        pilot.remote, m.held, sticks if isinstance(sticks, Sticks) else None, estimate, dt
    )
    new = held.stage > m.held.stage
    m = m._replace(held=held)
    if m.mode not in IN_AIR:
        return m
    if wish.said:
        m = noted(m, "remote", wish.stage or (MANUAL if wish.engaged else FLYING), wish.said)
    if new and wish.stage != HOVER:
        return _down(pilot, m, estimate, wish.stage, wish.said)
    if m.mode == EMERGENCY:
        return m
    return _held(pilot, m, estimate, wish, new)


def _held(pilot: SafePilot, m: Piloting, estimate: Estimate, wish: Wish, new: bool) -> Piloting:
    """Whether somebody holds the sticks, and what they ask for."""
    hovers = wish.stage == HOVER
    holds = wish.engaged or hovers
    if holds != (m.mode == MANUAL):
        m = changed(m, MANUAL if holds else FLYING, wish.said)._replace(pending=None)
        return tuned(pilot, m._replace(goal=halt(pilot, m, estimate), since=m.t), estimate)
    if not holds or (hovers and not new):
        return m
    if hovers:
        return given(pilot, m, estimate, halt(pilot, m, estimate))
    if isinstance(wish.asked, Velocity):
        return steer(pilot, m, estimate, wish.asked)
    if wish.asked is None:
        return m
    why = fence.why_not(pilot.area, estimate, wish.asked, now(m).r)
    return given(pilot, m, estimate, halt(pilot, m, estimate) if why else wish.asked)


def _down(pilot: SafePilot, m: Piloting, estimate: Estimate, stage: str, said: str) -> Piloting:
    """The failsafe switch has been on for long."""
    if stage == DROP:
        return fall(pilot, m, estimate, "remote", said)
    return m if m.mode == EMERGENCY else land_now(pilot, m, estimate, "remote", said)


def minding(
    pilot: SafePilot, m: Piloting, estimate: Estimate, readings: Mapping[str, Any], dt: float
) -> Piloting:
    """What the bumper wants, if it sees anything."""
    sectors = readings.get("sectors")
    if not isinstance(sectors, Sectors):
        if m.evading is None:
            return m
        evading = m.evading._replace(age=m.evading.age + dt)
        m = m._replace(evading=evading)
        return m if evading.age < BLIND else _free(pilot, m, estimate)
    if m.mode not in {FLYING, GOING_HOME, EVADING}:
        return m
    bump = bumped(
        pilot.bumper, sectors, estimate,
        lambda goal: fence.why_not(pilot.area, estimate, goal, now(m).r),
        m.evading is not None,
    )  # fmt: skip
    if bump.goal is None:
        return m if m.evading is None else _free(pilot, m, estimate)
    if m.evading is None:
        before, target = m.mode, m.target
        m = changed(noted(m, "bumper", "near", bump.said), EVADING, bump.said)
        m = tuned(pilot, m._replace(evading=Evading(before, 0.0), target=target), estimate)
    assert m.evading is not None
    return m._replace(goal=bump.goal, evading=m.evading._replace(age=0.0))


def _free(pilot: SafePilot, m: Piloting, estimate: Estimate) -> Piloting:
    """Nothing is near any more: go on with what was done before, from here."""
    assert m.evading is not None
    before = m.evading.before
    m = noted(m, "bumper", "free", "nothing is too near any more")
    m = changed(m, before, "nothing is too near any more")
    if before == GOING_HOME and m.target is not None:
        return m._replace(goal=m.target)
    return m
