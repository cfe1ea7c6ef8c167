"""The public checks of lab 05: what was put into a made-up measurement must come out. The exercises are beside it."""

from __future__ import annotations

import numpy as np

from uavlab.exercises import bench, draw
from uavlab.exercises.expect import expect_record, expect_refusal
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.types import Array, InertiaMemory, MassMemory

# Sensors at rest --------------------------------------------------------------------------------------


def still(rng: np.random.Generator, bias: Array, n: int = 60) -> Array:
    """Readings (n, 3) of a gyro at rest, whose noise of 0.01 rad/s has the mean zero."""
    noise = rng.normal(size=(n, 3))
    return bias + 0.01 * (noise - noise.mean(axis=0)) / noise.std(axis=0)


def mean_of_the_readings(f: Function, rng: np.random.Generator) -> None:
    """The bias must be the mean of the readings, axis by axis."""
    for n in (40, 75):
        bias = draw.vector(rng, 0.1)
        expect_close(f(still(rng, bias, n), 0.02), bias)


def refused_when_it_moved(f: Function, rng: np.random.Generator) -> None:
    """Readings that spread more than max_std along any axis must raise ValueError, the others must not."""
    for axis in range(3):
        bias = draw.vector(rng, 0.1)
        samples = still(rng, bias)
        expect_close(f(samples, 0.011), bias)
        samples[20:40, axis] += 0.2
        expect_refusal(f, samples, 0.05)


def gravity_in_every_orientation(f: Function, rng: np.random.Generator) -> None:
    """T (a_m − b) must be +9.81 m/s² along the direction that is up, in every orientation."""
    for n in (4, 12):
        made, R = bench.sensor(rng), bench.attitudes(rng, n)
        T, b = expect_record(f(bench.at_rest(made, R), R), (3, 3), (3,))
        for turn, reading in zip(R, bench.at_rest(made, R), strict=True):
            expect_close(turn @ T @ (reading - b), -bench.DOWN, atol=1e-7)


# Motors and thrust ------------------------------------------------------------------------------------


def one_clean_step(f: Function, rng: np.random.Generator) -> None:
    """From a step without noise the time constant must come out to one percent, whatever it is."""
    for up in (True, False):
        tau, n = float(rng.uniform(0.03, 0.08)), 160
        t = np.linspace(0.0, rng.uniform(5.0, 11.0) * tau, n)
        low, high = float(rng.uniform(100.0, 300.0)), float(rng.uniform(400.0, 900.0))
        start, end = (low, high) if up else (high, low)
        speed = bench.lag(t, np.full(n, end), tau, start)
        expect_close(f(t, np.full(n, end), speed), tau, atol=0.01 * tau)


def on_a_parabola(f: Function, rng: np.random.Generator) -> None:
    """Of points on a parabola its three coefficients must come out, the constant one first."""
    for n in (3, 12):
        p = rng.uniform(0.5, 2.0, size=3) * rng.choice((-1.0, 1.0), size=3)
        x = rng.permutation(np.linspace(0.3, 3.0, n))
        expect_close(f(x, p[0] + p[1] * x + p[2] * x * x), p, atol=1e-7)


def hovers_on_a_curve(f: Function, rng: np.random.Generator) -> None:
    """The curve through hovers that lie on one must be that one, by eq. (33)."""
    for n in (2, 5):
        a_t, b_t = draw.thrust_curve(rng)
        mass = rng.permutation(np.linspace(1.0, 6.0, n))
        throttle = a_t * np.sqrt(mass * 9.81) + b_t
        expect_close(expect_record(f(throttle, mass, 9.81), (), ()), (a_t, b_t))


def on_the_moon(f: Function, rng: np.random.Generator) -> None:
    """The slope must be that of force, not of mass: where g is smaller the same hovers make it larger."""
    mass, throttle = rng.uniform(1.0, 6.0, size=6), rng.uniform(0.3, 0.8, size=6)
    here = expect_record(f(throttle, mass, 9.81), (), ())
    there = expect_record(f(throttle, mass, 1.62), (), ())
    expect_close(there[0] * np.sqrt(1.62), here[0] * np.sqrt(9.81))
    expect_close(there[1], here[1])
    lines = np.polyfit(np.sqrt(9.81 * mass), throttle, 1)
    expect_close(here, lines, "The line through the points on Earth is not the best one.")


# Drag -------------------------------------------------------------------------------------------------


def pulled(V: Array, a_z: Array, c_2: Array, c: Array, offset: Array) -> Array:
    """Specific force [m/s²], body, (n, 3), of an aircraft with this drag."""
    return np.column_stack((-np.sqrt(a_z)[:, None] * (c_2 * V * np.abs(V) + c * V + offset), a_z))


