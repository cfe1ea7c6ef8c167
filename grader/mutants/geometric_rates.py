"""Known wrong answers of lab 07, continued: what the jerk asks for, and the rates."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.geometric import jerk_feedforward, rate_command
from uavlab.exercises.geometric_checks import some_mass
from uavlab.solutions import geometric as right
from uavlab.types import GRAVITY

CANARY = "canary-40f8a2d75be9461c8f3e17a9"

E3 = np.array((0.0, 0.0, 1.0))

# jerk_feedforward -------------------------------------------------------------------------------------


@sample(jerk_feedforward)
def forces_and_jerks(rng: np.random.Generator) -> list[Arguments]:
    drawn = [draw.rotation(rng) for _ in range(4)]
    return [
        (float(rng.uniform(5.0, 60.0)) * R[:, 2], some_mass(rng), R, draw.vector(rng, 2.0))
        for R in drawn
    ]


@mutant(
    jerk_feedforward,
    hint="This is (26) as printed, in m²/s⁵: the factor stands on its head, and the transpose turns the sign.",
)
def jerk_as_printed(f_d, m_e, R_d, jerk_d):
    return np.linalg.norm(f_d) / m_e * np.cross(R_d.T @ jerk_d, E3)


@mutant(
    jerk_feedforward,
    hint="The factor stands on its head: more thrust needs less turning for the same jerk. Look at the units.",
)
def factor_inverted(f_d, m_e, R_d, jerk_d):
    return np.linalg.norm(f_d) / m_e * np.cross(E3, R_d.T @ jerk_d)


@mutant(
    jerk_feedforward,
    hint="The rates have the wrong sign: a matrix of a cross product changes its sign when it is transposed.",
)
def turned_away(f_d, m_e, R_d, jerk_d):
    return m_e / np.linalg.norm(f_d) * np.cross(R_d.T @ jerk_d, E3)


@mutant(
    jerk_feedforward,
    hint="The jerk is used as it is told in the world: the rates belong to the wanted axes.",
)
def jerk_in_the_world(f_d, m_e, R_d, jerk_d):
    return m_e / np.linalg.norm(f_d) * np.cross(E3, jerk_d)


@mutant(
    jerk_feedforward,
    hint="The jerk is turned the wrong way round: from the world to the wanted axes it is R_dᵀ.",
)
def jerk_turned_out(f_d, m_e, R_d, jerk_d):
    return m_e / np.linalg.norm(f_d) * np.cross(E3, R_d @ jerk_d)


@mutant(
    jerk_feedforward,
    hint="The mass is missing: the thrust of (26) is one per mass, an acceleration.",
)
def massless(f_d, m_e, R_d, jerk_d):
    return np.cross(E3, R_d.T @ jerk_d) / np.linalg.norm(f_d)


@mutant(
    jerk_feedforward,
    hint="The thrust per mass is taken for g: on a fast curve it is much more.",
)
def as_in_hover(f_d, m_e, R_d, jerk_d):
    return np.cross(E3, R_d.T @ jerk_d) / GRAVITY


@mutant(
    jerk_feedforward,
    hint="The rates are not crossed with the axis: a jerk along body x needs a turn about body y.",
)
def not_crossed(f_d, m_e, R_d, jerk_d):
    return m_e / np.linalg.norm(f_d) * (R_d.T @ jerk_d) * (1.0, 1.0, 0.0)


@mutant(
    jerk_feedforward,
    hint="The rates are told in the world: turn them into the wanted axes, or cross there.",
)
def rates_in_the_world(f_d, m_e, R_d, jerk_d):
    return m_e / np.linalg.norm(f_d) * np.cross(R_d[:, 2], jerk_d)


# rate_command -----------------------------------------------------------------------------------------


@sample(rate_command)
def attitudes_and_rates(rng: np.random.Generator) -> list[Arguments]:
    drawn = [draw.aimed(rng, 0.3, 0.7) for _ in range(4)]
    return [
        (R @ so3.exp(0.4 * draw.direction(rng)), R, draw.pace(rng), draw.vector(rng) * (1.0, 1.0, 0.0),
         rng.uniform(3.0, 8.0, size=3)) for R in drawn
    ]  # fmt: skip


def yaw(R, rate):
    return rate * (1.0 - R[2, 0] ** 2) / R[2, 2]


def rates(R, R_d, feedback, ahead, undone):
    """(25): feedback and jerk, with one yaw rate for the heading, and one against the parasites."""
    omega = feedback.copy()
    omega[2] += ahead - undone * omega[1] * R[2, 1] / R[2, 2]
    return omega


def fed_back(R, R_d, omega_j, k_R):
    return omega_j - k_R * right.attitude_error(R, R_d)


@mutant(
    rate_command,
    hint="The feedback turns away from the wanted attitude: e_R leads from wanted to flown, so minus.",
)
def turned_further_off(R, R_d, heading_rate_d, omega_j, k_R):
    w = omega_j + k_R * right.attitude_error(R, R_d)
    return rates(R, R_d, w, yaw(R_d, heading_rate_d), 1.0)


@mutant(
    rate_command, hint="The wanted heading rate is not used: (25) forgets it, Sec. 5.2 says how."
)
def heading_rate_forgotten(R, R_d, heading_rate_d, omega_j, k_R):
    return rates(R, R_d, fed_back(R, R_d, omega_j, k_R), 0.0, 1.0)


@mutant(
    rate_command,
    hint="The wanted heading rate is taken for a yaw rate: on a tilted aircraft it is another one (Sec. 5.2).",
)
def heading_rate_as_yaw(R, R_d, heading_rate_d, omega_j, k_R):
    return rates(R, R_d, fed_back(R, R_d, omega_j, k_R), heading_rate_d, 1.0)


@mutant(
    rate_command,
    hint="The wanted heading rate is turned into a yaw rate with the flown attitude: it belongs to the wanted one.",
)
def ahead_at_the_flown(R, R_d, heading_rate_d, omega_j, k_R):
    return rates(R, R_d, fed_back(R, R_d, omega_j, k_R), yaw(R, heading_rate_d), 1.0)


@mutant(
    rate_command,
    hint="The parasites stay: what roll and pitch rates make of the heading is to be undone (Sec. 5.3).",
)
def parasites_stay(R, R_d, heading_rate_d, omega_j, k_R):
    return rates(R, R_d, fed_back(R, R_d, omega_j, k_R), yaw(R_d, heading_rate_d), 0.0)


@mutant(
    rate_command,
    hint="The parasites are doubled, not undone: mind which sign your function of lab 02 has.",
)
def parasites_doubled(R, R_d, heading_rate_d, omega_j, k_R):
    return rates(R, R_d, fed_back(R, R_d, omega_j, k_R), yaw(R_d, heading_rate_d), -1.0)


@mutant(
    rate_command,
    hint="The parasites are computed at the wanted attitude: it is the flown body that turns.",
)
def parasites_at_the_wanted(R, R_d, heading_rate_d, omega_j, k_R):
    return rates(R_d, R_d, fed_back(R, R_d, omega_j, k_R), yaw(R_d, heading_rate_d), 1.0)


@mutant(
    rate_command,
    hint="Only the feedback's parasites are undone: the jerk's roll and pitch rates swing the nose, too.",
)
def parasites_of_the_feedback(R, R_d, heading_rate_d, omega_j, k_R):
    w = rates(R, R_d, fed_back(R, R_d, 0.0 * omega_j, k_R), yaw(R_d, heading_rate_d), 1.0)
    return w + omega_j


@mutant(
    rate_command,
    hint="All of the heading rate is undone, the wanted one too: only roll and pitch make parasites.",
)
def everything_undone(R, R_d, heading_rate_d, omega_j, k_R):
    w = fed_back(R, R_d, omega_j, k_R)
    w[2] = -w[1] * R[2, 1] / R[2, 2]
    return w


@mutant(rate_command, hint="The jerk's rates are not used, or not yet: (25) adds ω_j.")
def jerk_forgotten(R, R_d, heading_rate_d, omega_j, k_R):
    return rates(R, R_d, fed_back(R, R_d, 0.0 * omega_j, k_R), yaw(R_d, heading_rate_d), 1.0)


@mutant(rate_command, hint="The jerk's rates are subtracted: in (25) they have a plus.")
def jerk_subtracted(R, R_d, heading_rate_d, omega_j, k_R):
    return rates(R, R_d, fed_back(R, R_d, -omega_j, k_R), yaw(R_d, heading_rate_d), 1.0)


@mutant(
    rate_command,
    hint="The gains are used as one: k_R has three numbers, one for each body axis.",
)
def one_gain_for_all(R, R_d, heading_rate_d, omega_j, k_R):
    return rates(R, R_d, fed_back(R, R_d, omega_j, float(k_R[0])), yaw(R_d, heading_rate_d), 1.0)
