"""How well observables are read, told by a record's own repeats: they differ by the specimens' scatter and by noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.reduction import Observations

_KNOWN = constants("infer.repeatability")

#: The expected noise counts as so many numbers, and its variance is off by a factor between these.
EXPECTED_NUMBERS = _KNOWN.number("expected_numbers")
LEAST, MOST = _KNOWN.pair("factors")

#: Squares of deviates count up to this one: a misread number says nothing of the others.
MOST_SQUARED = _KNOWN.number("most_squared")


@dataclass(frozen=True)
class Told:
    """What repeats tell of one observable's noise: its variance is off by 1 + `more` / `weight`, in so many numbers."""

    more: float = 0.0
    weight: float = 0.0

    def __add__(self, other: Told) -> Told:
        """Both together."""
        return Told(self.more + other.more, self.weight + other.weight)

    @property
    def factor(self) -> float:
        """On the variance, pooled with the expectation of one."""
        return float(np.clip(1.0 + self.more / (EXPECTED_NUMBERS + self.weight), LEAST, MOST))


def noise_factors(observed: Observations, scattered: Array) -> Array:
    """Factors (n,) on the variance of the noise, one for each observable, as repeats tell them."""
    told = told_by_repeats(observed, scattered)
    factors = [np.repeat(told[part.observable.name].factor, len(part.sites)) for part in observed.layout]
    return np.concatenate([np.ones(0), *factors])


def told_by_repeats(observed: Observations, scattered: Array) -> dict[str, Told]:
    """What the repeats tell of each observable's noise, by its name; nothing where there is one repeat.

    `scattered` (n, n) is the covariance of one repeat's specimens and zeros. What a repeat differs by from the mean of
    those before it is normal, of scatter and noise; given all its other numbers, one of them has a variance of which
    the share s is noise, and its squared deviate tells a factor of 1 + (square − 1)/s, with s² for a weight.
    """
    told = {part.observable.name: Told() for part in observed.layout}
    for seen, apart, noise in _contrasts(observed):
        inverse = np.linalg.inv(noise + scattered[np.ix_(seen, seen)])
        own = np.diag(inverse)
        squares = np.minimum((inverse @ apart) ** 2 / own, MOST_SQUARED)
        share = np.sum((inverse @ noise) * inverse, axis=1) / own
        for part in observed.layout:
            here = (seen >= part.rows.start) & (seen < part.rows.stop)
            more, weight = share[here] @ (squares[here] - 1.0), share[here] @ share[here]
            told[part.observable.name] += Told(float(more), float(weight))
    return told


def _contrasts(observed: Observations) -> Iterator[tuple[NDArray[np.intp], Array, Array]]:
    """Of each repeat but the first: where (k,) it and all before it are seen, and its difference (k,) from their mean.

    Differences are scaled so that they scatter as one repeat does; the covariance (k, k) of the noise is that of them.
    """
    for place in range(1, len(observed.values)):
        seen = np.flatnonzero(np.isfinite(observed.values[: place + 1]).all(axis=0))
        if seen.size:
            scale = place / (place + 1.0)
            apart = observed.values[place, seen] - observed.values[:place, seen].mean(axis=0)
            before = sum(observed.noise_covariance(repeat, seen) for repeat in range(place)) / place**2
            yield seen, np.sqrt(scale) * apart, scale * (observed.noise_covariance(place, seen) + before)
