"""Hidden checks of lab 07, continued: what disturbs, what the aircraft weighs, and what its estimator is told."""

from __future__ import annotations

import numpy as np

from grader.material import hidden
from uavlab import frames, so3
from uavlab.exercises import draw
from uavlab.exercises.expect import of_shapes
from uavlab.exercises.geometric import disturbance_step, estimated_mass, unbiased_acceleration
from uavlab.exercises.geometric_checks import UP, ZERO, some_gains, some_mass
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.types import GRAVITY, Array, Vec3

CANARY = "canary-e04c86a1d93b47f5a2c7180f"

LEVEL = np.array((1.0, 1.0, 0.0))


def sums(f: Function, d_w: Vec3, d_b: Vec3, *inputs: object) -> tuple[Array, ...]:
    """Both sums after one step, as plain numbers."""
    return of_shapes(f(d_w, d_b, *inputs), (3,), (3,))


# disturbance_step -------------------------------------------------------------------------------------


@hidden(disturbance_step, weight=2.0)
def one_step_of_both(f: Function, rng: np.random.Generator) -> None:
    """From any sums, one step must add gain, error and time: in the world, and as the nose sees it."""
    for _ in range(4):
        k, dt, eta = some_gains(rng), float(rng.uniform(0.01, 0.1)), draw.angle(rng)
        d_w, d_b = (rng.uniform(-2.0, 2.0, size=3) * LEVEL for _ in range(2))
        e_p, c, s = draw.vector(rng), np.cos(eta), np.sin(eta)
        seen = np.array((c * e_p[0] + s * e_p[1], c * e_p[1] - s * e_p[0], 0.0))
        new_w, new_b = sums(f, d_w, d_b, e_p, eta, dt, k)
        expect_close((new_w - d_w) / dt, k.k_iw * e_p * LEVEL)
        expect_close((new_b - d_b) / dt, k.k_ib * seen)


@hidden(disturbance_step)
def learnt_in_a_turned_world(f: Function, rng: np.random.Generator) -> None:
    """In a turned world the first sum must be turned, and the second one the same; heights must not matter."""
    for _ in range(3):
        k, by, etas = some_gains(rng), draw.angle(rng), rng.uniform(-3.0, 3.0, size=5)
        errors = rng.normal(size=(5, 3))
        here = there = (ZERO, ZERO)
        for eta, e_p in zip(etas, errors, strict=True):
            here = sums(f, *here, e_p, float(eta), 0.1, k)
            other = so3.about_z(by) @ e_p + rng.normal() * UP
            there = sums(f, *there, other, float(eta + by), 0.1, k)
        expect(min(np.linalg.norm(here[0]), np.linalg.norm(here[1])) > 1e-6, "Nothing was learnt.")
        expect_close(there[0], so3.about_z(by) @ here[0])
        expect_close(there[1], here[1])
        expect_close(here[0], 0.1 * k.k_iw * errors.sum(axis=0) * LEVEL)


@hidden(disturbance_step)
def each_entry_at_its_limit(f: Function, rng: np.random.Generator) -> None:
    """An entry at its limit must stay there while the other one grows, and leave it at once when the error turns."""
    for side in (1.0, -1.0):
        k, small = some_gains(rng), float(rng.uniform(0.2, 0.5))
        e_p = np.array((side * 40.0, small, 3.0))
        d_w, d_b = sums(f, ZERO, ZERO, e_p, 0.0, 1.0, k)
        expect_close(d_w, (side * k.d_max, k.k_iw * small, 0.0))
        expect_close(d_b, (side * k.d_max, k.k_ib * small, 0.0))
        d_w, d_b = sums(f, d_w, d_b, -side * np.eye(3)[0], 0.0, 1.0, k)
        expect_close(d_w, (side * (k.d_max - k.k_iw), k.k_iw * small, 0.0))
        expect_close(d_b, (side * (k.d_max - k.k_ib), k.k_ib * small, 0.0))


@hidden(disturbance_step, weight=2.0)
def a_wind_and_a_crooked_motor(f: Function, rng: np.random.Generator) -> None:
    """Flown against a wind and a push that turns with the nose, nose turning, both together must be found."""
    m, dt, spin = some_mass(rng), 0.05, draw.pace(rng)
    wind, crooked = draw.vector(rng, 1.0) * LEVEL, draw.vector(rng, 1.0) * LEVEL
    k = some_gains(rng)._replace(k_iw=1.5 * m, k_ib=1.5 * m, d_max=10.0)
    r, v, d_w, d_b, H = ZERO, ZERO, ZERO, ZERO, np.eye(3)
    for tick in range(240):
        eta = float(np.clip(tick * dt - 4.0, 0.0, 1.0) * spin)  # it turns once, in the fifth second
        H = so3.about_z(eta)
        a = -6.0 * r - 4.0 * v + (wind + H @ crooked - d_w - H @ d_b) / m
        d_w, d_b = sums(f, d_w, d_b, r, eta, dt, k)
        v = v + dt * a
        r = r + dt * v
    expect(float(np.linalg.norm(r)) < 0.02, "It is still pushed off.")
    expect_close(d_w + H @ d_b, wind + H @ crooked, "Together they are another push.", atol=0.3)


# estimated_mass ---------------------------------------------------------------------------------------


