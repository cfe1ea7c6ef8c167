"""The loop: sample, estimate, track, control, log, advance. A flight that ends badly ends with a value."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from math import isfinite
from time import perf_counter
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np

from uavlab.flight.damage import breakable
from uavlab.flight.fault import told as faults_told
from uavlab.flight.fill import Filled, stack
from uavlab.flight.injected import Injected
from uavlab.flight.log import Log
from uavlab.flight.mind import Mind
from uavlab.flight.recorder import Recorder
from uavlab.flight.scenario import SWAPPED, Scenario, checked
from uavlab.flight.slot import swappable
from uavlab.interfaces import Report, Stack
from uavlab.plant import CompiledPlant, gusts, load_airframe
from uavlab.plant.obstacles import hit
from uavlab.types import Command, Exit

HARD_IMPACT = 3.0  # [m/s], what landing feet bear


class Ending(NamedTuple):
    """How a flight ended."""

    exit: Exit
    reason: str
    traceback: str = ""


def fly(
    scenario: Scenario,
    mind: Stack | None = None,
    *,
    seed: int = 0,
    plant: Any = None,
    progress: Callable[[float, float], None] | None = None,
) -> Log:
    """Fly a scenario and return its log.

    Parameters
    ----------
    scenario : Scenario
        From `uavlab.scenarios.load`, or your own.
    mind : Stack, optional
        From `uavlab.stack`; what the scenario names if there is none, else the stand-ins.
    seed : int
        Of gusts and sensors. Same seed, same log.
    plant : part or Filled, optional
        A world of your own, with the interface of `uavlab.plant.CompiledPlant`.
    progress : callable, optional
        Called about once a simulated second with the time flown and the whole time [s].

    Returns
    -------
    Log
        ``log.exit`` and ``log.reason`` say how it ended. What a part raises in flight ends the flight
        with ``Exit.ERROR`` and stands in ``log.meta["traceback"]``.

    Raises
    ------
    BadInput, UnknownName
        The scenario cannot be flown, names an airframe that is not there, or swaps parts that the mind has not.
    NotImplementedError
        A part calls an exercise that is not finished.
    """
    checked(scenario)
    airframe = load_airframe(scenario.airframe)
    mind = mind or (scenario.mind or stack)(scenario.airframe)
    swappable(scenario, mind)
    provenance = dict(mind.provenance)
    if isinstance(plant, Filled):
        provenance |= plant.provenance
        plant = plant.part
    world_of = plant or CompiledPlant(airframe)
    breakable(scenario, world_of)

    ticks = round(scenario.duration * scenario.rate)
    faults = Injected(scenario.faults, airframe)
    at_work = Mind(mind, scenario, float(airframe.m), faults)
    record = Recorder(ticks, airframe, tuple(at_work.hypotheses()))
    say = progress or (lambda _t, _end: None)
    ending = _run(scenario, at_work, world_of, seed, record, say)
    meta = {
        "scenario": scenario.name,
        "summary": scenario.summary,
        "airframe": airframe.name,
        "arm": float(airframe.arm),
        "angles": np.asarray(airframe.angles).tolist(),
        "spins": np.asarray(airframe.spins).tolist(),
        "mass": float(airframe.m),
        "thrust_max": float(airframe.thrust_max),
        "seed": seed,
        "dt": 1.0 / scenario.rate,
        "duration": scenario.duration,
        "provenance": provenance,
        "traceback": ending.traceback,
    }
    meta |= _told(at_work.report(), scenario)
    return record.log(ending.exit, ending.reason, meta)


def _run(
    scenario: Scenario,
    mind: Mind,
    world_of: Any,
    seed: int,
    record: Recorder,
    progress: Callable[[float, float], None],
) -> Ending:
    dt = 1.0 / scenario.rate
    inner = round(scenario.physics / scenario.rate)
    second = max(round(scenario.rate), 1)
    try:
        world = world_of.init(scenario.start)
        sensors = _Sensors(scenario, seed)
        air = gusts(scenario.wind, _generator(seed, "wind"), dt)
        faults = mind.faults
        for tick in range(len(record)):
            t = tick * dt
            mind.doing, wind = "sensor", faults.wind(next(air), t)
            readings = faults.readings(sensors.sample(world, dt), t)
            start = perf_counter()
            with faults.solving(t):
                estimate, reference, command = mind.think(tick, readings, dt)
            solve = perf_counter() - start
            record.write(tick, world, wind, estimate, reference, command, solve)
            record.believe(tick, estimate, mind.hypotheses())
            bad = _bad_end(world, command, scenario, float(record.airframe.arm))
            if end := bad or _good_end(world, mind.report()):
                return end
            mind.doing = "plant"
            world = faults.advance(world_of, world, command, wind, dt, inner)
            if tick % second == 0:
                progress(tick * dt, scenario.duration)
    except NotImplementedError:
        raise
    except Exception as error:  # whatever a part raises is how this flight ended
        who = [*getattr(error, "__notes__", []), mind.doing][0]
        why = f"the {who} raised {type(error).__name__} at t = {record.time:.2f} s: {error}"
        return Ending(Exit.ERROR, why, traceback.format_exc())
    progress(scenario.duration, scenario.duration)
    return Ending(Exit.DONE, f"{Exit.DONE.value}, {scenario.duration:g} s")


def _told(report: Report, scenario: Scenario) -> dict[str, Any]:
    """What a pilot did, and where it could not go, for a log."""
    told: dict[str, Any] = {}
    if report.events:
        told["events"] = [list(event) for event in report.events]
        swaps = [list(x) for x in report.events if x.kind in SWAPPED]
        told |= {"swaps": swaps} if swaps else {}
    if scenario.faults:
        told["faults"] = faults_told(scenario.faults, scenario.duration)
    if scenario.area is not None:
        told["area"] = scenario.area.told()
    if scenario.obstacles:
        told["obstacles"] = [list(x) for x in scenario.obstacles]
    return told


def _good_end(world: Any, report: Report) -> Ending | None:
    """Whether the aircraft stands, and its pilot has switched the motors off."""
    if not (report.over and world.contact):
        return None
    exit_ = Exit.LANDED if report.over == "landed" else Exit.FAILSAFE
    x, y, _ = world.r
    return Ending(exit_, f"{exit_.value} at t = {world.t:.2f} s, at ({x:.1f}, {y:.1f}) m")


def _bad_end(world: Any, command: Command, scenario: Scenario, arm: float) -> Ending | None:
    """Whether the flight is over, and why."""
    w, r, r0 = command.omega_d, world.r, scenario.start.r
    x, y, z = r[0] - r0[0], r[1] - r0[1], r[2] - r0[2]
    away = x * x + y * y + z * z
    if not isfinite(command.f_d + w[0] + w[1] + w[2]):
        exit_, said = Exit.NAN, f"the controller asked for {command.f_d} N and {w} rad/s"
    elif not isfinite(away):
        exit_, said = Exit.NAN, f"the position is {r}"
    elif world.impact > HARD_IMPACT:
        exit_, said = Exit.CRASH, f"hit the ground at {world.impact:.1f} m/s"
    elif it := hit(scenario.obstacles, r, arm):
        where = f"({it.x:g}, {it.y:g}) m, {it.radius:g} m thick, {it.height:g} m high,"
        exit_, said = Exit.CRASH, f"hit an obstacle at {where}"
    elif world.R[2, 2] < 0.0:
        exit_, said = Exit.TILT, "tilted past 90 degrees"
    elif away > scenario.reach**2:
        exit_, said = Exit.AWAY, f"farther than {scenario.reach:g} m from the start"
    else:
        return None
    return Ending(
        exit_, f"{said} at t = {world.t:.2f} s, at ({r[0]:.1f}, {r[1]:.1f}, {r[2]:.1f}) m"
    )


def _generator(seed: int, name: str) -> np.random.Generator:
    """One generator for each source of chance, by name: adding one does not change the others."""
    return np.random.default_rng([seed, crc32(name.encode())])


class _Sensors:
    """The instruments aboard, each with its own memory and generator."""

    def __init__(self, scenario: Scenario, seed: int) -> None:
        self.of = {  # some look at what stands in the way
            name: sensor._replace(obstacles=scenario.obstacles)
            if hasattr(sensor, "obstacles")
            else sensor
            for name, sensor in scenario.sensors.items()
        }
        self.rng = {name: _generator(seed, name) for name in self.of}
        self.memory = {name: sensor.init(self.rng[name]) for name, sensor in self.of.items()}

    def sample(self, world: Any, dt: float) -> dict[str, Any]:
        """What arrives in this tick, by instrument."""
        arrived = {}
        for name, sensor in self.of.items():
            self.memory[name], reading = sensor.step(self.memory[name], world, dt, self.rng[name])
            if reading is not None:
                arrived[name] = reading
        return arrived
