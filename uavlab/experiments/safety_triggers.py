"""The watch, trigger by trigger: each is provoked by something that breaks, and the aircraft must come down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.experiments.story import down, when
from uavlab.flight.fault import Fault
from uavlab.flight.fly import HARD_IMPACT, fly
from uavlab.flight.log import Log
from uavlab.flight.piloted import piloted
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import Shift
from uavlab.interfaces import Memory
from uavlab.orders import TakeOff
from uavlab.parts.errands import Errand, Step, Wait
from uavlab.parts.estimators import AlphaBetaGamma
from uavlab.parts.missions import still
from uavlab.parts.vetted import Vetted
from uavlab.plant import load_airframe
from uavlab.sensors import Ahrs, carry
from uavlab.types import Command, Estimate, Exit, Reference

NAME = "T650"
AT, HEIGHT = 10.0, 2.5  # [s] when it breaks, [m] where it hovers then
SEEDS = 5
ALL, BEARS = Band(1.0, 1.0), Band(0.0, HARD_IMPACT)


@dataclass(frozen=True)
class Deaf:
    """A controller that never turns its nose: the law's command without the yaw rate."""

    slot: ClassVar[str] = "controller"
    law: Any

    def init(self, estimate: Estimate, last: Command | None) -> Memory:
        """As the law."""
        return self.law.init(estimate, last)

    def step(
        self, memory: Memory, estimate: Estimate, reference: Reference, dt: float
    ) -> tuple[Memory, Command]:
        """As the law, but for the yaw."""
        memory, command = self.law.step(memory, estimate, reference, dt)
        return memory, command._replace(omega_d=command.omega_d * (1.0, 1.0, 0.0))

    def reframe(self, memory: Memory, shift: Shift) -> Memory:
        """As the law."""
        return self.law.reframe(memory, shift)


class Cause(NamedTuple):
    """What is done to provoke a trigger, and what it should lead to."""

    trigger: str  # of `uavlab.managers.safety.TRIGGERS`
    said: str  # what breaks, in words
    soon: Band  # [s] from there to the verdict
    faults: tuple[Fault, ...] = ()
    steps: tuple[Step, ...] = ()  # after the take-off
    vetted: bool = False  # whether the estimator looks at its readings
    deaf: bool = False  # whether `Deaf` flies first
    hopeless: bool = False  # whether nobody could land it
    falls: bool = False  # whether it must end under the failsafe


BEHIND = (Wait(AT - 5.2), still(np.array((0.0, 0.0, HEIGHT)), np.pi))  # told at about AT
CAUSES: tuple[Cause, ...] = (
    Cause("state missing", "the estimate is no number", Band(0.085, 0.12), (Fault("nan", AT, what="all"),), falls=True),
    Cause("unreliable", "the cameras see nothing any more", Band(0.2, 1.1), (Fault("lost", AT, what="mocap"),),
          vetted=True, falls=True),
    Cause("lost", "the cameras move by 12 m", Band(0.0, 1.5),
          (Fault("jump", AT, what="mocap", value=(12.0, 0.0, 0.0)),), falls=True),
    Cause("tilt error", "a motor makes 40 % of its thrust", Band(0.5, 1.0), (Fault("motor", AT, what="0", value=0.4),),
          hopeless=True),
    Cause("tracker", "the tracker gives what is no number", Band(0.0, 0.02),
          (Fault("part", AT, what="tracker.MpcTracker", value="nan"),)),
    Cause("tracker", "the tracker raises, then the lander", Band(0.0, 0.02), (
            Fault("part", AT, what="tracker.MpcTracker", value="raises"),
            Fault("part", AT + 2.0, what="tracker.LandOff emergency", value="raises"),
        ),
          falls=True),
    Cause("controller", "the controller raises", Band(0.0, 0.02),
          (Fault("part", AT, what="controller.GeometricController", value="raises"),)),
    Cause("controller", "the controller raises, then its rescuer", Band(0.0, 0.02),
          (
            Fault("part", AT, what="controller.GeometricController", value="raises"),
            Fault("part", AT + 2.0, what="controller.Emergency", value="raises"),
        ), falls=True),
    Cause("control error", "a gust of 18 m/s that lasts 1 s", Band(0.0, 1.5),
          (Fault("gust", AT, AT + 1.0, value=(18.0, 0.0, 0.0)),)),
    Cause("jump", "the cameras move by 6 m", Band(0.0, 0.1),
          (Fault("jump", AT, what="mocap", value=(6.0, 0.0, 0.0)),)),
    Cause("heading error", "a controller that does not turn is told to turn round", Band(0.0, 10.0), steps=BEHIND,
          deaf=True),
    Cause("tilt", "a motor of four stands still", Band(0.0, 1.0), (Fault("motor", AT, what="0", value=0.0),),
          hopeless=True),
    Cause("throttle", "the battery sags to 40 % in 5 s", Band(1.0, 6.0), (Fault("battery", AT, AT + 5.0, value=0.4),)),
    Cause("solver", "no programme finds a plan", Band(0.45, 0.55), (Fault("solver", AT),)),
    Cause("link", "nobody is heard", Band(2.95, 3.05), (Fault("link", AT),)),
)  # fmt: skip


