"""Lab 01, known wrong answers: each with the hint that an answer like it earns; and inputs that tell them apart."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from grader.mutants.dynamics_motors import *  # noqa: F403  the second half of the lab
from uavlab.exercises import draw
from uavlab.exercises.dynamics import (
    allocation_matrix,
    rigid_body_rate,
    rotor_thrusts,
    step_on_so3,
)
from uavlab.so3 import exp, hat, project
from uavlab.types import StateRate

CANARY = "canary-ab17c12ba88672c3ddc3b373"

# rigid_body_rate --------------------------------------------------------------------------------------


@sample(rigid_body_rate)
def pushed_bodies(rng: np.random.Generator) -> list[Arguments]:
    drawn = [draw.pushed(rng) for _ in range(6)]
    return [(x, force, torque, {"m": m, "J": J}) for x, force, torque, m, J in drawn]


def rate(x, force, torque, m, J, **other):
    right = {
        "r_dot": x.v,
        "v_dot": force / m,
        "R_dot": x.R @ hat(x.omega),
        "omega_dot": np.linalg.solve(J, torque - np.cross(x.omega, J @ x.omega)),
    }
    return StateRate(**(right | other))


@mutant(
    rigid_body_rate,
    hint="The gyroscopic term is missing: J ω̇ is not the torque alone while the body turns.",
)
def no_gyroscopic_term(state, force, torque, *, m, J):
    return rate(state, force, torque, m, J, omega_dot=np.linalg.solve(J, torque))


@mutant(
    rigid_body_rate,
    hint="The gyroscopic term has the wrong sign: in (3) of Spica it stands on the left side.",
)
def gyroscopic_term_added(state, force, torque, *, m, J):
    w = state.omega
    return rate(
        state, force, torque, m, J, omega_dot=np.linalg.solve(J, torque + np.cross(w, J @ w))
    )


@mutant(
    rigid_body_rate,
    hint="J is not diagonal here: solve with the whole matrix instead of dividing by its diagonal.",
)
def inertia_taken_as_diagonal(state, force, torque, *, m, J):
    w = state.omega
    return rate(state, force, torque, m, J, omega_dot=(torque - np.cross(w, J @ w)) / np.diag(J))


@mutant(
    rigid_body_rate, hint="The angular acceleration was multiplied by J: (3) must be solved for ω̇."
)
def multiplied_by_inertia(state, force, torque, *, m, J):
    w = state.omega
    return rate(state, force, torque, m, J, omega_dot=J @ (torque - np.cross(w, J @ w)))


@mutant(
    rigid_body_rate,
    hint="In Ṙ the matrix Ω stands on the wrong side of R: omega is told in the body, not in the world.",
)
def rate_taken_in_the_world(state, force, torque, *, m, J):
    return rate(state, force, torque, m, J, R_dot=hat(state.omega) @ state.R)


@mutant(
    rigid_body_rate, hint="Ṙ has the wrong sign: the matrix of the cross product is transposed."
)
def cross_product_transposed(state, force, torque, *, m, J):
    return rate(state, force, torque, m, J, R_dot=state.R @ hat(state.omega).T)


@mutant(rigid_body_rate, hint="The force is told in the world already: do not turn it with R.")
def force_turned(state, force, torque, *, m, J):
    return rate(state, force, torque, m, J, v_dot=state.R @ force / m)


@mutant(
    rigid_body_rate,
    hint="The weight is counted twice: the force that you are given holds it already.",
)
def weight_twice(state, force, torque, *, m, J):
    return rate(state, force, torque, m, J, v_dot=force / m - np.array((0.0, 0.0, 9.81)))


@mutant(rigid_body_rate, hint="The acceleration is the force over the mass: the mass is missing.")
def no_mass(state, force, torque, *, m, J):
    return rate(state, force, torque, m, J, v_dot=force)


@mutant(rigid_body_rate, hint="The velocity is told in the world already: do not turn it with R.")
def velocity_turned(state, force, torque, *, m, J):
    return rate(state, force, torque, m, J, r_dot=state.R @ state.v)


# step_on_so3 ------------------------------------------------------------------------------------------


@sample(step_on_so3)
def turns(rng: np.random.Generator) -> list[Arguments]:
    return [
        (draw.rotation(rng), rng.uniform(0.5, 3.0) * draw.direction(rng), float(dt))
        for dt in (*rng.uniform(0.05, 0.9, size=5), -0.3)
    ] + [(draw.rotation(rng), np.zeros(3), 0.01)]


@mutant(
    step_on_so3,
    hint="This is a step of Euler along Ṙ: it leaves the rotations. Use the exponential map.",
)
def euler(R, omega, dt):
    return R + dt * R @ hat(omega)


@mutant(
    step_on_so3,
    hint="This is a step of Euler, pulled back onto the rotations: near, but not the exact solution.",
)
def euler_projected(R, omega, dt):
    return project(R + dt * R @ hat(omega))


@mutant(
    step_on_so3,
    hint="The turn stands on the wrong side of R: omega is told in the body, not in the world.",
)
def turned_in_the_world(R, omega, dt):
    return exp(omega * dt) @ R


@mutant(step_on_so3, hint="It turns backwards: a sign, or a transposed matrix.")
def turned_backwards(R, omega, dt):
    return R @ exp(-omega * dt)


@mutant(step_on_so3, hint="omega is in radians per second, not in degrees.")
def turned_by_degrees(R, omega, dt):
    return R @ exp(np.radians(omega) * dt)


@mutant(step_on_so3, hint="The time step is not used: it turns by omega, not by omega times dt.")
def turned_for_a_second(R, omega, dt):
    return R @ exp(omega)


@mutant(
    step_on_so3, hint="With a body rate of zero the axis of the turn is 0/0: treat that case apart."
)
def undefined_at_rest(R, omega, dt):
    angle = np.linalg.norm(omega * dt)
    K = hat(omega * dt / angle)
    return R @ (np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K)


@mutant(step_on_so3, hint="In the formula of Rodrigues the second term is 1 − cos, not cos.")
def rodrigues_with_cosine(R, omega, dt):
    angle = np.linalg.norm(omega) * dt
    K = hat(omega / max(float(np.linalg.norm(omega)), 1e-12))
    return R @ (np.eye(3) + np.sin(angle) * K + np.cos(angle) * K @ K)


# allocation_matrix ------------------------------------------------------------------------------------


@sample(allocation_matrix)
def layouts(rng: np.random.Generator) -> list[Arguments]:
    return [draw.layout(rng, n) for n in (4, 4, 5, 6, 8)]


def rows(angles, arm, c, spins, *, f=None, x=None, y=None, z=None):
    n = np.ones(len(angles))
    right = (n, arm * np.sin(angles), -arm * np.cos(angles), c * spins)
    return np.stack([a if b is None else b for a, b in zip(right, (f, x, y, z), strict=True)])


@mutant(allocation_matrix, hint="The angles are in radians, not in degrees.")
def angles_as_degrees(angles, arm, torque_ratio, spins):
    return rows(np.radians(angles), arm, torque_ratio, spins)


@mutant(
    allocation_matrix,
    hint="The pitch torque has the wrong sign: a push at the front turns the nose up, about −y.",
)
def pitch_sign(angles, arm, torque_ratio, spins):
    return rows(angles, arm, torque_ratio, spins, y=arm * np.cos(angles))


@mutant(
    allocation_matrix,
    hint="The roll torque has the wrong sign: angles count counter-clockwise, a push at the left turns about +x.",
)
def roll_sign(angles, arm, torque_ratio, spins):
    return rows(angles, arm, torque_ratio, spins, x=-arm * np.sin(angles))


@mutant(
    allocation_matrix,
    hint="Sine and cosine are swapped: angles count from body x, a push there makes no roll torque.",
)
def sine_and_cosine_swapped(angles, arm, torque_ratio, spins):
    return rows(angles, arm, torque_ratio, spins, x=arm * np.cos(angles), y=-arm * np.sin(angles))


@mutant(
    allocation_matrix, hint="The spins are not used: every rotor twists the body in the same sense."
)
def spins_ignored(angles, arm, torque_ratio, spins):
    return rows(angles, arm, torque_ratio, np.ones(len(angles)))


@mutant(
    allocation_matrix,
    hint="The drag torque has the wrong sign: spins are signs of the torque on the body.",
)
def spins_reversed(angles, arm, torque_ratio, spins):
    return rows(angles, arm, torque_ratio, -spins)


@mutant(
    allocation_matrix,
    hint="The drag torque does not depend on the arm: torque_ratio is in metres already.",
)
def drag_with_arm(angles, arm, torque_ratio, spins):
    return rows(angles, arm, arm * torque_ratio, spins)


@mutant(allocation_matrix, hint="The matrix is transposed: one column for each rotor is asked for.")
def one_row_for_each_rotor(angles, arm, torque_ratio, spins):
    return rows(angles, arm, torque_ratio, spins).T


@mutant(allocation_matrix, hint="The arm is missing: a torque is a force times its arm.")
def no_arm(angles, arm, torque_ratio, spins):
    return rows(angles, 1.0, torque_ratio, spins)


# rotor_thrusts ----------------------------------------------------------------------------------------


@sample(rotor_thrusts)
def wishes(rng: np.random.Generator) -> list[Arguments]:
    return [
        (float(rng.uniform(5.0, 40.0)), draw.vector(rng, size), draw.allocation(rng, n))
        for n, size in ((4, 0.5), (4, 20.0), (6, 0.5), (6, 20.0), (8, 3.0))
    ]


@mutant(rotor_thrusts, hint="The transpose of the allocation matrix is not its inverse.")
def transpose_for_inverse(f, tau, allocation):
    return allocation.T @ np.array((f, *tau))


@mutant(
    rotor_thrusts,
    hint="A matrix with more than four columns has no inverse: a pseudo-inverse finds the least thrusts.",
)
def inverse_only(f, tau, allocation):
    return np.linalg.inv(allocation) @ np.array((f, *tau))


@mutant(
    rotor_thrusts,
    hint="Only four of the rotors are used: share the work, the least sum of squares is asked for.",
)
def first_four_rotors(f, tau, allocation):
    some = np.zeros(allocation.shape[1])
    some[:4] = np.linalg.solve(allocation[:, :4], np.array((f, *tau)))
    return some


@mutant(
    rotor_thrusts, hint="Thrusts below zero were clipped: then they no longer make what was asked."
)
def clipped(f, tau, allocation):
    return np.maximum(np.linalg.pinv(allocation) @ np.array((f, *tau)), 0.0)


@mutant(
    rotor_thrusts, hint="The order is thrust first, then torque: the rows of the matrix say so."
)
def torque_first(f, tau, allocation):
    return np.linalg.pinv(allocation) @ np.array((*tau, f))


@mutant(rotor_thrusts, hint="The torque has the wrong sign.")
def torque_negated(f, tau, allocation):
    return np.linalg.pinv(allocation) @ np.array((f, *-tau))


@mutant(rotor_thrusts, hint="The torque is not used: all rotors push alike.")
def torque_ignored(f, tau, allocation):
    return np.full(allocation.shape[1], f / allocation.shape[1])


@mutant(
    rotor_thrusts,
    hint="The rows of the matrix were treated as if they were square to each other: invert M Mᵀ as a whole.",
)
def rows_taken_as_square(f, tau, allocation):
    return allocation.T @ (np.array((f, *tau)) / np.sum(allocation**2, axis=1))
