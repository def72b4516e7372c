"""Static condensation of an elastic body onto the nodes of its contact patch.

The body is held at its grip. Contact is the only non-linearity, so nothing is lost when all other unknowns are
eliminated once: a force f on the patch's nodes moves them by u = C f relative to the grip, with the dense compliance C
= S^-1 and S the Schur complement of the stiffness matrix. Of a body that is its own mirror image, grip included, only
the piece on one side is condensed, once for each way of holding it on the planes: even or odd about each plane.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.sparse import csr_matrix, diags
from threadpoolctl import threadpool_limits

from geometry import ContactPatch, Elastic, HexMesh, QuadMesh, mirror_images
from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity.elimination import inverse, schur_complements
from solvers.elasticity.linear_elasticity import stiffness_matrix
from solvers.elasticity.patch_compliance import Bricks, PatchCompliance
from solvers.errors import SolverError


@dataclass(frozen=True)
class CondensedBody:
    """A body reduced to its contact patch of n nodes.

    folded: compliance (3 n, 3 n) in mm/N (of a planar body mm per N/mm), symmetric positive definite; unknown 3 i + k
    is the displacement of patch node i (in the order of patch.nodes.ravel()) along the body's axis k, relative to the
    grip. bricks: the elements under the patch, for corrections by `patch_compliance`; None where they do not form
    regular layers.
    """

    patch: ContactPatch
    folded: PatchCompliance
    bricks: Bricks | None = None

    @classmethod
    def whole(cls, patch: ContactPatch, compliance: Array) -> "CondensedBody":
        """The body of a patch with n nodes and of a known compliance matrix (3 n, 3 n), in mm/N."""
        return cls(patch, PatchCompliance(patch.shape, (), compliance[None]))

    @property
    def compliance(self) -> Array:
        return self.folded.dense

    @property
    def yields(self) -> bool:
        return False

    def update(self, print_mm: Array, _force_N: Array, /) -> Array:
        return print_mm


def condense(
    mesh: HexMesh | QuadMesh, patch: ContactPatch, material: Elastic, bedding: Array | None = None
) -> CondensedBody:
    """Condense a body held at its surface "grip" onto its contact patch.

    bedding: (n,) stiffness in N/mm, at all nodes of the mesh, of springs that hold an elastic grip; None: the grip is
    rigid. Raises SolverError when nothing is gripped or the patch touches the grip; KeyError without the surface
    "grip".
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
    """The part of a body that has to be condensed: all of it, or its part on one side of each of p mirror planes."""

    #: The axes (0 along the body, 1 across it) about whose zero the body is its own mirror image.
    planes: tuple[int, ...]
    mesh: HexMesh | QuadMesh  #: The mesh of the piece, of n nodes.
    contact: IntArray  #: Nodes of the piece on the patch, in the patch's order.
    inner: IntArray  #: Nodes of the piece to be eliminated.
    #: (2^p, 3 n) for each way of moving, unknowns that are zero on the planes: even about each plane before odd, the
    #: last plane changing first.
    held: BoolArray
    nodes: IntArray  #: (n,) number of each node of the piece in the whole body.


def bedded(
    stiffness: csr_matrix, piece: HexMesh | QuadMesh, planes: tuple[int, ...], bedding_N_per_mm: Array
) -> csr_matrix:
    """The stiffness matrix (3 n, 3 n) of a piece whose n nodes are tied to ground by springs, in all three directions.

    stiffness: (3 n, 3 n) of the piece without springs, in N/mm. planes: axes (0 is x, 1 is y) normal to the mirror
    planes by which the piece was cut out of the body. bedding_N_per_mm: (n,) stiffness of each node's spring in the
    whole body; a piece has half of the spring at a node on one plane, a quarter where two planes meet.
    """
    on_planes = sum(((piece.points[:, axis] == 0.0).astype(int) for axis in planes), np.zeros(len(piece.points), int))
    return csr_matrix(stiffness + diags(np.repeat(bedding_N_per_mm / 2.0**on_planes, 3)))


def piece_to_condense(mesh: HexMesh | QuadMesh, patch: ContactPatch, gripped: IntArray) -> Piece:
    """The smallest piece of a body from which its compliance follows. gripped: nodes held rigidly, maybe none."""
    if (of_ring := held_of_ring(mesh, gripped)) is not None:
        inner = np.setdiff1d(np.arange(len(mesh.points)), patch.nodes)
        return Piece((), mesh, patch.nodes.ravel(), inner, of_ring, np.arange(len(mesh.points)))
    across = () if isinstance(mesh, QuadMesh) else (1,)
    planes = tuple(axis for axis in (0, *across) if _is_symmetric(mesh, patch, gripped, axis))
    part, number = one_side(mesh, planes)
    side = tuple(slice(n // 2, None) if axis in planes else slice(None) for axis, n in enumerate(patch.shape))
    contact, held = number[patch.nodes[side]].ravel(), number[gripped]
    inner = np.setdiff1d(np.arange(len(part.points)), np.concatenate([held[held >= 0], contact]))
    return Piece(planes, part, contact, inner, held_on_planes(part, planes), np.flatnonzero(number >= 0))


def held_of_ring(mesh: HexMesh | QuadMesh, gripped: IntArray) -> BoolArray | None:
    """(1, 3 n) True for displacements of a ring (a planar mesh turned about an axis along x) that are held: at nodes on
    the axis those across and around it, at gripped nodes those along and around it, so that the ends are free to widen.
    None for a mesh that is no ring.
    """
    if not isinstance(mesh, QuadMesh) or mesh.axis_mm is None:
        return None
    held = np.zeros((len(mesh.points), 3), dtype=bool)
    held[gripped, :2] = True
    # So near to the axis, over the ring's radius, a node lies on it.
    held[np.abs(mesh.points[:, 1] / mesh.axis_mm - 1.0) < 1e-9, 1:] = True
    return held.reshape(1, -1)


def compliance_of(piece: Piece, patch: ContactPatch, schurs: list[Array]) -> PatchCompliance:
    """The patch's compliance from the piece's Schur complements, one for each row of `piece.held`; empties the list."""
    unknowns = (3 * piece.contact[:, None] + np.arange(3)).ravel()
    parts = np.empty((len(schurs), len(unknowns), len(unknowns)))
    for part, held in zip(parts, piece.held[:, unknowns], strict=True):
        part[...] = inverse(schurs.pop(0))
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
    """The mesh on the non-negative sides of mirror planes, without named surfaces, and (n,) the number in it of each
    node of the whole mesh, -1 if left out.
    """
    inside = np.ones(len(mesh.cells), dtype=bool)
    for axis in planes:
        inside &= (mesh.points[mesh.cells, axis] >= 0.0).all(axis=1)
    cells = mesh.cells[inside]
    used = np.unique(cells)
    number = np.full(len(mesh.points), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    return replace(mesh, points=mesh.points[used], cells=number[cells], surfaces={}), number


def held_on_planes(piece: HexMesh | QuadMesh, planes: tuple[int, ...]) -> BoolArray:
    """(2^p, 3 n) True for unknowns of a piece that are zero on its p planes: a motion even about a plane has no
    displacement across it there, an odd one none along it. Rows: all combinations of even and odd, even first; the last
    plane's changes from row to row.
    """
    ways = []
    for odds in product((False, True), repeat=len(planes)):
        held = np.zeros((len(piece.points), 3), dtype=bool)
        for axis, odd in zip(planes, odds, strict=True):
            held[piece.points[:, axis] == 0.0] |= (np.arange(3) == axis) != odd
        ways.append(held.ravel())
    return np.array(ways)
