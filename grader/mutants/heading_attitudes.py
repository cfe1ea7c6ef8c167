"""Lab 02, known wrong answers, the second part: attitudes that point a force."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab.exercises import draw
from uavlab.exercises.heading import attitude_by_projection, attitude_with_heading
from uavlab.so3 import about_z, exp
from uavlab.solutions import heading as right

CANARY = "canary-3e7fd8543a5b802706be6a94"


def axes(f_d, eta):
    """Thrust axis and heading vector (17), (19)."""
    return f_d / np.linalg.norm(f_d), np.array((np.cos(eta), np.sin(eta), 0.0))


def unit(x):
    return x / np.linalg.norm(x)


# attitude_by_projection -------------------------------------------------------------------------------


@sample(attitude_by_projection)
def leaning_forces(rng: np.random.Generator) -> list[Arguments]:
    lows = (0.2, 0.5, 0.8, 1.0)
    return [(draw.force(rng, low, low + 0.4), draw.angle(rng)) for low in lows]


@mutant(
    attitude_by_projection,
    hint="This keeps the heading: it is the oblique projection of Sec. 5.1.2, not Lee's of Sec. 5.1.1.",
)
def oblique_instead(f_d, heading_d):
    return right.attitude_with_heading(f_d, heading_d)


@mutant(
    attitude_by_projection,
    hint="The matrix is transposed: the three vectors of (18) are its columns.",
)
def vectors_as_rows(f_d, heading_d):
    return right.attitude_by_projection(f_d, heading_d).T


@mutant(
    attitude_by_projection,
    hint="The factors of a cross product in (19) are swapped: x and y axis point backwards.",
)
def cross_product_swapped(f_d, heading_d):
    p1, p2, b3 = right.attitude_by_projection(f_d, heading_d).T
    return np.column_stack((-p1, -p2, b3))


@mutant(
    attitude_by_projection, hint="The result is left-handed: p_1d is p_2d × b_3d, in this order."
)
def left_handed(f_d, heading_d):
    p1, p2, b3 = right.attitude_by_projection(f_d, heading_d).T
    return np.column_stack((-p1, p2, b3))


@mutant(
    attitude_by_projection,
    hint="p_2d must be divided by its length: a cross product is shorter than one when the vectors are not square.",
)
def second_axis_not_normalised(f_d, heading_d):
    b3, h = axes(f_d, heading_d)
    p2 = np.cross(b3, h)
    return np.column_stack((np.cross(p2, b3), p2, b3))


@mutant(
    attitude_by_projection,
    hint="The x axis must be projected: the heading vector itself is not square to the thrust axis.",
)
def heading_vector_kept(f_d, heading_d):
    b3, h = axes(f_d, heading_d)
    return np.column_stack((h, unit(np.cross(b3, h)), b3))


@mutant(attitude_by_projection, hint="The heading is in radians, not in degrees.")
def projected_at_degrees(f_d, heading_d):
    return right.attitude_by_projection(f_d, np.radians(heading_d))


@mutant(attitude_by_projection, hint="The heading vector (17) is (cos, sin, 0), not (sin, cos, 0).")
def projected_at_sine(f_d, heading_d):
    return right.attitude_by_projection(f_d, np.pi / 2 - heading_d)


@mutant(
    attitude_by_projection, hint="The force must be divided by its length before it is the z axis."
)
def force_not_normalised(f_d, heading_d):
    p1, p2, _ = right.attitude_by_projection(f_d, heading_d).T
    return np.column_stack((p1, p2, f_d))


@mutant(attitude_by_projection, hint="The force is ignored: this is a level attitude.")
def level_attitude(f_d, heading_d):
    return about_z(heading_d)


# attitude_with_heading --------------------------------------------------------------------------------


@sample(attitude_with_heading)
def leaning_or_hanging_forces(rng: np.random.Generator) -> list[Arguments]:
    return [*leaning_forces.draw(rng), (draw.force(rng, 1.9, 2.8), draw.angle(rng))]


@mutant(
    attitude_with_heading,
    hint="This is Lee's projection of Sec. 5.1.1: it loses the heading when the aircraft leans.",
)
def lee_instead(f_d, heading_d):
    return right.attitude_by_projection(f_d, heading_d)


@mutant(
    attitude_with_heading,
    hint="The thrust axis has moved: turning Lee's attitude about the vertical mends the heading and breaks the force.",
)
def lee_turned_back(f_d, heading_d):
    return right.with_heading(right.attitude_by_projection(f_d, heading_d), heading_d)


@mutant(
    attitude_with_heading,
    hint="The smallest lean and a turn about it does not keep the heading: build the x axis from the heading vector.",
)
def smallest_lean(f_d, heading_d):
    b3, _ = axes(f_d, heading_d)
    axis = np.cross((0.0, 0.0, 1.0), b3)
    lean = np.arctan2(np.linalg.norm(axis), b3[2])
    return exp(lean * unit(axis)) @ about_z(heading_d)


@mutant(
    attitude_with_heading,
    hint="The matrix is transposed: the three vectors of (21) are its columns.",
)
def axes_as_rows(f_d, heading_d):
    return right.attitude_with_heading(f_d, heading_d).T


@mutant(
    attitude_with_heading,
    hint="The result is left-handed: in (23) b_2d is b_3d × b_1d, in this order.",
)
def mirrored(f_d, heading_d):
    b1, b2, b3 = right.attitude_with_heading(f_d, heading_d).T
    return np.column_stack((b1, -b2, b3))


@mutant(
    attitude_with_heading,
    hint="(22) is printed without its last factor: the projector must be applied to the heading vector.",
)
def printed_without_heading(f_d, heading_d):
    return right.attitude_with_heading(f_d, 0.0)


@mutant(
    attitude_with_heading,
    hint="The x axis is not square to the thrust axis: its height has the wrong sign.",
)
def height_sign(f_d, heading_d):
    b3, h = axes(f_d, heading_d)
    b1 = unit(h + np.array((0.0, 0.0, h @ b3 / b3[2])))
    return np.column_stack((b1, np.cross(b3, b1), b3))


@mutant(
    attitude_with_heading,
    hint="b_1d must be divided by its length: the projection along e_3 makes it longer.",
)
def first_axis_not_normalised(f_d, heading_d):
    b3, h = axes(f_d, heading_d)
    b1 = h - np.array((0.0, 0.0, h @ b3 / b3[2]))
    return np.column_stack((b1, np.cross(b3, b1), b3))


@mutant(
    attitude_with_heading,
    hint="With a force that points down the heading is turned by 180 degrees: the x axis needs the other sign there.",
)
def backwards_upside_down(f_d, heading_d):
    b3, _ = axes(f_d, heading_d)
    b1 = unit(np.cross((-np.sin(heading_d), np.cos(heading_d), 0.0), b3))
    return np.column_stack((b1, np.cross(b3, b1), b3))


@mutant(attitude_with_heading, hint="The heading is in radians, not in degrees.")
def oblique_at_degrees(f_d, heading_d):
    return right.attitude_with_heading(f_d, np.radians(heading_d))


@mutant(attitude_with_heading, hint="The heading vector (17) is (cos, sin, 0), not (sin, cos, 0).")
def oblique_at_sine(f_d, heading_d):
    return right.attitude_with_heading(f_d, np.pi / 2 - heading_d)
