"""Each trigger of the watch: silent below its bound, heard above it, told with its value and its bound."""

import re
from math import inf, nan, radians

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from uavlab.errors import BadInput
from uavlab.frames import Shift, moved
from uavlab.managers.safety import (
    BOUNDS,
    EMERGENCY,
    FAILSAFE,
    NOTHING,
    TRIGGERS,
    Bounds,
    Play,
    Safety,
    begun,
    checked,
    kind_of,
    reframed,
    watched,
)
from uavlab.parts.controllers import TiltAxis
from uavlab.parts.emergency import Emergency
from uavlab.parts.missions import still
from uavlab.parts.throttle import ThrustCurve
from uavlab.solutions.dynamics import force_from_throttle
from uavlab.solutions.mpc import MpcController
from uavlab.types import Command, Estimate

DT = 0.01
ZERO = np.zeros(3)
HERE = Estimate(np.array((1.0, 2.0, 3.0)), ZERO, ZERO, np.eye(3), ZERO)
HOVER = Command(20.0, ZERO, ZERO)
CURVE = ThrustCurve(0.12, -0.18)
LIMITS = Safety(curve=CURVE)
ASKED = still(HERE.r)
LOUD = begun(LIMITS)._replace(mute=0.0)
FLIES = Play()


def turned(axis, angle):
    return Rotation.from_rotvec(angle * np.array(axis, float)).as_matrix()


def look(memory=LOUD, estimate=HERE, reference=ASKED, command=HOVER, play=FLIES, limits=LIMITS):
    return watched(limits, memory, estimate, reference, command, play, DT)


def verdict(**given):
    return look(**given)[1]


def speaks_after(ticks=1000, memory=LOUD, counts=False, **given):
    """Tick from which on it speaks while all of it stays as it is; None: never. And what it then says."""
    play = given.pop("play", FLIES)
    for k in range(ticks):
        if counts:
            play = play._replace(failures=play.failures + 1)
        memory, said = look(memory=memory, play=play, **given)
        if said.level:
            return k + 1, said
    return None, NOTHING


def assert_says(said, level, trigger, *numbers):
    assert (said.level, said.trigger) == (level, trigger)
    for number in numbers:
        assert number in said.said


# Errors -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "error", "lost"), [("se3", 1.5, 2.5), ("mpc", 3.5, 4.5), ("other", 1.5, 2.5)]
)
def test_a_reference_that_is_too_far_away_ends_the_flight_by_the_bounds_of_the_law(
    kind, error, lost
):
    def at(e):
        return verdict(reference=still(np.add(HERE.r, (0.0, e, 0.0))), play=Play(kind))

    assert at(error - 0.01) == NOTHING
    assert_says(
        at(error + 0.01), EMERGENCY, "control error", f"{error + 0.01:.2f} m", f"{error:g} m"
    )
    assert at(lost - 0.01).level == EMERGENCY
    assert_says(at(lost + 0.01), FAILSAFE, "lost", f"{lost + 0.01:.2f} m", f"{lost:g} m")


def test_in_an_emergency_only_the_larger_bound_counts():
    def at(e):
        return verdict(
            reference=still(np.add(HERE.r, (e, 0, 0))), play=Play("emergency", emergency=True)
        )

    assert at(3.9) == NOTHING
    assert_says(at(4.1), FAILSAFE, "lost", "4.10 m", "4 m")


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_nose_that_points_more_than_a_quarter_turn_off_is_told(side):
    def off(angle):
        return verdict(reference=ASKED._replace(heading=side * radians(angle)))

    assert off(89.9) == NOTHING
    assert_says(off(90.1), EMERGENCY, "heading error", "90.1°", "90.0°")


def test_a_heading_is_compared_across_the_end_of_the_circle():
    back = HERE._replace(R=turned((0, 0, 1), radians(179.0)))
    assert verdict(estimate=back, reference=ASKED._replace(heading=radians(-179.0))) == NOTHING


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -1, 0), (0.6, 0.8, 0)])
def test_an_aircraft_that_tilts_too_far_is_told(axis):
    def tilted(angle):
        return verdict(estimate=HERE._replace(R=turned(axis, radians(angle))))

    assert tilted(74.9) == NOTHING
    assert_says(tilted(75.1), EMERGENCY, "tilt", "75.1°", "75.0°")


def test_upside_down_is_tilted_and_no_error_of_rounding():
    R = np.diag((1.0, -1.0, -1.0 - 1e-15))
    assert "180.0°" in verdict(estimate=HERE._replace(R=R)).said


