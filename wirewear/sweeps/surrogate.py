"""A polynomial that stands for a simulation near its middle, with its own error."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Surrogate:
    """A polynomial of the first or second degree; `error` is the root mean square of what it misses at points left out.

    terms: exponents (m, d).  coefficients: (m,).
    """

    terms: NDArray[np.int64]
    coefficients: Array
    error: float

    def at(self, points: Array) -> Array:
        """Values (n,) at points (n, d)."""
        values: Array = _columns(points, self.terms) @ self.coefficients
        return values


def fitted(points: Array, values: Array) -> Surrogate:
    """The polynomial of either degree that predicts left-out points better, by least squares.

    Leave-one-out residuals follow from the hat matrix (Allen's PRESS, Technometrics 16 (1974) 125).

    Args:
        points: (n, d), in standard deviations from the middle.
        values: (n,).

    Raises:
        ValueError: there are too few points for a straight line.
    """
    count, factors = points.shape
    degrees = [degree for degree in (1, 2) if len(_terms(factors, degree)) < 0.8 * count]
    if not degrees:
        raise ValueError(f"{count} points are too few for {factors} factors")
    return min((_of_degree(points, values, degree) for degree in degrees), key=lambda one: one.error)


def _of_degree(points: Array, values: Array, degree: int) -> Surrogate:
    terms = _terms(points.shape[1], degree)
    columns = _columns(points, terms)
    q, r = np.linalg.qr(columns)
    coefficients = np.linalg.solve(r, q.T @ values)
    leverage = np.minimum((q**2).sum(axis=1), 1.0 - 1e-9)
    left_out = (values - columns @ coefficients) / (1.0 - leverage)
    return Surrogate(terms, coefficients, float(np.sqrt(np.mean(left_out**2))))


def _terms(factors: int, degree: int) -> NDArray[np.int64]:
    chosen = [pick for d in range(degree + 1) for pick in combinations_with_replacement(range(factors), d)]
    return np.array([[pick.count(factor) for factor in range(factors)] for pick in chosen], dtype=np.int64)


def _columns(points: Array, terms: NDArray[np.int64]) -> Array:
    columns: Array = np.prod(points[:, None, :] ** terms[None, :, :], axis=2)
    return columns