def provoked(cause: Cause, seed: int) -> Log:
    """Take off and hover; then it breaks."""
    steps = (TakeOff(HEIGHT), *(cause.steps or (still(np.array((0.0, 0.0, HEIGHT))),)))
    scenario = Scenario(
        cause.trigger, "", NAME, Errand(steps), standing((0.0, 0.0, 0.0)), AT + 40.0,
        carry("imu", "mocap", ahrs=Ahrs(heading=0.0, heading_walk=0.0)), faults=cause.faults,
    )  # fmt: skip
    estimator: Any = Vetted(AlphaBetaGamma()) if cause.vetted else AlphaBetaGamma()
    law = answer("geometric", "GeometricController")(float(load_airframe(NAME).m))
    return fly(scenario, piloted(NAME, estimator, *((Deaf(law),) if cause.deaf else ())), seed=seed)


def run(seeds: int) -> Outcome:
    """All triggers."""
    answer("mpc", "MpcTracker")
    rows: list[Row] = []
    shown: list[tuple[Cause, Log]] = []
    for cause in CAUSES:
        logs = [provoked(cause, seed) for seed in range(seeds)]
        rows += _rows(cause, logs)
        shown.append((cause, logs[0]))
    return Outcome(tuple(rows), _panels(shown), _REMARKS)


_REMARKS = (
    f"{NAME} takes off to {HEIGHT:g} m and hovers under `uavlab.piloted`; at {AT:g} s something breaks. The notes have "
    "what the watch said, and how the flight ended. After a touch the motors go off when the "
    "thrust has been below half of the weight for 2 s, or when a fall must be over.",
    "A quadrotor of which a motor has failed turns over, or falls on, before anybody can land it: all that can be "
    "asked is that it is seen. A hexacopter flies on without it.",
    "Times are from the fault. A heading behind it is reached by the reference only after some seconds; gusts and "
    "batteries need theirs to do harm.",
)


def _rows(cause: Cause, logs: list[Log]) -> list[Row]:
    what = f"{cause.trigger}: {cause.said}"
    seen = [when(x, "safety", cause.trigger) - AT for x in logs]
    ends = [down(x) for x in logs]
    rows = [
        Row(f"{what}: seen [share]", "all",
            float(np.mean([not np.isnan(x) for x in seen])), ALL, None, _spoke(logs[0])),
        Row(f"{what}: after [s]", "—", float(np.mean(seen)), cause.soon, float(np.std(seen)),
            logs[0].reason if cause.hopeless else ""),
    ]  # fmt: skip
    if cause.hopeless:
        return rows
    wanted = Exit.FAILSAFE if cause.falls else Exit.LANDED
    return [
        *rows,
        Row(f"{what}: {'down under the failsafe' if cause.falls else 'landed'} [share]", "all",
            float(np.mean([x.exit is wanted for x in logs])), ALL, None, logs[0].reason),
        Row(f"{what}: speed at touch-down, largest [m/s]", "—", max(x.speed for x in ends), BEARS),
        Row(f"{what}: on the ground, from the fault [s]", "—",
            float(np.mean([x.contact - AT for x in ends]))),
    ]  # fmt: skip


def _spoke(log: Log) -> str:
    """What the watch said, in its order."""
    spoke = [x for x in log.meta["events"] if x[1] == "safety"]
    return "; then ".join(f"{name}: {said}" for *_, name, said in spoke)


def _panels(shown: list[tuple[Cause, Log]]) -> tuple[Panel, ...]:
    """Heights after the fault: of those who land, of those who fall, and of those whom nobody can save."""

    def height(title: str, some: list[tuple[Cause, Log]], end: float) -> Panel:
        lines = []
        for cause, log in some:
            t = log.t - AT
            near = (t > -1.0) & (t < end)
            lines.append(Line(cause.said, t[near], log.r[near, 2]))
        x, marks = "time after the fault [s]", ((0.0, "it breaks"),)
        return Panel(title, x, "height [m]", tuple(lines), marks)

    lands = [x for x in shown if not (x[0].falls or x[0].hopeless)]
    return (
        height("Emergency landings, seed 0", lands, 20.0),
        height("Failsafe, seed 0", [x for x in shown if x[0].falls], 8.0),
        height("A motor of four, seed 0", [x for x in shown if x[0].hopeless], 8.0),
    )


EXPERIMENTS = (
    Experiment("safety", "What must not be, and what is done about it", "MRS Sec. 7.2", run, SEEDS),
)
