"""Ground, take-off, touch-down; and what is refused at the edges of the world."""

import numpy as np
import pytest
from aircraft import command, state, without_rotors

from uavlab.errors import BadInput
from uavlab.plant import CompiledPlant, load_airframe
from uavlab.types import Command, State

G = 9.81


@pytest.fixture
def plant(make_plant):
    return make_plant(load_airframe("F450"))


def test_on_the_ground_rotors_rest_and_in_the_air_they_hover(plant):
    assert not plant.init(state((0, 0, 0))).speed.any()
    assert (plant.init(state((0, 0, 1))).speed > 100).all()


def test_too_little_thrust_leaves_it_standing_where_it_is(plant):
    start = state((1, 2, 0), w=(0, 0, 0.7))
    world = plant.init(start)
    for _ in range(30):
        world = plant.advance(world, command(0.95 * 1.7 * G, (1, 1, 1)), np.array((5.0, 0.0, 0.0)))
    assert world.contact
    np.testing.assert_array_equal(world.r, start.r)
    np.testing.assert_allclose(world.R, start.R, atol=1e-15)
    assert not (world.v.any())
    assert not (world.omega.any())
    assert not (world.a.any())
    assert world.impact == 0.0


def test_more_thrust_than_weight_takes_off_when_the_rotors_have_spun_up(plant):
    world = plant.init(state((0, 0, 0)))
    world = plant.advance(world, command(1.2 * 1.7 * G))
    assert world.contact  # motors need about 0.1 s
    for _ in range(40):
        world = plant.advance(world, command(1.2 * 1.7 * G))
    assert not world.contact
    assert world.r[2] > 0.05
    assert world.impact == 0.0


def test_a_fall_ends_with_the_speed_that_energy_gives(make_plant):
    plant = make_plant(without_rotors(load_airframe("F450"))._replace(drag_body=0.0))
    world = plant.init(state((0, 0, 3), w=(0, 0, 1)))
    hits = []
    for _ in range(100):
        world = plant.advance(world, command(0.0))
        hits.append(world.impact)
    assert max(hits) == pytest.approx(np.sqrt(2 * G * 3), abs=G * 1e-3)
    assert sum(h > 0 for h in hits) == 1  # told once, in the tick that it happened
    assert np.argmax(hits) == pytest.approx(np.sqrt(2 * 3 / G) / 0.01, abs=1)
    assert world.contact
    assert world.r[2] == 0.0
    assert not world.v.any()


def test_sliding_into_the_ground_counts_with_its_whole_speed(plant):
    world = plant.init(state((0, 0, 0.001), v=(6, 0, -1)))
    world = plant.advance(world, command(1.7 * G))
    assert world.impact == pytest.approx(np.hypot(6, 1), rel=0.01)


def test_after_a_touch_down_it_can_take_off_again(plant):
    world = plant.init(state((0, 0, 0.01)))
    for _ in range(30):
        world = plant.advance(world, command(0.5 * 1.7 * G))
    assert world.contact
    for _ in range(40):
        world = plant.advance(world, command(1.3 * 1.7 * G))
    assert world.r[2] > 0.05


BAD_STATES = {
    "state.r has shape (2,)": state()._replace(r=np.zeros(2)),
    "state.v has shape (3, 1)": state()._replace(v=np.zeros((3, 1))),
    "state.omega is [nan": state(omega=(np.nan, 0, 0)),
    "state.r is [inf": state(r=(np.inf, 0, 1)),
    "state.r is 'here'": state()._replace(r="here"),  # type: ignore[arg-type]
    "state.R is not a rotation": state()._replace(R=2 * np.eye(3)),
    "state.R is a reflection": state()._replace(R=np.diag((1.0, 1.0, -1.0))),
    "state.R has shape (4,)": state()._replace(R=np.zeros(4)),
    "below the ground": state((0, 0, -0.1)),
    "stands on the ground (z = 0) with v": state((0, 0, 0), v=(0, 0, 1)),
}


@pytest.mark.parametrize("said", BAD_STATES)
def test_a_state_that_cannot_be_is_refused(said: str):
    plant = CompiledPlant(load_airframe("F450"))
    with pytest.raises(BadInput) as caught:
        plant.init(BAD_STATES[said])
    assert said in str(caught.value)


BAD_CALLS = {
    "dt is 0.0 s": dict(dt=0.0),
    "dt is nan s": dict(dt=float("nan"), n=1),
    "dt is nan s and n is None": dict(dt=float("nan")),
    "dt is inf s": dict(dt=float("inf")),
    "n is nan": dict(n=float("nan")),
    "n is 0": dict(n=0),
    "omega_d (2,)": dict(command=Command(1.0, np.zeros(2), np.zeros(3))),
    "omega_d (1,)": dict(command=Command(1.0, np.zeros(1), np.zeros(3))),
    "omega_d (3, 1)": dict(command=Command(1.0, np.zeros((3, 1)), np.zeros(3))),
    "f_d has shape (2,)": dict(command=Command(np.ones(2), np.zeros(3), np.zeros(3))),  # type: ignore[arg-type]
    "wind ()": dict(wind=3.0),
    "wind (4,)": dict(wind=np.zeros(4)),
}


@pytest.mark.parametrize("said", BAD_CALLS)
def test_a_call_that_makes_no_sense_is_refused(said: str):
    plant = CompiledPlant(load_airframe("F450"))
    call = dict(command=command(1.0)) | BAD_CALLS[said]
    with pytest.raises(BadInput) as caught:
        plant.advance(plant.init(state()), **call)  # type: ignore[arg-type]
    assert said in str(caught.value)


def test_the_world_of_another_aircraft_is_refused():
    quad, hexa = CompiledPlant(load_airframe("F450")), CompiledPlant(load_airframe("F550"))
    with pytest.raises(BadInput, match="the world has 6 rotors, F450 has 4"):
        quad.advance(hexa.init(state()), command(1.0))


@pytest.mark.parametrize(("field", "value"), [("m", 0.0), ("motor_tau", -1.0), ("drag_body", np.nan)])  # fmt: skip
def test_an_airframe_spoilt_by_hand_is_refused(field: str, value: float):
    spoilt = load_airframe("F450")._replace(**{field: value})
    with pytest.raises(BadInput, match=rf"F450: {field} is"):
        CompiledPlant(spoilt)


def test_the_state_that_it_starts_from_stays_the_callers_own():
    mine = State(np.array((0.0, 0.0, 5.0)), np.zeros(3), np.eye(3), np.zeros(3))
    world = CompiledPlant(load_airframe("F450")).init(mine)
    mine.r[2] = 9.0
    assert world.r[2] == 5.0


def test_lists_and_integers_will_do_as_commands():
    plant = CompiledPlant(load_airframe("F450"))
    world = plant.init(state())
    loose = plant.advance(world, Command(17, [0, 1, 0], None), [1, 0, 0])  # type: ignore[arg-type]
    strict = plant.advance(world, command(17.0, (0, 1, 0)), np.array((1.0, 0, 0)))
    np.testing.assert_array_equal(loose.R, strict.R)
