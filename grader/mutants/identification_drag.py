"""Lab 05, known wrong answers: drag in flight."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab.exercises import bench
from uavlab.exercises.identification import (
    drag_coefficient,
    quadratic_drag,
)
from uavlab.exercises.identification_checks import pulled

CANARY = "canary-1c0d84efd9fd5213c4c00be3"

# drag_coefficient -------------------------------------------------------------------------------------


def flights(rng: np.random.Generator) -> list[Arguments]:
    drawn = []
    for n in (15, 30, 25, 20):
        V, a_z = bench.sweep(rng, n)
        c_2, c, offset = rng.uniform((0.005, 0.05, 0.1), (0.02, 0.2, 0.3), size=(2, 3)).T
        accel = pulled(V, a_z, c_2, c, offset)
        accel[:, :2] += 0.5 * rng.normal(size=(n, 2))
        drawn.append((accel, V))
    drawn[-1][0][4:6, 2] = (0.5, 0.8)  # near free fall
    return drawn


@sample(drag_coefficient)
def sweeps(rng: np.random.Generator) -> list[Arguments]:
    return flights(rng)


def kept(accel, v_body, root=np.sqrt):
    """Velocities and −a over what `root` makes of a_z, of the samples with enough lift."""
    lifted = accel[:, 2] > 1.0
    return v_body[lifted], -accel[lifted, :2] / root(accel[lifted, 2])[:, None]


def line(V, y):
    """Slope, offset and R² of each column."""
    c, offset = np.transpose([np.polyfit(V[:, i], y[:, i], 1) for i in (0, 1)])
    return c, offset, np.var(c * V, axis=0) / np.var(y, axis=0)


@mutant(
    drag_coefficient, hint="c has the wrong sign: drag opposes the velocity, and c is above zero."
)
def c_negated(accel, v_body):
    c, offset, r2 = line(*kept(accel, v_body))
    return -c, -offset, r2


@mutant(
    drag_coefficient,
    hint="The offset has the wrong sign: it stands beside c V, inside the same minus.",
)
def offset_outside(accel, v_body):
    c, offset, r2 = line(*kept(accel, v_body))
    return c, -offset, r2


@mutant(
    drag_coefficient,
    hint="The offset is forgotten: a line through the origin blames it on the velocity.",
)
def no_offset_of_drag(accel, v_body):
    V, y = kept(accel, v_body)
    c = (V * y).sum(axis=0) / (V * V).sum(axis=0)
    return c, np.zeros(2), 1.0 - ((y - c * V) ** 2).sum(axis=0) / y.var(axis=0) / len(y)


@mutant(
    drag_coefficient,
    hint="The square root is missing: the drag grows with the root of the thrust, so divide by √a_z.",
)
def no_root_of_thrust(accel, v_body):
    return line(*kept(accel, v_body, lambda a_z: a_z))


@mutant(
    drag_coefficient,
    hint="The thrust of hover is taken for that of each sample: divide by the root of a_z as it was.",
)
def always_in_hover(accel, v_body):
    return line(*kept(accel, v_body, lambda a_z: np.full_like(a_z, np.sqrt(9.81))))


@mutant(
    drag_coefficient,
    hint="The thrust is left out: the force over the velocity is c √a_z, not c.",
)
def no_thrust(accel, v_body):
    return line(*kept(accel, v_body, np.ones_like))


@mutant(drag_coefficient, hint="This is the correlation: R² is its square.")
def correlation_for_r2(accel, v_body):
    c, offset, r2 = line(*kept(accel, v_body))
    return c, offset, np.sqrt(r2)


@mutant(
    drag_coefficient,
    hint="The mean of the ratios is not the slope: where V is small a ratio is only noise.",
)
def mean_of_ratios(accel, v_body):
    V, y = kept(accel, v_body)
    c = (y / V).mean(axis=0)
    return c, (y - c * V).mean(axis=0), line(V, y)[2]


@mutant(
    drag_coefficient, hint="Samples near free fall are kept: where a_z ≤ 1 m/s² drag says nothing."
)
def free_fall_kept(accel, v_body):
    return line(v_body, -accel[:, :2] / np.sqrt(np.abs(accel[:, 2:])))


@mutant(
    drag_coefficient,
    hint="Velocity is fitted on force, and the slope turned over: the noise is in the force here.",
)
def turned_over(accel, v_body):
    V, y = kept(accel, v_body)
    slope, at_zero, r2 = line(y, V)
    return 1.0 / slope, -at_zero / slope, r2


# quadratic_drag ---------------------------------------------------------------------------------------


@sample(quadratic_drag)
def fast_sweeps(rng: np.random.Generator) -> list[Arguments]:
    return flights(rng)


def fit(parts, y):
    """Coefficients and R² of each axis; `parts` (n, 2, k)."""
    x = [np.linalg.lstsq(parts[:, i], y[:, i], rcond=None)[0] for i in (0, 1)]
    left = [np.var(y[:, i] - parts[:, i] @ x[i]) for i in (0, 1)]
    return (*np.transpose(x), 1.0 - np.array(left) / y.var(axis=0))


def parts_of(V):
    return np.stack((V * np.abs(V), V, np.ones_like(V)), axis=-1)


@mutant(
    quadratic_drag,
    hint="V² has no direction: drag turns round with the velocity, so it is V |V|.",
)
def square_without_side(accel, v_body):
    V, y = kept(accel, v_body)
    return fit(np.stack((V * V, V, np.ones_like(V)), axis=-1), y)


@mutant(quadratic_drag, hint="The order is c_2, c, offset, R²: the quadratic part first.")
def linear_first(accel, v_body):
    V, y = kept(accel, v_body)
    c_2, c, offset, r2 = fit(parts_of(V), y)
    return c, c_2, offset, r2


@mutant(quadratic_drag, hint="The offset is forgotten.")
def no_offset_of_parabola(accel, v_body):
    V, y = kept(accel, v_body)
    c_2, c, r2 = fit(parts_of(V)[..., :2], y)
    return c_2, c, np.zeros(2), r2


@mutant(
    quadratic_drag,
    hint="The parts are fitted one after the other: they are not square to each other, fit them at once.",
)
def one_after_the_other(accel, v_body):
    V, y = kept(accel, v_body)
    c, offset, _ = line(V, y)
    left = y - c * V - offset
    c_2, r2 = fit(parts_of(V)[..., :1], left)
    return c_2, c, offset, r2


@mutant(
    quadratic_drag,
    hint="All signs are wrong: drag opposes the velocity, and c_2 and c are above zero.",
)
def parabola_negated(accel, v_body):
    V, y = kept(accel, v_body)
    c_2, c, offset, r2 = fit(parts_of(V), -y)
    return c_2, c, offset, r2


@mutant(
    quadratic_drag,
    hint="The square root is missing: divide the force by √a_z, as in the linear fit.",
)
def no_root_under_parabola(accel, v_body):
    V, y = kept(accel, v_body, lambda a_z: a_z)
    return fit(parts_of(V), y)


@mutant(
    quadratic_drag,
    hint="R² is the one of the linear fit: the quadratic one explains more.",
)
def r2_of_the_line(accel, v_body):
    V, y = kept(accel, v_body)
    return (*fit(parts_of(V), y)[:3], line(V, y)[2])
