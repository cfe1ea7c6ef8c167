"""Lab 01, hidden checks: conservation laws, symmetries and closed forms, on inputs that nobody has seen."""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from grader.hidden.rollout import runge_kutta
from grader.material import hidden
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.dynamics import (
    allocation_matrix,
    apparent_mass,
    force_from_throttle,
    motor_step,
    rigid_body_rate,
    rotor_thrusts,
    step_on_so3,
    throttle_from_force,
)
from uavlab.exercises.expect import expect_rotation, expect_state_rate
from uavlab.exercises.spec import Function, expect, expect_close, numbers
from uavlab.types import State, StateRate

CANARY = "canary-5b3fe2add9aee825ecf6de66"


@hidden(rigid_body_rate)
def work_becomes_kinetic_energy(f: Function, rng: np.random.Generator) -> None:
    """The kinetic energy must grow by the power of the force and the torque."""
    for _ in range(4):
        state, force, torque, m, J = draw.pushed(rng)
        rate = expect_state_rate(f(state, force, torque, m=m, J=J))
        power = force @ rate.r_dot + torque @ state.omega
        growth = m * state.v @ rate.v_dot + state.omega @ J @ rate.omega_dot
        expect_close(growth, power)


@hidden(rigid_body_rate, weight=2.0)
def torque_turns_the_angular_momentum(f: Function, rng: np.random.Generator) -> None:
    """In the world, the angular momentum R J omega must change with the torque R tau, gyroscopic term included."""
    for _ in range(4):
        state, force, torque, m, J = draw.pushed(rng)
        rate = expect_state_rate(f(state, force, torque, m=m, J=J))
        R_dot = state.R @ so3.hat(state.omega)  # the true one: two mistakes must not cancel
        change = R_dot @ J @ state.omega + state.R @ J @ rate.omega_dot
        expect_close(change, state.R @ torque)


@hidden(rigid_body_rate)
def twisted_from_rest(f: Function, rng: np.random.Generator) -> None:
    """From rest, J times the angular acceleration must be the torque, also when J is not diagonal."""
    for _ in range(3):
        state, force, torque, m, J = draw.pushed(rng)
        rate = expect_state_rate(f(state._replace(omega=np.zeros(3)), force, torque, m=m, J=J))
        expect_close(J @ rate.omega_dot, torque)


@hidden(rigid_body_rate, weight=2.0)
def a_thrown_top(f: Function, rng: np.random.Generator) -> None:
    """A thrown top, followed for some seconds with your rates, must fly a parabola and precess as it should."""
    J = np.diag((0.02, 0.02, 0.02 * rng.uniform(1.3, 1.9)))
    m, omega, dt, steps = float(rng.uniform(0.5, 3.0)), rng.uniform(1.5, 3.0, size=3), 0.01, 200
    weight = np.array((0.0, 0.0, -9.81 * m))
    start = State(draw.vector(rng), draw.vector(rng, 3.0), draw.rotation(rng), omega)

    def rate(x: State) -> StateRate:
        return expect_state_rate(f(x, weight, np.zeros(3), m=m, J=J))

    state = start
    for _ in range(steps):
        state = runge_kutta(rate, state, dt)
    t = dt * steps
    expect_close(state.r, start.r + start.v * t + weight / m * t * t / 2, atol=1e-6)
    # A top whose two moments are equal: the rate turns about its axis at a constant pace.
    pace = (J[2, 2] / J[0, 0] - 1.0) * omega[2] * t
    expect_close(state.omega, so3.about_z(pace) @ omega, atol=1e-5)
    momentum = start.R @ J @ omega
    expect_close(state.R @ J @ state.omega, momentum, atol=1e-5)


@hidden(step_on_so3)
def agrees_with_scipy(f: Function, rng: np.random.Generator) -> None:
    """The step must be a turn in body axes by omega times dt, for turns of any size."""
    for size in (0.01, 1.0, 3.1, 3.2, 20.0):
        R, w, dt = draw.rotation(rng), size * draw.direction(rng), float(rng.uniform(0.01, 2.0))
        want = (Rotation.from_matrix(R) * Rotation.from_rotvec(w)).as_matrix()
        expect_close(f(R, w / dt, dt), want)


