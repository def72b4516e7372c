"""Static condensation of an elastic body onto the nodes of its contact patch.

The body is held at its grip. Contact is the only non-linearity, so nothing is lost when all other unknowns are
eliminated once: a force f on the patch's nodes moves them by u = C f relative to the grip, with the dense compliance
C = S^-1 and S the Schur complement of the stiffness matrix. Of a body that is its own mirror image, grip included, only
the piece on one side is condensed, once for every kind of displacement, even or odd about each plane.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csr_matrix, diags
from threadpoolctl import threadpool_limits

from geometry import ContactPatch, Elastic, HexMesh, QuadMesh, mirror_images
from geometry.arrays import Array, BoolArray, IntArray
from solvers.errors import SolverError
from solvers.near_field import Bricks
from solvers.patch_compliance import PatchCompliance
from solvers.strain import stiffness_matrix
from solvers.substructuring import cholesky_factor, schur_complements


@dataclass(frozen=True)
class CondensedBody:
    """A body reduced to its contact patch.

    folded: its compliance by symmetry, in mm/N (of a planar body in mm per N/mm), symmetric positive definite; unknown
    3 i + k is the displacement of patch node i (in the order of patch.nodes.ravel()) along the body's axis k, relative
    to the grip.
    bricks: the elements under the patch, None where they are not alike: see `solvers.near_field`.
    """

    patch: ContactPatch
    folded: PatchCompliance
    bricks: Bricks | None = None

    @classmethod
    def whole(cls, patch: ContactPatch, compliance: Array) -> CondensedBody:
        """A body of known compliance (3 n, 3 n), whose symmetry is not used."""
        return cls(patch, PatchCompliance(patch.shape, (), compliance[None]))

    @property
    def compliance(self) -> Array:
        """The whole compliance, (3 n, 3 n)."""
        return self.folded.dense


def condense(
    mesh: HexMesh | QuadMesh, patch: ContactPatch, material: Elastic, grip: str = "grip", bedding: Array | None = None
) -> CondensedBody:
    """Condense a body held at its surface `grip`.

    bedding: (n,) stiffness in N/mm by which the nodes of an elastic grip are held, in place of holding them still.

    SolverError when nothing is gripped or the patch touches the grip; GeometryError when there is no such surface.
    """
    held = mesh.surface_nodes(grip)
    if not held.size:
        raise SolverError(f"the surface '{grip}' is empty, so nothing holds the body; make the grip larger")
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
    """What has to be condensed of a body: all of it, or what lies on one side of its mirror planes.

    planes: the axes, 0 along the body and 1 across it, about whose zero the body is its own mirror image.
    mesh: of the piece.  contact: its nodes on the patch, in the patch's order.  inner: its nodes to be eliminated.
    held: (2^p, 3 n) unknowns that are zero on the planes, even about each plane before odd, the last plane first to
    change.  nodes: of the whole body.
    """

    planes: tuple[int, ...]
    mesh: HexMesh | QuadMesh
    contact: IntArray
    inner: IntArray
    held: BoolArray
    nodes: IntArray


def bedded(
    stiffness: csr_matrix, piece: HexMesh | QuadMesh, planes: tuple[int, ...], bedding_N_per_mm: Array
) -> csr_matrix:
    """The stiffness of a piece with springs (n,) to ground at its nodes; nodes on a plane have the piece's half."""
    on_planes = sum(((piece.points[:, axis] == 0.0).astype(int) for axis in planes), np.zeros(len(piece.points), int))
    return csr_matrix(stiffness + diags(np.repeat(bedding_N_per_mm / 2.0**on_planes, 3)))


def piece_to_condense(mesh: HexMesh | QuadMesh, patch: ContactPatch, gripped: IntArray) -> Piece:
    """The smallest piece of a body whose nodes `gripped` are held."""
    planes = _symmetry_planes(mesh, patch, gripped)
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
        part[...] = _inverse(schurs.pop(0))
        part[held, held] = 0.0
    return PatchCompliance.of_parities(patch.shape, piece.planes, parts)


def _symmetry_planes(mesh: HexMesh | QuadMesh, patch: ContactPatch, held: IntArray) -> tuple[int, ...]:
    """Axes about whose zero the body with its patch and its held nodes is its own mirror image to the last bit."""
    across = () if isinstance(mesh, QuadMesh) else (1,)
    return tuple(axis for axis in (0, *across) if _is_symmetric(mesh, patch, held, axis))


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


def _inverse(matrix: Array) -> Array:
    inverse, _ = lapack.dpotri(cholesky_factor(matrix), lower=1, overwrite_c=1)
    return np.asarray(np.tril(inverse) + np.tril(inverse, -1).T)
