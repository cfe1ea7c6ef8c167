"""The public checks of lab 07: what errors, forces, rates, sums and torques must do. The exercises are beside it."""

from __future__ import annotations

import numpy as np

from uavlab import frames, so3
from uavlab.exercises import draw
from uavlab.exercises.expect import expect_heading_rate, expect_record, of_shapes
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.gains import GeometricGains, TorqueGains, Triple
from uavlab.types import GRAVITY, Command, Estimate, Mat3, Reference, Vec3

ZERO = np.zeros(3)
UP = np.array((0.0, 0.0, 1.0))
NONE = (0.0, 0.0, 0.0)


def some_gains(rng: np.random.Generator) -> GeometricGains:
    """Gains that no aircraft has, every number another one."""
    k_p, k_v, k_R = (three(rng, 3.0, 9.0) for _ in range(3))
    k_iw, k_ib, k_m = map(float, rng.uniform(0.2, 1.0, size=3))
    return GeometricGains(k_p, k_v, k_R, k_iw, k_ib, k_m, float(rng.uniform(3.0, 6.0)), 1.5)


def three(rng: np.random.Generator, low: float, high: float) -> Triple:
    """Three gains, `low` to `high`."""
    x, y, z = rng.uniform(low, high, size=3).tolist()
    return x, y, z


def some_estimate(rng: np.random.Generator) -> Estimate:
    """Somewhere, on the move, tilted."""
    R = draw.aimed(rng, 0.1, 0.6)
    return Estimate(draw.vector(rng, 3.0), draw.vector(rng), draw.vector(rng), R, draw.vector(rng))


def some_mass(rng: np.random.Generator) -> float:
    """A mass [kg] that is not one."""
    return float(rng.uniform(1.5, 6.0))


def a_small_turn(f: Function, rng: np.random.Generator) -> None:
    """After a small turn the error must be its rotation vector, from wanted to flown, told in the body."""
    for _ in range(3):
        R_d, w = draw.rotation(rng), draw.vector(rng, 5e-4)
        expect_close(f(R_d @ so3.exp(w), R_d), w, atol=1e-8)


def errors_die_like_springs(f: Function, rng: np.random.Generator) -> None:
    """A body that this force and its weight move must have the wanted acceleration, with a spring and a damper."""
    for _ in range(3):
        k, x, y, m = some_gains(rng), some_estimate(rng), draw.reference(rng), some_mass(rng)
        a = numbers(f(x, y, m, ZERO, ZERO, k), (3,)) / m - GRAVITY * UP
        pulled = a - y.a + np.multiply(k.k_v, x.v - y.v) + np.multiply(k.k_p, x.r - y.r)
        expect_close(pulled, ZERO, "The errors die otherwise.")


def a_push_is_taken_off(f: Function, rng: np.random.Generator) -> None:
    """A horizontal push of the world must be answered by an equal force the other way, whatever the mass."""
    for _ in range(3):
        k, x, y, m = some_gains(rng), some_estimate(rng), draw.reference(rng), some_mass(rng)
        push = draw.vector(rng, 3.0) * (1.0, 1.0, 0.0)
        calm = numbers(f(x, y, m, ZERO, ZERO, k), (3,))
        expect_close(calm - numbers(f(x, y, m, push, ZERO, k), (3,)), push)


def the_axis_follows_the_force(f: Function, rng: np.random.Generator) -> None:
    """Turned with these rates, the thrust axis must stay along the force while this changes by the jerk."""
    for _ in range(3):
        R_d, size, m, jerk = (
            draw.rotation(rng),
            rng.uniform(10, 60),
            some_mass(rng),
            draw.vector(rng),
        )
        force, h = size * R_d[:, 2], 1e-5
        omega = numbers(f(force, m, R_d, jerk), (3,))
        later, before = force + h * m * jerk, force - h * m * jerk
        swing = later / np.linalg.norm(later) - before / np.linalg.norm(before)
        turned = R_d @ np.cross(omega, UP)
        expect_close(turned, swing / (2.0 * h), "The axis does not follow.", atol=1e-6)
        expect_close(omega[2], 0.0, "Turning about the axis makes no jerk.")


def the_nose_turns_as_told(f: Function, rng: np.random.Generator) -> None:
    """On the wanted attitude roll and pitch are the jerk's, and the heading must change at the wanted rate."""
    for _ in range(3):
        R, rate, k_R = draw.aimed(rng, 0.2, 0.9), draw.pace(rng), rng.uniform(3, 8, size=3)
        omega_j = draw.vector(rng) * (1.0, 1.0, 0.0)
        omega = numbers(f(R, R, rate, omega_j, k_R), (3,))
        expect_close(omega[:2], omega_j[:2], "Roll and pitch are others.")
        expect_heading_rate(rate, R, omega, message="The heading changes at another rate.")


