"""What repeats of a record tell of the noise with which it is read."""

from dataclasses import replace

import numpy as np
import pytest

from tests.diagnosis_cases import nominal, record, states
from wirewear.diagnosis.infer.covariance import EXPECTED_NUMBERS, estimate, noise_factors
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.observe.sites import Site
from wirewear.diagnosis.observe.stick import Stick

COUNT = 400


def observations(true_factor: float, repeats: int = 3, scatter: float = 0.0, seed: int = 1) -> Observations:
    """Repeats of plateaus whose noise has so many times the variance that is expected of it; stick branches as is."""
    sites = [Site(cycle, 1, 0.0) for cycle in range(1, COUNT + 1)]
    layout = Layout.of_sites((PlateauForce(), sites), (Stick(), sites))
    random = np.random.default_rng(seed)
    noise = np.full((repeats, 2 * COUNT), 0.01)
    true = noise * np.repeat([true_factor**0.5, 1.0], COUNT)
    values = true * random.standard_normal(true.shape) + scatter * random.standard_normal((repeats, 1))
    return Observations(layout, tuple(range(1, repeats + 1)), values, noise, np.zeros((2 * COUNT, 0)), (), ())


def scattered(size: float) -> Array:
    return np.full((2 * COUNT, 2 * COUNT), size**2)


@pytest.mark.parametrize("true_factor", [0.4, 1.0, 3.0])
@pytest.mark.parametrize("scatter", [0.0, 0.05])
def test_the_factor_on_the_noise_is_found_whatever_the_specimens_scatter(true_factor: float, scatter: float) -> None:
    factors = noise_factors(observations(true_factor, scatter=scatter), scattered(scatter))
    numbers = 2 * COUNT
    expected = (EXPECTED_NUMBERS + numbers * true_factor) / (EXPECTED_NUMBERS + numbers)
    # Squares beyond three deviations count as that, so that large factors are found too small.
    assert factors[0] == pytest.approx(expected, rel=0.15 if true_factor < 2.0 else 0.3)
    assert factors[-1] == pytest.approx(1.0, rel=0.12)


@pytest.mark.seconds
def test_a_record_whose_repeats_agree_worse_than_they_are_read_is_known_less_well() -> None:
    observed = reduce(record())
    shaken = observed.values.copy()
    plateaus = observed.layout.of_kind(PlateauForce)
    random = np.random.default_rng(3)
    shaken[:, plateaus] += 3.0 * observed.noise[:, plateaus] * random.standard_normal(shaken[:, plateaus].shape)
    # Of one number, given all others: scatter, which moves all plateaus alike, counts for nothing there.
    believed, doubted = (
        1.0 / np.diag(np.linalg.inv(estimate(states(), nominal("sensor"), one).total))[plateaus]
        for one in (observed, replace(observed, values=shaken))
    )
    assert np.median(doubted / believed) > 1.5
