"""Worlds in a log: which hypothesis flew, where its world lay, and everything told again in the world of the start.

After a switch of filters the numbers of estimate and reference jump by metres, though nothing moved. `told` takes the
jumps out, so that a log can be held against the truth.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from uavlab.types import Array

if TYPE_CHECKING:
    from uavlab.flight.log import Log

# Unit and frame of every field of `Worlds`: written into the file of a log.
UNITS = {
    "flies": "index of the hypothesis that flies, −1: none of them",
    "shift_r": "m, world of the start → world of the estimate", "shift_heading": "rad",
    "r": "m, world of the hypothesis", "v": "m/s, world of the hypothesis",
    "std": "m, of each coordinate", "heading": "rad", "heading_std": "rad",
    "nis": "normalised innovation squared per degree of freedom", "reliable": "bool",
}  # fmt: skip


class Worlds(NamedTuple):
    """What the H hypotheses of a bank believed in N ticks, each in its own world. A single filter has H = 0."""

    names: tuple[str, ...]  # (H,)
    flies: Array  # (N,) index into `names`; −1 while none of them flies
    shift_r: Array  # (N, 3) [m] world of the start → world in which estimate and reference are told
    shift_heading: Array  # (N,) [rad]
    r: Array  # (N, H, 3) [m]
    v: Array  # (N, H, 3) [m/s]
    std: Array  # (N, H, 3) [m] standard deviation of the position
    heading: Array  # (N, H) [rad]
    heading_std: Array  # (N, H) [rad]
    nis: Array  # (N, H) about 1 when all is well
    reliable: Array  # (N, H) bool

    def cut(self, ticks: int) -> Worlds:
        """The first `ticks` ticks."""
        return Worlds._make([self.names, *(x[:ticks] for x in self[1:])])


def room(ticks: int, names: tuple[str, ...] = ()) -> Worlds:
    """Worlds of so many ticks in which nothing has happened yet."""
    n, h = ticks, len(names)
    return Worlds(
        names,
        flies=np.full(n, -1), shift_r=np.zeros((n, 3)), shift_heading=np.zeros(n),
        r=np.zeros((n, h, 3)), v=np.zeros((n, h, 3)), std=np.zeros((n, h, 3)),
        heading=np.zeros((n, h)), heading_std=np.zeros((n, h)), nis=np.zeros((n, h)),
        reliable=np.zeros((n, h), dtype=bool),
    )  # fmt: skip


NO_WORLDS = room(0)  # of a recording, which knows of one world only


def flown_by(log: Log) -> list[tuple[float, float, str]]:
    """Which hypothesis flew when: (from [s], until [s], name), in order; the name is "" while none of them did."""
    w = log.worlds
    if not len(w.flies):
        return []
    edges = np.flatnonzero(np.diff(w.flies)) + 1
    starts = [0, *edges.tolist()]
    ends = [*edges.tolist(), len(w.flies) - 1]
    return [
        (float(log.t[a]), float(log.t[b]), w.names[w.flies[a]] if w.flies[a] >= 0 else "")
        for a, b in zip(starts, ends, strict=True)
    ]


def told(log: Log) -> Log:
    """The same flight with estimate, reference and hypotheses told in the world in which it began.

    A hypothesis that flew is moved by the shifts of the times when it did, carried on to the times when it did not
    (backwards before the first). One that never flew is laid onto the estimate at the tick at which it was first
    reliable. So all of them agree at every switch, and what is seen is how they drift apart.

    Parameters
    ----------
    log : Log
        As flown. One that is told already comes back unchanged.
    """
    w = log.worlds
    if not len(w.flies):
        return log
    turn, r = w.shift_heading, w.shift_r
    if turn.any() or r.any():
        log = log._replace(
            r_e=_turned(log.r_e - r, -turn),
            v_e=_turned(log.v_e, -turn),
            R_e=_turned(np.swapaxes(log.R_e, 1, 2), -turn[:, None]).swapaxes(1, 2),
            r_d=_turned(log.r_d - r, -turn),
            v_d=_turned(log.v_d, -turn),
            a_d=_turned(log.a_d, -turn),
            heading_d=_wrapped(log.heading_d - turn),
        )
    return log._replace(worlds=_told_worlds(log))


def _told_worlds(log: Log) -> Worlds:
    """The hypotheses of a log whose estimate is told in the world of the start already."""
    w = log.worlds
    n, h = w.heading.shape
    lay_r, lay_turn = np.zeros((n, h, 3)), np.zeros((n, h))
    for k in range(h):
        ticks = np.flatnonzero(w.flies == k)
        if ticks.size:  # the last tick at which it flew, or the first one before that
            at = ticks[(np.searchsorted(ticks, np.arange(n), side="right") - 1).clip(0)]
            lay_r[:, k], lay_turn[:, k] = w.shift_r[at], w.shift_heading[at]
        elif w.reliable[:, k].any():
            i = int(np.argmax(w.reliable[:, k]))
            eta = np.arctan2(log.R_e[i, 1, 0], log.R_e[i, 0, 0])
            lay_turn[:, k] = w.heading[i, k] - eta
            lay_r[:, k] = w.r[i, k] - _turned(log.r_e[i], w.heading[i, k] - eta)
    still = room(n, w.names)
    return w._replace(
        shift_r=still.shift_r,
        shift_heading=still.shift_heading,
        r=_turned(w.r - lay_r, -lay_turn),
        v=_turned(w.v, -lay_turn),
        std=_turned_std(w.std, lay_turn),
        heading=_wrapped(w.heading - lay_turn),
    )


def _turned(x: Array, angle: Array) -> Array:
    """Vectors (..., 3) turned about z by angles (...) [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack(
        [c * x[..., 0] - s * x[..., 1], s * x[..., 0] + c * x[..., 1], x[..., 2]], axis=-1
    )


def _turned_std(std: Array, angle: Array) -> Array:
    """Standard deviations (..., 3) of axes that do not know of each other, seen along axes turned by `angle`."""
    c, s = np.cos(angle) ** 2, np.sin(angle) ** 2
    x, y = std[..., 0] ** 2, std[..., 1] ** 2
    return np.stack([np.sqrt(c * x + s * y), np.sqrt(s * x + c * y), std[..., 2]], axis=-1)


def _wrapped(angle: Array) -> Array:
    """Angles [rad] in [−π, π)."""
    return (angle + np.pi) % (2.0 * np.pi) - np.pi
