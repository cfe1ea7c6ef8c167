"""The public checks of lab 04: what the laws of complementary filters promise. The exercises are beside it."""

from __future__ import annotations

from typing import Any

import numpy as np

from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.expect import expect_record, expect_rotation, expect_unit
from uavlab.exercises.paths import FIELD, Blown, Path
from uavlab.exercises.spec import Function, expect, expect_close
from uavlab.types import (
    GRAVITY,
    NO_PULL,
    AidedGains,
    Array,
    BodyMemory,
    CoupledEstimate,
    CoupledGains,
    Imu,
    InertialMemory,
    VerticalGains,
    VerticalMemory,
)


def only_the_gyro(f: Function, rng: np.random.Generator) -> None:
    """Where estimate and measurement agree, the estimate turns with the gyro, either sign of q_meas."""
    got = expect_unit(f(np.array((1.0, 0, 0, 0)), np.array((0, 0, 0.5)), -np.eye(4)[0], 2.0, 0.1))
    expect_close(got, (np.cos(0.025), 0.0, 0.0, np.sin(0.025)))


def small_errors_fade(f: Function, rng: np.random.Generator) -> None:
    """A small error must shrink by exp(−gain dt), about its own axis in the body, also where gain times dt is large."""
    for k in (0.1, 0.7, 3.0):
        gain, tiny, R = (
            float(rng.uniform(1.0, 60.0)),
            1e-4 * draw.direction(rng),
            draw.rotation(rng),
        )
        q, q_meas = (so3.quaternion_from_rotation(x) for x in (R @ so3.exp(tiny), R))
        got = expect_unit(f(q, np.zeros(3), q_meas, gain, k / gain))
        left = so3.log(R.T @ so3.rotation_from_quaternion(got))
        expect_close(
            left, np.exp(-k) * tiny, "It shrinks otherwise, or about another axis.", atol=1e-10
        )


def dead_reckoning(f: Function, rng: np.random.Generator) -> None:
    """Before the first measurement the acceleration alone carries position and velocity."""
    got = f(np.zeros(3), np.ones(3), np.array((0.0, 0.0, 2.0)), None, 2.0, 1.0, 0.5)
    expect_close(expect_record(got, (3,), (3,))[0], (0.5, 0.5, 0.75))
    expect_close(got[1], (1.0, 1.0, 2.0))


def one_long_step_or_many(f: Function, rng: np.random.Generator) -> None:
    """Of a held measurement one long step must make what many short ones make, and it must draw."""
    r, v, a, r_meas = (draw.vector(rng) for _ in range(4))
    k_p, k_v = float(rng.uniform(2.0, 6.0)), float(rng.uniform(2.0, 20.0))
    once = expect_record(f(r, v, a, r_meas, k_p, k_v, 1.0), (3,), (3,))
    short = (r, v)
    for _ in range(25):
        short = expect_record(f(*short, a, r_meas, k_p, k_v, 0.04), (3,), (3,))
    expect_close(once[0], short[0], atol=1e-8)
    expect_close(once[1], short[1], atol=1e-8)
    rest = expect_record(f(r, v, a, r_meas, k_p, k_v, 100.0), (3,), (3,))[0]
    expect_close(rest, r_meas + a / k_v, "Left alone, it does not come to rest where (11) says.")


def drag_of_a_velocity(f: Function, rng: np.random.Generator) -> None:
    """From the drag that a velocity makes, that velocity must come back; in free fall, NaN."""
    for _ in range(3):
        V, c, up = draw.vector(rng, 5.0)[:2], rng.uniform(0.05, 0.5), rng.uniform(2.0, 20.0)
        drag = -c * V  # (3), times √up
        expect_close(f(np.append(drag * up**0.5, up), float(c)), V)
    expect_nan(f(np.array((0.1, 0.2, float(rng.uniform(-5.0, 0.9)))), 0.1))


def expect_nan(got: Array) -> None:
    """Fail the check unless `got` is two NaN."""
    both = np.array(got, copy=True, subok=False)
    plain = both.dtype.kind == "f" and both.shape == (2,)
    expect(plain and np.isnan(both).all(), "Near free fall NaN twice is asked for.")


def hover_with_a_bias(f: Function, rng: np.random.Generator) -> None:
    """Leaning and at rest, with a wrong start and a biased accelerometer, the filter must find all three."""
    R, z, b = draw.tilted(rng, 0.2, 0.6), float(rng.uniform(-5, 5)), float(rng.uniform(0.2, 0.5))
    accel = R.T @ (0.0, 0.0, GRAVITY + b)
    x = VerticalMemory(z + 1.0, -0.5, 0.0)
    for _ in range(200):
        said = f(x, R, accel, z, 0.05, gains=VerticalGains(6.0, 12.0, 8.0))
        x = VerticalMemory(*map(float, expect_record(said, (), (), ())))
    expect_close(x, (z, 0.0, b), "It does not settle on height, rest and bias.", atol=1e-4)


