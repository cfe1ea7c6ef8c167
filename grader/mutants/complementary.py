"""Lab 04, known wrong answers: each with the hint that an answer like it earns; and inputs that tell them apart."""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm

from grader.material import Arguments, mutant, sample
from grader.mutants.complementary_attitude import *  # noqa: F403  the attitude of the lab
from grader.mutants.complementary_coupled import *  # noqa: F403  the class of the lab
from grader.mutants.complementary_filters import *  # noqa: F403  the two filters of the lab
from uavlab.exercises import draw
from uavlab.exercises.complementary import (
    drag_velocity,
    position_observer_step,
    vertical_step,
)
from uavlab.solutions import complementary as right
from uavlab.types import GRAVITY, VerticalGains, VerticalMemory

CANARY = "canary-9677a32f5ae9023e8b5f3890"

UP = np.array((0.0, 0.0, GRAVITY))  # [m/s²] specific force at rest

# position_observer_step -------------------------------------------------------------------------------


@sample(position_observer_step)
def positions(rng: np.random.Generator) -> list[Arguments]:
    drawn = []
    for k in range(5):
        r, v, a, z = (draw.vector(rng, 2.0) for _ in range(4))
        gains = float(rng.uniform(1.0, 5.0)), float(rng.uniform(1.0, 9.0))
        drawn.append((r, v, a, None if k == 4 else z, *gains, float(rng.uniform(0.1, 0.4))))
    return [*drawn, (r, v, a, z, -1.0, 2.0, 0.1), (r, v, a, z, 1.0, 0.0, 0.1)]


def rates(r, v, accel_W, r_meas, k_p, k_v):
    e = 0.0 * r if r_meas is None else r_meas - r
    return v + k_p * e, accel_W + k_v * e


@mutant(
    position_observer_step,
    hint="This is one explicit Euler step of (11): at 30 Hz, with the gains of Spica, it grows. Solve it instead.",
)
def euler_position(r, v, accel_W, r_meas, k_p, k_v, dt):
    r_dot, v_dot = rates(r, v, accel_W, r_meas, k_p, k_v)
    return r + dt * r_dot, v + dt * v_dot


@mutant(
    position_observer_step,
    hint="The velocity is stepped first and then the position with it: better than Euler, but (11) can be solved.",
)
def velocity_first(r, v, accel_W, r_meas, k_p, k_v, dt):
    v_dot = rates(r, v, accel_W, r_meas, k_p, k_v)[1]
    v = v + dt * v_dot
    return r + dt * rates(r, v, accel_W, r_meas, k_p, k_v)[0], v


@mutant(
    position_observer_step,
    hint="The innovation is held over the step and the rest solved: it has to shrink while it acts.",
)
def innovation_held_over_the_step(r, v, accel_W, r_meas, k_p, k_v, dt):
    e = 0.0 * r if r_meas is None else r_meas - r
    a = accel_W + k_v * e
    return r + dt * (v + k_p * e) + 0.5 * dt * dt * a, v + dt * a


@mutant(
    position_observer_step,
    hint="The two gains are swapped: k_p draws the position, k_v the velocity.",
)
def gains_swapped(r, v, accel_W, r_meas, k_p, k_v, dt):
    return right.position_observer_step(r, v, accel_W, r_meas, k_v, k_p, dt)


@mutant(
    position_observer_step,
    hint="The innovation does not act on the velocity: K has two blocks, and k_v is the lower.",
)
def velocity_never_corrected(r, v, accel_W, r_meas, k_p, k_v, dt):
    if r_meas is None or not (k_p > 0.0 and k_v > 0.0):
        return right.position_observer_step(r, v, accel_W, r_meas, k_p, k_v, dt)
    A = np.zeros((4, 4))
    A[:2] = (-k_p, 1.0, k_p, 0.0), (0.0, 0.0, 0.0, 1.0)
    return tuple((expm(A * dt) @ np.array((r, v, r_meas, accel_W)))[:2])


