"""The world that flies: airframes, motors, rigid body, ground and air. Numba starts when a plant is made."""

from uavlab.plant.airframe import Airframe, build_airframe
from uavlab.plant.compiled import CompiledPlant
from uavlab.plant.load import airframe_names, load_airframe
from uavlab.plant.readable import ReadablePlant
from uavlab.plant.wind import CALM, Wind, gusts
from uavlab.plant.world import World, thrusts

__all__ = [
    "CALM",
    "Airframe",
    "CompiledPlant",
    "ReadablePlant",
    "Wind",
    "World",
    "airframe_names",
    "build_airframe",
    "gusts",
    "load_airframe",
    "thrusts",
]
