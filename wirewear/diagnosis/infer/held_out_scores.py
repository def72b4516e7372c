"""How large a gap is on what was left out of a fit, against the floor that the repeats set themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import Covariance
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.features import Features
from wirewear.diagnosis.observe.reduction import Observations

#: Draws of a shrink's interval.
_DRAWS = constants("infer.shrink").count("draws")


@dataclass(frozen=True, eq=False)
class HeldOutScores:
    """Squared residuals of every repeat in the features of held-out observables, in variances of one test."""

    observed: Observations
    covariance: Covariance
    features: Features

    @classmethod
    def of(cls, observed: Observations, covariance: Covariance, test: NDArray[np.bool_]) -> HeldOutScores:
        """Scores on the observables marked."""
        return cls(observed, covariance, Features.of(observed.layout, test))

    def squares(self, predicted: Array) -> Array:
        """(r, f) with NaN where nothing was measured."""
        return self._scaled(self.observed.values - predicted)

    def floor(self) -> Array:
        """The same for a perfect model: repeats against the others' mean, or their expected scatter if alone."""
        values = self.observed.values
        count = np.isfinite(values).sum(axis=0)
        # r/(r−1): each repeat is part of the mean that it is compared with.
        apart = np.sqrt(np.where(count > 1, count / np.maximum(count - 1, 1), 0.0))
        squares = self._scaled((values - np.nanmean(values, axis=0)) * apart)
        for repeat, variance in enumerate(self._variances()):
            solver = self.features.variances(self.covariance.numerical, self._seen(repeat)) / variance
            alone = self.features.of_each(count, self._seen(repeat)) < 2.0
            squares[repeat] += np.where(alone, 1.0, solver)
        return squares

    def mean(self, squares: Array) -> float:
        """Mean over all that was measured."""
        return float(np.nanmean(squares))

    def size(self, squares: Array) -> float:
        """Root of that mean."""
        return float(np.sqrt(self.mean(squares)))

    def interval(self, squares: dict[str, Array], seed: int) -> tuple[float, float]:
        """95 % interval of the shrink by drawing repeats and cycles anew, as whole loops."""
        random = np.random.default_rng(seed)
        cycles = np.unique(self.features.cycle)
        sums = {
            name: np.array([[np.nansum(row[self.features.cycle == cycle]) for cycle in cycles] for row in values])
            for name, values in squares.items()
        }
        units = sums["before"].size
        draws = random.integers(0, units, size=(_DRAWS, units))
        b, a, f = (sums[name].ravel()[draws].sum(axis=1) for name in ("before", "after", "floor"))
        share = np.where(b - f > 1e-9, (b - a) / np.where(b - f > 1e-9, b - f, 1.0), 0.0)
        low, high = np.percentile(np.clip(share, -9.99, 1.0), [2.5, 97.5])
        return float(low), float(high)

    def _seen(self, repeat: int) -> NDArray[np.bool_]:
        return np.asarray(np.isfinite(self.observed.values[repeat]))

    def _scaled(self, residual: Array) -> Array:
        rows = [self.features.of_each(row, self._seen(repeat)) for repeat, row in enumerate(residual)]
        return np.stack(rows) ** 2 / np.stack(self._variances())

    def _variances(self) -> list[Array]:
        """Variance (f,) of each repeat's features about a perfect model."""
        between = self.covariance.between + self.covariance.numerical
        return [
            self.features.variances(between + np.diag(np.nan_to_num(noise**2)), self._seen(repeat))
            for repeat, noise in enumerate(self.observed.noise)
        ]
