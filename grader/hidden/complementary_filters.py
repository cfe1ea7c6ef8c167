"""Lab 04, hidden checks of the two velocity-aided filters: each law by itself, then laws of the whole, then flights."""

from __future__ import annotations

import numpy as np

from grader.hidden import complementary_laws as laws
from grader.material import hidden
from uavlab.exercises import draw
from uavlab.exercises.complementary import body_filter_step, inertial_filter_step
from uavlab.exercises.expect import expect_record, expect_rotation
from uavlab.exercises.paths import FIELD
from uavlab.exercises.spec import Function, expect_close
from uavlab.types import GRAVITY, NO_PULL, BodyMemory, Imu, InertialMemory

CANARY = "canary-ab8dc514dbfadad1e5222297"

# The laws of Filter 1 ---------------------------------------------------------------------------------


@hidden(body_filter_step)
def body_velocity(f: Function, rng: np.random.Generator) -> None:
    """The velocity must change as (6a) says, z up: turned by the body rate, with u gravity, and drawn by Δ^v."""
    for _ in range(3):
        c = laws.case(BodyMemory, rng)
        x, e = c.x, c.x.V - c.seen
        want = np.cross(x.V, c.imu.gyro - x.b_omega) + c.imu.accel - x.b_a
        laws.close(laws.rates(f, c).velocity, want - x.u * GRAVITY * x.R[2] - c.gains.k_v * e)


@hidden(body_filter_step)
def body_attitude(f: Function, rng: np.random.Generator) -> None:
    """The attitude must turn with the unbiased gyro, and by Δ^r, told in the world, against the velocity error."""
    laws.law_of_the_attitude(f, rng, BodyMemory)


@hidden(body_filter_step)
def body_compass(f: Function, rng: np.random.Generator) -> None:
    """The magnetometer must turn the attitude about the vertical by (7c), in the body, and the gyro bias too."""
    laws.law_of_the_compass(f, rng, BodyMemory)


@hidden(body_filter_step, weight=1.5)
def body_biases(f: Function, rng: np.random.Generator) -> None:
    """Both biases must follow their innovations, told in the body, with the signs of (6e) and (6f)."""
    laws.law_of_the_biases(f, rng, BodyMemory)


@hidden(body_filter_step)
def body_scaling(f: Function, rng: np.random.Generator) -> None:
    """The scaling must follow (6d), z up: the velocity error told in the world, its vertical part."""
    laws.law_of_the_scaling(f, rng, BodyMemory)


@hidden(body_filter_step, weight=0.5)
def body_pull(f: Function, rng: np.random.Generator) -> None:
    """What pulls must be added: on the velocity in the body, on the attitude in the world, on the bias in the body."""
    laws.law_of_the_pull(f, rng, BodyMemory)


@hidden(body_filter_step, weight=0.5)
def body_silence(f: Function, rng: np.random.Generator) -> None:
    """Without a measured velocity the filter must go on as if it had no velocity error."""
    laws.law_of_silence(f, rng, BodyMemory)


@hidden(body_filter_step, weight=0.5)
def body_turned_world(f: Function, rng: np.random.Generator) -> None:
    """In a world turned about the vertical everything told in the body must come out the same."""
    laws.law_of_the_turned_world(f, rng, BodyMemory)


@hidden(body_filter_step)
def energy_of_the_error(f: Function, rng: np.random.Generator) -> None:
    """With k_r = k_u, ½|Ṽ|² + |u Rᵀe_3 − true|² / 2k must fall by exactly k_v |Ṽ|², however large the error."""
    for _ in range(2):
        R, k = draw.tilted(rng, 0.1, 0.8), float(rng.uniform(0.02, 0.1))
        c, omega = laws.case(BodyMemory, rng), draw.vector(rng)
        V, a = c.seen, draw.vector(rng, 3.0) + laws.UP
        x = c.x._replace(b_a=np.zeros(3), b_omega=np.zeros(3))
        gains = c.gains._replace(k_r=k, k_u=k)
        got = laws.rates(f, c._replace(x=x, imu=Imu(0.0, a, omega), gains=gains))
        e, y = x.V - V, x.u * x.R[2] - R[2]
        e_dot = got.velocity - (np.cross(V, omega) + a - GRAVITY * R[2])
        y_dot = got.u * x.R[2] + x.u * np.cross(x.R[2], got.turn) - np.cross(R[2], omega)
        expect_close(e @ e_dot + y @ y_dot / k, -gains.k_v * (e @ e), atol=0.02)