# Jumps ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "bound"), [("se3", 1.5), ("mpc", 2.5), ("emergency", 3.0)])
def test_a_place_that_is_not_where_its_own_velocity_has_led_has_jumped(kind, bound):
    v = np.array((8.0, 0.0, 0.0))
    before, _ = look(estimate=HERE._replace(v=v), play=Play(kind))

    def at(jump):
        r = HERE.r + v * DT + (0.0, jump, 0.0)
        there = HERE._replace(r=r, v=v)
        return look(before, there, still(r), play=Play(kind))[1]

    assert at(bound - 0.01) == NOTHING
    assert_says(at(bound + 0.01), EMERGENCY, "jump", f"{bound + 0.01:.2f} m", f"{bound:g} m")


def test_an_estimate_that_jumps_far_is_landed_from_where_it_is_now_and_does_not_fall():
    before, _ = look()
    far = HERE._replace(r=np.add(HERE.r, (9.0, 0.0, 0.0)))
    memory, said = look(before, far)
    assert_says(said, EMERGENCY, "jump", "9.00 m")
    assert look(memory, far)[1].trigger == "lost"  # who does not land then


def test_flying_fast_is_no_jump():
    memory, v = LOUD, np.array((200.0, 0.0, 0.0))
    for k in range(50):
        there = HERE._replace(r=HERE.r + v * k * DT, v=v)
        memory, said = look(memory, there, still(there.r))
        assert said == NOTHING


def test_a_heading_that_jumps_is_a_jump():
    before, _ = look()
    for angle, heard in ((89.0, False), (91.0, True)):
        R = turned((0, 0, 1), radians(angle))
        said = look(before, HERE._replace(R=R), ASKED._replace(heading=radians(angle)))[1]
        assert bool(said.level) == heard
        assert not heard or "91.0°" in said.said


def test_an_estimate_that_is_told_in_another_world_has_not_jumped():
    before, _ = look()
    far = HERE.r + 10.0
    other = HERE._replace(r=far, world="rtk")
    assert look(before, other, still(far))[1] == NOTHING
    shifted = HERE._replace(r=far, shift=Shift(np.full(3, 10.0), 0.0))
    assert look(before, shifted, still(far))[1] == NOTHING
    assert look(before, HERE._replace(r=far), still(far))[1].trigger == "jump"


def test_a_change_of_world_hides_no_jump_when_the_memory_is_told_of_it():
    shift = Shift(np.array((3.0, -2.0, 0.5)), 0.4)
    here = HERE._replace(v=np.array((4.0, 0.0, 0.0)))
    memory, _ = look(estimate=here)
    memory = reframed(memory, shift)
    for jump, heard in ((0.0, False), (1.6, True)):
        there = moved(here._replace(r=here.r + here.v * DT), shift)
        there = there._replace(r=np.add(there.r, (0.0, 0.0, jump)))
        said = look(memory, there, still(there.r, 0.4))[1]
        assert (said.trigger == "jump") == heard


def test_the_place_after_a_gap_is_compared_with_where_the_motion_has_led():
    v = np.array((10.0, 0.0, 0.0))
    memory, _ = look(estimate=HERE._replace(v=v))
    for _ in range(8):
        memory, said = look(memory, HERE._replace(r=np.full(3, nan)))
        assert said == NOTHING
    there = HERE._replace(r=HERE.r + v * 9 * DT, v=v)
    assert look(memory, there, still(there.r))[1] == NOTHING
    assert look(memory, HERE._replace(r=HERE.r - 0.7, v=v))[1].trigger == "jump"


# What may be so for a while -----------------------------------------------------------------------------


@pytest.mark.parametrize("field", ["r", "v", "R", "omega"])
def test_an_estimate_that_is_no_number_may_be_missing_for_a_tenth_of_a_second(field):
    broken = HERE._replace(**{field: getattr(HERE, field) * nan})
    ticks, said = speaks_after(estimate=broken)
    assert ticks == 10
    assert_says(said, FAILSAFE, "state missing", "0.10 s", "0.1 s")


def test_an_estimate_that_comes_back_in_time_begins_the_tenth_anew():
    memory = LOUD
    for k in range(100):
        memory, said = look(memory, HERE._replace(r=np.full(3, inf)) if k % 10 else HERE)
        assert said == NOTHING


def test_an_estimate_without_measurements_may_fly_for_a_fifth_of_a_second():
    ticks, said = speaks_after(estimate=HERE._replace(reliable=False))
    assert ticks == 20
    assert_says(said, FAILSAFE, "unreliable", "0.20 s", "0.2 s")


def test_a_throttle_above_its_limit_for_a_second_is_told_and_the_bound_is_that_of_the_curve():
    f = force_from_throttle(0.8, *CURVE)
    below, _ = speaks_after(command=HOVER._replace(f_d=f - 0.01))
    assert below is None
    ticks, said = speaks_after(command=HOVER._replace(f_d=f + 0.01))
    assert ticks == 100
    assert_says(said, EMERGENCY, "throttle", f"{f + 0.01:.1f} N", "0.8", "1.00 s")
    assert speaks_after(command=HOVER._replace(f_d=f + 9.0), limits=Safety())[0] is None


