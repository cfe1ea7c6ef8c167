"""The sticks are held as the scenario tells, each line until the next, and arrive late."""

import numpy as np
import pytest
from truth import kept, watch

from uavlab import scenarios
from uavlab.errors import BadInput
from uavlab.frames import Shift, moved
from uavlab.sensors import Hold, Jump, Outage, Receiver

HOLDS = (Hold(0.5, True, (1.0, 0.0, -0.5), 0.2), Hold(1.0), Hold(1.5, failsafe=True))


def arrived(receiver, ticks=200):
    return kept(watch(receiver, ticks))


def test_the_sticks_are_held_as_told_from_a_time_until_the_next():
    for x in arrived(Receiver(holds=HOLDS)):
        want = [h for h in (Hold(0.0), *HOLDS) if h.t <= x.t + 1e-9][-1]
        assert (x.engaged, x.failsafe, x.turn) == (want.engaged, want.failsafe, want.turn)
        np.testing.assert_array_equal(x.push, want.push)


def test_messages_come_at_their_rate_a_little_late_and_not_in_an_outage():
    ticks = watch(Receiver(outages=(Outage(0.4, 1.0),)), 200)
    times = [(k * 0.01, x.t) for k, x in enumerate(ticks) if x is not None]
    assert len(times) == pytest.approx(0.7 * 100, abs=2)
    assert all(now - t == pytest.approx(0.02) for now, t in times)
    assert not any(0.4 <= t < 1.0 - 1e-9 for _, t in times)


def test_lines_of_plain_tuples_are_taken_too():
    x = arrived(Receiver(holds=((0.0, True, (0.0, 1.0, 0.0), 0.0, False),)))[-1]
    assert x.engaged
    np.testing.assert_array_equal(x.push, (0.0, 1.0, 0.0))


def test_a_hand_that_trembles_stays_within_the_way_of_the_sticks():
    seen = arrived(Receiver(holds=(Hold(0.0, True, (1.0, 0.0, 0.0)),), tremble=0.1), 400)
    push = np.array([x.push for x in seen])
    assert push[:, 0].max() == 1.0
    assert push[:, 1].std() == pytest.approx(0.1, rel=0.3)


def test_a_trim_that_slips_moves_the_sticks_and_no_farther_than_their_end():
    slips = Receiver(
        holds=(Hold(0.0, True, (0.9, 0.0, 0.0)),), jumps=(Jump(1.0, (0.2, 0.1, 0, 0)),)
    )
    before, after = (x.push for x in (arrived(slips)[0], arrived(slips)[-1]))
    np.testing.assert_allclose((before[:2], after[:2]), ((0.9, 0.0), (1.0, 0.1)))


def test_sticks_are_the_same_in_every_world():
    x = arrived(Receiver(holds=HOLDS), 60)[-1]
    there = moved(x, Shift(np.ones(3), 1.0))
    assert x.engaged
    np.testing.assert_array_equal(there.push, x.push)
    assert there[3:] == x[3:]


@pytest.mark.parametrize(
    ("holds", "said"),
    [
        ((Hold(1.0), Hold(1.0)), r"holds\[1\].t is 1.0 s after 1.0 s"),
        ((Hold(float("nan")),), r"holds\[0\].t is nan"),
        ((Hold(0.0, True, (1.1, 0.0, 0.0)),), r"holds\[0\] pushes"),
        ((Hold(0.0, True, (1.0, 0.0)),), r"three for push"),
        ((Hold(0.0, turn=-2.0),), "turns -2.0"),
    ],
)
def test_sticks_that_cannot_be_held_so_are_refused(holds, said):
    with pytest.raises(BadInput, match=said):
        Receiver(holds=holds).init(np.random.default_rng(0))


SAID = """
airframe = "F450"
duration = 1.0
[mission]
kind = "waypoints"
stops = [{ t = 0.0, r = [0, 0, 2] }]
[sensors]
kit = "guarded"
[sensors.sectors]
n = 12
[sensors.remote]
holds = [{ t = 0.5, engaged = true, push = [1, 0, 0] }, { t = 0.8 }]
"""


def test_a_file_says_how_the_sticks_are_held(tmp_path):
    path = tmp_path / "sticks.toml"
    path.write_text(SAID)
    carried = scenarios.load(str(path)).sensors
    held = arrived(carried["remote"], 100)
    assert [x.engaged for x in held] == [0.5 <= x.t + 1e-9 < 0.8 for x in held]
    assert kept(watch(carried["sectors"], 1))[0].d.shape == (12,)


def test_a_file_that_pushes_a_switch_half_way_is_refused(tmp_path):
    path = tmp_path / "sticks.toml"
    path.write_text(SAID.replace("engaged = true", "engaged = 0.5"))
    with pytest.raises(BadInput, match=r"engaged is 0\.5; it must be true or false"):
        scenarios.load(str(path))
