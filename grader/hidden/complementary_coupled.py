"""Lab 04, hidden checks of the coupled pair: wind, drop-out and return, a lost magnetometer, another world."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from grader.material import hidden
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.complementary import CoupledFilter
from uavlab.exercises.complementary_checks import FAST, expect_coupled
from uavlab.exercises.paths import FIELD, Blown
from uavlab.exercises.spec import Function, expect, expect_close
from uavlab.frames import moved
from uavlab.interfaces import Reading
from uavlab.types import GRAVITY, CoupledEstimate, Estimate, Field, Fix, Height, Imu, Shift

CANARY = "canary-eb9f2d06b9bdcaca3cd4fb2f"

DT = 0.03  # [s]
CALM = FAST.body._replace(k_v=12.0, k_r=0.03)  # the wind of the start hardly tilts it
NAN = np.full(3, np.nan)


def blown(rng: np.random.Generator, low: float = 1.0, high: float = 2.0) -> Blown:
    """A flight in a steady horizontal wind of `low` to `high` [m/s], with any heading."""
    w = float(rng.uniform(low, high)) * so3.about_z(draw.angle(rng))[:, 0]
    return Blown(rng, draw.angle(rng), w=w, c=0.12)


def fly(
    part: Any, memory: Any, flight: Blown, steps: int, lost: Collection[str] = ()
) -> tuple[Any, list[CoupledEstimate]]:
    """The memory after some steps, and every estimate; the instruments `lost` are silent."""
    said = []
    for _ in range(steps):
        readings = {k: x for k, x in flight.step(DT).items() if k not in lost}
        memory, x = part.step(memory, readings, None, DT)
        said.append(expect_coupled(x))
    return memory, said


def expect_truth(x: CoupledEstimate, flight: Blown, atol: float) -> None:
    """Fail the check unless both velocities, the wind and the attitude are true to `atol`."""
    expect_close(x.v, flight.v, "The velocity over ground is wrong.", atol=atol)
    expect_close(
        x.V, flight.R.T @ (flight.v - flight.w), "The velocity in air is wrong.", atol=atol
    )
    expect_close(x.w, flight.w, "The wind is wrong.", atol=atol)
    expect_close(x.R, flight.R, "The attitude is wrong.", atol=atol)


@hidden(CoupledFilter)
def the_truth_is_kept(f: Function, rng: np.random.Generator) -> None:
    """Started on the truth, in still air, it must stay there: velocities, attitude, height, scalings and biases."""
    flight = blown(rng, 0.0, 1e-9)
    part = f(m_W=FIELD, c=flight.c)
    _, said = fly(part, part.init(flight.guess()), flight, 30)
    x = said[-1]
    expect_truth(x, flight, 0.05)
    expect_close(x.z, flight.r[2], "The height is wrong.", atol=0.05)
    expect_close((x.u_1, x.u_2), (1.0, 1.0), "A scaling wanders.", atol=0.02)
    expect_close((x.b_a, x.b_omega), np.zeros((2, 3)), "A bias wanders.", atol=0.05)
    expect_close(x.omega, said[-2].omega, "The body rate is wrong.", atol=0.5)
    expect_close(x.a, (flight.v - flight.before) / DT, "The acceleration is wrong.", atol=0.5)


@hidden(CoupledFilter, weight=2.0)
def lost_and_found(f: Function, rng: np.random.Generator) -> None:
    """Once the velocity over ground has dropped out the wind must decay, V go on, and all come back with it."""
    flight = blown(rng)
    part = f(m_W=FIELD, c=flight.c, gains=FAST._replace(body=CALM), patience=2.5 * DT)
    memory, found = fly(part, part.init(flight.guess()), flight, 40)
    expect_close(found[-1].w, flight.w, "The wind is not found.", atol=0.6)
    memory, lost = fly(part, memory, flight, 22, lost=("gnss",))
    fade = (1.0 - 3.0 * DT, np.exp(-3.0 * DT))  # one step's, by Euler and exactly
    for k in (8, 20):
        ratio = np.linalg.norm(lost[k].w) / np.linalg.norm(lost[4].w)
        low, high = (x ** (k - 4) for x in fade)
        expect(low - 0.03 < ratio < high + 0.03, "The wind does not decay.")
    V = flight.R.T @ (flight.v - flight.w)
    expect_close(lost[-1].V, V, "The velocity in air is lost.", atol=0.4)
    _, again = fly(part, memory, flight, 32)
    expect_close(again[-1].w, flight.w, "The wind does not come back.", atol=0.6)
    expect_close(again[-1].v, flight.v, "The velocity does not come back.", atol=0.2)


@hidden(CoupledFilter)
def never_a_satellite(f: Function, rng: np.random.Generator) -> None:
    """Without any velocity over ground, Filter 2 must follow the velocity through the air that drag and height give."""
    flight = blown(rng, 2.0, 3.0)
    part = f(m_W=FIELD, c=flight.c, gains=FAST._replace(body=CALM, k_2_vc=12.0))
    _, said = fly(part, part.init(flight.guess()), flight, 42, lost=("gnss",))
    x = said[-1]
    expect_close(x.w, np.zeros(3), "A wind that nobody can know.", atol=1e-6)
    expect_close(x.V, flight.R.T @ (flight.v - flight.w), "The velocity in air is wrong.", atol=0.4)
    expect_close(x.v, flight.v - flight.w, "Filter 2 does not follow.", atol=0.9)


@hidden(CoupledFilter)
def leaning_in_steady_flight(f: Function, rng: np.random.Generator) -> None:
    """In steady flight, leaning, drag and height must tell all of the velocity in air: V_z is not that of Filter 0."""
    R, c, rest = draw.tilted(rng, 0.3, 0.45), 0.5, np.zeros(3)
    accel = R.T @ (0.0, 0.0, GRAVITY)
    V = np.append(-accel[:2] / (c * np.sqrt(accel[2])), 0.0)  # (3)
    V[2] = -R[2, :2] @ V[:2] / R[2, 2]  # at its height
    part, v, x = f(m_W=FIELD, c=c, gains=FAST), R @ V, None
    memory = part.init(Estimate(rest, v, rest, R, rest))
    readings = {"imu": Imu(0.0, accel, rest), "barometer": Height(0.0, 0.0)}
    readings |= {"magnetometer": Field(0.0, R.T @ FIELD), "gnss": Fix(0.0, rest, v)}
    for _ in range(15):
        memory, x = part.step(memory, readings, None, DT)
    x = expect_coupled(x)
    expect_close(x.V, V, "The velocity in air is wrong.", atol=0.05)
    expect_close(x.v, v, "The velocity over ground is wrong.", atol=0.05)
    expect_close(x.w, rest, "A wind where there is none.", atol=0.05)


@hidden(CoupledFilter)
def no_magnetometer(f: Function, rng: np.random.Generator) -> None:
    """With the magnetometer silent the tilt must be found all the same, and the heading stay what the gyro says."""
    flight = blown(rng, 0.0, 1e-9)
    part, start = f(m_W=FIELD, c=flight.c, gains=FAST), flight.guess()
    start = start._replace(R=start.R @ so3.exp(np.array((0.15, -0.15, 0.0))))
    _, said = fly(part, part.init(start), flight, 50, lost=("magnetometer",))
    expect_close(said[-1].R[2], flight.R[2], "The tilt is not found.", atol=0.05)
    expect_close(said[-1].R, flight.R, "The heading wanders.", atol=0.15)


@hidden(CoupledFilter)
def the_compass_shows_the_heading(f: Function, rng: np.random.Generator) -> None:
    """Started with a wrong heading, the magnetometer must lead to the right one, and with it all velocities."""
    flight = blown(rng, 0.0, 1e-9)
    part, start = f(m_W=FIELD, c=flight.c, gains=FAST), flight.guess()
    wrong = so3.about_z(float(0.4 * rng.choice((-1.0, 1.0))))
    _, said = fly(part, part.init(start._replace(R=wrong @ start.R)), flight, 45)
    expect_close(said[-1].R, flight.R, "The heading is not found.", atol=0.1)


@hidden(CoupledFilter)
def one_attitude_for_both(f: Function, rng: np.random.Generator) -> None:
    """Where Filter 2 cannot correct its attitude, by its gains, it must follow that of Filter 1 (11b)."""
    flight = blown(rng, 0.0, 1e-9)
    deaf = FAST.inertial._replace(k_r=0.0, k_m=0.0, k_u=0.0)
    apt = FAST.body._replace(k_r=0.4)  # soon right, also where the flight is fast
    gains = FAST._replace(body=apt, inertial=deaf, k_1_rc=0.0, k_2_rc=8.0, k_1_vc=0.0, k_2_vc=0.0)
    part = f(m_W=FIELD, c=flight.c, gains=gains)
    start = flight.guess()
    start = start._replace(R=start.R @ so3.exp(np.array((0.15, -0.15, 0.2))))
    _, said = fly(part, part.init(start), flight, 40)
    expect_close(said[-1].R, flight.R, "The attitudes do not agree.", atol=0.1)


@hidden(CoupledFilter)
def one_bias_for_both(f: Function, rng: np.random.Generator) -> None:
    """A bias that Filter 2 has found must reach Filter 1 (6e), and there be taken off before the drag is read."""
    turned, R = so3.about_z(draw.angle(rng)), so3.about_z(draw.angle(rng))
    bias = turned @ (0.3, 0.0, 0.15)
    own = FAST.inertial._replace(k_r=0.0, k_u=0.0, k_b_a=2.0)
    gains = FAST._replace(body=own._replace(k_b_a=0.0), inertial=own, k_1_b_a=4.0, k_2_b_a=0.0)
    gains = gains._replace(k_1_vc=0.0, k_2_vc=0.0)
    part, rest = f(m_W=FIELD, c=0.1, gains=gains), np.zeros(3)
    memory, x = part.init(Estimate(rest, rest, rest, R, rest)), None
    seen = Imu(0.0, bias + np.array((0.0, 0.0, GRAVITY)), rest)
    for _ in range(60):
        readings = {"imu": seen, "barometer": Height(0.0, 0.0), "gnss": Fix(0.0, rest, rest)}
        memory, x = part.step(
            memory, {**readings, "magnetometer": Field(0.0, R.T @ FIELD)}, None, DT
        )
    x = expect_coupled(x)
    expect_close(x.b_a, bias, "The bias is not found.", atol=0.05)
    expect_close(x.V, rest, "The drag is read with the bias in it.", atol=0.1)


def pair(
    f: Function, rng: np.random.Generator, change: Any, steps: int = 14
) -> tuple[CoupledEstimate, CoupledEstimate, Blown]:
    """Two flights of one filter, from a start that is off, with readings as `change(k, readings)` tells them."""
    flight = blown(rng)
    start = flight.guess()
    start = start._replace(R=start.R @ so3.exp(np.array((0.1, -0.1, 0.1))))
    part = f(m_W=FIELD, c=flight.c, gains=FAST)
    one, two, x, y = part.init(start), part.init(start), None, None
    for k in range(steps):
        first, second = change(k, flight.step(DT))
        one, x = part.step(one, first, None, DT)
        two, y = part.step(two, second, None, DT)
    x, y = expect_coupled(x), expect_coupled(y)
    expect(np.linalg.norm(x.w) > 0.05, "No wind is seen.")
    expect_close(x.v, flight.v, "The velocity over ground is wrong.", atol=0.5)
    return x, y, flight


@hidden(CoupledFilter)
def held_until_the_next(f: Function, rng: np.random.Generator) -> None:
    """A reading must be held until the next one comes: to hand it in again changes nothing."""
    kept: dict[str, Reading] = {}

    def change(k: int, new: dict[str, Reading]) -> tuple[Mapping[str, Reading], ...]:
        every = {"imu": 2, "barometer": 5, "magnetometer": 4, "gnss": 3}
        fresh = {name: x for name, x in new.items() if k % every[name] == 0}
        kept.update(fresh)
        return dict(kept), fresh

    x, y, _ = pair(f, rng, change)
    for a, b in zip(x, y, strict=True):
        expect_close(b, a)


@hidden(CoupledFilter, weight=0.5)
def readings_that_are_not_numbers(f: Function, rng: np.random.Generator) -> None:
    """A reading with a number that is not finite must be passed over, as if it had not come."""
    broken: dict[str, Reading] = {
        "imu": Imu(0.0, NAN, np.zeros(3)),
        "barometer": Height(0.0, np.inf),
        "magnetometer": Field(0.0, NAN),
        "gnss": Fix(0.0, np.zeros(3), NAN),
    }

    def change(k: int, new: dict[str, Reading]) -> tuple[Mapping[str, Reading], ...]:
        name = list(broken)[k % 4]
        if k < 4:
            return new, new
        return {n: x for n, x in new.items() if n != name}, {**new, name: broken[name]}

    x, y, _ = pair(f, rng, change)
    for a, b in zip(x, y, strict=True):
        expect_close(b, a)


@hidden(CoupledFilter)
def told_in_another_world(f: Function, rng: np.random.Generator) -> None:
    """Told in another world in mid-flight, it must go on as if it had always been there."""
    flight, shift = blown(rng), Shift(draw.vector(rng, 3.0), draw.angle(rng))
    part = f(m_W=FIELD, c=flight.c, gains=FAST)
    one, _ = fly(part, part.init(flight.guess()), flight, 10)
    two, Rz, x, y = part.reframe(one, shift), so3.about_z(shift.heading), None, None
    for k in range(14):
        readings = {} if k == 0 else flight.step(DT)  # first with what is held
        if k == 0:
            flight.step(DT)
        one, x = part.step(one, readings, None, DT)
        told = {n: moved(r, shift) for n, r in readings.items()}  # type: ignore[type-var]
        two, y = part.step(two, told, None, DT)
    x, y = expect_coupled(x), expect_coupled(y)
    expect_close(x.v, flight.v, "The velocity over ground is wrong.", atol=0.5)
    for a, b in ((x.v, y.v), (x.w, y.w), (x.a, y.a), (x.R, y.R)):
        expect_close(b, Rz @ a)
    expect_close(y.z, x.z + shift.r[2])
    for a, b in ((x.V, y.V), (x.omega, y.omega), (x.b_a, y.b_a), (x.b_omega, y.b_omega)):
        expect_close(b, a)
    expect_close((y.u_1, y.u_2), (x.u_1, x.u_2))