def the_error_shrinks(f: Function, rng: np.random.Generator) -> None:
    """A body that turns with these rates must come to the wanted attitude, within a few times one over the gain."""
    R_d, k_R = draw.aimed(rng, 0.2, 0.6), rng.uniform(4.0, 6.0, size=3)
    R = R_d @ so3.exp(0.4 * draw.direction(rng))
    for _ in range(40):
        R = R @ so3.exp(0.025 * numbers(f(R, R_d, 0.0, ZERO, k_R), (3,)))
    expect(so3.angle(R, R_d) < 0.05, "It has not come.")


def learnt_along_the_nose(f: Function, rng: np.random.Generator) -> None:
    """Pushed ahead while the nose turns, the second sum must grow along x, the first one along the push."""
    k, d_w, d_b, want, T = some_gains(rng), ZERO, ZERO, ZERO, 0.0
    off = float(rng.uniform(0.3, 0.9))
    for _ in range(4):
        eta, dt = draw.angle(rng), float(rng.uniform(0.01, 0.1))
        e_p = off * so3.about_z(eta)[:, 0] + rng.normal() * UP
        d_w, d_b = of_shapes(f(d_w, d_b, e_p, eta, dt, k), (3,), (3,))
        want, T = want + k.k_iw * dt * off * so3.about_z(eta)[:, 0], T + dt
        expect_close(d_b, (k.k_ib * T * off, 0.0, 0.0), "What turns with the nose is another one.")
        expect_close(d_w, want, "What stays with the world is another one.")


def no_more_than_that(f: Function, rng: np.random.Generator) -> None:
    """However long the error stays, no entry of either sum may pass the limit, and some must reach it."""
    k, d_w, d_b = some_gains(rng), ZERO, ZERO
    eta, e_p = draw.angle(rng), rng.choice((-1.0, 1.0), size=3) * rng.uniform(3.0, 6.0, size=3)
    for _ in range(60):
        d_w, d_b = of_shapes(f(d_w, d_b, e_p, eta, 0.5, k), (3,), (3,))
        expect(max(np.abs(d_w).max(), np.abs(d_b).max()) <= k.d_max + 1e-9, "It is passed.")
    expect_close(d_w, k.d_max * np.sign(e_p) * (1.0, 1.0, 0.0), "The world's is not at its limits.")
    expect_close(np.abs(d_b).max(), k.d_max, "The nose's has not reached it.")


def hanging_low(f: Function, rng: np.random.Generator) -> None:
    """Who hangs low must gain mass, in proportion to the error and the time, until the limit; who hangs high, lose."""
    k, m = some_gains(rng), some_mass(rng) + 2.0
    for side in (1.0, -1.0):
        m_e, T, low = m, 0.0, float(side * rng.uniform(0.1, 0.5))
        for dt in rng.uniform(0.01, 0.2, size=5):
            m_e, T = float(numbers(f(m_e, -low, float(dt), m, k), ())), T + dt
            expect_close(m_e, m + k.k_m * low * T)
        expect_close(
            f(m_e, -50.0 * low, 5.0, m, k), m + side * k.m_max, "The limit is another one."
        )


def still_in_the_wind(f: Function, rng: np.random.Generator) -> None:
    """Still in the wind it must say zero, and with a thrust that is stronger by some newtons what these make."""
    for _ in range(3):
        m, R, d_w = some_mass(rng), draw.aimed(rng, 0.1, 0.6), draw.vector(rng, 3.0)
        thrust, more = m * GRAVITY / R[2, 2], float(rng.uniform(1.0, 5.0))
        d_b = so3.about_z(frames.heading(R)).T @ (
            -thrust * R[:, 2] - d_w
        )  # what is left to balance
        expect_close(f(thrust, R, d_w, d_b, m), ZERO, "It stands still.")
        expect_close(f(thrust + more, R, d_w, d_b, m), more / m * R[:, 2], "It is pushed up.")


def the_rate_error_dies(f: Function, rng: np.random.Generator) -> None:
    """With a gain on rates alone, the error of a turning body's rates must die as that gain says, whatever turns."""
    for _ in range(3):
        R, R_d, J = draw.rotation(rng), draw.rotation(rng), draw.inertia(rng)
        omega, omega_d, omega_dot_d = (draw.vector(rng, 2.0) for _ in range(3))
        k = TorqueGains(k_R=NONE, k_iR=NONE, k_omega=three(rng, 0.1, 0.4))
        tau = numbers(f(R, R_d, omega, omega_d, omega_dot_d, ZERO, J, k), (3,))
        omega_dot = np.linalg.solve(J, tau - np.cross(omega, J @ omega))
        slope = wanted_slope(R, R_d, omega, omega_d, omega_dot_d) - omega_dot
        left = np.multiply(k.k_omega, R.T @ R_d @ omega_d - omega)
        expect_close(J @ slope, -left, "It dies otherwise.", atol=1e-5)


