"""The bank of lab 03, flown: five members in five worlds, and what they do when an instrument fails."""

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose

from uavlab import frames, so3
from uavlab.errors import BadInput, UnknownName
from uavlab.solutions.kalman_bank import KalmanBank, translation_model
from uavlab.types import Attitude, Command, Estimate, Fix, Flow, Height, Imu, Pose, Range, Shift

ZERO, DT = np.zeros(3), 0.01
NOISE = {
    "imu.heading_rate": 1e-4, "gnss.velocity": 1e-3, "gnss.position": 1e-3, "barometer.height": 1e-3,
    "rtk.position": 1e-3, "rtk.height": 1e-3, "slam.heading": 1e-4, "slam.position": 1e-3,
    "slam.height": 1e-3, "flow.velocity": 1e-3, "rangefinder.height": 1e-3,
}  # fmt: skip
GYRO = "imu.heading_rate"
MEMBERS = {
    "gnss": (GYRO, "gnss.velocity", "gnss.position", "barometer.height"),
    "rtk": (GYRO, "rtk.position", "rtk.height"),
    "slam": (GYRO, "slam.heading", "slam.position", "slam.height"),
    "flow": (GYRO, "flow.velocity", "rangefinder.height"),
    "flow+slam": (GYRO, "slam.heading", "flow.velocity", "slam.position", "slam.height"),
}
WORLDS = {  # where each member's world lies
    "gnss": Shift(np.array((3.0, -2.0, 0.5)), 0.0),
    "rtk": Shift(ZERO, 0.0),
    "slam": Shift(np.array((1.0, 1.0, 1.0)), 0.8),
    "flow": Shift(ZERO, 0.0),
    "flow+slam": Shift(np.array((1.0, 1.0, 1.0)), 0.8),
}


JUMP = np.array((5.0, 0.0, 0.0))  # [m]


def truth(t):
    """A circle of 2 m in 6 s with the nose turning, in the tilt that it needs."""
    w, c, s = 1.0, np.cos(t), np.sin(t)
    r, v, a = (
        np.array((2 * c, 2 * s, 2.0)),
        2 * w * np.array((-s, c, 0)),
        -2 * w * np.array((c, s, 0)),
    )
    pull = a + np.array((0.0, 0.0, 9.81))
    b3 = pull / np.linalg.norm(pull)
    eta = 3.0 + 0.5 * t
    side = np.cross(b3, (np.cos(eta), np.sin(eta), 0.0))
    b2 = side / np.linalg.norm(side)
    return r, v, a, np.column_stack((np.cross(b2, b3), b2, b3))


def readings(k, rng=None):
    """What five instruments tell of it, each in its own world."""
    t, rng = k * DT, rng or np.random.default_rng(k)
    r, v, _, R = truth(t)
    told = {"imu": Imu(t, ZERO, so3.log(R.T @ truth(t + 1e-5)[3]) / 1e-5)}
    told["attitude"] = Attitude(t, so3.about_z(-1.1) @ R)
    if k % 10 == 0 and k > 10:
        then_r, then_v, _, _ = truth(t - 0.1)
        told["gnss"] = frames.moved(Fix(t - 0.1, then_r, then_v), WORLDS["gnss"])
    if k % 5 == 0:
        told["rtk"], told["slam"] = Fix(t, r, v), frames.moved(Pose(t, r, R), WORLDS["slam"])
        told["barometer"], told["flow"] = Height(t, r[2] + 0.5), Flow(t, (R.T @ v)[:2])
        told["rangefinder"] = Range(t, r[2] / R[2, 2])
    return told


def fly(bank, steps, *, change=lambda k, told: told, start=None, flies="rtk"):
    """Memory, and hypotheses of each step."""
    r, v, a, R = truth(0.0)
    memory, said = bank.init(start or Estimate(r, v, a, R, ZERO, "rtk")), []
    for k in range(1, steps + 1):
        command = Command(0.0, ZERO, truth((k - 1) * DT)[2])
        memory, told = bank.step(memory, change(k, readings(k)), command, DT, flies)
        said.append(told)
    return memory, said


