"""A bank of filters that flies: hypotheses and arbiter of lab 03, and the attitude with the estimated heading."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.errors import BadInput, UnknownName
from uavlab.frames import compose, heading, inverse, moved
from uavlab.interfaces import Memory, Readings, asks
from uavlab.parts.estimators import HEARD
from uavlab.parts.priority import FixedPriority
from uavlab.so3 import about_z, exp
from uavlab.types import (
    Attitude,
    Command,
    Estimate,
    Hypothesis,
    Imu,
    Mat3,
    Pose,
    Shift,
    Vec3,
)

GNSS = ("imu.heading_rate", "magnetometer.heading", "gnss.velocity", "gnss.position", "gnss.height")
RTK = ("imu.heading_rate", "magnetometer.heading", "rtk.velocity", "rtk.position", "rtk.height")
SLAM = ("imu.heading_rate", "slam.heading", "slam.position", "slam.height")
FLOW = ("imu.heading_rate", "flow.velocity", "rangefinder.height")
MOCAP = ("imu.heading_rate", "mocap.heading", "mocap.position", "mocap.height")
MEMBERS: Mapping[str, tuple[str, ...]] = {
    "gnss": GNSS,
    "rtk": RTK,
    "slam": SLAM,
    "flow": FLOW,
    "flow+slam": (*SLAM[:2], "flow.velocity", *SLAM[2:]),
    "mocap": MOCAP,
}
VARIANCES: Mapping[str, float] = {  # of the instruments as they come in `uavlab.sensors`
    "imu.heading_rate": 1e-4,  # the bias at switch-on is most of it
    "magnetometer.heading": 4e-4,
    "gnss.velocity": 4e-3,
    "gnss.position": 1e-2,  # facts of the MRS filters; the error that wanders is larger and stays
    "gnss.height": 1e-2,
    "rtk.velocity": 1e-3,
    "rtk.position": 1e-3,  # as in the MRS filters
    "rtk.height": 1e-3,
    "slam.heading": 1e-4,
    "slam.position": 1e-3,
    "slam.height": 1e-3,
    "flow.velocity": 1e-2,
    "mocap.heading": 1e-5,
    "mocap.position": 1e-5,  # a millimetre of noise; the age of a pose makes as much in flight
    "mocap.height": 1e-5,
    "rangefinder.height": 1e-2,
    "barometer.height": 0.1,
}


class Setup(NamedTuple):
    """What a bank is made of."""

    members: Mapping[str, tuple[str, ...]] = MEMBERS  # filter → the sources that correct it
    variances: Mapping[str, float] = VARIANCES  # source → variance in the square of its unit
    options: Mapping[str, Any] = {}  # other parameters of `KalmanBank`


ALL = Setup()


def chosen(*names: str) -> Setup:
    """A bank of some of the `MEMBERS`.

    Raises
    ------
    UnknownName
        One of them is not there.
    """
    for name in names:
        if name not in MEMBERS:
            raise UnknownName("member", name, MEMBERS)
    return Setup({name: MEMBERS[name] for name in names})


def fused(setup: Setup, name: str = "all in one") -> Setup:
    """The same data in one filter that believes everything, at once: what MRS Sec. 3.5 warns of."""
    sources = dict.fromkeys(source for own in setup.members.values() for source in own)
    options = {**setup.options, "gate": inf, "limits": (inf, inf), "patience": inf}
    return setup._replace(members={name: tuple(sources)}, options=options)


class Flying(NamedTuple):
    """What a bank in flight remembers."""

    bank: Memory  # of the filters
    told: Mapping[str, Hypothesis]  # what they believe now
    last: Estimate  # as it was given out
    R: Mat3  # (3, 3) attitude of the autopilot, in its own world
    t: float  # [s] since init
    asked: tuple[tuple[float, str], ...] = ()  # the last request of `swap`: when [s], and for whom


@dataclass(frozen=True)
class BankEstimator:
    """Filters in parallel, an arbiter, and the tilt of the autopilot turned to the heading of the filter that flies.

    It continues the estimate that it was given, as a world without a name, until a filter is reliable. When another
    filter takes over, the estimate is told in that filter's world, and its `shift` says so.

    Parameters
    ----------
    setup : Setup
        Which filters there are.
    requests : tuple of (time [s], name)
        From that time on the mission asks for that filter; an empty name takes the request back.
    patience : float
        How long [s] the start waits for the filter that is asked for, before another one may fly.
    """

    slot: ClassVar[str] = "estimator"
    KalmanBank: Callable[..., Any] = asks("kalman_bank")
    arbitrate: Callable[[Mapping[str, Hypothesis], str, str], str] = asks("kalman_bank")
    shift_between: Callable[[Hypothesis, Hypothesis], Shift] = asks("kalman_bank")
    setup: Setup = ALL
    requests: tuple[tuple[float, str], ...] = ()
    patience: float = 1.0

    def __post_init__(self) -> None:
        times = [t for t, _ in self.requests]
        if times != sorted(times):
            raise BadInput(f"the times of requests must grow; got {times} s.")
        for _, name in self.requests:
            if name and name not in self.setup.members:
                raise UnknownName("filter that is asked for", name, self.setup.members)

    @staticmethod
    def stand_in(
        setup: Setup = ALL,
        requests: tuple[tuple[float, str], ...] = (),
        patience: float = 1.0,
    ) -> FixedPriority:
        """What flies while one of the functions is missing: it knows no members and hears no requests."""
        return FixedPriority()

    @cached_property
    def filters(self) -> Any:
        """The bank."""
        members, variances, options = self.setup
        return self.KalmanBank(dict(members), dict(variances), **options)

    def init(self, estimate: Estimate) -> Flying:
        """All filters begin at `estimate`, and none is reliable unless it is the one that gave it."""
        at = _as_hypothesis(estimate)
        told = dict.fromkeys(self.setup.members, at)
        return Flying(self.filters.init(estimate), told, estimate, estimate.R, 0.0)

    def step(
        self, memory: Flying, readings: Readings, command: Command, dt: float
    ) -> tuple[Flying, Estimate]:
        """One tick: the filters, the arbiter, the estimate."""
        last, t = memory.last, memory.t + dt
        flies = last.world if last.world in self.setup.members else ""
        R, omega, readings = _attitude(memory.R, last.omega, readings, dt)
        bank, told = self.filters.step(memory.bank, readings, command, dt, flies)

        name = self._arbiter(told, flies, t, memory.asked)
        shift = last.shift
        if name != flies:
            before = told[flies] if flies else _as_hypothesis(_carried(last, omega, dt))
            shift = compose(self.shift_between(before, told[name]), shift)
        estimate = _carried(last, omega, dt)
        if name:
            estimate = self._estimate(told, name, R, omega, shift)
        healthy = t <= HEARD or any(x.reliable for x in told.values())  # first, the start counts
        estimate = estimate._replace(reliable=healthy)
        return Flying(bank, told, estimate, R, t, memory.asked), estimate

    @property
    def names(self) -> tuple[str, ...]:
        """Whom a swap may name: the filters."""
        return tuple(self.setup.members)

    def swap(self, memory: Flying, name: str) -> Flying:
        """Ask for a filter in flight: from the next step on, as if `requests` had a line more.

        Parameters
        ----------
        memory : Flying
            Of this bank.
        name : str
            A filter; empty: the arbiter is free again.

        Returns
        -------
        Flying
            The request stands until another one comes, from here or from `requests`.

        Raises
        ------
        UnknownName
            There is no such filter.
        BadInput
            It is not reliable now, and another one flies.
        """
        if name and name not in self.setup.members:
            raise UnknownName("filter of the bank", name, self.setup.members)
        flies = memory.last.world in self.setup.members
        if name and flies and not memory.told[name].reliable:
            raise BadInput(f"{name} is not reliable now; ask again when it is.")
        return memory._replace(asked=((memory.t, name),))

    def _arbiter(
        self,
        told: Mapping[str, Hypothesis],
        flies: str,
        t: float,
        at_last: tuple[tuple[float, str], ...],
    ) -> str:
        """Who flies; nobody until the first one is reliable."""
        requests = sorted((*self.requests, *at_last), key=lambda x: x[0])
        asked = ["", *(name for time, name in requests if time <= t + 1e-9)][-1]
        first = next((name for name, x in told.items() if x.reliable), "")
        waiting = bool(asked) and not told[asked].reliable and t < self.patience
        if not flies and (waiting or not first):
            return ""
        return self.arbitrate(told, flies or first, asked)

    def _estimate(
        self, told: Mapping[str, Hypothesis], name: str, R: Mat3, omega: Vec3, shift: Shift
    ) -> Estimate:
        """What a hypothesis believes, with the tilt of the autopilot (MRS eq. 12–14)."""
        x, h = told[name].x, told[name].h
        worlds = {
            k: self.shift_between(other, told[name]) for k, other in told.items() if other.reliable
        }
        turn = Shift(np.zeros(3), float(h[0]) - heading(R))
        attitude = moved(Attitude(0.0, R), turn).R
        return Estimate(x[:, 0], x[:, 1], x[:, 2], attitude, omega, name, shift, worlds)

    def reframe(self, memory: Flying, shift: Shift) -> Flying:
        """The same beliefs, all told in worlds that are moved alike."""
        bank = self.filters.reframe(memory.bank, shift)
        told = {name: _moved_hypothesis(x, shift) for name, x in memory.told.items()}
        back = inverse(shift)  # the worlds of the others are moved, too
        worlds = {k: compose(shift, compose(x, back)) for k, x in memory.last.worlds.items()}
        last = moved(memory.last, shift)._replace(worlds=worlds)
        R = about_z(shift.heading) @ memory.R
        return memory._replace(bank=bank, told=told, last=last, R=R)

    def hypotheses(self, memory: Flying) -> Mapping[str, Hypothesis]:
        """What each filter believes, in its own world."""
        return memory.told


def _attitude(R: Mat3, omega: Vec3, readings: Readings, dt: float) -> tuple[Mat3, Vec3, Readings]:
    """Attitude of the autopilot (else of cameras) and angular velocity; and the readings with this attitude."""
    imu = readings.get("imu")
    if isinstance(imu, Imu) and np.isfinite(imu.gyro).all():
        omega = imu.gyro
        R = R @ exp(omega * dt)
    seen = readings.get("ahrs") or readings.get("mocap")
    if isinstance(seen, Attitude | Pose) and np.isfinite(seen.R).all():
        R = seen.R
        readings = {**readings, "attitude": Attitude(seen.t, seen.R)}
    return R, omega, readings


def _carried(last: Estimate, omega: Vec3, dt: float) -> Estimate:
    """The last estimate `dt` [s] later, when nobody has anything to say but the gyro."""
    attitude = last.R if omega is last.omega else last.R @ exp(omega * dt)
    return last._replace(r=last.r + last.v * dt, R=attitude, omega=omega)


def _as_hypothesis(estimate: Estimate) -> Hypothesis:
    """An estimate as a hypothesis that is not reliable."""
    x = np.stack([estimate.r, estimate.v, estimate.a], axis=1)
    h = np.array([heading(estimate.R), 0.0])
    return Hypothesis(x, np.tile(np.eye(3), (3, 1, 1)), h, np.eye(2), 1.0, False)


def _moved_hypothesis(x: Hypothesis, shift: Shift) -> Hypothesis:
    """A hypothesis in a world that was moved. Both horizontal axes have one covariance: a turn leaves it as it is."""
    rows = about_z(shift.heading) @ x.x
    rows[:, 0] += shift.r
    h = np.array([heading(about_z(x.h[0] + shift.heading)), x.h[1]])
    return x._replace(x=rows, h=h)
