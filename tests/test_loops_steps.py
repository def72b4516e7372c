"""Channels that were recorded in steps: how large these are, and what they add to the noise."""

import numpy as np
import pytest

from tests.diagnosis_cases import autoregressive
from wirewear.loops.correlated_noise import correlated_noise
from wirewear.loops.robust import Array
from wirewear.loops.steps import rounding_noise, step_of

STEP, SIZE, CORRELATION = 0.01, 0.0075, 0.7


def channel(samples: int = 400) -> np.ndarray:
    time = np.arange(samples) / samples
    return np.asarray(
        np.sin(2.0 * np.pi * time) + SIZE * autoregressive(samples, CORRELATION, np.random.default_rng(3))
    )


def test_the_step_of_a_rounded_channel_is_found() -> None:
    rounded = STEP * np.round(channel() / STEP)
    assert step_of(rounded) == pytest.approx(STEP)
    assert step_of(0.3 + rounded) == pytest.approx(STEP)
    assert step_of(np.round(rounded, 6)) == pytest.approx(STEP)


def test_a_few_samples_that_were_put_in_between_hide_no_step() -> None:
    rounded = STEP * np.round(channel() / STEP)
    rounded[[50, 180]] += 0.3 * STEP
    assert step_of(rounded) == pytest.approx(STEP)


def test_a_channel_without_steps_has_none() -> None:
    assert step_of(channel()) == 0.0
    assert step_of(np.ones(40)) == 0.0


def test_rounding_hides_no_correlation_of_the_noise_below_it() -> None:
    """As one autoregression, both would make means of many samples look surer than they are."""
    random = np.random.default_rng(8)
    design: Array = np.asarray(np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, 160), 6), dtype=np.float64)
    alone: list[float] = []
    beside: list[float] = []
    for _ in range(30):
        noisy = 0.05 * design[:, 1] + 0.02 * design[:, 3] + SIZE * autoregressive(160, CORRELATION, random)
        parts = [(design, STEP * np.round(noisy / STEP))]
        for found, rounding in ((alone, 0.0), (beside, rounding_noise(STEP))):
            deviation, stretch = correlated_noise(parts, None, rounding)
            found.append(deviation * stretch)
    # A mean's error goes with the spectrum at frequency zero.
    expected = np.hypot(SIZE * np.sqrt((1.0 + CORRELATION) / (1.0 - CORRELATION)), rounding_noise(STEP))
    assert np.median(beside) == pytest.approx(expected, rel=0.15)
    assert np.median(alone) < np.median(beside)