def wanted_slope(R: Mat3, R_d: Mat3, omega: Vec3, omega_d: Vec3, omega_dot_d: Vec3) -> Vec3:
    """How fast the wanted rates change as the body sees them [rad/s²], by a central difference."""
    h = 1e-5

    def seen(t: float) -> Vec3:
        turned, wanted = R @ so3.exp(t * omega), R_d @ so3.exp(t * omega_d)
        return turned.T @ wanted @ (omega_d + t * omega_dot_d)

    return (seen(h) - seen(-h)) / (2.0 * h)


def at_rest_it_turns_back(f: Function, rng: np.random.Generator) -> None:
    """At rest, a small turn away from the wanted attitude and its integral must be answered, axis by axis."""
    for _ in range(3):
        R, w, integral = draw.rotation(rng), draw.vector(rng, 1e-3), draw.vector(rng, 1e-3)
        k, J = TorqueGains(k_R=three(rng, 0.5, 2), k_iR=three(rng, 0.2, 1)), draw.inertia(rng)
        want = np.multiply(k.k_R, w) + np.multiply(k.k_iR, integral)
        expect_close(f(R, R @ so3.exp(w), ZERO, ZERO, ZERO, integral, J, k), want, atol=1e-7)


def as_much_as_can_be(f: Function, rng: np.random.Generator) -> None:
    """What can be done must be left alone; what cannot, be shrunk until one rotor is at its limit and none beyond."""
    for _ in range(2):
        M, m = draw.allocation(rng, 4, balanced=True), some_mass(rng)
        hover = m * GRAVITY / 4
        limits = float(0.2 * hover), float(rng.uniform(1.8, 3.0) * hover)
        u_gravity = np.array((m * GRAVITY, 0.0, 0.0, 0.0))
        wish = rng.normal(size=4)
        largest = np.abs(wish).max() / hover
        for size, fits in ((0.5 / largest, True), (20.0 / largest, False)):
            more = M @ (size * wish)
            got = numbers(f(u_gravity + more, u_gravity, M, *limits), (4,)) - u_gravity
            share = float(got @ more) / float(more @ more)
            expect_close(got, share * more, "The direction is another one.", atol=1e-7)
            rotors = np.linalg.solve(M, got + u_gravity)
            room = min(float((rotors - limits[0]).min()), float((limits[1] - rotors).min()))
            expect(not fits or abs(share - 1.0) < 1e-9, "It could have been done.")
            expect(fits or abs(room) < 1e-6, "No rotor is at its limit, or one is beyond.")


def hovers_at_once(f: Function, rng: np.random.Generator) -> None:
    """On the spot, level and at rest, it must ask for the weight, for no rates, and for no acceleration."""
    m, eta, r = some_mass(rng), draw.angle(rng), draw.vector(rng, 5.0)
    part = f(m, some_gains(rng))
    here = Estimate(r, ZERO, ZERO, so3.about_z(eta), ZERO)
    memory = part.init(here, None)
    for _ in range(3):
        memory, command = part.step(memory, here, Reference(r, ZERO, ZERO, ZERO, eta, 0.0), 0.01)
        f_d, omega_d, a_d = expect_record(command, (), (3,), (3,))
        expect_close(f_d, m * GRAVITY, "It is not the weight.")
        expect_close(omega_d, ZERO, "It turns.")
        expect_close(a_d, ZERO, "It says that it accelerates.")


def taken_over_without_a_jump(f: Function, rng: np.random.Generator) -> None:
    """The first command must be the one before, and what it differs from the law's own must fade with 0.5 s."""
    x, y, part = some_estimate(rng), draw.reference(rng), f(some_mass(rng), some_gains(rng))
    last = Command(float(rng.uniform(10.0, 60.0)), draw.vector(rng), draw.vector(rng))
    taken, fresh, first = part.init(x, last), part.init(x, None), []
    for k in range(4):
        taken, ours = part.step(taken, x, y, 0.05)
        fresh, own = part.step(fresh, x, y, 0.05)
        rest = [a - b for a, b in zip(forms(ours), forms(own), strict=True)]
        first = rest if k == 0 else first
        if k == 0:
            for got, want in zip(forms(ours), last, strict=True):
                expect_close(got, want, "It jumps.")
        for now, begun in zip(rest, first, strict=True):
            expect_close(now, begun * np.exp(-0.1 * k), "It fades otherwise.", atol=1e-7)


def forms(command: object) -> tuple[np.ndarray, ...]:
    """A command as plain numbers, or fail the check."""
    return expect_record(command, (), (3,), (3,))
