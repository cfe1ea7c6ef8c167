"""000-misprints: three equations of MRS as they are printed, flown beside what they should be. Told, not judged."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from uavlab.experiments import circles
from uavlab.experiments.answers import answer
from uavlab.experiments.control_flights import (
    Altered,
    flown,
    law,
    printed_acceleration,
    printed_jerk,
)
from uavlab.experiments.disturbances import BLOWS, TOLD, as_printed
from uavlab.experiments.spec import Experiment, Line, Outcome, Panel, Row
from uavlab.flight.fill import fill
from uavlab.flight.fly import fly
from uavlab.flight.log import Log
from uavlab.flight.metrics import position_error
from uavlab.flight.scenario import Scenario, standing
from uavlab.gains import gains_for
from uavlab.interfaces import Stack
from uavlab.parts.bank import BankEstimator, chosen
from uavlab.parts.missions import Follow, Waypoints, still
from uavlab.parts.paths import circle
from uavlab.parts.trackers import CommandFilter
from uavlab.plant import load_airframe
from uavlab.sensors import Magnetometer, Rtk, carry, earth_field
from uavlab.sources import NORTH
from uavlab.types import GRAVITY, Array, Estimate

SOFT = "soft"
SLOW = 1.0  # [m/s], a circle that (26) as printed survives
JERK = np.array((1.09, -1.37, 0.0))  # [m/s³], the errata's example ...
SHARE = 10.79  # [m/s²] ... and its thrust per mass
HEIGHT = 5.0  # [m] of the hover
END, SETTLED = 12.0, 6.0  # [s] of the hover, and from when on it counts
LEVEL = Rtk(offset=np.zeros(3))  # a receiver that counts from where the flight does
HOVERER = "T650"
OTHERS = ("F450", HOVERER)  # whose a_d is told


def example() -> tuple[Array, Array]:
    """Body rates of (26) for the errata's example [rad/s], each (3,): corrected, and as printed."""
    force = np.array((0.0, 0.0, SHARE))
    right = answer("geometric", "jerk_feedforward")(force, 1.0, np.eye(3), JERK)
    return right, -(SHARE**2) * right


def with_jerk(printed: bool, speed: float) -> Log:
    """A circle, nose to its centre, at `speed` [m/s], with (26) as printed or corrected."""
    centre = np.array((0.0, 0.0, circles.HEIGHT))
    path = circle(centre, circles.RADIUS)
    mission = Follow(path, speed / circles.RADIUS, circles.RAMP, 0.0, centre)
    flight = circles.scenario(True, 5)._replace(mission=mission)
    controller: Any = law(TOLD, circles.GAINS[circles.FLIES])
    if printed:
        controller = Altered(controller, printed_jerk)
    return flown(flight, controller, plant=circles.plant())


def hovering(name: str, printed: bool, seed: int) -> Log:
    """A hover on a filter that is told a_d: (53) as printed, or corrected."""
    airframe = load_airframe(name)
    north = Magnetometer(field=earth_field(azimuth=NORTH))
    carried = carry("imu", "ahrs", "rangefinder", magnetometer=north, rtk=LEVEL)
    there = (0.0, 0.0, HEIGHT)
    flight = Scenario(
        "hover", "", name, Waypoints(((0.0, there, 0.0),)), standing(there), END, carried
    )
    controller: Any = law(float(airframe.m), gains_for(name, SOFT))
    if printed:
        controller = Altered(controller, printed_acceleration)
    estimator = fill(BankEstimator, setup=chosen("rtk")).part
    return fly(flight, Stack(estimator, CommandFilter(), controller), seed=seed)


def told(name: str, printed: bool) -> float:
    """What the estimator is told of the vertical acceleration in a hover at rest [m/s²]."""
    airframe = load_airframe(name)
    controller: Any = law(float(airframe.m), gains_for(name, SOFT))
    if printed:
        controller = Altered(controller, printed_acceleration)
    zero, there = np.zeros(3), np.array((0.0, 0.0, HEIGHT))
    rest = Estimate(there, zero, zero, np.eye(3), zero)
    memory = controller.init(rest, None)
    return float(controller.step(memory, rest, still(there), 0.01)[1].a_d[2])


class Off(NamedTuple):
    """What a hover was worth, in means after it settled."""

    climb: float  # [m/s] vertical velocity that is believed, less the true one
    height: float  # [m] believed less true
    error: float  # [m] true less wanted
    swing: float  # [m/s] largest vertical speed


OFF = (  # in words
    "climb believed less true [m/s]",
    "height believed less true [m]",
    "height less wanted [m]",
    "largest vertical speed [m/s]",
)


def off(log: Log) -> Off:
    """The vertical errors of one hover."""
    late = log.t >= SETTLED
    if not late.any():
        return Off(*[float("nan")] * 4)
    climb, height = (log.v_e - log.v)[late, 2], (log.r_e - log.r)[late, 2]
    return Off(
        float(climb.mean()), float(height.mean()), float(log.r[late, 2].mean() - HEIGHT),
        float(np.abs(log.v[late, 2]).max()),
    )  # fmt: skip


