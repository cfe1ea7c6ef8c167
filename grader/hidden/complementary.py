"""Lab 04, hidden checks: closed forms, matrix exponentials, symmetries, and starts that are far off."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from grader.hidden.complementary_coupled import *  # noqa: F403  (found here by their lab)
from grader.hidden.complementary_filters import *  # noqa: F403
from grader.material import hidden
from uavlab.exercises import draw
from uavlab.exercises.complementary import (
    attitude_step,
    drag_velocity,
    position_observer_step,
    vertical_step,
)
from uavlab.exercises.complementary_checks import expect_nan
from uavlab.exercises.expect import expect_record, expect_unit
from uavlab.exercises.paths import Path
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.types import GRAVITY, Array, Mat3, Quat, Vec3, VerticalGains, VerticalMemory

CANARY = "canary-e8b5cdf21f251935d138acec"

UP = np.array((0.0, 0.0, GRAVITY))  # [m/s²] specific force at rest
SPICA = (126.3, 3987.3)  # k_p [1/s], k_v [1/s²], Spica Sec. 6.1


def expect_refusal(f: Function, *args: object, **kwargs: object) -> None:
    """Fail the check unless the answer refuses; an answer that hangs or dies has not."""
    try:
        f(*args, **kwargs)
    except (ValueError, ArithmeticError):
        return
    expect(False, "It must raise ValueError.")


# attitude_step ----------------------------------------------------------------------------------------


def quat(R: Rotation) -> Quat:
    """[w, x, y, z], either sign."""
    return R.as_quat()[[3, 0, 1, 2]]


def rotation(q: Quat) -> Rotation:
    """The rotation of [w, x, y, z]."""
    return Rotation.from_quat(q[[1, 2, 3, 0]])


def expect_attitude(got: object, want: Rotation, atol: float = 1e-9) -> None:
    """Fail the check unless `got` is a unit quaternion of this rotation, of either sign."""
    q = expect_unit(got)
    expect_close((rotation(q).inv() * want).magnitude(), 0.0, "The attitude is another.", atol=atol)


def off(rng: np.random.Generator, low: float, high: float) -> tuple[Rotation, Rotation]:
    """An estimate and a measurement, `low` to `high` [rad] apart."""
    true = Rotation.from_matrix(draw.rotation(rng))
    return true * Rotation.from_rotvec(rng.uniform(low, high) * draw.direction(rng)), true


def flow(est: Rotation, true: Rotation, omega: Vec3, gain: float, dt: float) -> Rotation:
    """(12), solved: about its axis in the world the error θ falls as tan(θ/2) exp(−gain t)."""
    error = (est * true.inv()).as_rotvec()
    size = np.linalg.norm(error)
    left = 2.0 * np.arctan(np.tan(0.5 * size) * np.exp(-gain * dt))
    return Rotation.from_rotvec(left / size * error) * true * Rotation.from_rotvec(omega * dt)


@hidden(attitude_step, weight=2.0)
def exact_at_any_angle(f: Function, rng: np.random.Generator) -> None:
    """The step must solve (12) exactly, for errors up to 170 degrees, slow and fast gains, and any body rate."""
    for low, k in ((0.05, 0.1), (0.5, 0.3), (1.5, 0.8), (2.4, 0.3), (2.4, 2.0)):
        (est, true), omega, dt = off(rng, low, low + 0.5), draw.vector(rng, 3.0), 0.1
        want = flow(est, true, omega, k / dt, dt)
        expect_attitude(f(quat(est), omega, quat(true), k / dt, dt), want)


@hidden(attitude_step)
def from_175_degrees(f: Function, rng: np.random.Generator) -> None:
    """Started 175 degrees off, the estimate must find a turning aircraft, at any rate of the measurements."""
    for dt in (0.02, 0.2):
        est, true = off(rng, np.radians(174.0), np.radians(175.0))
        q, omega, gain = quat(est), draw.vector(rng, 2.0), 20.0
        for _ in range(round(1.0 / dt)):
            q = expect_unit(f(q, omega, quat(true), gain, dt))
            true = true * Rotation.from_rotvec(omega * dt)
        expect_attitude(q, true, 1e-4)


@hidden(attitude_step)
def either_sign_of_the_measurement(f: Function, rng: np.random.Generator) -> None:
    """The sign of q_meas must not matter, both are one attitude; and the sign of q must be kept."""
    for low in (0.2, 1.0, 2.4):
        (est, true), omega = off(rng, low, low + 0.3), draw.vector(rng, 2.0)
        q, q_meas = quat(est), quat(true)
        for q_given in (q, -q):
            for meas in (q_meas, -q_meas):
                got = expect_unit(f(q_given, omega, meas, 4.0, 0.05))
                expect_attitude(got, flow(est, true, omega, 4.0, 0.05))
                expect(got @ q_given > 0.0, "The sign of the quaternion jumps.")


@hidden(attitude_step)
def of_any_length(f: Function, rng: np.random.Generator) -> None:
    """Quaternions that are not of length one must count by their direction only, and a unit one come out."""
    for low in (0.3, 1.5):
        (est, true), omega = off(rng, low, low + 0.5), draw.vector(rng, 2.0)
        a, b = rng.uniform(0.3, 0.8), rng.uniform(1.5, 3.0)
        got = f(a * quat(est), omega, b * quat(true), 5.0, 0.1)
        expect_attitude(got, flow(est, true, omega, 5.0, 0.1))


@hidden(attitude_step)
def another_world(f: Function, rng: np.random.Generator) -> None:
    """Told in another world, estimate and measurement must give the same attitude told in that world."""
    for _ in range(3):
        (est, true), omega = off(rng, 0.3, 2.5), draw.vector(rng, 2.0)
        turn = Rotation.from_matrix(draw.rotation(rng))
        got = rotation(expect_unit(f(quat(est), omega, quat(true), 6.0, 0.1)))
        expect_attitude(f(quat(turn * est), omega, quat(turn * true), 6.0, 0.1), turn * got)
        rest = expect_unit(f(quat(est), omega, quat(true), 6.0, 9.0))  # by then all is forgotten
        expect_attitude(rest, true * Rotation.from_rotvec(9.0 * omega), 1e-6)


# position_observer_step -------------------------------------------------------------------------------


def held(r: Vec3, v: Vec3, a: Vec3, z: Vec3, k_p: float, k_v: float, dt: float) -> Array:
    """(11) by the exponential of its matrix, measurement and acceleration as states that stand still."""
    A = np.zeros((4, 4))
    A[:2] = (-k_p, 1.0, k_p, 0.0), (-k_v, 0.0, k_v, 1.0)
    return (expm(A * dt) @ np.array((r, v, z, a)))[:2]


@hidden(position_observer_step, weight=2.0)
def exact_while_held(f: Function, rng: np.random.Generator) -> None:
    """The step must solve (11) exactly for a held measurement: poles that swing, and those of Spica at 30 Hz."""
    for k_p, k_v, dt in ((*SPICA, 1 / 30), (*SPICA, 0.004), (1.0, 9.0, 0.4), (5.0, 2.0, 0.3)):
        r, v, a, z = (draw.vector(rng, 2.0) for _ in range(4))
        got = expect_record(f(r, v, a, z, k_p, k_v, dt), (3,), (3,))
        expect_close(np.array(got), held(r, v, a, z, k_p, k_v, dt), atol=1e-8)


@hidden(position_observer_step)
def poles_that_fall_together(f: Function, rng: np.random.Generator) -> None:
    """With k_v = k_p² / 4 both poles fall together: the step must be right, and finite, there too."""
    for p in rng.uniform(1.0, 8.0, size=3):
        e, dt, z = draw.vector(rng), float(rng.uniform(0.1, 0.5)), draw.vector(rng)
        got = expect_record(f(z + e, p * e, np.zeros(3), z, 2 * p, p * p, dt), (3,), (3,))
        fade = np.exp(-p * dt)  # at rest in r: ṙ = v − k_p e = −p e
        expect_close(got[0], z + fade * e, atol=1e-7)
        expect_close(got[1], p * fade * e, atol=1e-7)


@hidden(position_observer_step)
def low_rate_positions(f: Function, rng: np.random.Generator) -> None:
    """With positions at 30 Hz, held in between, and the gains of Spica, it must follow a flight to some centimetres."""
    start, speed, pull = draw.vector(rng), draw.direction(rng), 0.5 * draw.direction(rng)
    dt, every = 1 / 240, 8
    r, v, seen = np.zeros(3), np.zeros(3), start
    for k in range(120):
        t = k * dt
        if k % every == 0:
            seen = start + speed * t + 0.5 * pull * t * t
        r, v = expect_record(f(r, v, pull, seen, *SPICA, dt), (3,), (3,))
    t = 120 * dt
    expect_close(r, start + speed * t + 0.5 * pull * t * t, "It does not follow.", atol=0.06)


@hidden(position_observer_step)
def nothing_measured_yet(f: Function, rng: np.random.Generator) -> None:
    """Before the first measurement the acceleration alone counts, whatever the gains; then the position draws."""
    for _ in range(3):
        r, v, a, z = (draw.vector(rng, 3.0) for _ in range(4))
        dt = float(rng.uniform(0.1, 0.5))
        got = expect_record(f(r, v, a, None, 3.0, 2.0, dt), (3,), (3,))
        expect_close(got[0], r + dt * v + dt * dt / 2 * a)
        expect_close(got[1], v + dt * a)
        then = expect_record(f(r, v, a, z, 3.0, 2.0, dt), (3,), (3,))
        expect(np.linalg.norm(then[0] - got[0]) > 1e-3, "A measurement changes nothing.")


@hidden(position_observer_step, weight=0.5)
def gains_of_no_use(f: Function, rng: np.random.Generator) -> None:
    """A gain that is zero or below must raise ValueError; small ones must not."""
    r, v, a, z = (draw.vector(rng) for _ in range(4))
    got = expect_record(f(r, v, a, z, 0.01, 0.001, 0.1), (3,), (3,))
    expect_close(np.array(got), held(r, v, a, z, 0.01, 0.001, 0.1), atol=1e-6)
    for k_p, k_v in ((0.0, 1.0), (1.0, 0.0), (-1.0, 1.0), (1.0, -1.0)):
        expect_refusal(f, r, v, a, z, k_p, k_v, 0.1)


# drag_velocity ----------------------------------------------------------------------------------------


@hidden(drag_velocity, weight=2.0)
def fast_and_slow_light_and_heavy(f: Function, rng: np.random.Generator) -> None:
    """The velocity must be right up to 15 m/s, with little thrust and with much."""
    for V_max, up in ((1.0, 9.81), (15.0, 9.81), (5.0, 1.2), (5.0, 30.0)):
        V, c = rng.uniform(-V_max, V_max, size=2), float(rng.uniform(0.05, 0.5))
        expect_close(f(np.array((*(-c * up**0.5 * V), up)), c), V)


@hidden(drag_velocity)
def four_times_the_thrust(f: Function, rng: np.random.Generator) -> None:
    """The same drag at four times the thrust must mean half the velocity, and none no velocity."""
    V, c, up = (
        draw.vector(rng, 3.0)[:2],
        float(rng.uniform(0.05, 0.5)),
        float(rng.uniform(3.0, 9.0)),
    )
    drag = -c * up**0.5 * V
    expect_close(f(np.array((*drag, up)), c), V)
    expect_close(f(np.array((*drag, 4.0 * up)), c), 0.5 * V)
    expect_close(f(np.array((0.0, 0.0, up)), c), np.zeros(2))


@hidden(drag_velocity)
def near_free_fall(f: Function, rng: np.random.Generator) -> None:
    """At and below 1 m/s² along body z the answer must be NaN, also where it is negative; above it must not."""
    drag, c = draw.vector(rng)[:2], float(rng.uniform(0.1, 0.5))
    expect_close(f(np.array((*drag, 1.01)), c), -drag / c / 1.01**0.5)
    for up in (1.0, 0.9, 0.0, -0.5, -9.81):
        expect_nan(f(np.array((*drag, up)), c))


@hidden(drag_velocity, weight=0.5)
def no_drag_at_all(f: Function, rng: np.random.Generator) -> None:
    """A drag coefficient of zero, or below, must raise ValueError; a small one must not."""
    accel = np.array((*draw.vector(rng)[:2], 9.0))
    expect_close(f(accel, 0.01), -accel[:2] / 0.03)
    expect_refusal(f, accel, 0.0)
    expect_refusal(f, accel, -0.1)


# vertical_step ----------------------------------------------------------------------------------------


def stable(rng: np.random.Generator) -> VerticalGains:
    """Gains with three poles between −1 and −3 rad/s."""
    _, a, b, c = np.poly(-rng.uniform(1.0, 3.0, size=3))
    return VerticalGains(float(a), float(b), float(c))


def drawn(rng: np.random.Generator) -> tuple[VerticalMemory, Mat3, Vec3]:
    """A memory, an attitude and a specific force."""
    x = VerticalMemory(*map(float, rng.uniform(-2.0, 2.0, size=3)))
    return x, draw.tilted(rng, 0.2, 1.0), draw.vector(rng, 3.0) + UP


def rate(f: Function, x: VerticalMemory, *given: object, gains: VerticalGains) -> Array:
    """The derivative of the memory, from a tiny step."""
    h = 1e-6
    there = np.array(expect_record(f(x, *given, h, gains=gains), (), (), ()))
    return (there - np.array(x)) / h


@hidden(vertical_step, weight=2.0)
def rates_of_filter_0(f: Function, rng: np.random.Generator) -> None:
    """For a small step the changes must be those of (4), with the specific force told in the world, z up."""
    for _ in range(3):
        (x, R, accel), k, z = drawn(rng), stable(rng), float(rng.normal())
        e, up = x.z - z, (R @ accel)[2] - GRAVITY
        want = (x.v_z - k.k_1 * e, up - x.b_z - k.k_2 * e, k.k_3 * e)
        expect_close(rate(f, x, R, accel, z, gains=k), want, atol=1e-3)


@hidden(vertical_step)
def before_the_first_height(f: Function, rng: np.random.Generator) -> None:
    """Before the first height the accelerometer alone counts, and the bias stands still."""
    for _ in range(2):
        (x, R, accel), k = drawn(rng), stable(rng)
        want = (x.v_z, (R @ accel)[2] - GRAVITY - x.b_z, 0.0)
        expect_close(rate(f, x, R, accel, None, gains=k), want, atol=1e-3)


@hidden(vertical_step)
def errors_die_as_the_poles_say(f: Function, rng: np.random.Generator) -> None:
    """Over a second the errors must die as s³ + k_1 s² + k_2 s + k_3 says."""
    k, b, dt = stable(rng), float(rng.uniform(-0.5, 0.5)), 0.01
    e = rng.uniform(-1.0, 1.0, size=3)
    R, rest = draw.tilted(rng, 0.3, 0.8), np.array((2.0, 0.0, b))
    x = VerticalMemory(*map(float, e + rest))
    for _ in range(100):
        got = f(x, R, R.T @ (0.0, 0.0, GRAVITY + b), 2.0, dt, gains=k)
        x = VerticalMemory(*map(float, expect_record(got, (), (), ())))
    A = np.array(((-k.k_1, 1.0, 0.0), (-k.k_2, 0.0, -1.0), (k.k_3, 0.0, 0.0)))
    expect_close(np.array(x) - rest, expm(A) @ e, atol=0.1)


@hidden(vertical_step)
def up_and_down_with_a_bias(f: Function, rng: np.random.Generator) -> None:
    """On a leaning flight up and down, with a biased accelerometer, the filter must stay with the truth."""
    path, b, dt = Path(rng, draw.angle(rng)), float(rng.uniform(0.2, 0.5)), 0.02
    here = path.at(0.0)
    x, bias = VerticalMemory(float(here.r[2]), float(here.v[2]), b), np.array((0.0, 0.0, b))
    for k in range(80):
        here, seen = path.at(k * dt), path.imu(k * dt, dt)
        said = f(
            x, here.R, seen.accel + here.R.T @ bias, float(here.r[2]), dt, gains=VerticalGains()
        )
        x = VerticalMemory(*map(float, expect_record(said, (), (), ())))
    there = path.at(80 * dt)
    expect_close(x, (there.r[2], there.v[2], b), "It leaves the truth.", atol=0.1)


@hidden(vertical_step, weight=0.5)
def gains_that_make_errors_grow(f: Function, rng: np.random.Generator) -> None:
    """Gains that make the error grow must raise ValueError: k_3 not below k_1 k_2, or one not above zero."""
    x, R, accel = drawn(rng)
    for bad in (
        (1.0, 1.0, 2.0),
        (2.0, 2.0, 4.0),
        (-1.0, 2.0, 1.0),
        (2.0, -1.0, 1.0),
        (1.0, 1.0, 0.0),
    ):
        expect_refusal(f, x, R, accel, 1.0, 0.01, gains=VerticalGains(*bad))
    edge = VerticalGains(1.0, 1.0, 0.99)
    moved = numbers(f(x, R, accel, x.z + 1.0, 0.01, gains=edge)[2], ())
    expect_close(moved, x.b_z - 0.0099, atol=1e-3)