@hidden(estimated_mass, weight=2.0)
def a_payload_is_found(f: Function, rng: np.random.Generator) -> None:
    """Flown with a payload, or without a battery, the mass must come to the true one, and the height back."""
    for extra in (float(rng.uniform(0.3, 0.8)), -float(rng.uniform(0.3, 0.8))):
        m, dt, z, v = some_mass(rng) + 1.0, 0.05, 0.0, 0.0
        k = some_gains(rng)._replace(k_m=float(0.5 * m))
        m_e = m
        for _ in range(160):
            lift = m_e * (GRAVITY - 10.0 * z - 5.0 * v)
            m_e = float(numbers(f(m_e, z, dt, m, k), ()))
            v += dt * (lift / (m + extra) - GRAVITY)
            z += dt * v
            expect(abs(z) < 3.0, "It flies away.")
        expect_close(m_e, m + extra, "The mass is another one.", atol=0.1)


@hidden(estimated_mass)
def one_step_of_the_mass(f: Function, rng: np.random.Generator) -> None:
    """From any mass, one step must add gain, time and how low it hangs, and half a step half of that."""
    for _ in range(4):
        k, m, e_z = some_gains(rng), some_mass(rng) + 2.0, float(rng.normal())
        m_e, dt = m + float(rng.uniform(-0.4, 0.4)), float(rng.uniform(0.01, 0.1))
        expect_close(float(numbers(f(m_e, e_z, dt, m, k), ())) + k.k_m * e_z * dt, m_e)
        half = float(numbers(f(m_e, e_z, 0.5 * dt, m, k), ()))
        expect_close(f(half, e_z, 0.5 * dt, m, k), m_e - k.k_m * e_z * dt)


@hidden(estimated_mass)
def between_two_masses(f: Function, rng: np.random.Generator) -> None:
    """The mass must stay within its limit of the nominal one on both sides, and leave it when the error turns."""
    for side in (1.0, -1.0):
        k, m = some_gains(rng), some_mass(rng) + 2.0
        at = float(numbers(f(m + side * 1.4, -side * 20.0, 1.0, m, k), ()))
        expect_close(at, m + side * k.m_max)
        expect_close(f(at, side * 0.5, 1.0, m, k), at - side * 0.5 * k.k_m)


@hidden(estimated_mass)
def never_lighter_than_air(f: Function, rng: np.random.Generator) -> None:
    """With a limit above the mass itself, a tenth of the mass must be left; upwards the limit is the limit."""
    for _ in range(2):
        k, m = some_gains(rng)._replace(m_max=20.0), some_mass(rng)
        expect_close(f(0.5 * m, 100.0, 1.0, m, k), 0.1 * m)
        expect_close(f(m, -200.0, 1.0, m, k), m + 20.0)


# unbiased_acceleration --------------------------------------------------------------------------------


@hidden(unbiased_acceleration, weight=2.0)
def what_newton_says(f: Function, rng: np.random.Generator) -> None:
    """For any thrust, attitude and push it must be the sum of forces over the mass, and gravity."""
    for _ in range(4):
        m, R, thrust = some_mass(rng), draw.aimed(rng, 0.1, 1.0), float(rng.uniform(5.0, 60.0))
        d_w, d_b = draw.vector(rng, 3.0), draw.vector(rng, 3.0)
        c, s = R[:2, 0] / np.hypot(*R[:2, 0])
        push = np.array((d_w[0] + c * d_b[0] - s * d_b[1], d_w[1] + s * d_b[0] + c * d_b[1], 0.0))
        pull = R @ (0.0, 0.0, thrust) + push - m * GRAVITY * UP
        expect_close(m * numbers(f(thrust, R, d_w, d_b, m), (3,)), pull)


@hidden(unbiased_acceleration)
def told_in_a_turned_world(f: Function, rng: np.random.Generator) -> None:
    """In a turned world it must be turned; the vertical entries of what disturbs must not matter."""
    for _ in range(3):
        m, R, by = some_mass(rng), draw.aimed(rng, 0.1, 1.0), so3.about_z(draw.angle(rng))
        d_w, d_b, thrust = (
            draw.vector(rng, 3.0),
            draw.vector(rng, 3.0),
            float(rng.uniform(5.0, 60.0)),
        )
        got = numbers(f(thrust, R, d_w, d_b, m), (3,))
        up = rng.normal(size=2)
        expect_close(f(thrust, by @ R, by @ d_w + up[0] * UP, d_b + up[1] * UP, m), by @ got)
        expect_close(got[2], thrust * R[2, 2] / m - GRAVITY)


@hidden(unbiased_acceleration)
def of_any_size(f: Function, rng: np.random.Generator) -> None:
    """Still in the air it must be zero for aircraft of all sizes, and all forces doubled must not change it."""
    for m in (0.3, 1.0, float(rng.uniform(5.0, 15.0))):
        d_w, d_b, eta = (
            draw.vector(rng, 0.5) * LEVEL,
            draw.vector(rng, 0.5) * LEVEL,
            draw.angle(rng),
        )
        R = so3.about_z(eta)
        expect_close(f(m * GRAVITY, R, -R @ d_b, d_b, m), ZERO)
        R, thrust = draw.aimed(rng, 0.1, 0.9), float(rng.uniform(0.5, 2.0) * m * GRAVITY)
        got = numbers(f(thrust, R, d_w, d_b, m), (3,))
        expect_close(f(2.0 * thrust, R, 2.0 * d_w, 2.0 * d_b, 2.0 * m), got)
        turned = so3.about_z(frames.heading(R)) @ d_b
        expect_close(got - numbers(f(thrust, R, ZERO, ZERO, m), (3,)), (d_w + turned) / m)
