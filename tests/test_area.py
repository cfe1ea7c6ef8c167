"""A safety area: what lies in it and what does not, held against winding numbers and places along each way."""

import copy
import json
import pickle
import re
import subprocess
import sys
from time import perf_counter

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from strategies import floats

from uavlab.area import Area, NoFly, from_told
from uavlab.errors import BadInput
from uavlab.types import Reference, Trajectory

YARD = ((0, 0), (40, 0), (40, 30), (20, 12), (0, 30))  # a notch from above: (20, 12) is its tip
TOWER = NoFly(((9, 9), (11, 9), (11, 11), (9, 11)), 0.0, 12.0, "tower")
AREA = Area(YARD, 1.0, 20.0, (TOWER,))
WARY = Area(YARD, 1.0, 20.0, (TOWER,), margin=1.0)
CENTRE = np.array((20.0, 5.0, 5.0))


def goal(*r: float) -> Reference:
    zero = np.zeros(3)
    return Reference(np.array(r, dtype=float), zero, zero, zero, 0.0, 0.0)


def trajectory(*r) -> Trajectory:
    points = np.array(r, dtype=float)
    return Trajectory(np.arange(len(points), dtype=float), points, np.zeros(len(points)))


# Oracles: they share nothing with the code ----------------------------------------------------------------


def winding(border, p) -> int:
    """How often a border goes around a place, from the angles under which its sides are seen (2 π each time)."""
    to = np.asarray(border, dtype=float) - p
    after = np.roll(to, -1, axis=0)
    cross = to[:, 0] * after[:, 1] - to[:, 1] * after[:, 0]
    return round(float(np.arctan2(cross, (to * after).sum(axis=1)).sum() / (2.0 * np.pi)))


def distance(border, p) -> float:
    """From a place to the nearest side of a border [m]."""
    a = np.asarray(border, dtype=float)
    ab = np.roll(a, -1, axis=0) - a
    s = np.clip(((p - a) * ab).sum(axis=1) / (ab**2).sum(axis=1), 0.0, 1.0)
    return float(np.linalg.norm(a + s[:, None] * ab - p, axis=1).min())


def allowed(area: Area, r) -> bool:
    """Whether a place may be asked for, without margin."""
    in_zone = any(winding(x.border, r[:2]) and x.low < r[2] < x.high for x in area.no_fly)
    return bool(winding(area.border, r[:2])) and area.low <= r[2] <= area.high and not in_zone


def nearest(area: Area, r) -> float:
    """From a place to the nearest surface at which the answer may change [m]."""
    zones = [distance(x.border, r[:2]) for x in area.no_fly]
    heights = [abs(r[2] - z) for x in (area, *area.no_fly) for z in (x.low, x.high)]
    return min(distance(area.border, r[:2]), *zones, *heights)


@st.composite
def stars(draw, centre=(0.0, 0.0), size=10.0):
    """Borders with dents and spikes: as seen from the centre, each corner is farther round than the one before."""
    n = draw(st.integers(3, 9))
    turn = (np.arange(n) + [draw(floats(-0.3, 0.3)) for _ in range(n)]) * 2.0 * np.pi / n
    radius = np.array([draw(floats(0.2, 1.0)) for _ in range(n)]) * size
    around = np.stack([np.cos(turn), np.sin(turn)], axis=1)[:: draw(st.sampled_from((1, -1)))]
    return np.array(centre) + radius[:, None] * around if n > 3 else size * around


places = st.tuples(floats(-12, 12), floats(-12, 12), floats(-2, 12)).map(np.array)
near = st.tuples(floats(-4, 4), floats(-4, 4), floats(1, 10)).map(np.array)


@given(stars(), stars((3.0, 2.0), 3.0), places)
def test_a_place_is_refused_exactly_where_the_border_does_not_wind_around_it_or_a_zone_does(
    border, zone, r
):
    area = Area(border, 1.0, 10.0, (NoFly(zone, 2.0, 6.0, "zone"),))
    assume(nearest(area, r) > 1e-5)
    assert (area.why_not_at(r) == "") == allowed(area, r)


