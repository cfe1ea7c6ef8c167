"""Known wrong answers of lab 06, continued: controllers, each the reference with one mistake in it."""

from __future__ import annotations

import inspect
from functools import partial
from typing import Any

import numpy as np

import uavlab.solutions.mpc_controller as right
from grader.material import Play, mutant, sample
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.mpc import MpcController
from uavlab.exercises.mpc_parts_checks import BRISK, STILL, at_rest, commanded, fly, stand
from uavlab.gains import MpcGains
from uavlab.limits import AxisLimits, ForceLimits
from uavlab.types import Command, Estimate, Reference, Shift

CANARY = "canary-5b50c33888348f636940d189"

SOURCE = inspect.getsource(right)
DT = 0.02
LEARNS = MpcGains(k_iw=2.0, k_ib=3.0, k_m=0.5)


def wrong(*changes: tuple[str, str]) -> Any:
    """The reference with some pieces of it replaced."""
    text = SOURCE
    for old, new in changes:
        if text.count(old) != 1:
            raise ValueError(f"{old!r} stands {text.count(old)} times in the reference")
        text = text.replace(old, new)
    room: dict[str, Any] = {"__name__": right.__name__}
    exec(compile(text, "<mutant>", "exec"), room)
    return room["MpcController"]


def told(u: Command) -> list[Any]:
    """A command, to as many digits as two solvers share."""
    return [round(u.f_d, 2), np.round(u.omega_d, 3), np.round(u.a_d, 3)]


def played(
    f: Any, mass: float, gains: MpcGains, parts: list[tuple[Estimate, Reference, int]],
    last: Command | None = None, shift: Shift | None = None, limits: ForceLimits = ForceLimits(),
) -> list[Any]:  # fmt: skip
    """What a controller says in the end of each part of a play; its worlds may move before the last."""
    part = f(mass, limits, gains=gains)
    memory, said = part.init(parts[0][0], last), []
    for i, (x, wanted, steps) in enumerate(parts):
        if shift is not None and i == len(parts) - 1:
            memory = part.reframe(memory, shift)
        for k in range(steps):
            memory, got = part.step(memory, x, wanted, DT)
            said += told(commanded(got)) if k in (0, steps - 1) else []
    return [said, part.failures(memory)]


def flown(f: Any, mass: float, limits: ForceLimits, goal: Reference) -> list[Any]:
    """The middle and the end of a short flight."""
    x = fly(f(mass, limits, gains=BRISK), at_rest(STILL), lambda _t: goal, mass, DT, 40)
    return [np.round(x.v[[20, 39]], 3), np.round(x.a[[3, 20, 39]], 2)]


@sample(MpcController)
def plays(rng: np.random.Generator) -> list[Play]:
    mass, e, eta = 3.0, 0.3 * draw.vector(rng), draw.angle(rng)
    x, goal = (
        at_rest(e, eta),
        stand(STILL, eta + 0.5)._replace(a=0.3 * rng.normal(size=3), heading_rate=0.7),
    )
    turned = at_rest(STILL, eta + 1.2)
    tilted = Estimate(
        e, 0.4 * np.eye(3)[0], 0.2 * rng.normal(size=3), draw.aimed(rng, 0.2, 0.3), np.ones(3)
    )
    rough = x._replace(v=np.array((9.0, -9.0, 9.0)), a=np.array((-9.0, 9.0, -9.0)))
    bad = x._replace(r=e * np.nan)
    last = Command(3.0 * 11.0, 0.2 * rng.normal(size=3), 3.0 * rng.normal(size=3))
    wild = LEARNS._replace(k_iw=900.0, k_ib=400.0, k_m=90.0, d_max=2.0, m_max=0.5)
    tight = MpcGains(tilt_max=0.05, rate_max=(0.1, 0.2, 0.3))
    limits = ForceLimits(AxisLimits(0.6, 0.9, 3.0, np.inf), AxisLimits(0.5, 0.7, np.inf, np.inf))
    shift, far = Shift(draw.vector(rng, 3.0), 0.5 * np.pi), 9.0 * draw.direction(rng)
    moved = at_rest(so3.about_z(shift.heading) @ e + shift.r, eta + shift.heading)
    return [
        partial(played, mass=mass, gains=LEARNS, parts=[(x, goal, 9), (turned, goal, 2)]),
        partial(played, mass=mass, gains=LEARNS, parts=[(tilted, goal, 2), (tilted, stand(far), 9)], limits=limits),
        partial(played, mass=mass, gains=LEARNS, parts=[(rough, goal._replace(v=np.ones(3)), 4), (bad, goal, 3)]),
        partial(played, mass=mass, gains=LEARNS, parts=[(x, goal, 6)], last=last),
        partial(played, mass=mass, gains=wild, parts=[(x, goal, 3)]),
        partial(played, mass=mass, gains=tight, parts=[(turned, stand(far, eta), 9)]),
        partial(
            played, mass=mass, gains=LEARNS, parts=[(x, goal, 5), (moved, stand(moved.r + 0.2), 3)],
            shift=shift, last=last,
        ),
        partial(flown, mass=mass, limits=limits, goal=stand(3.0 * draw.direction(rng) * (1.0, 1.0, 0.2))),
    ]  # fmt: skip


