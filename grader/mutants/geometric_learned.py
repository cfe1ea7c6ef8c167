"""Known wrong answers of lab 07, continued: what is learnt, and what the estimator is told."""

from __future__ import annotations

import numpy as np

from grader.material import Arguments, mutant, sample
from uavlab.exercises import draw
from uavlab.exercises.geometric import (
    disturbance_step,
    estimated_mass,
    unbiased_acceleration,
)
from uavlab.exercises.geometric_checks import some_gains, some_mass
from uavlab.frames import heading as nose
from uavlab.so3 import about_z
from uavlab.types import GRAVITY

CANARY = "canary-7d0e95b3c1284f6fa96e3815"

E3 = np.array((0.0, 0.0, 1.0))
LEVEL = np.array((1.0, 1.0, 0.0))

# disturbance_step -------------------------------------------------------------------------------------


@sample(disturbance_step)
def pushes(rng: np.random.Generator) -> list[Arguments]:
    made = []
    for size in (1.0, 1.0, 1.0, 60.0, 60.0):
        d_w, d_b = (rng.uniform(-2.0, 2.0, size=3) * LEVEL for _ in range(2))
        e_p = size * rng.choice((-1.0, 1.0), size=3) * rng.uniform(0.5, 1.5, size=3)
        made.append((d_w, d_b, e_p, draw.angle(rng), float(rng.uniform(0.2, 0.4)), some_gains(rng)))
    return made


def learnt(d_w, d_b, w, b, k, *, box=True, world=True):
    """Both sums with these steps added, and kept within the limit, or not."""
    d_w, d_b = d_w + k.k_iw * w, d_b + k.k_ib * b
    low, high = -k.d_max, k.d_max
    return (d_w.clip(low, high) if box and world else d_w), (d_b.clip(low, high) if box else d_b)


@mutant(disturbance_step, hint="The sums grow without end: no entry may pass d_max.")
def without_limit(d_w, d_b, e_p, heading, dt, gains):
    e = dt * e_p * LEVEL
    return learnt(d_w, d_b, e, about_z(-heading) @ e, gains, box=False)


@mutant(disturbance_step, hint="Only one of the sums is limited: d_max holds for both.")
def one_limit(d_w, d_b, e_p, heading, dt, gains):
    e = dt * e_p * LEVEL
    return learnt(d_w, d_b, e, about_z(-heading) @ e, gains, world=False)


@mutant(
    disturbance_step,
    hint="The length of the sums is limited: each entry has the limit for itself.",
)
def limited_length(d_w, d_b, e_p, heading, dt, gains):
    e = dt * e_p * LEVEL
    w, b = learnt(d_w, d_b, e, about_z(-heading) @ e, gains, box=False)
    return tuple(x * min(1.0, gains.d_max / np.linalg.norm(x)) for x in (w, b))


@mutant(
    disturbance_step,
    hint="The height is summed up, too: it belongs to the mass, and the third entries stay zero.",
)
def height_summed_too(d_w, d_b, e_p, heading, dt, gains):
    e = dt * e_p
    return learnt(d_w, d_b, e, about_z(-heading) @ e, gains)


@mutant(
    disturbance_step,
    hint="Both sums are told in the world: for d_b the error must be seen from the nose, Hᵀ e_p.",
)
def both_in_the_world(d_w, d_b, e_p, heading, dt, gains):
    e = dt * e_p * LEVEL
    return learnt(d_w, d_b, e, e, gains)


@mutant(
    disturbance_step,
    hint="The error is turned the wrong way round: from the world to the frame of the heading it is Hᵀ.",
)
def turned_out(d_w, d_b, e_p, heading, dt, gains):
    e = dt * e_p * LEVEL
    return learnt(d_w, d_b, e, about_z(heading) @ e, gains)


@mutant(
    disturbance_step,
    hint="This is (35) as printed: its H in front turns the second sum into the world, again in every step.",
)
def turned_at_every_step(d_w, d_b, e_p, heading, dt, gains):
    e = dt * e_p * LEVEL
    w, b = learnt(d_w, d_b, e, about_z(-heading) @ e, gains)
    return w, about_z(heading) @ b


