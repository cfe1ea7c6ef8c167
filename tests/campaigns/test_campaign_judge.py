"""The criterion of the fault campaign, on logs that were made for it: each rule can be broken, and is then named."""

import numpy as np
import pytest

from uavlab.campaigns.judge import inside, mode_of, touch_down, violations
from uavlab.flight.log import UNITS, Log
from uavlab.flight.worlds import NO_WORLDS, room
from uavlab.types import Exit

AREA = {
    "border": [[-10, -10], [10, -10], [10, 10], [-10, 10]], "low": 0.5, "high": 8.0, "margin": 0.0, "world": "",
    "no_fly": [{"border": [[3, 3], [6, 3], [6, 6], [3, 6]], "low": -np.inf, "high": 5.0, "name": "tower"}],
}  # fmt: skip
DT = 0.01


def made(exit_=Exit.LANDED, mode="landed", **changed):
    """Two seconds up in the air and one on the ground, in which it lands softly."""
    n = 300
    shapes = dict.fromkeys(("t", "heading_d", "heading_rate_d", "f_d", "solve"), ())
    shapes |= {"R": (3, 3), "R_e": (3, 3), "rotors": (4,)}
    rows = {name: np.zeros((n, *shapes.get(name, (3,)))) for name in UNITS}
    rows["t"] = DT * np.arange(n)
    rows["r"][:, 2] = np.maximum(2.0 - rows["t"], 0.0)
    rows["v"][rows["r"][:, 2] > 0.0, 2] = -1.0
    rows["r_d"][:, 2] = rows["r"][:, 2]
    events = [[0.0, "mode", "flying", ""], [0.5, "mode", "landing", ""], [2.5, "mode", mode, ""]]
    meta = {"dt": DT, "events": events, "area": AREA, "traceback": "", "faults": []}
    rows |= {k: v for k, v in changed.items() if k in rows}
    meta |= {k: v for k, v in changed.items() if k not in rows}
    return Log(**rows, exit=exit_, reason="it was made", meta=meta, worlds=NO_WORLDS)


def changed(name, ticks, value):
    x = getattr(made(), name).copy()
    x[ticks] = value
    return {name: x}


def said(log):
    return list(violations(log))


def test_a_flight_that_lands_softly_within_its_area_has_kept_to_all():
    assert said(made()) == []
    assert touch_down(made()) == pytest.approx(1.0)


def test_the_touch_down_is_that_at_the_ground_and_not_that_of_the_tick_before():
    log = made(
        a=np.full((300, 3), (0.0, 0.0, -9.81)), **changed("r", slice(150, 190), (0, 0, 0.04))
    )
    assert touch_down(log) == pytest.approx(1.0 + 9.81 * DT, abs=1e-3)
    assert touch_down(made(r=np.ones((300, 3)))) is None


@pytest.mark.parametrize("exit_", [Exit.TILT, Exit.CRASH, Exit.AWAY, Exit.NAN, Exit.ERROR])
def test_any_other_ending_is_named(exit_):
    assert said(made(exit_)) == [f"it ended with {exit_.name}: it was made"]


@pytest.mark.parametrize("mode", ["taking off", "landing", "emergency", "failsafe", "evading"])
def test_a_flight_whose_time_is_over_before_it_is_down_ended_nowhere(mode):
    up = np.full((300, 3), (0.0, 0.0, 2.0))
    log = made(Exit.DONE, mode, r=up, r_d=up)
    assert said(log) == [f"its time was over while it was {mode!r}"]
    assert said(made(Exit.DONE, "flying", r=up, r_d=up)) == []


def test_a_hard_touch_down_is_named_whatever_the_loop_made_of_it():
    fast = made().v.copy()
    fast[:, 2] = -3.2
    assert said(made(v=fast)) == ["it touched down at 3.20 m/s"]


def test_a_traceback_is_told_by_its_last_line():
    log = made(traceback="Traceback:\n  File\nZeroDivisionError: no\n")
    assert said(log) == ["a part raised: ZeroDivisionError: no"]


@pytest.mark.parametrize("name", ["r", "r_d", "f_d", "r_e", "R", "rotors", "omega_d"])
def test_what_is_not_a_number_is_named_with_its_time(name):
    log = made(**changed(name, slice(120, 130), np.nan))
    assert f"{name} is not a number at t = 1.20 s" in said(log)


def test_only_an_estimate_may_be_no_number_and_only_while_it_is_told_to():
    fault = [["nan", 1.2, 1.3, "estimator", 0.0]]
    assert said(made(faults=fault, **changed("v_e", slice(120, 130), np.nan))) == []
    assert said(made(faults=fault, **changed("v_e", slice(120, 140), np.nan)))
    assert said(made(faults=fault, **changed("a_d", slice(120, 130), np.nan)))


@pytest.mark.parametrize(
    ("place", "what"),
    [
        ((10.1, 0, 2), "outside the border"),
        ((0, -12, 2), "outside the border"),
        ((0, 0, 8.1), "above 8 m"),
        ((4, 4, 2), "in no-fly zone 'tower'"),
    ],
)
def test_a_reference_where_it_may_not_be_is_named_with_time_and_place(place, what):
    (one,) = said(made(**changed("r_d", slice(100, 150), place)))
    assert one.startswith(f"its reference was {what} for 0.50 s, first at t = 1.00 s, at (")


def test_above_a_low_zone_one_may_fly():
    assert said(made(**changed("r_d", slice(100, 150), (4, 4, 6)))) == []


def test_below_the_lower_bound_are_only_those_that_come_or_go():
    low = {"events": [[0.0, "mode", "flying", ""]]}
    assert "below 0.5 m" in said(made(Exit.DONE, **low))[0]


def test_a_reference_is_held_against_the_area_in_the_world_of_the_start():
    there = room(300)._replace(shift_r=np.full((300, 3), (20.0, 0.0, 0.0)))
    moved = made().r_d + np.array((20.0, 0.0, 0.0))
    assert said(made(r_d=moved)._replace(worlds=there)) == []
    assert said(made(r_d=moved))


def test_inside_is_what_a_winding_number_says():
    rng = np.random.default_rng(3)
    border = np.array([[0, 0], [6, 1], [5, 5], [3, 2], [1, 6]], dtype=float)
    r = rng.uniform(-1, 7, size=(500, 3))
    to = border[None] - r[:, None, :2]
    angle = np.arctan2(to[..., 1], to[..., 0])
    turn = (np.diff(angle, axis=1, append=angle[:, :1]) + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_array_equal(inside(r, border), np.abs(turn.sum(axis=1)) > np.pi)


def test_a_mode_lasts_until_the_next():
    mode = mode_of(made())
    assert [mode[0], mode[49], mode[50], mode[249], mode[250]] == [
        "flying", "flying", "landing", "landing", "landed",
    ]  # fmt: skip
