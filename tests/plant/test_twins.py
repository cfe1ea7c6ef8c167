"""The compiled world and the world in the functions of lab 01 are the same world, with the compiler on and off."""

import numpy as np
import pytest
from aircraft import command, state

from uavlab.errors import BadInput
from uavlab.flight.fill import REFERENCE, fill
from uavlab.plant import (
    Airframe,
    CompiledPlant,
    ReadablePlant,
    World,
    airframe_names,
    build_airframe,
    load_airframe,
)
from uavlab.solutions import dynamics

NAMES = ("rigid_body_rate", "step_on_so3", "allocation_matrix", "rotor_thrusts", "motor_step")
REFERENCES = {name: getattr(dynamics, name) for name in NAMES}


def random_airframe(rng: np.random.Generator) -> Airframe:
    """A known airframe, or one with four to eight rotors anywhere on a circle."""
    if rng.random() < 0.5:
        return load_airframe(str(rng.choice(airframe_names())))
    n = int(rng.integers(4, 9))
    A = rng.normal(size=(3, 3)) * 0.02
    while True:
        try:
            return build_airframe(
                "random",
                mass=rng.uniform(0.5, 3),
                inertia=np.diag((0.03, 0.04, 0.06)) + A @ A.T,
                arm=0.3,
                angles=np.arange(n) * 2 * np.pi / n + rng.uniform(-0.3, 0.3, n),
                spins=np.where(np.arange(n) % 2, 1.0, -1.0),
                torque_ratio=0.03,
                thrust_coefficient=1e-5,
                speed_min=80.0,
                speed_max=rng.uniform(900, 1400),
                motor_tau=rng.uniform(0.01, 0.08),
                drag_body=rng.uniform(0, 0.2),
                drag_rotor=rng.uniform(0, 0.2),
                rate_gain=rng.uniform(3, 20, 3),
            )
        except BadInput:
            continue


def random_start(rng: np.random.Generator):
    """On the ground, just above it, or high up in any attitude."""
    z = float(rng.choice((0.0, 0.01, 50.0)))
    if z == 0.0:
        return state((1, 2, 0), w=rng.normal(size=3) * 0.3)
    scale = rng.choice((0.1, 1.0))
    return state((0, 0, z), *(rng.normal(size=3) * scale * s for s in (5, 2, 5)))


def damage(rng: np.random.Generator, airframe: Airframe) -> dict:
    """Nothing, weak motors, or one that is dead and known to be."""
    kind = rng.integers(3)
    if kind == 0:
        return {}
    shares = rng.uniform(0.0, 1.0, airframe.n)
    return {"shares": shares} | ({"dead": (int(rng.integers(airframe.n)),)} if kind == 2 else {})


def apart(a: World, b: World) -> float:
    """The largest difference, relative to what is large and absolute to what is small."""
    worst = 0.0
    for x, y in zip(a, b, strict=True):
        x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        worst = max(worst, float(np.max(np.abs(x - y) / np.maximum(1.0, np.abs(x)))))
    return worst


def test_twins_agree_on_random_aircraft_states_commands_and_winds(make_plant):
    rng = np.random.default_rng(5)
    seen = {"contact": 0, "impact": 0, "saturated": 0, "lifted": 0, "weak": 0, "dead": 0}
    for _ in range(100):
        airframe = random_airframe(rng)
        compiled = make_plant(airframe)
        readable = ReadablePlant(airframe, **REFERENCES)
        world = compiled.init(random_start(rng))
        for _ in range(3):
            thrust = airframe.m * 9.81 * rng.uniform(-0.3, 3.0)
            asked = command(thrust, rng.normal(size=3) * rng.choice((0.1, 1.0, 10.0)))
            wind, n = rng.normal(size=3) * 4, int(rng.integers(1, 12))
            broken = damage(rng, airframe)
            one = compiled.advance(world, asked, wind, 0.01, n, **broken)
            two = readable.advance(world, asked, wind, 0.01, n, **broken)
            assert apart(one, two) < 1e-12
            assert (one.contact, type(one.contact)) == (two.contact, bool)
            seen["contact"] += one.contact
            seen["impact"] += one.impact > 0
            seen["weak"] += "shares" in broken
            seen["dead"] += bool(broken.get("dead"))
            seen["lifted"] += world.contact and not one.contact
            seen["saturated"] += not 0 < thrust < airframe.n * airframe.thrust_max
            world = one
    assert all(seen.values()), seen


def test_twins_start_alike():
    airframe = load_airframe("F450")
    start = state(v=(1, 2, 3), w=(0.1, 0.2, 0.3), omega=(1, 0, 0))
    readable = ReadablePlant(airframe, **REFERENCES)
    assert apart(CompiledPlant(airframe).init(start), readable.init(start)) == 0.0


def test_twins_carry_the_same_load():
    airframe = load_airframe("F550")
    compiled = CompiledPlant(airframe).laden(0.4)
    readable = ReadablePlant(airframe, **REFERENCES).laden(0.4)
    world = compiled.init(state(v=(3, 1, 0), omega=(1, 0, 0)))
    asked = command(25.0, (0.5, 0.0, 0.2))
    assert apart(compiled.advance(world, asked), readable.advance(world, asked)) < 1e-12


def test_the_readable_plant_is_filled_like_any_part():
    filled = fill(ReadablePlant, airframe=load_airframe("X500"))
    assert filled.provenance == dict.fromkeys(NAMES, REFERENCE)
    world = filled.part.init(state())
    assert filled.part.advance(world, command(19.62)).r == pytest.approx((0, 0, 100), abs=1e-9)


def test_without_the_answers_the_compiled_plant_stands_in():
    filled = fill(ReadablePlant, only_mine=True, airframe=load_airframe("X500"))
    assert isinstance(filled.part, CompiledPlant)


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("step_on_so3", lambda R, w, dt: R @ dynamics.step_on_so3(np.eye(3), -w, dt)),
        ("motor_step", lambda s, c, tau, dt: c),
        ("allocation_matrix", lambda a, L, c, s: dynamics.allocation_matrix(a, L, c, -s)),
        (
            "rigid_body_rate",
            lambda x, f, t, m, J: dynamics.rigid_body_rate(x, f, t, m=m, J=J)._replace(
                omega_dot=np.linalg.solve(J, t)
            ),
        ),
        ("rotor_thrusts", lambda f, t, A: dynamics.rotor_thrusts(f, t * (1, -1, 1), A)),
    ],
)
def test_a_wrong_answer_flies_differently(name, wrong):
    airframe = load_airframe("F450")
    mine = ReadablePlant(airframe, **(REFERENCES | {name: wrong}))
    world = mine.init(state(omega=(2, -3, 4)))
    asked = command(18.0, (1.0, 2.0, 0.5))
    assert apart(mine.advance(world, asked), CompiledPlant(airframe).advance(world, asked)) > 1e-4


@pytest.mark.parametrize("name", ["allocation_matrix", "rotor_thrusts"])
def test_an_answer_of_the_wrong_shape_is_named(name):
    functions = REFERENCES | {name: lambda *_: np.zeros((3, 3))}
    with pytest.raises(BadInput, match=rf"{name} returned an array of shape \(3, 3\)"):
        ReadablePlant(load_airframe("F450"), **functions)
