"""000-9 and 000-10 once more, with everything in the loop: the pilot itself sees the ground, or the loss."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.experiments.story import Down, down, leant, when
from uavlab.flight.fault import Fault
from uavlab.flight.fly import fly
from uavlab.flight.log import Log
from uavlab.flight.piloted import piloted
from uavlab.flight.scenario import Scenario, standing
from uavlab.orders import LandHome, TakeOff
from uavlab.parts.errands import Errand
from uavlab.parts.missions import still
from uavlab.plant import CALM, CompiledPlant, Wind, load_airframe
from uavlab.sensors import Ahrs, carry
from uavlab.types import Array, Exit

NAME = "T650"
SE3, MPC, BOTH = "SE(3)", "MPC", "MPC, landed by SE(3)"
LAWS: dict[str, tuple[str, str]] = {  # who flies, and who lands if somebody else does
    SE3: ("GeometricController", ""),
    MPC: ("MpcController", ""),
    BOTH: ("MpcController", "GeometricController"),
}
SOON, NEVER, ALL = Band(2.0, 3.0), Band(0.0, 0.0), Band(1.0, 1.0)
PATIENCE = 12.0  # [s] for each place, though gusts keep the aircraft from standing there
LOST, HEIGHT = 9.0, 2.0  # [s], [m]
NOTICED = Band(0.085, 0.12)  # [s]: the tick in which it is lost counts


def there_and_back(who: str, seed: int) -> Log:
    """From the ground to two places and back to the ground: load, wind and places are drawn."""
    rng = np.random.default_rng(2900 + seed)
    airframe = load_airframe(NAME)
    places = [rng.uniform((-6.0, -6.0, 1.5), (6.0, 6.0, 6.0)) for _ in range(2)]
    speed, towards = rng.uniform(0.0, 3.0), rng.uniform(-np.pi, np.pi)
    mean = speed * np.array((np.cos(towards), np.sin(towards), 0.0))
    steps = (TakeOff(float(rng.uniform(1.0, 3.0))), *(still(r, 0.0) for r in places), LandHome())
    scenario = Scenario(
        "there and back", "", NAME, Errand(steps, near=0.5, slow=0.5, patience=PATIENCE),
        standing((0.0, 0.0, 0.0)), 90.0, carry("imu", "mocap"),
        wind=Wind(mean, np.full(3, 0.25 * speed)),
    )  # fmt: skip
    plant = CompiledPlant(airframe._replace(m=airframe.m + rng.uniform(-0.3, 0.3)))
    law, lands = LAWS[who]
    return fly(scenario, piloted(NAME, law, lands=lands), seed=seed, plant=plant)


def landed(seeds: int) -> Outcome:
    """000-9, in the loop."""
    answer("geometric", "GeometricController")
    answer("mpc", "MpcController")
    logs = {who: [there_and_back(who, s) for s in range(seeds)] for who in LAWS}
    ends = {who: [down(x) for x in each] for who, each in logs.items()}
    rows = [row for who in LAWS for row in _landed_rows(who, logs[who], ends[who])]
    return Outcome(tuple(rows), _landed_panels(logs, ends), _LANDED)


_SLOW = (
    "MPC asks for 2 m/s² less at most, a fifth of the weight; the rest must be unlearned from the mass, at k_m · 1 m "
    "each second: see 000-9"
)
_LANDED = (
    f"{NAME} stands on the ground, takes off to 1 to 3 m, flies to two places within 12 by 12 by 4.5 m and lands "
    "where it took off: orders of an `Errand` to `uavlab.piloted`, inertial unit and cameras, true mass within 0.3 kg "
    "of what was told, wind of up to 3 m/s with gusts of a quarter. The pilot listens to its own commands and switches "
    "the motors off; the flight ends as landed if it truly stands then.",
    "The mass against which the ground is seen is the one that the controller had learned before the landing began.",
)


def _landed_rows(who: str, logs: list[Log], ends: list[Down]) -> list[Row]:
    after = [x.after for x in ends]
    quick = who != MPC
    aside = [float(np.hypot(*(x.at[:2]))) for x in ends]
    return [
        Row(f"{who}: flights that ended as landed [share]", "all",
            float(np.mean([x.exit is Exit.LANDED for x in logs])), ALL),
        _mean(f"{who}: motors off after contact [s]", "factor, time", after, SOON, "" if quick else _SLOW),
        Row(f"{who}: the same, soonest [s]", "—", min(after), SOON if quick else None),
        Row(f"{who}: the same, latest [s]", "—", max(after), SOON if quick else None),
        Row(f"{who}: motors off in flight", "0",
            float(sum(not x.height < 0.05 for x in ends)), NEVER),
        Row(f"{who}: emergencies and failsafes", "—",
            float(sum(when(x, "safety") == when(x, "safety") for x in logs)), NEVER),
        _mean(f"{who}: vertical speed at contact [m/s]", "0.5", [x.sink for x in ends]),
        _mean(f"{who}: from where it took off [m]", "—", aside),
    ]  # fmt: skip


def _landed_panels(logs: dict[str, list[Log]], ends: dict[str, list[Down]]) -> tuple[Panel, ...]:
    points = tuple(
        Line(who, np.arange(len(each), dtype=float), np.array([x.after for x in each]), "points")
        for who, each in ends.items()
    )
    touch = tuple(
        Line(f"{who}, seed {k}", x.t - end.contact, x.r[:, 2])
        for who, each in logs.items()
        for k, (x, end) in enumerate(zip(each[:2], ends[who][:2], strict=True))
    )
    force = tuple(
        Line(f"{who}, seed 0", *_late(each[0], ends[who][0])) for who, each in logs.items()
    )
    return (
        Panel("Height", "time after contact [s]", "height [m]", touch, ((0.0, "contact"),)),
        Panel("Thrust, as commanded", "time after contact [s]", "force [N]", force, ((0.0, "contact"),)),
        Panel("Motors off after contact", "seed", "time [s]", points),
    )  # fmt: skip


def _late(log: Log, end: Down) -> tuple[Array, Array]:
    """Thrust around the touch: times (n,) [s] after it, and forces (n,) [N]."""
    t = log.t - end.contact
    near = t > -6.0
    return t[near], log.f_d[near]


# 000-10 -----------------------------------------------------------------------------------------------


def lost_at_two_metres(seed: int, *, wind: Wind = CALM, what: str = "all") -> Log:
    """Take off to 2 m, hover; then the estimate is no number any more."""
    scenario = Scenario(
        "lost", "", NAME, Errand((TakeOff(HEIGHT),)), standing((0.0, 0.0, 0.0)), LOST + 25.0,
        carry("imu", "mocap", ahrs=Ahrs(heading=0.0, heading_walk=0.0)), wind=wind,
        faults=(Fault("nan", LOST, what=what),),
    )  # fmt: skip
    return fly(scenario, piloted(NAME), seed=seed)


def lost(seeds: int) -> Outcome:
    """000-10, in the loop."""
    answer("geometric", "GeometricController")
    windy = CALM._replace(mean=np.array((3.0, 0.0, 0.0)))
    kinds: dict[str, Callable[[int], Log]] = {
        "all is lost": lost_at_two_metres,
        "position and velocity are lost": lambda s: lost_at_two_metres(s, what=""),
        "all is lost in 3 m/s of wind": lambda s: lost_at_two_metres(s, wind=windy),
    }
    logs = {kind: [make(s) for s in range(seeds)] for kind, make in kinds.items()}
    rows = [row for kind, each in logs.items() for row in _lost_rows(kind, each, "wind" in kind)]
    return Outcome(tuple(rows), _lost_panels(logs), _LOST)


_LOST = (
    f"{NAME} takes off to {HEIGHT:g} m and hovers. From {LOST:g} s on the estimate is not a number. For 0.1 s the "
    "pilot flies on with what it knew, then it falls: .98 of the hover throttle of the mass that it had learned, 1.5 % "
    "of the range less each second. When all is lost, its attitude is that of the gyro and of the tilt of the "
    "autopilot.",
    "Level is what the attitude says: its own error of 0.3° stays. In wind it keeps the lean against the wind that it "
    "had when it was lost; who levels out, as MRS does, drifts away with the air (000-10).",
)


def _lost_rows(kind: str, logs: list[Log], windy: bool) -> list[Row]:
    ends = [down(x) for x in logs]
    seen = [when(x, "safety", "state missing") - LOST for x in logs]
    after, speed = [x.contact - LOST for x in ends], [x.speed for x in ends]
    begun = [LOST + (0.6 if windy else 0.0)] * len(logs)
    tilts = [leant(x, t, e.contact - 0.01) for x, t, e in zip(logs, begun, ends, strict=True)]
    judged = not windy
    return [
        Row(f"{kind}: noticed after, latest [s]", "> 0.1", max(seen), NOTICED),
        Row(f"{kind}: ended under the failsafe, on the ground [share]", "all",
            float(np.mean([x.exit is Exit.FAILSAFE for x in logs])), ALL),
        _mean(f"{kind}: on the ground after [s]", "moderate descent", after, SOON if judged else None),
        Row(f"{kind}: the same, soonest [s]", "—", min(after), SOON if judged else None),
        Row(f"{kind}: the same, latest [s]", "—", max(after), SOON if judged else None),
        Row(f"{kind}: speed at touch-down, largest [m/s]", "—", max(speed), Band(0.0, 2.6)),
        Row(f"{kind}: tilt on the way, largest [deg]", "levelled", max(tilts),
            Band(0.0, 2.0) if judged else None),
        _mean(f"{kind}: motors off after contact [s]", "—", [x.after for x in ends]),
    ]  # fmt: skip


def _lost_panels(logs: dict[str, list[Log]]) -> tuple[Panel, ...]:
    x = "time after the loss [s]"

    def lines(of: Callable[[Log], Array]) -> tuple[Line, ...]:
        return tuple(Line(kind, *_after(each[0], of(each[0]))) for kind, each in logs.items())

    marks = ((0.1, "it falls"),)
    return (
        Panel("Height, seed 0", x, "height [m]", lines(lambda log: log.r[:, 2]), marks),
        Panel("Vertical speed, seed 0", x, "speed [m/s]", lines(lambda log: log.v[:, 2]), marks),
        Panel("Thrust, as commanded, seed 0", x, "force [N]", lines(lambda log: log.f_d), marks),
    )


def _after(log: Log, y: Array) -> tuple[Array, Array]:
    near = log.t > LOST - 1.0
    return log.t[near] - LOST, y[near]


def _mean(
    quantity: str, paper: str, each: list[Any], band: Band | None = None, note: str = ""
) -> Row:
    return Row(quantity, paper, float(np.mean(each)), band, float(np.std(each)), note)


EXPERIMENTS = (
    Experiment(
        "000-9-managed",
        "From the ground to the ground: who stands switches off",
        "MRS Sec. 5.4, 7.3",
        landed,
    ),
    Experiment(
        "000-10-managed", "The state is lost, and the pilot sees it", "MRS Sec. 5.10, 7.2", lost
    ),
)
