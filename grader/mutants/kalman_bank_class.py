"""Known wrong answers of lab 03, continued: banks of filters, each the reference with one mistake in it."""

from __future__ import annotations

import inspect
from functools import partial
from typing import Any

import numpy as np

import uavlab.solutions.kalman_bank as right
from grader.material import Play, mutant, sample
from uavlab import so3
from uavlab.exercises import draw
from uavlab.exercises.kalman_bank import KalmanBank
from uavlab.types import (
    Attitude,
    Command,
    Estimate,
    Field,
    Fix,
    Flow,
    Height,
    Imu,
    Pose,
    Range,
    Shift,
)  # fmt: skip

CANARY = "canary-e708f35da416453e4f44bf6a"

SOURCE = inspect.getsource(right)
ZERO, DT = np.zeros(3), 0.02
MEMBERS = {
    "gnss": ("imu.heading_rate", "magnetometer.heading", "gnss.velocity", "gnss.position", "barometer.height"),
    "slam": ("imu.heading_rate", "slam.heading", "slam.position", "slam.height"),
    "flow": ("imu.heading_rate", "flow.velocity", "rangefinder.height"),
}  # fmt: skip
NOISE = {
    "imu.heading_rate": 0.01, "magnetometer.heading": 0.02, "gnss.velocity": 0.04, "gnss.position": 0.2,
    "barometer.height": 0.3, "slam.heading": 0.01, "slam.position": 0.02, "slam.height": 0.03,
    "flow.velocity": 0.05, "rangefinder.height": 0.02,
}  # fmt: skip


def wrong(old: str, new: str) -> Any:
    """The reference with one piece of it replaced."""
    if SOURCE.count(old) != 1:
        raise ValueError(f"{old!r} stands {SOURCE.count(old)} times in the reference")
    room: dict[str, Any] = {"__name__": right.__name__}
    exec(compile(SOURCE.replace(old, new), "<mutant>", "exec"), room)
    return room["KalmanBank"]


def plan(rng: np.random.Generator, steps: int, tilt: float, nose: float) -> list[dict[str, Any]]:
    """Readings of a tilted aircraft with this heading, in three worlds; fixes are late, and half of them missing."""
    R = draw.aimed(rng, tilt, tilt + 0.1)
    R = so3.about_z(nose - np.arctan2(R[1, 0], R[0, 0])) @ R
    made = []
    for k in range(1, steps + 1):
        t, off = k * DT, draw.vector(rng, 0.1)
        readings: dict[str, Any] = {
            "imu": Imu(t, ZERO, np.array((0.2, 0.6, -0.5)) + off), "attitude": Attitude(t, so3.about_z(0.4) @ R),
            "slam": Pose(t, 2.0 + off, so3.about_z(0.9 + off[0]) @ R),
            "flow": Flow(t, (R.T @ (1.0, 0.5, 0.2) + off)[:2]),
            "barometer": Height(t, 1.0 + off[1]),
        }  # fmt: skip
        if k % 2:
            readings["gnss"] = Fix(t - 0.4 * DT, off - 3.0, np.array((1.0, 0.4, 0.2)) + off)
            readings["magnetometer"] = Field(t, R.T @ np.array((0.5, 0.1 * off[2], -0.8)))
            readings["rangefinder"] = Range(t, 2.0 + off[2])
        made.append(readings)
    return made


def flown(
    bank: Any, start: Estimate, readings: list[dict[str, Any]], flies: str = "", **more: Any
) -> list[Any]:
    """All that a bank says in a flight, in which its worlds move in the end."""
    part = bank(MEMBERS, NOISE, **more)
    memory, said = part.init(start), []
    for k, arrived in enumerate(readings):
        if k == len(readings) - 1:
            memory = part.reframe(memory, Shift(np.array((1.0, -2.0, 0.5)), 0.7))
        memory, told = part.step(
            memory, arrived, Command(0.0, ZERO, np.array((1.0, -2.0, 0.5))), DT, flies
        )
        said.append([list(x) for x in told.values()])
    return [said, part.rejected(memory)]


@sample(KalmanBank)
def flights(rng: np.random.Generator) -> list[Play]:
    start = Estimate(draw.vector(rng), draw.vector(rng), ZERO, np.eye(3), ZERO, "gnss")
    rough = plan(rng, 4, 0.25, 0.3)
    rough[2]["slam"] = rough[2]["slam"]._replace(r=rough[2]["slam"].r + 9.0)
    rough[3]["barometer"] = rough[2]["barometer"]._replace(z=5.0)
    seam = plan(rng, 4, 0.2, np.pi - 0.9 - 0.01)
    steep = plan(rng, 3, 0.6, 1.0)
    quiet = plan(rng, 4, 0.2, -1.0)
    quiet[1], quiet[2] = {"imu": quiet[1]["imu"]}, {"imu": quiet[2]["imu"]}
    sick = plan(rng, 4, 0.2, 0.2)
    for readings in sick[:2]:
        readings["barometer"] = readings["barometer"]._replace(z=start.r[2] + 4.5)
    still = start._replace(R=so3.about_z(np.pi - 0.05), world="slam")
    return [
        partial(flown, start=start, readings=rough, flies="gnss"),
        partial(flown, start=still, readings=seam, flies="gnss"),
        partial(flown, start=start, readings=steep),
        partial(flown, start=start, readings=quiet, flies="slam", patience=0.03),
        partial(flown, start=start, readings=sick, limits=(1.02, 1.6), forget=0.1),
    ]  # fmt: skip


# Worlds and inputs ------------------------------------------------------------------------------------


@mutant(
    KalmanBank, hint="Every member is fed every instrument: each must hear its own sources only."
)
class everybody_hears_everything(
    wrong("[s in own for s in self._sources]", "[True for s in self._sources]")
):
    pass


