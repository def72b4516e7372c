"""Static condensation of an elastic body onto the nodes of its contact patch.

The body is held at its grip. Contact is the only non-linearity, so nothing is lost when all other unknowns are
eliminated once: a force f on the patch's nodes moves them by u = C f relative to the grip, with the dense compliance
C = S^-1 and S the Schur complement of the stiffness matrix. Of a body that is its own mirror image, grip included, only
the piece on one side is condensed, once for every kind of displacement, even or odd about each plane.

Schur complement of a large sparse matrix by nested substructures (the multifrontal method).

The unknowns are divided recursively by separators (METIS bisections). From the leaves to the root, each substructure
assembles a dense front, eliminates the nodes that no other substructure touches and passes its Schur complement up
(Duff & Reid, ACM TOMS 9 (1983) 302; George, SIAM J. Numer. Anal. 10 (1973) 345). All work is in dense LAPACK
kernels, which makes it several times faster than a general sparse factorisation followed by extracting the trailing
block (`make bench` prints the ratio).
"""

from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import product

import numpy as np
from scipy.linalg import blas, lapack
from scipy.sparse import csr_matrix, diags
from scipy.sparse.csgraph import maximum_bipartite_matching
from threadpoolctl import threadpool_limits

from geometry import ContactPatch, Elastic, HexMesh, QuadMesh, mirror_images
from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity.patch_compliance import Bricks, PatchCompliance
from solvers.elasticity.strain import stiffness_matrix
from solvers.errors import SolverError
from solvers.jit_cache import compiled

_LEAF_NODES = 120  #: Substructures of at most so many nodes are eliminated as one dense front.
#: Pivots below this share of their diagonal entry are round-off of zero: the body can move freely.
_LEAST_PIVOT = 1e-12

_MOST_TREES = 4


@dataclass(frozen=True)
class Substructure:
    """Nodes to be eliminated once the parts, which touch one another only through them, have been."""

    eliminated: IntArray
    parts: "tuple[Substructure, ...]"


@dataclass(frozen=True)
class System:
    """A matrix of nodes with d unknowns each, the graph of its nodes, the rank of each node in the elimination, and the
    ways (v, d n) to hold unknowns.
    """

    matrix: csr_matrix
    graph: csr_matrix
    rank: IntArray
    d: int
    held: BoolArray


def schur_complements(
    matrix: csr_matrix, kept: IntArray, eliminated: IntArray, unknowns_per_node: int, held: BoolArray
) -> list[Array]:
    """Schur complements onto k kept nodes, (d k, d k), one for each way (v, d n) to hold further unknowns at zero.

    matrix: (d n, d n) symmetric, unknown d i + c belongs to node i; positive definite on the eliminated nodes, else
    SolverError. kept, eliminated: node indices without common members. Nodes neither kept nor eliminated are held at
    zero. Kept unknowns that are held are uncoupled from all others and have a unit on the diagonal. What lies in
    substructures without held unknowns is eliminated once for all.
    """
    d = unknowns_per_node
    graph = node_graph(matrix, d)
    tree = divided(graph, eliminated)
    rank = np.full(graph.shape[0], -1, dtype=np.int64)
    order = np.concatenate([elimination_order(tree), kept])
    rank[order] = np.arange(len(order))
    boundary, updates = eliminate(tree, System(matrix, graph, rank, d, held))
    where = unknowns_of(rank[boundary] - len(eliminated), d)
    results = []
    for of_kept, update in zip(held[:, unknowns_of(kept, d)], updates, strict=True):
        result = _matrix_block(matrix, kept, d)
        add_update(np.zeros((len(result), 0), order="F"), result, where, update)
        hold(result, of_kept)
        lower = np.tril(result)
        results.append(lower + np.tril(result, -1).T)
    return results


def cholesky_factor(matrix: Array) -> Array:
    """Lower Cholesky factor of the stiffness in a matrix's lower triangle, (n, n).

    SolverError when the matrix is not positive definite beyond round-off, as that of a loose body.
    """
    factor, info = lapack.dpotrf(matrix, lower=1, clean=1)
    if info != 0 or np.any(factor.diagonal() ** 2 < _LEAST_PIVOT * matrix.diagonal()):
        raise SolverError("the stiffness matrix is not positive definite: the grip does not hold the body")
    return np.asarray(factor)


