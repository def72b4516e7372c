"""Elimination of unknowns from a sparse symmetric matrix, by the multifrontal method.

The unknowns are divided recursively by separators (METIS bisections). From the leaves to the root, each substructure
assembles a dense matrix, its front, eliminates the nodes that no other substructure touches and passes the Schur
complement, its update, to its parent (Duff & Reid, ACM TOMS 9 (1983) 302; George, SIAM J. Numer. Anal. 10 (1973) 345).
All work is in dense LAPACK kernels, which makes it several times faster than a general sparse factorisation followed by
extracting the trailing block (`make bench` prints the ratio).
"""

from dataclasses import dataclass
from hashlib import sha256

import numpy as np
import scipy
from scipy.linalg import blas, lapack
from scipy.sparse import csr_matrix

from geometry.arrays import Array, BoolArray, IntArray
from solvers.errors import SolverError
from solvers.jit_cache import compiled, inlined

_TREES: "dict[bytes, Substructure]" = {}  #: Cache of `divided`.


@dataclass(frozen=True)
class Substructure:
    """A set of nodes, divided: `eliminated` (m,) are the nodes whose removal separates the `parts`, which are
    eliminated first. Without parts, all nodes of the set.
    """

    eliminated: IntArray
    parts: "tuple[Substructure, ...]"


@dataclass(frozen=True)
class System:
    """A symmetric sparse matrix of n nodes with d unknowns each, prepared for elimination.

    matrix: (d n, d n), unknown d i + c belongs to node i. graph: (n, n) pattern of the nodes that it couples. rank:
    (n,) position of each node in the order of elimination, -1 of nodes that are left out. held: (v, d n) True for
    unknowns held at zero, in each of v ways.
    """

    matrix: csr_matrix
    graph: csr_matrix
    rank: IntArray
    d: int
    held: BoolArray


def schur_complements(
    matrix: csr_matrix, kept: IntArray, eliminated: IntArray, unknowns_per_node: int, held: BoolArray
) -> list[Array]:
    """Schur complements (d k, d k) onto the unknowns of k kept nodes, one for each of the v ways to hold unknowns.

    matrix: (d n, d n) symmetric, unknown d i + c belongs to node i. kept, eliminated: node indices without common
    members; all other nodes are held at zero. held: (v, d n) True for unknowns held at zero besides. Kept unknowns that
    are held are uncoupled from all others and have 1 on the diagonal. Raises SolverError unless the matrix is positive
    definite on the eliminated nodes. Substructures without held unknowns are eliminated once for all ways.
    """
    d = unknowns_per_node
    graph = node_graph(matrix, d)
    tree = divided(graph, eliminated)
    rank = np.full(graph.shape[0], -1, dtype=np.int64)
    order = np.concatenate([elimination_order(tree), kept])
    rank[order] = np.arange(len(order))
    boundary, updates = eliminate(tree, System(matrix, graph, rank, d, held))
    where, own = unknowns_of(rank[boundary] - len(eliminated), d), unknowns_of(kept, d)
    results = []
    for of_kept, update in zip(held[:, own], updates, strict=True):
        result = np.asarray(matrix[own][:, own].toarray(order="F"))
        add_update(np.zeros((len(result), 0), order="F"), result, where, update)
        hold(result, of_kept)
        lower = np.tril(result)
        results.append(lower + np.tril(result, -1).T)
    return results


def cholesky_factor(matrix: Array) -> Array:
    """Lower Cholesky factor (n, n) of a stiffness matrix, of which the lower triangle is read.

    Raises SolverError when the matrix is not positive definite beyond round-off, as that of a body free to move.
    """
    factor, info = lapack.dpotrf(matrix, lower=1, clean=1)
    # Pivots below this share of their diagonal entry are round-off of zero: the body can move freely.
    if info != 0 or np.any(factor.diagonal() ** 2 < 1e-12 * matrix.diagonal()):
        raise SolverError("the stiffness matrix is not positive definite: the grip does not hold the body")
    return np.asarray(factor)


def inverse(matrix: Array) -> Array:
    """Inverse (n, n) of the symmetric stiffness in a lower triangle. Raises SolverError as `cholesky_factor`."""
    lower, _ = lapack.dpotri(cholesky_factor(matrix), lower=1, overwrite_c=1)
    return np.asarray(np.tril(lower) + np.tril(lower, -1).T)


