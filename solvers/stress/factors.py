"""Symmetric matrices factorised by nested substructures, and others that differ from them in a few places.

Cholesky factors by the nested substructures of `elasticity.elimination`, of which here every front is kept, to solve
for any number of right-hand sides. What is far from the places that differ is eliminated once.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import blas
from scipy.sparse import csr_matrix, diags

from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity import elimination


@dataclass(frozen=True, eq=False)
class Factor:
    """A symmetric matrix (n, n) factorised on its unknowns that are free; all others are held at zero. fronts: its
    parts, in the order of elimination.
    """

    fronts: tuple[elimination.Front, ...]

    def solved(self, forces: Array) -> Array:
        """Displacements (n, k) by forces (n, k); 0 at held unknowns, whatever forces act there."""
        left = forces.copy()
        for front in self.fronts:
            left[front.held] = 0.0
            if not left[front.own].any():
                continue
            own = blas.dtrsm(1.0, front.factor, left[front.own], lower=1)
            left[front.own] = own
            if len(front.boundary):
                left[front.boundary] -= front.coupling @ own
        moved = np.zeros_like(left)
        for front in reversed(self.fronts):
            own = left[front.own] - front.coupling.T @ moved[front.boundary]
            moved[front.own] = blas.dtrsm(1.0, front.factor, own, lower=1, trans_a=1)
        return moved


@dataclass(frozen=True, eq=False)
class Far:
    """Nodes that are eliminated once for all matrices (d n, d n) which differ at other nodes only.

    rest: (d n, d n) entries of the matrix it was made of between those other nodes. order: the nodes, as eliminated.
    boundary (b,): other nodes coupled to them. updates, fronts: for each of the v ways to hold unknowns what is to be
    added to the matrix (d b, d b) of the boundary, and the fronts.
    """

    rest: csr_matrix
    order: IntArray
    boundary: IntArray
    updates: list[Array]
    fronts: list[list[elimination.Front]]

    @classmethod
    def of(cls, matrix: csr_matrix, nodes: IntArray, differs: BoolArray, d: int, held: BoolArray) -> "Far":
        """The nodes of nodes (k,) where not `differs` (n,); all others are held at zero. matrix, d, held: as of
        `factorised`, but that entries between nodes where `differs` need not be complete.
        """
        graph = elimination.node_graph(matrix, d)
        tree = elimination.divided(graph, nodes[~differs[nodes]])
        order, others = elimination.elimination_order(tree), np.sort(nodes[differs[nodes]])
        rank = np.full(graph.shape[0], -1, dtype=np.int64)
        fronts: list[list[elimination.Front]] = [[] for _ in held]
        rank[order], rank[others] = np.arange(len(order)), len(order) + np.arange(len(others))
        boundary, updates = elimination.eliminate(tree, elimination.System(matrix, graph, rank, d, held), fronts)
        chosen = diags(np.repeat(1.0 * differs, d))
        return cls(csr_matrix(chosen @ matrix @ chosen), order, boundary, updates, fronts)


def factorised(matrix: csr_matrix, nodes: IntArray, d: int, held: BoolArray, far: Far) -> Sequence[Factor]:
    """Factors of a symmetric matrix (d n, d n) on the d unknowns of each of nodes (k,), all others being held at zero.

    held: (v, d n) unknowns held besides, in each of v ways; one factor for each way, which share what belongs to
    substructures without held ones. far: of nodes and ways alike; the matrix needs entries only between nodes that are
    not far. Raises SolverError where the rest is not positive definite.
    """
    graph = elimination.node_graph(matrix, d)
    tree = elimination.divided(graph, np.setdiff1d(nodes, np.append(far.order, far.boundary)))
    rank = np.full(graph.shape[0], -1, dtype=np.int64)
    order = np.concatenate([far.order, elimination.elimination_order(tree), far.boundary])
    rank[order] = np.arange(len(order))
    system, fronts = elimination.System(matrix, graph, rank, d, held), [[*one] for one in far.fronts]
    near = elimination.eliminate(tree, system, fronts)
    elimination.eliminated_after([(far.boundary, far.updates), near], far.boundary, system, fronts)
    return [Factor(tuple(each)) for each in fronts]