# The plan ---------------------------------------------------------------------------------------------


@mutant(
    MpcController,
    hint="The acceleration of the reference is not fed forward: it is a term of (39).",
)
class no_feed_forward(wrong(("(reference.a + H @ c", "(H @ c"))):
    pass


@mutant(
    MpcController,
    hint="The last input is forgotten: each plan begins from 0, so the slew is not limited.",
)
class last_input_forgotten(wrong(("memory.inputs[i])", "0.0)"))):
    pass


@mutant(MpcController, hint="The second input of the plan is flown: the first one comes first.")
class second_input(wrong(("0.0 if new is None else new.z[0]", "0.0 if new is None else new.z[1]"))):
    pass


@mutant(MpcController, hint="The period of the QP is its dt: the next plan comes after one tick.")
class one_period_for_all(
    wrong(("period = 0.0 if takes_over else dt", "period = 0.0 if takes_over else self.dt"))
):
    pass


@mutant(
    MpcController,
    hint="The vertical is planned like the horizontal: it has limits, weights and a lag of its own.",
)
class one_programme_for_all(wrong(("(up, P_UP, VERTICAL)", "(flat, 0.0, HORIZONTAL)"))):
    pass


@mutant(MpcController, hint="The vertical has no lag here: p = 0.5.")
class no_vertical_lag(wrong(("(up, P_UP, VERTICAL)", "(up, 0.0, VERTICAL)"))):
    pass


@mutant(
    MpcController,
    hint="What is measured is always planned with: replace what breaks its limit (45).",
)
class never_replaced(
    wrong((
        "x0 = initial_state(estimate, reference, self.limits)",
        "x0 = np.column_stack((estimate.r, estimate.v, estimate.a))",
    ))
):
    pass


@mutant(
    MpcController,
    hint="The velocity of the reference is always planned with: (45) wants the measured one.",
)
class always_replaced(
    wrong((
        "x0 = initial_state(estimate, reference, self.limits)",
        "x0 = np.column_stack((estimate.r, reference.v, reference.a))",
    ))
):
    pass


@mutant(MpcController, hint="The plan is not multiplied by the mass: it is an acceleration.")
class plan_for_force(
    wrong((
        "m.m_e * (reference.a + H @ c + GRAVITY * E3)",
        "m.m_e * (reference.a + GRAVITY * E3) + H @ c",
    ))
):
    pass


# Disturbances -----------------------------------------------------------------------------------------


@mutant(MpcController, hint="Disturbances are added to the force: they are to be taken off (39).")
class pushes_along(wrong(("GRAVITY * E3) - d  # (39)", "GRAVITY * E3) + d"))):
    pass


@mutant(
    MpcController, hint="The body's disturbance does not turn: multiply it by H when it is used."
)
class does_not_turn(wrong(("H @ m.d_w + about_z(heading) @ m.d_b", "H @ m.d_w + m.d_b"))):
    pass


