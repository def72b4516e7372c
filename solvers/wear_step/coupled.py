"""Equations of a cycle's pressures: one dense block for each position, coupled by the wear work on common nodes.

Where all positions meet the same few nodes, the coupling, of low rank, is eliminated before all else (Woodbury's
identity: Hager, SIAM Rev. 31 (1989) 221): that takes a few per cent of what factors of the whole matrix take. Between
two steps of Newton's method on a cycle's pressures, normals turn a little and a few nodes open or close. The factors of
the equations before then make an excellent preconditioner: the method of generalised minimal residuals (Saad & Schultz,
SIAM J. Sci. Stat. Comput. 7 (1986) 856) takes a few products of the new matrix. So factors of single precision do, at
half the cost, but where equations are ill-conditioned.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import get_lapack_funcs, lapack
from scipy.sparse import csr_matrix

from geometry.arrays import Array, IntArray
from solvers.jit_cache import compiled

_RESIDUAL = 1e-12  # Of the right-hand side: what is left of equations that count as solved.
_MOST_PRODUCTS = 30  # New factors cost no more than so many.
# Factors of the whole matrix take less time with more nodes than this per unknown, or fewer unknowns (steel wires).
_FEW_NODES = 0.6
MANY_UNKNOWNS = 700

_Solver = Callable[[Array], Array]  # From right-hand sides to solutions of some equations, (n,).


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
    def places(self) -> list[IntArray]:
        """For each position, the indices (u + 1,) of its u pressures and of its height among all unknowns."""
        start = np.cumsum([0, *(len(block) - 1 for block in self.blocks)])
        return [np.append(np.arange(*pair), start[-1] + k) for k, pair in enumerate(pairwise(start))]


def as_a_whole(coupled: Coupled, precision: type) -> _Solver | None:
    """Solver of the equations by one dense matrix; None where they are singular."""
    getrf, getrs = get_lapack_funcs(("getrf", "getrs"), dtype=precision)
    count = coupled.opened.shape[0] + len(coupled.blocks)
    matrix = np.zeros((count, count), dtype=precision, order="F")
    opened, worked = coupled.opened, coupled.worked.tocsc()
    _join(matrix, (opened.indptr, opened.indices, opened.data), (worked.indptr, worked.indices, worked.data))
    start = 0
    for height, block in enumerate(coupled.blocks, opened.shape[0]):
        own = slice(start, start := start + len(block) - 1)
        matrix[own, own] += block[:-1, :-1]
        matrix[own, height], matrix[height, own], matrix[height, height] = block[:-1, -1], block[-1, :-1], block[-1, -1]
    lu, pivots, singular = getrf(matrix, overwrite_a=True)
    return None if singular else lambda rhs: getrs(lu, pivots, rhs)[0]


@compiled
def _join(matrix: Array, opened: tuple[IntArray, IntArray, Array], worked: tuple[IntArray, IntArray, Array]) -> None:
    """Add opened times the transpose of worked to the matrix; both sparse, by rows and by columns."""
    for i in range(len(opened[0]) - 1):
        for entry in range(opened[0][i], opened[0][i + 1]):
            node = opened[1][entry]
            for other in range(worked[0][node], worked[0][node + 1]):
                matrix[i, worked[1][other]] += opened[2][entry] * worked[2][other]


def position_by_position(coupled: Coupled, precision: type) -> _Solver | None:
    """Solver of the equations by a dense matrix for each position; None where they are singular."""
    getrf, getrs = get_lapack_funcs(("getrf", "getrs"), dtype=precision)
    opened, among = coupled.opened, np.unique(coupled.opened.indices)
    number = np.full(opened.shape[1], -1)
    number[among] = np.arange(len(among))
    # Work on the nodes that matter by each pressure.
    work = coupled.worked[:, among].T.astype(precision).tocsc()
    schur: Array = np.eye(len(among), dtype=precision, order="F")
    parts = []
    for own, block in zip(coupled.places, coupled.blocks, strict=True):
        faced = opened[own[:-1]]
        nodes, column = np.unique(number[faced.indices], return_inverse=True)
        by_work: Array = np.zeros((len(block), len(nodes)), dtype=precision, order="F")
        by_work[np.repeat(np.arange(len(block) - 1), np.diff(faced.indptr)), column] = faced.data
        lu, pivots, singular = getrf(block)
        if singular:
            return None
        by_work = getrs(lu, pivots, by_work)[0]
        parts.append((own, lu, pivots, nodes, by_work))
        schur[:, nodes] += work[:, own[:-1]] @ by_work[:-1]
    joint, swaps, singular = getrf(schur, overwrite_a=True)

    def solved(rhs: Array) -> Array:
        found: Array = np.empty(len(rhs), dtype=precision)
        for own, lu, pivots, _, _ in parts:
            found[own] = getrs(lu, pivots, rhs[own])[0]
        done = getrs(joint, swaps, work @ found[: work.shape[1]])[0]
        for own, _, _, nodes, by_work in parts:
            found[own] -= by_work @ done[nodes]
        return found

    return None if singular else solved


class SimilarEquations:
    """Solves `Coupled` equations one after another whose matrices differ little, each for some of the same unknowns.
    The factors of one matrix are kept, as a preconditioner for those that follow, until they save nothing.
    """

    def __init__(self) -> None:
        self._known: tuple[IntArray, float, _Solver] | None = None

    def solution(
        self,
        unknowns: IntArray,
        rhs: Array,
        row: Array,
        usual: float,
        product: Callable[[Array], Array],
        coupled_now: Callable[[], Coupled],
    ) -> Array | None:
        """The solution (m,) of equations between `unknowns` (m,), increasing numbers in the whole set; None where they
        are singular.

        rhs: (m,). row: (m,) factors on the equations that give them comparable units. usual: median of the diagonal of
        the pressures' equations. product: the matrix times a vector (m,). coupled_now: makes the matrix itself, for
        factors, only if kept ones do not do.
        """
        # New factors cost no more than one product for every 40 unknowns.
        found = self._by_known_factors(unknowns, rhs, row, product, len(unknowns) // 40)
        if found is not None:
            return found
        coupled = coupled_now()
        count = coupled.opened.shape[0]
        few = count > MANY_UNKNOWNS and len(np.unique(coupled.opened.indices)) < _FEW_NODES * count
        for precision in (np.float32, np.float64):
            solver = (position_by_position if few else as_a_whole)(coupled, precision)
            if solver is None:
                continue
            self._known = unknowns, usual, solver
            found = self._by_known_factors(unknowns, rhs, row, product, _MOST_PRODUCTS)
            if found is not None:
                return found
        return None

    def _by_known_factors(
        self, unknowns: IntArray, rhs: Array, row: Array, product: Callable[[Array], Array], most: int
    ) -> Array | None:
        """The solution by the kept factors and at most so many products, up to 30; None where that does not do."""
        if self._known is None:
            return None
        before, usual, solved = self._known
        _, here, there = np.intersect1d(unknowns, before, assume_unique=True, return_indices=True)
        if len(unknowns) + len(before) - 2 * len(here) > most // 2:
            return None

        def approximate(residual: Array) -> Array:
            """Approximate solution of the equations, by the factors of an earlier matrix."""
            load, rest = np.zeros(len(before)), residual / row
            load[there], answer = rest[here], rest / usual
            answer[here] = solved(load)[there]
            return answer

        return _minimal_residual(lambda some: row * product(some), row * rhs, approximate, min(most, _MOST_PRODUCTS))


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
