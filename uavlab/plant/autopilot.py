"""The embedded autopilot, compiled: body-rate loop, mixer, and what gives way when motors saturate.

What is asked for but cannot be had is given up in this order: first yaw torque, then collective thrust, and roll and
pitch torque only when the rotors cannot make it at any thrust. An aircraft that keeps its tilt can be saved.
"""

from __future__ import annotations

from math import inf

from uavlab.plant.constants import Constants
from uavlab.plant.jit import kernel
from uavlab.plant.vectors import V, apply, cross, plus
from uavlab.types import Array


@kernel
def rate_loop(omega: V, omega_d: V, c: Constants) -> V:
    """Torque [N m], body: proportional on the rate error, with the gyroscopic torque fed forward (Spica eq. 5)."""
    wish = (
        c.rate_gain[0] * (omega_d[0] - omega[0]),
        c.rate_gain[1] * (omega_d[1] - omega[1]),
        c.rate_gain[2] * (omega_d[2] - omega[2]),
    )
    return plus(apply(c.J, wish), 1.0, cross(omega, apply(c.J, omega)))


@kernel
def mix(f: float, tau: V, c: Constants, out: Array) -> None:
    """Write into `out` (n,) the rotor thrusts [N] for thrust f and torque τ, or what the rotors can of them."""
    fits = True
    for i in range(out.size):
        P = c.mixer[i]
        out[i] = P[0] * f + (P[1] * tau[0] + P[2] * tau[1]) + P[3] * tau[2]
        fits = fits and c.thrust_min <= out[i] <= c.thrust_max
    if fits:
        return
    share = tilt_share(tau, c)
    f = nearest_thrust(f, share, tau, c)
    for i in range(out.size):
        out[i] = c.mixer[i, 0] * f + share * tilt_part(i, tau, c)
    share = yaw_share(tau[2], c, out)
    for i in range(out.size):
        asked = out[i] + share * c.mixer[i, 3] * tau[2]
        out[i] = min(max(asked, c.thrust_min), c.thrust_max)  # only rounding is left to clip


@kernel
def tilt_part(i: int, tau: V, c: Constants) -> float:
    """What roll and pitch torque ask of rotor i [N]."""
    return c.mixer[i, 1] * tau[0] + c.mixer[i, 2] * tau[1]


@kernel
def tilt_share(tau: V, c: Constants) -> float:
    """The largest share ≤ 1 of roll and pitch torque that fits at some thrust.

    It lifts rotor j above rotor i by no more than the limits are apart, for all pairs.
    """
    share = 1.0
    n = c.mixer.shape[0]
    for i in range(n):
        for j in range(n):
            p_i, p_j = c.mixer[i, 0], c.mixer[j, 0]
            if p_i <= 0.0 or p_j <= 0.0:
                continue
            gap = tilt_part(j, tau, c) / p_j - tilt_part(i, tau, c) / p_i
            room = max(c.thrust_max / p_j - c.thrust_min / p_i, 0.0)
            if share * gap > room:
                share = room / gap
    return share


@kernel
def nearest_thrust(f: float, share: float, tau: V, c: Constants) -> float:
    """The collective thrust nearest to f [N] that leaves every rotor inside its limits."""
    low, high = -inf, inf
    for i in range(c.mixer.shape[0]):
        p = c.mixer[i, 0]
        if p > 0.0:
            q = share * tilt_part(i, tau, c)
            low = max(low, (c.thrust_min - q) / p)
            high = min(high, (c.thrust_max - q) / p)
    return min(max(f, low), high)


@kernel
def yaw_share(tau_z: float, c: Constants, base: Array) -> float:
    """The largest share ≤ 1 of yaw torque that fits on top of the thrusts `base` (n,) [N]."""
    share = 1.0
    for i in range(base.size):
        q = c.mixer[i, 3] * tau_z
        if q > 0.0 and share * q > c.thrust_max - base[i]:
            share = max(c.thrust_max - base[i], 0.0) / q
        elif q < 0.0 and share * q < c.thrust_min - base[i]:
            share = min(c.thrust_min - base[i], 0.0) / q
    return share
