"""Motors that make a share of their thrust, autopilots that do without the dead ones, and loads."""

import numpy as np
import pytest
from aircraft import command, state
from scipy.optimize import linprog

from uavlab.errors import BadInput
from uavlab.plant import CompiledPlant, build_airframe, load_airframe, thrusts
from uavlab.plant.reallocation import reallocated

G = 9.81
F550 = load_airframe("F550")
OPPOSITE = {0: 1, 1: 0, 2: 3, 3: 2, 4: 5, 5: 4}


def flown(plant, world, asked, ticks, **broken):
    for _ in range(ticks):
        world = plant.advance(world, asked, **broken)
    return world


# Shares -----------------------------------------------------------------------------------------------


def test_motors_that_make_all_of_their_thrust_change_nothing_to_the_last_bit(make_plant):
    plant = make_plant(F550)
    world, asked = plant.init(state(omega=(1, -2, 0.5))), command(25.0, (1.0, 0.5, -0.3))
    whole = plant.advance(world, asked, shares=np.ones(6))
    for a, b in zip(plant.advance(world, asked), whole, strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_motor_makes_the_share_of_what_is_asked_of_it_once_its_lag_has_passed(make_plant):
    plant, shares = make_plant(F550), np.array((0.7, 1.0, 0.0, 1.0, 0.25, 1.0))
    heavy = plant.init(state((0, 0, 0)))  # held by the ground: no rate loop moves the thrusts
    world = flown(plant, heavy, command(8.0), 60, shares=shares)
    assert world.contact
    np.testing.assert_allclose(thrusts(world, F550), shares * 8.0 / 6.0, atol=1e-6)


def test_a_dead_motor_runs_down_with_its_lag_and_no_faster():
    plant = CompiledPlant(F550)
    before = plant.init(state())
    world = plant.advance(before, command(F550.m * G), dt=0.03, shares=np.array((0, 1, 1, 1, 1, 1)))
    assert world.speed[0] == pytest.approx(before.speed[0] * np.exp(-0.03 / F550.motor_tau))


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        ({"shares": np.ones(4)}, r"shares are .*F550 needs 6 numbers"),
        ({"shares": np.array((1, 1, 1, 1, 1, -0.1))}, "numbers ≥ 0"),
        ({"shares": np.array((1, 1, 1, 1, 1, np.nan))}, "numbers ≥ 0"),
        ({"dead": (6,)}, "rotor 6 is dead, but F550 has rotors 0 to 5"),
        ({"dead": (-1,)}, "rotor -1 is dead"),
    ],
)
def test_shares_and_rotors_that_cannot_be_are_refused(broken, said):
    plant = CompiledPlant(F550)
    with pytest.raises(BadInput, match=said):
        plant.advance(plant.init(state()), command(20.0), **broken)


# Allocation without the dead ones ---------------------------------------------------------------------


@pytest.mark.parametrize("rotor", range(6))
def test_thrust_and_tilt_without_a_dead_rotor_are_made_exactly_with_the_least_thrusts(rotor):
    mixer, still = reallocated(F550, F550.allocation, (rotor,))
    assert still == tuple(sorted((rotor, OPPOSITE[rotor])))
    np.testing.assert_allclose((F550.allocation @ mixer)[:3], np.eye(4)[:3], atol=1e-12)
    assert not mixer[list(still)].any()
    assert not mixer[:, 3].any()  # yaw is given up
    rng = np.random.default_rng(rotor)
    alive = [i for i in range(6) if i not in still]
    for _ in range(20):  # any other way to make the same takes more
        wish = rng.normal(size=3) * (5.0, 0.3, 0.3)
        other, *_ = np.linalg.lstsq(F550.allocation[:3, alive], wish, rcond=None)
        assert np.linalg.norm(mixer[:, :3] @ wish) == pytest.approx(np.linalg.norm(other))


@pytest.mark.parametrize("rotor", range(6))
def test_no_five_rotors_hover_without_turning_while_the_opposite_one_idles(rotor):
    """By linear programming: what the autopilot is spared is impossible."""
    idle = np.array([0.0 if i == rotor else F550.thrust_min for i in range(6)])
    most = np.array([0.0 if i == rotor else F550.thrust_max for i in range(6)])
    bounds = list(zip(idle, most, strict=True))
    spin = F550.allocation[3] * np.sign(F550.spins[rotor])
    found = linprog(-spin, A_eq=F550.allocation[:3], b_eq=(F550.m * G, 0, 0), bounds=bounds)
    assert found.success
    least = found.fun / F550.J[2, 2]
    assert least == pytest.approx(3 * F550.torque_ratio * F550.thrust_min / F550.J[2, 2], rel=1e-6)
    assert least == pytest.approx(0.19, abs=0.005)  # [rad/s²], which the module tells of