@given(stars(), stars((3.0, 2.0), 3.0), near, near)
def test_a_way_is_refused_exactly_if_a_place_along_it_is(border, zone, r0, r1):
    area = Area(border, 1.0, 10.0, (NoFly(zone, 2.0, 6.0, "zone"),))
    assume(allowed(area, r0) and allowed(area, r1))
    along = r0 + np.linspace(0.0, 1.0, 101)[:, None] * (r1 - r0)
    bad = [r for r in along if not allowed(area, r)]
    if any(nearest(area, r) > 1e-5 for r in bad):
        assert area.why_not_between(r0, r1)
    elif not bad and min(nearest(area, r) for r in along) > 0.1:  # else one may slip in between
        assert not area.why_not_between(r0, r1)


@given(stars(), places, floats(0.01, 1.5))
def test_what_a_margin_admits_is_that_far_from_the_border(border, r, margin):
    try:
        area = Area(border, -5.0, 15.0, margin=margin)
    except BadInput:  # it leaves nothing
        assert distance(border, r[:2]) <= margin or not winding(border, r[:2])
        return
    if not area.why_not_at(r):
        assert winding(border, r[:2])
        assert distance(border, r[:2]) >= margin - 2e-6


@given(stars(), places, floats(0.01, 1.5))
def test_what_is_nearer_to_a_zone_than_the_margin_is_refused(border, r, margin):
    wide = ((-99, -99), (99, -99), (99, 99), (-99, 99))
    area = Area(wide, -5.0, 15.0, (NoFly(border, name="zone"),), margin=margin)
    if winding(border, r[:2]) or distance(border, r[:2]) < margin - 2e-6:
        assert "'zone'" in area.why_not_at(r)
    elif (
        distance(border, r[:2]) > 6.0 * margin
    ):  # beyond the sharpest corner that is made of two moved sides
        assert not area.why_not_at(r)


@given(stars(), places, places, st.integers(1, 40))
def test_a_trajectory_is_refused_exactly_if_one_of_its_ways_is(border, r0, r1, n):
    area = Area(border, 1.0, 10.0, (NoFly(((0, 0), (2, 0), (2, 2)), 2.0, 6.0, "zone"),))
    bend = np.array((1.0, 1.0, 3.0)) * np.sin(np.linspace(0.0, 3.0, n + 1))[:, None]
    r = r0 + np.linspace(0.0, 1.0, n + 1)[:, None] * (r1 - r0) + bend
    places_ = [area.why_not_at(x) for x in r]
    ways = [area.why_not_between(a, b) for a, b in zip([r[0], *r[:-1]], r, strict=True)]
    assert bool(area.why_not(trajectory(*r), r[0])) == any(places_ + ways)


# Borders --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("r", [(0, 5, 2), (40, 30, 20), (20, 12, 1), (10, 21, 5), (30, 21, 5)])
def test_on_the_border_is_inside(r):
    assert AREA.why_not_at(np.array(r, dtype=float)) == ""


def test_along_the_border_one_may_fly_and_a_millimetre_beyond_one_may_not():
    along = np.array([(x, x * 0.9 + 0.0, 5.0) for x in np.linspace(0.0, 18.0, 7)])
    border = ((0, 0), (20, 18), (0, 18))
    area = Area(border, 1.0, 20.0)
    assert area.why_not(trajectory(*along), along[0]) == ""
    assert "outside" in area.why_not(trajectory(*np.add(along, (0.0, -1e-3, 0.0))), along[0])


@pytest.mark.parametrize("r", [(9, 10, 5), (11, 11, 5), (10, 10, 12)])
def test_a_zone_may_be_touched_on_its_border_and_on_its_top(r):
    assert AREA.why_not_at(np.array(r, dtype=float)) == ""
    assert "'tower'" in AREA.why_not_at(np.array(r) + np.sign((10, 10, 6) - np.array(r)) * 1e-3)


def test_straight_down_and_standing_still_are_ways_too():
    over, under = np.array((10.0, 10.0, 15.0)), np.array((10.0, 10.0, 13.0))
    assert AREA.why_not_between(over, under) == ""
    assert AREA.why_not_between(over, over) == ""
    assert "'tower'" in AREA.why_not_between(over, np.array((10.0, 10.0, 11.9)))
    low = AREA.why_not_between(np.array((12.0, 10.0, 15.0)), np.array((8.0, 10.0, 12.0)))
    assert low == ""  # passes above it
    assert "crosses" in AREA.why_not_between(
        np.array((12.0, 10.0, 12.0)), np.array((8.0, 10.0, 11.0))
    )


