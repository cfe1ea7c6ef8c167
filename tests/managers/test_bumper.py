"""The bumper flies straight away from what is near, as far as it must, and nowhere that is forbidden."""

from math import inf, nan, pi

import numpy as np
import pytest

from uavlab.errors import BadInput
from uavlab.frames import Shift, moved
from uavlab.limits import limit_group
from uavlab.managers.bumper import FREE, Bumper, bumped, checked, spaced
from uavlab.so3 import about_z
from uavlab.types import Estimate, Sectors

ZERO = np.zeros(3)
ETA = 0.7
HERE = Estimate(np.array((4.0, -2.0, 3.0)), ZERO, ZERO, about_z(ETA), ZERO)


def seen(near=(), n=8, down=3.0, up=inf):
    """Sectors in which these distances (sector, metres) are seen, and nothing else."""
    d = np.full(n, inf)
    for i, x in near:
        d[i] = x
    return Sectors(0.0, d, down, up)


USUAL = Bumper()


def way(*given, bumper=USUAL, **sectors):
    """The way that the bumper goes (3,), or None."""
    goal = bumped(bumper, seen(given, **sectors), HERE).goal
    return None if goal is None else goal.r - HERE.r


def test_where_nothing_is_near_nothing_is_asked():
    assert bumped(Bumper(), seen(), HERE) == FREE
    assert bumped(Bumper(), seen([(3, 1.21)]), HERE) == FREE
    assert bumped(Bumper(), seen([(3, 1.2)]), HERE) == FREE


@pytest.mark.parametrize("n", [2, 5, 8, 12])
def test_it_flies_straight_away_from_the_nearest_sector_a_little_farther_than_needed(n):
    for i in range(n):
        angle = ETA + 2.0 * pi * i / n
        there = np.array((np.cos(angle), np.sin(angle), 0.0)) * 0.9
        move = way((i, 0.9), ((i + 1) % n, 30.0), n=n)
        np.testing.assert_allclose(move, -there / 0.9 * (1.2 + 0.2 - 0.9), atol=1e-12)
        assert np.linalg.norm(there - move) == pytest.approx(1.4)


def test_the_place_that_it_asks_for_is_one_to_stand_at_with_the_nose_where_it_is():
    goal = bumped(Bumper(), seen([(0, 1.0)]), HERE).goal
    assert goal.heading == pytest.approx(ETA)
    assert not np.any((goal.v, goal.a, goal.j))
    assert goal.heading_rate == 0.0


def test_it_says_what_is_near_where_and_how_near_it_may_be():
    assert "1.05 m away, ahead; bound 1.2 m" in bumped(Bumper(), seen([(0, 1.05)]), HERE).said
    assert "45° to the left" in bumped(Bumper(), seen([(1, 1.05)]), HERE).said
    assert "90° to the right" in bumped(Bumper(), seen([(6, 1.05)]), HERE).said