def the_truth_is_kept_in_the_body(f: Function, rng: np.random.Generator) -> None:
    """With the truth in memory and true readings, also with known biases, the filter must stay on it."""
    path, w, dt = Path(rng, draw.angle(rng), turn=1.0), draw.vector(rng, 2.0), 0.005
    for t in rng.uniform(0.0, 9.0, size=3):
        (_, v, R), (_, v_2, R_2), seen = path.at(t), path.at(t + dt), path.imu(t, dt)
        x = BodyMemory(R.T @ (v - w), R, 1.0, draw.vector(rng, 0.3), draw.vector(rng, 0.05))
        imu = Imu(t, seen.accel + x.b_a, seen.gyro + x.b_omega)
        got = f(x, imu, x.V, R.T @ FIELD, dt, m_W=FIELD, gains=AidedGains(), pull=NO_PULL)
        V, R_got, *rest = expect_record(got, (3,), (3, 3), (), (3,), (3,))
        expect_close(V, R_2.T @ (v_2 - w), "The velocity leaves the truth.", atol=1e-3)
        expect_close(R_got, R_2, "The attitude leaves the truth.", atol=1e-4)
        expect_close(np.hstack(rest), np.hstack(x[2:]), "A bias or the scaling moves.", atol=1e-4)


def the_truth_is_kept_in_the_world(f: Function, rng: np.random.Generator) -> None:
    """With the truth in memory and true readings, also with known biases, the filter must stay on it."""
    path, dt = Path(rng, draw.angle(rng), turn=1.0), 0.005
    for t in rng.uniform(0.0, 9.0, size=3):
        (_, v, R), (_, v_2, R_2), seen = path.at(t), path.at(t + dt), path.imu(t, dt)
        x = InertialMemory(v, R, 1.0, draw.vector(rng, 0.3), draw.vector(rng, 0.05))
        imu = Imu(t, seen.accel + x.b_a, seen.gyro + x.b_omega)
        got = f(x, imu, v, R.T @ FIELD, dt, m_W=FIELD, gains=AidedGains(), pull=NO_PULL)
        v_got, R_got, *rest = expect_record(got, (3,), (3, 3), (), (3,), (3,))
        expect_close(v_got, v_2, "The velocity leaves the truth.", atol=1e-3)
        expect_close(R_got, R_2, "The attitude leaves the truth.", atol=1e-4)
        expect_close(np.hstack(rest), np.hstack(x[2:]), "A bias or the scaling moves.", atol=1e-4)


# The coupled pair -------------------------------------------------------------------------------------


FAST = CoupledGains(
    vertical=VerticalGains(6.0, 12.0, 8.0),
    body=AidedGains(8.0, 0.16, 0.03, 20.0, 0.0, 0.0, 0.0),
    inertial=AidedGains(8.0, 0.16, 0.03, 20.0, 0.0, 0.0, 0.0),
    k_w=3.0,
)  # for flights of seconds, with biases known


def the_wind_is_found(f: Function, rng: np.random.Generator) -> None:
    """Flown in a steady wind, with all instruments, the filter must find the wind and both velocities."""
    w = float(rng.uniform(1.0, 2.0) * rng.choice((-1.0, 1.0))) * np.array((1.0, 0.6, 0.0))
    flight = Blown(rng, draw.angle(rng), w=w, c=0.12)
    part, x = f(m_W=FIELD, c=flight.c, gains=FAST), None
    memory = part.init(flight.guess())
    for _ in range(100):
        memory, x = part.step(memory, flight.step(0.03), None, 0.03)
    V, v, _, w, *_ = expect_coupled(x)
    expect_close(w, flight.w, "The wind is not found.", atol=0.3)
    expect_close(v, flight.v, "The velocity over ground is wrong.", atol=0.1)
    expect_close(V, flight.R.T @ (flight.v - flight.w), "The velocity in air is wrong.", atol=0.3)


def expect_coupled(got: Any) -> CoupledEstimate:
    """`got` as plain arrays; fail the check unless it has the fields of a CoupledEstimate and a rotation in it."""
    shapes = ((3,), (3,), (3,), (3,), (3, 3), (3,), (), (), (), (3,), (3,))
    x = CoupledEstimate(*expect_record(got, *shapes))  # type: ignore[arg-type]
    expect_rotation(x.R)
    return x
