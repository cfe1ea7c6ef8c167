"""What the experiments on control fly: which changes do what, and that a torque is flown as it was asked for."""

import numpy as np
import pytest

from uavlab import so3
from uavlab.experiments import (
    circles,
    compliance,
    control_flights,
    disturbances,
    misprints,
    spica_flight,
    torque_loop,
)
from uavlab.experiments.control_flights import Altered, Believes, Knows, Passes, flown, law
from uavlab.flight.metrics import heading_error, position_error
from uavlab.flight.scenario import standing
from uavlab.frames import Shift, moved
from uavlab.parts.missions import still
from uavlab.plant import CompiledPlant, load_airframe
from uavlab.types import Command, Estimate, Exit

MK = load_airframe("MK-Quadro")
FREE = MK._replace(drag_body=0.0, drag_rotor=0.0)


def turned_world(rng):
    """An aircraft in the air that turns, with rotors at hover speed."""
    R, omega = so3.exp(rng.normal(0.0, 0.4, 3)), rng.normal(0.0, 1.0, 3)
    start = standing((0.0, 0.0, 5.0))._replace(R=R, omega=omega)
    return CompiledPlant(FREE).init(start)


# A torque through the embedded rate loop ------------------------------------------------------------


def rate_loop(omega, omega_d):
    """Torque (3,) that the compiled autopilot makes of body rates."""
    from uavlab.plant import autopilot
    from uavlab.plant.constants import pack, unpacked
    from uavlab.plant.jit import entry
    from uavlab.plant.vectors import three

    loop = autopilot.rate_loop

    def once(w, w_d, numbers, allocation, mixer):
        return loop(three(w, 0), three(w_d, 0), unpacked(numbers, allocation, mixer))

    return np.array(entry(once)(omega, omega_d, *pack(MK)))


def test_the_embedded_loop_makes_exactly_the_torque_that_was_asked_for():
    for rng in map(np.random.default_rng, range(5)):
        tau, omega = rng.normal(0.0, 0.3, 3), rng.normal(0.0, 2.0, 3)
        omega_d = torque_loop.rates_for_torque(tau, omega, MK)
        np.testing.assert_allclose(rate_loop(omega, omega_d), tau, atol=1e-12)


def test_in_flight_it_is_that_torque_once_the_motors_have_followed():
    """With motors that follow at once, one physics step turns the aircraft by J⁻¹(τ − ω × Jω)."""
    quick = FREE._replace(motor_tau=1e-4)
    plant, world = CompiledPlant(quick), turned_world(np.random.default_rng(1))
    tau, dt = np.array((0.05, -0.03, 0.01)), 1e-3
    for _ in range(5):
        omega_d = torque_loop.rates_for_torque(tau, world.omega, MK)
        after = plant.advance(world, Command(12.83, omega_d, np.zeros(3)), dt=dt, n=1)
        rate = (after.omega - world.omega) / dt
        world = after
    want = MK.J_inv @ (tau - np.cross(world.omega, MK.J @ world.omega))
    np.testing.assert_allclose(rate, want, rtol=0.02, atol=0.02)


def test_a_path_tells_its_own_body_rates():
    """The wanted attitude, carried on by the rates of `flat`, meets the one of a moment later."""
    t, dt = 6.0, 1e-3
    omega, omega_dot = torque_loop.flat(spica_flight.there, t)
    now, then = (torque_loop._attitude(spica_flight.there(s)) for s in (t, t + dt))
    np.testing.assert_allclose(now @ so3.exp((omega + 0.5 * dt * omega_dot) * dt), then, atol=1e-7)


def test_the_goals_of_the_eight_are_derivatives_of_each_other():
    h = 1e-4
    for t in (1.0, 2.5, 9.0):
        a, b = spica_flight.there(t - h), spica_flight.there(t + h)
        now = spica_flight.there(t)
        for x, x_dot in (("r", "v"), ("v", "a"), ("a", "j")):
            slope = (getattr(b, x) - getattr(a, x)) / (2 * h)
            np.testing.assert_allclose(slope, getattr(now, x_dot), atol=1e-5)
        assert (b.heading - a.heading) / (2 * h) == pytest.approx(now.heading_rate, abs=1e-6)


def test_the_eight_is_flown_within_a_hand_and_a_step_keeps_the_rotors_within_their_limits():
    eight = spica_flight.eight(seconds=5.0)
    assert eight.exit is Exit.DONE
    assert position_error(eight).max() < 0.1
    assert np.abs(heading_error(eight)).max() < np.deg2rad(5.0)
    log, loop = spica_flight.stepped(True, seconds=1.5)
    asked, given = (x @ np.linalg.inv(MK.allocation).T for x in torque_loop.wishes(log, loop))
    assert asked.max() > spica_flight.F_MAX + 0.5  # it is aggressive
    assert given.max() <= MK.thrust_max + 1e-9
    assert given.min() >= MK.thrust_min - 1e-9
    assert spica_flight.turned(asked, given) < 1e-3


def test_the_share_that_is_given_is_the_one_of_the_paper_s_programme():
    assert spica_flight.formula_against_programme(1).max() < 1e-9


# What the aircraft knows ----------------------------------------------------------------------------


def test_who_knows_his_state_is_told_the_truth_and_noise_only_if_asked():
    world = turned_world(np.random.default_rng(2))
    told = Knows().step(None, world, 0.01, np.random.default_rng(0))[1]
    np.testing.assert_array_equal(told.r, world.r)
    noisy = Knows(0.1, 0.1).step(None, world, 0.01, np.random.default_rng(0))[1]
    assert 0.0 < np.linalg.norm(noisy.r - world.r) < 1.0
    belief = Believes()
    memory, estimate = belief.step(belief.init(told), {"state": noisy}, None, 0.01)
    assert estimate is noisy
    assert belief.step(memory, {}, None, 0.01)[1] is noisy


