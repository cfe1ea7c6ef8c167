"""A fault, as a line of a scenario."""

from __future__ import annotations

from typing import Any, NamedTuple


class Fault(NamedTuple):
    """Something breaks at `t`, and is whole again at `until`."""

    kind: str  # see `uavlab.flight.injected.KINDS`
    t: float  # [s]
    until: float = float("inf")  # [s]
    what: str = ""  # which instrument, slot or rotor
    value: Any = 0.0  # how much, in the unit of its kind
