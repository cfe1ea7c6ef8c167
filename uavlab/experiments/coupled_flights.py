"""The reference coupled filters along smooth flights: what the experiments on them share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.motion import (
    FIELD,
    PAPER_C,
    QUIET,
    Motion,
    Noise,
    instruments,
    motion,
    waves,
)
from uavlab.experiments.spec import Line, Panel
from uavlab.types import Array, Estimate

RATE = 100.0  # [Hz]; Bangura has 200, and the filters err alike there
SETTLED = 5.0  # [s] from where errors count


class Flown(NamedTuple):
    """A flight and what the filters made of it: estimates after a tick, the truth at the same time; M ticks."""

    t: Array  # (M,) [s]
    true: Motion
    V: Array  # (M, 3) velocity through the air, Filter 1 [m/s], body
    v: Array  # (M, 3) velocity over ground, Filter 2 [m/s], world
    w: Array  # (M, 3) wind [m/s], world
    R: Array  # (M, 3, 3) body → world
    u: Array  # (M, 2) scalings of both filters [1]

    @property
    def off(self) -> Array:
        """Error of the velocity through the air (M, 3) [m/s], body."""
        return self.V - self.true.V

    @property
    def turned(self) -> Array:
        """Error of the attitude (M,) [deg]."""
        cosine = 0.5 * (np.sum(self.R * self.true.R, axis=(1, 2)) - 1.0)
        return np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0)))


def filtered(
    true: Motion, rng: np.random.Generator, noise: Noise = QUIET, *, c: float = PAPER_C,
    off: tuple[float, float] | None = None, start: Estimate | None = None,
) -> Flown:  # fmt: skip
    """Run the reference filters along a flight, from its true start unless told otherwise.

    Parameters
    ----------
    true : Motion
        The flight.
    rng : numpy.random.Generator
        Of the instruments.
    noise : Noise
        Of the instruments.
    c : float
        Drag coefficient that the filter is told [1/√m].
    off : tuple, optional
        From when to when [s] there is no velocity over ground.
    start : Estimate, optional
        What the filters start from.
    """
    zero = np.zeros(3)
    coupled = answer("complementary", "CoupledFilter")(FIELD, c)
    memory = coupled.init(start or Estimate(true.r[0], true.v[0], zero, true.R[0], zero))
    out = []
    for readings in instruments(true, rng, noise, off):
        memory, estimate = coupled.step(memory, readings, None, true.dt)
        out.append(estimate)
    then = Motion(*(x[1:] for x in true))  # an estimate after a tick is one of the next
    V, v, w, R = (np.array([getattr(x, name) for x in out[:-1]]) for name in ("V", "v", "w", "R"))
    u = np.array([(x.u_1, x.u_2) for x in out[:-1]])
    return Flown(then.t, then, V, v, w, R, u)


def wandering(
    seed: int, seconds: float, speeds: Sequence[float], periods: Sequence[float], *,
    wind: Array | None = None, c: float = PAPER_C, parasitic: float = 0.0, rate: float = RATE,
) -> tuple[Motion, np.random.Generator]:  # fmt: skip
    """A smooth flight with these top speeds [m/s], from a start by chance; and the chance for its instruments."""
    rng = np.random.default_rng([2, seed])
    t = np.arange(0.0, seconds, 1.0 / rate)
    stretch = rng.uniform(0.85, 1.15, 3)
    path = waves(t, np.array(speeds), np.array(periods) * stretch, rng.uniform(0.0, 2 * np.pi, 3))
    heading = rng.uniform(-np.pi, np.pi) + 0.3 * np.sin(0.2 * t)
    if np.max(speeds) > 5.0:
        heading = heading - heading[0]  # the top speeds are told along body x and y
    air = np.zeros((len(t), 3)) if wind is None else wind
    return motion(t, path, heading, air, c, parasitic), rng


def errors(flights: Sequence[Flown]) -> tuple[Array, Array]:
    """Mean and standard deviation of |error| of V̂ along body x, y, z [m/s], (flights, 3) each, once settled."""
    off = [np.abs(x.off[x.t > SETTLED]) for x in flights]
    return np.array([x.mean(axis=0) for x in off]), np.array([x.std(axis=0) for x in off])


def speed_panels(one: Flown, said: str) -> tuple[Panel, ...]:
    """Velocities through the air, as Bangura's Figs 8 and 9(b)."""
    over_ground = np.einsum("nji,nj->ni", one.R, one.v)
    return tuple(
        Panel(f"V_{axis}: {said}", "time [s]", "velocity, body [m/s]", (
            Line("true", one.t, one.true.V[:, i], "truth"),
            Line("Filter 2, turned into the body", one.t, over_ground[:, i]),
            Line("Filter 1", one.t, one.V[:, i], "dashed")))
        for i, axis in enumerate("xyz")
    )  # fmt: skip


def scaling_panel(one: Flown, marks: tuple[tuple[float, str], ...] = ()) -> Panel:
    """Latent scalings, as Bangura's Fig. 9(a)."""
    ideal = np.ones(len(one.t))
    filters = (Line(f"Filter {i + 1}", one.t, one.u[:, i]) for i in range(2))
    lines = (Line("ideal", one.t, ideal, "truth"), *filters)
    return Panel("Latent scaling u: should stay within 0.9 to 1.1", "time [s]", "u", lines, marks)


def attitude_panel(one: Flown) -> Panel:
    """Errors of the attitude."""
    return Panel("Attitude error: band 2°", "time [s]", "error [deg]", (
        Line("Filter 2", one.t, one.turned), Line("band", one.t, np.full(len(one.t), 2.0), "paper")))  # fmt: skip