@mutant(
    position_observer_step,
    hint="Gravity is taken off a second time: accel_W is 0 at rest.",
)
def gravity_twice(r, v, accel_W, r_meas, k_p, k_v, dt):
    down = np.array((0.0, 0.0, -GRAVITY))
    return right.position_observer_step(r, v, accel_W + down, r_meas, k_p, k_v, dt)


@mutant(
    position_observer_step,
    hint="Before the first measurement the origin is taken for one: without a measurement nothing draws.",
)
def origin_for_nothing(r, v, accel_W, r_meas, k_p, k_v, dt):
    z = np.zeros(3) if r_meas is None else r_meas
    return right.position_observer_step(r, v, accel_W, z, k_p, k_v, dt)


@mutant(
    position_observer_step,
    hint="Any gains are taken: with one that is not above zero the observer is not stable. Raise ValueError.",
)
def any_gains(r, v, accel_W, r_meas, k_p, k_v, dt):
    try:
        return right.position_observer_step(r, v, accel_W, r_meas, k_p, k_v, dt)
    except ValueError:
        return r, v


# drag_velocity ----------------------------------------------------------------------------------------


@sample(drag_velocity)
def forces(rng: np.random.Generator) -> list[Arguments]:
    ups = (*rng.uniform(2.0, 20.0, size=3), 0.5, -3.0)
    return [(np.append(rng.normal(size=2), u), float(rng.uniform(0.05, 0.5))) for u in ups]


def guarded(accel, c, V):
    if not c > 0.0:
        raise ValueError
    return V if accel[2] > 1.0 else np.full(2, np.nan)


@mutant(
    drag_velocity, hint="The drag grows with the square root of the thrust, not with the thrust."
)
def no_square_root(accel, c):
    return guarded(accel, c, -accel[:2] / (c * accel[2]))


@mutant(drag_velocity, hint="The sign is missing: drag points against the velocity.")
def along_the_drag(accel, c):
    return -right.drag_velocity(accel, c)


@mutant(drag_velocity, hint="The thrust is not always the weight: take it from accel along body z.")
def weight_for_thrust(accel, c):
    return guarded(accel, c, -accel[:2] / (c * GRAVITY**0.5))


@mutant(
    drag_velocity,
    hint="The body z axis points up here: a_z of the paper is negative in flight, ours positive.",
)
def z_down(accel, c):
    return guarded(accel * (1, 1, -1), c, -accel[:2] / (c * np.sqrt(-accel[2])))


@mutant(drag_velocity, hint="Near free fall there is no velocity to be had: NaN, not zero.")
def zero_in_free_fall(accel, c):
    return np.nan_to_num(right.drag_velocity(accel, c))


@mutant(
    drag_velocity,
    hint="Near free fall a guard is missing: at and below 1 m/s² along body z the answer is NaN.",
)
def no_guard(accel, c):
    if not c > 0.0:
        raise ValueError
    return -accel[:2] / (c * np.sqrt(accel[2]))


@mutant(drag_velocity, hint="x and y are swapped: each axis feels its own drag.")
def axes_swapped(accel, c):
    return right.drag_velocity(accel, c)[::-1]


@mutant(
    drag_velocity, hint="The square root is taken of the quotient: only the thrust stands under it."
)
def root_of_the_coefficient(accel, c):
    return guarded(accel, c, -accel[:2] / np.sqrt(c * accel[2]))


# vertical_step ----------------------------------------------------------------------------------------


@sample(vertical_step)
def heights(rng: np.random.Generator) -> list[Arguments]:
    drawn = []
    for k in range(5):
        x = VerticalMemory(*map(float, rng.normal(size=3)))
        R, accel = draw.tilted(rng, 0.3, 1.0), draw.vector(rng, 2.0) + UP
        gains = {"gains": VerticalGains(*map(float, rng.uniform((2, 2, 1), (4, 4, 3))))}
        drawn.append((x, R, accel, None if k == 4 else float(rng.normal()), 0.05, gains))
    unstable = {"gains": VerticalGains(1.0, 1.0, 2.0)}
    return [*drawn, (x, R, accel, 0.5, 0.05, unstable)]


