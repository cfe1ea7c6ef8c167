"""An airframe follows from measured numbers."""

import numpy as np
import pytest

from uavlab.errors import BadInput
from uavlab.plant import Airframe, airframe_names, build_airframe, load_airframe

NUMBERS = dict(
    mass=1.0, inertia=np.array((0.01, 0.01, 0.02)), arm=0.2,
    angles=np.arange(4) * np.pi / 2, spins=np.array((1.0, -1.0, 1.0, -1.0)),
    torque_ratio=0.02, thrust_coefficient=1e-5, speed_min=100.0, speed_max=1000.0, motor_tau=0.03,
    drag_body=0.05, drag_rotor=0.1, rate_gain=np.array((15.0, 15.0, 8.0)),
)  # fmt: skip


@pytest.fixture(params=airframe_names())
def airframe(request: pytest.FixtureRequest) -> Airframe:
    return load_airframe(request.param)


def test_the_five_airframes_are_there():
    assert airframe_names() == ["F450", "F550", "MK-Quadro", "T650", "X500"]


def test_allocation_of_the_plus_layout_is_the_matrix_that_spica_prints():
    a = load_airframe("MK-Quadro")
    l, c = 0.25, 0.0174
    printed = [[1, 1, 1, 1], [0, l, 0, -l], [-l, 0, l, 0], [c, -c, c, -c]]
    np.testing.assert_allclose(a.allocation, printed, atol=1e-15)


def test_allocation_is_the_moment_of_each_thrust_about_the_centre(airframe: Airframe):
    for i, angle in enumerate(airframe.angles):
        place = airframe.arm * np.array((np.cos(angle), np.sin(angle), 0.0))
        turn = np.cross(place, (0.0, 0.0, 1.0))
        turn[2] += airframe.spins[i] * airframe.torque_ratio
        np.testing.assert_allclose(airframe.allocation[:, i], [1.0, *turn], atol=1e-14)


def test_signs_of_the_x_layouts_are_those_of_the_mrs_simulator():
    s = np.sqrt(0.5)
    quad = load_airframe("T650")
    np.testing.assert_allclose(quad.allocation[1] / quad.arm, [-s, s, s, -s], atol=1e-12)
    np.testing.assert_allclose(quad.allocation[2] / quad.arm, [-s, s, -s, s], atol=1e-12)
    assert np.sign(quad.allocation[3]).tolist() == [-1, -1, 1, 1]
    hexa = load_airframe("F550")
    c = np.sqrt(0.75)
    np.testing.assert_allclose(hexa.allocation[1] / hexa.arm, [1, -1, -0.5, 0.5, 0.5, -0.5], atol=1e-9)  # fmt: skip
    np.testing.assert_allclose(hexa.allocation[2] / hexa.arm, [0, 0, -c, c, -c, c], atol=1e-9)
    assert np.sign(hexa.allocation[3]).tolist() == [1, -1, 1, -1, -1, 1]


@pytest.mark.parametrize(
    ("name", "a_t", "hover", "thrust_to_weight"),
    [
        ("F450", 0.1856, 0.582, 2.41),
        ("F550", 0.1515, 0.543, 2.67),
        ("X500", 0.1449, 0.465, 3.36),
        ("T650", 0.1177, 0.513, 2.91),
    ],
)
def test_thrust_curves_are_those_of_the_mrs_simulator(name, a_t, hover, thrust_to_weight):
    a = load_airframe(name)
    assert a.a_t == pytest.approx(a_t, rel=1e-3)
    assert a.b_t == pytest.approx(-0.17647, rel=1e-3)
    assert a.a_t * np.sqrt(a.m * 9.81) + a.b_t == pytest.approx(hover, abs=1.5e-3)
    assert a.n * a.thrust_max / (a.m * 9.81) == pytest.approx(thrust_to_weight, rel=3e-3)


def test_thrust_curve_maps_half_throttle_to_half_the_speed_range(airframe: Airframe):
    speed = 0.5 * (airframe.speed_min + airframe.speed_max)
    force = airframe.n * airframe.thrust_coefficient * speed**2
    assert airframe.a_t * np.sqrt(force) + airframe.b_t == pytest.approx(0.5, abs=1e-12)


def test_rotors_of_the_mk_quadro_give_the_forces_that_spica_measured():
    a = load_airframe("MK-Quadro")
    assert a.thrust_min == pytest.approx(0.3131, rel=1e-4)
    assert a.thrust_max == pytest.approx(6.03, rel=1e-4)


def test_inertia_of_the_mrs_airframes_is_that_of_a_solid_cylinder():
    for name, height in (("F450", 0.1), ("F550", 0.1), ("X500", 0.1), ("T650", 0.15)):
        a = load_airframe(name)
        side, up = a.m * (3 * a.arm**2 + height**2) / 12, a.m * a.arm**2 / 2
        np.testing.assert_allclose(np.diag(a.J), (side, side, up), rtol=1e-5)
        np.testing.assert_allclose(a.J @ a.J_inv, np.eye(3), atol=1e-12)
        assert a.drag_body == pytest.approx(0.3 * np.pi * a.arm**2, rel=1e-3)


def test_arrays_of_an_airframe_cannot_be_written(airframe: Airframe):
    with pytest.raises(ValueError, match="read-only"):
        airframe.allocation[0, 0] = 2.0


def test_three_rotors_are_refused_because_they_cannot_steer():
    three = NUMBERS | dict(angles=np.arange(3) * 2.1, spins=np.array((1.0, -1.0, 1.0)))
    with pytest.raises(BadInput, match="span only 3 of"):
        build_airframe("tri", **three)


def test_rotors_of_one_spin_are_refused_because_they_cannot_yaw():
    with pytest.raises(BadInput, match="both spins"):
        build_airframe("one", **(NUMBERS | dict(spins=np.ones(4))))


def test_an_aircraft_too_heavy_for_its_rotors_is_refused_with_the_bound():
    with pytest.raises(BadInput, match=r"hover needs rotor thrusts.*allowed 0\.100 to 10\.000"):
        build_airframe("brick", **(NUMBERS | dict(mass=5.0)))


@pytest.mark.parametrize("spins", [(1, -1, 1), (1, -1, 0.5, -1)])
def test_spins_other_than_one_per_rotor_are_refused(spins):
    with pytest.raises(BadInput, match="spins are"):
        build_airframe("odd", **(NUMBERS | dict(spins=np.array(spins))))


def test_a_speed_range_of_nothing_is_refused():
    with pytest.raises(BadInput, match="speed_max 100 must exceed"):
        build_airframe("stuck", **(NUMBERS | dict(speed_max=100.0)))