# Ways back ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("now", [(-8, 5, 2), (50, 50, 5), (20, 5, 0), (20, 5, 30), (10, 10, 3)])
def test_who_is_outside_or_in_a_zone_may_come_back_but_not_go_on(now):
    now = np.array(now, dtype=float)
    assert WARY.why_not(goal(*CENTRE), now) == ""
    assert WARY.why_not(goal(*np.add(now, (1e-2, 0, 0))), now) != ""


def test_who_is_only_within_the_margin_may_not_fly_through_the_zone():
    now = np.array((8.5, 10.0, 3.0))  # half a metre from the tower
    assert "crosses the no-fly zone 'tower'" in WARY.why_not(goal(13, 10, 3), now)
    assert WARY.why_not(goal(5, 10, 3), now) == ""


def test_who_is_only_within_the_margin_may_not_cut_across_the_notch():
    now = np.array((5.0, 25.2, 3.0))  # within the border by less than a metre
    assert AREA.why_not_at(now) == ""
    assert WARY.why_not_at(now) != ""
    assert "leaves the safety area" in WARY.why_not(goal(36, 24, 3), now)
    assert WARY.why_not(goal(5, 5, 3), now) == ""


def test_behind_its_first_point_no_trajectory_is_forgiven():
    now = np.array((-8.0, 5.0, 2.0))
    assert "point 1" in AREA.why_not(trajectory((5, 5, 2), (-8, 5, 2), (5, 5, 2)), now)


# Messages -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("area", "asked", "said"),
    [
        (AREA, goal(42, 4, 2), "the goal, (42.0, 4.0, 2.0) m, lies 2.0 m outside the border of the safety area"),
        (WARY, goal(42, 4, 2), "lies 3.0 m outside the margin of the safety area; keep 1 m within its border"),
        (AREA, goal(5, 5, 0.5), "the goal, (5.0, 5.0, 0.5) m, lies 0.5 m below the safety area; keep to 1 m or more"),
        (AREA, goal(5, 5, 20.04), "lies 0.04 m above the safety area; keep to 20 m or less"),
        (AREA, goal(10, 10, 5), "lies in the no-fly zone 'tower' from 0 m up to 12 m; keep out of it"),
        (WARY, goal(11.5, 10, 5), "lies within 1 m of the no-fly zone 'tower' from 0 m up to 12 m; keep 1 m out of it"),
        (AREA, goal(5, 5, np.nan), "the goal, (5.0, 5.0, nan) m, is not finite"),
        (AREA, goal(5, 14, 5), "the way from (20.0, 5.0, 5.0) m, to the goal, (5.0, 14.0, 5.0) m, crosses the no-fly"),
        (WARY, goal(5, 11, 5), "or its margin of 1 m; fly around it"),
        (AREA, trajectory(*[CENTRE] * 3, (42, 4, 2)), "point 3 of the trajectory, (42.0, 4.0, 2.0) m, lies 2.0 m out"),
        (AREA, trajectory((35, 5, 5), (39, 29, 5), (1, 29, 5)), "the way from point 1 of the trajectory, "
            "(39.0, 29.0, 5.0) m, to point 2 of the trajectory, (1.0, 29.0, 5.0) m, leaves the safety area; keep"),
        (AREA, trajectory((5, 14, 5)), "to point 0 of the trajectory, (5.0, 14.0, 5.0) m, crosses the no-fly zone"),
        (AREA, Trajectory(np.zeros(0), np.zeros((0, 3)), np.zeros(0)), "the trajectory has no points"),
    ],
)  # fmt: skip
def test_a_refusal_names_point_place_bound_and_zone(area, asked, said):
    assert said in area.why_not(asked, CENTRE)


def test_who_does_not_know_where_it_is_gets_no_way():
    assert "where it is, (nan, 0.0, 0.0) m" in AREA.why_not(goal(*CENTRE), np.array((np.nan, 0, 0)))


