"""Obstacles: who flies into one has crashed, who passes by has not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import floats

from uavlab.errors import BadInput
from uavlab.flight.fly import fly
from uavlab.flight.scenario import Scenario, checked, standing
from uavlab.parts.missions import Waypoints
from uavlab.plant import load_airframe
from uavlab.plant.obstacles import Obstacle, checked_obstacles, hit
from uavlab.scenarios import load
from uavlab.types import Exit

TREE = Obstacle(1.0, 2.0, 0.5, 4.0)
ARM = float(load_airframe("F450").arm)


@pytest.mark.parametrize(
    ("r", "told"),
    [
        ((1.0, 2.0, 1.0), TREE),  # within it
        ((1.0, 2.79, 1.0), TREE),
        ((1.0, 2.81, 1.0), None),  # beside it
        ((1.0, 2.0, 4.29), TREE),
        ((1.0, 2.0, 4.31), None),  # above it
        (
            (1.0, 2.75, 4.2),
            None,
        ),  # past its edge, where a corner would be hit: hypot(0.25, 0.2) > 0.3
        ((1.0, 2.75, 4.1), TREE),
        ((np.nan, 2.0, 1.0), None),
    ],
)
def test_a_ball_hits_what_is_nearer_than_its_radius(r, told):
    assert hit((Obstacle(9.0, 9.0, 0.5, 4.0), TREE), np.array(r), 0.3) is told


@given(st.tuples(floats(-3, 3), floats(-3, 3), floats(0, 5)).map(np.array), floats(0.01, 1.0))
def test_a_hit_is_a_point_of_the_obstacle_within_the_ball(r, radius):
    """Held against points on the surface and within: rings of the cylinder, no closed form."""
    turn = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    far, up = np.meshgrid(np.linspace(0.0, TREE.radius, 20), np.linspace(0.0, TREE.height, 81))
    ring = np.stack([np.cos(turn), np.sin(turn)])
    x = TREE.x + np.multiply.outer(far, ring[0]) - r[0]
    y = TREE.y + np.multiply.outer(far, ring[1]) - r[1]
    nearest = float(np.sqrt(x**2 + y**2 + (up[..., None] - r[2]) ** 2).min())
    if nearest < radius:
        assert hit((TREE,), r, radius) is TREE
    elif nearest > radius + 0.06:  # the points are a few centimetres apart
        assert hit((TREE,), r, radius) is None


def _past(aside: float) -> Scenario:
    """Six metres ahead at two metres height, past a pole at half way."""
    stops = ((0.0, (0.0, 0.0, 2.0), 0.0), (0.5, (6.0, 0.0, 2.0), 0.0))
    hover = load("hover")
    return hover._replace(
        mission=Waypoints(stops), duration=8.0, obstacles=(Obstacle(3.0, aside, 0.3, 5.0),)
    )


def test_who_flies_into_an_obstacle_has_crashed_there():
    log = fly(_past(0.0))
    assert log.exit is Exit.CRASH
    assert log.reason.startswith("hit an obstacle at (3, 0) m, 0.3 m thick, 5 m high, at t = ")
    ahead = 3.0 - 0.3 - ARM
    assert ahead < log.r[-1][0] < ahead + 0.1  # it touches, and no tick later
    assert not log.exit.good
    assert log.meta["obstacles"] == [[3.0, 0.0, 0.3, 5.0]]


def test_who_passes_beside_it_flies_on():
    assert fly(_past(1.2)).exit is Exit.DONE


@pytest.mark.parametrize(
    ("obstacle", "said"),
    [
        (Obstacle(np.nan, 0.0, 1.0, 2.0), r"obstacles\[1\]: x is nan m; it must be finite"),
        (Obstacle(0.0, 0.0, 0.0, 2.0), r"obstacles\[1\]: radius is 0.0 m; it must be > 0"),
        (Obstacle(0.0, 0.0, 1.0, -2.0), r"obstacles\[1\]: height is -2.0 m; it must be > 0"),
        ((0.0, 0.0, 1.0, 2.0), r"obstacles\[1\] is \(0.0, .*; it must be an Obstacle"),
    ],
)
def test_what_cannot_stand_is_refused_by_field_and_value(obstacle, said):
    with pytest.raises(BadInput, match=said):
        checked_obstacles((TREE, obstacle))
    with pytest.raises(BadInput, match=r"scenario 'hover': " + said):
        checked(load("hover")._replace(obstacles=(TREE, obstacle)))


def test_nobody_starts_in_an_obstacle():
    scenario = load("hover")._replace(start=standing((1.0, 2.6, 1.0)), obstacles=(TREE,))
    with pytest.raises(
        BadInput, match=r"less than the arm of 0.2.* m from the obstacle at \(1, 2\) m"
    ):
        checked(scenario)
    checked(scenario._replace(start=standing((1.0, 2.8, 1.0))))
