"""The safe pilot: control manager, gain and constraint managers and UAV manager of MRS in one pure object (Sec. 7).

What it decides stands in files of its own: goals, wishes (parts, gains, limits), tasks (take-off, landing), overrides
(remote control, bumper), rescue (emergency, failsafe). Here is the order in which they are asked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

import numpy as np

from uavlab.area import Area
from uavlab.errors import BadInput, UnknownName
from uavlab.frames import Shift, heading
from uavlab.interfaces import Goal, Readings, Report, standing_command
from uavlab.managers import groups, overrides, rescue, tasks, wishes
from uavlab.managers import safety as watch
from uavlab.managers.bumper import Bumper
from uavlab.managers.bumper import checked as checked_bumper
from uavlab.managers.fence import fenced
from uavlab.managers.goals import asked_goal, asked_in, asked_velocity, minded, steered
from uavlab.managers.memory import Piloting, Wants, noted, refused, told
from uavlab.managers.modes import EMERGENCY, FAILSAFE, FLYING, GROUND, IN_AIR, LANDING
from uavlab.managers.reckoning import begun
from uavlab.managers.remote import Remote
from uavlab.managers.remote import checked as checked_remote
from uavlab.managers.safety import Safety, Verdict
from uavlab.managers.takeover import (
    DOWN,
    RESCUER,
    SOON,
    UP,
    controlled,
    kept,
    seated,
    tracked,
    tuned,
)
from uavlab.orders import (
    EmergencyLand,
    Fall,
    In,
    Land,
    LandHome,
    LandThere,
    Order,
    TakeOff,
    Unheard,
    Use,
    Velocity,
)
from uavlab.parts.missions import still
from uavlab.parts.slot import FIRST, Slot
from uavlab.parts.throttle import ThrustCurve
from uavlab.parts.throttle import checked as checked_curve
from uavlab.types import Command, Estimate, Reference, Trajectory

LIMITS, BUMPER, REMOTE = Safety(), Bumper(), Remote()


@dataclass(frozen=True)
class SafePilot:
    """Who flies, and whether it may: MRS Sec. 7, with figures of mrs_uav_managers where nothing else is said.

    Make one with `uavlab.piloted`; by hand, `trackers` must have "LandOff up", "LandOff" and "LandOff emergency", and
    `controllers` "Emergency". Parts of other groups of limits or gains are named by them: "MpcTracker slow",
    "GeometricController soft"; one that leaves an MPC controller room, "MpcTracker slow half".

    Parameters
    ----------
    trackers, controllers : Slot
        All that may fly. The first of each is wanted first.
    mass : float
        Of the aircraft, as it was told [kg].
    curve : ThrustCurve
        Of the aircraft.
    area : Area, optional
        In which it stays.
    safety : Safety
        The limits of the watch.
    allowed : mapping of str to Allowed
        Which groups may be flown in the world of which estimator.
    bumper : Bumper
        What it does about what is near, if an instrument "sectors" sees it.
    remote : Remote
        What the sticks mean, if an instrument "remote" reads them.
    lifts, lands : str
        The controllers of take-off and landing; empty: the one that is wanted.
    unsteered : float
        After so long without a new velocity it stands [s].

    Raises
    ------
    BadInput
        A part is missing, a figure is none, or the aircraft cannot hover.
    """

    trackers: Slot
    controllers: Slot
    mass: float
    curve: ThrustCurve
    area: Area | None = None
    safety: Safety = LIMITS
    allowed: Mapping[str, groups.Allowed] = field(default_factory=lambda: groups.ALLOWED)
    bumper: Bumper = BUMPER
    remote: Remote = REMOTE
    lifts: str = ""
    lands: str = ""
    unsteered: float = 1.0

    def __post_init__(self) -> None:
        for slot, kind, names in (
            (self.trackers, "tracker", (UP, DOWN, SOON)),
            (self.controllers, "controller", (RESCUER,)),
        ):
            missing = [x for x in names if x not in slot.parts]
            if slot.slot != kind or missing:
                raise BadInput(
                    f"the {kind}s of a SafePilot are a Slot with {', '.join(names)}; missing: {', '.join(missing)}."
                )
        for name in (self.lifts, self.lands):
            self._controls(name)
        checked_curve(self.curve, self.mass)
        watch.checked(self.safety)
        groups.checked(self.allowed)
        checked_bumper(self.bumper)
        checked_remote(self.remote)
        if not (isfinite(self.unsteered) and self.unsteered > 0.0):
            raise BadInput(f"unsteered is {self.unsteered} s; it must be finite and above 0.")

    def _controls(self, name: str) -> None:
        names = {groups.split(x, wishes.GROUPS["gains"])[0] for x in self.controllers.parts}
        if name and name not in names:
            raise BadInput(str(UnknownName("controller that lifts or lands", name, names)))

    def init(self, estimate: Estimate, ground: bool) -> Piloting:
        """On the ground, with motors off; or in the air as it is, with hover thrust first (MRS Sec. 7.4)."""
        names = self._first()
        hover = standing_command(self.mass)
        here = still(estimate.r, heading(estimate.R))
        home = (
            here if ground else here._replace(r=here.r * (1, 1, 0) + estimate.shift.r * (0, 0, 1))
        )
        m = Piloting(
            0.0, GROUND if ground else FLYING, names,
            self.trackers.init(estimate, here if ground else None),
            self.controllers.init(estimate, None if ground else hover),
            watch.begun(self.safety), estimate, here, hover, home, self.mass, np.zeros(3),
            begun(estimate.v),
        )  # fmt: skip
        why = "it stands on the ground" if ground else "it is in the air"
        m = noted(m, "mode", m.mode, why)
        m = noted(m, "tracker", m.tracking.name, FIRST)
        m = noted(m, "controller", m.controlling.name, FIRST)
        m = wishes.in_world(self, m, estimate, first=True)
        return m if ground else tuned(self, m, estimate)

    def _first(self) -> Wants:
        """What is wanted first: the first parts, and their groups."""
        first = [x.first or next(iter(x.parts)) for x in (self.trackers, self.controllers)]
        tracker, limits = groups.split(first[0], wishes.GROUPS["limits"])
        controller, gains = groups.split(first[1], wishes.GROUPS["gains"])
        may = groups.allowed_in(self.allowed, "")
        return Wants(tracker, controller, limits or may.default_limits, gains or may.default_gains)

    def step(
        self,
        memory: Piloting,
        estimate: Estimate,
        readings: Readings,
        asked: Sequence[Goal | Order],
        dt: float,
    ) -> tuple[Piloting, Reference, Command]:
        """One tick of `dt` [s].

        Raises
        ------
        NotImplementedError
            A part calls a stub that nobody has finished.
        """
        world = memory.estimate.world
        m, x = rescue.believed(memory, estimate, readings, dt)
        if not m.over and m.mode != FAILSAFE:
            if x.world != world:
                m = wishes.in_world(self, m, x)
            m = overrides.handled(self, m, x, readings, dt)
            m = self._heard(m, x, asked)
            m = overrides.minding(self, m, x, readings, dt)
        if m.over or m.mode == GROUND:
            m, reference, command = tasks.resting(m, x)
        elif m.mode == FAILSAFE:
            m, reference, command = rescue.falls(self, m, x, dt)
        else:
            heard = not any(isinstance(one, Unheard) for one in asked)
            m, reference, command = self._flown(m, x, estimate, memory.wants, heard, dt)
        return m._replace(t=m.t + dt, switched=False), reference, command

    def _heard(self, m: Piloting, x: Estimate, asked: Sequence[Goal | Order]) -> Piloting:
        """Goals and orders, one after the other."""
        for one in asked:
            obey = _OBEYED.get(type(one))
            m = _nothing(m, one) if obey is None else obey(self, m, x, one)
        return m

    def _flown(
        self, m: Piloting, x: Estimate, told: Estimate, before: Wants, heard: bool, dt: float
    ) -> tuple[Piloting, Reference, Command]:
        """Track, control and watch; if that goes wrong, again in an emergency; if that does, too, fall."""
        m = steered(self, m, x, dt) if m.steering else minded(self, m, x)
        after, reference, command, verdict = self._tried(m, x, told, heard, dt)
        if verdict.level == EMERGENCY and m.mode != EMERGENCY:
            after = rescue.land_now(self, after, x, verdict.trigger, verdict.said)
            after, reference, command, verdict = self._tried(after, x, told, heard, dt)
        if verdict.level:
            after = rescue.fall(self, after, x, verdict.trigger, verdict.said)
            return rescue.falls(self, after, x, dt)
        m = kept(self, after, before, x)
        mass, lean = tasks.weighed(self, m), tasks.leaning(m, x, reference, command, dt)
        m, command = tasks.progressed(self, m, x, command, dt)
        m = m._replace(reference=reference, command=command, mass=mass, lean=lean)
        return m, reference, command

    def _tried(
        self, m: Piloting, x: Estimate, told: Estimate, heard: bool, dt: float
    ) -> tuple[Piloting, Reference, Command, Verdict]:
        """One step of who flies, and what the watch says of it."""
        m, reference, why = tracked(self, m, x, dt)
        if why:
            return m, reference, m.command, _failed(m, "tracker", why)
        wanted, reference = reference, fenced(self.area, x, reference)
        if reference is not wanted and m.mode in {
            EMERGENCY,
            LANDING,
        }:  # from there on, or it sinks outside
            m = m._replace(tracking=seated(self.trackers, m.tracking.name, x, reference))
        m, command, why = controlled(self, m, x, reference, dt)
        if why:
            return m, reference, command, _failed(m, "controller", why)
        # Who lands and is outside is brought back gently, from however far: that is no error.
        seen = None if m.mode == EMERGENCY and reference is not wanted else reference
        m, verdict = rescue.guarded(self, m, told, (seen, command), heard, dt)
        return m, reference, command, verdict

    def reframe(self, memory: Piloting, shift: Shift) -> Piloting:
        """All of it, told in the new world."""
        m = memory
        falling = m.falling if m.law is None else m.law.reframe(m.falling, shift)
        return told(m, shift)._replace(
            tracking=self.trackers.reframe(m.tracking, shift),
            controlling=self.controllers.reframe(m.controlling, shift),
            falling=falling,
        )

    def report(self, memory: Piloting) -> Report:
        """What it does, and what it did."""
        return Report(memory.mode, memory.events, memory.over)


def _failed(m: Piloting, trigger: str, why: str) -> Verdict:
    """What a part that fails asks for."""
    return Verdict(watch.TRIGGERS[trigger][m.mode == EMERGENCY], trigger, why)


def _emergency(pilot: SafePilot, m: Piloting, x: Estimate, order: EmergencyLand) -> Piloting:
    if m.mode == EMERGENCY:
        return m
    if m.mode not in IN_AIR:
        return refused(m, order, f"it is not in the air, but {m.mode}.")
    return rescue.land_now(pilot, m, x, "asked for", order.why)


def _fall(pilot: SafePilot, m: Piloting, x: Estimate, order: Fall) -> Piloting:
    if m.mode not in IN_AIR:
        return refused(m, order, f"it is not in the air, but {m.mode}.")
    return rescue.fall(pilot, m, x, "asked for", order.why)


def _nothing(m: Piloting, one: Any) -> Piloting:
    return refused(m, one, f"{one!r} is no goal and no order.")


def _nobody(pilot: SafePilot, m: Piloting, x: Estimate, order: Unheard) -> Piloting:
    return m  # the watch counts for how long


_OBEYED: Mapping[type, Callable[[Any, Piloting, Estimate, Any], Piloting]] = {
    Reference: asked_goal, Trajectory: asked_goal, In: asked_in, Velocity: asked_velocity,
    Use: wishes.asked_use, TakeOff: tasks.take_off, Land: tasks.land, LandHome: tasks.land_home,
    LandThere: tasks.land_there, EmergencyLand: _emergency, Fall: _fall, Unheard: _nobody,
}  # fmt: skip