# Edges ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"border": ((0, 0), (1, 1), (0, 1), (1, 0))}, "border crosses or touches itself (Self-intersection[0.5 0.5])"),
        ({"border": ((0, 0), (1, 1), (2, 2))}, "border crosses or touches itself"),
        ({"border": ((0, 0), (1, 1))}, "border has shape (2, 2); it must be (K, 2) with K ≥ 3"),
        ({"border": "square"}, "border is 'square'; it must be points"),
        ({"border": ((0, 0), (0, np.inf), (1, 1))}, "border[1] is [0.0, inf]; it must be finite"),
        ({"low": 3.0}, "low is 3 m and high is 3 m; low must be below high"),
        ({"low": np.nan}, "low is nan; it must be a number"),
        ({"high": "top"}, "high is 'top'; it must be a number"),
        ({"margin": -1}, "margin is -1 m; it must be ≥ 0"),
        ({"margin": 2.0}, "margin is 2 m, which leaves nothing of it; take less, or a wider border"),
        ({"world": None}, "world is None; it must be a name, or empty"),
        ({"no_fly": (1,)}, "no_fly[0] is 1; it must be a NoFly"),
        ({"no_fly": (TOWER, TOWER)}, "no_fly has two zones named 'tower'; rename one"),
    ],
)  # fmt: skip
def test_an_area_that_cannot_be_is_refused_by_field_value_and_bound(change, said):
    good = {"border": ((0, 0), (4, 0), (4, 3), (0, 3)), "low": 0.0, "high": 3.0}
    Area(**good)
    with pytest.raises(BadInput, match=re.escape(said)):
        Area(**{**good, **change})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"name": ""}, "the name of a no-fly zone is ''; give it one"),
        ({"low": 9.0, "high": 2.0}, "no-fly zone 'x': low is 9 m and high is 2 m"),
        ({"border": ((0, 0), (1e-7, 0), (0, 1e-7))}, "no-fly zone 'x': border encloses nothing"),
    ],
)
def test_a_zone_that_cannot_be_is_refused(change, said):
    with pytest.raises(BadInput, match=re.escape(said)):
        NoFly(**{"border": ((0, 0), (1, 0), (0, 1)), "name": "x", **change})


def test_nobody_can_move_a_border_afterwards():
    corners = np.array(YARD, dtype=float)
    area = Area(corners, 1.0, 20.0)
    corners[:] = 0.0
    assert area.why_not_at(CENTRE) == ""
    with pytest.raises(ValueError, match="read-only"):
        area.border[0] = 1.0
    with pytest.raises(AttributeError):
        area.low = 0.0  # type: ignore[misc]


def test_what_is_told_makes_the_same_area_again():
    zones = (TOWER, NoFly(((30, 5), (31, 5), (31, 6)), name="always"))
    area = Area(YARD, 1.0, 20.0, zones, 0.5, "gnss")
    for again in (
        from_told(json.loads(json.dumps(area.told()))),
        pickle.loads(pickle.dumps(area)),
        copy.deepcopy(area),
    ):
        assert again.told() == area.told()
        assert again.why_not_at(np.array((30.9, 5.1, 500.0))) != ""
    strict = {**area.told(), "high": None}
    assert from_told(strict).high == np.inf
    with pytest.raises(BadInput, match=r"tells no safety area.*'low'"):
        from_told({"border": YARD, "high": 3.0})
    with pytest.raises(BadInput, match=r"tells no safety area.*'highh'"):
        from_told({"border": YARD, "low": 0.0, "highh": 3.0})


# Speed ----------------------------------------------------------------------------------------------------


def test_five_thousand_points_are_checked_within_a_tick():
    turn = np.linspace(0.0, 2.0 * np.pi, 5000)
    r = np.stack([20 + 7 * np.cos(turn), 6 + 4 * np.sin(turn), 5 + np.sin(turn)], axis=1)
    asked = Trajectory(turn, r, turn)
    taken = []
    for _ in range(10):
        start = perf_counter()
        assert WARY.why_not(asked, r[0]) == ""
        taken.append(perf_counter() - start)
    assert min(taken) < 5e-3


def test_nobody_waits_for_geometry_who_has_no_area():
    code = "import sys, uavlab, uavlab.area, uavlab.flight.scenario; assert 'shapely' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