def node_graph(matrix: csr_matrix, d: int) -> csr_matrix:
    """Pattern (n, n), without a diagonal, of the nodes that a matrix (d n, d n) couples."""
    rows, columns = matrix.nonzero()
    n = matrix.shape[0] // d
    graph = csr_matrix((np.ones(len(rows), dtype=np.int8), (rows // d, columns // d)), shape=(n, n))
    graph.setdiag(0)
    graph.eliminate_zeros()
    return graph


def divided(graph: csr_matrix, nodes: IntArray) -> Substructure:
    """Divide nodes (m,) by recursive bisection of their graph (n, n), down to sets of at most 120.

    Results for the last four graphs are kept, as a body that wears asks for the same again.
    """
    key = sha256(b"".join(np.ascontiguousarray(one).data for one in (graph.indptr, graph.indices, nodes))).digest()
    if key not in _TREES:
        while len(_TREES) >= 4:
            del _TREES[next(iter(_TREES))]
        _TREES[key] = _bisected(graph, nodes)
    return _TREES[key]


def _bisected(graph: csr_matrix, nodes: IntArray) -> Substructure:
    # Substructures of at most so many nodes are eliminated as one dense front.
    if len(nodes) <= 120:
        return Substructure(nodes, ())
    import pymetis

    local = graph[nodes][:, nodes].tocsr()
    _, side = pymetis.part_graph(2, pymetis.CSRAdjacency(local.indptr, local.indices))
    second = np.asarray(side, dtype=bool)
    separator = _separator(local, second)
    sides = [nodes[~second & ~separator], nodes[second & ~separator]]
    parts = tuple(_bisected(graph, side_nodes) for side_nodes in sides if len(side_nodes))
    return Substructure(nodes[separator], parts)


def _separator(graph: csr_matrix, second: BoolArray) -> BoolArray:
    """The smallest set of nodes, True in (n,), that separates the side `second` of a graph from the other side.

    By Koenig's theorem it has as many nodes as a largest matching of the couplings between the sides has pairs; the
    nodes that alternating paths from unpaired nodes of the other side reach determine which.
    """
    ends, starts = np.flatnonzero(second), np.flatnonzero(~second)
    across = graph[starts][:, ends]
    paired = scipy.sparse.csgraph.maximum_bipartite_matching(across, perm_type="column")
    partner = np.full(len(ends), -1)
    partner[paired[paired >= 0]] = np.flatnonzero(paired >= 0)
    reached, reached_ends = paired < 0, np.zeros(len(ends), dtype=bool)
    front = np.flatnonzero(reached)
    while len(front):
        new = np.unique(across[front].indices)
        new = new[~reached_ends[new]]
        reached_ends[new] = True
        # All are paired off: else the matching were not the largest.
        front = partner[new]
        reached[front] = True
    separator = np.zeros(len(second), dtype=bool)
    separator[starts], separator[ends] = ~reached, reached_ends
    return separator


def elimination_order(tree: Substructure) -> IntArray:
    """The nodes (m,) of a substructure and its parts, in the order of their elimination."""
    return np.concatenate([*(elimination_order(part) for part in tree.parts), tree.eliminated])


@dataclass(frozen=True)
class Front:
    """An eliminated substructure with m own unknowns and b boundary unknowns, which are eliminated later; own, boundary
    and held are indices into the system's unknowns, held those of `own` that are fixed at zero.
    """

    own: IntArray
    boundary: IntArray
    factor: Array  #: (m, m) lower Cholesky factor L of the own unknowns' matrix.
    coupling: Array  #: (b, m) matrix between boundary and own unknowns times the inverse of L's transpose.
    held: IntArray


def eliminate(
    tree: Substructure, system: System, kept: list[list[Front]] | None = None
) -> tuple[IntArray, list[Array]]:
    """Eliminate a substructure and its parts; what is returned, and `kept`, as by `eliminated_after`."""
    return eliminated_after([eliminate(part, system, kept) for part in tree.parts], tree.eliminated, system, kept)


def eliminated_after(
    parts: list[tuple[IntArray, list[Array]]], own: IntArray, system: System, kept: list[list[Front]] | None = None
) -> tuple[IntArray, list[Array]]:
    """Eliminate nodes (m,) after substructures that they separate, of each of which this function's result is given.
    Returns the boundary nodes (b,), which later substructures share, by rank, and for each of the v ways to hold
    unknowns the update (d b, d b): what is to be added to the matrix of the boundary.

    Ways that do not differ within the substructure share one array. Of dense matrices only the lower triangle is used:
    as fronts are ordered by rank, the lower triangle of an update falls into that of the front that receives it.
    Unknowns are held when their turn comes, which gives the same as holding them beforehand. kept: for each way a list
    to which the fronts of this substructure are appended; None to keep none.
    """
    d = system.d
    boundary, position, columns = front_of(own, [nodes for nodes, _ in parts], system)
    unknowns = unknowns_of(own, d)
    held = system.held[:, unknowns]
    keys = [(of_own.tobytes(), *(id(of_part[way]) for _, of_part in parts)) for way, of_own in enumerate(held)]
    done: dict[tuple[object, ...], tuple[Array, Front | None]] = {}
    for way, key in enumerate(keys):
        if key not in done:
            of_way = columns if len(done) == len(set(keys)) - 1 else columns.copy(order="F")
            rest = np.zeros((len(columns) - len(unknowns),) * 2, order="F")
            for nodes, of_part in parts:
                add_update(of_way, rest, unknowns_of(position[nodes], d), of_part[way])
            update, front = _eliminated(of_way, rest, unknowns, unknowns_of(boundary, d), held[way])
            done[key] = update, None if kept is None else front
        if kept is not None and (front := done[key][1]) is not None:
            kept[way].append(front)
    return boundary, [done[key][0] for key in keys]


def front_of(own: IntArray, left: list[IntArray], system: System) -> tuple[IntArray, IntArray, Array]:
    """The boundary nodes (b,) of a front, by rank; the position of each node of the system in the front, (n,), -1 if
    not in it; and the columns (d (m + b), d m) of its own unknowns, from the system's matrix alone.

    own: (m,) nodes that the front eliminates. left: boundary nodes of each of its parts.
    """
    matrix, rank, d = system.matrix, system.rank, system.d
    neighbours = np.unique(np.concatenate([system.graph[own].indices, *left]))
    later = neighbours[rank[neighbours] > (rank[own].max() if len(own) else -1)]
    boundary = later[np.argsort(rank[later])].astype(np.int64)
    position = np.full(len(rank), -1, dtype=np.int64)
    position[own] = np.arange(len(own))
    position[boundary] = len(own) + np.arange(len(boundary))
    front = np.zeros((d * (len(own) + len(boundary)), d * len(own)), order="F")
    _write_rows(front, matrix.indptr, matrix.indices, matrix.data, unknowns_of(own, d), position, d)
    return boundary, position, front


def _eliminated(
    columns: Array, rest: Array, own: IntArray, boundary: IntArray, held: BoolArray
) -> tuple[Array, Front | None]:
    """The update (b, b) from eliminating a front's own unknowns, some of them held, and the front; None if it has no
    unknowns.

    columns: (m + b, m) of its own unknowns; rest: (b, b) of the boundary's. Both are overwritten.
    """
    m = len(own)
    if m == 0:  # The two sides are not connected, so nothing separates them.
        return rest, None
    hold(columns, held)
    factor = cholesky_factor(columns[:m])
    if not len(boundary):
        return rest, Front(own, boundary, factor, columns[m:], own[held])
    coupling = blas.dtrsm(1.0, factor, columns[m:], side=1, lower=1, trans_a=1)
    update = np.asarray(blas.dsyrk(-1.0, coupling, beta=1.0, c=rest, lower=1, overwrite_c=1))
    return update, Front(own, boundary, factor, coupling, own[held])


def hold(matrix: Array, held: BoolArray) -> None:
    """In place, set rows and columns of held unknowns to 0, their diagonal to 1. held: (m,) flags of the first m."""
    which = np.flatnonzero(held)
    matrix[which] = 0.0
    matrix[:, which] = 0.0
    matrix[which, which] = 1.0


@compiled
def _write_rows(
    front: Array, starts: IntArray, columns: IntArray, data: Array, own: IntArray, position: IntArray, d: int
) -> None:
    """Write rows `own` (m,) of a symmetric sparse matrix to the columns of a front, see `front_of`."""
    for k in range(len(own)):
        for entry in range(starts[own[k]], starts[own[k] + 1]):
            node, component = columns[entry] // d, columns[entry] % d
            if position[node] >= 0:
                front[d * position[node] + component, k] = data[entry]


@compiled
def add_update(columns: Array, rest: Array, where: IntArray, update: Array) -> None:
    """Add an update (k, k) to a front at increasing positions `where` (k,), in the lower triangle, in place.

    The front's first m columns are `columns` (m + b, m); the others, from row m on, are `rest` (b, b).
    """
    m, k = columns.shape[1], len(where)
    # Positions mostly follow one another: numbers are added to a whole stretch of them at once.
    end = np.empty(k, np.int64)
    for i in range(k - 1, -1, -1):
        end[i] = end[i + 1] if i + 1 < k and where[i + 1] == where[i] + 1 else i + 1
    for j in range(k):
        column, i = where[j], j
        while i < k:
            begin, stop = where[i], where[i] + end[i] - i
            if column < m:
                _add(columns[begin:stop, column], update[i : end[i], j])
            else:
                _add(rest[begin - m : stop - m, column - m], update[i : end[i], j])
            i = end[i]


@inlined
def _add(target: Array, values: Array) -> None:
    for i in range(len(values)):
        target[i] += values[i]


def unknowns_of(nodes: IntArray, d: int) -> IntArray:
    """Indices (d k,) of the d unknowns of each of k nodes, one node after another."""
    return (d * nodes[:, None] + np.arange(d)).ravel()
