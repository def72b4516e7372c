"""Symmetric matrices factorised by nested substructures, and solutions for others like them.

Cholesky factors by the nested substructures of `elasticity.elimination`, of which here every front is kept, to solve
for any number of right-hand sides.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import blas
from scipy.sparse import csr_matrix

from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity import elimination

#: Share of the energy's root by which displacements may err that are found with the factors of another body (a worn
#: ball's and flat's stresses then err by 2e-5 of the largest), and the steps that this may take before the body's own
#: factors cost less: they take as long as about fifteen.
_EXACT, _STEPS = 1e-5, 12


@dataclass(frozen=True, eq=False)
class Factor:
    """A symmetric matrix (n, n) factorised on its unknowns that are free; all others are held at zero.

    free: (n,) True for free unknowns. fronts: its parts, in the order of elimination.
    """

    matrix: csr_matrix
    free: BoolArray
    fronts: tuple[elimination.Front, ...]

    def solved(self, forces: Array) -> Array:
        """Displacements (n, k) by forces (n, k); 0 at held unknowns, whatever forces act there."""
        substituted = blas.dtrsm if self._is_exact else blas.strsm
        left = forces.astype(self.fronts[0].factor.dtype, copy=True)
        for front in self.fronts:
            left[front.held] = 0.0
            if not left[front.own].any():
                continue
            own = substituted(1.0, front.factor, left[front.own], lower=1)
            left[front.own] = own
            if len(front.boundary):
                left[front.boundary] -= front.coupling @ own
        moved = np.zeros_like(left)
        for front in reversed(self.fronts):
            own = left[front.own] - front.coupling.T @ moved[front.boundary]
            moved[front.own] = substituted(1.0, front.factor, own, lower=1, trans_a=1)
        return moved

    def solved_for(self, matrix: csr_matrix, forces: Array) -> Array | None:
        """What `solved` gives for another matrix with the same free unknowns, by conjugate gradients which this factor
        preconditions (Saad, Iterative Methods for Sparse Linear Systems, 2003, section 9.2); None if they take too
        many steps.
        """
        if matrix is self.matrix and self._is_exact:
            return self.solved(forces)
        left = forces * self.free[:, None]
        # Forces of any size fit into single precision once they are of size 1.
        scale = np.abs(left).max(initial=1e-300)
        left /= scale
        moved, along = np.zeros_like(left), np.zeros_like(left)
        before = first = np.ones(left.shape[1])
        for step in range(_STEPS + 1):
            towards = self.solved(left)
            energy = np.einsum("nk,nk->k", left, towards)
            if step == 0:
                before = first = np.where(energy > 0.0, energy, 1.0)
            if np.all(energy <= _EXACT**2 * first):
                return np.asarray(moved * scale)
            along = towards + energy / before * along if step else towards.astype(np.float64)
            pushed = (matrix @ along) * self.free[:, None]
            work = np.einsum("nk,nk->k", along, pushed)
            length = energy / np.where(work > 0.0, work, 1.0)
            moved += length * along
            left -= length * pushed
            before = np.where(energy > 0.0, energy, 1.0)
        return None

    @property
    def _is_exact(self) -> bool:
        return self.fronts[0].factor.dtype == np.float64


#: Factors by what they are of: mirror planes of the body, and for each whether motions are odd about it.
Factors = dict[tuple[object, ...], Factor]


def factorised(matrix: csr_matrix, nodes: IntArray, unknowns_per_node: int, held: BoolArray) -> tuple[Factor, ...]:
    """Factors of a symmetric matrix (d n, d n) on the unknowns of nodes (k,), all others being held at zero.

    held: (v, d n) unknowns held besides, in each of v ways; one factor for each way, which share what belongs to
    substructures without held ones. Raises SolverError where the rest is not positive definite.
    """
    d = unknowns_per_node
    graph = elimination.node_graph(matrix, d)
    tree = elimination.divided(graph, nodes)
    rank = np.full(graph.shape[0], -1, dtype=np.int64)
    order = elimination.elimination_order(tree)
    rank[order] = np.arange(len(order))
    fronts: list[list[elimination.Front]] = [[] for _ in held]
    elimination.eliminate(tree, elimination.System(matrix, graph, rank, d, held), fronts)
    free = np.repeat(rank >= 0, d) & ~held
    return tuple(Factor(matrix, one, tuple(each)) for one, each in zip(free, fronts, strict=True))
