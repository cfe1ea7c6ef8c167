"""The world: what is true of the aircraft at one moment, and how a flight begins."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.plant.airframe import Airframe
from uavlab.so3 import check_rotation
from uavlab.types import GRAVITY, Array, Mat3, State, Vec3

SPEED = 21  # where the rotor speeds begin in the array that the compiled world writes


class World(NamedTuple):
    """The truth at time `t`. Made by a plant's ``init`` and ``advance``; its arrays are never written to again."""

    t: float  # [s]
    r: Vec3  # (3,) position [m], world
    v: Vec3  # (3,) velocity [m/s], world
    R: Mat3  # (3, 3) body → world
    omega: Vec3  # (3,) angular velocity [rad/s], body
    speed: Array  # (n,) of the rotors [rad/s]
    a: Vec3  # (3,) acceleration [m/s²], world, of gravity, thrust, drag and ground together
    contact: bool  # it stands on the ground, z = 0
    impact: float  # [m/s], speed of the hardest touch-down in the last `advance`; 0 without one

    @property
    def state(self) -> State:
        """The rigid body alone."""
        return State(self.r, self.v, self.R, self.omega)


def unpack(t: float, out: Array, contact: bool, impact: float) -> World:
    """The world from the array (21 + n,) that the compiled world writes: r, v, R, ω, a, rotor speeds.

    Parameters
    ----------
    t : float
        [s].
    out : Array
        Shape (21 + n,). The world looks into it.
    contact, impact : bool, float
        As in `World`.
    """
    R = out[6:15].reshape(3, 3)
    return World(t, out[0:3], out[3:6], R, out[15:18], out[SPEED:], out[18:SPEED], contact, impact)


def thrusts(world: World, airframe: Airframe) -> Array:
    """Thrust of each rotor [N], shape (n,)."""
    return airframe.thrust_coefficient * world.speed**2


def first_world(state: State, airframe: Airframe) -> World:
    """The world at t = 0: rotors at hover speed in the air, at rest on the ground.

    Parameters
    ----------
    state : State
        Where the aircraft is, in calm air. At z = 0 it stands on the ground and must be at rest.
    airframe : Airframe
        What it is.

    Raises
    ------
    BadInput
        A wrong shape, a number that is not finite, `state.R` is not a rotation, the aircraft is below the ground, or
        it stands on the ground and moves.
    """
    r, v = vector(state.r, "state.r"), vector(state.v, "state.v")
    omega = vector(state.omega, "state.omega")
    R = check_rotation(state.R, "state.R").copy()
    if r[2] < 0.0:
        raise BadInput(f"state.r is {r[2]:g} m below the ground; z must be ≥ 0.")
    contact = bool(r[2] == 0.0)
    if contact and (v.any() or omega.any()):
        raise BadInput(
            f"state stands on the ground (z = 0) with v = {v.tolist()} m/s and omega = {omega.tolist()} rad/s; "
            "let both be zero, or start above the ground."
        )
    hover = np.linalg.pinv(airframe.allocation)[:, 0] * airframe.m * GRAVITY
    speed = np.zeros(airframe.n) if contact else np.sqrt(hover / airframe.thrust_coefficient)
    world = World(0.0, r, v, R, omega, speed, np.zeros(3), contact, 0.0)
    if contact:
        return world
    f = float(airframe.allocation[0] @ thrusts(world, airframe))
    return world._replace(a=total_force(airframe, world.state, f, np.zeros(3)) / airframe.m)


def total_force(airframe: Airframe, state: State, f: float, wind: Vec3) -> Vec3:
    """All forces on the flying aircraft [N], world, (3,): thrust, drag of rotors and body, gravity.

    Rotors drag across their axis with the root of thrust (Bangura eq. 3), the body with the square of airspeed.

    Parameters
    ----------
    airframe : Airframe
        What it is.
    state : State
        How it moves.
    f : float
        Collective thrust [N].
    wind : Vec3
        Velocity of the air [m/s], world, (3,).
    """
    a = airframe
    air = state.v - wind
    V_B = state.R.T @ air
    k = a.drag_rotor * np.sqrt(a.m * max(f, 0.0))
    rotors = state.R @ np.array((-k * V_B[0], -k * V_B[1], f))
    return rotors - a.drag_body * np.linalg.norm(air) * air - np.array((0, 0, a.m * GRAVITY))


def vector(x: object, name: str) -> Vec3:
    """`x` as a fresh float64 array of shape (3,), or a `BadInput` that calls it `name`."""
    try:
        out = np.array(x, dtype=float)
    except (TypeError, ValueError):
        raise BadInput(f"{name} is {x!r}; three numbers are needed.") from None
    if out.shape != (3,):
        raise BadInput(f"{name} has shape {out.shape}; (3,) is needed.")
    if not np.isfinite(out).all():
        raise BadInput(f"{name} is {out.tolist()}; every entry must be finite.")
    return out
