"""The mind in flight: estimator, mission and pilot, each with its memory, and which of them is at work."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from uavlab.flight.injected import Injected
from uavlab.flight.scenario import Scenario, Swap
from uavlab.frames import compose, inverse, moved
from uavlab.interfaces import Event, Goal, Report, Stack, standing_command
from uavlab.managers.pair import Pair
from uavlab.orders import ORDERS, Order, Unheard, Use
from uavlab.parts.slot import FIRST, TAKEN
from uavlab.types import Command, Estimate, Hypothesis, Reference, Shift


class Mind:
    """The stack and its memories in flight."""

    def __init__(self, parts: Stack, scenario: Scenario, mass: float, faults: Injected) -> None:
        parts = faults.minds(parts)
        self.estimator, self.mission, self.faults = parts.estimator, scenario.mission, faults
        self.pilot: Any = parts.pilot or Pair(parts.tracker, parts.controller)
        self.every = round(scenario.rate / scenario.mission_rate)
        self.doing = "start"
        self.to_come = sorted(scenario.swaps, key=lambda x: x.t)
        self.events: list[Event] = []  # of the estimator, whom no pilot flies
        r, v, R, omega = scenario.start
        self.believed = self.estimate = Estimate(r, v, np.zeros(3), R, omega)
        self.command = standing_command(mass)
        self.estimating = self.estimator.init(self.estimate)
        self.piloting = self.pilot.init(self.estimate, bool(r[2] == 0.0))
        self.pursuing = self.mission.init(self.estimate)
        if first := getattr(self.estimator, "first_name", ""):
            self.events.append(Event(0.0, "estimator", first, FIRST))
        self._hear(0.0)

    def think(
        self, tick: int, readings: Mapping[str, Any], dt: float
    ) -> tuple[Estimate, Reference, Command]:
        """One tick: estimate, what is asked, reference, command."""
        t = tick * dt
        asked = self._due(t)
        self.doing = "estimator"
        if tick:  # at the first tick the estimate is the start itself
            was = self.believed.shift
            self.estimating, self.believed = self.estimator.step(
                self.estimating, readings, self.command, dt
            )
            if self.believed.shift is not was:
                self._reframe(compose(self.believed.shift, inverse(was)))
            self._hear(t)
        estimate = self.estimate = self.faults.estimate(self.believed, t)
        self.doing = "mission"
        if tick % self.every == 0:
            self.pursuing, goal = self.mission.step(self.pursuing, estimate, self.every * dt)
            if goal is not None:
                asked.append(goal)
        if not self.faults.linked(t):
            asked = [Unheard()]
        self.doing = "pilot"
        asked = [x for x in asked if not self._for_estimator(x, t)]
        self.piloting, reference, self.command = self.pilot.step(
            self.piloting, estimate, readings, asked, dt
        )
        return estimate, reference, self.command

    def hypotheses(self) -> Mapping[str, Hypothesis]:
        """What each filter of a bank believes now; nothing for a single one."""
        return self.estimator.hypotheses(self.estimating)

    def report(self) -> Report:
        """What the pilot does, and what happened until now."""
        report = self.pilot.report(self.piloting)
        return report._replace(events=tuple(sorted((*self.events, *report.events), key=_time)))

    def _due(self, t: float) -> list[Goal | Order]:
        """The swaps of the scenario whose time has come."""
        due: list[Swap] = []
        while self.to_come and self.to_come[0].t <= t + 1e-9:
            due.append(self.to_come.pop(0))
        return [Use(x.slot, x.name) for x in due]

    def _for_estimator(self, asked: Goal | Order, t: float) -> bool:
        """Obey what concerns the estimator; whether it did."""
        if not (isinstance(asked, ORDERS) and isinstance(asked, Use) and asked.slot == "estimator"):
            return False
        swap = getattr(self.estimator, "swap", None)
        said = "refused: this estimator hears no requests"
        if swap is not None:
            try:
                self.estimating, said = swap(self.estimating, asked.name), TAKEN
            except Exception as error:  # whatever it raises, the old one can fly on
                said = f"refused: {error}"
        self.events.append(Event(t, "estimator", asked.name, said))
        return True

    def _hear(self, t: float) -> None:
        """What became of the members of an estimator that is several, unasked for."""
        news = getattr(self.estimator, "news", None)
        for name, said in news(self.estimating) if news is not None else ():
            self.events.append(Event(t, "estimator", name, said))

    def _reframe(self, shift: Shift) -> None:
        """The estimator tells its world anew: whatever else remembers a place is told it, too (MRS Sec. 3.5)."""
        self.pursuing = self.mission.reframe(self.pursuing, shift)
        self.piloting = self.pilot.reframe(self.piloting, shift)
        self.command = moved(self.command, shift)


def _time(event: Event) -> float:
    return event.t
