"""The thrust curve of an aircraft, two numbers. What it makes of them is what lab 01 asks for, and not told here."""

from __future__ import annotations

from math import isfinite, sqrt
from typing import NamedTuple

from uavlab.errors import BadInput
from uavlab.types import GRAVITY


class ThrustCurve(NamedTuple):
    """T = a_t √f + b_t, with the throttle T in [0, 1] and the collective force f [N] (MRS eq. 32)."""

    a_t: float  # [1/√N], above 0
    b_t: float  # [1]


def checked(curve: ThrustCurve, mass: float) -> ThrustCurve:
    """The same curve, if an aircraft of this mass [kg] can hover on it.

    Raises
    ------
    BadInput
        A number is not finite, a_t is not above 0, the mass is not above 0, or hover is no throttle between 0 and 1.
    """
    a, b = curve
    if not (isfinite(a) and isfinite(b) and a > 0.0):
        raise BadInput(
            f"the thrust curve has a_t = {a}, b_t = {b}; a_t must be above 0, both finite."
        )
    if not (isfinite(mass) and mass > 0.0):
        raise BadInput(f"the mass is {mass} kg; it must be a finite number above 0.")
    hover = a * sqrt(mass * GRAVITY) + b
    if not 0.0 < hover < 1.0:
        raise BadInput(
            f"{mass:g} kg hover at throttle {hover:.3f} on this curve (a_t = {a:g}, b_t = {b:g}); it must lie "
            "between 0 and 1. Is the curve that of this aircraft, and of all rotors together?"
        )
    return curve
