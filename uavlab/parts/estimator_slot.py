"""A slot of estimators: all of them run, one is told; another is told in mid-flight, and nothing is felt.

MRS Sec. 3.5 does this with the filters of one bank. Here the members may be anything that estimates, banks too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.errors import BadInput, UnknownName
from uavlab.frames import NO_SHIFT, Shift, compose, heading, inverse, moved, wrap
from uavlab.interfaces import Estimator, Memory, Readings
from uavlab.parts.slot import TAKEN
from uavlab.so3 import about_z, exp
from uavlab.types import Attitude, Command, Estimate, Hypothesis, Imu, Pose


class Parallel(NamedTuple):
    """Memory of an `EstimatorSlot`."""

    name: str  # whose estimate is told
    memories: Mapping[str, Memory]  # of all
    own: Mapping[str, Estimate]  # what each estimated last, in its own world
    last: Estimate  # as it was told
    asked: str = ""  # who is to be told from the next step on; empty: nobody else
    dropped: Mapping[str, str] = {}  # who runs no more, and why
    news: tuple[tuple[str, str], ...] = ()  # (name, what became of it) in the last step, unasked


class _Unfit(Exception):
    """What a member gave is no estimate."""


@dataclass(frozen=True)
class EstimatorSlot:
    """An estimator that is several: by name, all of which run, and one of which is told.

    Each member has a world of its own: they begin in one, and drift apart as their instruments do. When another member
    is told, the estimate jumps into its world, and ``estimate.shift`` says by how much: the two poses of this tick are
    laid onto each other by position and heading. So whoever remembers a place is moved along (MRS Sec. 3.5), and an
    error of place or heading is what it was. Velocity, acceleration and tilt are the new member's.

    ``estimate.worlds`` has the way from the world of each reliable member to the one that is told, and from those
    of its hypotheses if it is a bank; of two by one name the member counts, then who is told. A bank that changes
    its own world says so; while it is told, so does the slot.

    A member that raises, or gives what is not finite, is dropped, and runs no more; the memory's ``dropped`` says why.
    If it was the one that is told, the first reliable one in the order of `parts` is told next. With nobody left the
    estimate goes on along its last velocity, and is not ``reliable``.

    Parameters
    ----------
    parts : mapping of str to Estimator
        By name, as a swap calls them.
    first : str, optional
        Who is told after ``init``; the first of `parts` if it is empty.

    Raises
    ------
    BadInput
        No parts, a name that is no text, or a part that is no estimator.
    UnknownName
        `first` is none of the parts.
    """

    slot: ClassVar[str] = "estimator"
    parts: Mapping[str, Estimator]
    first: str = ""

    def __post_init__(self) -> None:
        if not self.parts:
            raise BadInput("an EstimatorSlot got no parts; give it {'name': estimator, …}.")
        for name, part in self.parts.items():
            if not (isinstance(name, str) and name):
                raise BadInput(f"a part of an EstimatorSlot is named {name!r}; give it a text.")
            has = getattr(part, "slot", None)
            if has != "estimator":
                raise BadInput(
                    f"part {name!r} of an EstimatorSlot is {type(part).__name__} with slot {has!r}; "
                    "all of them must be estimators."
                )
        if self.first and self.first not in self.parts:
            raise UnknownName("part of the estimator's slot", self.first, self.parts)

    @property
    def first_name(self) -> str:
        """Who is told after ``init``."""
        return self.first or next(iter(self.parts))

    @property
    def names(self) -> tuple[str, ...]:
        """Whom a swap may name: the members, and the filters of those that are banks."""
        inner = [x for part in self.parts.values() for x in getattr(part, "names", ())]
        return tuple(dict.fromkeys([*self.parts, *inner]))

    def init(self, estimate: Estimate) -> Parallel:
        """All members continue from `estimate`, in its world."""
        memories: dict[str, Memory] = {}
        dropped = {}
        start = estimate._replace(reliable=True)  # some would repeat for ever what they were given
        for name, part in self.parts.items():
            try:
                memories[name] = part.init(start)
            except Exception as error:  # whatever it raises, the others can fly
                memories[name], dropped[name] = None, _why(error)
        own = {name: estimate._replace(reliable=name not in dropped) for name in self.parts}
        name = _who(self.first_name, "", own, dropped) or self.first_name
        news = tuple((x, f"dropped: {why}") for x, why in dropped.items())
        return Parallel(name, memories, own, estimate, dropped=dropped, news=news)

    def swap(self, memory: Parallel, name: str) -> Parallel:
        """Let `name` be told from the next step on.

        Parameters
        ----------
        memory : Parallel
            Of this slot.
        name : str
            A member; or a filter of the member that is told, if that is a bank: it is handed on.

        Returns
        -------
        Parallel
            The same member is told until the next step; ``asked`` says who is to come.

        Raises
        ------
        UnknownName
            Nobody has this name.
        BadInput
            The member was dropped, or nothing of late stands behind it.
        """
        if name in self.parts:
            if name in memory.dropped:
                raise BadInput(f"{name} runs no more: {memory.dropped[name]}.")
            if not memory.own[name].reliable:
                raise BadInput(f"{name} is not reliable now; ask again when it is.")
            return memory._replace(asked=name)
        if name not in self.names:
            raise UnknownName("part of the estimator's slot", name, self.names)
        part: Any = self.parts[memory.name]
        if name not in getattr(part, "names", ()):
            raise BadInput(
                f"{name} is no filter of {memory.name}, which is told; ask for its bank."
            )
        now = part.swap(memory.memories[memory.name], name)
        return memory._replace(memories={**memory.memories, memory.name: now})

    def step(
        self, memory: Parallel, readings: Readings, command: Command, dt: float
    ) -> tuple[Parallel, Estimate]:
        """One tick of `dt` [s] of every member, then the estimate of the one that is told."""
        memories, own, dropped = dict(memory.memories), dict(memory.own), dict(memory.dropped)
        for name in self.parts:
            if name in dropped:
                continue
            try:
                memories[name], own[name] = self._one(memory, name, readings, command, dt)
            except Exception as error:  # as above
                dropped[name] = _why(error)
                own[name] = memory.own[name]._replace(reliable=False)
        news = [(x, f"dropped: {y}") for x, y in dropped.items() if x not in memory.dropped]
        name = _who(memory.name, memory.asked, own, dropped)
        if name and name not in {memory.name, memory.asked}:
            news.append((name, TAKEN))
        estimate = self._told(memory, own, dropped, name, _carried(memory.last, readings, dt))
        return Parallel(
            name or memory.name, memories, own, estimate, "", dropped, tuple(news)
        ), estimate

    def _one(
        self, memory: Parallel, name: str, readings: Readings, command: Command, dt: float
    ) -> tuple[Memory, Estimate]:
        """One step of one member, which hears of the command in its own world."""
        if name != memory.name:
            turn = heading(memory.own[name].R) - heading(memory.last.R)
            command = moved(command, Shift(NO_SHIFT.r, turn))
        now, out = self.parts[name].step(memory.memories[name], readings, command, dt)
        if not isinstance(out, Estimate):
            raise _Unfit(f"it gave {type(out).__name__}, no Estimate")
        for field in ("r", "v", "a", "R", "omega"):
            if not np.isfinite(getattr(out, field)).all():
                raise _Unfit(f"its {field} is not finite")
        return now, out

    def _told(
        self,
        memory: Parallel,
        own: Mapping[str, Estimate],
        dropped: Mapping[str, str],
        name: str,
        here: Estimate,
    ) -> Estimate:
        """What goes out: the estimate of `name`, and how its world lies; `here` is the last one, carried on."""
        was, shift = memory.name, memory.last.shift
        if was not in dropped:
            here = own[was]
            shift = _along(shift, memory.own[was].shift, here.shift)
        if not name:
            return here._replace(worlds={}, reliable=False)
        there = own[name]
        if name != was:
            shift = compose(_between(here, there), shift)
        filters = getattr(self.parts[name], "names", ())  # of a bank; one of them is the world
        world = there.world if there.world in filters else name
        return there._replace(world=world, shift=shift, worlds=self._worlds(own, name))

    def _worlds(self, own: Mapping[str, Estimate], name: str) -> dict[str, Shift]:
        """From every world that is known to the one of member `name`."""
        there = own[name]
        ways = {k: _between(x, there) for k, x in own.items() if x.reliable and k != name}
        inner = {
            k: compose(way, one)
            for member, way in reversed(ways.items())
            for k, one in own[member].worlds.items()
        }
        here = {name: NO_SHIFT} if there.reliable else {}
        return {**inner, **there.worlds, **ways, **here}

    def reframe(self, memory: Parallel, shift: Shift) -> Parallel:
        """The same beliefs, all told in worlds that are moved alike."""
        memories = {
            name: x if x is None else self.parts[name].reframe(x, shift)
            for name, x in memory.memories.items()
        }
        own = {name: _retold(x, shift) for name, x in memory.own.items()}
        return memory._replace(memories=memories, own=own, last=_retold(memory.last, shift))

    def hypotheses(self, memory: Parallel) -> Mapping[str, Hypothesis]:
        """What each member believes, in its own world, without a covariance; of a bank, each of its filters."""
        found: dict[str, Hypothesis] = {}
        for name, part in self.parts.items():
            inner = memory.memories[name]
            filters = {} if inner is None else part.hypotheses(inner)
            for key, x in filters.items() or [(name, _as_hypothesis(memory.own[name]))]:
                alive = x.reliable and name not in memory.dropped
                if key == name or key not in self.parts:
                    found.setdefault(key, x._replace(reliable=alive))
        return found

    def news(self, memory: Parallel) -> tuple[tuple[str, str], ...]:
        """Who was dropped in the last step, and who took over from it: (name, what became of it)."""
        return memory.news


def _who(name: str, asked: str, own: Mapping[str, Estimate], dropped: Mapping[str, str]) -> str:
    """Who is told: who is asked, else who was, else the first of the rest; empty if nobody is left."""
    left = [x for x in own if x not in dropped]
    rest = sorted(left, key=lambda x: not own[x].reliable)  # the reliable ones first, else in order
    return next((x for x in (asked, name, *rest) if x in left), "")


def _why(error: Exception) -> str:
    return str(error) if isinstance(error, _Unfit) else f"it raised {type(error).__name__}: {error}"


def _between(a: Estimate, b: Estimate) -> Shift:
    """World of `a` → world of `b`, if both are of one aircraft at one time: place on place, heading on heading."""
    return compose(Shift(b.r, heading(b.R)), inverse(Shift(a.r, heading(a.R))))


def _along(shift: Shift, was: Shift, now: Shift) -> Shift:
    """`shift`, after a member told its world anew: it said `was` of it before, and says `now`."""
    if now is was or (now.heading == was.heading and np.array_equal(now.r, was.r)):
        return shift  # the same object: the loop looks whether it is
    return compose(compose(now, inverse(was)), shift)


def _carried(last: Estimate, readings: Readings, dt: float) -> Estimate:
    """The last estimate `dt` [s] later, when no member has anything to say: its motion goes on, it turns as is read.

    The gyro turns it; an attitude that is read has the last word on the tilt, and none on the heading.
    """
    omega, imu = last.omega, readings.get("imu")
    seen = readings.get("ahrs") or readings.get("mocap")
    if isinstance(imu, Imu) and np.isfinite(imu.gyro).all():
        omega = imu.gyro
    R = last.R @ exp(omega * dt)
    if isinstance(seen, Attitude | Pose) and np.isfinite(seen.R).all():
        R = about_z(wrap(heading(R) - heading(seen.R))) @ seen.R
    return last._replace(r=last.r + last.v * dt, R=R, omega=omega)


def _retold(x: Estimate, shift: Shift) -> Estimate:
    """An estimate whose world and all others are moved alike."""
    back = inverse(shift)
    worlds = {name: compose(shift, compose(one, back)) for name, one in x.worlds.items()}
    return moved(x, shift)._replace(worlds=worlds)


def _as_hypothesis(x: Estimate) -> Hypothesis:
    rows = np.stack([x.r, x.v, x.a], axis=1)
    h = np.array([heading(x.R), 0.0])
    return Hypothesis(rows, np.zeros((3, 3, 3)), h, np.zeros((2, 2)), 1.0, x.reliable)