def test_an_octocopter_keeps_yaw_without_a_rotor():
    octo = build_airframe(
        "octo", mass=3.0, inertia=np.array((0.05, 0.05, 0.09)), arm=0.3,
        angles=np.arange(8) * np.pi / 4, spins=np.where(np.arange(8) % 2, 1.0, -1.0),
        torque_ratio=0.02, thrust_coefficient=1e-5, speed_min=80.0, speed_max=950.0,
        motor_tau=0.03, drag_body=0.05, drag_rotor=0.05, rate_gain=np.array((15.0, 15.0, 8.0)),
    )  # fmt: skip
    mixer, still = reallocated(octo, octo.allocation, (3,))
    assert still == (3,)
    np.testing.assert_allclose(octo.allocation @ mixer, np.eye(4), atol=1e-12)
    plant = CompiledPlant(octo)
    shares = np.where(np.arange(8) == 3, 0.0, 1.0)
    asked = command(octo.m * G, (0.0, 0.0, 0.5))
    world = flown(plant, plant.init(state()), asked, 150, shares=shares, dead=(3,))
    assert world.omega == pytest.approx((0, 0, 0.5), abs=1e-3)


@pytest.mark.parametrize("rotor", range(6))
def test_a_hexacopter_turns_tilt_rates_as_asked_on_four_rotors(rotor, make_plant):
    plant = make_plant(F550)
    shares = np.where(np.arange(6) == rotor, 0.0, 1.0)
    broken = {"shares": shares, "dead": (rotor,)}
    asked = command(F550.m * G, (0.2, -0.3, 0.0))
    world = flown(plant, plant.init(state()), asked, 60, **broken)
    assert world.omega[:2] == pytest.approx((0.2, -0.3), abs=0.02)
    assert thrusts(world, F550)[[rotor, OPPOSITE[rotor]]] == pytest.approx((0, 0), abs=1e-3)
    assert thrusts(world, F550).sum() == pytest.approx(F550.m * G, rel=1e-3)


def test_a_mixer_at_its_limits_keeps_every_rotor_within_them_and_the_tilt_torque_that_fits(plain):
    from uavlab.plant import autopilot, constants

    numbers, allocation, _ = constants.pack(F550)
    mixer, still = reallocated(F550, F550.allocation, (0,))
    packed = constants.unpacked(numbers, allocation, mixer)
    rng, out = np.random.default_rng(4), np.empty(6)
    alive = [i for i in range(6) if i not in still]
    cut = 0
    for _ in range(200):
        f, tau = F550.m * G * rng.uniform(-0.5, 2.5), rng.normal(size=3) * rng.choice((0.3, 3.0))
        autopilot.mix(f, tuple(tau), packed, out)
        assert (out >= F550.thrust_min - 1e-12).all()
        assert (out <= F550.thrust_max + 1e-12).all()
        made = F550.allocation[:3, alive] @ out[alive]
        share = float(made[1:] @ tau[:2] / (tau[:2] @ tau[:2]))
        np.testing.assert_allclose(made[1:], share * tau[:2], atol=1e-9)  # tilt keeps its direction
        cut += share < 1.0 - 1e-9
    assert 20 < cut < 180


# Loads ------------------------------------------------------------------------------------------------


def test_a_load_makes_heavier_and_leaves_the_drag_of_the_rotors_as_it_was():
    plant = CompiledPlant(F550).laden(0.7)
    assert plant.airframe.m == pytest.approx(3.0)
    world = plant.advance(plant.init(state(v=(2, 0, 0))), command(3.0 * G), dt=1e-5, n=1)
    bare = F550.drag_rotor * np.sqrt(F550.m * 3.0 * G) * 2.0 + F550.drag_body * 4.0
    assert world.a == pytest.approx((-bare / 3.0, 0, 0), abs=1e-3)


def test_nothing_weighs_less_than_nothing():
    with pytest.raises(BadInput, match=r"F550 weighs 2.3 kg and cannot carry -2.3 kg"):
        CompiledPlant(F550).laden(-2.3)
