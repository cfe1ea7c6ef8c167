"""Known wrong answers of lab 07, continued: controllers, each the reference with one mistake in it."""

from __future__ import annotations

import inspect
from functools import partial
from typing import Any

import numpy as np

import uavlab.solutions.geometric as right
from grader.material import Play, mutant, sample
from uavlab import frames
from uavlab.exercises import draw
from uavlab.exercises.geometric import GeometricController
from uavlab.exercises.geometric_checks import ZERO, some_estimate, some_gains, some_mass
from uavlab.frames import Shift
from uavlab.solutions.heading import attitude_by_projection
from uavlab.types import Command, Reference

CANARY = "canary-a64b19c2570f4bd38ef7d031"

SOURCE = inspect.getsource(right)
DT = 0.2


def without_a_floor(f: Any, tilt_max: float) -> Any:
    """The force with its lean limited, whether it points up or down."""
    flat = float(np.hypot(f[0], f[1]))
    share = min(1.0, f[2] * np.tan(tilt_max) / flat) if flat > 0.0 else 1.0
    return np.array((share * f[0], share * f[1], f[2]))


def wrong(*pairs: str) -> Any:
    """The reference with pieces of it replaced: old, new, old, new."""
    source = SOURCE
    for old, new in zip(pairs[::2], pairs[1::2], strict=True):
        if source.count(old) != 1:
            raise ValueError(f"{old!r} stands {source.count(old)} times in the reference")
        source = source.replace(old, new)
    room: dict[str, Any] = {
        "__name__": right.__name__, "lee": attitude_by_projection, "without_a_floor": without_a_floor,
    }  # fmt: skip
    exec(compile(source, "<mutant>", "exec"), room)
    return room["GeometricController"]


def flown(make: Any, m: float, k: Any, last: Any, ticks: list[Any], shift: Shift) -> Any:
    """What a controller commands, tick by tick, before and after a change of world."""
    part, said = make(m, k), []
    memory = part.init(ticks[0][0], last)
    for n, (x, y) in enumerate(ticks):
        if n == len(ticks) // 2:
            memory = part.reframe(memory, shift)
        if n >= len(ticks) // 2:
            x, y = frames.moved(x, shift), frames.moved(y, shift)
        memory, command = part.step(memory, x, y, DT)
        said.append(command)
    return said


@sample(GeometricController)
def flights_to_know_them_by(rng: np.random.Generator) -> list[Play]:
    plays = []
    for away, taken, slow in (
        (ZERO, False, False), (ZERO, True, False), ((40.0, 30.0, 0.0), False, False),
        ((2.0, 3.0, -60.0), False, False), (ZERO, False, True),
    ):  # fmt: skip
        k, m, ticks = some_gains(rng), some_mass(rng) + 2.0, []
        k = (
            k._replace(rate_max=(0.2, 0.3, 0.2))
            if slow
            else k._replace(rate_max=(99.0, 99.0, 99.0))
        )
        for _ in range(6):
            x = some_estimate(rng)
            r, v = x.r + draw.vector(rng, 0.3) + away, x.v + draw.vector(rng, 0.2)
            eta = frames.heading(x.R) + 0.4
            ticks.append((
                x,
                Reference(r, v, draw.vector(rng), draw.vector(rng, 3.0), eta, draw.pace(rng)),
            ))
        last = Command(30.0, draw.vector(rng), draw.vector(rng)) if taken else None
        shift = Shift(draw.vector(rng), draw.angle(rng))
        plays.append(partial(flown, m=m, k=k, last=last, ticks=ticks, shift=shift))
    return plays


def known_mistake(name: str, hint: str, *pairs: str) -> Any:
    """One of them, under its name."""
    return mutant(GeometricController, hint=hint)(type(name, (wrong(*pairs),), {}))


# The command ------------------------------------------------------------------------------------------

no_tilt_limit = known_mistake(
    "no_tilt_limit",
    "The lean of the force is not limited: far from its goal the aircraft falls. Cut the horizontal part.",
    "limited_tilt(f, k.tilt_max)", "limited_tilt(f, 1.5707)",
)  # fmt: skip
turned_over = known_mistake(
    "turned_over",
    "A force that points down turns the aircraft over: take one newton of vertical force at least.",
    "limited_tilt(f, k.tilt_max)", "without_a_floor(f, k.tilt_max)",
)  # fmt: skip
rates_without_limit = known_mistake(
    "rates_without_limit",
    "The rates are not cut at rate_max, each body axis by itself.",
    "np.clip(omega_d, np.negative(k.rate_max), k.rate_max)", "omega_d",
)  # fmt: skip
norm_for_projection = known_mistake(
    "norm_for_projection",
    "The thrust is the length of the force: while the aircraft still turns only its part along the thrust axis helps.",
    "float(f @ R[:, 2])", "float(np.linalg.norm(f))",
)  # fmt: skip
jerk_left_out = known_mistake(
    "jerk_left_out",
    "The jerk is not fed forward: on a curve the thrust will lag behind the force.",
    "R_d, reference.j)", "R_d, 0.0 * reference.j)",
)  # fmt: skip
heading_rate_left_out = known_mistake(
    "heading_rate_left_out",
    "The heading rate of the reference is not used: the nose will lag behind.",
    "rate_command(R, R_d, reference.heading_rate,", "rate_command(R, R_d, 0.0,",
)  # fmt: skip
printed_jerk = known_mistake(
    "printed_jerk",
    "The jerk's rates are those of (26) as printed: too large by a hundred, and of the wrong sign.",
    "return m_e / size * ", "return -size / m_e * ",
)  # fmt: skip
lee_s_attitude = known_mistake(
    "lee_s_attitude",
    "The attitude is Lee's, whose heading is not the wanted one: take that of (21) to (23).",
    "R_d = _attitude(", "R_d = lee(",
)  # fmt: skip
heading_of_now = known_mistake(
    "heading_of_now",
    "The attitude is built with the heading of now: so the nose never goes where the reference wants it.",
    "_attitude(f, reference.heading)", "_attitude(f, frames.heading(R))",
)  # fmt: skip

