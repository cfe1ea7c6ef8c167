"""A random flight: aircraft, safety area with a no-fly zone, errand in it, wind, instruments, and what breaks."""

from __future__ import annotations

from math import cos, inf, pi, sin
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from uavlab.area import Area, NoFly
from uavlab.campaigns.breaks import fault
from uavlab.flight.scenario import Scenario, standing
from uavlab.interfaces import Goal
from uavlab.orders import Land, LandHome, LandThere, Order, TakeOff, Use, Velocity
from uavlab.parts.bank import MEMBERS
from uavlab.parts.errands import Errand, Wait
from uavlab.parts.missions import still
from uavlab.plant import Wind, load_airframe
from uavlab.plant.wind import low_altitude
from uavlab.sensors import Magnetometer, earth_field, laboratory, survey
from uavlab.sources import NORTH
from uavlab.types import Trajectory, Vec3

_Range: TypeAlias = tuple[float, float]


class Ranges(NamedTuple):
    """From what flights are drawn."""

    airframes: tuple[str, ...] = ("T650", "F450", "X500", "F550")
    ground: float = 0.6  # share of the flights that begin on the ground; the others hover at 2 m
    survey: float = 0.3  # share that flies on a bank of filters; the others are in a laboratory
    members: tuple[str, ...] = ("gnss", "rtk", "slam", "flow")  # of a bank: two or three of them
    spare: float = 0.5  # share that has a second estimator aboard
    corners: int = 5  # of the border
    radius: _Range = (7.0, 12.0)  # [m] from home to the border's corners
    high: _Range = (4.0, 6.0)  # [m] of the area
    low: float = 0.5  # [m]
    margin: float = 0.5  # [m]
    zone: _Range = (3.5, 6.0)  # [m] from home to the middle of the no-fly zone
    width: _Range = (0.6, 1.5)  # [m], half of its width
    wind: _Range = (0.0, 5.0)  # [m/s], mean at 5 m, with the gusts that belong to it
    rise: _Range = (0.8, 1.8)  # [m], to which it takes off
    goals: tuple[int, int] = (1, 2)
    reach: float = 1.3  # goals lie within so many radii: some outside
    patience: float = 3.0  # [s] for a goal; then comes the next one
    wait: _Range = (1.0, 2.0)  # [s] behind a velocity
    speed: float = 2.0  # [m/s], largest velocity that is asked for
    faults: tuple[int, int] = (1, 3)
    after: float = 16.0  # [s] that are left to come down
    stay: float = 3.0  # [s] of an errand that does not end with a landing


RANGES = Ranges()
KINDS = ("goal", "goal", "velocity", "trajectory", "use")  # what is asked for under way
SWITCHED = (
    ("limits", "slow"),
    ("limits", "fast"),
    ("gains", "tight"),
    ("controller", "MpcController"),
)
ENDS = ("land", "home", "there", "stay")


class Drawn(NamedTuple):
    """A flight, and who estimates in it."""

    scenario: Scenario
    members: tuple[
        str, ...
    ]  # of the bank, the first of which is asked for; none: the cameras of a laboratory
    spare: bool  # whether a second estimator runs beside it
    kinds: tuple[str, ...]  # of what is asked, in a word


def drawn(seed: int, salt: int = 0) -> Drawn:
    """The flight of a seed."""
    rng = np.random.default_rng([salt, seed])
    name = str(rng.choice(RANGES.airframes))
    ground = bool(rng.random() < RANGES.ground)
    area = _area(rng)
    errand, kinds, end = _errand(rng, ground, area)
    kit, members = _kit(rng)
    last = RANGES.stay if kinds[-1] == "stay" else RANGES.after
    n = int(rng.integers(RANGES.faults[0], RANGES.faults[1] + 1))
    airframe = load_airframe(name)
    faults = tuple(fault(rng, airframe, sorted(kit), end) for _ in range(n))
    scenario = Scenario(
        f"faults-{seed}", "A random flight with random faults.", name, errand,
        standing((0.0, 0.0, 0.0 if ground else 2.0)), end + last, kit, _wind(rng),
        reach=100.0, faults=faults, area=area,
    )  # fmt: skip
    return Drawn(scenario, members, bool(rng.random() < RANGES.spare), kinds)


