"""The Phantom 4 flights, their inertial units aligned: what the experiments on real drag start from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.datasets.alignment import Alignment, align, averaged
from uavlab.datasets.phantom import DotImu, RtkTrack
from uavlab.types import Array

FLIGHTS = ("horizontal-8", "horizontal-12", "horizontal-22", "line-1", "vertical-1")
UNITS = (1, 2)
WINDOW = 0.5  # [s] over which specific force and velocity are averaged: rotors shake the unit at 1 m/s² and more
EXCITED = (
    1.0  # [m/s] standard deviation of a velocity, from which its axis says something of the drag
)


class Flown(NamedTuple):
    """One unit on one flight, told in the body at the times of the track."""

    flight: str
    unit: int
    alignment: Alignment
    t: Array  # (N,) [s], the track's clock
    accel: Array  # (N, 3) specific force [m/s²], body, mean over the window
    V: Array  # (N, 3) velocity over ground by RTK [m/s], body, mean over the window

    @property
    def name(self) -> str:
        """Flight and unit."""
        return f"{self.flight}/{self.unit}"

    @property
    def root(self) -> Array:
        """(N, 2) −a/√a_z [√(m/s²)] along body x and y: what the drag model says is c V + ε (Bangura V-A)."""
        return -self.accel[:, :2] / np.sqrt(self.accel[:, 2:])


def flown(track: RtkTrack, imu: DotImu, flight: str = "", unit: int = 1) -> Flown:
    """Align `imu` with `track`; specific force and velocity as means over the window, body axes of the aircraft."""
    found = align(track, imu)
    half = WINDOW / 2
    t = track.t - found.lag
    there = (t > imu.t[0] + half) & (t < imu.t[-1] - half)
    there &= (track.t > track.t[0] + half) & (track.t < track.t[-1] - half)
    at = track.t[there]
    accel = averaged(imu.t, imu.accel, at - found.lag, WINDOW) @ found.M.T
    ends = [
        np.stack([np.interp(at + side * half, track.t, x) for x in track.r.T], axis=1)
        for side in (1, -1)
    ]
    v = (ends[0] - ends[1]) / WINDOW
    V = np.einsum("nji,nj->ni", track.R[there], v)
    return Flown(flight, unit, found, at, accel, V)


def all_flown() -> list[Flown]:
    """Every unit on every flight."""
    from uavlab.datasets import fetch, read_dot, read_rtk

    out = []
    for flight in FLIGHTS:
        track = read_rtk(fetch(f"phantom4-{flight}"))
        for unit in UNITS:
            imu = read_dot(fetch(f"phantom4-{flight}/IMU_{unit}"))
            out.append(flown(track, imu, flight, unit))
    return out


def pooled(those: list[Flown]) -> float:
    """One c [1/√m] for both axes of all, each flight and axis with its own offset; quiet axes hardly weigh."""
    V = np.concatenate([(x.V[:, :2] - x.V[:, :2].mean(axis=0)).ravel() for x in those])
    y = np.concatenate([(x.root - x.root.mean(axis=0)).ravel() for x in those])
    return float(V @ y / (V @ V))


def offsets(those: list[Flown], c: float) -> Array:
    """(n, 2) offsets ε of each flight and axis, if the drag coefficient is `c` [1/√m]."""
    return np.array([x.root.mean(axis=0) - c * x.V[:, :2].mean(axis=0) for x in those])