def an_ideal_sweep(f: Function, rng: np.random.Generator) -> None:
    """Of a flight without noise, c and offset of both axes must come out, and R² must be 1."""
    for n in (8, 60):
        V, a_z = bench.sweep(rng, n)
        c, offset = rng.uniform(0.04, 0.3, size=2), rng.uniform(-0.1, 0.1, size=2)
        got = expect_record(f(pulled(V, a_z, np.zeros(2), c, offset), V), (2,), (2,), (2,))
        for have, want in zip(got, (c, offset, np.ones(2)), strict=True):
            expect_close(have, want)


def an_ideal_fast_sweep(f: Function, rng: np.random.Generator) -> None:
    """Of a flight without noise, both coefficients and the offset must come out, and R² must be 1."""
    for n in (12, 60):
        V, a_z = bench.sweep(rng, n)
        c_2, c = rng.uniform(0.002, 0.02, size=2), rng.uniform(0.02, 0.2, size=2)
        offset = rng.uniform(-0.1, 0.1, size=2)
        got = expect_record(f(pulled(V, a_z, c_2, c, offset), V), (2,), (2,), (2,), (2,))
        for have, want in zip(got, (c_2, c, offset, np.ones(2)), strict=True):
            expect_close(have, want)


# Mass and inertia -------------------------------------------------------------------------------------


def expect_mass_memory(got: object) -> MassMemory:
    """`got` as a MassMemory of plain numbers, or fail the check."""
    return MassMemory(*(float(x) for x in expect_record(got, (), (), (), ())))


def weighed_in_hover(f: Function, rng: np.random.Generator) -> None:
    """In a long hover, level or leaning, the estimate must become the mass that the thrust carries."""
    for rate in (60.0, 500.0):
        m, R = float(rng.uniform(0.8, 3.0)), draw.tilted(rng, 0.0, 0.6)
        u_1 = m * 9.81 / R[2, 2]
        memory = MassMemory(0.3, m * 9.81, 9.81, 1.0 / (1.6 * m))
        for _ in range(30):
            memory = f(memory, 0.3, R, u_1, 1.0 / rate, a=0.2, k=2.0, g=9.81)
            memory = expect_mass_memory(memory)
        expect_close(1.0 / memory.inverse, m, atol=1e-3)


def filters_close_a_share_of_the_gap(f: Function, rng: np.random.Generator) -> None:
    """In ln 2 / a seconds each of the three filters must close half of its gap, and in twice that three quarters."""
    for share, turns in ((0.5, 1.0), (0.25, 2.0)):
        a, R = float(rng.uniform(0.2, 2.0)), draw.tilted(rng, 0.1, 0.6)
        v_z, u_1, g = (float(x) for x in rng.uniform((-1.0, 5.0, 3.0), (1.0, 20.0, 10.0)))
        was = MassMemory(
            *(float(x) for x in rng.uniform((-1.0, 5.0, 3.0, 0.4), (1.0, 20.0, 10, 1)))
        )
        new = expect_mass_memory(f(was, v_z, R, u_1, turns * np.log(2.0) / a, a=a, k=1e-3, g=g))
        aims = np.array((v_z, u_1 * R[2, 2], g))
        expect_close(new[:3] - aims, share * (np.array(was[:3]) - aims), "Another share is left.")


def pushed_evenly(f: Function, rng: np.random.Generator) -> None:
    """Turned ever faster by an even torque, the aircraft must come out with the inertia that it has, axis by axis."""
    J, a, dt = rng.uniform(0.01, 0.05, size=3), 0.5, 0.005
    torque = rng.uniform(0.1, 0.3, size=3) * rng.choice((-1.0, 1.0), size=3)
    memory = InertiaMemory(-torque / J / a, torque, 0.5 / J)  # a filter is 1/a behind a ramp
    for i in range(1, 61):
        got = f(memory, torque / J * dt * i, torque, dt, a=a, k=5e3)
        memory = InertiaMemory(*expect_record(got, (3,), (3,), (3,)))
    expect_close(memory.inverse * J, np.ones(3), "It is another inertia.", atol=0.01)


# The attitude loop ------------------------------------------------------------------------------------


def a_clean_flight(f: Function, rng: np.random.Generator) -> None:
    """Of a flight without noise that begins and ends at rest, all three numbers must come out to three percent."""
    for _ in range(2):
        b = np.array(bench.closed_loop(rng))
        t = np.arange(0.0, 14.0, 0.02)
        ends = np.clip(np.minimum(t, 11.0 - t), 0.0, 1.0)
        reference = ends * bench.stick(rng, t)
        got = numbers(f(t, reference, bench.loop(t, reference, *b)), (3,))
        expect(np.all(np.abs(got - b) < 0.03 * b), "b_0, b_1 or b_r is off by more than 3 %.")