# What is learnt, and told -----------------------------------------------------------------------------

deaf_to_disturbances = known_mistake(
    "deaf_to_disturbances",
    "No disturbance is learnt: against a wind the aircraft stays off for ever.",
    "        d_w, d_b = disturbance_step(d_w, d_b, e_p, frames.heading(R), dt, k)  # (35)\n", "",
)  # fmt: skip
deaf_to_the_mass = known_mistake(
    "deaf_to_the_mass",
    "The mass is not learnt: with a payload the aircraft stays low for ever.",
    "        m_e = estimated_mass(m_e, float(e_p[2]), dt, self.mass, k)  # (37)\n", "",
)  # fmt: skip
printed_mass = known_mistake(
    "printed_mass",
    "The mass learns the wrong way, as (37) is printed: who hangs low must gain mass.",
    "float(e_p[2])", "-float(e_p[2])",
)  # fmt: skip
learnt_too_early = known_mistake(
    "learnt_too_early",
    "It learns before it flies: disturbances and mass take their step after the command, and count from the next tick.",
    "        d_w, d_b = disturbance_step(d_w, d_b, e_p, frames.heading(R), dt, k)  # (35)\n", "",
    "        m_e = estimated_mass(m_e, float(e_p[2]), dt, self.mass, k)  # (37)\n", "",
    "        d_w, d_b = memory.d_w, memory.d_b\n",
    "        e_p = estimate.r - reference.r\n"
    "        d_w, d_b = disturbance_step(memory.d_w, memory.d_b, e_p, frames.heading(R), dt, k)\n"
    "        m_e = estimated_mass(m_e, float(e_p[2]), dt, self.mass, k)\n",
)  # fmt: skip
heading_of_the_reference = known_mistake(
    "heading_of_the_reference",
    "The disturbances are learnt along the heading of the reference: it is the aircraft that feels them.",
    "e_p, frames.heading(R), dt", "e_p, reference.heading, dt",
)  # fmt: skip
weighed_on_the_ground = known_mistake(
    "weighed_on_the_ground",
    "a_d is computed with the nominal mass: use the estimated one, as for the force.",
    "R, d_w, d_b, m_e))  # (53)", "R, d_w, d_b, self.mass))  # (53)",
)  # fmt: skip
a_d_without_pushes = known_mistake(
    "a_d_without_pushes",
    "a_d forgets what disturbs: in a wind the estimator is told of an acceleration that is none.",
    "R, d_w, d_b, m_e))  # (53)", "R, 0.0 * d_w, 0.0 * d_b, m_e))  # (53)",
)  # fmt: skip
a_d_of_the_wish = known_mistake(
    "a_d_of_the_wish",
    "a_d is that of the wanted force: (53) asks what the thrust does along the axis that the aircraft has now.",
    "unbiased_acceleration(f_d, R, d_w, d_b, m_e)", "(f + _pushed(R, d_w, d_b)) / m_e - GRAVITY * E3",
)  # fmt: skip

# Worlds, and taking over ------------------------------------------------------------------------------

pushes_not_reframed = known_mistake(
    "pushes_not_reframed",
    "reframe leaves d_w as it was: it is told in the world, so it turns with it.",
    "d_w = about_z(shift.heading) @ memory.d_w", "d_w = memory.d_w",
)  # fmt: skip
nose_reframed = known_mistake(
    "nose_reframed",
    "reframe turns d_b, too: it is told in the frame of the heading, which turns by itself.",
    "memory._replace(d_w=d_w, hand", "memory._replace(d_w=d_w, d_b=about_z(shift.heading) @ memory.d_b, hand",
)  # fmt: skip
handover_not_reframed = known_mistake(
    "handover_not_reframed",
    "reframe leaves the hand-over as it was: the acceleration in it is told in the world.",
    "None if x is None else frames.moved(x, shift) for x", "x for x",
)  # fmt: skip
jumps = known_mistake(
    "jumps",
    "Taking over is felt: the first step must give the last command again, and then let it fade.",
    "fading(memory.handover, command, dt, FADE)", "(Handover(None, None), command)",
)  # fmt: skip
never_lets_go = known_mistake(
    "never_lets_go",
    "What differs from the last command never fades: it must be gone after some half seconds.",
    "command, dt, FADE)", "command, dt, 1e9)",
)  # fmt: skip
