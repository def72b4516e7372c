"""Cholesky factors of a large sparse matrix by nested substructures, kept to solve for any number of right-hand sides.

The elimination is that of `solvers.substructuring`; here every front's factor is kept, which a Schur complement need
not do.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import blas
from scipy.sparse import csr_matrix

from geometry.arrays import Array, BoolArray, IntArray
from solvers.substructuring import (
    Substructure,
    System,
    add_update,
    cholesky_factor,
    divided,
    elimination_order,
    front_of,
    hold,
    node_graph,
    unknowns_of,
)


@dataclass(frozen=True)
class _Front:
    """What is left of an eliminated substructure: its m unknowns, the b that it leaves behind, and how they couple.

    factor: (m, m) lower.  coupling: (b, m).  held: those of its own that are held at zero.
    """

    own: IntArray
    boundary: IntArray
    factor: Array
    coupling: Array
    held: IntArray


@dataclass(frozen=True)
class Factor:
    """A matrix (n, n) factorised on its unknowns that are free; all others are held at zero."""

    size: int
    fronts: tuple[_Front, ...]

    @property
    def bytes(self) -> int:
        """Memory of the factor."""
        return sum(front.factor.nbytes + front.coupling.nbytes for front in self.fronts)

    def solved(self, forces: Array) -> Array:
        """Displacements (n, k) by forces (n, k); those at held unknowns are left out of account."""
        left = forces.astype(np.float64, copy=True)
        for front in self.fronts:
            left[front.held] = 0.0
            own = blas.dtrsm(1.0, front.factor, left[front.own], lower=1)
            left[front.own] = own
            if len(front.boundary):
                left[front.boundary] -= front.coupling @ own
        moved = np.zeros_like(left)
        for front in reversed(self.fronts):
            own = left[front.own] - front.coupling.T @ moved[front.boundary]
            moved[front.own] = blas.dtrsm(1.0, front.factor, own, lower=1, trans_a=1)
        return moved


def factorised(matrix: csr_matrix, nodes: IntArray, unknowns_per_node: int, held: BoolArray) -> tuple[Factor, ...]:
    """Factors of a symmetric matrix (d n, d n) on nodes (k,), all others being held at zero.

    One for each way (v, d n) to hold further unknowns; they share what belongs to substructures without held ones.
    SolverError where the rest is not positive definite.
    """
    d = unknowns_per_node
    graph = node_graph(matrix, d)
    tree = divided(graph, nodes)
    rank = np.full(graph.shape[0], -1, dtype=np.int64)
    order = elimination_order(tree)
    rank[order] = np.arange(len(order))
    fronts: list[list[_Front]] = [[] for _ in held]
    _eliminate(tree, System(matrix, graph, rank, d, held), fronts)
    return tuple(Factor(matrix.shape[0], tuple(each)) for each in fronts)


def _eliminate(tree: Substructure, system: System, fronts: list[list[_Front]]) -> tuple[IntArray, list[Array]]:
    """Eliminate a substructure, append its front for each way to hold unknowns, and return what it leaves.

    That is the nodes that it leaves behind, and the update of their matrix for each way: the same array where ways do
    not differ so far.
    """
    parts = [_eliminate(part, system, fronts) for part in tree.parts]
    d, own = system.d, tree.eliminated
    boundary, position, matrix = front_of(own, [nodes for nodes, _ in parts], system)
    unknowns = unknowns_of(own, d)
    held = system.held[:, unknowns]
    done: dict[tuple[object, ...], tuple[Array, _Front | None]] = {}
    updates = []
    keys = [(of_own.tobytes(), *(id(of_part[way]) for _, of_part in parts)) for way, of_own in enumerate(held)]
    for way, (key, of_own) in enumerate(zip(keys, held, strict=True)):
        if key not in done:
            front = (
                matrix.copy(order="F") if any(later != key and later not in done for later in keys[way:]) else matrix
            )
            for nodes, of_part in parts:
                add_update(front, unknowns_of(position[nodes], d), of_part[way])
            done[key] = _eliminated(front, unknowns, unknowns_of(boundary, d), of_own)
        update, kept = done[key]
        updates.append(update)
        if kept is not None:
            fronts[way].append(kept)
    return boundary, updates


def _eliminated(front: Array, own: IntArray, boundary: IntArray, held: BoolArray) -> tuple[Array, _Front | None]:
    """The update that a front leaves when its own unknowns are eliminated, and what is kept of it."""
    m = len(own)
    if m == 0:  # The two sides are not connected, so nothing separates them.
        return front, None
    hold(front, held)
    factor = cholesky_factor(front[:m, :m])
    coupling = blas.dtrsm(1.0, factor, front[m:, :m], side=1, lower=1, trans_a=1) if len(boundary) else front[m:, :m]
    kept = _Front(own, boundary, factor, coupling, own[held])
    if not len(boundary):
        return front[m:, m:], kept
    return np.asarray(blas.dsyrk(-1.0, coupling, beta=1.0, c=front[m:, m:], lower=1)), kept
