"""The rigid body in air, against conservation laws, closed forms and scipy."""

import numpy as np
import pytest
from aircraft import command, state, without_rotors
from scipy.integrate import solve_ivp

from uavlab import so3
from uavlab.plant import Airframe, CompiledPlant, airframe_names, load_airframe, thrusts

G = 9.81


def spinning(airframe: Airframe, omega: tuple, seconds: float) -> tuple[float, float]:
    """The largest relative change of energy and of angular momentum (as a vector, in the world)."""
    airframe = without_rotors(airframe)._replace(drag_body=0.0)
    plant = CompiledPlant(airframe)
    world = plant.init(state((0, 0, 1e5), w=(0.3, -0.2, 0.5), omega=omega))
    J = airframe.J
    energy, momentum = [], []
    for _ in range(round(seconds * 100)):
        energy.append(0.5 * world.omega @ J @ world.omega)
        momentum.append(world.R @ J @ world.omega)
        world = plant.advance(world, command(0.0))
    d_energy = np.abs(np.array(energy) / energy[0] - 1.0).max()
    d_momentum = np.linalg.norm(np.array(momentum) - momentum[0], axis=1).max()
    return float(d_energy), float(d_momentum / np.linalg.norm(momentum[0]))


@pytest.mark.parametrize("omega", [(3, -2, 9), (6, 6, 6), (0.01, 10, 0.01), (10, 0.1, -8)])
@pytest.mark.parametrize("inertia", [(0.023, 0.023, 0.043), (0.02, 0.035, 0.05)])
def test_a_spin_without_torque_keeps_energy_and_angular_momentum_for_a_minute(omega, inertia):
    J = np.diag(inertia)
    airframe = load_airframe("F450")._replace(J=J, J_inv=np.linalg.inv(J))
    d_energy, d_momentum = spinning(airframe, omega, 60.0)
    assert d_energy < 1e-9
    assert d_momentum < 1e-9


@pytest.mark.slow
def test_rotation_stays_a_rotation_for_an_hour_of_tumbling():
    plant = CompiledPlant(load_airframe("X500"))
    world = plant.init(state((0, 0, 1e6)))
    worst = 0.0
    for k in range(360_000):
        if k % 50 == 0:
            rates = (3 * np.sin(k / 700), 4 * np.cos(k / 1100), 2 * np.sin(k / 300))
            asked = command(25.0, rates)
            worst = max(worst, np.abs(world.R @ world.R.T - np.eye(3)).max())
        world = plant.advance(world, asked)
    assert worst < 1e-12
    assert np.linalg.det(world.R) == pytest.approx(1.0, abs=1e-12)


def ode(airframe: Airframe, start, f: float, wind: np.ndarray, end: float) -> np.ndarray:
    """r, v, ω and R of a torque-free body under constant thrust, by scipy."""
    a = airframe

    def rate(_t, y):
        v, R, w = y[3:6], y[6:15].reshape(3, 3), y[15:18]
        air = v - wind
        V = R.T @ air
        F = R @ np.array((0, 0, f)) - a.drag_rotor * np.sqrt(a.m * f) * R @ (V * (1, 1, 0))
        F = F - a.drag_body * np.linalg.norm(air) * air
        w_dot = a.J_inv @ -np.cross(w, a.J @ w)
        return np.concatenate((v, F / a.m - (0, 0, G), (R @ so3.hat(w)).ravel(), w_dot))

    y0 = np.concatenate((start.r, start.v, start.R.ravel(), start.omega))
    return solve_ivp(rate, (0, end), y0, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]


def thrust_only(airframe: Airframe) -> Airframe:
    """Rotors that push along z and cannot turn the body."""
    return airframe._replace(allocation=airframe.allocation * [[1], [0], [0], [0]])


def flown(airframe: Airframe, start, f: float, wind: np.ndarray, end: float, rate: float):
    plant = CompiledPlant(airframe)
    world = plant.advance(plant.init(start), command(f), wind, end, round(end * rate))
    return np.concatenate((world.r, world.v, world.R.ravel(), world.omega))


def test_a_spinning_body_under_hover_thrust_in_wind_moves_as_scipy_says():
    airframe = thrust_only(load_airframe("T650"))
    start = state((0, 0, 90), v=(3, -2, 1), w=(0.5, 0.2, -1), omega=(4, -3, 5))
    f, wind = airframe.m * G, np.array((-4.0, 2.0, 0.5))
    got = flown(airframe, start, f, wind, 2.0, 1000)
    np.testing.assert_allclose(got, ode(airframe, start, f, wind, 2.0), rtol=1e-9, atol=1e-9)


