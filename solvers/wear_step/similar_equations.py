"""Dense equations solved one after another that differ little, by the triangular factors of some before them.

Between two steps of Newton's method on a cycle's pressures, normals turn a little and a few nodes open or close. The
factors of the equations before then make an excellent preconditioner: the method of generalised minimal residuals (Saad
& Schultz, SIAM J. Sci. Stat. Comput. 7 (1986) 856) takes a few products of the new matrix, at a cost of n² each, where
factors cost n³.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from geometry.arrays import Array, IntArray

_RESIDUAL = 1e-12  # Of the right-hand side: what is left of equations that count as solved.
_UNKNOWNS_A_PRODUCT = 40  # New factors cost as much as one product for every so many unknowns.


@dataclass(frozen=True)
class _Factors:
    """Of a matrix whose rows and columns, those of some unknowns, were scaled: `row * matrix * column`."""

    unknowns: IntArray
    row: Array
    column: Array
    lu: Array
    pivots: IntArray


class SimilarEquations:
    """Solves equations of some of a set of unknowns, and keeps their factors for the next ones."""

    def __init__(self) -> None:
        """Nothing is known yet."""
        self._factors: _Factors | None = None

    def solution(self, unknowns: IntArray, matrix: Array, rhs: Array, row: Array, column: Array) -> Array | None:
        """The solution (n,) of equations between unknowns (n,), increasing numbers; None where they are singular.

        matrix: (n, n) in Fortran's order, with rows and columns scaled already by `row` and `column`, (n,) each; it is
        used up.  rhs: (n,) scaled by `row`.
        """
        found = self._by_known_factors(unknowns, matrix, rhs, row, column)
        if found is not None:
            return found
        lu, pivots, info = lapack.dgetrf(matrix, overwrite_a=1)
        if info != 0:
            return None
        self._factors = _Factors(unknowns, row, column, lu, pivots)
        solution, _ = lapack.dgetrs(lu, pivots, rhs)
        return np.asarray(solution)

    def _by_known_factors(
        self, unknowns: IntArray, matrix: Array, rhs: Array, row: Array, column: Array
    ) -> Array | None:
        """The solution by the factors of equations before; None where that takes more than new factors."""
        known, size = self._factors, len(rhs)
        most = size // _UNKNOWNS_A_PRODUCT
        if known is None:
            return None
        _, here, there = np.intersect1d(unknowns, known.unknowns, assume_unique=True, return_indices=True)
        if size + len(known.unknowns) - 2 * len(here) > most // 2:
            return None
        to_known = (known.row[there] / row[here]), (known.column[there] / column[here])
        beside = np.ones(size, dtype=bool)
        beside[here] = False
        diagonal = matrix.diagonal()[beside]

        def approximate(residual: Array) -> Array:
            """What solves the equations up to what has changed."""
            load = np.zeros(len(known.unknowns))
            load[there] = to_known[0] * residual[here]
            answer = np.empty(size)
            answer[here] = to_known[1] * lapack.dgetrs(known.lu, known.pivots, load)[0][there]
            answer[beside] = residual[beside] / diagonal
            return answer

        return _minimal_residual(matrix, rhs, approximate, most)


def _minimal_residual(matrix: Array, rhs: Array, approximate: Callable[[Array], Array], most: int) -> Array | None:
    """The solution (n,) by at most so many products of the matrix; None where that does not do."""
    size = float(np.linalg.norm(rhs))
    basis, hessenberg = np.empty((most + 1, len(rhs))), np.zeros((most + 1, most))
    images = np.empty((most, len(rhs)))
    basis[0] = rhs / size
    for k in range(most):
        images[k] = approximate(basis[k])
        new = matrix @ images[k]
        # Twice is enough to be orthogonal to round-off.
        for _ in range(2):
            parts = basis[: k + 1] @ new
            hessenberg[: k + 1, k] += parts
            new -= parts @ basis[: k + 1]
        hessenberg[k + 1, k] = np.linalg.norm(new)
        target = np.zeros(k + 2)
        target[0] = size
        weights, left, _, _ = np.linalg.lstsq(hessenberg[: k + 2, : k + 1], target, rcond=None)
        if len(left) and left[0] ** 0.5 <= _RESIDUAL * size:
            return np.asarray(weights @ images[: k + 1])
        if hessenberg[k + 1, k] <= _RESIDUAL * size:
            return None
        basis[k + 1] = new / hessenberg[k + 1, k]
    return None
