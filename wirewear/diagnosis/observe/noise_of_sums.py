"""The noise of a weighted sum of neighbouring samples, whose own noise is correlated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.setup import Array

_KNOWN = constants("observe.noise_of_sums")

#: Neighbours that are more alike than this are a drift, not noise.
MOST_CORRELATED = _KNOWN.number("most_correlated")


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


def correlation_of_neighbours(factor: float) -> float:
    """The correlation of which `noise_of_neighbours` is that factor; 0 for one of at most 1."""
    if factor <= noise_of_neighbours(0.0):
        return 0.0
    most = noise_of_neighbours(MOST_CORRELATED)
    if factor >= most:
        return MOST_CORRELATED
    return float(brentq(lambda correlation: noise_of_neighbours(correlation) - factor, 0.0, MOST_CORRELATED))


def stretch_of(correlation: float) -> float:
    """By what neighbours of that correlation make means of many samples less certain."""
    return float(np.sqrt((1.0 + correlation) / (1.0 - correlation)))


def noise_of_neighbours(correlation: float) -> float:
    """Factor from a noise that was told as uncorrelated, by cubics through four neighbours, to that of a sample.

    Correlated neighbours go along with a sample, so that its distance to their cubic is smaller.
    """
    numbers = np.array([0, -2, -1, 1, 2])
    weights = np.array([1.0, 1.0 / 6.0, -2.0 / 3.0, -2.0 / 3.0, 1.0 / 6.0])
    return float(np.linalg.norm(weights)) / noise_factor(weights, numbers, correlation)