@cache
def calm():
    """Two hundred steps in which nothing goes wrong."""
    return fly(KalmanBank(MEMBERS, NOISE, start=(0.1,) * 5), 200)


def test_each_member_finds_the_aircraft_in_its_own_world():
    memory, said = calm()
    r, v, _, R = truth(200 * DT)
    for name, x in said[-1].items():
        there = frames.moved(Pose(0.0, r, R), WORLDS[name])
        assert x.reliable
        assert_allclose(x.x[:, 0], there.r, atol=0.25 if name == "flow" else 0.05)
        assert_allclose(x.x[:, 1], so3.about_z(WORLDS[name].heading) @ v, atol=0.1)
        assert abs(frames.wrap(x.h[0] - frames.heading(there.R))) < 0.02
    assert set(KalmanBank(MEMBERS, NOISE).rejected(memory).values()) == {0}


def test_a_late_fix_does_not_lag_behind_a_fast_aircraft():
    _, said = calm()
    off = [
        x["gnss"].x[:2, 0] - truth((k + 1) * DT)[0][:2] - (3.0, -2.0) for k, x in enumerate(said)
    ]
    assert np.abs(off[100:]).max() < 0.06  # taken for one of now it would be 0.2 m behind


def test_with_flow_alone_the_position_is_known_less_and_less_and_with_slam_it_is_not():
    _, said = calm()
    early, late = ({k: x.P[0, 0, 0] for k, x in said[i].items()} for i in (50, 199))
    assert late["flow"] > 2.0 * early["flow"]
    assert late["flow+slam"] < 1.5 * early["flow+slam"]


def test_nan_readings_and_wild_ones_are_counted_and_the_flight_goes_on():
    def spoiled(k, told):
        if k == 100:
            told["rtk"] = told["rtk"]._replace(r=told["rtk"].r * np.nan)
        if k == 105:
            told["rtk"] = told["rtk"]._replace(r=told["rtk"].r + 50.0)
        if k == 110:
            told["slam"] = told["slam"]._replace(t=0.1)
        return told

    bank = KalmanBank(MEMBERS, NOISE)
    memory, said = fly(bank, 120, change=spoiled)
    assert bank.rejected(memory) == {"gnss": 0, "rtk": 3, "slam": 1, "flow": 0, "flow+slam": 1}
    assert_allclose(said[-1]["rtk"].x[:, 0], truth(1.2)[0], atol=0.05)


def test_a_lost_instrument_takes_its_members_along_and_only_these():
    def without_slam(k, told):
        return {name: x for name, x in told.items() if name != "slam" or k < 60}

    _, said = fly(KalmanBank(MEMBERS, NOISE, patience=0.4), 120, change=without_slam)
    assert [x["slam"].reliable for x in said[50:120:23]] == [True, True, False, False]
    sick = {"slam", "flow+slam"}
    assert {name for name, x in said[-1].items() if not x.reliable} == sick


def test_a_jump_of_the_camera_s_map_is_not_believed_until_it_is_all_that_is_said():
    def jumped(k, told):
        if "slam" in told and k >= 60:
            told["slam"] = told["slam"]._replace(r=told["slam"].r + JUMP)
        return told

    bank = KalmanBank(MEMBERS, NOISE, patience=0.4, forget=0.2)
    _, said = fly(bank, 130, change=jumped)
    assert not said[70]["slam"].reliable
    before = frames.moved(Pose(0.0, *truth(0.71)[::3]), WORLDS["slam"]).r
    assert_allclose(said[70]["slam"].x[:, 0], before, atol=0.1)
    after = frames.moved(Pose(0.0, *truth(1.3)[::3]), WORLDS["slam"]).r + JUMP
    assert_allclose(said[-1]["slam"].x[:, 0], after, atol=0.1)


