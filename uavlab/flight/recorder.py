"""The recorder: arrays that a flight fills tick by tick, cut to what was flown at its end."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from typing import Any

import numpy as np

from uavlab.flight.log import UNITS, Log
from uavlab.flight.worlds import room
from uavlab.plant import thrusts
from uavlab.types import Command, Estimate, Exit, Hypothesis, Reference, Vec3

_SHAPES = {
    "t": (), "R": (3, 3), "R_e": (3, 3), "heading_d": (), "heading_rate_d": (), "f_d": (), "solve": (),
}  # fmt: skip


class Recorder:
    """Room for a number of ticks. The one mutable thing in the loop."""

    def __init__(self, ticks: int, airframe: Any, hypotheses: tuple[str, ...] = ()) -> None:
        self.airframe = airframe
        shapes = {**_SHAPES, "rotors": (airframe.n,)}
        self.rows = {name: np.zeros((ticks, *shapes.get(name, (3,)))) for name in UNITS}
        self.worlds = room(ticks, hypotheses)
        self.flown = 0
        self.time = 0.0

    def __len__(self) -> int:
        return len(self.rows["t"])

    def write(
        self,
        tick: int,
        world: Any,
        wind: Vec3,
        estimate: Estimate,
        reference: Reference,
        command: Command,
        solve: float,
    ) -> None:
        """One tick: what is true, believed, wanted and asked."""
        rows = self.rows
        rows["t"][tick] = self.time = float(world.t)
        rows["r"][tick], rows["v"][tick], rows["a"][tick] = world.r, world.v, world.a
        rows["R"][tick], rows["omega"][tick], rows["wind"][tick] = world.R, world.omega, wind
        rows["rotors"][tick] = thrusts(world, self.airframe)
        rows["r_e"][tick], rows["v_e"][tick], rows["R_e"][tick] = estimate.r, estimate.v, estimate.R
        rows["r_d"][tick], rows["v_d"][tick] = reference.r, reference.v
        rows["a_d"][tick], rows["heading_d"][tick] = reference.a, reference.heading
        rows["heading_rate_d"][tick] = reference.heading_rate
        rows["f_d"][tick], rows["omega_d"][tick] = command.f_d, command.omega_d
        rows["solve"][tick] = solve
        self.flown = tick + 1

    def believe(self, tick: int, estimate: Estimate, believed: Mapping[str, Hypothesis]) -> None:
        """One tick of worlds: which one the estimate is told in, and what each hypothesis believes."""
        w = self.worlds
        w.shift_r[tick], w.shift_heading[tick] = estimate.shift
        for k, name in enumerate(w.names):
            x = believed[name]
            w.r[tick, k], w.v[tick, k] = x.x[:, 0], x.x[:, 1]
            w.std[tick, k] = np.sqrt(x.P[:, 0, 0])
            w.heading[tick, k], w.heading_std[tick, k] = x.h[0], sqrt(x.P_h[0, 0])
            w.nis[tick, k], w.reliable[tick, k] = x.nis, x.reliable
            if name == estimate.world:
                w.flies[tick] = k

    def log(self, exit_: Exit, reason: str, meta: dict[str, Any]) -> Log:
        """The log of what was flown."""
        cut = {name: rows[: self.flown] for name, rows in self.rows.items()}
        worlds = self.worlds.cut(self.flown)
        return Log(**cut, exit=exit_, reason=reason, meta=meta, worlds=worlds)