def _matrix_block(matrix: csr_matrix, nodes: IntArray, d: int) -> Array:
    where = unknowns_of(nodes, d)
    return np.asarray(matrix[where][:, where].toarray(order="F"))


def node_graph(matrix: csr_matrix, d: int) -> csr_matrix:
    """Which nodes a matrix (d n, d n) couples, (n, n) without a diagonal."""
    rows, columns = matrix.nonzero()
    n = matrix.shape[0] // d
    graph = csr_matrix((np.ones(len(rows), dtype=np.int8), (rows // d, columns // d)), shape=(n, n))
    graph.setdiag(0)
    graph.eliminate_zeros()
    return graph


_TREES: dict[bytes, Substructure] = {}  #: Of the graphs that were divided last.


def divided(graph: csr_matrix, nodes: IntArray) -> Substructure:
    """Recursive bisection: the separator of a set of nodes is eliminated after its two sides.

    A body that wears, and bodies that are meshed alike, have one graph: it is divided once.
    """
    key = sha256(b"".join(np.ascontiguousarray(one).data for one in (graph.indptr, graph.indices, nodes))).digest()
    if key not in _TREES:
        while len(_TREES) >= _MOST_TREES:
            del _TREES[next(iter(_TREES))]
        _TREES[key] = _bisected(graph, nodes)
    return _TREES[key]


def _bisected(graph: csr_matrix, nodes: IntArray) -> Substructure:
    if len(nodes) <= _LEAF_NODES:
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
    """The fewest nodes (n,) that part the second side of a graph from the first.

    Koenig's theorem: they are as many as the couplings between the sides that a largest matching pairs off, and what
    alternating paths from unpaired nodes of the first side reach says which.
    """
    ends, starts = np.flatnonzero(second), np.flatnonzero(~second)
    across = graph[starts][:, ends]
    paired = maximum_bipartite_matching(across, perm_type="column")
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
    """The nodes of a substructure in the order in which they are eliminated."""
    return np.concatenate([*(elimination_order(part) for part in tree.parts), tree.eliminated])


@dataclass(frozen=True)
class Front:
    """What is left of an eliminated substructure: its m unknowns, the b that it leaves behind, and how they couple."""

    own: IntArray
    boundary: IntArray
    factor: Array  #: (m, m) lower.
    coupling: Array  #: (b, m).
    held: IntArray  #: Those of its own that are held at zero.


def eliminate(
    tree: Substructure, system: System, kept: list[list[Front]] | None = None
) -> tuple[IntArray, list[Array]]:
    """Eliminate a substructure; return the nodes it leaves behind, by rank, and their Schur complement's update, one
    for each way to hold unknowns: the same array where ways do not differ so far.

    Of all dense matrices only the lower triangle is meant. As every front is ordered by rank, the lower triangle of
    an update falls into the lower triangle of the front that receives it. Unknowns are held when they are eliminated:
    to hold them in a Schur complement is the same as to hold them before.

    kept: of each way the fronts, to which those of this substructure are added.
    """
    parts = [eliminate(part, system, kept) for part in tree.parts]
    d, own = system.d, tree.eliminated
    boundary, position, columns = front_of(own, [nodes for nodes, _ in parts], system)
    unknowns = unknowns_of(own, d)
    held = system.held[:, unknowns]
    keys = [(of_own.tobytes(), *(id(of_part[way]) for _, of_part in parts)) for way, of_own in enumerate(held)]
    done: dict[tuple[object, ...], tuple[Array, Front | None]] = {}
    for way, key in enumerate(keys):
        if key not in done:
            of_way = columns.copy(order="F")
            rest = np.zeros((len(columns) - len(unknowns),) * 2, order="F")
            for nodes, of_part in parts:
                add_update(of_way, rest, unknowns_of(position[nodes], d), of_part[way])
            update, front = _eliminated(of_way, rest, unknowns, unknowns_of(boundary, d), held[way])
            done[key] = update, None if kept is None else front
        if kept is not None and (front := done[key][1]) is not None:
            kept[way].append(front)
    return boundary, [done[key][0] for key in keys]


def front_of(own: IntArray, left: list[IntArray], system: System) -> tuple[IntArray, IntArray, Array]:
    """The nodes that a front leaves behind, by rank; each node's position in it; the columns of its own unknowns."""
    matrix, rank, d = system.matrix, system.rank, system.d
    neighbours = np.unique(np.concatenate([system.graph[own].indices, *left]))
    later = neighbours[rank[neighbours] > (rank[own].max() if len(own) else -1)]
    boundary = later[np.argsort(rank[later])].astype(np.int64)
    position = np.full(len(rank), -1, dtype=np.int64)
    position[own] = np.arange(len(own))
    position[boundary] = len(own) + np.arange(len(boundary))
    front = np.zeros((d * (len(own) + len(boundary)), d * len(own)), order="F")
    rows = matrix[unknowns_of(own, d)].tocoo()
    inside = position[rows.col // d] >= 0
    columns = rows.col[inside]
    front[d * position[columns // d] + columns % d, rows.row[inside]] = rows.data[inside]
    return boundary, position, front


def _eliminated(
    columns: Array, rest: Array, own: IntArray, boundary: IntArray, held: BoolArray
) -> tuple[Array, Front | None]:
    """The update that a front leaves when its own unknowns, some of them held, are eliminated, and the front.

    columns: (m + b, m) of its own unknowns; rest: (b, b) of those that it leaves behind. Both are used up.
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
    """Uncouple held unknowns, the first of the matrix, from all others."""
    which = np.flatnonzero(held)
    matrix[which] = 0.0
    matrix[:, which] = 0.0
    matrix[which, which] = 1.0


@compiled
def add_update(columns: Array, rest: Array, where: IntArray, update: Array) -> None:
    """Add an update (k, k) to a front at increasing places (k,), in the lower triangle.

    The front's first m columns are `columns` (m + b, m); its others, from the row m on, are `rest` (b, b).
    """
    m = columns.shape[1]
    for j in range(len(where)):
        column = where[j]
        if column < m:
            for i in range(j, len(where)):
                columns[where[i], column] += update[i, j]
        else:
            for i in range(j, len(where)):
                rest[where[i] - m, column - m] += update[i, j]


def unknowns_of(nodes: IntArray, d: int) -> IntArray:
    """The d unknowns of each node, one node after another."""
    return (d * nodes[:, None] + np.arange(d)).ravel()


@dataclass(frozen=True)
class CondensedBody:
    """A body reduced to its contact patch.

    folded: its compliance by symmetry, in mm/N (of a planar body in mm per N/mm), symmetric positive definite; unknown
    3 i + k is the displacement of patch node i (in the order of patch.nodes.ravel()) along the body's axis k, relative
    to the grip.
    bricks: the elements under the patch, None where they are not alike: see `solvers.elasticity.patch_compliance`.
    """

    patch: ContactPatch
    folded: PatchCompliance
    bricks: Bricks | None = None

    @classmethod
    def whole(cls, patch: ContactPatch, compliance: Array) -> "CondensedBody":
        """A body of known compliance (3 n, 3 n), whose symmetry is not used."""
        return cls(patch, PatchCompliance(patch.shape, (), compliance[None]))

    @property
    def compliance(self) -> Array:
        """The whole compliance, (3 n, 3 n)."""
        return self.folded.dense

    @property
    def yields(self) -> bool:
        """False: a condensed body is elastic."""
        return False

    def update(self, print_mm: Array, _force_N: Array, /) -> Array:
        """The print unchanged: an elastic body keeps none."""
        return print_mm


def condense(
    mesh: HexMesh | QuadMesh, patch: ContactPatch, material: Elastic, bedding: Array | None = None
) -> CondensedBody:
    """Condense a body held at its surface "grip".

    bedding: (n,) stiffness in N/mm by which the nodes of an elastic grip are held, in place of holding them still.

    SolverError when nothing is gripped or the patch touches the grip; GeometryError when there is no such surface.
    """
    held = mesh.surface_nodes("grip")
    if not held.size:
        raise SolverError("the surface 'grip' is empty, so nothing holds the body; make the grip larger")
    if np.intersect1d(held, patch.nodes).size:
        raise SolverError("the holder grips nodes of the contact patch; make the grip or the patch smaller")
    piece = piece_to_condense(mesh, patch, held if bedding is None else held[:0])
    # Most fronts are small; on a busy machine, threads that wait for each other would cost ten times what they gain.
    with threadpool_limits(limits=1, user_api="blas"):
        stiffness = stiffness_matrix(piece.mesh, material)
        if bedding is not None:
            stiffness = bedded(stiffness, piece.mesh, piece.planes, bedding[piece.nodes])
        schurs = schur_complements(stiffness, piece.contact, piece.inner, 3, piece.held)
        return CondensedBody(patch, compliance_of(piece, patch, schurs))


@dataclass(frozen=True)
class Piece:
    """What has to be condensed of a body: all of it, or what lies on one side of its mirror planes."""

    #: The axes, 0 along the body and 1 across it, about whose zero the body is its own mirror image.
    planes: tuple[int, ...]
    mesh: HexMesh | QuadMesh  #: Of the piece.
    contact: IntArray  #: Its nodes on the patch, in the patch's order.
    inner: IntArray  #: Its nodes to be eliminated.
    #: (2^p, 3 n) unknowns that are zero on the planes, even about each plane before odd, the last plane first to
    #: change.
    held: BoolArray
    nodes: IntArray  #: Of the whole body.


def bedded(
    stiffness: csr_matrix, piece: HexMesh | QuadMesh, planes: tuple[int, ...], bedding_N_per_mm: Array
) -> csr_matrix:
    """The stiffness of a piece with springs (n,) to ground at its nodes; nodes on a plane have the piece's half."""
    on_planes = sum(((piece.points[:, axis] == 0.0).astype(int) for axis in planes), np.zeros(len(piece.points), int))
    return csr_matrix(stiffness + diags(np.repeat(bedding_N_per_mm / 2.0**on_planes, 3)))


def piece_to_condense(mesh: HexMesh | QuadMesh, patch: ContactPatch, gripped: IntArray) -> Piece:
    """The smallest piece of a body whose nodes `gripped` are held."""
    across = () if isinstance(mesh, QuadMesh) else (1,)
    planes = tuple(axis for axis in (0, *across) if _is_symmetric(mesh, patch, gripped, axis))
    part, number = one_side(mesh, planes)
    side = tuple(slice(n // 2, None) if axis in planes else slice(None) for axis, n in enumerate(patch.shape))
    contact, held = number[patch.nodes[side]].ravel(), number[gripped]
    inner = np.setdiff1d(np.arange(len(part.points)), np.concatenate([held[held >= 0], contact]))
    return Piece(planes, part, contact, inner, held_on_planes(part, planes), np.flatnonzero(number >= 0))


def compliance_of(piece: Piece, patch: ContactPatch, schurs: list[Array]) -> PatchCompliance:
    """The patch's compliance from the Schur complements of the piece, which are used up."""
    unknowns = (3 * piece.contact[:, None] + np.arange(3)).ravel()
    parts = np.empty((len(schurs), len(unknowns), len(unknowns)))
    for part, held in zip(parts, piece.held[:, unknowns], strict=True):
        inverse, _ = lapack.dpotri(cholesky_factor(schurs.pop(0)), lower=1, overwrite_c=1)
        part[...] = np.asarray(np.tril(inverse) + np.tril(inverse, -1).T)
        part[held, held] = 0.0
    return PatchCompliance.of_parities(patch.shape, piece.planes, parts)


def _is_symmetric(mesh: HexMesh | QuadMesh, patch: ContactPatch, held: IntArray, axis: int) -> bool:
    if patch.shape[axis] % 2 == 0:
        return False
    image = mirror_images(mesh, axis)
    return (
        image is not None
        and np.array_equal(image[patch.nodes], np.flip(patch.nodes, axis))
        and np.array_equal(np.sort(image[held]), held)
    )


def one_side(mesh: HexMesh | QuadMesh, planes: tuple[int, ...]) -> tuple[HexMesh | QuadMesh, IntArray]:
    """The mesh on the non-negative sides of planes, without named surfaces, and each old node's number in it or -1."""
    inside = np.ones(len(mesh.cells), dtype=bool)
    for axis in planes:
        inside &= (mesh.points[mesh.cells, axis] >= 0.0).all(axis=1)
    cells = mesh.cells[inside]
    used = np.unique(cells)
    number = np.full(len(mesh.points), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    return replace(mesh, points=mesh.points[used], cells=number[cells], surfaces={}), number


def held_on_planes(piece: HexMesh | QuadMesh, planes: tuple[int, ...]) -> BoolArray:
    """Unknowns (2^p, 3 n) of a piece that are zero on its planes, even about each plane before odd."""
    ways = []
    for odds in product((False, True), repeat=len(planes)):
        held = np.zeros((len(piece.points), 3), dtype=bool)
        for axis, odd in zip(planes, odds, strict=True):
            held[piece.points[:, axis] == 0.0] |= (np.arange(3) == axis) != odd
        ways.append(held.ravel())
    return np.array(ways)
