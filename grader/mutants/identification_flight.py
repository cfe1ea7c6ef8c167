"""Lab 05, known wrong answers: mass, inertia and attitude loop in flight."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab.exercises import bench, draw
from uavlab.exercises.identification import (
    attitude_response,
    inertia_step,
    mass_step,
)
from uavlab.solutions import identification as right
from uavlab.types import InertiaMemory, MassMemory

CANARY = "canary-e51eb8cfead235eb023ac5d7"

# mass_step --------------------------------------------------------------------------------------------


@sample(mass_step)
def weighings(rng: np.random.Generator) -> list[Arguments]:
    drawn = []
    for dt in (0.01, 1.0 / 60.0, 0.1, 0.4):
        was = rng.uniform((-1.0, 8.0, 4.0, 0.4), (1.0, 15.0, 9.0, 0.9))
        R, u_1 = draw.tilted(rng, 0.3, 0.7), float(rng.uniform(9.0, 16.0))
        named = {"a": float(rng.uniform(0.2, 1.0)), "k": float(rng.uniform(0.1, 1.0)), "g": 9.81}
        memory = MassMemory(*(float(x) for x in was))
        drawn.append((memory, float(rng.uniform(-2.0, 2.0)), R, u_1, dt, named))
    return drawn


def filtered(memory, v_z, lift, dt, a, g):
    keep = np.exp(-a * dt)
    return tuple(x + keep * (was - x) for was, x in zip(memory[:3], (v_z, lift, g), strict=True))


def learnt(inverse, y, u, amount):
    """1/m after (10) with everything held, exactly."""
    return inverse + (1.0 - np.exp(-amount * u * u)) * (y / u - inverse)


@mutant(
    mass_step,
    hint="This is (9) as printed, with g = +9.81: z up and g positive it is z̈ + g, or the mass comes out negative.",
)
def sign_of_the_paper(memory, v_z, R, u_1, dt, *, a, k, g):
    v_f, lift, g_f = filtered(memory, v_z, u_1 * R[2, 2], dt, a, g)
    y = a * (v_z - v_f) - g_f
    return MassMemory(v_f, lift, g_f, learnt(memory.inverse, y, lift, k * dt))


@mutant(
    mass_step,
    hint="g must pass the same filter as the rest: unfiltered, the estimate is wrong until the filters are full.",
)
def g_not_filtered(memory, v_z, R, u_1, dt, *, a, k, g):
    v_f, lift, g_f = filtered(memory, v_z, u_1 * R[2, 2], dt, a, g)
    y = a * (v_z - v_f) + g
    return MassMemory(v_f, lift, g_f, learnt(memory.inverse, y, lift, k * dt))


@mutant(
    mass_step, hint="g is missing in (9): in hover nothing accelerates, and yet there is thrust."
)
def g_missing(memory, v_z, R, u_1, dt, *, a, k, g):
    v_f, lift, g_f = filtered(memory, v_z, u_1 * R[2, 2], dt, a, g)
    return MassMemory(v_f, lift, g_f, learnt(memory.inverse, a * (v_z - v_f), lift, k * dt))


@mutant(
    mass_step,
    hint="This is a step of Euler: (10) is stiff, and at a rate below a hundred hertz it runs away.",
)
def euler(memory, v_z, R, u_1, dt, *, a, k, g):
    v_f, lift, g_f = filtered(memory, v_z, u_1 * R[2, 2], dt, a, g)
    y = a * (v_z - v_f) + g_f
    grown = memory.inverse + dt * k * (y - memory.inverse * lift) * lift
    return MassMemory(v_f, lift, g_f, grown)


@mutant(mass_step, hint="The lean is forgotten: only the part u_1 z_B·z_W of the thrust lifts.")
def lean_forgotten(memory, v_z, R, u_1, dt, *, a, k, g):
    return right.mass_step(memory, v_z, np.eye(3), u_1, dt, a=a, k=k, g=g)


@mutant(mass_step, hint="The factor a is missing in (8): P(s) z̈ = a (ż − ż_fil).")
def a_missing(memory, v_z, R, u_1, dt, *, a, k, g):
    v_f, lift, g_f = filtered(memory, v_z, u_1 * R[2, 2], dt, a, g)
    y = (v_z - v_f) + g_f
    return MassMemory(v_f, lift, g_f, learnt(memory.inverse, y, lift, k * dt))


@mutant(mass_step, hint="The difference in (8) has the wrong sign: it is ż − ż_fil.")
def difference_negated(memory, v_z, R, u_1, dt, *, a, k, g):
    v_f, lift, g_f = filtered(memory, v_z, u_1 * R[2, 2], dt, a, g)
    y = a * (v_f - v_z) + g_f
    return MassMemory(v_f, lift, g_f, learnt(memory.inverse, y, lift, k * dt))


@mutant(
    mass_step,
    hint="The estimate steps before the filters, on their old values: first the filters, then 1/m.",
)
def old_filters(memory, v_z, R, u_1, dt, *, a, k, g):
    y = a * (v_z - memory.v_z) + memory.g
    inverse = learnt(memory.inverse, y, memory.lift, k * dt)
    return MassMemory(*filtered(memory, v_z, u_1 * R[2, 2], dt, a, g), inverse)


@mutant(
    mass_step, hint="The exponent lacks the thrust: 1/m closes its gap at the rate k · thrust²."
)
def rate_of_k(memory, v_z, R, u_1, dt, *, a, k, g):
    v_f, lift, g_f = filtered(memory, v_z, u_1 * R[2, 2], dt, a, g)
    y = a * (v_z - v_f) + g_f
    share = 1.0 - np.exp(-k * dt)
    return MassMemory(v_f, lift, g_f, memory.inverse + share * (y / lift - memory.inverse))


@mutant(
    mass_step,
    hint="The filters make steps of Euler: an exact one closes 1 − exp(−a dt) of the gap.",
)
def filters_of_euler(memory, v_z, R, u_1, dt, *, a, k, g):
    return right.mass_step(memory, v_z, R, u_1, dt, a=a, k=k, g=g)._replace(**{
        name: was + a * dt * (x - was)
        for name, was, x in zip(
            ("v_z", "lift", "g"), memory[:3], (v_z, u_1 * R[2, 2], g), strict=True
        )
    })


# inertia_step -----------------------------------------------------------------------------------------


@sample(inertia_step)
def shakes(rng: np.random.Generator) -> list[Arguments]:
    drawn = []
    for dt in (0.01, 0.05, 0.2, 0.5):
        was = InertiaMemory(
            draw.vector(rng), rng.uniform(0.1, 0.5, size=3), rng.uniform(20.0, 80.0, size=3)
        )
        omega, torque = draw.vector(rng), rng.uniform(0.1, 0.5, size=3)
        named = {"a": float(rng.uniform(0.2, 1.0)), "k": float(rng.uniform(50.0, 500.0))}
        drawn.append((was, omega, torque, dt, named))
    return drawn


def turned(memory, omega, torque, dt, a):
    keep = np.exp(-a * dt)
    return omega + keep * (memory.omega - omega), torque + keep * (memory.torque - torque)


@mutant(inertia_step, hint="There is no gravity in a turn: y is a (ω − ω_fil), nothing else.")
def gravity_kept(memory, omega, torque, dt, *, a, k):
    w_f, u = turned(memory, omega, torque, dt, a)
    return InertiaMemory(w_f, u, learnt(memory.inverse, a * (omega - w_f) + 9.81, u, k * dt))


@mutant(
    inertia_step, hint="This is a step of Euler, which runs away where k · torque² · dt is above 2."
)
def euler_of_inertia(memory, omega, torque, dt, *, a, k):
    w_f, u = turned(memory, omega, torque, dt, a)
    y = a * (omega - w_f)
    return InertiaMemory(w_f, u, memory.inverse + dt * k * (y - memory.inverse * u) * u)


@mutant(inertia_step, hint="The factor a is missing in (8).")
def a_missing_in_the_turn(memory, omega, torque, dt, *, a, k):
    w_f, u = turned(memory, omega, torque, dt, a)
    return InertiaMemory(w_f, u, learnt(memory.inverse, omega - w_f, u, k * dt))


@mutant(inertia_step, hint="The difference in (8) has the wrong sign: it is ω − ω_fil.")
def turn_negated(memory, omega, torque, dt, *, a, k):
    w_f, u = turned(memory, omega, torque, dt, a)
    return InertiaMemory(w_f, u, learnt(memory.inverse, a * (w_f - omega), u, k * dt))


@mutant(
    inertia_step,
    hint="The axes are mixed: each has its own error and its own torque, and learns by itself.",
)
def axes_mixed(memory, omega, torque, dt, *, a, k):
    w_f, u = turned(memory, omega, torque, dt, a)
    y, square = a * (omega - w_f), u @ u
    share = (1.0 - np.exp(-k * dt * square)) / square
    return InertiaMemory(w_f, u, memory.inverse + share * u * (y - memory.inverse * u))


@mutant(
    inertia_step, hint="The exponent lacks the torque: 1/J closes its gap at the rate k · torque²."
)
def rate_of_k_alone(memory, omega, torque, dt, *, a, k):
    w_f, u = turned(memory, omega, torque, dt, a)
    share = 1.0 - np.exp(-k * dt)
    return InertiaMemory(w_f, u, memory.inverse + share * (a * (omega - w_f) / u - memory.inverse))


@mutant(
    inertia_step,
    hint="The torque is not filtered: it must pass the same filter as the angular velocity.",
)
def torque_not_filtered(memory, omega, torque, dt, *, a, k):
    w_f, _ = turned(memory, omega, torque, dt, a)
    y = a * (omega - w_f)
    return InertiaMemory(w_f, torque, learnt(memory.inverse, y, torque, k * dt))


# attitude_response ------------------------------------------------------------------------------------


@sample(attitude_response)
def stick_flights(rng: np.random.Generator) -> list[Arguments]:
    drawn = []
    for noise in (0.0, 0.002, 0.003, 0.004):
        t, b = np.arange(0.0, 12.0, 0.04), bench.closed_loop(rng)
        reference = bench.stick(rng, t)
        drawn.append((t, reference, bench.loop(t, reference, *b) + noise * rng.normal(size=300)))
    return drawn


@mutant(
    attitude_response, hint="b_r is fixed to b_0: whether the loop arrives is to be measured, too."
)
def gain_of_one(t, reference, measured):
    b_0, b_1, _ = right.attitude_response(t, reference, measured)
    return b_0, b_1, b_0


@mutant(
    attitude_response, hint="Reference and measurement are swapped: the reference is the input."
)
def swapped(t, reference, measured):
    s, ref, said = right._spectra(t, measured, reference)
    return tuple(right._iterated_fit(s, ref, said)[0][:3])


@mutant(
    attitude_response,
    hint="The frequencies are in hertz: ω is 2π times that, or b_1 is 2π too small and the others 4π².",
)
def in_hertz(t, reference, measured):
    b_0, b_1, b_r = right.attitude_response(t, reference, measured)
    turn = 2.0 * np.pi
    return b_0 / turn**2, b_1 / turn, b_r / turn**2


@mutant(attitude_response, hint="The order is b_0, b_1, b_r.")
def rate_first(t, reference, measured):
    b_0, b_1, b_r = right.attitude_response(t, reference, measured)
    return b_1, b_0, b_r


@mutant(
    attitude_response,
    hint="b_1 has the wrong sign: it damps. Mind the sign of i in the transform.",
)
def damping_negated(t, reference, measured):
    b_0, b_1, b_r = right.attitude_response(t, reference, measured)
    return b_0, -b_1, b_r


@mutant(
    attitude_response,
    hint="These are pace, damping and gain of the loop: b_0, b_1 and b_r of (12) are asked for.",
)
def pace_and_damping(t, reference, measured):
    b_0, b_1, b_r = right.attitude_response(t, reference, measured)
    return np.sqrt(b_0), b_1 / (2.0 * np.sqrt(b_0)), b_r / b_0


@mutant(
    attitude_response,
    hint="Noise that is differentiated twice drowns the tilt: fit spectra, or what the model would have done.",
)
def differences_fitted(t, reference, measured):
    rate = np.gradient(measured, t)
    M = np.stack((-measured, -rate, reference), axis=1)
    return tuple(np.linalg.lstsq(M, np.gradient(rate, t), rcond=None)[0])


@mutant(
    attitude_response,
    hint="The record is taken to begin and end at rest: what its ends leave in the transforms counts.",
)
def ends_forgotten(t, reference, measured):
    s, ref, said = right._spectra(t, reference, measured)
    M = np.stack((-said, -s * said, ref), axis=1) / (s**2 + 8.0 * s + 40.0)[:, None]
    y = s**2 * said / (s**2 + 8.0 * s + 40.0)
    x = np.linalg.lstsq(np.vstack((M.real, M.imag)), np.append(y.real, y.imag), rcond=None)[0]
    return tuple(x)
