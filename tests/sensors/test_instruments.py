"""What every instrument obeys: its rate, its delay, its gaps, its seed."""

from typing import Any

import numpy as np
import pytest
from truth import at_rest, drifting, kept, watch

from uavlab.errors import BadInput
from uavlab.sensors import (
    INSTRUMENTS,
    BeaconCamera,
    FlowCamera,
    Gnss,
    ImuSensor,
    Mocap,
    Outage,
    Rangefinder,
    Receiver,
    Sensor,
)

# Whatever stands at the origin must be able to read something there.
READY = {
    "flow": FlowCamera(lowest=0.0),
    "rangefinder": Rangefinder(nearest=0.0, bias=1.0),
    "bearings": BeaconCamera(axis=np.array((0.0, 0.0, 1.0)), view=2.0),
    "remote": Receiver(tremble=0.1),
}
ALL = [READY.get(name, kind()) for name, kind in INSTRUMENTS.items()]


@pytest.fixture(params=ALL, ids=lambda s: type(s).__name__)
def sensor(request: pytest.FixtureRequest) -> Any:
    return request.param


def same(a: list, b: list) -> bool:
    return len(a) == len(b) and all(
        (x is None and y is None)
        or (
            x is not None
            and y is not None
            and all(np.array_equal(p, q, equal_nan=True) for p, q in zip(x, y, strict=True))
        )
        for x, y in zip(a, b, strict=True)
    )


def test_every_instrument_has_the_shape_of_a_sensor(sensor):
    assert isinstance(sensor, Sensor)


def test_the_same_seed_reads_the_same_and_another_does_not(sensor):
    one, two, other = (watch(sensor, 200, seed=s) for s in (1, 1, 2))
    assert same(one, two)
    assert not same(one, other)


@pytest.mark.parametrize("rate", [100.0, 50.0, 10.0, 30.0, 3.0])
def test_samples_come_at_the_rate_even_if_ticks_do_not_divide_it(sensor, rate):
    times = [x.t for x in kept(watch(sensor._replace(rate=rate, delay=0.0), 1000))]
    assert len(times) == pytest.approx(10 * rate, abs=1)
    late = np.array(times) - np.arange(len(times)) / rate
    assert late.min() > -1e-6
    assert late.max() < 0.01 + 1e-6  # at the first tick after it was due


def test_an_instrument_faster_than_the_loop_gives_one_sample_each_tick(sensor):
    arrived = watch(sensor._replace(rate=1000.0, delay=0.0), 100)
    assert None not in arrived


@pytest.mark.parametrize("delay", [0.0, 0.01, 0.05, 0.123])
def test_a_reading_arrives_late_and_says_when_it_was_true(sensor, delay):
    arrived = watch(sensor._replace(delay=delay), 400)
    for tick, reading in enumerate(arrived):
        if reading is not None:
            assert delay - 1e-6 < tick * 0.01 - reading.t < delay + 0.01 + 1e-6
    first = next(k for k, reading in enumerate(arrived) if reading is not None)
    assert arrived[first].t == 0.0
    assert first == np.ceil(delay / 0.01 - 1e-6)


def test_a_late_reading_tells_the_truth_of_its_own_time():
    quiet = Gnss(delay=0.2, noise=np.zeros(3), drift=np.zeros(3), velocity_noise=np.zeros(3))
    for fix in kept(watch(quiet, 200, see=drifting)):
        np.testing.assert_allclose(fix.r, drifting(fix.t).r, atol=1e-9)
        np.testing.assert_allclose(fix.v, drifting(fix.t).v, atol=1e-9)


def test_no_reading_is_lost_on_a_slow_line(sensor):
    times = [x.t for x in kept(watch(sensor._replace(delay=0.5), 500))]
    late = np.array(times) - np.arange(len(times)) / sensor.rate
    assert late.min() > -1e-6
    assert late.max() < 0.01 + 1e-6


def test_dropout_loses_its_share_and_leaves_the_others_as_they_were(sensor):
    whole = watch(sensor._replace(rate=100.0), 800)
    holed = watch(sensor._replace(rate=100.0, dropout=0.3), 800)
    share = 4 * np.sqrt(0.7 * 0.3 / 800)
    assert len(kept(holed)) / len(kept(whole)) == pytest.approx(0.7, abs=share)
    assert all(same([a], [b]) for a, b in zip(whole, holed, strict=True) if b is not None)


def test_dropout_of_one_gives_nothing(sensor):
    assert kept(watch(sensor._replace(dropout=1.0), 100)) == []


def test_in_an_outage_nothing_is_read_and_afterwards_all_is_as_without_it(sensor):
    whole = watch(sensor, 400)
    holed = watch(sensor._replace(outages=(Outage(1.0, 2.0),)), 400)
    times = np.array([x.t for x in kept(holed)])
    assert not ((times >= 1.0) & (times < 2.0 - 1e-9)).any()
    assert (times < 1.0).any()
    assert (times > 2.0 - 1e-9).any()
    assert all(same([a], [b]) for a, b in zip(whole, holed, strict=True) if b is not None)


def test_a_step_leaves_truth_and_memory_as_they_were(sensor):
    rng = np.random.default_rng(0)
    memory = sensor.init(rng)
    before = repr(memory)
    world = drifting(0.0)._replace(r=np.array((0.1, 0.2, 1.0)))
    kept_world = [np.copy(x) for x in world]
    sensor.step(memory, world, 0.01, rng)
    assert repr(memory) == before
    for was, now in zip(kept_world, world, strict=True):
        np.testing.assert_array_equal(was, now)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("rate", 0.0), ("rate", -1.0), ("rate", float("nan")), ("rate", float("inf")),
        ("delay", -0.1), ("delay", float("nan")), ("dropout", -0.1), ("dropout", 1.1),
        ("dropout", float("nan")), ("outages", (Outage(2.0, 1.0),)),
    ],
)  # fmt: skip
def test_what_no_instrument_can_have_is_refused(sensor, field, value):
    with pytest.raises(BadInput, match="outage" if field == "outages" else field):
        sensor._replace(**{field: value}).init(np.random.default_rng(0))


@pytest.mark.parametrize(
    ("sensor", "field", "value"),
    [
        (ImuSensor(), "gyro_noise", -1.0),
        (ImuSensor(), "accel_tau", 0.0),
        (ImuSensor(), "accel_turn_on", float("nan")),
        (Gnss(), "noise", np.array((0.1, -0.1, 0.1))),
        (Gnss(), "drift", np.zeros(2)),
        (Gnss(), "drift_tau", -5.0),
        (Gnss(), "velocity_noise", "much"),
        (Mocap(), "noise", float("inf")),
        (Mocap(), "turn_noise", -0.1),
    ],
)
def test_noise_that_cannot_be_is_refused_by_name(sensor, field, value):
    with pytest.raises(BadInput, match=field):
        sensor._replace(**{field: value}).init(np.random.default_rng(0))


def test_the_truth_of_a_plant_can_be_sensed(sensor):
    from uavlab.plant import CompiledPlant, load_airframe
    from uavlab.types import State

    world = CompiledPlant(load_airframe("F450")).init(
        State(np.array((0.0, 0.0, 5.0)), np.zeros(3), np.eye(3), np.zeros(3))
    )
    arrived = watch(sensor._replace(delay=0.0), 1, see=lambda _t: world)
    assert arrived[0].t == 0.0
    assert at_rest().t == 0.0
