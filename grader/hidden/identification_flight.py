"""Lab 05, hidden checks, the second half: what is measured in flight, drag, mass, inertia and the attitude loop."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from grader.material import hidden
from uavlab.exercises import bench, draw
from uavlab.exercises.expect import expect_record, expect_refusal
from uavlab.exercises.identification import (
    attitude_response,
    drag_coefficient,
    inertia_step,
    mass_step,
    quadratic_drag,
)
from uavlab.exercises.identification_checks import expect_mass_memory, pulled
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.types import Array, InertiaMemory, MassMemory

CANARY = "canary-918e1146001bb82edf350dcf"

# Drag -------------------------------------------------------------------------------------------------


def flown(rng: np.random.Generator, n: int, c_2: float = 0.0) -> tuple[Array, Array]:
    """Specific forces (n, 3) and velocities (n, 2) of a flight with drag and noise, the axes apart."""
    V, a_z = bench.sweep(rng, n)
    c, offset = rng.uniform(0.04, 0.2, size=2), rng.uniform(0.05, 0.3, size=2)
    accel = pulled(V, a_z, c_2 * rng.uniform(0.5, 1.0, size=2), c, offset)
    accel[:, :2] += rng.uniform(0.2, 0.6, size=2) * rng.normal(size=(n, 2))
    return accel, V


def lines_of(accel: Array, V: Array) -> list[Array]:
    """What least squares says of each axis, after numpy: c, offset and R², each (2,)."""
    y = -accel[:, :2] / np.sqrt(accel[:, 2:])
    fits = [np.polyfit(V[:, i], y[:, i], 1) for i in (0, 1)]
    r2 = [np.corrcoef(V[:, i], y[:, i])[0, 1] ** 2 for i in (0, 1)]
    return [*np.transpose(fits), np.array(r2)]


def expect_lines(got: object, want: list[Array]) -> None:
    """Fail the check unless `got` is c, offset and R² of these lines."""
    for have, wish in zip(expect_record(got, (2,), (2,), (2,)), want, strict=True):
        expect_close(have, wish, "It is not the line of least squares, or not its R².", atol=1e-8)


@hidden(drag_coefficient, weight=2.0)
def best_line_in_noise(f: Function, rng: np.random.Generator) -> None:
    """With noise, c and offset must be those of least squares, axis by axis, and R² the one of that fit."""
    for n in (25, 80):
        accel, V = flown(rng, n)
        expect_lines(f(accel, V), lines_of(accel, V))


@hidden(drag_coefficient)
def free_fall_says_nothing(f: Function, rng: np.random.Generator) -> None:
    """Samples near free fall, or in a dive, must change nothing, whatever their lateral force."""
    accel, V = flown(rng, 30)
    want = lines_of(accel, V)
    dive = np.column_stack((rng.normal(size=(5, 2)), (0.9, 0.3, -1e-3, -0.8, -6.0)))
    mix = rng.permutation(35)
    much, fast = np.vstack((accel, dive))[mix], np.vstack((V, 9.0 * rng.normal(size=(5, 2))))[mix]
    expect_lines(f(much, fast), want)


@hidden(drag_coefficient)
def other_units_and_axes(f: Function, rng: np.random.Generator) -> None:
    """With the axes exchanged the answers must be exchanged; with speeds in km/h c is smaller and R² is the same."""
    accel, V = flown(rng, 30)
    c, offset, r2 = lines_of(accel, V)
    expect_lines(f(accel[:, (1, 0, 2)], V[:, ::-1].copy()), [x[::-1] for x in (c, offset, r2)])
    expect_lines(f(accel, 3.6 * V), [c / 3.6, offset, r2])


@hidden(drag_coefficient, weight=0.5)
def hovering_only(f: Function, rng: np.random.Generator) -> None:
    """An aircraft that moves at one speed only along an axis must raise ValueError; with a sweep it must not."""
    accel, V = flown(rng, 20)
    expect_lines(f(accel, V), lines_of(accel, V))
    for axis in (0, 1):
        held = V.copy()
        held[:, axis] = rng.choice((0.0, 3.0))
        expect_refusal(f, accel, held)


def parabolas_of(accel: Array, V: Array) -> list[Array]:
    """What least squares says of each axis with V|V|, after numpy: c_2, c, offset and R², each (2,)."""
    said = []
    for i in (0, 1):
        y = -accel[:, i] / np.sqrt(accel[:, 2])
        M = np.column_stack((V[:, i] * np.abs(V[:, i]), V[:, i], np.ones(len(V))))
        x = np.linalg.pinv(M) @ y
        said.append((*x, np.var(M @ x) / np.var(y)))
    return list(np.transpose(said))


def expect_parabolas(got: object, want: list[Array]) -> None:
    """Fail the check unless `got` is c_2, c, offset and R² of these fits."""
    for have, wish in zip(expect_record(got, (2,), (2,), (2,), (2,)), want, strict=True):
        expect_close(have, wish, "It is not the fit of least squares, or not its R².", atol=1e-8)


@hidden(quadratic_drag, weight=2.0)
def best_parabola_in_noise(f: Function, rng: np.random.Generator) -> None:
    """With noise, the coefficients must be those of least squares, axis by axis, and R² the one of that fit."""
    for n in (25, 80):
        accel, V = flown(rng, n, 0.02)
        expect_parabolas(f(accel, V), parabolas_of(accel, V))


@hidden(quadratic_drag)
def the_other_way_round(f: Function, rng: np.random.Generator) -> None:
    """Flown the other way round, with the force turned round too, only the offset may change, and that its sign."""
    accel, V = flown(rng, 30, 0.02)
    c_2, c, offset, r2 = parabolas_of(accel, V)
    expect_parabolas(f(accel * (-1.0, -1.0, 1.0), -V), [c_2, c, -offset, r2])
    expect_parabolas(f(accel, 3.6 * V), [c_2 / 3.6**2, c / 3.6, offset, r2])


@hidden(quadratic_drag)
def a_dive_says_nothing(f: Function, rng: np.random.Generator) -> None:
    """Samples near free fall must change nothing, nor may the order of the samples."""
    accel, V = flown(rng, 30, 0.02)
    want = parabolas_of(accel, V)
    dive, mix = np.column_stack((rng.normal(size=(3, 2)), (0.8, -1e-3, -5.0))), rng.permutation(33)
    fast = 9.0 * rng.normal(size=(3, 2))
    expect_parabolas(f(np.vstack((accel, dive))[mix], np.vstack((V, fast))[mix]), want)


@hidden(quadratic_drag, weight=0.5)
def one_speed_either_way(f: Function, rng: np.random.Generator) -> None:
    """One speed, to and fro along an axis, cannot tell the parts apart and must raise ValueError; a sweep can."""
    accel, V = flown(rng, 20, 0.02)
    expect_parabolas(f(accel, V), parabolas_of(accel, V))
    for axis in (0, 1):
        held = V.copy()
        held[:, axis] = 4.0 * np.where(np.arange(20) % 2, 1.0, -1.0)
        expect_refusal(f, accel, held)


# Mass and inertia -------------------------------------------------------------------------------------


@hidden(mass_step, weight=2.0)
def error_fades_as_it_should(f: Function, rng: np.random.Generator) -> None:
    """With the filters at rest, the error of 1/m must shrink by exp(−k · thrust² · dt), in steps of any length."""
    for turns in (0.1, 1.0, 2.5, 8.0):
        m, k, R = (
            float(rng.uniform(0.8, 3.0)),
            float(rng.uniform(0.2, 2.0)),
            draw.tilted(rng, 0.2, 0.7),
        )
        lift, v_z, g = m * 9.81, float(rng.uniform(-2.0, 2.0)), 9.81
        dt, wrong = turns / (k * lift**2), float(rng.uniform(0.1, 0.5))
        was = MassMemory(v_z, lift, g, 1.0 / m + wrong)
        new = expect_mass_memory(f(was, v_z, R, lift / R[2, 2], dt, a=0.2, k=k, g=g))
        expect_close(new.inverse - 1.0 / m, wrong * np.exp(-turns), "It shrinks otherwise.")


@hidden(mass_step, weight=2.0)
def true_from_the_first_second(f: Function, rng: np.random.Generator) -> None:
    """A true estimate must stay true while the filters fill, and while the aircraft climbs and sinks, leaning."""
    for g in (9.81, 3.7):
        m, a, dt = float(rng.uniform(0.8, 3.0)), float(rng.uniform(0.2, 1.0)), 0.004
        v_z, start = float(rng.uniform(-1.0, 1.0)), float(rng.uniform(-2.0, 2.0))
        memory = MassMemory(v_z, 0.0, 0.0, 1.0 / m)
        for i in range(110):
            R, u_1 = draw.tilted(rng, 0.3, 0.6), m * g * (1.2 + 0.6 * np.sin(0.15 * i + start))
            v_z += dt * (u_1 * R[2, 2] / m - g)
            memory = expect_mass_memory(f(memory, v_z, R, u_1, dt, a=a, k=50.0, g=g))
            expect(abs(memory.inverse * m - 1.0) < 0.02, "The estimate leaves the truth.")
    # An estimate that never learns would stay true as well.
    wrong = MassMemory(v_z, m * 9.81, 9.81, 2.0 / m)
    new = expect_mass_memory(f(wrong, v_z, np.eye(3), m * 9.81, 1.0, a=a, k=1.0, g=9.81))
    expect_close(new.inverse * m, 1.0, "It does not learn.", atol=1e-3)


@hidden(mass_step)
def weak_rotors_look_heavy(f: Function, rng: np.random.Generator) -> None:
    """Rotors that give less than was commanded must make the aircraft look heavier, by just that share."""
    for share in (0.938, float(rng.uniform(0.7, 0.9))):
        m, dt = 1.308, 1.0 / 60.0
        u_1 = m * 9.81 / share
        memory = MassMemory(0.0, u_1, 9.81, 1.0)
        for _ in range(12):
            memory = expect_mass_memory(f(memory, 0.0, np.eye(3), u_1, dt, a=0.188, k=1.0, g=9.81))
        expect_close(1.0 / memory.inverse, m / share, "It looks like another mass.", atol=1e-6)


@hidden(mass_step)
def nothing_is_learnt_without_thrust(f: Function, rng: np.random.Generator) -> None:
    """Without thrust the estimate must stand still, in free fall too; with a little it must move a little."""
    was = MassMemory(float(rng.uniform(-3.0, 0.0)), 0.0, 9.81, float(rng.uniform(0.3, 1.0)))
    new = expect_mass_memory(f(was, -4.0, np.eye(3), 0.0, 0.02, a=0.5, k=1.0, g=9.81))
    expect_close(new.inverse, was.inverse, "It has moved without thrust.")
    fed = was._replace(lift=1e-3)  # so little that (10) is as good as its first term
    got = expect_mass_memory(f(fed, was.v_z, np.eye(3), 1e-3, 0.02, a=0.5, k=1.0, g=9.81))
    gain = (got.inverse - was.inverse) / (0.02 * 1e-3)
    expect_close(gain, 9.81, "A little thrust moves it by k y lift dt.", atol=0.01)


@hidden(inertia_step, weight=2.0)
def each_error_fades_by_itself(f: Function, rng: np.random.Generator) -> None:
    """With the filters at rest, the error of each axis must shrink by exp(−k · torque² · dt), for any dt."""
    for turns in (0.1, 1.0, 6.0):
        torque = rng.uniform(0.1, 0.5, size=3) * rng.choice((-1.0, 1.0), size=3)
        inverse, omega, k = rng.uniform(20.0, 80.0, size=3), draw.vector(rng), 100.0
        dt = turns / (k * torque[0] ** 2)
        got = f(InertiaMemory(omega, torque, inverse), omega, torque, dt, a=0.3, k=k)
        new = InertiaMemory(*expect_record(got, (3,), (3,), (3,)))
        expect_close(new.inverse, inverse * np.exp(-k * torque**2 * dt), "It shrinks otherwise.")


@hidden(inertia_step)
def an_axis_without_torque(f: Function, rng: np.random.Generator) -> None:
    """An axis without torque must learn nothing, whatever the others do, and these must learn."""
    for axis in range(3):
        torque, omega, inverse = rng.uniform(0.1, 0.3, size=3), draw.vector(rng), np.full(3, 40.0)
        torque[axis] = 0.0
        got = f(InertiaMemory(np.zeros(3), torque, inverse), omega, torque, 0.1, a=2.0, k=1e5)
        new = InertiaMemory(*expect_record(got, (3,), (3,), (3,)))
        want = 2.0 * np.exp(-0.2) * omega  # y = a (ω − ω_fil)
        others = np.arange(3) != axis
        expect_close(new.inverse[axis], 40.0, "An axis without torque has learnt.")
        expect_close(
            (new.inverse * torque)[others], want[others], "It learns otherwise.", atol=1e-6
        )


@hidden(inertia_step)
def shaken_to_and_fro(f: Function, rng: np.random.Generator) -> None:
    """Shaken to and fro with three different torques, the aircraft must come out with its three inertias."""
    J, a, dt = rng.uniform(0.01, 0.05, size=3), 0.5, 0.004
    omega, memory = np.zeros(3), InertiaMemory(np.zeros(3), np.zeros(3), 1.5 / J)
    for i in range(90):
        torque = 0.4 * np.cos(np.array((0.05, 0.08, 0.11)) * i)
        omega = omega + dt * torque / J
        got = f(memory, omega, torque, dt, a=a, k=1e7)
        memory = InertiaMemory(*expect_record(got, (3,), (3,), (3,)))
    expect_close(memory.inverse * J, np.ones(3), "It is another inertia.", atol=0.05)


@hidden(inertia_step)
def filters_of_the_inertia(f: Function, rng: np.random.Generator) -> None:
    """The filters of angular velocity and torque must close the same share of their gaps, exp(−a dt) being left."""
    was = InertiaMemory(draw.vector(rng), draw.vector(rng), rng.uniform(20.0, 80.0, size=3))
    omega, torque, a = draw.vector(rng), draw.vector(rng), float(rng.uniform(0.5, 2.0))
    for once, twice in pairwise((0.2, 0.4, 0.8)):
        near, far = (
            expect_record(f(was, omega, torque, dt, a=a, k=1.0), (3,), (3,), (3,))
            for dt in (once, twice)
        )
        for i, aim in enumerate((omega, torque)):
            left = np.exp(-a * once)
            expect_close(near[i] - aim, left * (was[i] - aim), "Another share is left.")
            expect_close(far[i] - aim, left**2 * (was[i] - aim), "Another share is left.")


# The attitude loop ------------------------------------------------------------------------------------


def record(
    rng: np.random.Generator, b: tuple[float, ...], noise: float = 0.0, *, cut: bool = True
) -> tuple[Array, Array, Array]:
    """Times, reference and measurement of a flight of 14 s, which is cut out of a longer one."""
    t = np.arange(0.0, 18.0, 0.02)
    reference = bench.stick(rng, t)
    measured = bench.loop(t, reference, *b)
    part = slice(200, None) if cut else slice(None)
    return t[part], reference[part], measured[part] + noise * rng.normal(size=len(t[part]))


def expect_loop(got: object, b: Array, share: float) -> None:
    """Fail the check unless `got` is b_0, b_1, b_r to this share."""
    off = np.abs(numbers(got, (3,)) - b) / b
    expect(np.all(off < share), f"b_0, b_1 or b_r is off by more than {share:.0%}.")


@hidden(attitude_response)
def cut_out_of_a_flight(f: Function, rng: np.random.Generator) -> None:
    """A record that begins and ends in the middle of a swing must serve, with a trim on either signal too."""
    for _ in range(2):
        b = np.array(bench.closed_loop(rng))
        t, reference, measured = record(rng, tuple(b))
        expect_loop(f(t, reference, measured), b, 0.05)
        trims = rng.uniform(0.1, 0.3, size=2) * rng.choice((-1.0, 1.0), size=2)
        expect_loop(f(t, reference + trims[0], measured + trims[1]), b, 0.05)


@hidden(attitude_response, weight=2.0)
def a_second_flight(f: Function, rng: np.random.Generator) -> None:
    """From a noisy flight the model must be good enough to tell a second flight, to a tenth of its motion."""
    b = bench.closed_loop(rng)
    slower = (0.3 * b[0], 0.55 * b[1], 0.3 * b[2])  # one guess for all aircraft must not do
    got = numbers(f(*record(rng, slower)), (3,))
    expect(np.all(np.abs(got - slower) < 0.25 * np.array(slower)), "A number is off by a quarter.")
    got = numbers(f(*record(rng, b, 0.004)), (3,))
    expect(np.all(np.abs(got - b) < 0.25 * np.array(b)), "A number is off by a quarter.")
    t, reference, flew = record(rng, b, cut=False)
    told = bench.loop(t, reference, *got)
    expect(np.std(told - flew) < 0.1 * np.std(flew), "The model tells another second flight.")


@hidden(attitude_response)
def a_slower_clock(f: Function, rng: np.random.Generator) -> None:
    """On a clock of another pace b_0 and b_r must scale with its square, b_1 with it; size is no matter."""
    b, pace = np.array(bench.closed_loop(rng)), float(rng.uniform(0.4, 2.0))
    t, reference, measured = record(rng, tuple(b))
    size = float(rng.uniform(0.2, 3.0))
    got = numbers(f(pace * t + 100.0, size * reference, size * measured), (3,))
    expect_loop(got * (pace**2, pace, pace**2), b, 0.05)


@hidden(attitude_response)
def a_loop_that_does_not_arrive(f: Function, rng: np.random.Generator) -> None:
    """A loop that follows only a part of its reference, or swings, must be told as such."""
    for gain, damping in ((0.7, 0.25), (1.3, 0.7)):
        pace = float(rng.uniform(4.0, 8.0))
        b = np.array((pace**2, 2.0 * damping * pace, gain * pace**2))
        expect_loop(f(*record(rng, tuple(b))), b, 0.05)


@hidden(attitude_response, weight=0.5)
def nothing_happened(f: Function, rng: np.random.Generator) -> None:
    """A reference that stands still, or times that run backwards, must raise ValueError; a flight must not."""
    b = np.array(bench.closed_loop(rng))
    t, reference, measured = record(rng, tuple(b))
    expect_loop(f(t, reference, measured), b, 0.05)
    expect_refusal(f, t, np.full(len(t), 0.1), measured)
    expect_refusal(f, t[::-1].copy(), reference, measured)