def filter_0(x, R, accel, z_meas, dt, gains, *, up=None, signs=(1, 1, 1), bias=-1.0):
    """(4), with what may be wrong in it as parameters."""
    k_1, k_2, k_3 = (s * k for s, k in zip(signs, gains, strict=True))
    if not 0.0 < gains.k_3 < gains.k_1 * gains.k_2:
        raise ValueError
    e = 0.0 if z_meas is None else x.z - z_meas
    force = (R @ accel)[2] - GRAVITY if up is None else up
    return VerticalMemory(
        x.z + dt * (x.v_z - k_1 * e),
        x.v_z + dt * (force + bias * x.b_z - k_2 * e),
        x.b_z + dt * k_3 * e,
    )


@mutant(vertical_step, hint="The specific force is told in the body: turn it into the world first.")
def body_z(memory, R, accel, z_meas, dt, *, gains):
    return filter_0(memory, R, accel, z_meas, dt, gains, up=accel[2] - GRAVITY)


@mutant(vertical_step, hint="R is transposed: it turns a body vector into a world vector.")
def transposed(memory, R, accel, z_meas, dt, *, gains):
    return filter_0(memory, R, accel, z_meas, dt, gains, up=(R.T @ accel)[2] - GRAVITY)


@mutant(
    vertical_step, hint="Gravity is missing: at rest the accelerometer reads +g, and nothing moves."
)
def no_gravity(memory, R, accel, z_meas, dt, *, gains):
    return filter_0(memory, R, accel, z_meas, dt, gains, up=(R @ accel)[2])


@mutant(
    vertical_step, hint="Gravity has the sign of the paper, whose z points down: take g off here."
)
def gravity_added(memory, R, accel, z_meas, dt, *, gains):
    return filter_0(memory, R, accel, z_meas, dt, gains, up=(R @ accel)[2] + GRAVITY)


@mutant(vertical_step, hint="The bias follows the innovation with the wrong sign, and runs away.")
def bias_runs_away(memory, R, accel, z_meas, dt, *, gains):
    return filter_0(memory, R, accel, z_meas, dt, gains, signs=(1, 1, -1))


@mutant(vertical_step, hint="The bias is added to the acceleration: it is to be taken off.")
def bias_added(memory, R, accel, z_meas, dt, *, gains):
    return filter_0(memory, R, accel, z_meas, dt, gains, bias=1.0)


@mutant(vertical_step, hint="The bias stands still: (4c) lets it follow the innovation.")
def bias_frozen(memory, R, accel, z_meas, dt, *, gains):
    return filter_0(memory, R, accel, z_meas, dt, gains, signs=(1, 1, 0))


@mutant(vertical_step, hint="The innovation acts on the height only: k_2 draws the velocity.")
def velocity_not_drawn(memory, R, accel, z_meas, dt, *, gains):
    return filter_0(memory, R, accel, z_meas, dt, gains, signs=(1, 0, 1))


@mutant(
    vertical_step,
    hint="Positive gains are not enough: with k_3 not below k_1 k_2 the error grows. Raise ValueError.",
)
def only_positive_gains(memory, R, accel, z_meas, dt, *, gains):
    k_1, k_2, k_3 = gains
    if min(gains) <= 0.0:
        raise ValueError
    safe = VerticalGains(k_1, k_2, 0.5 * k_1 * k_2)
    x = filter_0(memory, R, accel, z_meas, dt, safe)
    e = 0.0 if z_meas is None else memory.z - z_meas
    return x._replace(b_z=memory.b_z + dt * k_3 * e)


@mutant(vertical_step, hint="Before the first height 0 is taken for one: None means no innovation.")
def ground_for_nothing(memory, R, accel, z_meas, dt, *, gains):
    return filter_0(memory, R, accel, 0.0 if z_meas is None else z_meas, dt, gains)
