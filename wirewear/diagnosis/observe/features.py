"""Features of loops in which a gap is measured: height and slope of each branch's zones, and the other channels.

Neighbouring observables of a branch say nearly the same. Height and slope keep what there is to say: friction and
offsets lift a plateau, scars tilt it; compliance and play tilt a stick branch, a sensor's zero moves it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.observable import AlongBranch


@dataclass(frozen=True, eq=False)
class Features:
    """Linear combinations of observables: which `members` (f, n) belong to each, `slope` (f,) if it is one.

    `place` (n,) is where along its branch an observable lies, `cycle` (f,) the cycle of a feature.
    """

    members: NDArray[np.bool_]
    slope: NDArray[np.bool_]
    place: Array
    cycle: NDArray[np.int64]

    @classmethod
    def of(cls, layout: Layout, used: NDArray[np.bool_]) -> Features:
        """Features of the observables marked."""
        members, slope, cycles = [], [], []
        place = np.zeros(len(layout))
        numbers = np.arange(len(layout))
        for part in layout:
            own = numbers[part.rows]
            if isinstance(part.observable, AlongBranch):
                place[own] = part.observable.along(part.sites)
                groups = [(own[places], cycle) for cycle, _, places in part.sites.branches]
            else:
                groups = [(own[[i]], int(cycle)) for i, cycle in enumerate(part.sites.cycle)]
            for rows, cycle in groups:
                here = np.isin(numbers, rows[used[rows]])
                for tilt in (False, True):
                    if here.sum() > int(tilt):
                        members.append(here)
                        slope.append(tilt)
                        cycles.append(cycle)
        return cls(
            np.array(members, dtype=bool).reshape(len(members), len(layout)),
            np.array(slope, dtype=bool),
            place,
            np.array(cycles, dtype=np.int64),
        )

    def of_each(self, values: Array, seen: NDArray[np.bool_]) -> Array:
        """Features (f,) of observables (n,), NaN where none was seen."""
        return self._weights(seen) @ np.where(seen, values, 0.0)

    def variances(self, covariance: Array, seen: NDArray[np.bool_]) -> Array:
        """Variances (f,) of the features of observables of that covariance (n, n)."""
        weights = self._weights(seen)
        return np.asarray(np.einsum("fi,ij,fj->f", weights, covariance, weights, optimize=True))

    def _weights(self, seen: NDArray[np.bool_]) -> Array:
        """Weights (f, n): means, and least-squares slopes."""
        weights = (self.members & seen).astype(float)
        count = weights.sum(axis=1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = weights / count
            away = weights * (self.place - (mean @ self.place)[:, None])
            tilt = away / (away**2).sum(axis=1, keepdims=True)
        return np.where(self.slope[:, None], np.where(count > 1, tilt, np.nan), mean)
