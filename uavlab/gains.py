"""Sets of gains that have flown, each with its source. Forces in N, lengths in m, angles in rad, tuples of x, y, z.

The gains on position and velocity of the MRS controllers are of acceleration: their code multiplies them by the mass.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, radians
from typing import NamedTuple

from uavlab.errors import BadInput, UnknownName

Triple = tuple[float, float, float]

TILT_MAX = radians(60.0)  # [rad], the limit of every constraint group of MRS
RATE_MAX: Triple = (60.0, 60.0, 10.0)  # [rad/s], likewise, of all but the slow group of 2020


class GeometricGains(NamedTuple):
    """Gains and limits of the geometric controller (MRS Sec. 5.1–5.6)."""

    k_p: Triple  # (3,) [1/s²] on position; times the mass in the force
    k_v: Triple  # (3,) [1/s] on velocity; times the mass
    k_R: Triple  # (3,) [1/s] on the rotation error, body
    k_iw: float  # [N/(m s)] of the disturbance that stays in the world, horizontal
    k_ib: float  # [N/(m s)] of the disturbance that turns with the heading, horizontal
    k_m: float  # [kg/(m s)] of the mass on the height error
    d_max: float  # [N] largest disturbance of each kind along each axis
    m_max: float  # [kg] largest difference from the mass that was told
    tilt_max: float = TILT_MAX  # [rad] of the force
    rate_max: Triple = RATE_MAX  # (3,) [rad/s] of the command, body
    source: str = ""


class MpcGains(NamedTuple):
    """What the MPC controller of MRS has beside its QPs: attitude, disturbances, mass (MRS Sec. 5.7)."""

    k_R: Triple = (5.0, 5.0, 5.0)  # (3,) [1/s] on the rotation error, body
    k_iw: float = 0.1  # [N/(m s)] of the disturbance that stays in the world, horizontal
    k_ib: float = 0.1  # [N/(m s)] of the disturbance that turns with the heading, horizontal
    k_m: float = 0.5  # [kg/(m s)] of the mass on the height error
    d_max: float = 10.0  # [N] largest disturbance of each kind along each axis
    m_max: float = 5.0  # [kg] largest difference from the mass that was told
    tilt_max: float = TILT_MAX  # [rad] of the force
    rate_max: Triple = RATE_MAX  # (3,) [rad/s] of the command, body
    source: str = "mrs_uav_controllers, 2020, MpcController"
    follows: bool = False  # plan along the velocity of the reference, as newer software does; not asked for in lab 06


class TorqueGains(NamedTuple):
    """Gains of the position loop, Spica eq. (4), and of the attitude loop, Spica eq. (5), for the MK-Quadro.

    The paper prints none; these are ours. With the lag of its motors (0.047 s) the tilt has a pole pair at 8.5 rad/s of
    damping 0.55, the yaw one at 5 rad/s of damping 0.8, and the position is damped by 0.5.
    """

    k_p: Triple = (4.0, 4.0, 6.0)  # (3,) [N/m] on position; not times the mass
    k_ip: Triple = (1.0, 1.0, 1.5)  # (3,) [N/(m s)] on its integral
    k_v: Triple = (3.7, 3.7, 5.0)  # (3,) [N s/m] on velocity
    k_R: Triple = (0.51, 0.51, 0.37)  # (3,) [N m] on the rotation error
    k_iR: Triple = (0.1, 0.1, 0.05)  # (3,) [N m/s] on its integral
    k_omega: Triple = (0.108, 0.108, 0.148)  # (3,) [N m s] on angular velocity
    source: str = "ours: Spica prints none"


MPC_GAINS: Mapping[str, MpcGains] = {
    "2020": MpcGains(),
    "now": MpcGains(
        (5.0, 5.0, 1.0), k_m=0.5, m_max=20.0, source="mrs_uav_controllers, now, MpcController"
    ),
}


def _group(
    p: float, v: float, z: tuple[float, float], tilt: float, yaw: float,
    i: float, m: tuple[float, float], source: str,
) -> GeometricGains:  # fmt: skip
    """One row of the controllers' files: horizontal gains, vertical ones, and so on; both integrals have one gain."""
    return GeometricGains(
        (p, p, z[0]), (v, v, z[1]), (tilt, tilt, yaw), i, i, m[0], 10.0, m[1], source=source
    )


_CODE = "mrs_uav_controllers, Se3Controller, "
_SIM, _REAL = f"{_CODE}2020, T650 in simulation, ", f"{_CODE}2020, T650 outdoors, "
_F450, _F550 = f"{_CODE}2022, F450 in simulation, ", f"{_CODE}2022, F550 in simulation, "
_T18 = f"{_CODE}T18 outdoors, "
_NOW = f"{_CODE}now, all aircraft, "

