"""An aircraft that is where its reference is: to ask a pilot what it decides, without a flight."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

import uavlab
from uavlab.area import Area
from uavlab.interfaces import standing_command
from uavlab.managers.safety import Safety
from uavlab.so3 import about_z
from uavlab.types import Estimate

DT = 0.02
ZERO = np.zeros(3)
PARTS = ("CommandFilter", "TiltAxis")
SQUARE = Area(((-10.0, -10.0), (10.0, -10.0), (10.0, 10.0), (-10.0, 10.0)), 0.5, 8.0)

LEVEL = Safety(tilt_error=np.inf)  # a ghost does not lean


def believing(r=(0.0, 0.0, 2.0), v=(0.0, 0.0, 0.0), heading=0.0, **more):
    return Estimate(np.array(r, float), np.array(v, float), ZERO, about_z(heading), ZERO, **more)


class Ghost:
    """It believes what it is told to; else it is at its reference."""

    def __init__(self, *parts, start=None, ground=False, airframe="T650", **pilot):
        pilot = {"safety": LEVEL, **pilot}
        self.pilot: Any = uavlab.piloted(airframe, *(parts or PARTS), **pilot).pilot
        self.estimate = start or believing((0.0, 0.0, 0.0) if ground else (0.0, 0.0, 2.0))
        self.memory = self.pilot.init(self.estimate, ground)
        self.references = []

    def tick(self, *asked, readings=None, **belief):
        self.estimate = self.estimate._replace(**belief)
        self.memory, reference, self.command = self.pilot.step(
            self.memory, self.estimate, readings or {}, list(asked), DT
        )
        self.references.append(reference)
        if not belief:
            self.estimate = self.estimate._replace(
                r=reference.r, v=reference.v, R=about_z(reference.heading)
            )
        return self.command

    def fly(self, seconds, *asked, always=(), **more):
        for k in range(round(seconds / DT)):
            self.tick(*(asked if k == 0 else ()), *always, **more)
        return self

    @property
    def report(self):
        return self.pilot.report(self.memory)

    @property
    def reference(self):
        return self.references[-1]

    def said(self, *kinds):
        return [tuple(x[1:]) for x in self.report.events if not kinds or x.kind in kinds]

    @property
    def flies(self):
        return self.memory.tracking.name, self.memory.controlling.name

    def way(self):
        return np.array([x.r for x in self.references])


@dataclass(frozen=True)
class Fails:
    """A part that goes wrong when a goal or the time says so."""

    slot: str
    how: str  # raises, nan, unfinished
    after: int = 5
    limits: ClassVar[Any] = None

    def init(self, estimate, last):
        return (0, last, estimate)

    def step(self, memory, estimate, given, dt):
        k, last, first = memory
        if k >= self.after:
            if self.how == "raises":
                raise RuntimeError("out of order")
            if self.how == "unfinished":
                raise NotImplementedError("step is not finished yet")
        out = standing_command(3.5)
        if self.slot == "tracker":
            from uavlab.parts.pace import beginning

            out = beginning(first, last)
        if k >= self.after:
            out = out._replace(
                **({"r": out.r * np.nan} if self.slot == "tracker" else {"f_d": np.nan})
            )
        return (k + 1, last, first), out

    def reframe(self, memory, shift):
        return memory
