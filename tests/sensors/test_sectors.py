"""What is in each sector: against rays that march through the scene, step by step."""

from math import inf, pi

import numpy as np
import pytest
from truth import at_rest, kept, spread, watch

import uavlab
from uavlab.errors import BadInput
from uavlab.flight.scenario import Scenario, standing
from uavlab.parts.missions import Waypoints
from uavlab.plant.obstacles import Obstacle
from uavlab.sensors import Jump, Outliers, Scanner
from uavlab.sensors.sectors import around
from uavlab.so3 import about_z, exp

REACH, STEP = 8.0, 0.01
LEVEL = np.eye(3)


def marched(r, angle, obstacles):
    """How far a ray gets [m], level, before it is inside of something; inf: it leaves the scene."""
    s = np.arange(0.0, REACH, STEP)
    x, y = r[0] + s * np.cos(angle), r[1] + s * np.sin(angle)
    inside = np.zeros(s.shape, bool)
    for a, b, radius, height in obstacles:
        if r[2] <= height:
            inside |= (x - a) ** 2 + (y - b) ** 2 <= radius**2
    return s[np.argmax(inside)] if inside.any() else inf


@pytest.mark.parametrize("seed", range(6))
def test_each_sector_tells_what_the_nearest_of_its_rays_meets(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 10))
    poles = [
        Obstacle(*rng.uniform(-6, 6, 2), *rng.uniform((0.1, 0.0), (1.5, 4.0))) for _ in range(7)
    ]
    r, eta = np.array((*rng.uniform(-2, 2, 2), rng.uniform(0.5, 2.5))), rng.uniform(-pi, pi)
    told = around(r, eta, poles, n)
    found = 0
    for i in range(n):
        rays = eta + 2 * pi * i / n + np.linspace(-pi / n, pi / n, 241)
        seen = min(marched(r, angle, poles) for angle in rays)
        if np.isfinite(seen):
            found += 1
            assert seen - 2 * STEP <= told[i] <= seen + 1e-9 or told[i] == pytest.approx(
                seen, abs=0.03
            )
        else:
            assert told[i] > REACH - 0.05
    assert found > 0


def scan(*obstacles, r=(0.0, 0.0, 2.0), R=LEVEL, **fields):
    scanner = Scanner(noise=0.0, obstacles=obstacles)._replace(**fields)
    see = lambda t: at_rest(t)._replace(r=np.array(r), R=R)  # noqa: E731
    return kept(watch(scanner, 1, see=see))[0]


POLE = Obstacle(5.0, 0.0, 0.5, 3.0)


def test_a_pole_ahead_is_ahead_and_turns_to_the_right_when_the_nose_turns_left():
    assert scan(POLE).d[0] == pytest.approx(4.5)
    turned = scan(POLE, R=about_z(pi / 2))
    assert turned.d[6] == pytest.approx(4.5)
    assert np.isinf(np.delete(turned.d, 6)).all()


def test_it_is_kept_level_when_the_aircraft_tilts():
    level, tilted = scan(POLE), scan(POLE, R=exp(np.array((0.0, 0.6, 0.0))))
    np.testing.assert_array_equal(level.d, tilted.d)
    assert level.down == tilted.down == 2.0


def test_above_its_top_a_pole_is_seen_below_only():
    over = scan(POLE, r=(5.2, 0.0, 4.0))
    assert np.isinf(over.d).all()
    assert over.down == pytest.approx(1.0)
    assert scan(POLE, r=(5.6, 0.0, 4.0)).down == pytest.approx(4.0)


def test_inside_of_an_obstacle_the_distance_is_nothing():
    assert scan(POLE, r=(5.0, 0.2, 1.0)).d.max() == 0.0


def test_what_is_out_of_reach_is_infinitely_far_and_so_is_the_sky():
    far = scan(Obstacle(25.0, 0.0, 1.0, 9.0), r=(0.0, 0.0, 30.0))
    assert np.isinf(far.d).all()
    assert far.down == far.up == inf
    assert scan(Obstacle(20.9, 0.0, 1.0, 9.0)).d[0] == pytest.approx(19.9)
    assert scan(Obstacle(20.9, 0.0, 1.0, 9.0), reach=19.0).d[0] == inf


def test_its_noise_is_as_large_as_it_says():
    turns = kept(
        watch(
            Scanner(noise=0.1, obstacles=(POLE,)),
            4001,
            see=lambda t: at_rest(t)._replace(r=np.array((0, 0, 2.0))),
        )
    )
    ahead = np.array([x.d[0] for x in turns])
    assert ahead.std() == pytest.approx(0.1, rel=spread(len(turns)))
    assert ahead.mean() == pytest.approx(4.5, abs=0.4 / np.sqrt(len(turns)))


def test_a_bird_may_be_seen_where_there_is_nothing_and_dirt_in_every_sector():
    birds = Scanner(noise=0.0, outliers=Outliers(0.3, 15.0))
    turns = np.array([x.d for x in kept(watch(birds, 1000))])
    assert 0.2 < np.isfinite(turns).any(axis=1).mean() < 0.35
    dirty = kept(watch(Scanner(noise=0.0, jumps=(Jump(1.0, -19.0),)), 200))
    assert all(np.isinf(x.d).all() for x in dirty if x.t < 1.0 - 1e-6)
    assert all(x.d == pytest.approx(np.full(8, 1.0)) for x in dirty if x.t > 1.0)


def test_a_scanner_of_one_sector_or_of_none_is_refused():
    for n in (0, 1, 2.5):
        with pytest.raises(BadInput, match=f"n is {n}"):
            Scanner(n=n).init(np.random.default_rng(0))
    with pytest.raises(BadInput, match="reach"):
        Scanner(reach=-1.0).init(np.random.default_rng(0))


def test_aboard_it_sees_the_obstacles_of_the_scenario():
    listened = []

    class Listens(Scanner):
        def step(self, memory, world, dt, rng):
            memory, reading = super().step(memory, world, dt, rng)
            if reading is not None:
                listened.append(reading)
            return memory, reading

    stay = Waypoints(((0.0, (0.0, 0.0, 2.0), 0.0),))
    scenario = Scenario(
        "pole", "", "F450", stay, standing((0.0, 0.0, 2.0)), 0.1,
        {**uavlab.scenarios.load("hover").sensors, "sectors": Listens(noise=0.0)}, obstacles=(POLE,),
    )  # fmt: skip
    uavlab.fly(scenario)
    assert len(listened) == 2
    assert listened[0].d[0] == pytest.approx(4.5)
