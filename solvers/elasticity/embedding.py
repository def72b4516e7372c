"""The joint stiffness of a block of hexahedra and its host, a body from a file, condensed to the contact patch.

Unknowns are those of the block's nodes, then those of the host's. Both displacement fields meet on the block's sides
and back, the seam, where they share no nodes, by Nitsche's method: the block's own traction does work on the gap
between them, and a spring closes it (A. Hansbo, P. Hansbo and M. G. Larson, ESAIM: M2AN 37 (2003) 495).
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_diag, coo_matrix, csr_matrix, diags, identity, kron
from threadpoolctl import threadpool_limits

from geometry import BodyMesh, Elastic, HexMesh
from geometry.arrays import Array, IntArray
from geometry.elements import BRICK, ElementKind
from geometry.solid import Host, SolidMesh
from solvers.elasticity.condensation import CondensedBody, condense
from solvers.elasticity.elimination import inverse, schur_complements
from solvers.elasticity.linear_elasticity import stiffness_matrix
from solvers.errors import SolverError

_CHUNK = 4_000_000  #: Numbers of elements' matrices that are worked out together.


def condense_meshed(meshed: BodyMesh, material: Elastic) -> CondensedBody:
    """Condense a meshed body of this material, held at its surface "grip" or, if it has one, in its host, onto its
    patch. Raises SolverError if nothing holds it.
    """
    if meshed.host is None:
        return condense(meshed.mesh, meshed.patch, material, bedding=meshed.bedding)
    joined = Joined.of(meshed, material)
    kept = meshed.patch.nodes.ravel()
    with threadpool_limits(limits=1, user_api="blas"):
        free = np.setdiff1d(joined.free, kept)
        none_held = np.zeros((1, joined.stiffness.shape[0]), dtype=bool)
        (schur,) = schur_complements(joined.stiffness, kept, free, 3, none_held)
        return CondensedBody.whole(meshed.patch, inverse(schur))


@dataclass(frozen=True)
class Joined:
    """The stiffness of a block of b nodes and its host as one system."""

    stiffness: csr_matrix  #: (3 n, 3 n) in N/mm; the first b nodes are the block's, the others the host's.
    free: IntArray  #: Nodes that are not held.
    block: int  #: Number b of the block's nodes.

    @classmethod
    def of(cls, meshed: BodyMesh, material: Elastic) -> "Joined":
        """The system of a meshed body with a host. material: of the body's first part; the host names those of its
        others. Raises SolverError if nothing holds it.
        """
        host = meshed.host
        if host is None or not len(host.held):
            raise SolverError("nothing holds the body; name a surface that is held")
        b, n = len(meshed.mesh.points), len(meshed.mesh.points) + len(host.solid.points)
        materials = (material, *(Elastic(*part) for part in host.parts))
        of_host = solid_stiffness(host.solid, host.part, host.kept, materials)
        if meshed.bedding is not None:
            of_host = of_host + diags(np.repeat(meshed.bedding, 3))
        both = block_diag([_of_block(meshed.mesh, host, materials), of_host], format="csr")
        held = b + host.held if meshed.bedding is None else host.held[:0]
        return cls(
            csr_matrix(both + _seam_stiffness(meshed.mesh, host, materials)), np.setdiff1d(np.arange(n), held), b
        )


def _seam_stiffness(block: HexMesh, host: Host, materials: tuple[Elastic, ...]) -> csr_matrix:
    """Contribution (3 n, 3 n) of the seam to the joint stiffness."""
    seam = host.seam
    nodes = block.cells[seam.cells]
    slopes = BRICK.slopes(seam.local)
    jacobian = np.einsum("fni,fqnj->fqij", block.points[nodes], slopes)
    slopes = slopes @ np.linalg.inv(jacobian)
    size = np.linalg.norm(seam.areas_mm2, axis=2)
    lame, shear = (each[host.part[seam.places.cell]].reshape(size.shape) for each in _constants(materials))
    normal = seam.areas_mm2 / size[..., None]
    # Traction a by displacement b of node n: λ n_a g_b + μ g_a n_b + μ δ_ab g·n.
    traction = lame[:, :, None, None, None] * np.einsum("fqa,fqnb->fqanb", normal, slopes)
    traction += shear[:, :, None, None, None] * np.einsum("fqna,fqb->fqanb", slopes, normal)
    along = shear[:, :, None] * np.einsum("fqna,fqa->fqn", slopes, normal)
    for axis in range(3):
        traction[:, :, axis, :, axis] += along
    b, n = len(block.points), len(block.points) + len(host.solid.points)
    q = size.shape[1]
    rows = np.arange(3 * size.size).reshape(*size.shape, 3)
    columns = 3 * nodes[:, :, None] + np.arange(3)
    shape = (3 * size.size, 3 * n)
    pulled = coo_matrix(
        (
            traction.ravel(),
            (
                np.broadcast_to(rows[..., None, None], traction.shape).ravel(),
                np.broadcast_to(columns[:, None, None], traction.shape).ravel(),
            ),
        ),
        shape=shape,
    ).tocsr()
    points = np.arange(size.size)
    own = BRICK.shapes(seam.local)
    parts = [(np.repeat(points, 8), np.repeat(nodes, q, axis=0).ravel(), own.ravel())]
    for places, of_host, shapes in seam.places.weights:
        parts.append((np.repeat(places, of_host.shape[1]), b + of_host.ravel(), -shapes.ravel()))
    row, column, value = (np.concatenate([part[k] for part in parts]) for k in range(3))
    gap = kron(coo_matrix((value, (row, column)), shape=(size.size, n)), identity(3), format="csr")
    area = diags(np.repeat(size.ravel(), 3))
    # The seam's spring per area, over the block's modulus by its elements' thickness there.
    spring = 10.0 * (lame + 2.0 * shear) / seam.depth_mm[:, None] * size
    work = gap.T @ area @ pulled
    return csr_matrix(gap.T @ diags(np.repeat(spring.ravel(), 3)) @ gap - work - work.T)


def _constants(materials: tuple[Elastic, ...]) -> tuple[Array, Array]:
    """Lamé's constants λ and μ (k,) in MPa of k materials."""
    shear = np.array([one.shear_modulus_MPa for one in materials])
    ratio = np.array([one.poissons_ratio for one in materials])
    return 2.0 * shear * ratio / (1.0 - 2.0 * ratio), shear


