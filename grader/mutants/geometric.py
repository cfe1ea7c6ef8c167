"""Lab 07, known wrong answers: each with the hint that an answer like it earns; and inputs that tell them apart."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from grader.mutants.geometric_class import *  # noqa: F403  the controller
from grader.mutants.geometric_learned import *  # noqa: F403  disturbances, mass, a_d
from grader.mutants.geometric_rates import *  # noqa: F403  rates
from grader.mutants.geometric_torque import *  # noqa: F403  torque and limits
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.geometric import (
    attitude_error,
    desired_force,
)
from uavlab.exercises.geometric_checks import some_estimate, some_gains, some_mass
from uavlab.frames import heading
from uavlab.so3 import about_z, vee
from uavlab.solutions import geometric as right
from uavlab.types import GRAVITY

CANARY = "canary-c8f1720b6de94a35958e0b7d"

E3 = np.array((0.0, 0.0, 1.0))

# attitude_error ---------------------------------------------------------------------------------------


@sample(attitude_error)
def two_attitudes(rng: np.random.Generator) -> list[Arguments]:
    drawn = [draw.rotation(rng) for _ in range(4)]
    return [(R @ so3.exp(0.4 * (k + 1) * draw.direction(rng)), R) for k, R in enumerate(drawn)]


@mutant(
    attitude_error,
    hint="The sign is Spica's, wanted less flown: (24) starts with R_dᵀ R, and so does this lab.",
)
def wanted_less_flown(R, R_d):
    return -right.attitude_error(R, R_d)


@mutant(attitude_error, hint="The half in (24) is missing: a small turn must give its own vector.")
def not_halved(R, R_d):
    return 2.0 * right.attitude_error(R, R_d)


@mutant(
    attitude_error,
    hint="The transposes stand on the wrong side: R R_dᵀ compares in the world, and e_R is told in the body.",
)
def told_in_the_world(R, R_d):
    return vee(R @ R_d.T - R_d @ R.T) / 2.0


@mutant(
    attitude_error,
    hint="This is the whole rotation vector. (24) is its sine: the controller was proved with that one.",
)
def rotation_vector(R, R_d):
    return so3.log(R_d.T @ R)


@mutant(
    attitude_error,
    hint="This is the vector part of the quaternion, twice: it is largest upside down, (24) at a right angle.",
)
def quaternion_error(R, R_d):
    return 2.0 * so3.quaternion_from_rotation(R_d.T @ R)[1:]


@mutant(
    attitude_error,
    hint="The entries are in the wrong order: (3,2) is the first, then (1,3), then (2,1). `so3.vee` does it.",
)
def entries_in_reverse(R, R_d):
    return right.attitude_error(R, R_d)[::-1]


@mutant(
    attitude_error,
    hint="The middle entry has the wrong sign: it is (1,3), above the diagonal, not (3,1).",
)
def below_the_diagonal(R, R_d):
    return right.attitude_error(R, R_d) * (1.0, -1.0, 1.0)


@mutant(
    attitude_error,
    hint="The two matrices are subtracted without a product: (24) compares R_dᵀ R with its transpose.",
)
def difference_of_both(R, R_d):
    return vee(R - R_d)


# desired_force ----------------------------------------------------------------------------------------


@sample(desired_force)
def errors_and_pushes(rng: np.random.Generator) -> list[Arguments]:
    return [
        (some_estimate(rng), draw.reference(rng), some_mass(rng), draw.vector(rng, 3.0), draw.vector(rng, 3.0),
         some_gains(rng)) for _ in range(4)
    ]  # fmt: skip


def force(x, y, m, d, k, *, p=-1.0, v=-1.0, a=1.0, g=1.0, gains=None, flat=True):
    """(38), for whatever is taken for the parts of it."""
    pull = p * np.multiply(k.k_p, x.r - y.r) + v * np.multiply(k.k_v, x.v - y.v)
    pull = pull * (m if gains is None else gains)
    return pull + m * a * y.a + g * m * GRAVITY * E3 - d * ((1.0, 1.0, 0.0) if flat else 1.0)


def both(x, d_w, d_b):
    return d_w + about_z(heading(x.R)) @ d_b


@mutant(
    desired_force,
    hint="Position and velocity push away from the reference: the errors are flown less wanted, so minus.",
)
def pushed_away(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, both(estimate, d_w, d_b), gains, p=1.0, v=1.0)


@mutant(
    desired_force, hint="The velocity error has the wrong sign: it must damp, not drive the motion."
)
def undamped(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, both(estimate, d_w, d_b), gains, v=1.0)


@mutant(
    desired_force,
    hint="The gains are those of an acceleration: m_e multiplies them, too.",
)
def gains_without_mass(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, both(estimate, d_w, d_b), gains, gains=1.0)


@mutant(
    desired_force, hint="The wanted acceleration is not fed forward: every curve will be cut late."
)
def acceleration_forgotten(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, both(estimate, d_w, d_b), gains, a=0.0)


@mutant(desired_force, hint="Nothing carries the weight: m_e g is missing along the world z axis.")
def weightless(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, both(estimate, d_w, d_b), gains, g=0.0)


@mutant(desired_force, hint="Gravity stands among forces without a mass: (38) has m_e g, not g.")
def gravity_without_mass(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, both(estimate, d_w, d_b), gains, g=1.0 / m_e)


@mutant(
    desired_force,
    hint="The disturbances are added: what pushes is to be compensated, so they are taken off.",
)
def disturbances_added(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, -both(estimate, d_w, d_b), gains)


@mutant(
    desired_force,
    hint="The disturbances are multiplied by the mass, as (38) has them in m/s²: they are newtons.",
)
def disturbances_times_mass(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, m_e * both(estimate, d_w, d_b), gains)


@mutant(
    desired_force,
    hint="d_b is used as if it were told in the world: turn it by the heading first.",
)
def nose_forgotten(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, d_w + d_b, gains)


@mutant(
    desired_force,
    hint="d_b is turned the wrong way round: from the frame of the heading to the world it is H, not Hᵀ.",
)
def nose_turned_back(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, d_w + about_z(-heading(estimate.R)) @ d_b, gains)


@mutant(
    desired_force,
    hint="d_b is turned with the whole attitude: its frame is that of the heading, and stays level.",
)
def tilted_along(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, d_w + estimate.R @ d_b, gains)


@mutant(
    desired_force,
    hint="d_b is turned by the heading that is wanted: the push is where the nose points now.",
)
def wanted_nose(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, d_w + about_z(reference.heading) @ d_b, gains)


@mutant(
    desired_force,
    hint="The vertical parts of the disturbances are used: (38) multiplies them by zero.",
)
def height_disturbed(estimate, reference, m_e, d_w, d_b, gains):
    return force(estimate, reference, m_e, both(estimate, d_w, d_b), gains, flat=False)