@hidden(step_on_so3)
def two_steps_make_one(f: Function, rng: np.random.Generator) -> None:
    """Two steps must make one long step, and a step back must undo a step."""
    for _ in range(3):
        R, omega = draw.rotation(rng), draw.vector(rng, 3.0)
        a, b = rng.uniform(0.1, 1.0, size=2)
        first = numbers(f(R, omega, a), (3, 3))
        expect(np.abs(first - R).max() > 1e-3, "It did not turn.")
        whole = f(R, omega, a + b)
        expect_close(f(first, omega, b), numbers(whole, (3, 3)))
        expect_close(f(first, omega, -a), R)


@hidden(step_on_so3)
def slow_and_still(f: Function, rng: np.random.Generator) -> None:
    """With a body rate of zero the rotation stays, and next to zero it turns by the little that it should."""
    for size in (1e-3, 1e-4, 1e-5):
        R, w = draw.rotation(rng), draw.direction(rng)
        expect_close(f(R, np.zeros(3), 0.01), R)
        little = (numbers(f(R, size * w, 1.0), (3, 3)) - R) / size
        expect_close(little, np.cross(R, w), atol=2.0 * size + 1e-8)  # R [w]× row by row


@hidden(step_on_so3)
def a_long_flight(f: Function, rng: np.random.Generator) -> None:
    """After hundreds of steps with changing rates the attitude must still be a rotation, and the right one."""
    R, dt = draw.rotation(rng), 0.01
    truth = Rotation.from_matrix(R)
    for omega in rng.normal(scale=4.0, size=(250, 3)):
        R = expect_rotation(f(R, omega, dt))
        truth = truth * Rotation.from_rotvec(omega * dt)
    expect_close(R, truth.as_matrix())
    expect_close(R @ R.T, np.eye(3), atol=1e-12)


@hidden(allocation_matrix)
def column_by_column(f: Function, rng: np.random.Generator) -> None:
    """Each rotor, alone, must make the torque of its push and of its drag, in any layout."""
    for n in (3, 4, 5, 8):
        angles, arm, c, spins = draw.layout(rng, n)
        M = numbers(f(angles, arm, c, spins), (4, n))
        places = arm * np.exp(1j * angles)  # x + i y
        expect_close(M[0], np.ones(n))
        expect_close(M[1], places.imag)
        expect_close(M[2], -places.real)
        expect_close(M[3], spins * c)


@hidden(allocation_matrix)
def body_axes_turned(f: Function, rng: np.random.Generator) -> None:
    """Turning the body axes by an angle must turn the torque by that angle, and leave the rest."""
    for n in (4, 6):
        angles, arm, c, spins = draw.layout(rng, n)
        turn = draw.angle(rng)
        M = numbers(f(angles, arm, c, spins), (4, n))
        expect_close(M[1], arm * np.sin(angles))  # true somewhere: any frame turns along
        expect_close(M[2], -arm * np.cos(angles))
        expect_close(M[0], np.ones(n))
        expect_close(f(angles + turn, arm, c, spins), np.vstack((M[0], so3.about_z(turn) @ M[1:])))


@hidden(allocation_matrix)
def an_even_ring_hovers(f: Function, rng: np.random.Generator) -> None:
    """Equal thrusts on an even ring of rotors must lift without any torque, however the ring is turned."""
    for n in (4, 6, 8):
        _, arm, c, spins = draw.layout(rng, n)
        angles = 2.0 * np.pi * np.arange(n) / n + draw.angle(rng)
        M = numbers(f(angles, arm, c, spins), (4, n))
        expect_close(M @ np.ones(n), (n, 0.0, 0.0, 0.0))
        expect_close(M[1], arm * np.sin(angles))
        expect_close(M[1:] @ M[1:].T, np.diag((n * arm**2 / 2, n * arm**2 / 2, n * c**2)))


@hidden(allocation_matrix)
def one_above_the_other(f: Function, rng: np.random.Generator) -> None:
    """Two rotors above each other that spin against each other must differ in nothing but their drag torque."""
    angles, arm, c, _ = draw.layout(rng, 4)
    spins = np.repeat((1.0, -1.0), 4)
    M = numbers(f(np.tile(angles, 2), arm, c, spins), (4, 8))
    expect_close(M[:3, :4], M[:3, 4:])
    expect_close(M[1, :4], arm * np.sin(angles))
    expect_close(M[3], c * spins)
    expect_close(M[2] @ M[2] + M[1] @ M[1], 8 * arm**2)


@hidden(rotor_thrusts)
def gives_back_the_thrusts(f: Function, rng: np.random.Generator) -> None:
    """With four rotors, the thrusts that made a force and a torque must come back."""
    for _ in range(3):
        M, thrusts = draw.allocation(rng, 4), rng.uniform(0.5, 9.0, size=4)
        u = M @ thrusts
        expect_close(f(float(u[0]), u[1:], M), thrusts, atol=1e-7)


