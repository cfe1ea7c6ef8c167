"""Limits of motion, by name."""

from math import inf, nan

import numpy as np
import pytest

from uavlab.errors import BadInput, UnknownName
from uavlab.frames import NO_SHIFT, Shift, inverse, moved
from uavlab.limits import GROUPS, ForceLimits, checked, limit_group
from uavlab.types import Trajectory


def test_every_group_can_be_flown_and_says_where_it_stands():
    for name, limits in GROUPS.items():
        assert checked(limits) is limits is limit_group(name)
        assert name.split("-")[0] in limits.source


def test_a_faster_group_is_nowhere_slower():
    for year in ("", "-2020"):
        slow, medium, fast = (GROUPS[x + year] for x in ("slow", "medium", "fast"))
        assert slow.horizontal.v < medium.horizontal.v < fast.horizontal.v
        assert slow.up.a <= medium.up.a <= fast.up.a
        assert slow.heading.a <= medium.heading.a <= fast.heading.a


def test_a_name_that_is_not_known_is_told_which_are():
    with pytest.raises(UnknownName, match="Did you mean 'medium'"):
        limit_group("medum")


@pytest.mark.parametrize("value", [0.0, -1.0, nan, "9", None])
def test_a_limit_that_lets_nothing_move_is_refused_by_its_name(value):
    medium = limit_group("medium")
    with pytest.raises(BadInput, match=r"limits\.up\.a .* above 0"):
        checked(medium._replace(up=medium.up._replace(a=value)))


def test_what_is_no_limits_is_refused():
    medium = limit_group("medium")
    for bad in (None, "medium", medium._replace(rates=(1.0, 2.0)), medium._replace(down=3.0)):
        with pytest.raises(BadInput, match="limits"):
            checked(bad)
    with pytest.raises(BadInput, match=r"limits\.tilt"):
        checked(medium._replace(tilt=nan))


def test_no_limit_is_a_limit():
    medium = limit_group("medium")
    checked(medium._replace(down=medium.down._replace(s=inf)))
    assert ForceLimits().vertical.j == inf


def test_a_trajectory_changes_worlds_with_its_places_and_headings():
    way = Trajectory(np.array([0.0, 1.0]), np.array([[1.0, 0, 2], [0, 3, 4]]), np.array([0.0, 3.0]))
    shift = Shift(np.array([1.0, 2.0, 3.0]), np.pi / 2)
    there = moved(way, shift)
    assert there.t is way.t
    assert there.r == pytest.approx(np.array([[1.0, 3, 5], [-2, 2, 7]]))
    assert there.heading == pytest.approx([np.pi / 2, 3.0 + np.pi / 2 - 2 * np.pi])
    back = moved(there, inverse(shift))
    assert back.r == pytest.approx(way.r)
    assert back.heading == pytest.approx(way.heading)
    assert moved(way, NO_SHIFT).r == pytest.approx(way.r)
