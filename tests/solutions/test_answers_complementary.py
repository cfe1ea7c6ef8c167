"""The reference answers of lab 04 against scipy, closed forms, Lyapunov functions, and flights with true readings."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from strategies import floats, rates, rotations, vectors

from uavlab import so3
from uavlab.errors import BadInput
from uavlab.exercises.paths import FIELD, Blown, Path
from uavlab.frames import moved
from uavlab.solutions.complementary import (
    CoupledFilter,
    attitude_step,
    body_filter_step,
    drag_velocity,
    inertial_filter_step,
    position_observer_step,
    vertical_step,
)
from uavlab.types import (
    GRAVITY,
    NO_PULL,
    AidedGains,
    BodyMemory,
    CoupledGains,
    Estimate,
    Fix,
    Imu,
    InertialMemory,
    Shift,
    VerticalGains,
    VerticalMemory,
)

UP = np.array((0.0, 0.0, GRAVITY))
SPICA = (126.3, 3987.3)  # Spica Sec. 6.1


def quat(R):
    return np.roll(Rotation.from_matrix(R).as_quat(), 1)


def matrix(q):
    return Rotation.from_quat(np.roll(q, -1)).as_matrix()


def product(p, q):
    v = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.append(p[0] * q[0] - p[1:] @ q[1:], v)


# attitude_step ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_the_attitude_step_is_the_solution_of_the_differential_equation_of_spica(seed):
    rng = np.random.default_rng(seed)
    q, q_meas = (x / np.linalg.norm(x) for x in rng.normal(size=(2, 4)))
    omega, gain, dt = 3.0 * rng.normal(size=3), 5.0, 0.4

    def rate(t, x):  # (12), and the measurement that turns along
        d = product(x[:4] * (1, -1, -1, -1), x[4:])
        drawn = np.append(0.0, omega + 2.0 * gain * d[0] * d[1:])
        return 0.5 * np.append(product(x[:4], drawn), product(x[4:], np.append(0.0, omega)))

    want = solve_ivp(rate, (0.0, dt), np.append(q, q_meas), rtol=1e-11, atol=1e-12).y[:4, -1]
    assert_allclose(attitude_step(q, omega, q_meas, gain, dt), want, atol=1e-9)


def test_the_attitude_is_found_from_two_hundred_starts_up_to_175_degrees_off():
    rng = np.random.default_rng(0)
    gain, dt, found = 4.0, 0.1, 0
    for _ in range(200):
        axis, omega = rng.normal(size=(2, 3))
        off = rng.uniform(0.0, np.radians(175.0)) / np.linalg.norm(axis) * axis
        q, true, turn = quat(so3.exp(off)), np.eye(4)[0], quat(so3.exp(omega * dt))
        for _ in range(40):
            q = attitude_step(q, omega, true, gain, dt)
            true = -product(true, turn)  # either sign
        found += abs(q @ true) > 1.0 - 1e-9
    assert found == 200


@given(rotations(), rotations(), rates, floats(0.1, 100.0), floats(1e-4, 10.0))
def test_the_attitude_stays_of_length_one_and_never_gets_worse(R, R_meas, omega, gain, dt):
    q = attitude_step(quat(R), omega, quat(R_meas), gain, dt)
    assert abs(np.linalg.norm(q) - 1.0) < 1e-12
    after = so3.angle(matrix(q), R_meas @ so3.exp(omega * dt))
    assert after <= so3.angle(R, R_meas) + 1e-6


@given(rotations(), rotations(), rates)
def test_two_half_steps_are_one_step_and_signs_do_not_matter(R, R_meas, omega):
    q, q_meas = quat(R), quat(R_meas)
    once = attitude_step(q, omega, q_meas, 3.0, 0.2)
    half = attitude_step(q, omega, q_meas, 3.0, 0.1)
    twice = attitude_step(half, omega, quat(R_meas @ so3.exp(0.1 * omega)), 3.0, 0.1)
    assert_allclose(matrix(twice), matrix(once), atol=1e-7)
    assert_allclose(attitude_step(q, omega, -q_meas, 3.0, 0.2), once, atol=1e-12)
    assert_allclose(attitude_step(-q, omega, q_meas, 3.0, 0.2), -once, atol=1e-12)


# position_observer_step -------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_the_position_step_is_the_exponential_of_its_matrix(seed):
    rng = np.random.default_rng(seed)
    for k_p, k_v in (SPICA, (2.0, 1.0), (2.0, 1.0 + 1e-9), (1.0, 40.0), (20.0, 3.0)):
        r, v, a, z = rng.normal(size=(4, 3))
        A = np.zeros((4, 4))
        A[:2] = (-k_p, 1.0, k_p, 0.0), (-k_v, 0.0, k_v, 1.0)
        want = (expm(A / 30.0) @ np.array((r, v, z, a)))[:2]
        assert_allclose(position_observer_step(r, v, a, z, k_p, k_v, 1 / 30), want, atol=1e-8)


def test_the_gains_of_spica_put_two_poles_near_ten_hertz_and_do_not_swing():
    poles = np.sort(np.roots((1.0, *SPICA)))
    assert_allclose(poles, (-63.9, -62.4), atol=0.05)


def test_positions_at_thirty_hertz_do_for_an_observer_at_the_rate_of_the_imu():
    dt, r, v, seen, off = 1 / 240, np.zeros(3), np.zeros(3), np.zeros(3), []
    for k in range(480):
        t = k * dt
        if k % 8 == 0:
            seen = np.array((np.sin(t), 0.0, 1.0))
        r, v = position_observer_step(r, v, np.array((-np.sin(t), 0.0, 0.0)), seen, *SPICA, dt)
        off.append(abs(r[0] - np.sin(t + dt)))
    assert max(off[100:]) < 0.03
    assert np.mean(off[100:]) > 0.005  # what is held lags


@pytest.mark.parametrize("gains", [(0.0, 1.0), (1.0, 0.0), (-1.0, 1.0), (np.nan, 1.0)])
def test_an_observer_that_is_not_stable_is_refused(gains):
    with pytest.raises(BadInput, match="k_p"):
        position_observer_step(np.zeros(3), np.zeros(3), np.zeros(3), np.ones(3), *gains, 0.01)


# drag_velocity and vertical_step ----------------------------------------------------------------------


@given(vectors(10.0), floats(1.1, 30.0), floats(0.02, 1.0))
def test_the_velocity_comes_back_from_its_drag_and_from_the_numbers_of_the_paper(V, up, c):
    accel = np.array((-c * up**0.5 * V[0], -c * up**0.5 * V[1], up))
    assert_allclose(drag_velocity(accel, c), V[:2], atol=1e-9)
    bias = drag_velocity(np.array((0.05, 0.0, GRAVITY)), 0.0794)  # Bangura Sec. V-A, errata of (3)
    assert_allclose(bias[0], -0.05 / 0.249, atol=1e-3)


@pytest.mark.parametrize("up", [1.0, 0.5, 0.0, -9.81, np.nan])
def test_in_free_fall_there_is_no_velocity_from_drag(up):
    assert np.isnan(drag_velocity(np.array((0.1, 0.2, up)), 0.1)).all()


def test_the_errors_of_filter_0_die_as_its_characteristic_polynomial_says():
    k, dt, e = VerticalGains(), 1e-3, np.array((1.0, -0.5, 0.3))
    assert_allclose(np.roots((1.0, *k)), (-1.0, -1.0, -1.0), atol=1e-4)
    x, lifted = VerticalMemory(5.0 + e[0], e[1], 0.2 + e[2]), np.array((0.0, 0.0, GRAVITY + 0.2))
    for _ in range(1000):
        x = vertical_step(x, np.eye(3), lifted, 5.0, dt, gains=k)
    A = np.array(((-k.k_1, 1.0, 0.0), (-k.k_2, 0.0, -1.0), (k.k_3, 0.0, 0.0)))
    assert_allclose(np.array(x) - (5.0, 0.0, 0.2), expm(A) @ e, atol=2e-3)


def test_positive_gains_are_not_enough_for_filter_0():
    assert np.roots((1.0, 1.0, 1.0, 2.0)).real.max() > 0.17  # the errata's example
    for bad in ((1.0, 1.0, 2.0), (2.0, 2.0, 4.0), (0.0, 1.0, 1.0), (1.0, 1.0, -1.0)):
        with pytest.raises(BadInput, match="k_3"):
            vertical_step(
                VerticalMemory(0, 0, 0), np.eye(3), UP, 0.0, 0.01, gains=VerticalGains(*bad)
            )


# The two filters --------------------------------------------------------------------------------------

QUICK = AidedGains(10.0, 0.3, 0.05, 30.0, 0.0, 0.2, 0.5)


def flown(kind, path, seconds, *, start=0.1, u=1.0, b_omega=0.0, gains=QUICK, dt=0.02):
    """Memories on the way of a flight with true readings but a biased gyro, and the moments."""
    step = body_filter_step if kind is BodyMemory else inertial_filter_step
    here = path.at(0.0)
    told = here.R.T @ here.v if kind is BodyMemory else here.v
    R = here.R @ so3.exp(np.array((start, -start, 0.0)))
    x, way = kind(told, R, u, np.zeros(3), np.zeros(3)), []
    for k in range(round(seconds / dt)):
        here, seen = path.at(k * dt), path.imu(k * dt, dt)
        way.append((x, here))
        told = here.R.T @ here.v if kind is BodyMemory else here.v
        imu = seen._replace(gyro=seen.gyro + b_omega)
        x = step(x, imu, told, here.R.T @ FIELD, dt, m_W=FIELD, gains=gains, pull=NO_PULL)
    return way


@pytest.mark.parametrize("kind", [BodyMemory, InertialMemory])
@pytest.mark.parametrize("yaw", [0.0, np.pi, 1.5])
def test_attitude_and_gyro_bias_are_found_exactly_whatever_the_heading(kind, yaw):
    path, bias = (
        Path(np.random.default_rng(1), yaw, turn=0.2, lean=0.2),
        np.array((0.05, -0.03, 0.04)),
    )
    x, here = flown(kind, path, 14.0, b_omega=bias)[-1]
    assert np.degrees(so3.angle(x.R, here.R)) < 0.3
    assert_allclose(x.b_omega, bias, atol=3e-3)
    assert abs(x.u - 1.0) < 0.01


def test_the_lyapunov_function_of_filter_1_never_rises():
    k = 0.2
    gains = QUICK._replace(k_r=k, k_u=k, k_m=0.0, k_b_omega=0.0, k_b_m=0.0)
    path = Path(np.random.default_rng(2), np.pi, turn=0.5)
    way = flown(BodyMemory, path, 4.0, start=0.6, u=1.3, gains=gains, dt=0.005)
    energy = []
    for x, here in way:
        e, y = x.V - here.R.T @ here.v, x.u * x.R[2] - here.R[2]
        energy.append(0.5 * e @ e + y @ y / (2.0 * k))
    assert np.diff(energy).max() < 1e-3 * energy[0]
    assert energy[-1] < 1e-3 * energy[0]


@pytest.mark.parametrize("u", [0.8, 1.2])
def test_the_scaling_of_filter_2_comes_back_to_one_because_it_weighs_gravity(u):
    path = Path(np.random.default_rng(3), 2.0, lean=0.2)
    x, here = flown(InertialMemory, path, 8.0, u=u, gains=QUICK._replace(k_u=0.2))[-1]
    assert abs(x.u - 1.0) < 1e-3
    assert np.abs(x.v - here.v).max() < 0.01


def test_without_a_magnetometer_the_tilt_is_found_and_the_heading_stays_off():
    path, dt = Path(np.random.default_rng(4), 1.0, lean=0.2), 0.02
    here = path.at(0.0)
    start = so3.about_z(0.5) @ here.R @ so3.exp(np.array((0.2, 0.0, 0.0)))
    x = BodyMemory(here.R.T @ here.v, start, 1.0, np.zeros(3), np.zeros(3))
    for k in range(300):
        here = path.at(k * dt)
        x = body_filter_step(
            x,
            path.imu(k * dt, dt),
            here.R.T @ here.v,
            None,
            dt,
            m_W=FIELD,
            gains=QUICK,
            pull=NO_PULL,
        )
    assert_allclose(x.R[2], path.at(6.0).R[2], atol=0.01)
    assert so3.angle(x.R, path.at(6.0).R) > 0.3


# The coupled pair -------------------------------------------------------------------------------------


def coupled(seconds, *, seed=0, dt=0.02, w=(1.5, -0.8, 0.0), gap=(99.0, 99.0), **kwargs):
    """Memory and estimate on the way of a flight in the wind, with the true velocities."""
    flight = Blown(np.random.default_rng(seed), np.pi, w=np.array(w), c=0.08)
    part, way = CoupledFilter(FIELD, 0.08, **kwargs), []
    memory = part.init(flight.guess())
    for _ in range(round(seconds / dt)):
        t, readings = flight.t, flight.step(dt)
        if gap[0] <= t < gap[1]:
            del readings["gnss"]
        memory, x = part.step(memory, readings, None, dt)
        V = flight.R.T @ (flight.v - flight.w)
        way.append((flight.t, memory, x, flight.v, V, flight.R))
    return way


def test_the_wind_and_both_velocities_are_found():
    _, memory, x, v, V, R = coupled(25.0)[-1]
    assert_allclose(x.w, (1.5, -0.8, 0.0), atol=0.05)
    assert_allclose(x.v, v, atol=0.02)
    assert_allclose(x.V, V, atol=0.05)
    assert np.degrees(so3.angle(x.R, R)) < 0.5
    assert memory.rejected == 0


def test_a_lost_velocity_lets_the_wind_decay_and_its_return_makes_no_step():
    way = coupled(24.0, gap=(14.0, 19.0), patience=0.1)
    w = {round(t, 2): np.linalg.norm(x.w) for t, _, x, *_ in way}
    k, dt = CoupledGains().k_w, 0.02
    assert_allclose(w[18.0] / w[15.0], (1.0 - k * dt) ** 150, rtol=1e-9)  # e^{−3 k_w}, by Euler
    for (_, _, a, *_), (t, _, b, _, V, _) in pairwise(way):
        if t > 14.0:
            assert np.linalg.norm(b.v - a.v - dt * a.a) < 0.15
            assert np.linalg.norm(b.w - a.w) < 0.1
            assert np.abs(b.V - V).max() < 0.3
            assert 0.9 < b.u_1 < 1.1


def test_a_smaller_step_ends_nearer_to_the_same():
    ends = [coupled(2.0, dt=dt, seed=3)[-1][2] for dt in (0.04, 0.02, 0.01)]
    one, two = (np.abs(a.V - b.V).max() for a, b in pairwise(ends))
    assert two < 0.8 * one


def test_told_in_another_world_it_says_the_same_and_what_is_not_a_number_is_counted():
    flight = Blown(np.random.default_rng(5), 0.4, w=np.array((1.0, 0.0, 0.0)), c=0.08)
    part, shift = CoupledFilter(FIELD, 0.08), Shift(np.array((3.0, -2.0, 0.5)), 2.4)
    one, x, y = part.init(flight.guess()), None, None
    for _ in range(10):
        one, x = part.step(one, flight.step(0.02), None, 0.02)
    two, Rz = part.reframe(one, shift), so3.about_z(2.4)
    for _ in range(10):
        readings = flight.step(0.02)
        one, x = part.step(one, readings, None, 0.02)
        two, y = part.step(two, {n: moved(r, shift) for n, r in readings.items()}, None, 0.02)
    assert_allclose(y.v, Rz @ x.v, atol=1e-12)
    assert_allclose(y.w, Rz @ x.w, atol=1e-12)
    assert_allclose(y.R, Rz @ x.R, atol=1e-12)
    assert_allclose(y.V, x.V, atol=1e-12)
    assert_allclose(y.z, x.z + 0.5, atol=1e-12)
    broken = {
        "imu": Imu(0.0, np.full(3, np.nan), np.zeros(3)),
        "gnss": Fix(0.0, np.zeros(3), np.full(3, np.inf)),
    }
    now, said = part.step(one, broken, None, 0.02)
    assert now.rejected == 2
    assert all(np.isfinite(f).all() for f in said)


def test_before_the_first_imu_the_start_is_told():
    start = Estimate(UP, np.ones(3), np.zeros(3), so3.about_z(0.3), np.zeros(3))
    part = CoupledFilter(FIELD, 0.08)
    _, x = part.step(part.init(start), {}, None, 0.01)
    assert_allclose(x.v, start.v)
    assert_allclose(x.R, start.R)
    assert x.z == GRAVITY
