"""Lab 04, what the hidden checks of both velocity-aided filters share: cases, derivatives, and laws."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.expect import expect_record, expect_rotation
from uavlab.exercises.paths import FIELD, Path
from uavlab.exercises.spec import Function, expect, expect_close
from uavlab.types import (
    GRAVITY,
    NO_PULL,
    AidedGains,
    Array,
    BodyMemory,
    Imu,
    InertialMemory,
    Mat3,
    Pull,
    Vec3,
)

CANARY = "canary-60ad2235d08e66c447b7f9f9"

UP = np.array((0.0, 0.0, GRAVITY))  # [m/s²] specific force at rest
SMALL = 1e-7  # [s], a step for derivatives
QUICK = AidedGains(10.0, 0.3, 0.05, 30.0, 0.0, 0.2, 0.5)  # for flights of seconds


class Case(NamedTuple):
    """One call: a filter away from the truth, and what its instruments say."""

    x: Any  # BodyMemory or InertialMemory
    imu: Imu
    seen: Vec3  # (3,) measured velocity [m/s]
    m: Vec3  # (3,) magnetic field, body
    gains: AidedGains


class Rates(NamedTuple):
    """How fast a memory changes."""

    velocity: Vec3  # (3,) [m/s²]
    turn: Vec3  # (3,) angular velocity of the attitude [rad/s], body
    u: Array  # () [1/s]
    b_a: Vec3  # (3,) [m/s³]
    b_omega: Vec3  # (3,) [rad/s²]


def case(kind: Any, rng: np.random.Generator) -> Case:
    """Tilted up to 60 degrees, with any heading, and everything off."""
    R = draw.tilted(rng, 0.3, 1.0)
    x = kind(draw.vector(rng, 3.0), R, float(rng.uniform(0.8, 1.2)), *rng.normal(size=(2, 3)) * 0.2)
    imu = Imu(0.0, draw.vector(rng, 2.0) + UP, draw.vector(rng, 2.0))
    m = (R @ draw.tilted(rng, 0.2, 0.5)).T @ FIELD
    gains = AidedGains(*rng.uniform(0.5, 1.5, size=7) * (4.0, 0.05, 0.05, 5.0, 0.3, 0.05, 0.3))
    return Case(x, imu, x[0] + draw.vector(rng), m, gains)


def rates(
    f: Function, c: Case, *, seen: bool = True, m: bool = False, pull: Pull = NO_PULL
) -> Rates:
    """The derivative of the memory, from a tiny step; the magnetometer is off unless asked for."""
    given = c.seen if seen else None, c.m if m else None
    got = f(c.x, c.imu, *given, SMALL, m_W=FIELD, gains=c.gains, pull=pull)
    velocity, R, *rest = expect_record(got, (3,), (3, 3), (), (3,), (3,))
    turn = so3.log(c.x.R.T @ expect_rotation(R)) / SMALL
    others = [(y - x) / SMALL for x, y in zip(c.x[2:], rest, strict=True)]
    return Rates((velocity - c.x[0]) / SMALL, turn, *others)


def tilt(c: Case, e_W: Vec3) -> Vec3:
    """Δ^r of (7b), (10a), z up, for a velocity error told in the world."""
    return -GRAVITY / c.x.u * np.cross(e_W, np.eye(3)[2])


def compass(c: Case) -> Vec3:
    """Δ^μ of (7c), (10c) as a vector, body."""
    up = c.x.u * c.x.R[2]
    return c.gains.k_m * (np.cross(c.m, FIELD @ c.x.R) @ up) * up


def close(got: Array, want: Array) -> None:
    """Fail the check unless they agree as well as a derivative by differences can."""
    expect_close(got, want, atol=2e-4, rtol=1e-5)


def error(c: Case) -> tuple[Vec3, Vec3]:
    """The velocity error as it is told, and told in the world."""
    e = c.x[0] - c.seen
    return e, c.x.R @ e if isinstance(c.x, BodyMemory) else e


# Laws that both filters share, written once for each -----------------------------------------------------


def law_of_the_attitude(f: Function, rng: np.random.Generator, kind: Any) -> None:
    """The attitude turns with the unbiased gyro and by −k_r Δ^r."""
    for _ in range(3):
        c = case(kind, rng)
        _, e_W = error(c)
        want = c.imu.gyro - c.x.b_omega - c.gains.k_r * c.x.R.T @ tilt(c, e_W)
        close(rates(f, c).turn, want)


def law_of_the_compass(f: Function, rng: np.random.Generator, kind: Any) -> None:
    """Δ^μ turns the attitude, and −k_b_m Δ^μ the gyro bias."""
    for _ in range(2):
        c = case(kind, rng)
        with_it, without = rates(f, c, m=True), rates(f, c)
        close(with_it.turn - without.turn, compass(c))
        close(with_it.b_omega - without.b_omega, -c.gains.k_b_m * compass(c))
        _, e_W = error(c)
        close(without.b_omega, c.gains.k_b_omega * c.x.R.T @ tilt(c, e_W))


def law_of_the_biases(f: Function, rng: np.random.Generator, kind: Any) -> None:
    """Both biases follow their innovations, told in the body."""
    for _ in range(3):
        c = case(kind, rng)
        (_, e_W), got = error(c), rates(f, c)
        close(got.b_a, c.gains.k_b_a * c.gains.k_v * c.x.R.T @ e_W)
        close(got.b_omega, c.gains.k_b_omega * c.x.R.T @ tilt(c, e_W))


def law_of_the_scaling(f: Function, rng: np.random.Generator, kind: Any) -> None:
    """The scaling follows the vertical velocity error."""
    for _ in range(3):
        c = case(kind, rng)
        _, e_W = error(c)
        close(rates(f, c).u, np.array(c.gains.k_u * GRAVITY * e_W[2]))


def law_of_the_pull(f: Function, rng: np.random.Generator, kind: Any) -> None:
    """A pull is added, in its frame."""
    c, pull = case(kind, rng), Pull(*rng.normal(size=(3, 3)))
    pulled, free = rates(f, c, m=True, pull=pull), rates(f, c, m=True)
    close(pulled.velocity - free.velocity, pull.v_dot)
    close(pulled.turn - free.turn, c.x.R.T @ pull.turn)
    close(pulled.b_a - free.b_a, pull.b_a_dot)
    close(pulled.b_omega - free.b_omega, np.zeros(3))


def law_of_silence(f: Function, rng: np.random.Generator, kind: Any) -> None:
    """No measurement is like no error."""
    c = case(kind, rng)
    lost = rates(f, c, seen=False)
    agreed = rates(f, c._replace(seen=c.x[0]))
    for a, b in zip(lost, agreed, strict=True):
        close(a, b)
    close(lost.turn, c.imu.gyro - c.x.b_omega)
    close(np.hstack((lost.u, lost.b_a, lost.b_omega)), np.zeros(7))


def law_of_the_turned_world(f: Function, rng: np.random.Generator, kind: Any) -> None:
    """A turn about the vertical changes nothing but how things are told."""
    c, Rz = case(kind, rng), so3.about_z(draw.angle(rng))
    world = kind is InertialMemory
    turned = c.x._replace(R=Rz @ c.x.R)
    told = c.seen
    if world:
        turned, told = turned._replace(v=Rz @ c.x.v), Rz @ c.seen
    given = {"gains": c.gains, "pull": NO_PULL}
    one = f(c.x, c.imu, c.seen, c.m, 0.01, m_W=FIELD, **given)
    two = f(turned, c.imu, told, c.m, 0.01, m_W=Rz @ FIELD, **given)
    v, R, *rest = expect_record(one, (3,), (3, 3), (), (3,), (3,))
    v_2, R_2, *rest_2 = expect_record(two, (3,), (3, 3), (), (3,), (3,))
    expect(np.abs(np.hstack(rest) - np.hstack(c.x[2:])).max() > 1e-5, "Nothing is estimated.")
    expect_close(expect_rotation(R_2), Rz @ R)
    expect_close(v_2, Rz @ v if world else v)
    expect_close(np.hstack(rest_2), np.hstack(rest))


def flown(f: Function, kind: Any, path: Path, b_omega: Vec3) -> tuple[Any, Mat3]:
    """The memory after a flight of 3.6 s that was started 8 degrees off, and the true attitude."""
    dt, here = 0.03, path.at(0.0)
    start, zero = here.R @ so3.exp(np.array((0.1, -0.1, 0.0))), np.zeros(3)
    x = kind(here.R.T @ here.v if kind is BodyMemory else here.v, start, 1.0, zero, zero)
    for k in range(120):
        there = path.at((k + 1) * dt)
        accel = here.R.T @ ((there.v - here.v) / dt + UP)
        imu = Imu(k * dt, accel, so3.log(here.R.T @ there.R) / dt + b_omega)
        told = here.R.T @ here.v if kind is BodyMemory else here.v
        got = f(x, imu, told, here.R.T @ FIELD, dt, m_W=FIELD, gains=QUICK, pull=NO_PULL)
        v, R, u, b_a, b_w = expect_record(got, (3,), (3, 3), (), (3,), (3,))
        x, here = kind(v, expect_rotation(R), float(u), b_a, b_w), there
    return x, here.R


def law_of_the_flight_south(f: Function, rng: np.random.Generator, kind: Any) -> None:
    """Attitude and gyro bias are found with the nose turned round."""
    path = Path(rng, np.pi + float(rng.uniform(-0.3, 0.3)), lean=0.15)
    path.size *= 0.3
    bias = 0.1 * draw.direction(rng)
    x, R = flown(f, kind, path, bias)
    expect(so3.angle(x.R, R) < np.radians(5.0), "The attitude is not found.")
    expect_close(x.b_omega, bias, "The gyro bias is not found.", atol=0.05)