@hidden(rotor_thrusts, weight=2.0)
def none_is_wasted(f: Function, rng: np.random.Generator) -> None:
    """With more than four rotors, no part of the thrusts may be without effect: take the least sum of squares."""
    for n in (5, 6, 8):
        M = draw.allocation(rng, n)
        lift, tau = float(rng.uniform(5.0, 40.0)), draw.vector(rng)
        thrusts = numbers(f(lift, tau, M), (n,))
        expect_close(M @ thrusts, [lift, *tau], atol=1e-8)
        expect_close(null_space(M).T @ thrusts, np.zeros(n - 4), atol=1e-8)


@hidden(rotor_thrusts)
def a_rotor_may_be_asked_to_pull(f: Function, rng: np.random.Generator) -> None:
    """Nothing may be clipped: for a large torque some thrusts are below zero, and still make what was asked."""
    for n in (4, 8):
        M, tau = draw.allocation(rng, n), draw.vector(rng, 30.0)
        thrusts = numbers(f(1.0, tau, M), (n,))
        expect_close(M @ thrusts, [1.0, *tau], atol=1e-8)
        expect(thrusts.min() < 0.0, "None of them is below zero.")


@hidden(motor_step)
def what_is_left_of_the_gap(f: Function, rng: np.random.Generator) -> None:
    """The gap to the command must shrink by exp(-dt / tau), up or down, whatever the step."""
    for share in (0.01, 0.2, 1.0, 2.5, 6.0):
        speed, command = rng.uniform(100.0, 900.0, size=(2, 5))
        tau = float(rng.uniform(0.02, 0.1))
        new = numbers(f(speed, command, tau, share * tau), (5,))
        expect_close((command - new) / (command - speed), np.full(5, np.exp(-share)), atol=1e-8)


@hidden(motor_step)
def steps_add_up(f: Function, rng: np.random.Generator) -> None:
    """A short step and a long one must make the step of both times together."""
    for _ in range(3):
        speed, command = rng.uniform(100.0, 900.0, size=(2, 4))
        tau, a, b = rng.uniform(0.02, 0.1, size=3)
        first = numbers(f(speed, command, tau, a), (4,))
        expect(np.all((first - speed) * (command - first) > 0.0), "It is not on its way.")
        whole = numbers(f(speed, command, tau, a + b), (4,))
        expect_close(f(first, command, tau, b), whole)
        left = np.exp(-(a + b) / tau)  # steps of any wrong tau add up too
        expect_close(whole, command + (speed - command) * left, atol=1e-7)


@hidden(motor_step)
def the_rate_does_not_matter(f: Function, rng: np.random.Generator) -> None:
    """A motor that follows changing commands must end at the same speed at 100 Hz and at 500 Hz."""
    commands, tau, ends = rng.uniform(100.0, 900.0, size=(20, 4)), 0.047, []
    for substeps in (1, 5):
        speed = np.full(4, 300.0)
        for command in commands:
            for _ in range(substeps):
                speed = numbers(f(speed, command, tau, 0.01 / substeps), (4,))
        ends.append(speed)
    filtered = np.full(4, 300.0)
    for command in commands:
        filtered += (command - filtered) * -np.expm1(-0.01 / tau)
    expect_close(ends[0], ends[1])
    expect_close(ends[0], filtered)


@hidden(throttle_from_force)
def hover_of_any_mass(f: Function, rng: np.random.Generator) -> None:
    """The throttle must lie on the line through the square root of the force, for light and for heavy aircraft."""
    for T in rng.uniform(0.1, 0.9, size=5):
        a_t, b_t = draw.thrust_curve(rng)
        s = (T - b_t) / a_t
        expect_close(f(float(s * s), a_t, b_t), T)


@hidden(throttle_from_force)
def rotors_cannot_pull(f: Function, rng: np.random.Generator) -> None:
    """A force of zero or below asks for the throttle b_t, and a force just above zero for little more."""
    for _ in range(2):
        a_t, b_t = draw.thrust_curve(rng)
        for force in (0.0, -float(rng.uniform(0.1, 20.0))):
            expect_close(f(force, a_t, b_t), b_t)
        expect_close(f(1e-4, a_t, b_t), 0.01 * a_t + b_t)


