"""Lab 02, known wrong answers: each with the hint that an answer like it earns; and inputs that tell them apart."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from grader.mutants.heading_attitudes import *  # noqa: F403  the attitudes of the lab
from uavlab.exercises import draw
from uavlab.exercises.heading import (
    heading_rate,
    parasitic_yaw_rate,
    with_heading,
    yaw_rate_from_heading_rate,
)
from uavlab.frames import heading
from uavlab.so3 import about_z, hat
from uavlab.solutions.heading import attitude_with_heading as oblique

CANARY = "canary-9cbec847fde4485f00484bd5"

# heading_rate -----------------------------------------------------------------------------------------


@sample(heading_rate)
def tumbling(rng: np.random.Generator) -> list[Arguments]:
    lows = (0.2, 0.5, 0.8, 1.0, 2.0)
    return [(draw.aimed(rng, low, low + 0.4), draw.vector(rng, 2.0)) for low in lows]


def slope(R, R_dot):
    """(15), for whatever is taken for the rotation and its derivative."""
    x, y = R[0, 0], R[1, 0]
    return (x * R_dot[1, 0] - y * R_dot[0, 0]) / (x * x + y * y)


@mutant(heading_rate, hint="The yaw rate is the heading rate only while the aircraft is level.")
def yaw_rate_taken(R, omega):
    return omega[2]


@mutant(
    heading_rate,
    hint="The heading rate has the wrong sign when the aircraft is tilted: the part of the pitch rate is subtracted.",
)
def pitch_part_subtracted(R, omega):
    return (omega[2] * R[2, 2] - omega[1] * R[2, 1]) / (1.0 - R[2, 0] ** 2)


@mutant(
    heading_rate,
    hint="The heading rate has the wrong sign everywhere: in (15) the first term has the minus.",
)
def wrong_sign(R, omega):
    return -slope(R, R @ hat(omega))


@mutant(
    heading_rate,
    hint="The pitch rate is not used: while the aircraft leans to a side it turns the heading too.",
)
def pitch_ignored(R, omega):
    return omega[2] * R[2, 2] / (1.0 - R[2, 0] ** 2)


@mutant(
    heading_rate,
    hint="omega is told in the body, but it was used as if in the world: (2) is Ṙ = R Ω, not Ω R.",
)
def omega_in_the_world(R, omega):
    return slope(R, hat(omega) @ R)


@mutant(
    heading_rate,
    hint="This is the vertical part of the angular velocity: not the heading rate when the nose points up or down.",
)
def vertical_part(R, omega):
    return R[2] @ omega


@mutant(
    heading_rate,
    hint="The denominators of (15) are missing: x² + y² is 1 only while the nose is level.",
)
def no_denominator(R, omega):
    return slope(R, R @ hat(omega)) * (1.0 - R[2, 0] ** 2)


@mutant(
    heading_rate, hint="The denominators of (15) are squares: no square root is taken of x² + y²."
)
def root_in_the_denominator(R, omega):
    return slope(R, R @ hat(omega)) * np.sqrt(1.0 - R[2, 0] ** 2)


@mutant(
    heading_rate,
    hint="R is transposed: R(2,1) is the second row and the first column, the y part of the body x axis.",
)
def transposed(R, omega):
    return slope(R.T, R.T @ hat(omega))


@mutant(heading_rate, hint="The heading rate is in radians per second, not in degrees.")
def in_degrees(R, omega):
    return np.degrees(slope(R, R @ hat(omega)))


# with_heading -----------------------------------------------------------------------------------------


@sample(with_heading)
def orientations(rng: np.random.Generator) -> list[Arguments]:
    drawn = [draw.aimed(rng, low, low + 0.4) for low in (0.2, 0.5, 0.8, 1.0, 2.0)]
    front, back = about_z(-heading(drawn[0]) + 0.4), about_z(-heading(drawn[1]) + 2.5)
    return [(R, draw.angle(rng)) for R in (front @ drawn[0], back @ drawn[1], *drawn[2:])]


@mutant(
    with_heading,
    hint="The turn stands on the wrong side: (14) turns about the world z axis, not about the body's.",
)
def about_the_body_axis(R_o, eta):
    return R_o @ about_z(eta - heading(R_o))


@mutant(
    with_heading,
    hint="It turns the wrong way: the difference (13) is wanted minus original, and sin stands below −sin.",
)
def turned_the_wrong_way(R_o, eta):
    return about_z(heading(R_o) - eta) @ R_o


@mutant(
    with_heading,
    hint="It turns by the heading wanted, not by the difference to the heading that was: see (13).",
)
def difference_forgotten(R_o, eta):
    return about_z(eta) @ R_o


@mutant(
    with_heading,
    hint="The tilt is lost: turn the original orientation, do not start from a level one.",
)
def level_instead(R_o, eta):
    return about_z(eta)


@mutant(
    with_heading,
    hint="The original heading needs atan2: with arctan(y/x) half of all headings are turned by 180 degrees.",
)
def arctan_for_atan2(R_o, eta):
    return about_z(eta - np.arctan(R_o[1, 0] / R_o[0, 0])) @ R_o


@mutant(
    with_heading,
    hint="The thrust axis must turn along: this keeps it where it was and builds a new x axis.",
)
def thrust_axis_kept(R_o, eta):
    return oblique(R_o[:, 2], eta)


@mutant(with_heading, hint="The heading is in radians, not in degrees.")
def heading_as_degrees(R_o, eta):
    return about_z(np.radians(eta) - heading(R_o)) @ R_o


@mutant(
    with_heading,
    hint="The original heading was read from the first row of R: the body x axis is its first column.",
)
def row_for_column(R_o, eta):
    return about_z(eta - heading(R_o.T)) @ R_o


# yaw_rate_from_heading_rate ---------------------------------------------------------------------------


@sample(yaw_rate_from_heading_rate)
def wanted_rates(rng: np.random.Generator) -> list[Arguments]:
    signs = (1.0, -1.0, 1.0, 1.0, -1.0)
    return [
        (R, s * abs(draw.pace(rng))) for (R, _), s in zip(tumbling.draw(rng), signs, strict=True)
    ]


def converted(R, eta_dot):
    return eta_dot * (1.0 - R[2, 0] ** 2) / R[2, 2]


@mutant(
    yaw_rate_from_heading_rate,
    hint="The heading rate is the yaw rate only while the aircraft is level.",
)
def heading_rate_taken(R, eta_dot):
    return eta_dot


@mutant(
    yaw_rate_from_heading_rate,
    hint="The conversion is upside down: this makes a heading rate of a yaw rate.",
)
def ratio_inverted(R, eta_dot):
    return eta_dot * R[2, 2] / (1.0 - R[2, 0] ** 2)


@mutant(
    yaw_rate_from_heading_rate,
    hint="(27) takes h, the shadow of b_1 as short as it is; only (28) normalises it.",
)
def unit_shadow(R, eta_dot):
    return eta_dot * np.sqrt(1.0 - R[2, 0] ** 2) / R[2, 2]


@mutant(
    yaw_rate_from_heading_rate, hint="The sign of (30) is missing: norms alone give no direction."
)
def sign_missing(R, eta_dot):
    return abs(converted(R, eta_dot))


@mutant(
    yaw_rate_from_heading_rate,
    hint="Upside down a yaw turns the heading the other way: the sign in (30) is that of ḣᵀp, not that of the rate.",
)
def sign_of_the_rate(R, eta_dot):
    return np.sign(eta_dot) * abs(converted(R, eta_dot))


@mutant(yaw_rate_from_heading_rate, hint="The yaw rate has the wrong sign.")
def yaw_negated(R, eta_dot):
    return -converted(R, eta_dot)


@mutant(
    yaw_rate_from_heading_rate,
    hint="The shadow of b_1 is shorter than one when the nose points up or down: ḣ is shorter too.",
)
def full_length_nose(R, eta_dot):
    return eta_dot / R[2, 2]


@mutant(
    yaw_rate_from_heading_rate,
    hint="The body z axis is taken as if it gave a part of the yaw rate: divide by R33, do not multiply.",
)
def vertical_part_of_the_rate(R, eta_dot):
    return eta_dot * R[2, 2]


@mutant(yaw_rate_from_heading_rate, hint="Rates are in radians per second, not in degrees.")
def yaw_in_degrees(R, eta_dot):
    return np.degrees(converted(R, eta_dot))


# parasitic_yaw_rate -----------------------------------------------------------------------------------


@sample(parasitic_yaw_rate)
def parasites(rng: np.random.Generator) -> list[Arguments]:
    return tumbling.draw(rng)


@mutant(
    parasitic_yaw_rate,
    hint="The sign is that of (25), where it is subtracted: here the yaw rate that undoes is asked for.",
)
def sign_of_the_paper(R, omega):
    return omega[1] * R[2, 1] / R[2, 2]


@mutant(parasitic_yaw_rate, hint="This is a heading rate: convert it to a yaw rate as in Sec. 5.2.")
def not_converted(R, omega):
    return -omega[1] * R[2, 1] / (1.0 - R[2, 0] ** 2)


@mutant(
    parasitic_yaw_rate,
    hint="The yaw rate is counted as a parasite: set it to zero before you compute the heading rate.",
)
def yaw_counted_too(R, omega):
    return -omega[1] * R[2, 1] / R[2, 2] - omega[2]


@mutant(
    parasitic_yaw_rate,
    hint="This stops the vertical part of the angular velocity, not the heading: the roll rate must not matter.",
)
def vertical_part_stopped(R, omega):
    return -(omega[0] * R[2, 0] + omega[1] * R[2, 1]) / R[2, 2]


@mutant(
    parasitic_yaw_rate,
    hint="Nothing is undone: when the aircraft leans, the pitch rate does turn the heading.",
)
def nothing_undone(R, omega):
    return 0.0


@mutant(
    parasitic_yaw_rate,
    hint="R is transposed: the third row is asked for, the heights of the body axes.",
)
def column_for_row(R, omega):
    return -omega[1] * R[1, 2] / R[2, 2]


@mutant(
    parasitic_yaw_rate,
    hint="The roll rate is used in place of the pitch rate: a turn about b_1 cannot move b_1.",
)
def roll_for_pitch(R, omega):
    return -omega[0] * R[2, 1] / R[2, 2]
