"""Noise of measured loops: its size and correlation, told from the smooth branch that it lies on."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from tests.diagnosis_cases import autoregressive
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.evolution import LEAST, OWN_SHARE, own_noise
from wirewear.diagnosis.observe.measured_loops import reduced_loop
from wirewear.diagnosis.observe.noise_of_samples import (
    MOST_CORRELATED,
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


def cosine(time: Array) -> Array:
    return np.asarray(np.cos(2.0 * np.pi * time))


def triangle(time: Array) -> Array:
    return np.asarray(np.abs(4.0 * time - 2.0) - 1.0)


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


def test_what_the_record_states_of_its_noise_helps_and_a_wrong_statement_hardly_harms() -> None:
    random = np.random.default_rng(3)
    branches = [[noisy_branch(0.7, random), noisy_branch(0.7, random)] for _ in range(25)]
    errors = {}
    for stated in (None, 0.01):
        found = [np.prod(correlated_noise(branch, stated)) / (0.01 * np.sqrt(1.7 / 0.3)) for branch in branches]
        errors[stated] = float(np.std(np.log(found)))
    assert errors[0.01] < 0.8 * errors[None]
    assert error_of_means(0.0, stated=0.0002) == pytest.approx(1.0, abs=0.15)
    assert error_of_means(0.0, stated=0.5) == pytest.approx(1.0, abs=0.15)


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


@pytest.mark.parametrize("measured", [True, False])
def test_few_samples_take_the_correlation_from_the_normal_force_or_else_from_the_displacement(measured: bool) -> None:
    random = np.random.default_rng(11)
    stated = Noise(displacement_um=0.15, tangential_force_N=0.008, normal_force_N=0.008)
    errors = {}
    for correlation in (0.0, 0.7):
        loops = [noisy_loop(cycle, correlation, random, 48) for cycle in range(1, 25)]
        read = [reduced_loop(loop if measured else replace(loop, normal_force_N=None), stated) for loop in loops]
        assert {loop.sample_noise_N for loop in read} == {0.008}
        names = ("force_noise_N", "normal_error_N") if measured else ("force_noise_N",)
        errors[correlation] = [float(np.median([getattr(loop, name) for loop in read])) for name in names]
    assert np.divide(errors[0.7], errors[0.0]) == pytest.approx([2.4] * len(errors[0.0]), rel=0.3)


def test_few_samples_without_a_drive_that_tells_are_as_unsure_as_the_record_states() -> None:
    """Neighbours of correlated noise lie near to each other: alone they would pass for 2.6 times less noise."""
    random, correlation = np.random.default_rng(23), 0.75
    errors = {}
    for stated in (Noise(), Noise(displacement_um=0.15, tangential_force_N=0.008)):
        loops = [noisy_loop(cycle, correlation, random, 64, triangle) for cycle in range(1, 17)]
        read = [reduced_loop(replace(loop, normal_force_N=None), stated) for loop in loops]
        errors[bool(stated.displacement_um)] = float(np.median([loop.displacement_noise_um for loop in read]))
    assert errors[True] == pytest.approx(0.15, rel=0.25)
    assert errors[True] / errors[False] == pytest.approx(noise_of_neighbours(correlation), rel=0.3)
