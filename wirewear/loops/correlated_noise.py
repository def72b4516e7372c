"""Noise whose neighbouring samples correlate: told from the smooth curve that it lies on, and in sums of samples."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.optimize import brentq

from geometry.arrays import Array
from wirewear.loops.noise import NEIGHBOURS, WEIGHTS

#: Correlations of neighbours that are tried.
TRIED = np.arange(0.0, 0.91, 0.05)

#: A stated noise is what one expects within this relative deviation, of a Student's t that lets wrong statements be.
STATED_WITHIN, STATED_FREEDOM = 0.3, 3.0

#: Rounding of less than this share of a sample's noise is left in it: written digits are steps, too.
LEAST_ROUNDING = 0.1


def correlated_noise(
    parts: Sequence[tuple[Array, Array]], stated: float | None, rounding: float = 0.0
) -> tuple[float, float]:
    """Standard deviation of one sample of an AR(1) noise, and by how much correlation raises the error of a mean.

    `parts` are designs (m, k) of smooth curves and samples (m,) that follow them but for noise, which is alike in all.
    A curve takes the slowest part of correlated noise for its own, so that what is left correlates too little: the
    restricted likelihood allows for it. A mean of many samples whose neighbours correlate by ρ scatters as if there
    were (1 − ρ)/(1 + ρ) of them. `stated` is what the record says of a sample's noise, if it does.

    Rounding to steps adds white noise of the deviation `rounding`: an autoregression that had to follow both would
    correlate too little.

    Source: Patterson & Thompson, Biometrika 58 (1971) 545, for a first-order autoregression.
    """
    found = [_likeliest(*_restricted(parts, float(correlation)), stated) for correlation in TRIED]
    best = int(np.argmax([likelihood for likelihood, _ in found]))
    highest, deviation = found[best]
    stretch = stretch_of(float(TRIED[best]))
    if LEAST_ROUNDING * deviation < rounding < deviation:
        under = float(np.sqrt(deviation**2 - rounding**2))
        share = (rounding / under) ** 2
        rounded = [_likeliest(*_rounded(parts, float(correlation), share), stated) for correlation in TRIED]
        best = int(np.argmax([likelihood for likelihood, _ in rounded]))
        if rounded[best][0] > highest:
            under, correlated = rounded[best][1], stretch_of(float(TRIED[best]))
            deviation = under * float(np.sqrt(1.0 + share))
            stretch = float(np.sqrt((correlated**2 + share) / (1.0 + share)))
    return deviation, stretch


def _rounded(parts: Sequence[tuple[Array, Array]], correlation: float, share: float) -> tuple[float, int, float]:
    """As of `_restricted`, beside white noise of that share of the variance."""
    squares, free, determinants = 0.0, 0, 0.0
    for design, values in parts:
        apart = np.abs(np.subtract.outer(np.arange(values.size), np.arange(values.size)))
        factor = np.linalg.cholesky(correlation**apart + share * np.eye(values.size))
        upper = np.linalg.qr(solve_triangular(factor, np.column_stack([design, values]), lower=True), mode="r")
        size = np.abs(np.diag(upper))
        squares += float(size[-1] ** 2)
        free += values.size - design.shape[1]
        determinants += float(np.log(np.maximum(size[:-1], 1e-300)).sum() + np.log(np.diag(factor)).sum())
    return max(squares / free, 1e-300), free, -determinants


def _restricted(parts: Sequence[tuple[Array, Array]], correlation: float) -> tuple[float, int, float]:
    """Mean square of one sample, degrees of freedom, and the determinants in the restricted log-likelihood."""
    squares, free, determinants = 0.0, 0, 0.0
    for design, values in parts:
        columns = np.column_stack([design, values])
        columns[1:] = (columns[1:] - correlation * columns[:-1]) / np.sqrt(1.0 - correlation**2)
        upper = np.linalg.qr(columns, mode="r")
        size = np.abs(np.diag(upper))
        squares += float(size[-1] ** 2)
        free += values.size - design.shape[1]
        determinants += float(np.log(np.maximum(size[:-1], 1e-300)).sum())
        determinants += 0.5 * (values.size - 1) * float(np.log1p(-(correlation**2)))
    return max(squares / free, 1e-300), free, -determinants


def _likeliest(variance: float, free: int, determinants: float, stated: float | None) -> tuple[float, float]:
    """Largest log-likelihood over the standard deviation, what is stated of it included, and that deviation."""
    level = 0.5 * float(np.log(variance))
    if not stated:
        return determinants - free * (level + 0.5), float(np.sqrt(variance))
    expected, at = float(np.log(stated)), level
    for _ in range(20):
        # Newton's method for the normal that touches Student's t where the last step has led.
        weight = (STATED_FREEDOM + 1.0) / (STATED_FREEDOM * STATED_WITHIN**2 + (at - expected) ** 2)
        ratio = free * variance * float(np.exp(-2.0 * at))
        at -= (free - ratio + weight * (at - expected)) / (2.0 * ratio + weight)
    likelihood = -free * at - 0.5 * free * variance * float(np.exp(-2.0 * at))
    surprise = 0.5 * (STATED_FREEDOM + 1.0) * float(np.log1p(((at - expected) / STATED_WITHIN) ** 2 / STATED_FREEDOM))
    return determinants + likelihood - surprise, float(np.exp(at))


def noise_factor(weights: Array, order: NDArray[np.intp], correlation: float) -> float:
    """From a sample's noise to that of a sum with weights (m,), of samples with these numbers (m,) on their branch.

    Their noise is an autoregression of first order with that correlation of neighbours: few samples in a row average
    less of it away than many, but have not yet the error of a mean of many such samples.
    """
    if correlation <= 0.0:
        return float(np.linalg.norm(weights))
    return float(np.sqrt(noise_product(weights, order, weights, order, correlation)))


def noise_product(
    weights: Array, order: NDArray[np.intp], others: Array, their_order: NDArray[np.intp], correlation: float
) -> float:
    """Covariance of two sums over samples of one branch, (m,) and (k,), over a sample's variance, like that."""
    apart = np.abs(order[:, None] - their_order)
    return float(weights @ np.where(apart == 0, 1.0, max(correlation, 0.0) ** apart) @ others)


def correlation_of(stretch: float) -> float:
    """Correlation of neighbours whose noise makes means of many samples that much less certain."""
    return (stretch**2 - 1.0) / (stretch**2 + 1.0)


def correlation_of_neighbours(factor: float, most: float) -> float:
    """The correlation, `most` at most, of which `noise_of_neighbours` is that factor; 0 for one of at most 1."""
    within = float(np.clip(factor, noise_of_neighbours(0.0), noise_of_neighbours(most)))
    return float(brentq(lambda correlation: noise_of_neighbours(correlation) - within, 0.0, most))


def stretch_of(correlation: float) -> float:
    """By what neighbours of that correlation make means of many samples less certain."""
    return float(np.sqrt((1.0 + correlation) / (1.0 - correlation)))


def noise_of_neighbours(correlation: float) -> float:
    """Factor from a noise that was told as uncorrelated, by cubics through four neighbours, to that of a sample.

    Correlated neighbours go along with a sample, so that its distance to their cubic is smaller.
    """
    weights = np.append(-WEIGHTS, 1.0)
    return float(np.linalg.norm(weights)) / noise_factor(weights, np.array([*NEIGHBOURS, 0]), correlation)