@mutant(
    disturbance_step,
    hint="The error of the world's sum is turned, that of the nose's is not: you have exchanged them.",
)
def exchanged(d_w, d_b, e_p, heading, dt, gains):
    e = dt * e_p * LEVEL
    return learnt(d_w, d_b, about_z(-heading) @ e, e, gains)


@mutant(disturbance_step, hint="The step does not depend on its length: multiply by dt.")
def step_without_dt(d_w, d_b, e_p, heading, dt, gains):
    e = e_p * LEVEL
    return learnt(d_w, d_b, e, about_z(-heading) @ e, gains)


@mutant(
    disturbance_step,
    hint="The sums learn the wrong way: pushed to the east the aircraft is too far east, and (38) takes them off.",
)
def learnt_backwards(d_w, d_b, e_p, heading, dt, gains):
    e = -dt * e_p * LEVEL
    return learnt(d_w, d_b, e, about_z(-heading) @ e, gains)


@mutant(
    disturbance_step, hint="The gains are exchanged: k_iw is the world's, k_ib that of the nose."
)
def gains_exchanged(d_w, d_b, e_p, heading, dt, gains):
    e = dt * e_p * LEVEL
    swapped = gains._replace(k_iw=gains.k_ib, k_ib=gains.k_iw)
    return learnt(d_w, d_b, e, about_z(-heading) @ e, swapped)


# estimated_mass ---------------------------------------------------------------------------------------


@sample(estimated_mass)
def heights(rng: np.random.Generator) -> list[Arguments]:
    made = []
    for e_z, m_max in (
        (-0.7, 1.5),
        (0.6, 1.5),
        (-40.0, 1.5),
        (40.0, 1.5),
        (-90.0, 20.0),
        (90.0, 20.0),
    ):
        m, k = some_mass(rng) + 1.0, some_gains(rng)._replace(m_max=m_max)
        m_e, dt = m + float(rng.uniform(0.2, 0.4)), float(rng.uniform(0.3, 0.5))
        made.append((m_e, e_z * float(rng.uniform(1.0, 1.5)), dt, m, k))
    return made


def kept(m_e, m, k, *, least=0.1):
    return min(max(m_e, m - k.m_max, least * m), m + k.m_max)


@mutant(
    estimated_mass,
    hint="This is (37) as printed: a heavy aircraft hangs low, its error is negative, and it must gain mass.",
)
def mass_as_printed(m_e, e_z, dt, m, gains):
    return kept(m_e + gains.k_m * e_z * dt, m, gains)


@mutant(estimated_mass, hint="The step does not depend on its length: multiply by dt.")
def mass_without_dt(m_e, e_z, dt, m, gains):
    return kept(m_e - gains.k_m * e_z, m, gains)


@mutant(
    estimated_mass,
    hint="It starts from the nominal mass in every step: add to what is known so far.",
)
def begun_anew(m_e, e_z, dt, m, gains):
    return kept(m - gains.k_m * e_z * dt, m, gains)


@mutant(
    estimated_mass,
    hint="The mass grows and falls without end: stay within m_max of the nominal one.",
)
def mass_without_limit(m_e, e_z, dt, m, gains):
    return max(m_e - gains.k_m * e_z * dt, 0.1 * m)


@mutant(
    estimated_mass,
    hint="The limit is taken from zero, or from the mass so far: it is a difference from the nominal mass.",
)
def limit_of_the_step(m_e, e_z, dt, m, gains):
    return max(m_e + float(np.clip(-gains.k_m * e_z * dt, -gains.m_max, gains.m_max)), 0.1 * m)


@mutant(
    estimated_mass,
    hint="The limit holds upwards only: an aircraft that drops its payload can be misled, too.",
)
def limit_upwards(m_e, e_z, dt, m, gains):
    return max(min(m_e - gains.k_m * e_z * dt, m + gains.m_max), 0.1 * m)


@mutant(
    estimated_mass,
    hint="The mass can become zero or less: keep a tenth of the nominal one, whatever m_max says.",
)
def lighter_than_air(m_e, e_z, dt, m, gains):
    return kept(m_e - gains.k_m * e_z * dt, m, gains, least=-100.0)


