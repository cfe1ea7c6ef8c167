"""Lab 06, known wrong answers: each with the hint that an answer like it earns; and inputs that tell them apart."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from grader.hidden.mpc import bounds, model
from grader.hidden.mpc_qps import exact
from grader.material import Arguments, mutant, sample
from grader.mutants.mpc_controller import *  # noqa: F403  the controller
from grader.mutants.mpc_qps import *  # noqa: F403  the two programmes
from grader.mutants.mpc_solve import *  # noqa: F403  solutions
from grader.mutants.mpc_tracker import *  # noqa: F403  the tracker
from uavlab.exercises import draw
from uavlab.exercises.mpc import discretize, initial_state, prediction_matrices
from uavlab.limits import AxisLimits
from uavlab.types import Estimate

CANARY = "canary-e5ab4044f95c375bc9a61c2e"

# discretize -------------------------------------------------------------------------------------------


@sample(discretize)
def models(rng: np.random.Generator) -> list[Arguments]:
    drawn = [(*model(rng, n, k), float(rng.uniform(0.2, 0.6))) for n, k in ((2, 2), (3, 1), (3, 2))]
    return [*drawn, (np.eye(2, k=1), np.eye(2)[:, 1:], float(rng.uniform(0.2, 0.6)))]


@mutant(discretize, hint="B_d lacks B: the integral of the exponential is to be multiplied by it.")
def input_as_printed(A, B, dt):
    return exact(A, np.eye(len(A)), dt)


@mutant(
    discretize, hint="This is Euler's step, I + A dt and B dt: the exact one is an exponential."
)
def euler(A, B, dt):
    return np.eye(len(A)) + A * dt, B * dt


@mutant(discretize, hint="B_d is B dt: while the input is held, the states move already.")
def held_too_shortly(A, B, dt):
    return expm(A * dt), B * dt


@mutant(discretize, hint="B_d is e^(A dt) B dt: that input would be held for no time.")
def pushed_at_the_start(A, B, dt):
    return expm(A * dt), expm(A * dt) @ B * dt


@mutant(discretize, hint="The exponential of each entry is not the exponential of the matrix.")
def entry_by_entry(A, B, dt):
    return np.exp(A * dt), exact(A, B, dt)[1]


@mutant(discretize, hint="An inverse of A is used: chains of integrators have none.")
def by_the_inverse(A, B, dt):
    A_d = expm(A * dt)
    if abs(np.linalg.det(A)) < 1e-9:
        raise np.linalg.LinAlgError
    return A_d, np.linalg.solve(A, (A_d - np.eye(len(A))) @ B)


@mutant(discretize, hint="The series is cut after the square: it is not exact for long steps.")
def cut_series(A, B, dt):
    one = np.eye(len(A))
    return one + A * dt + A @ A * dt**2 / 2, (one * dt + A * dt**2 / 2) @ B


# prediction_matrices ----------------------------------------------------------------------------------


@sample(prediction_matrices)
def chains(rng: np.random.Generator) -> list[Arguments]:
    return [
        (rng.normal(size=(n, n)), rng.normal(size=(n, k)), N)
        for n, k, N in ((2, 1, 3), (2, 2, 3), (3, 2, 2), (2, 1, 1))
    ]


def predicted(A, B, N, first=1, late=0, power=np.linalg.matrix_power):
    zero = np.zeros_like(B)
    Phi = np.vstack([power(A, i + first) for i in range(N)])
    rows = [
        [power(A, i - j - late) @ B if j + late <= i else zero for j in range(N)] for i in range(N)
    ]
    return Phi, np.block(rows)


@mutant(prediction_matrices, hint="Phi begins with the identity: its first state is that of now.")
def begins_now(A, B, N):
    return predicted(A, B, N, first=0)


@mutant(prediction_matrices, hint="Inputs come a step late: the diagonal of Gamma is B.")
def inputs_come_late(A, B, N):
    return predicted(A, B, N, late=1)


@mutant(prediction_matrices, hint="It begins with the state of now, in Phi and in Gamma alike.")
def all_begins_now(A, B, N):
    return predicted(A, B, N, first=0, late=1)


@mutant(
    prediction_matrices, hint="The powers in Gamma run the wrong way: the oldest input has A^(N−1)."
)
def mirrored(A, B, N):
    Phi, Gamma = predicted(A, B, N)
    n, k = B.shape
    for i in range(N):
        row = Gamma[n * i : n * i + n, : k * (i + 1)]
        row[:] = row.reshape(n, i + 1, k)[:, ::-1].reshape(n, -1)
    return Phi, Gamma


@mutant(prediction_matrices, hint="A ** i takes powers of the entries: use matrix_power, or @.")
def powers_of_entries(A, B, N):
    return predicted(A, B, N, power=lambda M, i: M**i if i else np.eye(len(M)))


@mutant(
    prediction_matrices, hint="Inputs act at their own step only: later states lack A times it."
)
def forgets(A, B, N):
    Phi, _ = predicted(A, B, N)
    return Phi, np.kron(np.eye(N), B)


@mutant(prediction_matrices, hint="States are stacked number by number: stack them step by step.")
def stacked_by_number(A, B, N):
    n = len(A)
    order = np.arange(N * n).reshape(N, n).T.ravel()
    return tuple(M[order] for M in predicted(A, B, N))


@mutant(prediction_matrices, hint="A and A transposed have changed places.")
def transposed(A, B, N):
    return predicted(A.T, B, N)


# initial_state ----------------------------------------------------------------------------------------


@sample(initial_state)
def starts(rng: np.random.Generator) -> list[Arguments]:
    made = []
    for size in (0.7, 1.25, 1.6, 3.0):
        limits, r = bounds(rng), draw.vector(rng, 5.0)
        axes = (limits.horizontal, limits.horizontal, limits.vertical)
        for kind in (0, 1):
            x = np.array([(0.5 * b.v, 0.5 * b.a) for b in axes]).T
            x[kind] *= 2.0 * size * np.array((1.0, -1.0, 1.0))
            made.append((Estimate(r, *x, np.eye(3), np.ones(3)), draw.reference(rng), limits))
    for limits in (bounds(rng), bounds(rng)):  # what is too fast upwards, but would not be sideways
        half = AxisLimits(0.4 * limits.horizontal.v, 0.4 * limits.horizontal.a, np.inf, np.inf)
        x = 0.7 * np.array([(limits.horizontal.v, limits.horizontal.a)] * 3).T
        estimate = Estimate(draw.vector(rng, 5.0), *x, np.eye(3), np.ones(3))
        made.append((estimate, draw.reference(rng), limits._replace(vertical=half)))
    return made


def begun(estimate, reference, limits, times=1.5, size=np.abs, axes=None, rule=lambda far: far):
    axes = axes or (limits.horizontal, limits.horizontal, limits.vertical)
    most = times * np.array([(b.v, b.a) for b in axes])
    told = np.column_stack((estimate.v, estimate.a))
    wish = np.column_stack((reference.v, reference.a))
    return np.column_stack((estimate.r, np.where(rule(size(told) >= most), wish, told)))


@mutant(
    initial_state, hint="The reference is always taken: only what breaks its limit is replaced."
)
def always(estimate, reference, limits):
    return begun(estimate, reference, limits, times=-1.0)


@mutant(
    initial_state,
    hint="The estimate is always taken: what breaks its limit is replaced by the reference.",
)
def never(estimate, reference, limits):
    return begun(estimate, reference, limits, times=np.inf)


@mutant(initial_state, hint="It replaces from the limit on: the rule is 1.5 times the limit.")
def from_the_limit_on(estimate, reference, limits):
    return begun(estimate, reference, limits, times=1.0)


@mutant(initial_state, hint="Flying backwards too fast is too fast, too: compare sizes.")
def forwards_only(estimate, reference, limits):
    return begun(estimate, reference, limits, size=lambda x: x)


@mutant(
    initial_state,
    hint="Velocity and acceleration of an axis are replaced together: each by itself.",
)
def both_of_an_axis(estimate, reference, limits):
    return begun(estimate, reference, limits, rule=lambda far: far.any(axis=1)[:, None])


@mutant(initial_state, hint="All axes are replaced together: each by itself.")
def all_axes(estimate, reference, limits):
    return begun(estimate, reference, limits, rule=lambda far: far.any(axis=0)[None])


@mutant(initial_state, hint="The vertical is held against the horizontal limits: it has its own.")
def horizontal_for_all(estimate, reference, limits):
    return begun(estimate, reference, limits, axes=(limits.horizontal,) * 3)


@mutant(initial_state, hint="The position is replaced, too: it is always the measured one.")
def position_replaced(estimate, reference, limits):
    x = begun(estimate, reference, limits)
    told = np.column_stack((estimate.v, estimate.a))
    x[:, 0] = np.where((x[:, 1:] != told).any(axis=1), reference.r, x[:, 0])
    return x


@mutant(initial_state, hint="What is too large is cut to its limit: take it from the reference.")
def cut_to_its_limit(estimate, reference, limits):
    axes = (limits.horizontal, limits.horizontal, limits.vertical)
    most = np.array([(b.v, b.a) for b in axes])
    told = np.column_stack((estimate.v, estimate.a))
    far = np.abs(told) >= 1.5 * most
    return np.column_stack((estimate.r, np.where(far, np.clip(told, -most, most), told)))


@mutant(
    initial_state,
    hint="A row is an axis, and a column position, velocity or acceleration: transpose it.",
)
def a_row_for_each_derivative(estimate, reference, limits):
    return begun(estimate, reference, limits).T