@pytest.mark.parametrize("n", [8, 7])
def test_between_two_walls_it_goes_half_way_and_no_farther(n):
    move = way((0, 0.4), (n // 2, 1.0), n=n)
    assert np.linalg.norm(move) == pytest.approx(0.3)
    assert np.linalg.norm(way((0, 0.7), (n // 2, 0.7), n=n)) == 0.0


def test_too_low_it_climbs_and_under_something_it_sinks():
    np.testing.assert_allclose(way(down=0.3), (0.0, 0.0, 0.4))
    np.testing.assert_allclose(way(up=0.9), (0.0, 0.0, -0.5))
    np.testing.assert_allclose(way(up=0.3, down=0.4), (0.0, 0.0, -0.05))  # half of what is there
    assert way(down=0.51) is None
    assert way(up=1.21) is None
    move = way((0, 1.0), down=0.3)
    assert move[2] == pytest.approx(0.4)
    assert np.hypot(*move[:2]) == pytest.approx(0.4)


def test_a_bumper_of_no_distance_does_not_look_there():
    assert way((0, 0.0), down=0.0, up=0.0, bumper=Bumper(0.0, 0.0, 0.0)) is None


def test_a_place_that_is_forbidden_is_not_flown_to():
    asked = []

    def why_not(goal):
        asked.append(goal.r)
        return "it lies outside of the area"

    bump = bumped(Bumper(), seen([(0, 1.0)]), HERE, why_not)
    np.testing.assert_array_equal(bump.goal.r, HERE.r)
    assert "it stays, for it lies outside of the area" in bump.said
    assert np.linalg.norm(asked[0] - HERE.r) == pytest.approx(0.4)


def test_a_distance_that_is_no_number_is_none():
    assert way((0, nan), (2, 1.0)) is not None
    assert way((0, nan), down=nan, up=nan) is None


def test_it_is_the_same_way_in_every_world():
    shift = Shift(np.array((3.0, -2.0, 0.5)), 2.0)
    sectors = seen([(1, 0.8)], down=0.2)
    here, there = (bumped(Bumper(), sectors, x).goal for x in (HERE, moved(HERE, shift)))
    np.testing.assert_allclose(np.hstack(moved(here, shift)), np.hstack(there), atol=1e-12)


@pytest.mark.parametrize(("group", "around"), [("slow", 1.95), ("medium", 7.2), ("fast", 13.2)])
def test_its_distance_grows_with_the_way_to_stop_of_the_limits(group, around):
    flat = limit_group(group).horizontal
    assert spaced(flat.v, flat.a).around == pytest.approx(around)  # as in mrs_uav_managers


def nearing(v, d=3.0, a=0.0, bumper=USUAL, moving=False, to=ETA):
    """What the bumper says of something `d` [m] ahead that comes nearer with `v` [m/s] and `a` [m/s²]."""
    there = np.array((np.cos(to), np.sin(to), 0.0))
    x = HERE._replace(v=v * there, a=a * there)
    return bumped(bumper, seen([(0, d)]), x, moving=moving)


def test_who_comes_nearer_must_still_be_able_to_stop():
    v, bumper = 2.0, Bumper(a=1.5, late=0.3)
    bound = 1.2 + 0.3 * v + 1.5 * v**2 / (2.0 * 1.5)
    assert nearing(v, bound + 0.01, bumper=bumper) == FREE
    bump = nearing(v, bound - 0.01, bumper=bumper)
    assert "bound 3.8 m" in bump.said
    assert np.linalg.norm(bump.goal.r - HERE.r) == pytest.approx(0.01 + 0.2)
    assert nearing(-v, 1.3, bumper=bumper) == FREE  # who goes away may
    assert nearing(v, 1.3, bumper=bumper, to=ETA + pi / 2) == FREE  # and who passes by


def test_who_is_getting_quicker_will_be_quicker_before_it_brakes():
    bound = 1.2 + 0.4 * 1.8 + 1.5 * 1.8**2 / (2.0 * 2.0)  # of 1 m/s and 0.4 s of 2 m/s²
    assert nearing(1.0, bound + 0.01, 2.0) == FREE
    assert nearing(1.0, bound - 0.01, 2.0) != FREE
    assert (
        nearing(1.0, 3.0, -2.0) == FREE == nearing(1.0, 3.0)
    )  # braking is not believed in advance


def test_of_two_things_the_one_that_is_flown_at_counts_and_not_the_nearer_one_beside():
    x = HERE._replace(v=np.array((np.cos(ETA), np.sin(ETA), 0.0)) * 3.0)
    bump = bumped(Bumper(), seen([(0, 5.0), (2, 1.5)]), x)
    assert "5.00 m away, ahead" in bump.said


def test_the_bumper_of_the_limits_looks_at_no_speed():
    assert nearing(3.9, 7.3, bumper=spaced(4.0, 2.0)) == FREE
    assert nearing(0.0, 7.1, bumper=spaced(4.0, 2.0)) != FREE


def test_who_moves_away_goes_on_until_it_is_slow_and_has_gained_something():
    assert nearing(0.4, 2.5) == FREE
    goal = nearing(0.4, 2.5, moving=True).goal
    np.testing.assert_array_equal(goal.r, HERE.r)  # it brakes
    assert nearing(0.2, 2.5, moving=True) == FREE
    assert nearing(0.0, 1.25) == FREE
    assert np.linalg.norm(nearing(0.0, 1.25, moving=True).goal.r - HERE.r) == pytest.approx(0.15)
    assert nearing(0.0, 1.31, moving=True) == FREE
    assert bumped(Bumper(), seen(), HERE._replace(v=np.ones(3)), moving=True) == FREE


def test_numbers_that_make_no_bumper_are_refused():
    with pytest.raises(BadInput, match="above is -1"):
        checked(Bumper(above=-1.0))
    with pytest.raises(BadInput, match=r"a is 0\.0 m/s²"):
        checked(Bumper(a=0.0))
    with pytest.raises(BadInput, match="late is inf"):
        checked(Bumper(late=inf))
    assert checked(spaced(4.0, 2.0)).a == inf
    with pytest.raises(BadInput, match=r"1 m/s and 0\.0 m/s²"):
        spaced(1, 0.0)