@mutant(
    estimated_mass,
    hint="The gain of the horizontal disturbances is used: the mass has its own, k_m, in kg/(m s).",
)
def gain_of_the_wind(m_e, e_z, dt, m, gains):
    return kept(m_e - gains.k_iw * e_z * dt, m, gains)


@mutant(
    estimated_mass, hint="The step is divided by g, as if it were a force: k_m gives kilograms."
)
def weight_for_mass(m_e, e_z, dt, m, gains):
    return kept(m_e - gains.k_m * e_z * dt / GRAVITY, m, gains)


# unbiased_acceleration --------------------------------------------------------------------------------


@sample(unbiased_acceleration)
def thrusts(rng: np.random.Generator) -> list[Arguments]:
    return [
        (float(rng.uniform(5.0, 60.0)), draw.aimed(rng, 0.3, 0.9), draw.vector(rng, 3.0), draw.vector(rng, 3.0),
         some_mass(rng)) for _ in range(4)
    ]  # fmt: skip


def told(f, d, m, *, g=1.0, flat=True):
    return (f + d * (LEVEL if flat else 1.0)) / m - g * GRAVITY * E3


def together(R, d_w, d_b):
    return d_w + about_z(nose(R)) @ d_b


@mutant(
    unbiased_acceleration,
    hint="This is (53) as printed: gravity is among the forces without a mass, right for one kilogram only.",
)
def a_d_as_printed(f_d, R, d_w, d_b, m_e):
    return told(f_d * R[:, 2], together(R, d_w, d_b), m_e, g=1.0 / m_e)


@mutant(
    unbiased_acceleration,
    hint="The disturbances are taken off: they push the aircraft, and (53) puts them back.",
)
def pushes_taken_off(f_d, R, d_w, d_b, m_e):
    return told(f_d * R[:, 2], -together(R, d_w, d_b), m_e)


@mutant(
    unbiased_acceleration,
    hint="The disturbances are added as they are: they are forces, divide them by the mass.",
)
def pushes_as_accelerations(f_d, R, d_w, d_b, m_e):
    return told(f_d * R[:, 2], m_e * together(R, d_w, d_b), m_e)


@mutant(
    unbiased_acceleration,
    hint="d_b is used as if it were told in the world: turn it by the heading first.",
)
def nose_not_turned(f_d, R, d_w, d_b, m_e):
    return told(f_d * R[:, 2], d_w + d_b, m_e)


@mutant(
    unbiased_acceleration,
    hint="d_b is turned with the whole attitude: its frame is that of the heading, and stays level.",
)
def pushes_tilted(f_d, R, d_w, d_b, m_e):
    return told(f_d * R[:, 2], d_w + R @ d_b, m_e)


@mutant(
    unbiased_acceleration,
    hint="The vertical parts of the disturbances are used: (53) multiplies them by zero.",
)
def pushed_up(f_d, R, d_w, d_b, m_e):
    return told(f_d * R[:, 2], together(R, d_w, d_b), m_e, flat=False)


@mutant(
    unbiased_acceleration,
    hint="The thrust is turned with the third row of R: the body z axis is its third column.",
)
def row_for_column(f_d, R, d_w, d_b, m_e):
    return told(f_d * R[2], together(R, d_w, d_b), m_e)


@mutant(
    unbiased_acceleration,
    hint="The thrust is taken to point up: it points along the body z axis, wherever that leans.",
)
def thrust_upwards(f_d, R, d_w, d_b, m_e):
    return told(f_d * E3, together(R, d_w, d_b), m_e)


@mutant(
    unbiased_acceleration,
    hint="Gravity is missing: this is what an accelerometer sees, not how the aircraft accelerates.",
)
def specific_force(f_d, R, d_w, d_b, m_e):
    return told(f_d * R[:, 2], together(R, d_w, d_b), m_e, g=0.0)


@mutant(
    unbiased_acceleration, hint="The disturbances are forgotten: a wind would look like a motion."
)
def pushes_forgotten(f_d, R, d_w, d_b, m_e):
    return told(f_d * R[:, 2], np.zeros(3), m_e)
