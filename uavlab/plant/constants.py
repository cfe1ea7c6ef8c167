"""What the compiled world must know of an airframe: floats, tuples and arrays, no names."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from uavlab.errors import BadInput
from uavlab.plant.airframe import Airframe
from uavlab.plant.jit import kernel
from uavlab.plant.vectors import M, V, three
from uavlab.types import Array


class Constants(NamedTuple):
    """Numbers of an airframe, as the compiled functions see them."""

    m: float  # [kg]
    thrust_coefficient: float  # [N s²/rad²]
    thrust_min: float  # of one rotor [N]
    thrust_max: float  # [N]
    motor_tau: float  # [s]
    drag_body: float  # [N s²/m²]
    drag_rotor: float  # [1/√m]
    rate_gain: V  # [1/s]
    J: M  # [kg m²]
    J_inv: M  # [1/(kg m²)]
    allocation: Array  # (4, n) rotor thrusts → (f, τ)
    mixer: Array  # (n, 4) (f, τ) → rotor thrusts


def pack(airframe: Airframe) -> tuple[Array, Array, Array]:
    """The constants of an airframe as three arrays: numbers (28,), allocation (4, n), mixer (n, 4).

    The mixer is the least-norm inverse of the allocation.

    Raises
    ------
    BadInput
        A number is not finite, or mass, motor lag or thrust coefficient are not positive.
    """
    parts = {name: np.ravel(getattr(airframe, name)) for name in Constants._fields[:-2]}
    parts["allocation"] = np.array(airframe.allocation, dtype=float, order="C")
    for name, value in parts.items():
        if not np.isfinite(value).all():
            raise BadInput(f"{airframe.name}: {name} is {value.tolist()}; it must be finite.")
    for name in ("m", "motor_tau", "thrust_coefficient"):
        if not parts[name][0] > 0.0:
            raise BadInput(f"{airframe.name}: {name} is {parts[name][0]:g}; it must be > 0.")
    allocation = parts.pop("allocation")
    numbers = np.concatenate(list(parts.values()))
    return numbers, allocation, np.ascontiguousarray(np.linalg.pinv(allocation))


@kernel
def unpacked(numbers: Array, allocation: Array, mixer: Array) -> Constants:
    """The constants that `pack` made into arrays."""
    return Constants(
        numbers[0],
        numbers[1],
        numbers[2],
        numbers[3],
        numbers[4],
        numbers[5],
        numbers[6],
        three(numbers, 7),
        (three(numbers, 10), three(numbers, 13), three(numbers, 16)),
        (three(numbers, 19), three(numbers, 22), three(numbers, 25)),
        allocation,
        mixer,
    )