def test_a_tracker_that_adds_nothing_gives_the_goal_and_keeps_it_in_another_world():
    zero = np.zeros(3)
    stands = Estimate(np.ones(3), zero, zero, np.eye(3), zero)
    passes, goal = Passes(), still(np.array((1.0, 2.0, 3.0)), 0.5)
    memory = passes.init(stands, None)
    assert passes.step(memory, stands, None, 0.01)[1].r is stands.r
    memory, reference = passes.step(memory, stands, goal, 0.01)
    assert reference is goal
    shift = Shift(np.array((5.0, 0.0, 0.0)), 1.0)
    np.testing.assert_allclose(passes.reframe(memory, shift).r, moved(goal, shift).r)


# Changes to the controller --------------------------------------------------------------------------


def one_step(change, reference=None):
    zero, gains = np.zeros(3), circles.GAINS["soft"]
    there = Estimate(np.array((0.0, 0.0, 4.9)), zero, zero, np.eye(3), zero)
    the_law = law(3.5, gains)
    changed = Altered(the_law, change)
    reference = reference or still(np.array((0.0, 0.0, 5.0)))
    memory = the_law.init(there, None)
    return the_law.step(memory, there, reference, 0.01), changed.step(
        memory, there, reference, 0.01
    )


def test_the_jerk_as_printed_points_the_other_way_and_is_a_hundred_times_too_large():
    x = still(np.array((0.0, 0.0, 5.0)))._replace(j=np.array((1.0, 0.0, 0.0)))
    (_, right), (_, printed) = one_step(control_flights.printed_jerk, x)
    share = right.f_d / 3.5
    assert printed.omega_d[1] == pytest.approx(-(share**2) * right.omega_d[1], rel=1e-6)
    right, printed = misprints.example()
    np.testing.assert_allclose(right[:2], (0.127, 0.101), atol=5e-4)
    np.testing.assert_allclose(printed[:2], (-14.8, -11.8), atol=0.05)


def test_the_mass_as_printed_moves_the_other_way():
    (right, _), (printed, _) = one_step(control_flights.printed_mass)
    assert right.m_e > 3.5
    assert printed.m_e == pytest.approx(2 * 3.5 - right.m_e)


def test_the_acceleration_as_printed_tells_a_hover_that_it_climbs():
    assert misprints.told("T650", False) == pytest.approx(0.0, abs=1e-9)
    assert misprints.told("T650", True) == pytest.approx(7.01, abs=0.01)
    assert misprints.told("F450", True) == pytest.approx(4.04, abs=0.01)


def test_told_again_the_controller_remembers_what_it_did_in_flight():
    scenario = disturbances.scenario(2.0)
    controller = law(disturbances.TOLD, disturbances.GAINS)
    log = flown(scenario, controller, plant=disturbances.loaded())
    kept = control_flights.memories(log, controller)
    assert len(kept) == len(log.t)
    assert kept[0].m_e == disturbances.TOLD
    assert kept[-1].m_e > disturbances.TOLD + 0.05
    # Equally split until it turns.
    np.testing.assert_allclose(kept[-1].d_w, kept[-1].d_b, atol=1e-9)


# Flights --------------------------------------------------------------------------------------------


def test_with_the_jerk_as_printed_the_fast_circle_is_lost_and_else_it_is_not():
    laps = 0.4
    mission = circles.scenario(True, laps)
    gains = circles.GAINS["soft"]
    lost = flown(mission, Altered(law(3.5, gains), control_flights.printed_jerk))
    kept = flown(mission, law(3.5, gains))
    assert lost.exit is Exit.TILT
    assert lost.t[-1] < 1.0
    assert kept.exit is Exit.DONE
    assert position_error(kept).max() < 1.0


def test_a_heavier_aircraft_falls_with_the_mass_as_printed_and_stays_with_the_corrected_one():
    log, mass = disturbances.as_printed(
        3.5, 4.0, disturbances.BLOWS, disturbances.GAINS, seconds=5.0
    )
    assert mass[-1] < 3.0
    assert log.r[-1, 2] < disturbances.HEIGHT - 0.3


def test_the_oblique_attitude_keeps_the_heading_and_lee_s_does_not():
    assert compliance.drawn("attitude_with_heading", 0)[:200].max() < 1e-9
    assert np.rad2deg(compliance.worst("attitude_by_projection", np.deg2rad(45))) == pytest.approx(
        19.47, abs=0.01
    )
    assert compliance.printed_shape(compliance.force(0.3, 1.0), 0.0) == (3, 3)


def test_a_flight_that_ended_before_the_laps_that_count_has_no_numbers():
    short = circles.round_and_round(True, circles.GAINS["soft"], laps=1)
    assert np.isnan(circles.lapped(short).error)


def test_the_tracker_is_sent_the_circle_that_the_filter_follows():
    way = circles.scenario(True).mission
    sent = circles.Sent(way.path, way.rate, way.ramp, way.heading, way.face, 10.0)
    _, trajectory = sent.step(None, None, 50.0)
    for t, r in zip(trajectory.t[::10], trajectory.r[::10], strict=True):
        np.testing.assert_allclose(r, way.goal(t).r)
    assert np.abs(np.diff(trajectory.heading)).max() < 1.0  # it does not jump by a turn
