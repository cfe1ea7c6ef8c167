"""Where a scenario may begin: within its safety area."""

import numpy as np
import pytest

from uavlab.area import Area, NoFly
from uavlab.errors import BadInput
from uavlab.flight.fly import fly
from uavlab.flight.scenario import checked, standing
from uavlab.scenarios import load

SQUARE = ((-5, -5), (5, -5), (5, 5), (-5, 5))
TOWER = NoFly(((2, 2), (4, 2), (4, 4), (2, 4)), 0.0, 9.0, "tower")
AREA = Area(SQUARE, 1.0, 10.0, (TOWER,))


@pytest.mark.parametrize(
    ("start", "said"),
    [
        (
            (7, 0, 2),
            r"where it starts: the place, \(7.0, 0.0, 2.0\) m, lies 2.0 m outside .*; or move the area",
        ),
        ((7, 0, 0), r"lies 2.0 m outside the border"),
        ((0, 0, 11), r"lies 1.0 m above the safety area; keep to 10 m or less"),
        ((0, 0, 0.5), r"lies 0.5 m below the safety area; keep to 1 m or more"),
        ((3, 3, 2), r"lies in the no-fly zone 'tower'"),
        ((3, 3, 0), r"lies in the no-fly zone 'tower'"),
    ],
)
def test_a_flight_that_would_start_outside_its_area_is_refused(start, said):
    with pytest.raises(BadInput, match=r"scenario 'hover': .*" + said):
        checked(load("hover")._replace(area=AREA, start=standing(start)))


@pytest.mark.parametrize("start", [(0, 0, 2), (0, 0, 0), (5, 5, 10), (3, 3, 9.5)])
def test_a_flight_may_start_on_the_ground_or_anywhere_within(start):
    checked(load("hover")._replace(area=AREA, start=standing(start)))


def test_an_area_that_is_told_in_another_world_says_nothing_of_the_start():
    elsewhere = Area(np.add(SQUARE, 100.0), 1.0, 10.0, world="gnss")
    checked(load("hover")._replace(area=elsewhere))


def test_what_is_no_area_is_refused():
    with pytest.raises(BadInput, match=r"area is .*; it must be a uavlab.area.Area, or None"):
        checked(load("hover")._replace(area=SQUARE))  # type: ignore[arg-type]


def test_a_log_tells_the_area():
    log = fly(load("hover")._replace(area=AREA, duration=0.1))
    assert log.meta["area"] == AREA.told()