def _of_block(mesh: HexMesh, host: Host, materials: tuple[Elastic, ...]) -> csr_matrix:
    if not host.block_part.any():
        return stiffness_matrix(mesh, materials[0])
    whole = SolidMesh(mesh.points, {8: mesh.cells}, {}, {})
    return solid_stiffness(whole, host.block_part, np.ones(len(mesh.cells)), materials)


def solid_stiffness(solid: SolidMesh, part: IntArray, share: Array, materials: tuple[Elastic, ...]) -> csr_matrix:
    """Stiffness (3 n, 3 n) of a mesh whose cells count with a share (size,) each.

    part: number of the material of each cell (size,), or at each of its integration points (size, q).
    """
    lame, shear = _constants(materials)
    size, first = 3 * len(solid.points), 0
    total = csr_matrix((size, size))
    for kind, cells in solid.groups:
        count = 3 * cells.shape[1]
        for rows in np.array_split(np.arange(len(cells)), max(1, len(cells) * count**2 // _CHUNK)):
            number, counts = part[first + rows].reshape(len(rows), -1), share[first + rows, None]
            values = _of_elements(solid, kind, cells[rows], lame[number] * counts, shear[number] * counts)
            unknowns = (3 * cells[rows][:, :, None] + np.arange(3)).reshape(len(rows), count)
            places = np.repeat(unknowns, count, axis=1).ravel(), np.tile(unknowns, (1, count)).ravel()
            total = total + coo_matrix((values.ravel(), places), shape=(size, size)).tocsr()
        first += len(cells)
    return csr_matrix(total)


def _of_elements(solid: SolidMesh, kind: ElementKind, cells: IntArray, lame: Array, shear: Array) -> Array:
    """Stiffness matrices (m, 3 k, 3 k) of elements (m, k) with Lamé's constants (m, q) at their integration points, or
    (m, 1).
    """
    slopes, volumes = solid.gradients(kind, cells)
    found, sheared = (
        np.einsum("mqia,mqjb,mq->miajb", slopes, slopes, each * volumes, optimize=True) for each in (lame, shear)
    )
    found += sheared.transpose(0, 1, 4, 3, 2)
    own = np.einsum("miaja->mij", sheared)
    for axis in range(3):
        found[:, :, axis, :, axis] += own
    k = cells.shape[1]
    return np.asarray(found.reshape(len(cells), 3 * k, 3 * k))
