"""The airframe: what an aircraft is made of, and what follows from it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.types import GRAVITY, Array, Mat3, Vec3


class Airframe(NamedTuple):
    """A multirotor: mass, rotors, drag and the gains of its embedded rate loop.

    `build_airframe` makes one from measured numbers and derives the rest; ``airframe._replace(m=1.9)`` changes one
    field and derives nothing.
    """

    name: str
    n: int  # number of rotors
    m: float  # mass [kg]
    J: Mat3  # (3, 3) inertia [kg m²], body
    J_inv: Mat3  # (3, 3) [1/(kg m²)], body
    arm: float  # rotor axis to centre [m]
    angles: Array  # (n,) of the rotors [rad], from body x, counter-clockwise seen from above
    spins: Array  # (n,) +1 or −1: the sign of the torque about body z that the rotor's drag leaves on the airframe
    torque_ratio: float  # c: that torque per thrust [m]
    allocation: Array  # (4, n) rotor thrusts [N] → (f [N], τ [N m]), body
    thrust_coefficient: float  # thrust per squared speed [N s²/rad²]
    speed_min: float  # of a rotor [rad/s], when armed
    speed_max: float  # [rad/s]
    thrust_min: float  # of one rotor [N]
    thrust_max: float  # of one rotor [N]
    motor_tau: float  # time constant of rotor speed [s]
    a_t: float  # thrust curve T = a_t √f + b_t of the collective thrust f (MRS eq. 32) [1/√N]
    b_t: float  # [1]
    drag_body: float  # quadratic drag of the body: F = −drag_body |v| v [N s²/m²]
    drag_rotor: float  # c of Bangura eq. (3): a_xy = −c √(f/m) V_xy [1/√m]
    rate_gain: Vec3  # (3,) of the embedded rate loop, body axes [1/s]
    propeller_radius: float  # [m], for pictures


def build_airframe(
    name: str,
    *,
    mass: float,
    inertia: Array,
    arm: float,
    angles: Array,
    spins: Array,
    torque_ratio: float,
    thrust_coefficient: float,
    speed_min: float,
    speed_max: float,
    motor_tau: float,
    drag_body: float,
    drag_rotor: float,
    rate_gain: Vec3,
    propeller_radius: float = 0.1,
) -> Airframe:
    """An airframe from measured numbers, all SI and radians; what follows from them is derived.

    Parameters
    ----------
    name : str
        Its name.
    mass : float
        [kg].
    inertia : Array
        Diagonal (3,) or matrix (3, 3) [kg m²], body.
    arm : float
        Rotor axis to centre [m].
    angles : Array
        Of the rotors [rad], (n,), from body x, counter-clockwise.
    spins : Array
        (n,) of ±1. A rotor with spin +1 pushes the airframe counter-clockwise (torque +torque_ratio·thrust about
        body z); seen from above it turns clockwise itself.
    torque_ratio : float
        Drag torque per thrust of a rotor [m].
    thrust_coefficient : float
        Thrust per squared speed [N s²/rad²].
    speed_min, speed_max : float
        Of an armed rotor [rad/s].
    motor_tau : float
        Time constant [s].
    drag_body, drag_rotor : float
        [N s²/m²] and [1/√m], see `Airframe`.
    rate_gain : Vec3
        Of the embedded rate loop [1/s], (3,).
    propeller_radius : float
        [m], for pictures.

    Raises
    ------
    BadInput
        The rotors cannot make all of thrust, roll, pitch and yaw, or cannot carry the aircraft.
    """
    angles, spins = np.asarray(angles, dtype=float), np.asarray(spins, dtype=float)
    n = len(angles)
    if spins.shape != (n,) or not (np.abs(spins) == 1.0).all():
        raise BadInput(f"{name}: spins are {spins.tolist()}; one +1 or −1 for each of {n} angles.")
    places = arm * np.stack((np.cos(angles), np.sin(angles)), axis=1)
    J = np.diag(inertia) if np.ndim(inertia) == 1 else np.asarray(inertia, dtype=float)
    span = (speed_max - speed_min) * np.sqrt(n * thrust_coefficient)
    if not span > 0.0:
        raise BadInput(
            f"{name}: speed_max {speed_max:g} must exceed speed_min {speed_min:g} rad/s."
        )
    airframe = Airframe(
        name=name,
        n=n,
        m=float(mass),
        J=J,
        J_inv=np.linalg.inv(J),
        arm=float(arm),
        angles=angles,
        spins=spins,
        torque_ratio=float(torque_ratio),
        allocation=_allocation(places, torque_ratio * spins),
        thrust_coefficient=float(thrust_coefficient),
        speed_min=float(speed_min),
        speed_max=float(speed_max),
        thrust_min=float(thrust_coefficient * speed_min**2),
        thrust_max=float(thrust_coefficient * speed_max**2),
        motor_tau=float(motor_tau),
        a_t=float(1.0 / span),  # T = (speed − min) / (max − min) and f = n k speed²
        b_t=float(-speed_min / (speed_max - speed_min)),
        drag_body=float(drag_body),
        drag_rotor=float(drag_rotor),
        rate_gain=np.asarray(rate_gain, dtype=float),
        propeller_radius=float(propeller_radius),
    )
    for value in airframe:
        if isinstance(value, np.ndarray):
            value.setflags(write=False)
    _check_flyable(airframe)
    return airframe


def _allocation(places: Array, yaw: Array) -> Array:
    """Rotor thrusts → thrust and torque (4, n), for upright rotors at `places` (n, 2) [m] (Spica eq. 1).

    A thrust f at (x, y) turns by (y f, −x f); `yaw` (n,) [m] is what each rotor's drag adds per thrust.
    """
    return np.stack((np.ones(len(yaw)), places[:, 1], -places[:, 0], yaw))


def _check_flyable(airframe: Airframe) -> None:
    """Refuse rotors that cannot steer or cannot carry."""
    name, n = airframe.name, airframe.n
    rank = np.linalg.matrix_rank(airframe.allocation, tol=1e-6)
    if rank < 4:
        raise BadInput(
            f"{name}: its {n} rotors span only {rank} of (thrust, roll, pitch, yaw). It takes at least four "
            "rotors, not all on one line, with both spins."
        )
    each = np.linalg.pinv(airframe.allocation)[:, 0] * airframe.m * GRAVITY
    if not ((each > airframe.thrust_min) & (each < airframe.thrust_max)).all():
        raise BadInput(
            f"{name}: hover needs rotor thrusts {each.round(3).tolist()} N, "
            f"allowed {airframe.thrust_min:.3f} to {airframe.thrust_max:.3f} N each. Change mass or rotors."
        )
