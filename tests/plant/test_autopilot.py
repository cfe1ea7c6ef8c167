"""Rate loop, mixer and motors."""

import numpy as np
import pytest
from aircraft import command, state
from scipy.optimize import linprog

from uavlab.plant import (
    Airframe,
    CompiledPlant,
    ReadablePlant,
    airframe_names,
    load_airframe,
    thrusts,
)
from uavlab.solutions import dynamics

NAMES = ("rigid_body_rate", "step_on_so3", "allocation_matrix", "rotor_thrusts", "motor_step")


@pytest.fixture(params=airframe_names())
def airframe(request: pytest.FixtureRequest) -> Airframe:
    return load_airframe(request.param)


@pytest.fixture
def mix(airframe: Airframe, plain: None):
    """The compiled mixer as plain Python, returning what it writes."""
    from uavlab.plant import autopilot, constants

    packed = constants.unpacked(*constants.pack(airframe))

    def call(f: float, tau: np.ndarray) -> np.ndarray:
        out = np.empty(airframe.n)
        autopilot.mix(f, tuple(tau), packed, out)
        return out

    return call


def test_what_the_rotors_can_make_is_made_exactly(mix, airframe: Airframe):
    rng = np.random.default_rng(1)
    for _ in range(200):
        each = rng.uniform(airframe.thrust_min, airframe.thrust_max, airframe.n)
        u = airframe.allocation @ each
        got = mix(u[0], u[1:])
        inside = np.linalg.pinv(airframe.allocation) @ u
        if (inside >= airframe.thrust_min).all() and (inside <= airframe.thrust_max).all():
            np.testing.assert_allclose(airframe.allocation @ got, u, atol=1e-9)


def best(airframe: Airframe, f: float, tau: np.ndarray) -> tuple[float, float, float]:
    """By linear programming: the most tilt torque, then the nearest thrust, then the most yaw torque."""
    P = np.linalg.pinv(airframe.allocation)
    tilt, yaw = P[:, 1:3] @ tau[:2], P[:, 3] * tau[2]
    lo, hi = np.full(airframe.n, airframe.thrust_min), np.full(airframe.n, airframe.thrust_max)

    def most(column, fixed, bounds, extra=None):
        rows = [column] if extra is None else [column, extra]
        A = np.stack(rows, axis=1)
        cost = [-1.0] + [0.0] * (len(rows) - 1)
        found = linprog(cost, np.vstack((A, -A)), np.r_[hi - fixed, fixed - lo], bounds=bounds)
        assert found.success
        return float(found.x[0])

    share = most(tilt, 0 * tilt, [(0, 1), (None, None)], P[:, 0])
    span = [(None, None)]
    top = most(P[:, 0], share * tilt, span)
    bottom = -most(-P[:, 0], share * tilt, span)
    thrust = float(np.clip(f, bottom, top))
    return share, thrust, most(yaw, P[:, 0] * thrust + share * tilt, [(0, 1)])


def test_at_saturation_yaw_gives_way_then_thrust_then_tilt(mix, airframe: Airframe):
    rng = np.random.default_rng(2)
    cases = {"tilt": 0, "thrust": 0, "yaw": 0}
    for _ in range(40):
        f = airframe.m * 9.81 * rng.uniform(-0.5, 4.0)
        tau = rng.normal(size=3) * airframe.m * airframe.arm * rng.choice((1.0, 30.0)) * (1, 1, 0.1)
        got = mix(f, tau)
        assert (got >= airframe.thrust_min - 1e-12).all()
        assert (got <= airframe.thrust_max + 1e-12).all()
        share, thrust, yaw = best(airframe, f, tau)
        wish = (thrust, share * tau[0], share * tau[1], yaw * tau[2])
        np.testing.assert_allclose(airframe.allocation @ got, wish, rtol=1e-6, atol=1e-6)
        cases["tilt"] += share < 1
        cases["thrust"] += thrust != f
        cases["yaw"] += yaw < 1
    assert all(cases.values()), cases