@hidden(throttle_from_force)
def a_force_out_of_reach(f: Function, rng: np.random.Generator) -> None:
    """The throttle must not be clipped: for a force out of reach it says by how much."""
    for _ in range(3):
        a_t, b_t = draw.thrust_curve(rng)
        s = (rng.uniform(1.2, 3.0) - b_t) / a_t
        got = numbers(f(float(s * s), a_t, b_t), ())
        expect_close((got - b_t) / a_t, s)
        expect(got > 1.0, "The throttle was clipped.")


@hidden(force_from_throttle)
def along_the_whole_curve(f: Function, rng: np.random.Generator) -> None:
    """At any throttle the force must be the one that asks for this throttle."""
    for T in rng.uniform(0.02, 1.0, size=5):
        a_t, b_t = draw.thrust_curve(rng)
        force = numbers(f(float(T), a_t, b_t), ())
        expect(force > 0.0, "There is no force.")
        expect_close((T - b_t) / np.sqrt(force), a_t)


@hidden(force_from_throttle)
def rotors_that_stand_still(f: Function, rng: np.random.Generator) -> None:
    """At the throttle b_t and below there must be no force, and just above b_t little."""
    for _ in range(2):
        a_t, b_t = draw.thrust_curve(rng)
        for below in (0.0, float(rng.uniform(0.1, 0.5))):
            expect_close(f(b_t - below, a_t, b_t), 0.0)
        expect_close(f(b_t + 0.01, a_t, b_t), (0.01 / a_t) ** 2)


@hidden(force_from_throttle)
def slope_of_the_curve(f: Function, rng: np.random.Generator) -> None:
    """Force must grow with throttle, faster at more throttle: the second difference is 2 / a_t squared."""
    h = 0.05
    for _ in range(3):
        a_t, b_t = draw.thrust_curve(rng)
        T = float(rng.uniform(0.4, 0.8))
        low, here, high = (numbers(f(T + k * h, a_t, b_t), ()) for k in (-1, 0, 1))
        expect(low < here < high, "Force does not grow.")
        expect_close((high - 2.0 * here + low) / h**2, 2.0 / a_t**2, rtol=1e-8)


@hidden(apparent_mass)
def weighs_any_aircraft(f: Function, rng: np.random.Generator) -> None:
    """At its hover throttle of eq. (33) an aircraft must appear with its own mass, wherever it flies."""
    for m in (0.4, 1.7, 4.8, 15.0):
        (a_t, b_t), g = draw.thrust_curve(rng), float(rng.uniform(1.6, 24.0))
        m = float(m * rng.uniform(0.9, 1.1))
        expect_close(f(float(a_t * np.sqrt(m * g) + b_t), a_t, b_t, g), m)


@hidden(apparent_mass)
def on_the_moon(f: Function, rng: np.random.Generator) -> None:
    """With less gravity the same throttle must carry as much more mass."""
    for _ in range(3):
        (a_t, b_t), T = draw.thrust_curve(rng), float(rng.uniform(0.4, 0.9))
        here, there = (numbers(f(T, a_t, b_t, g), ()) for g in (9.81, 1.62))
        expect_close(there * 1.62, here * 9.81)
        expect(0.0 < here < there, "Less gravity must mean more mass.")
        expect_close(here * 9.81 * a_t**2, (T - b_t) ** 2)  # anything over g has the ratio right


@hidden(apparent_mass)
def nothing_is_carried(f: Function, rng: np.random.Generator) -> None:
    """At the throttle b_t and below the rotors must carry nothing, and just above b_t little."""
    for _ in range(2):
        (a_t, b_t), g = draw.thrust_curve(rng), float(rng.uniform(1.6, 24.0))
        for below in (0.0, float(rng.uniform(0.1, 0.5))):
            expect_close(f(b_t - below, a_t, b_t, g), 0.0)
        expect_close(f(b_t + 0.02, a_t, b_t, g), (0.02 / a_t) ** 2 / g)


@hidden(apparent_mass)
def touchdown(f: Function, rng: np.random.Generator) -> None:
    """As an aircraft settles on the ground its thrust fades, and its apparent mass must fade in proportion."""
    (a_t, b_t), m, g = draw.thrust_curve(rng), float(rng.uniform(1.0, 6.0)), 9.81
    carried = np.linspace(1.0, 0.05, 20)
    masses = [numbers(f(float(a_t * np.sqrt(c * m * g) + b_t), a_t, b_t, g), ()) for c in carried]
    expect_close(np.array(masses) / m, carried)