def test_the_health_is_about_one_when_all_is_well():
    bank = KalmanBank({"b": ("barometer.height",)}, {"barometer.height": 0.04}, q_z=(0.1, 1.0, 1.0))
    total, runs = 0.0, 25
    A, B = translation_model(DT, 0.9)
    for seed in range(runs):
        rng = np.random.default_rng(seed)
        memory = bank.init(Estimate(ZERO, ZERO, ZERO, np.eye(3), ZERO, "b"))
        x = rng.normal(size=3)
        for k in range(1, 31):
            u = rng.normal(size=1)
            x = A @ x + B @ u + np.sqrt(DT * np.array((0.1, 1.0, 1.0))) * rng.normal(size=3)
            z = Height(k * DT, x[0] + 0.2 * rng.normal())
            command = Command(0.0, ZERO, np.array((0.0, 0.0, u[0])))
            memory, told = bank.step(memory, {"barometer": z}, command, DT)
        total += told["b"].nis
    assert abs(total / runs - 1.0) < 0.25


def test_one_filter_for_all_follows_the_metres_between_two_receivers_and_a_bank_does_not():
    together = {"all": ("gnss.position", "rtk.position"), "gnss": ("gnss.position",)}
    bank = KalmanBank(together, NOISE, gate=np.inf, limits=(1e9, 1e9))
    memory, seen = bank.init(Estimate(ZERO, ZERO, ZERO, np.eye(3), ZERO, "all")), []
    for k in range(1, 200):
        told = {"gnss": Fix(k * DT, np.array((3.0, 0.0, 0.0)), ZERO)}
        told |= {"rtk": Fix(k * DT, ZERO, ZERO)} if k >= 100 else {}
        memory, x = bank.step(memory, told, Command(0.0, ZERO, ZERO), DT)
        seen.append((x["all"].x[0, 0], x["all"].x[0, 1], x["gnss"].x[0, 0]))
    seen = np.array(seen)
    assert abs(seen[98, 0] - 3.0) < 0.05
    assert 1.0 < seen[-1, 0] < 2.0
    assert np.abs(seen[99:, 1]).max() > 1.0  # a velocity that nobody flew
    assert np.abs(seen[50:, 2] - 3.0).max() < 0.05


def test_a_bank_that_cannot_be_is_refused_with_the_nearest_name():
    with pytest.raises(UnknownName, match=r"Did you mean 'gnss\.position'"):
        KalmanBank({"a": ("gnss.positions",)}, {"gnss.positions": 1.0})
    with pytest.raises(UnknownName, match=r"no variance named 'gnss\.position'"):
        KalmanBank({"a": ("gnss.position",)}, {})
    with pytest.raises(BadInput, match="hears nothing"):
        KalmanBank({"a": ()}, {})
    with pytest.raises(BadInput, match=r"variance of gnss\.position is -1"):
        KalmanBank({"a": ("gnss.position",)}, {"gnss.position": -1.0})
    with pytest.raises(BadInput, match="patience = 0"):
        KalmanBank({"a": ("gnss.position",)}, {"gnss.position": 1.0}, patience=0.0)
    bank = KalmanBank({"a": ("gnss.position",)}, {"gnss.position": 1.0})
    memory = bank.init(Estimate(ZERO, ZERO, ZERO, np.eye(3), ZERO))
    with pytest.raises(UnknownName, match="no member named 'b'"):
        bank.step(memory, {}, Command(0.0, ZERO, ZERO), DT, "b")


def test_a_step_leaves_its_memory_as_it_was():
    bank = KalmanBank(MEMBERS, NOISE)
    memory, _ = fly(bank, 5)
    before = repr(memory)
    first = bank.step(memory, readings(10), Command(0.0, ZERO, np.ones(3)), DT)[1]
    bank.reframe(memory, Shift(np.ones(3), 1.0))
    second = bank.step(memory, readings(10), Command(0.0, ZERO, np.ones(3)), DT)[1]
    assert repr(memory) == before
    assert repr(first) == repr(second)
