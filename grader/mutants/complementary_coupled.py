"""Lab 04, known wrong answers, the third part: the coupled pair. Each is the reference with one method changed."""

from __future__ import annotations

from functools import partial

import numpy as np

from grader.material import Play, mutant, sample
from uavlab.exercises import draw
from uavlab.exercises.complementary import CoupledFilter
from uavlab.exercises.complementary_checks import FAST
from uavlab.exercises.paths import FIELD, Blown
from uavlab.frames import moved
from uavlab.solutions.complementary import CoupledFilter as Right
from uavlab.types import Height, Shift

CANARY = "canary-eabffe550dd53b27a2fe89c4"


def flight(make, seed, shift):
    """Found, lost and found again, without a compass at the end, then in another world."""
    rng = np.random.default_rng(seed)
    blown = Blown(rng, draw.angle(rng), w=draw.vector(rng, 2.0) * (1, 1, 0), c=0.1)
    gains = FAST._replace(k_1_vc=2.0, k_2_vc=1.0, k_1_b_a=3.0, k_2_b_a=2.0, k_1_rc=2.0, k_2_rc=3.0)
    gains = gains._replace(body=gains.body._replace(k_b_a=0.3, k_b_omega=0.05, k_b_m=0.2))
    part, said = make(m_W=FIELD, c=0.1, gains=gains, patience=0.1), []
    memory, start = part.init(blown.guess()), None
    for k in range(28):
        readings = blown.step(0.03)
        lost = {"gnss"} if k % 3 or 9 <= k < 18 else set()
        lost |= {"magnetometer"} if k < 8 else set()
        lost |= {"barometer"} if k < 4 else set()
        if k == 20:
            memory, start = part.reframe(memory, shift), shift
        readings = {
            n: x if start is None else moved(x, start) for n, x in readings.items() if n not in lost
        }
        if k == 23:
            readings["barometer"] = Height(0.0, np.nan)
        memory, x = part.step(memory, readings, None, 0.03)
        said.append(x)
    return said[3], said[8], said[12], said[19], said[21], said[27]


@sample(CoupledFilter)
def flights(rng: np.random.Generator) -> list[Play]:
    return [
        partial(flight, seed=int(s), shift=Shift(draw.vector(rng), float(rng.uniform(0.5, 2.5))))
        for s in rng.integers(1_000_000, size=4)
    ]


def changed(name: str, hint: str, method: str, make):
    """The reference with one method made anew from the right one."""
    kind = type(name, (Right,), {method: make(getattr(Right, method))})
    return mutant(CoupledFilter, hint=hint)(kind)


def after(change):
    """A step whose memory is changed by ``change(filter, before, after, dt)``."""

    def make(step):
        def changed_step(self, memory, readings, command, dt):
            now, x = step(self, memory, readings, command, dt)
            now = change(self, memory, now, dt)
            return now, x._replace(w=now.w, v=now.inertial.v)

        return changed_step

    return make


def with_gains(**gains):
    """A step with other gains."""

    def make(step):
        def changed_step(self, memory, readings, command, dt):
            other = Right(
                self.m_W, self.c, self.gains._replace(**gains), self.patience, self.velocity
            )
            return step(other, memory, readings, command, dt)

        return changed_step

    return make


def filtered(keep):
    """A step that is told only some readings."""

    def make(step):
        def changed_step(self, memory, readings, command, dt):
            return step(self, memory, keep(memory, readings), command, dt)

        return changed_step

    return make


def flipped_wind(self, old, now, dt):
    return now._replace(w=2.0 * old.w - now.w)


def kept_wind(self, old, now, dt):
    return now._replace(w=old.w) if now.v_meas is None else now


def driven_wind(self, old, now, dt):
    gap = old.inertial.v - old.w - old.body.R @ old.body.V
    return now._replace(w=old.w + dt * self.gains.k_w * gap)


def forgotten_wind(self, old, now, dt):
    return now._replace(w=0.0 * now.w) if now.v_meas is None else now


def not_held(self, old, now, dt):
    return now._replace(v_meas=None)


def raw_bias(right):
    def air(self, now, imu):
        return right(self, now._replace(body=now.body._replace(b_a=0.0 * now.body.b_a)), imu)

    return air


def body_up(right):
    def air(self, now, imu):
        V = right(self, now, imu)
        return None if V is None else np.array((V[0], V[1], now.vertical.v_z))

    return air


