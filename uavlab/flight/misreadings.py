"""Misreadings: what faults make of readings on their way from the instruments to the mind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from uavlab.flight.fault import Fault
from uavlab.so3 import exp

KINDS = ("lost", "frozen", "jump", "bias", "late")
TURNED = ("R", "b")  # fields that are turned, not added to


class Misreadings:
    """The faults of the instruments in one flight, with what a fault must remember of readings.

    Of one instrument an error comes first, then it freezes, then the line loses or holds back what it sends. Readings
    that a late line still holds when it is quick again are overtaken, and never arrive.
    """

    def __init__(self, faults: tuple[Fault, ...]) -> None:
        self.faults = tuple(x for x in faults if x.kind in KINDS)
        self.told: dict[
            str, Any
        ] = {}  # what arrived last, by instrument, of those that freeze one day
        self.under_way: dict[str, list[tuple[float, Any]]] = {}  # (when it arrives [s], reading)

    def arrived(self, readings: Mapping[str, Any], t: float) -> Mapping[str, Any]:
        """The readings that the mind gets at time `t` [s]."""
        if not self.faults:
            return readings
        out = dict(readings)
        for kind in ("jump", "bias", "frozen", "lost", "late"):
            for fault in self.faults:
                if fault.kind == kind:
                    getattr(self, f"_{kind}")(fault, out, t)
        return out

    def _jump(self, fault: Fault, out: dict[str, Any], t: float) -> None:
        if fault.name in out and fault.lasts(t):
            out[fault.name] = wrong(out[fault.name], fault.of, fault.value)

    def _bias(self, fault: Fault, out: dict[str, Any], t: float) -> None:
        if fault.name in out and fault.lasts(t):
            grown = np.asarray(fault.value, dtype=float) * (t - fault.t)
            out[fault.name] = wrong(out[fault.name], fault.of, grown)

    def _frozen(self, fault: Fault, out: dict[str, Any], t: float) -> None:
        new = out.get(fault.name)
        if new is None:
            return
        if fault.lasts(t) and fault.name in self.told:
            out[fault.name] = self.told[fault.name]._replace(t=new.t)
        else:
            self.told[fault.name] = new

    @staticmethod
    def _lost(fault: Fault, out: dict[str, Any], t: float) -> None:
        if fault.lasts(t):
            out.pop(fault.name, None)

    def _late(self, fault: Fault, out: dict[str, Any], t: float) -> None:
        queue = self.under_way.setdefault(fault.name, [])
        if not fault.lasts(t):
            queue.clear()
            return
        if (new := out.pop(fault.name, None)) is not None:
            queue.append((t + float(fault.value), new))
        if queue and queue[0][0] <= t + 1e-9:
            out[fault.name] = queue.pop(0)[1]


def wrong(reading: Any, field: str, by: Any) -> Any:
    """The reading with an error in one field.

    Parameters
    ----------
    reading : Reading
        Any of `uavlab.types`.
    field : str
        Of the reading; empty: the first one that is measured.
    by : number or array
        Added to the field, in its unit. An attitude is turned by the rotation vector `by` (3,) [rad], world, and
        bearings by one in the body; a number turns about z.
    """
    field = field or next(
        x for x in reading._fields[1:] if not isinstance(getattr(reading, x), bool)
    )
    value, by = getattr(reading, field), np.asarray(by, dtype=float)
    if field in TURNED:
        turn = exp(by if by.ndim else np.array((0.0, 0.0, float(by))))
        return reading._replace(**{field: turn @ value if field == "R" else value @ turn.T})
    new = value + by
    return reading._replace(**{field: new if np.ndim(value) else float(new)})
