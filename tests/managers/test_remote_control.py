"""Somebody with sticks takes over, flies in the frame of the nose, gives back, or wants it down."""

from math import inf

import numpy as np
import pytest

from uavlab.errors import BadInput
from uavlab.managers.remote import Held, Remote, checked, heard
from uavlab.orders import Velocity
from uavlab.so3 import about_z
from uavlab.types import Estimate, Reference, Sticks

DT = 0.01
ZERO = np.zeros(3)
ETA = 0.6
HERE = Estimate(np.array((4.0, -2.0, 3.0)), np.array((0.6, 0.8, 0.0)), ZERO, about_z(ETA), ZERO)


def sticks(push=(0.0, 0.0, 0.0), turn=0.0, engaged=True, failsafe=False):
    return Sticks(0.0, engaged, np.array(push), turn, failsafe)


USUAL = Remote()


def flown(*told, estimate=HERE, remote=USUAL):
    """The wishes of these ticks; a tick is Sticks, None, or (n, one of them)."""
    memory, wishes = Held(), []
    for one in told:
        n, now = one if isinstance(one, tuple) and not isinstance(one, Sticks) else (1, one)
        for _ in range(n):
            memory, wish = heard(remote, memory, now, estimate, DT)
            wishes.append(wish)
    return wishes


def test_sticks_that_nobody_has_switched_on_want_nothing():
    for wish in flown(sticks((1.0, 0, 0), engaged=False), None, None):
        assert (wish.engaged, wish.asked, wish.stage, wish.said) == (False, None, "", "")


def test_a_stick_all_the_way_is_a_metre_per_second_in_the_direction_of_the_nose():
    asked = flown(sticks((1.0, 0.0, 0.0)))[0].asked
    assert isinstance(asked, Velocity)
    np.testing.assert_allclose(asked.v, (np.cos(ETA), np.sin(ETA), 0.0))
    left = flown(sticks((0.0, 0.5, -0.5), turn=-1.0))[0].asked
    np.testing.assert_allclose(left.v, (-0.5 * np.sin(ETA), 0.5 * np.cos(ETA), -0.5))
    assert left.heading_rate == pytest.approx(-0.2)
    assert left.z is None
    assert left.heading is None


def test_a_stick_goes_no_farther_than_its_end():
    asked = flown(sticks((7.0, 0.0, 0.0), turn=9.0))[0].asked
    assert np.linalg.norm(asked.v) == pytest.approx(1.0)
    assert asked.heading_rate == pytest.approx(0.2)


def test_between_two_messages_the_last_one_is_asked_for_with_the_nose_of_now():
    memory, _ = heard(Remote(), Held(), sticks((1.0, 0, 0)), HERE, DT)
    turned = HERE._replace(R=about_z(2.0))
    _, wish = heard(Remote(), memory, None, turned, DT)
    np.testing.assert_allclose(wish.asked.v, (np.cos(2.0), np.sin(2.0), 0.0))


def test_let_go_they_ask_once_for_the_place_where_it_will_have_stopped():
    wishes = flown(sticks((1.0, 0, 0)), sticks(), sticks((0.04, -0.04, 0.0)), None)
    assert isinstance(wishes[0].asked, Velocity)
    goal = wishes[1].asked
    assert isinstance(goal, Reference)
    np.testing.assert_allclose(goal.r, HERE.r + 0.5 * HERE.v)  # v²/2a at 1 m/s and 1 m/s²
    assert goal.heading == pytest.approx(ETA)
    assert not goal.v.any()
    assert [x.asked for x in wishes[2:]] == [None, None]
    assert all(x.engaged for x in wishes)


def test_taken_over_with_the_sticks_let_go_it_stops():
    assert isinstance(flown(sticks())[0].asked, Reference)


def test_turning_alone_is_not_let_go():
    assert isinstance(flown(sticks(turn=0.5))[0].asked, Velocity)


def test_who_takes_over_and_gives_back_is_told_once():
    wishes = flown((10, sticks((1.0, 0, 0))), (10, sticks(engaged=False)))
    assert [x.said for x in wishes if x.said] == [
        "the remote control takes over",
        "the remote control gives back: it was let go",
    ]
    assert [x.engaged for x in wishes] == [True] * 10 + [False] * 10
    assert wishes[10].asked is None


def test_sticks_that_fall_silent_give_back_after_a_second_and_take_over_when_heard_again():
    wishes = flown(sticks((1.0, 0, 0)), (150, None), sticks())
    assert [x.engaged for x in wishes[:100]] == [True] * 100
    assert not any(x.engaged for x in wishes[100:151])
    assert wishes[100].said == "the remote control gives back: it has been silent for 1 s"
    assert wishes[151].said == "the remote control takes over"
    assert isinstance(wishes[151].asked, Reference)


def stages(*told):
    return [x.stage for x in flown(*told)]


def test_the_failsafe_switch_wants_more_every_two_seconds_engaged_or_not():
    for engaged in (True, False):
        seen = stages((1000, sticks(failsafe=True, engaged=engaged)))
        assert seen == ["hover"] * 200 + ["emergency"] * 200 + ["failsafe"] * 600


def test_what_the_switch_wants_is_told_when_it_wants_it():
    said = [x.said for x in flown((500, sticks(failsafe=True, engaged=False))) if x.said]
    assert said == [
        "the failsafe switch is on now: hover",
        "the failsafe switch is on for 2 s more: emergency",
        "the failsafe switch is on for 2 s more: failsafe",
    ]


def test_switched_off_in_time_a_hover_is_all_there_was():
    seen = stages((100, sticks(failsafe=True)), (100, sticks()), (150, sticks(failsafe=True)))
    assert seen == ["hover"] * 100 + [""] * 100 + ["hover"] * 150


def test_an_emergency_is_not_taken_back_and_the_next_press_goes_on_from_there():
    on, off = sticks(failsafe=True), sticks()
    seen = stages((250, on), (30, off), (200, on))
    assert seen[200:280] == ["emergency"] * 80
    assert seen[399] == "emergency"
    assert seen[400] == "failsafe"


def test_a_switch_that_nobody_hears_any_more_wants_nothing_new():
    on = sticks(failsafe=True)
    assert stages(on, (500, None))[-1] == "hover"
    assert stages((150, on), (90, None))[-1] == "emergency"


def test_a_remote_that_cannot_be_flown_with_is_refused():
    with pytest.raises(BadInput, match=r"remote\.v is 0"):
        checked(Remote(v=0.0))
    with pytest.raises(BadInput, match="pause is inf"):
        checked(Remote(pause=inf))
    with pytest.raises(BadInput, match=r"dead is 1\.0"):
        checked(Remote(dead=1.0))
    assert checked(Remote()) == Remote()