def _area(rng: np.random.Generator) -> Area:
    """A border about home, and a zone in it that does not reach home."""
    n = RANGES.corners
    angles = 2 * pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    radii = rng.uniform(*RANGES.radius, n)
    border = np.round(np.column_stack((radii * np.cos(angles), radii * np.sin(angles))), 2)
    at, away = 2 * pi * rng.random(), rng.uniform(*RANGES.zone)
    half, turn = rng.uniform(*RANGES.width), 2 * pi * rng.random()
    corners = turn + pi / 4 + pi / 2 * np.arange(4)
    zone = np.column_stack((
        away * cos(at) + half * 2**0.5 * np.cos(corners),
        away * sin(at) + half * 2**0.5 * np.sin(corners),
    ))
    high = round(float(rng.uniform(*RANGES.high)), 2)
    tall = inf if rng.random() < 0.5 else 0.5 * high
    return Area(
        border, RANGES.low, high, (NoFly(np.round(zone, 2), high=tall, name="tower"),), RANGES.margin
    )  # fmt: skip


def _errand(
    rng: np.random.Generator, ground: bool, area: Area
) -> tuple[Errand, tuple[str, ...], float]:
    """What is asked, in steps and in words, and when the last of it is asked at the latest [s]."""
    steps: list[Goal | Order | Wait] = []
    kinds: list[str] = []
    t = 0.0
    if ground:
        height = round(float(rng.uniform(*RANGES.rise)), 2)
        steps, t = [Wait(0.2), TakeOff(height)], 3.0 + height
    for _ in range(int(rng.integers(RANGES.goals[0], RANGES.goals[1] + 1))):
        kinds.append(str(rng.choice(KINDS)))
        steps.append(_asked(rng, kinds[-1], area))
        wait = round(float(rng.uniform(*RANGES.wait)), 2)
        steps += [Wait(wait)] if kinds[-1] == "velocity" else []
        t += {"velocity": wait, "use": 0.0}.get(kinds[-1], RANGES.patience)
    kinds.append(str(rng.choice(ENDS)))
    there = 0.5 * _place(rng, area) * (1.0, 1.0, 0.0)
    last: dict[str, Goal | Order] = {
        "land": Land(), "home": LandHome() if ground else LandThere(np.zeros(3), 0.0),
        "there": LandThere(there, 0.0), "stay": still(np.array((0.0, 0.0, 2.0))),
    }  # fmt: skip
    return Errand((*steps, last[kinds[-1]]), RANGES.patience), tuple(kinds), max(round(t, 2), 2.0)


def _asked(rng: np.random.Generator, kind: str, area: Area) -> Goal | Order:
    if kind == "velocity":
        angle, speed = 2 * pi * rng.random(), RANGES.speed * rng.random()
        v = speed * np.array((cos(angle), sin(angle), 0.3 * (2 * rng.random() - 1)))
        return Velocity(v, *([2.0] if rng.random() < 0.5 else []))
    if kind == "trajectory":
        return _trajectory(rng, area)
    if kind == "use":
        return Use(*SWITCHED[int(rng.integers(len(SWITCHED)))])
    return still(_place(rng, area), float(rng.uniform(-pi, pi)))


def _trajectory(rng: np.random.Generator, area: Area) -> Trajectory:
    """Three random places, at a speed that can be flown."""
    r = np.array([0.8 * _place(rng, area) for _ in range(3)])
    r[:, 2] += 0.5
    gaps = np.linalg.norm(np.diff(r, axis=0), axis=1) / 1.2
    return Trajectory(np.concatenate(([1.0], 1.0 + np.cumsum(gaps))), r, np.zeros(3))


def _place(rng: np.random.Generator, area: Area) -> Vec3:
    """A random place (3,) [m]; some are outside."""
    angle, away = 2 * pi * rng.random(), RANGES.reach * RANGES.radius[0] * rng.random() ** 0.5
    return np.array((away * cos(angle), away * sin(angle), rng.uniform(0.6, 1.1 * area.high)))


def _kit(rng: np.random.Generator) -> tuple[dict[str, Any], tuple[str, ...]]:
    """Instruments, and the filters that are made of them."""
    if rng.random() >= RANGES.survey:
        return laboratory(), ()
    some = rng.permutation(RANGES.members)[: int(rng.integers(2, 4))]
    members = tuple(str(x) for x in some)
    heard = {source.partition(".")[0] for name in members for source in MEMBERS[name]}
    north = Magnetometer(field=earth_field(azimuth=NORTH))
    kit = {**survey(), "magnetometer": north}
    return {name: x for name, x in kit.items() if name in heard | {"imu", "ahrs"}}, members


def _wind(rng: np.random.Generator) -> Wind:
    angle, speed = 2 * pi * rng.random(), float(rng.uniform(*RANGES.wind))
    return low_altitude(speed * np.array((cos(angle), sin(angle), 0.0)), 5.0)