def test_the_error_falls_with_the_fourth_power_of_the_step():
    airframe = thrust_only(load_airframe("T650"))
    start = state((0, 0, 90), v=(3, -2, 1), w=(0.5, 0.2, -1), omega=(4, -3, 5))
    f, wind = airframe.m * G, np.array((-4.0, 2.0, 0.5))
    true = ode(airframe, start, f, wind, 1.0)
    errors = [np.abs(flown(airframe, start, f, wind, 1.0, hz) - true).max() for hz in (25, 50, 100)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 3.6).all(), orders


def test_a_fall_approaches_the_speed_where_drag_carries_the_weight():
    airframe = without_rotors(load_airframe("F450"))
    plant = CompiledPlant(airframe)
    limit = np.sqrt(airframe.m * G / airframe.drag_body)
    world = plant.init(state((0, 0, 1000)))
    for _ in range(200):
        world = plant.advance(world, command(0.0))
    t = 2.0
    assert world.v[2] == pytest.approx(-limit * np.tanh(G * t / limit), rel=1e-9)
    assert world.r[2] == pytest.approx(1000 - limit**2 / G * np.log(np.cosh(G * t / limit)))


@pytest.mark.parametrize("name", airframe_names())
def test_in_hover_thrust_the_rotors_drag_with_the_root_of_thrust(name: str):
    a = load_airframe(name)
    plant = CompiledPlant(a)
    V = 2.0
    world = plant.advance(plant.init(state(v=(V, 0, 0))), command(a.m * G), dt=1e-6, n=1)
    lateral = -0.0794 * np.sqrt(G) * V - a.drag_body * V**2 / a.m
    assert world.a == pytest.approx((lateral, 0, 0), abs=1e-5)


def test_climbing_along_the_rotor_axis_meets_no_rotor_drag():
    a = load_airframe("F450")._replace(drag_body=0.0)
    plant = CompiledPlant(a)
    world = plant.init(state(v=(0, 0, 5)))
    assert plant.advance(world, command(a.m * G)).v == pytest.approx((0, 0, 5), abs=1e-9)


def test_only_motion_through_the_air_counts():
    plant = CompiledPlant(load_airframe("F550"))
    wind = np.array((3.0, -2.0, 0.7))
    still = plant.init(state(v=(1, 2, 0), w=(0.2, 0.1, 0.3), omega=(0.5, 0.1, -0.2)))
    drifting = still._replace(v=still.v + wind)
    asked = command(25.0, (0.3, -0.2, 0.1))
    for _ in range(100):
        still = plant.advance(still, asked)
        drifting = plant.advance(drifting, asked, wind)
    np.testing.assert_allclose(drifting.v - wind, still.v, atol=1e-11)
    np.testing.assert_allclose(drifting.r - wind * 1.0, still.r, atol=1e-11)
    np.testing.assert_allclose(drifting.R, still.R, atol=1e-12)


def test_the_world_looks_the_same_from_another_heading():
    plant = CompiledPlant(load_airframe("T650"))
    Rz = so3.about_z(1.1)
    wind = np.array((3.0, -2.0, 0.7))
    one = plant.init(state(v=(1, 2, 0), w=(0.2, 0.1, 0.3), omega=(0.5, 0.1, -0.2)))
    two = one._replace(r=Rz @ one.r, v=Rz @ one.v, R=Rz @ one.R)
    asked = command(35.0, (0.3, -0.2, 0.1))
    for _ in range(100):
        one, two = plant.advance(one, asked, wind), plant.advance(two, asked, Rz @ wind)
    np.testing.assert_allclose(two.r, Rz @ one.r, atol=1e-10)
    np.testing.assert_allclose(two.R, Rz @ one.R, atol=1e-11)


def test_acceleration_is_the_slope_of_velocity():
    plant = CompiledPlant(load_airframe("F450"))
    world = plant.init(state(v=(4, -1, 2), w=(0.4, -0.3, 1), omega=(1, 2, -1)))
    assert world.a == pytest.approx(slope(plant, world), abs=1e-4)
    for _ in range(20):
        world = plant.advance(world, command(30.0, (2, -1, 0.5)), np.array((1.0, 2.0, 0.0)))
    later = plant.advance(world, command(30.0, (2, -1, 0.5)), np.array((1.0, 2.0, 0.0)), 1e-6, 1)
    assert world.a == pytest.approx((later.v - world.v) / 1e-6, abs=1e-3)


def slope(plant: CompiledPlant, world) -> np.ndarray:
    f = thrusts(world, plant.airframe).sum()
    later = plant.advance(world, command(f, world.omega), dt=1e-6, n=1)
    return (later.v - world.v) / 1e-6


def test_advancing_leaves_the_world_before_as_it_was():
    plant = CompiledPlant(load_airframe("F450"))
    world = plant.init(state(v=(4, -1, 2)))
    before = [np.copy(x) for x in world]
    plant.advance(world, command(30.0, (2, -1, 0.5)))
    for was, now in zip(before, world, strict=True):
        np.testing.assert_array_equal(was, now)
