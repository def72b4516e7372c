"""The noise of sums of correlated samples, and that which a column of an evolution tells of itself."""

import numpy as np
import pytest
from scipy.signal import lfilter

from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.evolution import LEAST, OWN_SHARE, own_noise
from wirewear.diagnosis.observe.noise_of_sums import (
    MOST_CORRELATED,
    correlation_of,
    correlation_of_neighbours,
    noise_factor,
    noise_of_neighbours,
    stretch_of,
)
from wirewear.loops.noise import sample_noise


def autoregression(count: int, correlation: float, seed: int) -> Array:
    white = np.random.default_rng(seed).standard_normal(count)
    return np.asarray(lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], white))[1000:]


@pytest.mark.parametrize("correlation", [0.0, 0.4, 0.8])
@pytest.mark.parametrize("count", [1, 4, 9])
def test_means_of_few_samples_scatter_as_drawn_noise_does(correlation: float, count: int) -> None:
    noise = autoregression(401_000, correlation, seed=2)
    means = noise[: noise.size // count * count].reshape(-1, count).mean(axis=1)
    factor = noise_factor(np.full(count, 1.0 / count), np.arange(count), correlation)
    assert factor == pytest.approx(means.std(), rel=0.03)


def test_means_of_very_many_samples_scatter_as_the_stretch_says() -> None:
    stretch, count = 2.5, 1000
    factor = noise_factor(np.full(count, 1.0 / count), np.arange(count), correlation_of(stretch))
    assert factor * np.sqrt(count) == pytest.approx(stretch, rel=2e-3)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8])
def test_a_noise_told_by_cubics_through_neighbours_is_that_of_a_sample(correlation: float) -> None:
    noise = autoregression(41_000, correlation, seed=5)
    time = np.arange(noise.size, dtype=float)
    told = sample_noise(noise + np.sin(1e-3 * time), time)
    assert told * noise_of_neighbours(correlation) == pytest.approx(1.0, rel=0.04)


@pytest.mark.parametrize("correlation", [0.3, 0.6, 0.8])
def test_neighbours_nearer_than_a_samples_noise_tell_how_they_correlate(correlation: float) -> None:
    noise = autoregression(41_000, correlation, seed=6)
    told = sample_noise(noise, np.arange(noise.size, dtype=float))
    assert correlation_of_neighbours(1.0 / told) == pytest.approx(correlation, abs=0.04)
    assert correlation_of(stretch_of(correlation)) == pytest.approx(correlation)


def test_neighbours_no_nearer_than_a_samples_noise_do_not_correlate_nor_do_any_wholly() -> None:
    assert correlation_of_neighbours(0.7) == 0.0
    assert correlation_of_neighbours(50.0) == MOST_CORRELATED


def test_a_column_tells_its_own_noise_and_no_slow_course() -> None:
    cycles = np.geomspace(10.0, 1e5, 40)
    course = 3.0 * (1.0 + 0.2 * np.log10(cycles))
    noise = np.random.default_rng(4).standard_normal((200, cycles.size))
    told = [own_noise(cycles, course * (1.0 + 0.01 * one)) for one in noise]
    assert np.median([one for one in told if one is not None]) == pytest.approx(0.01 * OWN_SHARE, rel=0.1)
    assert own_noise(cycles, 2.0 * cycles**0.1) == LEAST


def test_a_column_of_few_figures_tells_no_noise() -> None:
    assert own_noise(np.geomspace(10.0, 1e5, 5), np.full(5, 2.0)) is None
