"""What the compiled world must know of an airframe: floats and arrays, no names."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.plant.airframe import Airframe
from uavlab.types import Array, Mat3, Vec3


class Constants(NamedTuple):
    """Numbers of an airframe, in the form that kernels take."""

    m: float  # [kg]
    J: Mat3  # (3, 3) [kg m²]
    J_inv: Mat3  # (3, 3) [1/(kg m²)]
    allocation: Array  # (4, n) rotor thrusts → (f, τ)
    mixer: Array  # (n, 4) (f, τ) → rotor thrusts
    rate_gain: Vec3  # (3,) [1/s]
    thrust_coefficient: float  # [N s²/rad²]
    thrust_min: float  # of one rotor [N]
    thrust_max: float  # [N]
    motor_tau: float  # [s]
    drag_body: float  # [N s²/m²]
    drag_rotor: float  # [1/√m]


def constants(airframe: Airframe) -> Constants:
    """The constants of an airframe; its mixer is the least-norm inverse of its allocation.

    Raises
    ------
    BadInput
        A number of the airframe is not finite, or mass, inertia or motor lag are not positive.
    """
    made = Constants(
        mixer=np.linalg.pinv(airframe.allocation),
        **{name: getattr(airframe, name) for name in Constants._fields if name != "mixer"},
    )
    values = {k: np.array(v, dtype=float, order="C") for k, v in made._asdict().items()}
    for name, value in values.items():
        if not np.isfinite(value).all():
            raise BadInput(f"{airframe.name}: {name} is {value.tolist()}; it must be finite.")
    for name in ("m", "motor_tau", "thrust_coefficient"):
        if not values[name] > 0.0:
            raise BadInput(f"{airframe.name}: {name} is {values[name]:g}; it must be > 0.")
    return Constants(**{k: v if v.ndim else float(v) for k, v in values.items()})
