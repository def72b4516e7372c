"""Equations of a cycle's pressures: one dense block for each position, coupled by the wear work on common nodes.

All positions meet the same few nodes, so the coupling, of low rank, is eliminated before all else (Woodbury's identity:
Hager, SIAM Rev. 31 (1989) 221): that takes a few per cent of what factors of the whole matrix take. Between two steps
of Newton's method on a cycle's pressures, normals turn a little and a few nodes open or close. The factors of the
equations before then make an excellent preconditioner: the method of generalised minimal residuals (Saad & Schultz,
SIAM J. Sci. Stat. Comput. 7 (1986) 856) takes a few products of the new matrix.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csr_matrix

from geometry.arrays import Array, IntArray

_RESIDUAL = 1e-12  # Of the right-hand side: what is left of equations that count as solved.
_MOST_PRODUCTS = 30  # New factors cost no more than so many products.


@dataclass(frozen=True)
class Coupled:
    """The matrix of the equations for a pressures, position by position, and then for one height of the holder a
    position.

    blocks: one matrix (u + 1, u + 1) for each position, between its u pressures and the holder's height. opened: (a,
    nodes) sparse, gap at each pressure's node by unit wear work on nodes of the patches. worked: (a, nodes) sparse,
    work on nodes by each pressure; opened times its transpose is added to the blocks.
    """

    blocks: Sequence[Array]
    opened: csr_matrix
    worked: csr_matrix

    @cached_property
    def diagonal(self) -> Array:
        """(a,) gap in mm that each pressure opens at its own node by strain, per MPa."""
        return np.concatenate([block.diagonal()[:-1] for block in self.blocks])

    @cached_property
    def own(self) -> Array:
        """(a,) gap in mm that each pressure opens at its own node by wear, per MPa."""
        return np.asarray(self.opened.multiply(self.worked).sum(axis=1)).ravel()


@dataclass(frozen=True)
class _Block:
    """One position's equations: where its pressures and height stand among all unknowns, factors, nodes (m,) that it
    faces, and what work on them does to it, (n + 1, m).
    """

    own: IntArray
    lu: Array
    pivots: IntArray
    nodes: IntArray
    by_work: Array

    def solved(self, rhs: Array) -> Array:
        return np.asarray(lapack.dgetrs(self.lu, self.pivots, rhs)[0])


@dataclass(frozen=True)
class _Factors:
    """Factors that solve the equations of some unknowns.  usual: the median of the diagonal of their pressures.
    work: (nodes, a) sparse, work on the nodes that matter by each pressure.
    """

    unknowns: IntArray
    usual: float
    blocks: tuple[_Block, ...]
    work: csr_matrix
    lu: Array
    pivots: IntArray

    @classmethod
    def of(cls, unknowns: IntArray, coupled: Coupled) -> "_Factors | None":
        """Factors of equations between unknowns (a + positions,); None where they are singular."""
        opened, start = coupled.opened, np.concatenate([[0], np.cumsum([len(block) - 1 for block in coupled.blocks])])
        among = np.unique(opened.indices)
        number = np.full(opened.shape[1], -1)
        number[among] = np.arange(len(among))
        work = coupled.worked[:, among].T.tocsc()
        schur, blocks = np.eye(len(among)), []
        for k, block in enumerate(coupled.blocks):
            mine, entries = slice(start[k], start[k + 1]), slice(*opened.indptr[start[k : k + 2]])
            nodes, column = np.unique(number[opened.indices[entries]], return_inverse=True)
            by_work = np.zeros((len(block), len(nodes)), order="F")
            counts = np.diff(opened.indptr[start[k] : start[k + 1] + 1])
            by_work[np.repeat(np.arange(len(block) - 1), counts), column] = opened.data[entries]
            lu, pivots, singular = lapack.dgetrf(block)
            if singular:
                return None
            own = np.append(np.arange(start[k], start[k + 1]), start[-1] + k)
            by_work = lapack.dgetrs(lu, pivots, by_work)[0]
            blocks.append(_Block(own, lu, pivots, nodes, by_work))
            schur[:, nodes] += work[:, mine] @ by_work[:-1]
        lu, pivots, singular = lapack.dgetrf(schur)
        if singular:
            return None
        return cls(unknowns, float(np.median(coupled.diagonal + coupled.own)), tuple(blocks), work, lu, pivots)

    def solved(self, rhs: Array) -> Array:
        """The solution of the equations themselves."""
        found = np.empty_like(rhs)
        for block in self.blocks:
            found[block.own] = block.solved(rhs[block.own])
        work = lapack.dgetrs(self.lu, self.pivots, self.work @ found[: self.work.shape[1]])[0]
        for block in self.blocks:
            found[block.own] -= block.by_work @ work[block.nodes]
        return found


class SimilarEquations:
    """Solver of a sequence of similar equations, each between some of one set of unknowns. The factors of the latest
    matrix that was factorised are kept, as a preconditioner of the next.
    """

    def __init__(self) -> None:
        self._factors: _Factors | None = None

    def solution(
        self, unknowns: IntArray, rhs: Array, row: Array, product: Callable[[Array], Array], coupled: Coupled
    ) -> Array | None:
        """The solution (m,) of equations between `unknowns` (m,), increasing numbers in the whole set; None where they
        are singular.

        rhs: (m,). row: (m,) factors on the equations that give them comparable units. product: the matrix times a
        vector (m,). coupled: the matrix itself, factorised only if kept factors do not do.
        """
        found = self._by_known_factors(unknowns, rhs, row, product)
        if found is None:
            self._factors = _Factors.of(unknowns, coupled)
            found = self._by_known_factors(unknowns, rhs, row, product)
        return found

    def _by_known_factors(
        self, unknowns: IntArray, rhs: Array, row: Array, product: Callable[[Array], Array]
    ) -> Array | None:
        """The solution by the factors of equations before; None where that takes more than new factors."""
        known = self._factors
        if known is None:
            return None
        _, here, there = np.intersect1d(unknowns, known.unknowns, assume_unique=True, return_indices=True)
        if len(unknowns) + len(known.unknowns) - 2 * len(here) > _MOST_PRODUCTS // 2:
            return None

        def approximate(residual: Array) -> Array:
            """Approximate solution of the equations, by the factors of an earlier matrix."""
            load, rest = np.zeros(len(known.unknowns)), residual / row
            load[there], answer = rest[here], rest / known.usual
            answer[here] = known.solved(load)[there]
            return answer

        return _minimal_residual(lambda some: row * product(some), row * rhs, approximate, _MOST_PRODUCTS)


def _minimal_residual(
    product: Callable[[Array], Array], rhs: Array, approximate: Callable[[Array], Array], most: int
) -> Array | None:
    """The solution (n,) by at most so many products of a matrix; None where that does not do."""
    size = float(np.linalg.norm(rhs))
    basis, hessenberg = np.empty((most + 1, len(rhs))), np.zeros((most + 1, most))
    images = np.empty((most, len(rhs)))
    basis[0] = rhs / size
    for k in range(most):
        images[k] = approximate(basis[k])
        new = product(images[k])
        # Twice is enough to be orthogonal to round-off.
        for _ in range(2):
            parts = basis[: k + 1] @ new
            hessenberg[: k + 1, k] += parts
            new -= parts @ basis[: k + 1]
        hessenberg[k + 1, k] = np.linalg.norm(new)
        target = np.zeros(k + 2)
        target[0] = size
        # The least squares' last entry is what they leave.
        _, weights, singular = lapack.dgels(hessenberg[: k + 2, : k + 1], target)
        if not singular and abs(weights[k + 1]) <= _RESIDUAL * size:
            return np.asarray(weights[: k + 1] @ images[: k + 1])
        if hessenberg[k + 1, k] <= _RESIDUAL * size:
            return None
        basis[k + 1] = new / hessenberg[k + 1, k]
    return None