def run(seeds: int) -> Outcome:
    """Each misprint in flight."""
    jerky = {(p, v): with_jerk(p, v) for p in (True, False) for v in (circles.SPEED, SLOW)}
    heavy, mass = as_printed(TOLD, TOLD + 0.5, BLOWS, circles.GAINS[SOFT])
    hovers = {p: [hovering(HOVERER, p, s) for s in range(seeds)] for p in (True, False)}
    rows = (*_jerk_rows(jerky), *_mass_rows(heavy, mass), *_acceleration_rows(hovers))
    fast = jerky[True, circles.SPEED]
    remarks = (
        f"(26) as printed is −(‖f_d‖/m_e)² times what it should be. The circle at {circles.SPEED:g} m/s: "
        f"{fast.reason}. At {SLOW:g} m/s the attitude loop can still fight it.",
        f"(37) as printed, told {TOLD} kg of {TOLD + 0.5} kg, in a wind of 3 m/s: {heavy.reason}.",
        "(53) as printed takes g e3 where it should take m_e g e3, before dividing by m_e. The filter of lab 03, on a "
        "differential receiver, takes a_d as its input: it believes in a climb that is not there. The position "
        "corrects the height, nothing corrects the input, and the controller flies on that belief: it sinks first, and "
        "then swings up and down.",
        "No band: the paper prints no number that these could be held against.",
    )
    return Outcome(rows, _panels(jerky, heavy, mass, hovers), remarks)


def _jerk_rows(jerky: dict[tuple[bool, float], Log]) -> tuple[Row, ...]:
    right, printed = example()
    rows = [
        Row(f"(26), the errata's example, {what}, about {'xy'[i]} [rad/s]", "—", float(x[i]))
        for what, x in (("corrected", right), ("as printed", printed))
        for i in (0, 1)
    ]
    for (is_printed, speed), log in jerky.items():
        what = "as printed" if is_printed else "corrected"
        rows.append(
            Row(f"(26) {what}, circle at {speed:g} m/s: flown for [s]", "—", float(log.t[-1]))
        )
        late = log.t >= circles.RAMP
        if late.any():
            mean = float(position_error(log)[late].mean())
            rows.append(Row(f"(26) {what}, circle at {speed:g} m/s: position error [m]", "—", mean))
    return tuple(rows)


def _mass_rows(heavy: Log, mass: Array) -> tuple[Row, ...]:
    return (
        Row("(37) as printed, half a kilogram too heavy: flown for [s]", "—", float(heavy.t[-1])),
        Row("(37) as printed: mass at its end, of 4.0 kg [kg]", "—", float(mass[-1])),
    )


def _acceleration_rows(hovers: dict[bool, list[Log]]) -> tuple[Row, ...]:
    rows = []
    for printed in hovers:
        how = "as printed" if printed else "corrected"
        for name in OTHERS:
            m = float(load_airframe(name).m)
            note = f"g (1 − 1/m) = {GRAVITY * (1.0 - 1.0 / m):.2f} m/s²" if printed else ""
            what = f"(53) {how}, {name}: a_d of a hover, vertical [m/s²]"
            rows.append(Row(what, "—", told(name, printed), None, None, note))
    for printed, logs in hovers.items():
        what = f"(53) {'as printed' if printed else 'corrected'}, {HOVERER}"
        each = np.array([off(x) for x in logs])
        for i, said in enumerate(OFF):
            x = each[:, i]
            rows.append(Row(f"{what}: {said}", "—", float(x.mean()), None, float(x.std())))
    return tuple(rows)


def _panels(
    jerky: dict[tuple[bool, float], Log],
    heavy: Log,
    mass: Array,
    hovers: dict[bool, list[Log]],
) -> tuple[Panel, ...]:
    lost, kept = jerky[True, circles.SPEED], jerky[False, circles.SPEED]
    soon = kept.t < 2.0
    slow, quiet = jerky[True, SLOW], jerky[False, SLOW]
    n = slice(None, None, 10)
    hovered = hovers[True][0], hovers[False][0]
    return (
        Panel(f"(26): body rate about x that is commanded, {circles.SPEED:g} m/s", "time [s]", "rate [rad/s]", (
            Line("corrected", kept.t[soon], kept.omega_d[soon, 0]),
            Line("as printed", lost.t, lost.omega_d[:, 0]))),
        Panel(f"(26): position error at {SLOW:g} m/s", "time [s]", "error [m]", (
            Line("corrected", quiet.t[n], position_error(quiet)[n]),
            Line("as printed", slow.t[n], position_error(slow)[n]))),
        Panel("(37): height, half a kilogram too heavy", "time [s]", "height [m]", (
            Line("as printed", heavy.t, heavy.r[:, 2]),)),
        Panel("(37): mass", "time [s]", "mass [kg]", (
            Line("true", heavy.t[[0, -1]], np.full(2, TOLD + 0.5), "truth"), Line("as printed", heavy.t, mass))),
        Panel(f"(53): climb of the {HOVERER} that is believed", "time [s]", "vertical velocity [m/s]", (
            Line("as printed, believed", hovered[0].t, hovered[0].v_e[:, 2]),
            Line("as printed, true", hovered[0].t, hovered[0].v[:, 2], "dashed"),
            Line("corrected, believed", hovered[1].t, hovered[1].v_e[:, 2]))),
        Panel(f"(53): height of the {HOVERER}, {HEIGHT:g} m wanted", "time [s]", "height [m]", (
            Line("as printed, believed", hovered[0].t, hovered[0].r_e[:, 2]),
            Line("as printed, true", hovered[0].t, hovered[0].r[:, 2], "dashed"),
            Line("corrected, true", hovered[1].t, hovered[1].r[:, 2]))),
    )  # fmt: skip


EXPERIMENTS = (
    Experiment("000-misprints", "Three misprints in flight", "MRS eq. (26), (37), (53)", run),
)
