"""Noise of measured loops: its size and correlation, told from the smooth branch that it lies on."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.signal import lfilter

from tests.diagnosis_cases import autoregressive
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.measured_loops import reduced_loop
from wirewear.diagnosis.observe.noise_of_samples import (
    correlation_of,
    correlation_of_neighbours,
    noise_factor,
    noise_of_neighbours,
    stretch_of,
)
from wirewear.loops.correlated_noise import correlated_noise
from wirewear.loops.noise import sample_noise
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
    assert correlation_of_neighbours(1.0 / told) == pytest.approx(correlation, abs=0.04)
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