def test_a_moment_of_less_throttle_begins_the_second_anew():
    memory, hard = LOUD, HOVER._replace(f_d=force_from_throttle(0.9, *CURVE))
    for k in range(500):
        memory, said = look(memory, command=HOVER if k % 100 == 99 else hard)
        assert said == NOTHING


def test_a_thrust_that_points_down_is_not_hard_work():
    assert speaks_after(command=HOVER._replace(f_d=-5.0))[0] is None


def test_an_axis_of_thrust_that_does_not_come_may_be_off_for_half_a_second():
    for angle, heard in ((19.9, None), (20.1, 50)):
        rate = 5.0 * radians(angle)  # what a law of gain 5 1/s asks for
        ticks, said = speaks_after(
            command=HOVER._replace(omega_d=rate * np.array((0.6, -0.8, 9.0)))
        )
        assert ticks == heard
    assert_says(said, FAILSAFE, "tilt error", "20.1°", "20.0°", "0.50 s")


def test_an_aircraft_that_turns_as_it_is_told_has_no_error_of_the_axis():
    omega = np.array((3.0, -3.0, 1.0))
    turning = HERE._replace(omega=omega)
    assert speaks_after(estimate=turning, command=HOVER._replace(omega_d=omega))[0] is None


def test_a_law_without_plans_may_fly_on_old_ones_for_half_a_second():
    ticks, said = speaks_after(counts=True)
    assert ticks == 50
    assert_says(said, EMERGENCY, "solver", "0.50 s", "0.5 s")
    assert speaks_after(play=Play(failures=999), memory=LOUD._replace(failures=999))[0] is None


def test_a_new_law_that_counts_its_failures_from_zero_has_not_failed():
    memory, _ = look(memory=LOUD._replace(failures=40, unsolved=0.4), play=Play(failures=0))
    assert memory.unsolved == 0.0


def test_a_link_may_be_silent_for_three_seconds():
    ticks, said = speaks_after(play=Play(heard=False))
    assert ticks == 300
    assert_says(said, EMERGENCY, "link", "3.00 s", "3 s")


# What is not there --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "bad", [ASKED._replace(r=np.array((0, nan, 0))), ASKED._replace(heading=nan)]
)
def test_a_reference_that_is_no_number_is_told_at_once_even_while_mute(bad):
    said = look(begun(LIMITS), reference=bad)[1]
    assert_says(said, EMERGENCY, "tracker", "nan")


@pytest.mark.parametrize("bad", [{"f_d": inf}, {"omega_d": np.array((0.0, nan, 0.0))}])
def test_a_command_that_is_no_number_is_told_at_once_even_while_mute(bad):
    said = look(begun(LIMITS), command=HOVER._replace(**bad))[1]
    assert (said.level, said.trigger) == (EMERGENCY, "controller")
    assert re.search("inf|nan", said.said)


def test_what_comes_of_an_estimate_that_is_no_number_is_blamed_on_nobody_else():
    given = {"reference": still(np.full(3, nan)), "command": HOVER._replace(f_d=nan)}
    ticks, said = speaks_after(estimate=HERE._replace(r=np.full(3, nan)), **given)
    assert (ticks, said.trigger) == (10, "state missing")


def test_before_anything_was_asked_there_is_nothing_to_compare():
    assert speaks_after(reference=None, command=None)[0] is None


# Mute, and in an emergency ------------------------------------------------------------------------------

WRONG = {
    "lost": {"reference": still(HERE.r + 5.0)},
    "control error": {"reference": still(np.add(HERE.r, (2.0, 0, 0)))},
    "heading error": {"reference": ASKED._replace(heading=3.0)},
    "tilt": {"estimate": HERE._replace(R=turned((1, 0, 0), 1.4))},
    "tilt error": {"command": HOVER._replace(omega_d=np.array((3.0, 0, 0)))},
    "throttle": {"command": HOVER._replace(f_d=90.0)},
    "solver": {"counts": True},
    "link": {"play": Play(heard=False)},
    "state missing": {"estimate": HERE._replace(r=np.full(3, nan))},
    "unreliable": {"estimate": HERE._replace(reliable=False)},
    "tracker": {"reference": ASKED._replace(heading=nan)},
    "controller": {"command": HOVER._replace(f_d=nan)},
}
TIMES = {"tilt error": 50, "throttle": 100, "solver": 50}
NEVER_MUTE = {"state missing": 10, "unreliable": 20, "tracker": 1, "controller": 1}


def test_every_trigger_but_a_jump_is_in_the_list_of_what_can_be_wrong():
    assert WRONG.keys() | {"jump"} == TRIGGERS.keys()


