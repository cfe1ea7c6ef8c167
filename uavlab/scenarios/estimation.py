"""Flights on which the world of the estimator changes: differential corrections come and go, satellites are lost."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from uavlab.flight.fill import fill, stack
from uavlab.flight.scenario import Scenario, standing
from uavlab.interfaces import Stack
from uavlab.parts.bank import BankEstimator, Setup, chosen, fused
from uavlab.parts.controllers import HeadingController
from uavlab.parts.missions import Waypoints
from uavlab.sensors import Gnss, Magnetometer, Outage, Rtk, Slam, carry, earth_field
from uavlab.sources import NORTH

CORRECTED = 6.0  # [s], when corrections arrive or are lost
SWITCH = 8.0  # [s], when the mission asks for the differential receiver


def bank_mind(setup: Setup, requests: tuple[tuple[float, str], ...] = ()) -> Callable[[str], Stack]:
    """A mind that flies on a bank of filters: references if they are installed, else stand-ins.

    Parameters
    ----------
    setup : Setup
        The filters.
    requests : tuple of (time [s], name)
        Which filter the mission asks for, and when.

    Returns
    -------
    callable
        Airframe → stack, for the field ``mind`` of a scenario.
    """

    def mind(airframe: str) -> Stack:
        estimator = fill(BankEstimator, setup=setup, requests=requests)
        return stack(airframe, estimator, HeadingController)

    return mind


def naive_mind(setup: Setup) -> Callable[[str], Stack]:
    """The same data in one filter: what MRS Sec. 3.5 warns of."""
    return bank_mind(fused(setup))


def outdoors(**instruments: Any) -> dict[str, Any]:
    """What an aircraft carries under open sky, with north along y, where the filters look for it."""
    north = Magnetometer(field=earth_field(azimuth=NORTH))
    return carry("imu", "ahrs", "rangefinder", **{"magnetometer": north, **instruments})


def gnss_to_rtk() -> Scenario:
    """Hover on a satellite receiver; differential corrections arrive at 6 s, metres away, and are asked for at 8 s."""
    rtk = Rtk(corrections_lost=(Outage(0.0, CORRECTED),), refix=0.0)
    return Scenario(
        "gnss-to-rtk", "", "F450", Waypoints(((0.0, (0.0, 0.0, 3.0), 0.0),)),
        standing((0, 0, 3)), 14.0, outdoors(gnss=Gnss(), rtk=rtk),
        mind=bank_mind(chosen("gnss", "rtk"), ((0.0, "gnss"), (SWITCH, "rtk"))),
    )  # fmt: skip


def rtk_lost() -> Scenario:
    """Hover on a differential receiver whose corrections are lost at 6 s, and fixed again at 12 s."""
    rtk = Rtk(corrections_lost=(Outage(CORRECTED, CORRECTED + 4.0),), refix=2.0)
    return gnss_to_rtk()._replace(
        name="rtk-lost",
        duration=18.0,
        sensors=outdoors(gnss=Gnss(), rtk=rtk),
        mind=bank_mind(chosen("gnss", "rtk"), ((0.0, "rtk"),)),
    )


def outdoor_indoor() -> Scenario:
    """Through a door: satellites are lost, a map and optic flow take over; the goals stay what they were."""
    return through_a_door(10.0)


def through_a_door(door: float) -> Scenario:
    """The flight of `outdoor_indoor` with satellites lost at `door` [s], and all else in proportion."""
    stops = (
        (0.0, (0.0, 0.0, 2.0), 0.0),
        (0.3 * door, (0.6 * door, 0.0, 2.0), 0.0),
        (door, (1.2 * door, 0.0, 2.0), 0.0),
        (1.6 * door, (1.2 * door, 0.4 * door, 2.0), 0.0),
    )
    gnss = Gnss(outages=(Outage(door, 1e9),))
    slam = Slam(outages=(Outage(0.0, 0.7 * door),))  # too far from walls before
    return Scenario(
        "outdoor-indoor", "", "F450", Waypoints(stops), standing((0, 0, 2)), 2.4 * door,
        outdoors(gnss=gnss, slam=slam, **carry("flow")),
        mind=bank_mind(chosen("gnss", "slam", "flow", "flow+slam"), ((0.0, "gnss"),)),
    )  # fmt: skip
