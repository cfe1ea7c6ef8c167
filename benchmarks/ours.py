"""Our side of the same work."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.peers import RADIUS, SPEED, circle_reference
from uavlab import fly, scenarios, standing
from uavlab.interfaces import Controller, standing_command
from uavlab.parts.controllers import TiltAxis
from uavlab.plant import CompiledPlant, load_airframe
from uavlab.types import Estimate


def whole() -> Callable[[float], float]:
    """The whole flight as a user flies it: sensors, estimator, tracker, controller at 100 Hz, log."""
    circle = scenarios.load("circle")

    def run(seconds: float) -> float:
        log = fly(circle._replace(duration=seconds))
        return float(np.linalg.norm(log.r[-1] - log.r_d[-1]))

    return run


def lean(
    physics: float = 1000.0, part: Controller | None = None, speed: float = SPEED
) -> Callable[[float], float]:
    """The shortest loop: a controller at 100 Hz on the true state, compiled plant.

    Parameters
    ----------
    physics : float
        Rate of the plant [Hz].
    part : Controller, optional
        Who flies; the numpy SE(3)-type stand-in without.
    speed : float
        On the circle [m/s].
    """
    a = load_airframe("T650")
    plant, reference_at = CompiledPlant(a), circle_reference(speed)
    part = part or TiltAxis(a.m)
    n, still = round(physics / 100), np.zeros(3)

    def run(seconds: float) -> float:
        world = plant.init(standing((RADIUS, 0, 3))._replace(v=np.array([0, speed, 0])))
        memory = part.init(Estimate(world.r, world.v, world.a, world.R, world.omega), None)
        for k in range(round(seconds * 100)):
            reference = reference_at(k / 100)
            here = Estimate(world.r, world.v, world.a, world.R, world.omega)
            memory, command = part.step(memory, here, reference, 0.01)
            world = plant.advance(world, command, still, 0.01, n)
        return float(np.linalg.norm(world.r - reference.r))

    return run


def plant_alone() -> Callable[[float], float]:
    """The compiled plant under a constant command: what is left when no mind is at work."""
    a = load_airframe("T650")
    plant, command, still = CompiledPlant(a), standing_command(a.m), np.zeros(3)

    def run(seconds: float) -> float:
        world = plant.init(standing((0, 0, 3)))
        for _ in range(round(seconds * 100)):
            world = plant.advance(world, command, still, 0.01, 10)
        return abs(float(world.r[2]) - 3.0)

    return run