@pytest.mark.parametrize("trigger", WRONG)
def test_for_a_second_after_a_switch_only_what_is_missing_has_a_voice(trigger):
    switched, said = look(play=Play(switched=True))
    assert said == NOTHING
    ticks, said = speaks_after(memory=switched, **WRONG[trigger])
    wait = NEVER_MUTE.get(trigger) or 99 + TIMES.get(trigger, 1)
    assert ticks == (300 if trigger == "link" else wait)  # a silent link counts on meanwhile
    assert said.trigger == trigger
    assert said.level == TRIGGERS[trigger][0]


def test_a_jump_right_after_a_switch_is_that_of_the_switch():
    memory, _ = look(play=Play(switched=True))
    assert look(memory, HERE._replace(r=HERE.r + 9.0), still(HERE.r + 9.0))[1] == NOTHING


def test_a_watch_that_has_just_begun_is_mute_for_a_second():
    assert speaks_after(memory=begun(LIMITS), **WRONG["lost"])[0] == 100


@pytest.mark.parametrize("trigger", WRONG)
def test_in_an_emergency_what_can_still_be_landed_with_is_borne_and_all_else_falls(trigger):
    given = {**WRONG[trigger], "play": Play("emergency", emergency=True)}
    if trigger == "link":
        given["play"] = given["play"]._replace(heard=False)
    ticks, said = speaks_after(**given)
    assert said.level == TRIGGERS[trigger][1]
    assert (ticks is None) == (trigger in {"control error", "throttle", "solver", "link"})


def test_of_several_causes_the_gravest_speaks():
    both = HERE._replace(R=turned((1, 0, 0), 1.4))
    assert verdict(estimate=both, **WRONG["control error"]).trigger == "control error"
    assert verdict(estimate=both, **WRONG["lost"]).trigger == "lost"


def test_a_verdict_is_repeated_as_long_as_its_cause_is_there_and_no_longer():
    memory, said = look(**WRONG["lost"])
    memory, again = look(memory, **WRONG["lost"])
    assert said == again
    assert look(memory)[1] == NOTHING


# The limits ---------------------------------------------------------------------------------------------


def test_what_is_infinite_is_not_watched():
    deaf = Safety(
        bounds={"se3": Bounds(inf, inf, inf)}, heading_jump=inf, heading_error=inf, tilt=inf, tilt_error=inf,
        missing_time=inf, unreliable_time=inf, throttle_time=inf, unsolved_time=inf, unheard_time=inf, curve=CURVE,
    )  # fmt: skip
    for trigger, given in WRONG.items():
        ticks, _ = speaks_after(limits=checked(deaf), **given)
        assert (ticks is None) == (trigger not in {"tracker", "controller"})


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"tilt": 0.0}, "tilt is 0.0"),
        ({"throttle_time": nan}, "throttle_time is nan"),
        ({"bounds": {}}, "must have 'se3'"),
        ({"bounds": {"se3": Bounds(-1.0, 2.0, 1.0)}}, r"bounds\['se3'\].error is -1"),
        ({"bounds": {**BOUNDS, "mpc": Bounds(3.0, 2.0, 1.0)}}, "falls at 2.0 m and lands at 3.0 m"),
        ({"mute": inf}, "mute is inf"),
        ({"k_R": inf}, "k_R is inf"),
    ],
)
def test_limits_that_cannot_be_watched_are_refused_by_name(wrong, said):
    with pytest.raises(BadInput, match=said):
        checked(Safety(**wrong))


def test_the_kind_of_a_law_is_that_of_its_bounds():
    assert kind_of(MpcController(2.0)) == "mpc"
    assert kind_of(Emergency(2.0)) == "emergency"
    assert kind_of(TiltAxis(2.0)) == "se3"


def test_it_looks_the_same_from_every_world_and_leaves_its_inputs_alone():
    rng = np.random.default_rng(0)
    shift = Shift(np.array((3.0, -2.0, 0.5)), 2.4)
    heard = set()
    for _ in range(200):
        r = HERE.r + rng.normal(size=3) * rng.choice((0.1, 1.5))
        R = turned((0, 0, 1), rng.uniform(-3, 3)) @ turned((1, 0, 0), rng.normal() * 0.8)
        here, wants = (
            HERE._replace(r=r, R=R, v=rng.normal(size=3)),
            still(HERE.r, rng.uniform(-3, 3)),
        )
        memory, _ = look(estimate=here._replace(r=r + rng.normal(size=3)), reference=wants)
        after, said = look(memory, here, wants)
        there, told = look(reframed(memory, shift), moved(here, shift), moved(wants, shift))
        assert (said.level, said.trigger) == (told.level, told.trigger)
        np.testing.assert_allclose(moved(after.expected, shift).r, there.expected.r, atol=1e-9)
        heard.add(said.trigger)
    assert heard >= {"", "lost", "control error", "jump", "heading error"}
