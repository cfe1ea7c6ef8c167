"""Hidden checks of lab 07, continued: a torque loop, and what the rotors can give."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from grader.material import hidden
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.expect import expect_refusal
from uavlab.exercises.geometric import scale_to_limits, torque_command
from uavlab.exercises.geometric_checks import NONE, ZERO, some_mass, three, wanted_slope
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.gains import TorqueGains
from uavlab.types import GRAVITY, Array

CANARY = "canary-91fd2b6a0c584e37b6ad35e2"

# torque_command ---------------------------------------------------------------------------------------


def some_torque_gains(rng: np.random.Generator) -> TorqueGains:
    """Gains on attitude, integral and rate, every one another."""
    return TorqueGains(
        k_R=three(rng, 0.5, 2.0), k_iR=three(rng, 0.2, 1.0), k_omega=three(rng, 0.1, 0.4)
    )


@hidden(torque_command, weight=3.0)
def errors_as_the_gains_say(f: Function, rng: np.random.Generator) -> None:
    """Whatever turns, the error of the rates must change as the three gains say, and by nothing else."""
    for _ in range(3):
        R, R_d, J, k = (
            draw.rotation(rng),
            draw.rotation(rng),
            draw.inertia(rng),
            some_torque_gains(rng),
        )
        omega, omega_d, omega_dot_d = (draw.vector(rng, 2.0) for _ in range(3))
        integral = draw.vector(rng, 0.3)
        tau = numbers(f(R, R_d, omega, omega_d, omega_dot_d, integral, J, k), (3,))
        omega_dot = np.linalg.solve(J, tau - np.cross(omega, J @ omega))
        w, angle = so3.log(R.T @ R_d), so3.angle(R, R_d)
        pull = np.multiply(k.k_R, w * np.sin(angle) / angle) + np.multiply(k.k_iR, integral)
        pull += np.multiply(k.k_omega, R.T @ R_d @ omega_d - omega)
        slope = wanted_slope(R, R_d, omega, omega_d, omega_dot_d)
        expect_close(J @ (omega_dot - slope), pull, atol=1e-5)


@hidden(torque_command)
def what_spinning_costs(f: Function, rng: np.random.Generator) -> None:
    """A body that spins as wanted must be given the gyroscopic torque, and what the wanted acceleration costs."""
    for _ in range(3):
        R, J, k = draw.rotation(rng), draw.inertia(rng), some_torque_gains(rng)
        omega, omega_dot_d = draw.vector(rng, 3.0), draw.vector(rng, 3.0)
        tau = numbers(f(R, R, omega, omega, omega_dot_d, ZERO, J, k), (3,))
        expect_close(tau - J @ omega_dot_d, np.cross(omega, J @ omega))


@hidden(torque_command)
def told_in_the_wanted_axes(f: Function, rng: np.random.Generator) -> None:
    """What is wanted, told in other wanted axes, must be answered by the same torque but for the attitude's part."""
    for _ in range(3):
        R, R_d, Q, J = draw.rotation(rng), draw.rotation(rng), draw.rotation(rng), draw.inertia(rng)
        omega, omega_d, omega_dot_d = (draw.vector(rng, 2.0) for _ in range(3))
        k = some_torque_gains(rng)._replace(k_R=NONE, k_iR=NONE)
        tau = numbers(f(R, R_d, omega, omega_d, omega_dot_d, ZERO, J, k), (3,))
        expect_close(f(R, R_d @ Q, omega, Q.T @ omega_d, Q.T @ omega_dot_d, ZERO, J, k), tau)
        seen = R.T @ R_d @ omega_d
        rest = tau - np.multiply(k.k_omega, seen - omega) - np.cross(omega, J @ omega)
        expect_close(np.linalg.solve(J, rest), R.T @ R_d @ omega_dot_d - np.cross(omega, seen))


@hidden(torque_command, weight=2.0)
def swung_with_a_crooked_propeller(f: Function, rng: np.random.Generator) -> None:
    """Flown along a swinging attitude, with a torque that nobody asked for, the error must go."""
    J, dt = np.diag((0.0125, 0.0125, 0.024)), 0.01
    k = TorqueGains(k_R=(1.5, 1.5, 1.2), k_iR=(2.0, 2.0, 1.5), k_omega=(0.25, 0.25, 0.3))
    n, base, pace, wide = draw.direction(rng), draw.rotation(rng), rng.uniform(2.0, 3.0), 0.8
    crooked = 0.12 * draw.direction(rng)
    R, omega, integral = base @ so3.exp(0.3 * draw.direction(rng)), ZERO, ZERO
    for tick in range(400):
        t = tick * dt
        R_d = base @ so3.exp(wide * np.sin(pace * t) * n)
        omega_d, dot = wide * pace * np.cos(pace * t) * n, -wide * pace**2 * np.sin(pace * t) * n
        S = R.T @ R_d
        integral = integral + dt * so3.vee(S - S.T) / 2.0
        tau = numbers(f(R, R_d, omega, omega_d, dot, integral, J, k), (3,)) + crooked
        omega = omega + dt * np.linalg.solve(J, tau - np.cross(omega, J @ omega))
        R = R @ so3.exp(dt * omega)
        expect(float(np.linalg.norm(omega)) < 60.0, "It tumbles.")
        expect(t < 3.5 or so3.angle(R, R_d) < 0.04, "The error stays.")


