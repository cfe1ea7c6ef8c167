"""000-9: a landing is seen by the thrust that it takes, soon after the ground carries, and never before."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from uavlab.experiments.answers import answer
from uavlab.experiments.control_flights import KNOWS, Knows, flown, law
from uavlab.experiments.spec import Band, Experiment, Line, Outcome, Panel, Row
from uavlab.flight.log import Log
from uavlab.flight.scenario import Scenario, standing
from uavlab.gains import gain_group, gains_for
from uavlab.parts.landoff import LandOff
from uavlab.parts.missions import Waypoints
from uavlab.parts.throttle import ThrustCurve
from uavlab.parts.touchdown import Touchdown
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import CompiledPlant, Wind, load_airframe
from uavlab.types import GRAVITY, Array, Command, Exit

NAME = "T650"
SE3, MPC = "SE(3)", "MPC"
SPEEDS = {SE3: 4.0, MPC: 0.5}  # [m/s] of errands: MPC as fast as a landing, because ...
FALLS = 1.5  # [m/s] ... behind this it falls
TOUCH = 0.002  # [m]: as near is on the ground (who touches it may still be carried a hair above it by his thrust)
END = 30.0  # [s]
KNOWN = Knows(0.02, 0.05)  # [m], [m/s]: white errors of position and velocity at each tick
SOON, NEVER = Band(2.0, 3.0), Band(0.0, 0.0)
REST = np.zeros(3)


class Landing(NamedTuple):
    """What a flight says of its end, and of what came before."""

    contact: float  # [s] first touch of the ground; inf: none
    disarm: float  # [s] when it was said to stand; inf: never
    vertical: float  # [m/s] at the touch, downwards
    light: float  # [s] longest time below half of the mass before the touch
    log: Log
    mass: Array  # (N,) apparent mass [kg]

    @property
    def after(self) -> float:
        """From touch to disarming [s]."""
        return self.disarm - self.contact


def detector(name: str = NAME) -> Touchdown:
    """For this airframe, with the share and the time of the software."""
    airframe = load_airframe(name)
    return Touchdown(float(airframe.m), ThrustCurve(airframe.a_t, airframe.b_t))


def watched(log: Log) -> Landing:
    """A flight, with a detector that listens to its commands."""
    part, dt = detector(log.meta["airframe"]), log.meta["dt"]
    memory, light, disarm = part.init(), np.zeros(len(log.t)), np.inf
    for k, f in enumerate(log.f_d):
        memory, stands = part.step(memory, Command(float(f), REST, REST), dt)
        light[k] = memory
        if stands and disarm == np.inf:
            disarm = float(log.t[k])
    touched = np.flatnonzero(log.r[:, 2] < TOUCH)
    k = int(touched[0]) if touched.size else len(log.t)
    mass = np.maximum(log.f_d, 0.0) / GRAVITY
    return Landing(
        float(log.t[k]) if touched.size else np.inf, disarm, -float(log.v[max(k - 1, 0), 2]),
        float(light[:k].max(initial=0.0)), log, mass,
    )  # fmt: skip


def controllers(told: float) -> dict[str, Callable[[], Any]]:
    """Who lands, told that it weighs so much [kg]."""
    mpc = answer("mpc", "MpcController")
    return {
        SE3: lambda: law(told, gains_for(NAME, "soft")),
        MPC: lambda: mpc(told),
    }


def landings(make: Callable[[], Any], seeds: int) -> list[Landing]:
    """Landings from everywhere, in gusts, with some load that nobody told of."""
    return [watched(landing(make(), seed)) for seed in range(seeds)]


def landing(controller: Any, seed: int, end: float = END) -> Log:
    """One landing: height, sideways motion, wind and load are drawn."""
    rng = np.random.default_rng(900 + seed)
    airframe = load_airframe(NAME)
    side = rng.uniform(-1.5, 1.5, 2)
    start = standing((0.0, 0.0, rng.uniform(1.0, 4.0)), rng.uniform(-3.0, 3.0))
    start = start._replace(v=np.array((*side, 0.0)))
    plant = CompiledPlant(airframe._replace(m=airframe.m + rng.uniform(-0.3, 0.3)))
    return flown(
        Scenario("landing", "", NAME, Waypoints(((0.0, (0.0, 0.0, 0.0), 0.0),)), start, end,
                 {KNOWS: KNOWN}, wind=_gusty(rng, 3.0)),
        controller, tracker=LandOff(), seed=seed, plant=plant,
    )  # fmt: skip


def errand(controller: Any, seed: int, speed: float, airframe: str = NAME) -> Log:
    """One flight that lands nowhere: up and down and aside at `speed` [m/s], in strong gusts."""
    rng = np.random.default_rng(1900 + seed)
    places = [(3.0 * k, tuple(rng.uniform((-8, -8, 3), (8, 8, 15)))) for k in range(10)]
    stops = tuple((t, (float(x), float(y), float(z)), 0.0) for t, (x, y, z) in places)
    scenario = Scenario(
        "errand", "", airframe, Waypoints(stops), standing((0.0, 0.0, 8.0)), END, {KNOWS: KNOWN},
        wind=_gusty(rng, 8.0),
    )  # fmt: skip
    return flown(scenario, controller, tracker=CommandFilter(v_max=speed), seed=seed)


def errands(make: Callable[[], Any], seeds: int, speed: float) -> list[Landing]:
    """Errands at this speed [m/s]."""
    return [watched(errand(make(), seed, speed)) for seed in range(seeds)]


def _gusty(rng: np.random.Generator, most: float) -> Wind:
    """Wind from anywhere, with gusts of a quarter of its speed."""
    speed, towards = rng.uniform(0.0, most), rng.uniform(-np.pi, np.pi)
    mean = speed * np.array((np.cos(towards), np.sin(towards), 0.0))
    return Wind(mean, np.full(3, 0.25 * speed))


def run(seeds: int) -> Outcome:
    """000-9."""
    told = float(load_airframe(NAME).m)
    make = controllers(told)
    landed = {name: landings(make[name], seeds) for name in make}
    away = {name: errands(make[name], seeds, SPEEDS[name]) for name in make}
    today = landings(lambda: law(told, gain_group("now", "soft")), seeds)
    hurried = errands(make[MPC], seeds, FALLS)
    rows = [row for name in make for row in _rows(name, landed[name], away[name])]
    rows += [
        _mean("SE(3), gains of today: disarmed after contact [s]", "—", [x.after for x in today]),
        Row(f"MPC behind a reference of {FALLS:g} m/s: errands that ended on the ground", "—",
            float(sum(x.log.exit is Exit.CRASH for x in hurried)), None, None,
            "it plans for a reference that stands (MRS eq. 44) and lags; the mass that it learns (eq. 37) swings until "
            "it falls"),
        Row("the same: said to stand while it fell", "—", float(sum(x.disarm < np.inf for x in hurried))),
    ]  # fmt: skip
    logs = [x.log for each in (*landed.values(), *away.values()) for x in each]
    ended = [x.exit.value for x in logs if x.exit is not Exit.DONE]
    remarks = (
        f"{NAME}, {END:g} s, reference of `LandOff`, detector of MRS (34): below half of the mass for 2 s. From 1 to "
        "4 m, sideways up to 1.5 m/s along each axis, wind up to 3 m/s with gusts of a quarter, true mass within "
        f"0.3 kg of what was told, errors of {KNOWN.r_noise:g} m and {KNOWN.v_noise:g} m/s at each tick.",
        "Who does not land flies to ten places within 16 by 16 by 12 m, one each 3 s, in wind of up to 8 m/s with "
        f"gusts, behind a reference of {SPEEDS[SE3]:g} m/s (SE(3)) or, because it falls behind a faster one, "
        f"{SPEEDS[MPC]:g} m/s (MPC). {len(ended)} of these landings and errands ended before "
        f"their time{': ' if ended else ''}{'; '.join(sorted(set(ended)))}.",
        "The reference goes 1 m below what stands, and the controller asks for less thrust: SE(3) for k_p · 1 m less "
        "at once, MPC for 2 m/s² less at most. What is missing to half of the weight, the mass must unlearn.",
    )
    return Outcome(tuple(rows), _panels(landed, away), remarks)


def _mean(quantity: str, paper: str, each: list[float], band: Band | None = None, note: str = "") -> Row:  # fmt: skip
    return Row(quantity, paper, float(np.mean(each)), band, float(np.std(each)), note)


def _rows(name: str, landed: list[Landing], away: list[Landing]) -> list[Row]:
    early = sum(x.disarm < x.contact for x in landed) + sum(x.disarm < np.inf for x in away)
    after = [x.after for x in landed]
    slow = (
        "MPC bounds the vertical acceleration it asks for at 2 m/s², a fifth of the weight; the rest must be unlearned "
        "from the mass, at k_m · 1 m each second"
    )
    note = slow if name == MPC else ""
    return [
        _mean(f"{name}: disarmed after contact [s]", "factor, time", after, SOON, note),
        Row(f"{name}: the same, soonest [s]", "—", min(after), SOON if name == SE3 else None),
        Row(f"{name}: the same, latest [s]", "—", max(after), SOON if name == SE3 else None),
        Row(f"{name}: disarmed in flight, of {len(landed)} landings and {len(away)} errands", "0",
            float(early), NEVER),
        Row(f"{name}: longest time below half of the mass in flight [s]", "—",
            max(x.light for x in [*landed, *away])),
        _mean(f"{name}: vertical speed at contact [m/s]", "—", [x.vertical for x in landed]),
    ]  # fmt: skip


def _panels(landed: dict[str, list[Landing]], away: dict[str, list[Landing]]) -> tuple[Panel, ...]:
    """The first landings from their touch on; every landing as a point; an errand."""
    m = detector().mass
    panels = []
    for title, y, of in (
        ("Height and reference", "height [m]", None),
        ("Apparent mass", "mass [kg]", "mass"),
    ):
        lines: list[Line] = []
        for name, each in landed.items():
            x = each[0]
            t, near = x.log.t - x.contact, np.abs(x.log.t - x.contact) < 8.0
            if of:
                lines.append(Line(name, t[near], x.mass[near]))
                continue
            lines += [
                Line(name, t[near], x.log.r[near, 2]),
                Line(f"{name}, reference", t[near], x.log.r_d[near, 2], "dashed"),
            ]
        if of:
            lines.append(
                Line("half of the mass", np.array((-8.0, 8.0)), np.full(2, m / 2), "truth")
            )
        panels.append(Panel(title, "time after contact [s]", y, tuple(lines)))
    points = tuple(
        Line(name, np.arange(len(each), dtype=float), np.array([x.after for x in each]), "points")
        for name, each in landed.items()
    )
    errands = tuple(Line(name, x[0].log.t, x[0].mass) for name, x in away.items())
    half = Line("half of the mass", np.array((0.0, END)), np.full(2, m / 2), "truth")
    return (
        *panels,
        Panel("Disarmed after contact", "seed", "time [s]", points),
        Panel("Apparent mass on an errand", "time [s]", "mass [kg]", (*errands, half)),
    )


EXPERIMENTS = (
    Experiment("000-9", "When it stands, it is seen to stand", "MRS Sec. 4.2, 5.4, eq. (34)", run),
)
