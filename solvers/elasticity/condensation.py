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
from solvers.elasticity.patch_compliance import Bricks, PatchCompliance
from solvers.elasticity.strain import stiffness_matrix
from solvers.errors import SolverError


@dataclass(frozen=True)
class CondensedBody:
    """A body reduced to its contact patch.

    folded: its compliance, in mm/N (for a planar body in mm per N/mm), symmetric positive definite; unknown 3 i + k is
    the displacement of patch node i (in the order of patch.nodes.ravel()) along the body's axis k, relative to the
    grip.

    bricks: the elements under the patch, for corrections by `patch_compliance`; None where they do not form regular
    layers.
    """

    patch: ContactPatch
    folded: PatchCompliance
    bricks: Bricks | None = None

    @classmethod
    def whole(cls, patch: ContactPatch, compliance: Array) -> "CondensedBody":
        """A body of known compliance matrix (3 n, 3 n), stored without use of symmetry."""
        return cls(patch, PatchCompliance(patch.shape, (), compliance[None]))

    @property
    def compliance(self) -> Array:
        """The whole compliance matrix (3 n, 3 n)."""
        return self.folded.dense

    @property
    def yields(self) -> bool:
        """False: a condensed body is elastic."""
        return False

    def update(self, print_mm: Array, _force_N: Array, /) -> Array:
        """The print unchanged, since an elastic body keeps none."""
        return print_mm


def condense(
    mesh: HexMesh | QuadMesh, patch: ContactPatch, material: Elastic, bedding: Array | None = None
) -> CondensedBody:
    """Condense a body held at its surface "grip" onto its contact patch.

    bedding: (n,) stiffness in N/mm of springs that hold the nodes of an elastic grip; without it the grip is rigid.

    SolverError when nothing is gripped or the patch touches the grip; KeyError without the surface "grip".
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
    """The part of a body that has to be condensed: all of it, or what lies on one side of its p mirror planes."""

    #: The axes, 0 along the body and 1 across it, about whose zero the body is its own mirror image.
    planes: tuple[int, ...]
    mesh: HexMesh | QuadMesh  #: The mesh of the piece, of n nodes.
    contact: IntArray  #: Nodes of the piece on the patch, in the patch's order.
    inner: IntArray  #: Nodes of the piece to be eliminated.
    #: (2^p, 3 n) unknowns that are zero on the planes, even about each plane before odd, the last plane first to
    #: change.
    held: BoolArray
    nodes: IntArray  #: (n,) number of each node of the piece in the whole body.


def bedded(
    stiffness: csr_matrix, piece: HexMesh | QuadMesh, planes: tuple[int, ...], bedding_N_per_mm: Array
) -> csr_matrix:
    """The stiffness matrix of a piece with springs to ground at its nodes.

    bedding_N_per_mm: (n,) of the whole body; nodes on a mirror plane get the piece's half.
    """
    on_planes = sum(((piece.points[:, axis] == 0.0).astype(int) for axis in planes), np.zeros(len(piece.points), int))
    return csr_matrix(stiffness + diags(np.repeat(bedding_N_per_mm / 2.0**on_planes, 3)))


def piece_to_condense(mesh: HexMesh | QuadMesh, patch: ContactPatch, gripped: IntArray) -> Piece:
    """The smallest piece of a body whose nodes `gripped` are held rigidly."""
    across = () if isinstance(mesh, QuadMesh) else (1,)
    planes = tuple(axis for axis in (0, *across) if _is_symmetric(mesh, patch, gripped, axis))
    part, number = one_side(mesh, planes)
    side = tuple(slice(n // 2, None) if axis in planes else slice(None) for axis, n in enumerate(patch.shape))
    contact, held = number[patch.nodes[side]].ravel(), number[gripped]
    inner = np.setdiff1d(np.arange(len(part.points)), np.concatenate([held[held >= 0], contact]))
    return Piece(planes, part, contact, inner, held_on_planes(part, planes), np.flatnonzero(number >= 0))


def compliance_of(piece: Piece, patch: ContactPatch, schurs: list[Array]) -> PatchCompliance:
    """The patch's compliance from the Schur complements of the piece; the list `schurs` is emptied."""
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
    """The mesh on the non-negative sides of mirror planes, without named surfaces, and each old node's number in it, or
    -1.
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
    """Unknowns of a piece that are zero on its planes, (2^p, 3 n): even about each plane before odd, the last changing
    first.
    """
    ways = []
    for odds in product((False, True), repeat=len(planes)):
        held = np.zeros((len(piece.points), 3), dtype=bool)
        for axis, odd in zip(planes, odds, strict=True):
            held[piece.points[:, axis] == 0.0] |= (np.arange(3) == axis) != odd
        ways.append(held.ravel())
    return np.array(ways)