# set → group → gains, softest first
GROUPS: Mapping[str, Mapping[str, GeometricGains]] = {
    "now": {
        "supersoft": _group(3, 2, (15, 8), 5, 5, 0.1, (0.5, 20), f"{_NOW}supersoft"),
        "soft": _group(6, 4, (15, 8), 5, 5, 0.1, (0.5, 20), f"{_NOW}soft"),
    },
    "2020": {"default": _group(3, 2, (8, 5), 5, 5, 0.1, (1, 3), f"{_CODE}2020, all aircraft")},
    "T650-sim-2020": {
        "supersoft": _group(3, 2, (10, 5), 5, 2, 0.5, (1, 6), f"{_SIM}supersoft"),
        "soft": _group(4, 3, (10, 5), 5, 2, 0.7, (1, 6), f"{_SIM}soft"),
        "tight": _group(6, 4, (10, 5), 5, 2, 1.0, (1, 6), f"{_SIM}tight"),
    },
    "T650-real-2020": {
        "supersoft": _group(6, 3, (5, 4), 8, 8, 0.3, (0.5, 6), f"{_REAL}supersoft"),
        "soft": _group(8, 3, (8, 4), 8, 8, 0.7, (0.5, 6), f"{_REAL}soft"),
        "tight": _group(12, 3, (10, 4), 8, 8, 1.0, (0.5, 6), f"{_REAL}tight"),
    },
    "F450-sim-2022": {
        "supersoft": _group(4, 2, (8, 5), 5, 5, 0.1, (1, 3), f"{_F450}supersoft"),
        "soft": _group(6, 4, (8, 5), 5, 5, 0.1, (1, 3), f"{_F450}soft"),
        "tight": _group(8, 6, (8, 5), 5, 5, 0.1, (1, 3), f"{_F450}tight"),
    },
    "F550-sim-2022": {
        "supersoft": _group(6, 4, (8, 5), 5, 5, 0.1, (1, 3), f"{_F550}supersoft"),
        "soft": _group(8, 6, (8, 5), 5, 5, 0.1, (1, 3), f"{_F550}soft"),
        "tight": _group(12, 8, (8, 5), 5, 5, 0.1, (1, 3), f"{_F550}tight"),
    },
    "T18-real": {
        "supersoft": _group(3, 2, (5, 4), 4, 8, 0.3, (2, 15), f"{_T18}supersoft"),
        "soft": _group(4, 3, (8, 4), 4, 8, 0.7, (2, 15), f"{_T18}soft"),
    },
}  # fmt: skip

# Which set an aircraft flies in simulation; the others fly "now".
OF_AIRFRAME: Mapping[str, str] = {
    "T650": "T650-sim-2020",
    "F450": "F450-sim-2022",
    "F550": "F550-sim-2022",
}


def mpc_gains_for(mass: float) -> MpcGains:
    """Gains of the MPC controller for an aircraft of this mass [kg].

    The plan may ask for no more than 2 m/s² upwards; what is learned of the mass while it is at that limit must be
    unlearned again. With 0.5 kg/(m s), as the software has it, an F450 of 1.7 kg learns so much on a take-off that it
    falls. A T650 of 3.5 kg flies well with it; a lighter one gets its share (ours).
    """
    most = MPC_GAINS["2020"]
    return most._replace(k_m=min(most.k_m, most.k_m * mass / 3.5))


def gain_group(gain_set: str, group: str) -> GeometricGains:
    """The gains of one group, such as ``gain_group("T650-sim-2020", "tight")``.

    Raises
    ------
    UnknownName
        There is no such set, or no such group in it.
    """
    if gain_set not in GROUPS:
        raise UnknownName("gain set", gain_set, GROUPS)
    if group not in GROUPS[gain_set]:
        raise UnknownName(f"gain group of {gain_set}", group, GROUPS[gain_set])
    return GROUPS[gain_set][group]


def gains_for(airframe: str, group: str) -> GeometricGains:
    """The gains of one group for an aircraft in simulation, by the name of its airframe.

    Raises
    ------
    UnknownName
        Its set has no such group.
    """
    return gain_group(OF_AIRFRAME.get(airframe, "now"), group)


def checked(gains: GeometricGains) -> GeometricGains:
    """These gains, if they can fly.

    Raises
    ------
    BadInput
        A gain or limit that is negative or not finite, three where one is asked for (or the other way round), or a
        tilt limit that is not between 0 and 90 degrees.
    """
    for name in ("k_p", "k_v", "k_R", "rate_max"):
        value = getattr(gains, name)
        if not (isinstance(value, tuple) and len(value) == 3 and all(map(_size, value))):
            raise BadInput(f"{name} is {value!r}; give three finite numbers of 0 or more.")
    for name in ("k_iw", "k_ib", "k_m", "d_max", "m_max"):
        if not _size(value := getattr(gains, name)):
            raise BadInput(f"{name} is {value!r}; give one finite number of 0 or more.")
    if not (_size(gains.tilt_max) and 0.0 < gains.tilt_max < radians(90.0)):
        raise BadInput(
            f"tilt_max is {gains.tilt_max!r} rad; it must lie between 0 and π/2: beyond, no thrust carries the weight."
        )
    return gains


def _size(x: object) -> bool:
    """Whether `x` is a finite number of 0 or more."""
    return isinstance(x, int | float) and not isinstance(x, bool) and isfinite(x) and x >= 0.0