@mutant(KalmanBank, hint="The input is not used: the controller says what acceleration will come.")
class input_ignored(wrong("u = _turned(", "u = 0.0 * _turned(")):
    pass


@mutant(
    KalmanBank,
    hint="The input is used as it is told: turn it from the world of who flies into that of each member.",
)
class input_in_the_wrong_world(wrong("m.h[:, 0] - eta)", "0.0 * m.h[:, 0])")):
    pass


@mutant(
    KalmanBank,
    hint="The input is turned the wrong way round: by the member's heading less that of who flies.",
)
class input_turned_backwards(wrong("m.h[:, 0] - eta)", "eta - m.h[:, 0])")):
    pass


@mutant(
    KalmanBank,
    hint="The first reading is weighed: taken as it is, it lets a member start in its own world.",
)
class start_is_weighed(wrong("(m.age[:, s] > self.patience)", "np.isnan(m.age[:, s])")):
    pass


@mutant(
    KalmanBank,
    hint="A member that hears its heading for the first time keeps its old velocity: that turns along.",
)
class velocity_left_behind(
    wrong("m = self._turned_along(m, np.where(fresh, nu[:, 0, 0], 0.0))", "pass")
):
    pass


@mutant(KalmanBank, hint="reframe turns positions only: velocities and accelerations turn, too.")
class motion_not_reframed(
    wrong(
        "        x[:, :, 0] += shift.r\n",
        "        x[:, :, 0] += shift.r\n        x[:, :, 1:] = memory.x[:, :, 1:]\n",
    )
):
    pass


# Filters ----------------------------------------------------------------------------------------------


@mutant(KalmanBank, hint="Q is not multiplied by dt: q_xy and q_z say what is gained per second.")
class noise_without_dt(wrong("dt * np.stack(", "np.stack(")):
    pass


@mutant(
    KalmanBank,
    hint="The variances are used as standard deviations, or the other way round: R_z is the variance itself.",
)
class deviation_for_variance(
    wrong("np.array([[self.variances[source]]])", "np.array([[self.variances[source] ** 0.5]])")
):
    pass


@mutant(
    KalmanBank, hint="p belongs to a step of 0.01 s: for another step take the power dt / 0.01."
)
class one_p_for_all_steps(wrong("p ** (dt / PERIOD)", "p")):
    pass


@mutant(
    KalmanBank,
    hint="The innovation of a heading is not wrapped: near ±π the filter turns all around.",
)
class heading_not_wrapped(wrong("frames.wrap(nu) if quantity", "nu if quantity")):
    pass


@mutant(
    KalmanBank, hint="A late reading is taken for one of now: use the time at which it was true."
)
class late_for_now(wrong("max(m.t - reading.t, 0.0)", "0.0")):
    pass


@mutant(
    KalmanBank, hint="The yaw rate is taken for the heading rate: on a tilted aircraft use (15)."
)
class yaw_rate_for_heading_rate(wrong("_heading_rate(m.R, reading.gyro))", "reading.gyro[2])")):
    pass


@mutant(KalmanBank, hint="Optic flow is told in the body: turn it into the world of the member.")
class flow_in_the_body(
    wrong(
        "return _turned(np.array(v), m.h[:, 0] - frames.heading(m.R))",
        "return np.tile(reading.v_B, (len(v), 1))",
    )
):
    pass


# Health -----------------------------------------------------------------------------------------------


@mutant(
    KalmanBank,
    hint="Nothing is rejected for being too surprising: compare the normalised innovation with the gate.",
)
class no_gate(wrong("(nis <= self.gate)", "(nis <= inf)")):
    pass


@mutant(
    KalmanBank, hint="An instrument that looks down is used on an aircraft that is tilted too far."
)
class no_tilt_gate(wrong("return bool(R[2, 2] >= np.cos(self.tilt))", "return True")):
    pass


@mutant(
    KalmanBank, hint="A reading that is not newer than the last of its instrument is used again."
)
class time_runs_backwards(wrong("reading.t > last.get(name, -inf)", "True")):
    pass


@mutant(
    KalmanBank,
    hint="The normalised innovation is not divided by its degrees of freedom: a position has two.",
)
class sum_for_mean(wrong("each.mean(axis=1)", "each.sum(axis=1)")):
    pass


@mutant(KalmanBank, hint="A member whose instrument has fallen silent counts as reliable.")
class silence_is_no_sign(wrong("heard.all(axis=1) & ", "")):
    pass


@mutant(
    KalmanBank,
    hint="The limit of the health has no hysteresis: who is reliable may reach the higher one.",
)
class no_hysteresis(
    wrong("np.where(m.reliable, max(self.limits), min(self.limits))", "min(self.limits)")
):
    pass


@mutant(KalmanBank, hint="Rejected readings are not counted.")
class nothing_counted(
    wrong(
        "return dict(zip(self.members, memory.rejected.tolist(), strict=True))",
        "return dict.fromkeys(self.members, 0)",
    )
):
    pass


@mutant(
    KalmanBank,
    hint="The last reading is held and used in every step: it counts when it arrives, and not again.",
)
class innovation_held(right.KalmanBank):
    def init(self, estimate):
        return super().init(estimate), {}

    def step(self, memory, readings, command, dt, flies=""):
        held = {k: x._replace(t=x.t + dt) for k, x in memory[1].items()} | readings
        inner, told = super().step(memory[0], held, command, dt, flies)
        return (inner, held), told

    def reframe(self, memory, shift):
        return super().reframe(memory[0], shift), memory[1]

    def rejected(self, memory):
        return super().rejected(memory[0])
