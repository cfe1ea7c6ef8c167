"""The plain pilot: one tracker and one controller, or slots of them, and nobody who watches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from uavlab.errors import BadInput
from uavlab.frames import Shift
from uavlab.interfaces import Event, Goal, Memory, Readings, Report
from uavlab.orders import ORDERS, Order, Unheard, Use
from uavlab.parts.slot import FIRST, TAKEN, Slot
from uavlab.types import Command, Estimate, Reference


class Paired(NamedTuple):
    """Memory of a `Pair`."""

    t: float  # [s] since init
    tracking: Memory
    controlling: Memory
    events: tuple[Event, ...]


@dataclass(frozen=True)
class Pair:
    """A tracker and a controller. Of all orders it knows another part in a slot; unheard, it keeps its last goal."""

    tracker: Any
    controller: Any

    def init(self, estimate: Estimate, ground: bool) -> Paired:
        """Both begin at the estimate."""
        first = [
            Event(0.0, kind, part.first or next(iter(part.parts)), FIRST)
            for kind, part in (("tracker", self.tracker), ("controller", self.controller))
            if isinstance(part, Slot)
        ]
        tracking = self.tracker.init(estimate, None)
        return Paired(0.0, tracking, self.controller.init(estimate, None), tuple(first))

    def step(
        self,
        memory: Paired,
        estimate: Estimate,
        readings: Readings,
        asked: Sequence[Goal | Order],
        dt: float,
    ) -> tuple[Paired, Reference, Command]:
        """One tick of `dt` [s].

        Raises
        ------
        BadInput
            An order that needs a pilot who can do more.
        """
        t, tracking, controlling, events = memory
        goal, uses = None, {}
        for one in asked:
            if isinstance(one, Use) and one.slot in {"tracker", "controller"}:
                uses[one.slot] = one.name
            elif isinstance(one, Unheard):
                continue  # it has no other plan than its last goal
            elif isinstance(one, ORDERS):
                raise BadInput(
                    f"{one!r} is an order, and nobody here can obey it; fly with uavlab.piloted(...)."
                )
            else:
                goal = one
        doing = "tracker"
        try:
            tracking = _asked(self.tracker, tracking, uses.get("tracker"), estimate)
            tracking, reference = self.tracker.step(tracking, estimate, goal, dt)
            doing = "controller"
            controlling = _asked(self.controller, controlling, uses.get("controller"), estimate)
            controlling, command = self.controller.step(controlling, estimate, reference, dt)
        except Exception as error:
            error.add_note(doing)  # the loop says who it was
            raise
        for slot, now in (("tracker", tracking), ("controller", controlling)):
            if slot in uses:
                outcome = f"refused: {now.said}" if now.said else TAKEN
                events = (*events, Event(round(t, 9), slot, uses[slot], outcome))
        return Paired(t + dt, tracking, controlling, events), reference, command

    def reframe(self, memory: Paired, shift: Shift) -> Paired:
        """Both, told in the new world."""
        return memory._replace(
            tracking=self.tracker.reframe(memory.tracking, shift),
            controlling=self.controller.reframe(memory.controlling, shift),
        )

    def report(self, memory: Paired) -> Report:
        """Who took over, and when."""
        return Report("", memory.events)


def _asked(part: Any, memory: Memory, name: str | None, estimate: Estimate) -> Memory:
    if name is None:
        return memory
    if not isinstance(part, Slot):
        raise BadInput(f"{name!r} is to take over, but {type(part).__name__} flies alone.")
    return part.swap(memory, name, estimate)
