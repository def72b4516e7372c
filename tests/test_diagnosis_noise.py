"""Noise of measured loops: its size and correlation, told from the smooth branch that it lies on."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from geometry.arrays import Array
from tests.diagnosis_cases import autoregressive, nominal, record, states
from wirewear.diagnosis.infer.covariance import EXPECTED_NUMBERS, estimate, noise_factors
from wirewear.diagnosis.observe.measured_loops import reduced_loop
from wirewear.diagnosis.observe.observable import Site
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.reduction import Layout, Observations, reduce
from wirewear.diagnosis.observe.stick import Stick
from wirewear.loops.noise import (
    correlated_noise,
    correlation_of,
    correlation_of_neighbours,
    noise_factor,
    noise_of_neighbours,
    sample_noise,
    stretch_of,
)
from wirewear.records import MeasuredLoop
from wirewear.records.tables import Noise

SMOOTH = np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, 90), 11).astype(np.float64)


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
    assert correlation_of_neighbours(1.0 / told, most=0.95) == pytest.approx(correlation, abs=0.04)
    assert correlation_of(stretch_of(correlation)) == pytest.approx(correlation)


def cosine(time: Array) -> Array:
    return np.asarray(np.cos(2.0 * np.pi * time))


def noisy_loop(
    cycle: int,
    correlation: float,
    random: np.random.Generator,
    count: int = 400,
    drive: Callable[[Array], Array] = cosine,
) -> MeasuredLoop:
    """A loop of a spring and a slider, each channel with noise of that correlation."""
    time = np.arange(count) / count
    displacement = 60.0 * drive(time)
    travel = 60.0 - displacement
    force = 1.24 - np.minimum(0.3 * travel, 2.48)
    force[count // 2 :] = -force[: count // 2]
    x, q, p = (autoregressive(count, correlation, random) for _ in range(3))
    return MeasuredLoop(1, cycle, time, displacement + 0.15 * x, force + 0.008 * q, 2.0 + 0.008 * p)


def noisy_branch(correlation: float, random: np.random.Generator) -> tuple[Array, Array]:
    """A curved branch with AR(1) noise of deviation 0.01."""
    return SMOOTH, np.asarray(SMOOTH[:, 3] + 0.01 * autoregressive(len(SMOOTH), correlation, random))


def error_of_means(correlation: float, stated: float | None = None, tries: int = 25) -> float:
    """Median of deviation times stretch over what it must be, each time from the two branches of one loop."""
    random = np.random.default_rng(7)
    found = []
    for _ in range(tries):
        deviation, stretch = correlated_noise([noisy_branch(correlation, random) for _ in range(2)], stated)
        found.append(deviation * stretch)
    return float(np.median(found) / (0.01 * np.sqrt((1.0 + correlation) / (1.0 - correlation))))


@pytest.mark.parametrize("correlation", [0.0, 0.3, 0.6, 0.75])
def test_noise_and_its_correlation_are_found_under_a_curve_that_takes_its_slow_part(correlation: float) -> None:
    assert error_of_means(correlation) == pytest.approx(1.0, abs=0.15)


def test_errors_of_readings_grow_with_the_correlation_of_the_noise() -> None:
    random = np.random.default_rng(11)
    errors = {}
    for correlation in (0.0, 0.7):
        loops = [reduced_loop(noisy_loop(cycle, correlation, random), Noise()) for cycle in range(1, 9)]
        errors[correlation] = [
            float(np.median([getattr(loop, name) for loop in loops]))
            for name in ("sample_noise_N", "force_noise_N", "normal_error_N")
        ]
    # One sample's noise is the same; that of means grows by √(1.7/0.3) = 2.4.
    assert np.divide(errors[0.7], errors[0.0]) == pytest.approx([1.0, 2.4, 2.4], rel=0.25)


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


def test_numbers_between_the_same_two_samples_share_their_noise_and_yet_can_be_weighed() -> None:
    of_samples = np.random.default_rng(3).uniform(size=(2 * COUNT, 2))
    of_samples /= np.linalg.norm(of_samples, axis=1)[:, None]
    shared = replace(observations(1.0), alike=np.stack([of_samples @ of_samples.T] * 3))
    covariance = shared.noise_covariance(0, np.arange(2 * COUNT))
    assert covariance == pytest.approx(1e-4 * of_samples @ of_samples.T, abs=1e-9)
    inverse = np.linalg.inv(covariance)
    assert np.linalg.eigvalsh(0.5 * (inverse + inverse.T))[0] > 0.0
    assert covariance @ inverse == pytest.approx(np.eye(2 * COUNT), abs=1e-6)