def test_no_thrust_at_all_still_leaves_roll_and_pitch(mix, airframe: Airframe):
    tau = np.array((0.2, -0.1, 0.0)) * airframe.arm
    np.testing.assert_allclose((airframe.allocation @ mix(0.0, tau))[1:3], tau[:2], atol=1e-12)


def test_asking_for_more_than_everything_is_full_thrust_on_each_rotor(mix, airframe: Airframe):
    np.testing.assert_allclose(mix(1e6, np.zeros(3)), airframe.thrust_max)
    np.testing.assert_allclose(mix(-5.0, np.zeros(3)), airframe.thrust_min)


def test_the_readable_mixer_is_the_compiled_one(mix, airframe: Airframe):
    functions = {name: getattr(dynamics, name) for name in NAMES}
    readable = ReadablePlant(airframe, **functions)
    rng = np.random.default_rng(3)
    for scale in (0.1, 1.0, 10.0, 100.0):
        for _ in range(20):
            f = airframe.m * 9.81 * rng.uniform(-1, 5)
            tau = rng.normal(size=3) * scale
            np.testing.assert_allclose(mix(f, tau), readable.mix(f, tau), rtol=0, atol=1e-11)


def test_rotor_speed_follows_an_exact_lag_whatever_the_step(airframe: Airframe):
    plant = CompiledPlant(airframe)
    first = plant.init(state())
    f = 1.3 * airframe.m * 9.81
    target = np.sqrt(f / airframe.n / airframe.thrust_coefficient)
    for n in (1, 7, 50):
        world = plant.advance(first, command(f), dt=0.05, n=n)
        want = target + (first.speed - target) * np.exp(-0.05 / airframe.motor_tau)
        np.testing.assert_allclose(world.speed, want, rtol=1e-9)


def test_hover_thrust_hovers(airframe: Airframe):
    plant = CompiledPlant(airframe)
    world = plant.init(state())
    assert thrusts(world, airframe).sum() == pytest.approx(airframe.m * 9.81)
    for _ in range(200):
        world = plant.advance(world, command(airframe.m * 9.81))
    assert world.r == pytest.approx((0, 0, 100), abs=1e-9)
    assert pytest.approx(np.eye(3), abs=1e-9) == world.R


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_step_of_body_rate_is_reached_quickly_and_without_much_overshoot(airframe, axis: int):
    plant = CompiledPlant(airframe)
    world = plant.init(state())
    omega_d = 0.2 * np.eye(3)[axis]
    seen = []
    for _ in range(120):
        world = plant.advance(world, command(airframe.m * 9.81, omega_d))
        seen.append(world.omega)
    rates = np.array(seen)[:, axis] / 0.2
    assert rates.max() < 1.08
    late, soon = round(30 * airframe.motor_tau / 0.01), round(5 * airframe.motor_tau / 0.01)
    assert np.abs(rates[min(late, 110) :] - 1.0).max() < 0.01
    assert rates[soon] > (0.9 if axis < 2 else 0.6)
    assert np.abs(np.delete(np.array(seen), axis, axis=1)).max() < 1e-3


def test_gyroscopic_torque_does_not_hold_the_rates_away_from_what_is_asked():
    a = load_airframe("T650")
    plant = CompiledPlant(a)
    world = plant.init(state((0, 0, 1000)))
    asked = np.array((1.5, 2.0, 0.3))
    for _ in range(80):
        world = plant.advance(world, command(a.m * 9.81, asked))
    assert world.omega == pytest.approx(asked, abs=0.02)


def test_commands_are_turned_at_a_kilohertz_by_default():
    plant = CompiledPlant(load_airframe("F450"))
    world = plant.init(state(omega=(0, 0, 1)))
    asked = command(17.0, (3.0, 0.0, 0.0))
    default = plant.advance(world, asked, dt=0.02)
    np.testing.assert_array_equal(default.R, plant.advance(world, asked, dt=0.02, n=20).R)
    assert np.abs(default.R - plant.advance(world, asked, dt=0.02, n=5).R).max() > 1e-6
