"""Named flights, shared by labs, tests, grader and book."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import pi
from typing import Any

import numpy as np

from uavlab.errors import UnknownName
from uavlab.flight.scenario import Scenario, standing
from uavlab.parts.missions import Follow, Waypoints
from uavlab.parts.paths import circle as circle_path
from uavlab.parts.paths import lemniscate as eight
from uavlab.plant import CALM
from uavlab.scenarios.estimation import gnss_to_rtk, outdoor_indoor, rtk_lost
from uavlab.scenarios.files import load_file
from uavlab.scenarios.managed import errand, outdoor_indoor_managed
from uavlab.sensors import Gnss, ImuSensor, Mocap

__all__ = ["Scenario", "load", "load_file", "names", "standing"]


def _laboratory() -> dict[str, Any]:
    """What an aircraft carries indoors."""
    return {"imu": ImuSensor(), "mocap": Mocap()}


def hover() -> Scenario:
    """Stand still two metres above the ground."""
    mission = Waypoints(((0.0, (0.0, 0.0, 2.0), 0.0),))
    return Scenario("hover", "", "F450", mission, standing((0, 0, 2)), 10.0, _laboratory())


def takeoff() -> Scenario:
    """From standing on the ground to two metres above it, and back down."""
    stops = ((0.0, (0.0, 0.0, 2.0), 0.0), (6.0, (0.0, 0.0, 0.0), 0.0))
    return Scenario(
        "takeoff", "", "F450", Waypoints(stops), standing((0, 0, 0)), 12.0, _laboratory()
    )


def step() -> Scenario:
    """Five metres to the side, up, and a quarter turn."""
    stops = ((0.0, (0.0, 0.0, 2.0), 0.0), (1.0, (5.0, 3.0, 4.0), pi / 2))
    return Scenario("step", "", "T650", Waypoints(stops), standing((0, 0, 2)), 10.0, _laboratory())


def circle() -> Scenario:
    """MRS Figs 9 and 10: a circle of 5 m at 7 m/s, with the nose along x all the time."""
    mission = Follow(circle_path(np.array([0.0, 0.0, 3.0]), 5.0), rate=7.0 / 5.0, ramp=5.0)
    return Scenario("circle", "", "T650", mission, standing((5, 0, 3)), 25.0, _laboratory())


def circle_facing() -> Scenario:
    """The same circle, with the nose to its centre."""
    calm = circle()
    mission = replace(calm.mission, face=np.zeros(3))  # type: ignore[type-var]
    return calm._replace(name="circle-facing", mission=mission, start=standing((5, 0, 3), pi))


def lemniscate() -> Scenario:
    """A figure of eight that climbs and sinks, Spica Fig. 4 enlarged."""
    mission = Follow(eight(np.array([0.0, 0.0, 3.0]), 8.0, 4.0, 0.5), rate=2 * pi / 8, ramp=4.0)
    return Scenario("lemniscate", "", "X500", mission, standing((0, 0, 3.5)), 24.0, _laboratory())


def gnss() -> Scenario:
    """Hover outdoors: a satellite receiver beside the cameras, and gusts."""
    calm = hover()
    wind = CALM._replace(mean=np.array([3.0, 0.0, 0.0]), sigma=np.array([0.8, 0.8, 0.4]))
    return calm._replace(name="gusts", sensors={**calm.sensors, "gnss": Gnss()}, wind=wind)


_ALL: dict[str, Callable[[], Scenario]] = {
    "hover": hover,
    "takeoff": takeoff,
    "step": step,
    "circle": circle,
    "circle-facing": circle_facing,
    "lemniscate": lemniscate,
    "gusts": gnss,
    "gnss-to-rtk": gnss_to_rtk,
    "rtk-lost": rtk_lost,
    "outdoor-indoor": outdoor_indoor,
    "errand": errand,
    "outdoor-indoor-managed": outdoor_indoor_managed,
}


def names() -> list[str]:
    """The scenarios that there are."""
    return list(_ALL)


def load(name: str) -> Scenario:
    """The scenario with this name, or from the file with this path if it ends in ``.toml``.

    Raises
    ------
    UnknownName
        There is none; the message says which there are.
    BadFile, BadInput
        The file cannot be read, or says what cannot be flown.
    """
    if name.endswith(".toml"):
        return load_file(name)
    if name not in _ALL:
        raise UnknownName("scenario", name, _ALL)
    make = _ALL[name]
    summary = " ".join(str(make.__doc__).split())
    return make()._replace(summary=summary)
