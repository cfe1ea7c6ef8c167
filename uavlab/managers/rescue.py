"""Emergency and failsafe: what is done when it must come down (MRS Sec. 7.2)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np

from uavlab.errors import BadInput
from uavlab.frames import heading, wrap
from uavlab.managers import reckoning as dead
from uavlab.managers.memory import Piloting, changed, noted
from uavlab.managers.modes import EMERGENCY, FAILSAFE
from uavlab.managers.safety import Play, Verdict, begun, kind_of, watched
from uavlab.managers.takeover import RESCUER, SOON, planless, seated, tuned
from uavlab.managers.tasks import OFF, touchdown, touched
from uavlab.parts.failsafe import STEEPEST, Failsafe
from uavlab.parts.slot import TAKEN
from uavlab.so3 import about_z, exp
from uavlab.types import GRAVITY, Attitude, Command, Estimate, Imu, Mat3, Reference, Vec3

if TYPE_CHECKING:
    from uavlab.managers.pilot import SafePilot
MISSED = ("state missing", "unreliable")  # triggers that may pass
BACK = 1.0  # [s] of a reliable estimate, after which it is believed again (ours)
SOFT = 2.3  # [m/s], at which a fall should end: feet bear 3 (ours)
RATES = (
    1.0,
    0.7,
    0.5,
    0.35,
    0.25,
    0.15,
    0.1,
)  # of the rate of the failsafe, tried one after the other
UNTRUE = 2.0  # [m/s] by which the speed that is estimated is believed against the one that was flown (ours)
BRAKE = 1.0  # [1/s] of a velocity that a fall should not have (ours)
CLIMBS, DROPS = -0.3, -2.0  # [m/s], between which a fall is one (ours)
MOST = 2.5  # [m/s²] of thrust against it (ours)
LONG = 60.0  # [s], longer than any fall
LATE = 1.3  # times as long as it should take, and a second: then it stands
QUICK = 0.06  # [1/s] of the throttle from then on


# What is believed -------------------------------------------------------------------------------------


def believed(
    m: Piloting, estimate: Estimate, readings: Mapping[str, Any], dt: float
) -> tuple[Piloting, Estimate]:
    """The estimate, if it is finite and stands on measurements; else what is known of it, and for the rest the last.

    A place and a velocity that are not known, or guessed, are carried on by dead reckoning, as long as that is worth
    something; an attitude that is not known by what is read: turned by the gyro, its tilt that of the autopilot. For
    how long this may last is a matter of the watch, who sees the estimate itself.
    """
    x, last = estimate, m.estimate
    place, turn = x.r @ x.r + x.v @ x.v, np.vdot(x.R, x.R) + x.omega @ x.omega
    if not isfinite(turn):
        R, omega = turned(last.R, readings, dt)
        x = x._replace(R=R, omega=omega)
    if not isfinite(x.a @ x.a):  # nobody needs to fall for the lack of it
        x = x._replace(a=np.zeros(3))
    good = x.reliable and isfinite(place)
    reckoned = dead.reckoned(m.reckoned, x, good, x.R, readings, dt)
    if not good and reckoned.holds:
        x = x._replace(r=last.r + reckoned.v * dt, v=reckoned.v, a=np.zeros(3))
    elif not isfinite(place):
        x = x._replace(r=last.r, v=last.v, a=last.a)
    x = x._replace(reliable=good and isfinite(turn))
    return m._replace(estimate=x, reckoned=reckoned), x


def turned(R: Mat3, readings: Mapping[str, Any], dt: float) -> tuple[Mat3, np.ndarray]:
    """Attitude (3, 3) and rates (3,) [rad/s] a tick later, from what was read alone."""
    omega = np.zeros(3)
    imu, ahrs = readings.get("imu"), readings.get("ahrs")
    if isinstance(imu, Imu) and np.isfinite(imu.gyro).all():
        omega = imu.gyro
        R = R @ exp(omega * dt)
    if isinstance(ahrs, Attitude) and np.isfinite(ahrs.R).all():
        R = about_z(wrap(heading(R) - heading(ahrs.R))) @ ahrs.R
    return R, omega


# The watch --------------------------------------------------------------------------------------------


def guarded(
    pilot: SafePilot, m: Piloting, told: Estimate, given: tuple[Reference | None, Command], heard: bool,
    dt: float,
) -> tuple[Piloting, Verdict]:  # fmt: skip
    """What the watch says of this tick; `told` is the estimate as it came."""
    flying: Any = pilot.controllers.parts[m.controlling.name]
    failures = planless(pilot.trackers, m.tracking) + planless(pilot.controllers, m.controlling)
    play = Play(
        kind_of(getattr(flying, "part", flying)), m.switched, failures, heard, m.mode == EMERGENCY
    )
    watch, verdict = watched(pilot.safety, m.watch, told, *given, play, dt)
    if m.light > 0.0 and verdict.level and verdict.trigger not in MISSED:
        verdict = Verdict()  # it stands, or nearly: the ground holds it as it likes
    return m._replace(watch=watch), verdict


# What is done -----------------------------------------------------------------------------------------


def land_now(pilot: SafePilot, m: Piloting, estimate: Estimate, trigger: str, why: str) -> Piloting:
    """Begin to land in an emergency."""
    m = changed(noted(m, "safety", trigger, why), EMERGENCY, why)
    if trigger != "jump":  # the speed is nearly true, then, and has to be braked
        was = m.reference.v
        off = (
            estimate.v - was
        )  # of an observer it may be wrong by metres per second after a jump that was small
        share = min(1.0, UNTRUE / max(sqrt(off @ off), 1e-9))
        m = m._replace(reference=m.reference._replace(v=was + share * off))
    return tuned(pilot, m._replace(goal=None, pending=None), estimate)


def fall(pilot: SafePilot, m: Piloting, estimate: Estimate, trigger: str, why: str) -> Piloting:
    """Begin to come down without knowing where."""
    m = changed(noted(m, "safety", trigger, why), FAILSAFE, why)
    last = m.estimate
    high, v = float(last.r[2] - m.home.r[2]), float(last.v[2])
    law = replace(gentle(failsafe(pilot, m.mass), high, v), lean=_lean(m.lean))
    due = inf if law.rate == failsafe(pilot, m.mass).rate else LATE * landing(law, high, v)[1] + 1.0
    falling = law.init(estimate, m.command)
    return m._replace(law=law, falling=falling, fell=trigger, due=due, goal=None, pending=None)


def _lean(lean: Vec3) -> tuple[float, float]:
    """A lean that the failsafe takes [m/s²]."""
    x, y, _ = lean * min(1.0, 0.99 * STEEPEST / max(sqrt(lean @ lean), 1e-9))
    return float(x), float(y)


def failsafe(pilot: SafePilot, mass: float) -> Failsafe:
    """The failsafe for an aircraft of this mass [kg]; of the one that was told if that cannot hover."""
    try:
        return Failsafe(mass, pilot.curve)
    except BadInput:
        return Failsafe(pilot.mass, pilot.curve)


def gentle(law: Failsafe, height: float, v: float) -> Failsafe:
    """The same failsafe, its thrust falling more slowly if it would else hit the ground too fast.

    That of mrs_uav_managers is made for low flights indoors: from 5 m it lands at 3.6 m/s. How high it was when it last
    knew is known, and how fast that is on the ground can be said beforehand (ours).

    Parameters
    ----------
    law : Failsafe
        For the mass that was believed.
    height, v : float
        Above the ground [m], and how fast it climbs [m/s].
    """
    slower = (replace(law, rate=law.rate * share) for share in RATES)
    last = replace(law, rate=law.rate * RATES[-1])
    return next((x for x in slower if landing(x, height, v)[0] < SOFT), last)


def landing(law: Failsafe, height: float, v: float, dt: float = 0.02) -> tuple[float, float]:
    """Speed [m/s] and time [s] at which a failsafe meets the ground, from `height` [m] and `v` [m/s], in still air."""
    t = 0.0
    while height > 0.0 and t < LONG:
        v += (law.force(t) / law.mass - GRAVITY) * dt
        height += v * dt
        t += dt
    return (-v if height <= 0.0 else inf), t


def _stood(pilot: SafePilot, m: Piloting) -> Piloting:
    """A fall that was slow, and should be over: from now on the thrust goes quickly, so that the ground is seen."""
    if m.falling.t < m.due:
        return m
    law = m.law
    hover = law.curve.a_t * sqrt(law.mass * GRAVITY) + law.curve.b_t
    share = max(law.share - law.rate * m.falling.t / hover, 0.01)
    return m._replace(
        law=replace(law, share=share, rate=QUICK), falling=m.falling._replace(t=0.0), due=inf
    )


def falls(
    pilot: SafePilot, m: Piloting, estimate: Estimate, dt: float
) -> tuple[Piloting, Reference, Command]:
    """A tick of the failsafe, which needs an attitude and nothing else. The reference stands where it was.

    As long as a velocity is known it leans against what moves sideways, and keeps what climbs or drops from it (ours).
    """
    zero = np.zeros(3)
    reference = m.reference._replace(v=zero, a=zero, j=zero, heading_rate=0.0)
    m = _stood(pilot, m)
    falling, eased = m.falling, 0.0
    if m.reckoned.holds:
        x, y, z = estimate.v
        lean = _lean(m.lean - BRAKE * np.array((x, y, 0.0)))
        falling, eased = falling._replace(lean=np.array((*lean, 0.0))), m.law.mass * _eased(z)
    falling, command = m.law.step(falling, estimate, reference, dt)
    light, down = touchdown(pilot, m.mass).step(m.light, command, dt)
    command = command._replace(f_d=max(command.f_d + eased, 0.0))
    m = m._replace(falling=falling, light=light, reference=reference, command=command)
    if down:
        return touched(m, FAILSAFE)._replace(command=OFF), reference, OFF
    return _caught(pilot, m, estimate, dt), reference, command


def _eased(v_z: float) -> float:
    """What is added to the thrust of a fall [m/s²] that climbs, or drops too fast."""
    a = BRAKE * (CLIMBS - v_z) if v_z > CLIMBS else BRAKE * max(DROPS - v_z, 0.0)
    return min(max(a, -MOST), MOST)


def _caught(pilot: SafePilot, m: Piloting, estimate: Estimate, dt: float) -> Piloting:
    """Who falls for want of an estimate, and has had one again for a while, lands with it instead.

    This is ours: mrs_uav_managers falls to the end. But a fall is blind, and a landing is not.
    """
    known = m.fell in MISSED and estimate.reliable and m.light == 0.0
    m = m._replace(waited=m.waited + dt if known else 0.0)
    if m.waited < BACK:
        return m
    m = changed(m, EMERGENCY, f"there has been an estimate again for {BACK:g} s")
    for kind, name in (("tracker", SOON), ("controller", RESCUER)):
        m = noted(m, kind, name, TAKEN)
    return m._replace(
        tracking=seated(pilot.trackers, SOON, estimate, None), law=None, falling=None, fell="",
        controlling=seated(pilot.controllers, RESCUER, estimate, m.command), watch=begun(pilot.safety),
    )  # fmt: skip