def less_moved(**fields):
    """A reframe that leaves something where it was."""

    def make(right):
        def reframe(self, memory, shift):
            kept = {name: getattr(memory, name) for name in fields}
            return right(self, memory, shift)._replace(**kept)

        return reframe

    return make


def only_the_shift(right):
    def reframe(self, memory, shift):
        return right(self, memory, Shift(shift.r, 0.0))

    return reframe


def tilted_start(right):
    def init(self, estimate):
        return right(self, estimate._replace(R=np.eye(3)))

    return init


def patient(step):
    def changed_step(self, memory, readings, command, dt):
        other = Right(self.m_W, self.c, self.gains, np.inf, self.velocity)
        return step(other, memory, readings, command, dt)

    return changed_step


STEP, AIR = "step", "_air_velocity"

m_1 = changed(
    "WindFlipped", "The wind runs away: (9e) draws it to v̂_2 − R̂_1 V̂_1.", STEP, after(flipped_wind)
)
m_2 = changed(
    "WindKept",
    "Without a velocity over ground the wind must decay, −k_w ŵ (Sec. II-E): yours stays.",
    STEP,
    after(kept_wind),
)
m_3 = changed(
    "WindDriven",
    "Without a velocity over ground the wind cannot be seen: (9e) must lose its drive, and the wind decay.",
    STEP,
    after(driven_wind),
)
m_4 = changed(
    "WindForgotten",
    "The wind jumps to zero when the velocity over ground is lost: let it decay.",
    STEP,
    after(forgotten_wind),
)
m_5 = changed(
    "NotHeld",
    "A velocity counts only in the step in which it arrives: hold it, and make its innovation anew each step.",
    STEP,
    after(not_held),
)
m_6 = changed(
    "Patient",
    "A velocity is held for ever: after `patience` it has dropped out.",
    STEP,
    patient,
)
m_7 = changed(
    "NotCoupled",
    "The two filters are not coupled: (8) and (11) pull each to the other.",
    STEP,
    with_gains(k_1_vc=0.0, k_2_vc=0.0, k_1_rc=0.0, k_2_rc=0.0, k_1_b_a=0.0, k_2_b_a=0.0),
)
m_8 = changed(
    "VelocityNotCoupled",
    "The velocities are not coupled: (8a) and (11a) are missing.",
    STEP,
    with_gains(k_1_vc=0.0, k_2_vc=0.0),
)
m_9 = changed(
    "AttitudeNotCoupled",
    "The attitudes are not coupled: (8b) and (11b) are missing.",
    STEP,
    with_gains(k_1_rc=0.0, k_2_rc=0.0),
)
m_10 = changed(
    "BiasNotCoupled",
    "The accelerometer biases are not coupled: (6e) and (9f) draw each to the other.",
    STEP,
    with_gains(k_1_b_a=0.0, k_2_b_a=0.0),
)
m_11 = changed(
    "NoMagnetometer",
    "The magnetometer is not read: the heading is the gyro's alone.",
    STEP,
    filtered(lambda memory, readings: {n: x for n, x in readings.items() if n != "magnetometer"}),
)
m_12 = changed(
    "NoBarometer",
    "The barometer is not read: Filter 0 has no innovation.",
    STEP,
    filtered(lambda memory, readings: {n: x for n, x in readings.items() if n != "barometer"}),
)
m_13 = changed(
    "BiasedDrag",
    "The drag is taken from the biased accelerometer: take the bias of Filter 1 off first.",
    AIR,
    raw_bias,
)
m_14 = changed(
    "BodyUp",
    "The vertical velocity of Filter 0 is told in the world: solve for V_z, it is not V_z.",
    AIR,
    body_up,
)
m_15 = changed(
    "FieldForgotten",
    "In another world the magnetic field points elsewhere: turn it too.",
    "reframe",
    less_moved(m_W=0),
)
m_16 = changed(
    "WindForgottenInReframe",
    "In another world the wind blows elsewhere: turn it too.",
    "reframe",
    less_moved(w=0),
)
m_17 = changed(
    "HeldForgottenInReframe",
    "What is held of the velocity is told in the old world: turn it too.",
    "reframe",
    less_moved(v_meas=0),
)
m_18 = changed(
    "NotTurned",
    "The shift of the world also turns it: velocities, wind, attitudes and field turn along.",
    "reframe",
    only_the_shift,
)
m_19 = changed(
    "LevelStart",
    "The start forgets the attitude of the estimate.",
    "init",
    tilted_start,
)
