"""The emergency controller lands what is pushed, heavy, tilted or told wrong; and it does it on its own."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np
import pytest

from uavlab import so3
from uavlab.errors import BadInput
from uavlab.experiments.control_flights import KNOWS, Believes, Knows
from uavlab.experiments.landing_detection import watched
from uavlab.flight.fly import fly
from uavlab.flight.scenario import Scenario, standing
from uavlab.frames import Shift, moved
from uavlab.gains import mpc_gains_for
from uavlab.interfaces import Stack
from uavlab.limits import AxisLimits, ForceLimits
from uavlab.parts.emergency import Emergency
from uavlab.parts.landoff import EMERGENCY, LandOff
from uavlab.parts.missions import Waypoints, still
from uavlab.plant import CompiledPlant, Wind, load_airframe
from uavlab.so3 import about_z
from uavlab.solutions.mpc import MpcController
from uavlab.types import Command, Estimate

DT = 0.01
ZERO = np.zeros(3)
NOWHERE = Waypoints(((0.0, (0.0, 0.0, 0.0), 0.0),))
PART = Emergency(2.0)
HERE = Estimate(np.array((1.0, 2.0, 3.0)), ZERO, ZERO, np.eye(3), ZERO)
# of the emergency controller of mrs_uav_controllers
LIMITS = ForceLimits(AxisLimits(10.0, 2.5, 10.0, inf), AxisLimits(10.0, 2.5, inf, inf))
STORM = (8.0, 6.0, 0.0)  # [m/s]


@dataclass(frozen=True)
class Misled(Believes):
    """An estimate that is `off` [m] from the second tick on."""

    off: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def step(self, memory, readings, command, dt):
        told = readings.get(KNOWS, memory)
        return told, told._replace(r=told.r + self.off)


def mpc(name):
    m = float(load_airframe(name).m)
    return MpcController(m, limits=LIMITS, gains=mpc_gains_for(m)._replace(k_R=(5.0, 5.0, 1.0)))


def landed(law=None, name="T650", v=ZERO, tilt=0.0, wind=ZERO, more=0.0, off=ZERO, noise=0.02):
    """An emergency landing from 4 m, of an aircraft that weighs this share `more` than told."""
    airframe = load_airframe(name)
    start = standing((0.0, 0.0, 4.0), 0.5)._replace(v=np.array(v, float))
    start = start._replace(R=start.R @ so3.exp(np.array((tilt, 0.0, 0.0))))
    air = Wind(np.array(wind), np.full(3, 0.25 * np.linalg.norm(wind)))
    scenario = Scenario("", "", name, NOWHERE, start, 16.0, {KNOWS: Knows(noise, noise)}, wind=air)
    law = law or Emergency(float(airframe.m))
    plant = CompiledPlant(airframe._replace(m=airframe.m * (1.0 + more)))
    return watched(
        fly(scenario, Stack(Misled(tuple(off)), LandOff(sink=EMERGENCY), law), plant=plant)
    )


def aside(landing):
    """Speed over the ground at the touch [m/s]."""
    log = landing.log
    return float(np.linalg.norm(log.v[np.searchsorted(log.t, landing.contact) - 1, :2]))


@pytest.mark.flight
@pytest.mark.parametrize("name", ["T650", "F450"])
@pytest.mark.parametrize(
    "given",
    [
        {}, {"wind": (5.0, 0.0, 0.0)}, {"wind": STORM}, {"more": 0.4}, {"more": -0.15}, {"v": (5.0, 0.0, 0.0)},
        {"v": (0.0, 0.0, -2.0)}, {"tilt": 1.3}, {"off": (3.0, 0.0, 0.0)}, {"off": (0.0, 0.0, 3.0)}, {"noise": 0.3},
    ],
    ids=["calm", "wind", "storm", "heavy", "light", "fast", "sinking", "tilted", "beside", "above", "noise"],
)  # fmt: skip
def test_it_lands_gently_and_what_lands_is_seen_to_stand(name, given):
    x = landed(name=name, **given)
    assert x.log.exit.name == "DONE"
    assert 0.0 < x.vertical < 1.0
    assert aside(x) < (3.0 if given.get("wind") == STORM else 0.3)
    assert 1.9 < x.after < 3.5
    assert x.light < 1.0  # and nobody took it for landed before


@pytest.mark.flight
def test_a_height_that_jumped_does_not_let_it_fall_as_it_lets_the_mpc_controller():
    ours, theirs = landed(off=(0, 0, 3.0)), landed(mpc("T650"), off=(0, 0, 3.0))
    assert ours.vertical < 1.0
    assert theirs.log.exit.name == "CRASH"


@pytest.mark.flight
def test_a_storm_that_carries_the_mpc_controller_away_does_not_carry_it():
    ours, theirs = landed(wind=STORM), landed(mpc("T650"), wind=STORM)
    assert np.linalg.norm(ours.log.r[:, :2], axis=1).max() < 15.0
    assert np.linalg.norm(theirs.log.r[:, :2], axis=1).max() > 25.0


@pytest.mark.parametrize("far", [0.1, 1.0, 100.0, 1e6])
def test_however_far_the_reference_is_it_leans_and_climbs_within_its_bounds(far):
    rng = np.random.default_rng(1)
    for _ in range(50):
        e = rng.normal(size=3)
        x = HERE._replace(v=far * rng.normal(size=3))
        _, out = PART.step(PART.init(x, None), x, still(x.r + far * e), DT)
        f = PART.mass * np.add(out.a_d, (0.0, 0.0, 9.81))  # level, so all of it is thrust along z
        assert 2.0 * (9.81 - 6.0) - 1e-9 <= f[2] <= 2.0 * (9.81 + 6.0) * 1.05
        assert np.abs(out.omega_d[:2]).max() <= 6.0 * np.arctan(2.5 / (9.81 - 6.0)) + 1e-9


def tilts(law, reference, seconds=8.0):
    """Tilt [rad] of an aircraft that starts level and at rest, tick by tick."""
    plant = CompiledPlant(load_airframe("F450"))
    world = plant.init(standing((0.0, 0.0, 50.0)))
    memory, seen = law.init(HERE._replace(r=world.r), None), []
    for _ in range(round(seconds / DT)):
        x = Estimate(world.r, world.v, world.a, world.R, world.omega)
        memory, out = law.step(memory, x, reference, DT)
        world = plant.advance(world, out)
        seen.append(float(np.arccos(min(world.R[2, 2], 1.0))))
    return np.array(seen), world


def test_it_flies_to_a_far_place_no_faster_than_it_may_and_stops_there():
    law = Emergency(float(load_airframe("F450").m))
    lean, world = tilts(law, still(np.array((12.0, 0.0, 48.0))), 14.0)
    assert np.degrees(lean.max()) < 31.0
    np.testing.assert_allclose(world.r, (12.0, 0.0, 48.0), atol=0.3)
    assert np.linalg.norm(world.v) < 0.2


def test_a_heavy_aircraft_is_weighed_and_a_light_one_too_within_its_share():
    for more in (0.3, -0.3):
        airframe = load_airframe("F450")
        law, plant = (
            Emergency(float(airframe.m)),
            CompiledPlant(airframe._replace(m=airframe.m * (1 + more))),
        )
        world = plant.init(standing((0.0, 0.0, 50.0)))
        memory, goal = law.init(HERE._replace(r=world.r), None), still(world.r)
        for _ in range(1000):
            x = Estimate(world.r, world.v, world.a, world.R, world.omega)
            memory, out = law.step(memory, x, goal, DT)
            world = plant.advance(world, out)
        assert memory.m_e == pytest.approx(airframe.m * (1 + more), rel=0.01)
        assert np.abs(world.r - goal.r).max() < 0.05
    memory = PART.init(HERE, None)
    for _ in range(3000):
        memory, _ = PART.step(memory, HERE, still(np.add(HERE.r, (0.0, 0.0, 5.0))), DT)
    assert memory.m_e == pytest.approx(1.6 * PART.mass)


def test_a_reference_that_is_no_number_makes_it_brake():
    x = HERE._replace(v=np.array((2.0, 0.0, -1.0)))
    _, out = PART.step(PART.init(x, None), x, still(np.full(3, np.nan), np.nan), DT)
    assert np.isfinite(np.hstack(out)).all()
    assert out.a_d[2] > 0.0
    assert out.omega_d[1] < 0.0  # nose up


def test_with_an_attitude_alone_it_is_level_and_carries_its_mass():
    blind = HERE._replace(
        r=np.full(3, np.nan), v=np.full(3, np.nan), R=so3.exp(np.array((0.3, 0, 0)))
    )
    _, out = PART.step(PART.init(blind, None), blind, still(ZERO), DT)
    assert out.omega_d[0] == pytest.approx(-6.0 * 0.3)
    assert out.f_d == pytest.approx(2.0 * 9.81 * np.cos(0.3))


def test_without_an_attitude_the_last_command_stands():
    last = Command(21.0, np.array((0.1, 0.0, 0.0)), ZERO)
    lost = HERE._replace(R=np.full((3, 3), np.nan))
    for start, f in ((last, 21.0), (None, 2.0 * 9.81)):
        _, out = PART.step(PART.init(lost, start), lost, still(HERE.r), DT)
        assert out.f_d == pytest.approx(f)
        assert np.isfinite(np.hstack(out)).all()


def test_a_command_that_was_no_number_is_not_handed_over():
    bad = Command(np.nan, ZERO, ZERO)
    _, out = PART.step(PART.init(HERE, bad), HERE, still(HERE.r), DT)
    assert out.f_d == pytest.approx(2.0 * 9.81)


def test_a_lean_that_was_learned_stays_with_the_wind_when_the_world_turns():
    shift = Shift(np.array((3.0, -2.0, 0.5)), 1.2)
    memory = PART.init(HERE, None)
    for _ in range(200):
        memory, _ = PART.step(memory, HERE, still(np.add(HERE.r, (1.0, 0.0, 0.0))), DT)
    assert memory.d[0] > 0.5
    np.testing.assert_allclose(PART.reframe(memory, shift).d, about_z(1.2) @ memory.d, atol=1e-12)
    there = moved(HERE, shift)
    _, a = PART.step(memory, HERE, still(HERE.r), DT)
    _, b = PART.step(PART.reframe(memory, shift), there, moved(still(HERE.r), shift), DT)
    np.testing.assert_allclose(np.hstack(moved(a, shift)), np.hstack(b), atol=1e-9)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"mass": 0.0}, "mass is 0.0"), ({"tilt": 1.6}, "tilt is 1.6"), ({"share": 1.0}, "share is 1.0"),
        ({"k_v": inf}, "k_v is inf"),
    ],
)  # fmt: skip
def test_numbers_with_which_nothing_can_be_held_are_refused(wrong, said):
    with pytest.raises(BadInput, match=said):
        replace(PART, **wrong)