# scale_to_limits --------------------------------------------------------------------------------------


def craft(rng: np.random.Generator, n: int) -> tuple[Array, Array, float, float]:
    """Allocation (4, n), what holds the weight (4,), and limits of the rotors [N]."""
    M, weight = draw.allocation(rng, n, balanced=True), some_mass(rng) * GRAVITY
    low, high = rng.uniform(0.1, 0.6), rng.uniform(1.3, 3.0)
    return M, np.array((weight, 0.0, 0.0, 0.0)), float(low * weight / n), float(high * weight / n)


def largest(u: Array, u_gravity: Array, M: Array, low: float, high: float) -> float:
    """The largest share of u − u_gravity that the rotors can do, by a linear programme."""
    pull, hover = np.linalg.pinv(M) @ (u - u_gravity), np.linalg.pinv(M) @ u_gravity
    rows = np.concatenate((pull, -pull))[:, None]
    room = np.concatenate((high - hover, hover - low))
    found = linprog([-1.0], A_ub=rows, b_ub=room, bounds=[(0.0, 1.0)])
    return float(found.x[0])


@hidden(scale_to_limits, weight=3.0)
def the_largest_share(f: Function, rng: np.random.Generator) -> None:
    """With four rotors or more, the share that is done must be the largest that a linear programme finds."""
    for n in (4, 6, 8):
        M, u_gravity, low, high = craft(rng, n)
        for size in (3.0, 1.0):
            u = u_gravity + M @ (size * u_gravity[0] / n * rng.normal(size=n))
            want = u_gravity + largest(u, u_gravity, M, low, high) * (u - u_gravity)
            expect_close(f(u, u_gravity, M, low, high), want, atol=1e-6)


@hidden(scale_to_limits)
def too_much_and_too_little(f: Function, rng: np.random.Generator) -> None:
    """More thrust alone must end at the upper limit of all rotors, less at the lower one, and neither beyond."""
    for n in (4, 6):
        M, u_gravity, low, high = craft(rng, n)
        for ask, limit in ((1.0, high), (-1.0, low)):
            u = u_gravity * (1.0 + ask * float(rng.uniform(3.0, 9.0)))
            expect_close(f(u, u_gravity, M, low, high), n * limit * np.eye(4)[0], atol=1e-7)


@hidden(scale_to_limits)
def left_as_it_is(f: Function, rng: np.random.Generator) -> None:
    """What can be done must be given whole and never be stretched, the hover included; beyond, it is shrunk."""
    for n in (4, 6):
        M, u_gravity, low, high = craft(rng, n)
        room = min(u_gravity[0] / n - low, high - u_gravity[0] / n)
        within = M @ (0.8 * room * rng.uniform(-1.0, 1.0, size=n))
        expect_close(f(u_gravity + within, u_gravity, M, low, high), u_gravity + within)
        expect_close(f(u_gravity, u_gravity, M, low, high), u_gravity)
        u = u_gravity + 50.0 * within
        share = largest(u, u_gravity, M, low, high)
        expect_close(f(u, u_gravity, M, low, high), u_gravity + share * 50.0 * within, atol=1e-6)


@hidden(scale_to_limits, weight=0.5)
def cannot_even_hover(f: Function, rng: np.random.Generator) -> None:
    """A weight that the rotors cannot hold, or cannot hold so low, must raise ValueError; another must not."""
    M, u_gravity, low, high = craft(rng, 4)
    u = u_gravity + M @ (u_gravity[0] * rng.normal(size=4))
    want = u_gravity + largest(u, u_gravity, M, low, high) * (u - u_gravity)
    expect_close(f(u, u_gravity, M, low, high), want, atol=1e-6)
    expect_refusal(f, u, u_gravity, M, low, 0.2 * u_gravity[0])
    expect_refusal(f, u, u_gravity, M, 0.3 * u_gravity[0], u_gravity[0])
