"""Wind: the mean, and gusts with the statistics of the Dryden spectra."""

from itertools import islice

import numpy as np
import pytest

from uavlab.errors import BadInput
from uavlab.plant import CALM, Wind, gusts
from uavlab.plant.wind import low_altitude

UNIT = Wind(sigma=np.array((1.0, 2.0, 0.5)), length=np.array((2.0, 1.0, 4.0)), passing=1.0)


@pytest.fixture(scope="module")
def blown() -> np.ndarray:
    """20 000 s of gusts at 10 Hz, along the world's axes, (N, 3)."""
    rng = np.random.default_rng(7)
    return np.array(list(islice(gusts(UNIT, rng, 0.1), 200_000)))


@pytest.mark.slow
def test_gusts_have_the_asked_standard_deviation(blown: np.ndarray):
    np.testing.assert_allclose(blown.std(axis=0) / UNIT.sigma, 1.0, atol=0.04)
    np.testing.assert_allclose(blown.mean(axis=0) / UNIT.sigma, 0.0, atol=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.5, 1.0, 2.0, 4.0])
def test_gusts_forget_as_the_dryden_spectra_say(blown: np.ndarray, lag: float):
    k = round(lag / 0.1)
    got = (blown[k:] * blown[:-k]).mean(axis=0) / UNIT.sigma**2
    x = lag / UNIT.length  # passing at 1 m/s
    along = np.exp(-x[0])
    across = np.exp(-x[1:]) * (1 - x[1:] / 2)
    np.testing.assert_allclose(got, [along, *across], atol=0.06)


@pytest.mark.slow
def test_gusts_along_and_across_and_up_know_nothing_of_each_other(blown: np.ndarray):
    np.testing.assert_allclose(np.corrcoef(blown.T), np.eye(3), atol=0.04)


@pytest.mark.parametrize("dt", [0.01, 0.5, 20.0])
def test_the_spread_of_the_air_is_the_same_at_the_start_and_after_any_step(dt: float):
    rng = np.random.default_rng(3)
    first, second = np.array([list(islice(gusts(UNIT, rng, dt), 2)) for _ in range(4000)]).swapaxes(
        0, 1
    )
    np.testing.assert_allclose(first.std(axis=0) / UNIT.sigma, 1.0, atol=0.05)
    np.testing.assert_allclose(second.std(axis=0) / UNIT.sigma, 1.0, atol=0.05)


def test_a_long_step_forgets_and_a_short_one_remembers():
    rng = np.random.default_rng(4)
    for dt, low, high in ((1e-4, 0.98, 1.0), (200.0, -0.1, 0.1)):
        pairs = np.array([list(islice(gusts(UNIT, rng, dt), 2)) for _ in range(1500)])
        for axis in range(3):
            r = np.corrcoef(pairs[:, 0, axis], pairs[:, 1, axis])[0, 1]
            assert low <= r <= high


def test_gusts_along_the_wind_blow_along_the_wind():
    wind = Wind(mean=np.array((0.0, 5.0, 0.0)), sigma=np.array((1.0, 0.0, 0.0)))
    air = np.array(list(islice(gusts(wind, np.random.default_rng(0), 0.1), 200)))
    np.testing.assert_allclose(air[:, [0, 2]], 0.0, atol=1e-15)
    assert air[:, 1].std() > 0.1


def test_calm_air_does_not_move():
    air = np.array(list(islice(gusts(CALM, np.random.default_rng(0), 0.1), 50)))
    assert not air.any()


def test_the_same_seed_blows_the_same():
    one, two, other = (
        np.array(list(islice(gusts(UNIT, np.random.default_rng(seed), 0.1), 50)))
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, two)
    assert np.abs(one - other).max() > 0.1


def test_a_step_leaves_its_memory_as_it_was():
    rng = np.random.default_rng(0)
    gust = UNIT.init(rng)
    kept = (gust.along, gust.across, gust.up)
    UNIT.step(gust, 0.1, rng)
    assert (gust.along, gust.across, gust.up) == kept


def test_at_a_thousand_feet_the_turbulence_is_the_same_in_all_directions():
    wind = low_altitude(np.array((6.0, 8.0, 0.0)), 304.8)
    np.testing.assert_allclose(wind.sigma, 1.0, rtol=1e-9)
    np.testing.assert_allclose(wind.length, 304.8, rtol=1e-9)


def test_near_the_ground_gusts_are_flat_and_short():
    """MIL-F-8785C at 20 ft in 10 m/s: sigma_w = 1 m/s, L_w = 20 ft, L_u = 20 / 0.19346^1.2 ft."""
    wind = low_altitude(np.array((10.0, 0.0, 0.0)), 6.096)
    assert wind.sigma == pytest.approx((1.929, 1.929, 1.0), rel=1e-3)
    assert wind.length == pytest.approx((43.77, 43.77, 6.096), rel=1e-3)


@pytest.mark.parametrize(
    ("bad", "said"),
    [
        (CALM._replace(mean=np.zeros(2)), "wind.mean has shape"),
        (CALM._replace(sigma=np.array((0, np.nan, 0))), "wind.sigma is"),
        (CALM._replace(sigma=np.array((0, -1, 0))), "sigma .* must be ≥ 0"),
        (CALM._replace(length=np.array((1, 0, 1))), "length .* m > 0"),
        (CALM._replace(passing=float("nan")), "passing nan"),
        (CALM._replace(passing=-1.0), "passing -1"),
    ],
)
def test_wind_that_cannot_blow_is_refused(bad: Wind, said: str):
    with pytest.raises(BadInput, match=said):
        next(gusts(bad, np.random.default_rng(0), 0.1))


@pytest.mark.parametrize("height", [2.0, 400.0, float("nan")])
def test_heights_outside_the_formula_are_refused(height: float):
    with pytest.raises(BadInput, match="covers 3 to 305 m"):
        low_altitude(np.ones(3), height)
