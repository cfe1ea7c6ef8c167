"""Hidden checks of lab 07, continued: the whole controller, tick by tick and in flight."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import exp, pi, tan
from typing import Any, NamedTuple

import numpy as np

from grader.material import hidden
from uavlab import frames, so3
from uavlab.exercises import draw
from uavlab.exercises.expect import expect_record
from uavlab.exercises.geometric import GeometricController
from uavlab.exercises.geometric_checks import ZERO, forms, some_estimate, some_gains, some_mass
from uavlab.exercises.spec import Function, expect, expect_close
from uavlab.frames import Shift
from uavlab.gains import GeometricGains
from uavlab.types import GRAVITY, Array, Command, Estimate, Mat3, Reference, Vec3

CANARY = "canary-3c7a50be84d14f9a9e12c6f8"

G = np.array((0.0, 0.0, GRAVITY))
FLAT = np.array((1.0, 1.0, 0.0))
AT_ONCE = 1e-12  # [s] a tick in which nothing is learnt, before the command or after it

# What the law asks for --------------------------------------------------------------------------------


class Known(NamedTuple):
    """What a controller has learnt."""

    m_e: float
    d_w: Vec3 = ZERO
    d_b: Vec3 = ZERO


def axes(force: Vec3, eta: float) -> Mat3:
    """The attitude with its z axis along a force that points up, and this heading."""
    z, c, s = force / np.linalg.norm(force), np.cos(eta), np.sin(eta)
    x = np.array((c, s, -(z[0] * c + z[1] * s) / z[2]))
    x /= np.linalg.norm(x)
    return np.column_stack((x, np.cross(z, x), z))


def law(k: GeometricGains, known: Known, x: Estimate, y: Reference) -> list[Array]:
    """Thrust, rates and acceleration of MRS Sec. 5.6, in closed form."""
    R, m = x.R, known.m_e
    d = (known.d_w + so3.about_z(frames.heading(R)) @ known.d_b) * FLAT
    a = y.a + np.multiply(k.k_p, y.r - x.r) + np.multiply(k.k_v, y.v - x.v) + G
    f = m * a - d
    f[2] = max(f[2], 1.0)
    f[:2] *= min(1.0, f[2] * tan(k.tilt_max) / np.hypot(*f[:2]))
    R_d = axes(f, y.heading)
    turned = np.cross(R_d[:, 2], y.j) * m / np.linalg.norm(f)  # in the world
    S = R.T @ R_d
    rates = np.multiply(k.k_R, so3.vee(S - S.T)) / 2.0 + R_d.T @ turned * FLAT
    rates[2] += y.heading_rate * (1.0 - R_d[2, 0] ** 2) / R_d[2, 2] - rates[1] * R[2, 1] / R[2, 2]
    f_d = f @ R[:, 2]
    return [f_d, np.clip(rates, np.negative(k.rate_max), k.rate_max), (f_d * R[:, 2] + d) / m - G]


def agrees(command: object, want: Sequence[Any], message: str, atol: float = 1e-8) -> None:
    """Fail the check unless a command is what the law asks for."""
    for got, wish in zip(forms(command), want, strict=True):
        expect_close(got, wish, message, atol=atol)


def near(rng: np.random.Generator, x: Estimate) -> Reference:
    """A reference so near that no limit of tilt is met."""
    r, v = x.r + draw.vector(rng, 0.2), x.v + draw.vector(rng, 0.2)
    eta = frames.heading(x.R) + float(rng.uniform(-0.4, 0.4))
    return Reference(r, v, draw.vector(rng), draw.vector(rng, 2.0), eta, draw.pace(rng))


@hidden(GeometricController, weight=3.0)
def every_term_of_the_law(f: Function, rng: np.random.Generator) -> None:
    """With nothing to take over, the first command must be what (25), (26), (38) and (53) ask for, corrected."""
    for _ in range(4):
        k, m, x = some_gains(rng), some_mass(rng), some_estimate(rng)
        part, y = f(m, k), near(rng, x)
        _, command = part.step(part.init(x, None), x, y, AT_ONCE)
        agrees(command, law(k, Known(m), x, y), "It is another command.")


@hidden(GeometricController, weight=2.0)
def with_all_that_was_learnt(f: Function, rng: np.random.Generator) -> None:
    """After some ticks off the reference, nose turning, the command must be that of what these have taught."""
    for _ in range(2):
        k, m, x, dt = some_gains(rng), some_mass(rng) + 2.0, some_estimate(rng), 0.05
        part, known = f(m, k), Known(m)
        memory = part.init(x, None)
        for _ in range(8):
            y = near(rng, x)
            memory, command = part.step(memory, x, y, dt)
            agrees(command, law(k, known, x, y), "It has learnt something else.", atol=1e-7)
            known = taught(k, known, x, y, dt)
            x = x._replace(R=so3.about_z(0.5) @ x.R)


def taught(k: GeometricGains, known: Known, x: Estimate, y: Reference, dt: float) -> Known:
    """What is known after one more tick, far from all limits."""
    e, H = (x.r - y.r) * FLAT, so3.about_z(frames.heading(x.R))
    m_e = known.m_e - k.k_m * dt * (x.r[2] - y.r[2])
    return Known(m_e, known.d_w + k.k_iw * dt * e, known.d_b + k.k_ib * dt * (H.T @ e))


@hidden(GeometricController, weight=2.0)
def leans_no_further(f: Function, rng: np.random.Generator) -> None:
    """Far from its goal it must lean by its limit and no more, hold its height, and stay with its nose."""
    k, m, eta, to = some_gains(rng), some_mass(rng), draw.angle(rng), draw.angle(rng)
    k = k._replace(tilt_max=float(rng.uniform(0.5, 1.0)))
    force = m * (G + GRAVITY * tan(k.tilt_max) * np.array((np.cos(to), np.sin(to), 0.0)))
    x = Estimate(draw.vector(rng), ZERO, ZERO, axes(force, eta), ZERO)
    part, away = (
        f(m, k),
        400.0 * np.array((np.cos(to), np.sin(to), 0.0)) / np.append(k.k_p[:2], 1.0),
    )
    y = Reference(x.r + away, ZERO, ZERO, ZERO, eta, 0.0)
    _, command = part.step(part.init(x, None), x, y, AT_ONCE)
    want = [np.linalg.norm(force), ZERO, force / m - G]
    agrees(command, want, "It leans or lifts otherwise.")


@hidden(GeometricController)
def never_turns_over(f: Function, rng: np.random.Generator) -> None:
    """Far above its goal it must keep one newton of lift and stay upright, whatever it wants to do sideways."""
    k, m, eta = some_gains(rng), some_mass(rng), draw.angle(rng)
    for side, R in (
        (0.0, so3.about_z(eta)),
        (9.0, axes(np.array((tan(k.tilt_max), 0.0, 1.0)), eta)),
    ):
        x = Estimate(ZERO, ZERO, ZERO, R, ZERO)
        part, y = f(m, k), Reference(np.array((side, 0.0, -90.0)), ZERO, ZERO, ZERO, eta, 0.0)
        _, command = part.step(part.init(x, None), x, y, AT_ONCE)
        agrees(command, [1.0 / R[2, 2], ZERO, R[:, 2] / R[2, 2] / m - G], "It turns over.")


@hidden(GeometricController)
def turns_no_faster(f: Function, rng: np.random.Generator) -> None:
    """No body rate may pass its own limit, and one that would must be at it, the others as they are."""
    for _ in range(3):
        x = some_estimate(rng)
        k, m = some_gains(rng)._replace(rate_max=(0.3, 0.2, 0.4)), some_mass(rng)
        part, y = f(m, k), near(rng, x)._replace(j=draw.vector(rng, 20.0))
        _, command = part.step(part.init(x, None), x, y, AT_ONCE)
        want = law(k, Known(m), x, y)
        expect(float(np.abs(want[1]).max()) > 0.1, "")
        agrees(command, want, "Its rates are others.")


@hidden(GeometricController)
def learns_to_its_limits(f: Function, rng: np.random.Generator) -> None:
    """Held off for long, disturbances and mass must stop at their limits, and the command stay finite."""
    k, m = some_gains(rng), some_mass(rng) + 2.0
    eta = float(rng.uniform(-0.3, 0.3) + 0.5 * pi * rng.integers(4))
    x = Estimate(ZERO, ZERO, ZERO, so3.about_z(eta), ZERO)
    sides = rng.choice((-1.0, 1.0), size=3)
    H, part = so3.about_z(eta), f(m, k)
    off = H @ (sides * (0.7, 0.9, 0.4))  # ahead or behind, left or right, low or high
    y = Reference(off, ZERO, ZERO, ZERO, eta, 0.0)
    memory = part.init(x, None)
    for _ in range(60):
        memory, _ = part.step(memory, x, y, 2.0)
    _, command = part.step(memory, x, y, AT_ONCE)
    d_w, d_b = -k.d_max * np.sign(off) * FLAT, -k.d_max * sides * FLAT
    agrees(command, law(k, Known(m + sides[2] * k.m_max, d_w, d_b), x, y), "Its limits are others.")


# Change of world, and taking over ---------------------------------------------------------------------


@hidden(GeometricController, weight=2.0)
def a_change_of_world_is_not_felt(f: Function, rng: np.random.Generator) -> None:
    """Told in a new world, it must fly on as if nothing were; the old memory must stay as it was."""
    k, m, x = some_gains(rng), some_mass(rng), some_estimate(rng)
    shift = Shift(draw.vector(rng, 5.0), draw.angle(rng))
    k = k._replace(k_p=(k.k_p[0],) * 3, k_v=(k.k_v[0],) * 3)
    last = Command(float(rng.uniform(10.0, 40.0)), draw.vector(rng), draw.vector(rng))
    for early in (0, 5):  # before the take-over, and in the midst of it
        part = f(m, k)
        memory = part.init(x, last)
        for _ in range(early):
            memory, _ = part.step(memory, x, near(rng, x), 0.1)
        other = part.reframe(memory, shift)
        for _ in range(3):
            y = near(rng, x)
            memory, here = part.step(memory, x, y, 0.1)
            other, there = part.step(other, frames.moved(x, shift), frames.moved(y, shift), 0.1)
            f_d, omega_d, a_d = forms(here)
            told = frames.moved(Command(float(f_d), omega_d, a_d), shift)
            expect(float(np.linalg.norm(told.a_d)) > 1e-9, "It does something.")
            agrees(there, list(told), "It is felt.", atol=1e-7)


@hidden(GeometricController)
def the_last_command_fades(f: Function, rng: np.random.Generator) -> None:
    """The first command must be the last one, and what differs must fade with half a second, at any rate."""
    for dt in (0.01, 0.1):
        k, m, x = (
            some_gains(rng)._replace(k_m=0.0, k_iw=0.0, k_ib=0.0),
            some_mass(rng),
            some_estimate(rng),
        )
        part, y = f(m, k), near(rng, x)
        last = Command(float(rng.uniform(10.0, 40.0)), draw.vector(rng), draw.vector(rng))
        memory, own = part.init(x, last), law(k, Known(m), x, y)
        for tick in range(12):
            memory, command = part.step(memory, x, y, dt)
            left = exp(-tick * dt / 0.5)
            want = [a + left * (b - a) for a, b in zip(own, last, strict=True)]
            agrees(command, want, "It fades otherwise.", atol=1e-7)


# In flight --------------------------------------------------------------------------------------------


def flight(
    part: Any,
    goal: Callable[[float], Reference],
    m: float,
    seconds: float,
    push: Callable[[float, Mat3], Vec3] = lambda t, R: ZERO,
    dt: float = 0.025,
) -> list[tuple[Estimate, Reference, tuple[Array, ...]]]:
    """Fly a body of mass m whose rates and thrust follow with lags; estimate, reference and command of each tick."""
    y = goal(0.0)
    R, lags = axes(y.a + G, y.heading), np.exp(-dt / 2 * np.array((16.0, 16.0, 10.0)))
    r, v, omega, f = y.r, y.v, ZERO, m * float(np.linalg.norm(y.a + G))
    omega = so3.log(R.T @ axes(goal(1e-3).a + G, goal(1e-3).heading)) / 1e-3
    memory, seen = part.init(Estimate(r, v, y.a, R, omega), None), []
    for tick in range(round(seconds / dt)):
        t = tick * dt
        x, y = Estimate(r, v, ZERO, R, omega), goal(t)
        memory, command = part.step(memory, x, y, dt)
        f_d, omega_d, a_d = expect_record(command, (), (3,), (3,))
        seen.append((x, y, (f_d, omega_d, a_d)))
        expect(float(np.linalg.norm(r - y.r)) < 3.0, "It flies away.")
        for _ in range(2):  # the autopilot and the motors are quicker
            omega = omega_d + lags * (omega - omega_d)
            f = min(max(float(f_d), 0.0), 3.0 * m * GRAVITY) * 0.3 + 0.7 * f
            R = R @ so3.exp(0.5 * dt * omega)
            v = v + 0.5 * dt * ((f * R[:, 2] + push(t, R)) / m - G)
            r = r + 0.5 * dt * v
    return seen


def round_and_round(
    rng: np.random.Generator, facing: bool, radius: float = 5.0
) -> Callable[[float], Reference]:
    """A circle of 5 m at 6 to 7 m/s, nose to the centre or anywhere."""
    w, start, eta = (
        float(rng.uniform(1.2, 1.4) * rng.choice((-1, 1))),
        draw.angle(rng),
        draw.angle(rng),
    )

    def goal(t: float) -> Reference:
        p = so3.about_z(start + w * t)
        x, y = radius * p[:, 0], radius * p[:, 1]
        nose, rate = (start + w * t + pi, w) if facing else (eta, 0.0)
        return Reference(x, w * y, -(w**2) * x, -(w**3) * y, float(frames.wrap(nose)), rate)

    return goal


def off_by(seen: list[Any], after: float, dt: float = 0.025) -> tuple[float, float]:
    """Largest distance [m] and heading error [rad] from `after` [s] on."""
    late = seen[round(after / dt) :]
    far = max(float(np.linalg.norm(x.r - y.r)) for x, y, _ in late)
    return far, max(abs(frames.wrap(frames.heading(x.R) - y.heading)) for x, y, _ in late)


@hidden(GeometricController, weight=2.0)
def circle_facing_the_centre(f: Function, rng: np.random.Generator) -> None:
    """Flown round a fast circle with the nose to its centre, it must stay on the circle, and so must its nose."""
    m = some_mass(rng)
    far, nose = off_by(flight(f(m), round_and_round(rng, True), m, 4.0), 2.0)
    expect(far < 0.12, "It leaves the circle.")
    expect(nose < 0.05, "The nose wanders.")


@hidden(GeometricController, weight=2.0)
def circle_with_a_still_nose(f: Function, rng: np.random.Generator) -> None:
    """Flown round a fast circle with the nose in one direction, it must stay on the circle, and so must its nose."""
    m = some_mass(rng)
    far, nose = off_by(flight(f(m), round_and_round(rng, False), m, 4.0), 2.0)
    expect(far < 0.25, "It leaves the circle.")
    expect(nose < 0.08, "The nose wanders.")


@hidden(GeometricController, weight=2.0)
def payload_and_wind(f: Function, rng: np.random.Generator) -> None:
    """Hovering with a payload, in a wind, nose turning, it must find back, and say that it does not accelerate."""
    m, extra, eta = some_mass(rng), float(rng.uniform(0.15, 0.25)), draw.angle(rng)
    wind = m * float(rng.uniform(0.5, 1.0)) * so3.about_z(draw.angle(rng))[:, 0]
    k = GeometricGains(
        (6.0, 6.0, 10.0), (4.0, 4.0, 6.0), (5.0, 5.0, 5.0), 2.0 * m, 2.0 * m, 0.9 * m, 10.0 * m, m
    )
    spot = Reference(draw.vector(rng), ZERO, ZERO, ZERO, eta, 0.0)

    def goal(t: float) -> Reference:
        turning = 2.0 < t < 4.0
        angle = eta + 0.8 * float(np.clip(t - 2.0, 0.0, 2.0))
        return spot._replace(heading=float(frames.wrap(angle)), heading_rate=0.8 * turning)

    seen = flight(f(m, k), goal, m * (1.0 + extra), 7.5, push=lambda t, R: wind)
    far, nose = off_by(seen, 7.0)
    expect(far < 0.03, "It has not found back.")
    expect(nose < 0.02, "The nose is off.")
    f_d, _, a_d = seen[-1][2]
    expect(float(np.linalg.norm(a_d)) < 0.1, "It stands still.")
    held = np.hypot(m * (1.0 + extra) * GRAVITY, np.linalg.norm(wind))
    expect_close(f_d, held, "It is not what holds it.", atol=0.05 * m)
