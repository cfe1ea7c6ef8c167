"""Flights with a safe pilot: from the ground to the ground, in an area, under orders."""

from __future__ import annotations

from functools import partial

import numpy as np

from uavlab.area import Area, NoFly
from uavlab.flight.fill import fill
from uavlab.flight.piloted import piloted
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import moved
from uavlab.interfaces import Stack
from uavlab.orders import In, Land, LandHome, TakeOff, Use
from uavlab.parts.bank import BankEstimator, chosen
from uavlab.parts.errands import Errand, Step
from uavlab.parts.missions import still
from uavlab.plant import CALM
from uavlab.scenarios.estimation import outdoors
from uavlab.sensors import Gnss, Outage, Rtk, Slam, carry, laboratory
from uavlab.types import Array, Reference, Shift


def _at(x: float, y: float, z: float, nose: float = 0.0) -> Reference:
    return still(np.array((x, y, z)), nose)


def _box(x0: float, y0: float, x1: float, y1: float) -> Array:
    """Corners (4, 2) [m] of a rectangle."""
    return np.array(((x0, y0), (x1, y0), (x1, y1), (x0, y1)))


# An errand --------------------------------------------------------------------------------------------


def safe_mind(airframe: str, area: Area | None = None) -> Stack:
    """The safe pilot with all its parts, on the stand-in estimator."""
    return piloted(airframe, area=area)


def errand() -> Scenario:
    """Take off, three goals around a tower, and land at home; a fourth goal lies in the tower, and is refused."""
    area = Area(
        _box(-4.0, -4.0, 12.0, 10.0), 0.5, 8.0, (NoFly(_box(3.0, 1.0, 6.0, 5.0), name="tower"),), 0.3
    )  # fmt: skip
    steps = (
        TakeOff(2.0), _at(9.0, 0.0, 2.0), _at(4.5, 3.0, 3.0), _at(9.0, 7.0, 4.0, 1.6),
        _at(0.0, 7.0, 3.0, 3.1), LandHome(),
    )  # fmt: skip
    return Scenario(
        "errand", "", "T650", Errand(steps, patience=12.0), standing((0, 0, 0)), 90.0, laboratory(),
        wind=CALM._replace(mean=np.array((1.0, 0.5, 0.0)), sigma=np.array((0.3, 0.3, 0.1))),
        mind=partial(safe_mind, area=area), area=area,
    )  # fmt: skip


# Outdoors → indoors -----------------------------------------------------------------------------------

BASE = np.array((1.5, -1.0, 0.8))  # [m] where the start lies for the differential receiver
MAP = Shift(np.array((-6.0, 4.0, 0.2)), 0.6)  # true world → that of the map, which knows the house
DOOR, SEES = 13.5, 8.0  # [s]: satellites are lost as it passes; the camera sees the house
DARK = Outage(21.0, 25.0)  # [s] in which it sees nothing it knows: optic flow carries on
LAND_AT = np.array((14.0, -2.5, 1.5))  # [m] above where it lands
HOUSE = (8.0, -6.0, 20.0, 6.0)  # [m] x, y of two corners, outside
THICK, WIDE, HIGH = 0.3, 1.2, 4.0  # [m]: walls, half of the door, height of the walls


def walls() -> tuple[NoFly, ...]:
    """Four walls, the first with a door in it."""
    x0, y0, x1, y1 = HOUSE
    boxes = {
        "west wall, right of the door": (x0, y0, x0 + THICK, -WIDE),
        "west wall, left of the door": (x0, WIDE, x0 + THICK, y1),
        "south wall": (x0, y0, x1, y0 + THICK),
        "north wall": (x0, y1 - THICK, x1, y1),
        "east wall": (x1 - THICK, y0, x1, y1),
    }
    return tuple(NoFly(_box(*box), high=HIGH, name=name) for name, box in boxes.items())


def on_bank(airframe: str, area: Area | None = None) -> Stack:
    """The safe pilot on a bank of filters: satellites, map and optic flow."""
    setup = chosen("rtk", "gnss", "slam", "flow", "flow+slam")
    estimator = fill(BankEstimator, setup=setup, requests=((0.0, "rtk"),))
    return piloted(airframe, estimator, area=area)


def outdoor_indoor_managed() -> Scenario:
    """Take off under the sky, fly through a door behind which no satellite is heard, and land inside, on a map."""
    area = Area(_box(-5.0, -9.0, 22.0, 9.0), 0.5, 6.0, walls(), 0.2)
    fast: tuple[Step, ...] = (Use("limits", "fast"), Use("gains", "tight"))
    steps = (
        TakeOff(2.0), *fast, *(In("rtk", _moved_by(x)) for x in (_at(3.0, 6.0, 3.0), _at(5.5, 0.0, 2.0))),
        *(In("slam", moved(x, MAP)) for x in (_at(11.0, 0.0, 2.0), _at(16.0, 3.0, 1.5), _at(*LAND_AT))),
        Land(),
    )  # fmt: skip
    lost = (Outage(DOOR, 1e9),)
    sensors = outdoors(
        gnss=Gnss(outages=lost), rtk=Rtk(offset=BASE, outages=lost), **carry("flow"),
        slam=Slam(world=MAP, outages=(Outage(0.0, SEES), DARK)),
    )  # fmt: skip
    return Scenario(
        "outdoor-indoor-managed", "", "T650", Errand(steps, patience=20.0), standing((0, 0, 0)),
        100.0, sensors, mind=partial(on_bank, area=area), area=area,
    )  # fmt: skip


def _moved_by(goal: Reference) -> Reference:
    """A goal as the differential receiver counts places."""
    return goal._replace(r=goal.r + BASE)