@mutant(
    MpcController,
    hint="The body's disturbance is summed up in the world: multiply the error by Hᵀ first.",
)
class summed_in_the_world(wrong(("(about_z(-frames.heading(estimate.R)) @ flat)", "flat"))):
    pass


@mutant(
    MpcController,
    hint="The mass goes the wrong way: who sags is heavier, against the sign of (37).",
)
class lighter_when_it_sags(wrong(("m.m_e - k.k_m *", "m.m_e + k.k_m *"))):
    pass


@mutant(MpcController, hint="Disturbances have no limit: keep them within ±d_max.")
class no_limit(
    wrong(("d_w=d_w.clip(-k.d_max, k.d_max), d_b=d_b.clip(-k.d_max, k.d_max)", "d_w=d_w, d_b=d_b"))
):
    pass


@mutant(MpcController, hint="Disturbances are learned on the way, too: above 0.3 m/s they rest.")
class learns_on_the_way(wrong(("estimate.v[1]) > CALM", "estimate.v[1]) > np.inf"))):
    pass


@mutant(
    MpcController,
    hint="a_d is as printed: (53) needs the mass times g, so the hover is not without a bias.",
)
class as_printed(wrong(("+ d) / m.m_e - GRAVITY * E3", "+ d - GRAVITY * E3) / m.m_e"))):
    pass


@mutant(MpcController, hint="a_d lacks the disturbances: the estimator would feel them as motion.")
class biased(wrong(("(f_d * R[:, 2] + d) / m.m_e", "(f_d * R[:, 2]) / m.m_e"))):
    pass


# Attitude ---------------------------------------------------------------------------------------------


@mutant(
    MpcController,
    hint="The thrust is the size of the force: it is its part along the measured b_3.",
)
class size_for_thrust(wrong(("f_d = float(f @ R[:, 2])", "f_d = float(np.linalg.norm(f))"))):
    pass


@mutant(MpcController, hint="The rotation error has the wrong sign: R_dᵀ R − Rᵀ R_d.")
class turns_away(wrong(("R_d.T @ R - R.T @ R_d", "R.T @ R_d - R_d.T @ R"))):
    pass


@mutant(MpcController, hint="The rotation error lacks its ½.")
class twice_the_error(wrong(("0.5 * (R_d.T", "1.0 * (R_d.T"))):
    pass


@mutant(MpcController, hint="The heading rate of the reference is not used.")
class heading_rate_ignored(wrong(("reference.heading_rate *", "0.0 *"))):
    pass


@mutant(MpcController, hint="The rates are not limited: rate_max.")
class any_rate(wrong(("omega_d.clip(np.negative(k.rate_max), k.rate_max)", "omega_d"))):
    pass


@mutant(MpcController, hint="The tilt is not limited: tilt_max.")
class any_tilt(wrong(("f = limited_tilt(f, k.tilt_max)", "pass"))):
    pass


# Hand-over, worlds, failures --------------------------------------------------------------------------


@mutant(MpcController, hint="The hand-over is felt: the first command must be the last one before.")
class no_handover(
    wrong(("fading(memory.handover, Command", "fading(Handover(None, None), Command"))
):
    pass


@mutant(
    MpcController, hint="reframe does nothing: inputs, d_w and the hand-over are told in the world."
)
class not_reframed(right.MpcController):
    def reframe(self, memory, shift):
        return memory


@mutant(MpcController, hint="Failures are not counted.")
class nothing_counted(right.MpcController):
    def failures(self, memory):
        return 0


@mutant(MpcController, hint="What is no number leads to an error: fly on with the last plan.")
class raises_for_no_number(wrong(("if _numbers(x0[i]):", "if True:"))):
    pass


@mutant(
    MpcController,
    hint="Without a plan it flies as if it were where it is wanted: the last plan is the better guess.",
)
class plan_thrown_away(
    wrong(("solved, new = False, _shifted(memory.plans[i])", "solved, new = False, None"))
):
    pass
