"""Hovers on an estimate that is wrong by a known error, under MPC and under SE(3): the flights of 000-5 and 000-6."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple, final

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.flight.fly import fly
from uavlab.flight.log import Log
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import Shift
from uavlab.gains import gains_for
from uavlab.interfaces import Readings, Stack
from uavlab.limits import ForceLimits
from uavlab.parts.missions import Waypoints
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import World, load_airframe
from uavlab.types import Array, Command, Estimate, Hypothesis, Mat3

NAME = "T650"
GAINS = gains_for(NAME, "soft")  # the paper does not say with which gains it flew
LIMITS = ForceLimits()  # 2 m/s, 2 m/s², 5 m/s³, as printed
CONTROLLERS = ("MPC", "SE(3)")
TOLD = "MPC, mass known"  # the MPC controller without its estimate of the mass
HEIGHT = 50.0  # [m]: whatever happens, the ground is no part of it
RATE = 100.0  # [Hz] of estimate and control
JUMP, AT = 5.0, 2.0  # [m] along x, and [s] when


@final
class Truth(NamedTuple):
    """An instrument that knows everything."""

    def init(self, rng: np.random.Generator) -> None:
        """It remembers nothing."""
        return

    def step(
        self, memory: None, world: World, dt: float, rng: np.random.Generator
    ) -> tuple[None, Estimate]:
        """The true state, at each tick."""
        return memory, Estimate(world.r, world.v, world.a, world.R, world.omega)


@dataclass(frozen=True)
class Mistaken:
    """The truth with a known error in position and velocity: nothing is filtered, and nobody is told of a shift.

    The last error stays when there are no more.
    """

    slot: ClassVar[str] = "estimator"
    error: Array  # (n, 6), at each tick: position [m] and velocity [m/s], world

    def init(self, estimate: Estimate) -> int:
        """How many ticks have passed: none."""
        return 0

    def step(
        self, memory: int, readings: Readings, command: Command, dt: float
    ) -> tuple[int, Estimate]:
        """The truth of this tick, and its error."""
        true: Any = readings["truth"]
        off = self.error[min(memory, len(self.error) - 1)]
        return memory + 1, true._replace(r=true.r + off[:3], v=true.v + off[3:])

    def reframe(self, memory: int, shift: Shift) -> int:
        """Nothing of it depends on the world: its errors are not of the aircraft's making."""
        return memory

    def hypotheses(self, memory: int) -> dict[str, Hypothesis]:
        """It has one belief only."""
        return {}


def noise(seed: int, sigma: Array, axes: int = 2, hold: int = 1) -> Array:
    """White noise of standard deviations `sigma` (n,) [m] and [m/s] in position and velocity, shape (n, 6).

    Parameters
    ----------
    seed : int
        Of the noise.
    sigma : Array
        (n,) at each tick.
    axes : int
        Along x, y and z (3), or along x and y only (2).
    hold : int
        For how many ticks a sample stays.
    """
    draws = np.random.default_rng([seed, 12]).normal(size=(-(-len(sigma) // hold), 2, 3))
    draws[:, :, axes:] = 0.0
    return sigma[:, None] * np.repeat(draws, hold, axis=0)[: len(sigma)].reshape(-1, 6)


def jump() -> Array:
    """Nothing until the jump along x, and the jump from then on, shape (n, 6), position [m]."""
    error = np.zeros((round(AT * RATE) + 1, 6))
    error[-1, 0] = JUMP
    return error


# Flights -----------------------------------------------------------------------------------------------


def controller(name: str) -> Any:
    """One of the controllers, as the reference answers them."""
    mass = float(load_airframe(NAME).m)
    if name == "MPC":
        return answer("mpc", "MpcController")(mass=mass, limits=LIMITS)
    if name == TOLD:
        mpc = controller("MPC")
        return replace(mpc, gains=mpc.gains._replace(k_m=0.0))
    return answer("geometric", "GeometricController")(mass=mass, gains=GAINS)


def flown(name: str, error: Array, end: float) -> Log:
    """A hover under one of the controllers, with these errors (n, 6) in its estimate; every safety is off."""
    place = (0.0, 0.0, HEIGHT)
    hover = Scenario(
        "hover on a wrong estimate", "", NAME, Waypoints(((0.0, place, 0.0),)), standing(place), end,
        {"truth": Truth()},
    )  # fmt: skip
    return fly(hover, Stack(Mistaken(error), CommandFilter(), controller(name)))


def turn_gains(name: str) -> tuple[float, float, float]:
    """Gains on the rotation error [1/s], body, of one of the controllers."""
    return controller(name).gains.k_R


def lean(R: Mat3) -> Array:
    """By how much the thrust axes of `R` (N, 3, 3) lean along x and along y [rad], shape (N, 2)."""
    return np.arctan2(R[:, :2, 2], R[:, 2, 2, None])


def asked_axis(log: Log, name: str) -> Array:
    """Thrust axis, body, that the controller asked for at each tick, shape (N, 3).

    In a hover with a constant heading its roll and pitch rates are −k_R e_R (MRS eq. 25) and nothing else, and e_R
    is e3 × b_3d (MRS eq. 24) as long as no yaw is missing.
    """
    e = log.omega_d[:, :2] / -np.array(turn_gains(name))[:2]
    x, y = -e[:, 1], e[:, 0]
    z = np.sqrt(np.clip(1.0 - x * x - y * y, 0.0, None))
    return np.column_stack((x, y, z))