@hidden(body_filter_step, weight=1.5)
def body_flight_south(f: Function, rng: np.random.Generator) -> None:
    """Flown with the nose turned round, and a biased gyro, the filter must find the attitude and the bias."""
    laws.law_of_the_flight_south(f, rng, BodyMemory)


# The laws of Filter 2 ---------------------------------------------------------------------------------


@hidden(inertial_filter_step)
def inertial_velocity(f: Function, rng: np.random.Generator) -> None:
    """The velocity must change as (9a) says, z up: with u in front of gravity, and drawn by Δ^v."""
    for _ in range(3):
        c = laws.case(InertialMemory, rng)
        x, e = c.x, c.x.v - c.seen
        want = x.R @ (c.imu.accel - x.b_a) - (0.0, 0.0, x.u * GRAVITY) - c.gains.k_v * e
        laws.close(laws.rates(f, c).velocity, want)


@hidden(inertial_filter_step)
def inertial_attitude(f: Function, rng: np.random.Generator) -> None:
    """The attitude must turn with the unbiased gyro, and by Δ^r, told in the world, against the velocity error."""
    laws.law_of_the_attitude(f, rng, InertialMemory)


@hidden(inertial_filter_step)
def inertial_compass(f: Function, rng: np.random.Generator) -> None:
    """The magnetometer must turn the attitude about the vertical by (10c), in the body, and the gyro bias too."""
    laws.law_of_the_compass(f, rng, InertialMemory)


@hidden(inertial_filter_step, weight=1.5)
def inertial_biases(f: Function, rng: np.random.Generator) -> None:
    """Both biases must follow their innovations, told in the body, not in the world as (9f) and (9g) are printed."""
    laws.law_of_the_biases(f, rng, InertialMemory)


@hidden(inertial_filter_step)
def inertial_scaling(f: Function, rng: np.random.Generator) -> None:
    """The scaling must follow the vertical velocity error, not the velocity itself as (9d) is printed."""
    laws.law_of_the_scaling(f, rng, InertialMemory)


@hidden(inertial_filter_step, weight=0.5)
def inertial_pull(f: Function, rng: np.random.Generator) -> None:
    """What pulls must be added: on velocity and attitude in the world, on the bias in the body."""
    laws.law_of_the_pull(f, rng, InertialMemory)


@hidden(inertial_filter_step, weight=0.5)
def inertial_silence(f: Function, rng: np.random.Generator) -> None:
    """While the velocity has dropped out the filter must go on as if it had no velocity error."""
    laws.law_of_silence(f, rng, InertialMemory)


@hidden(inertial_filter_step, weight=0.5)
def inertial_turned_world(f: Function, rng: np.random.Generator) -> None:
    """In a world turned about the vertical, velocity and attitude must turn along, and the rest stay."""
    laws.law_of_the_turned_world(f, rng, InertialMemory)


@hidden(inertial_filter_step, weight=1.5)
def inertial_flight_south(f: Function, rng: np.random.Generator) -> None:
    """Flown with the nose turned round, and a biased gyro, the filter must find the attitude and the bias."""
    laws.law_of_the_flight_south(f, rng, InertialMemory)


@hidden(inertial_filter_step)
def back_to_one(f: Function, rng: np.random.Generator) -> None:
    """At rest, with a scaling that starts 20 percent off, the scaling must come back to one."""
    R, u = draw.tilted(rng, 0.0, 0.3), float(1.0 + 0.2 * rng.choice((-1.0, 1.0)))
    x = InertialMemory(np.zeros(3), R, u, np.zeros(3), np.zeros(3))
    imu = Imu(0.0, R.T @ (0.0, 0.0, GRAVITY), np.zeros(3))
    rest, gains = draw.vector(rng) * 0.0, laws.QUICK._replace(k_b_a=0.0, k_u=0.1)
    for _ in range(150):
        got = f(x, imu, rest, R.T @ FIELD, 0.02, m_W=FIELD, gains=gains, pull=NO_PULL)
        v, R_2, u, b_a, b_w = expect_record(got, (3,), (3, 3), (), (3,), (3,))
        x = InertialMemory(v, expect_rotation(R_2), float(u), b_a, b_w)
    expect_close(x.u, 1.0, "It does not come back.", atol=0.02)
    expect_close(x.v, rest, "The velocity is wrong.", atol=0.1)
