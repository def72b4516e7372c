"""Linear elasticity on eight-node bricks and four-node quadrilaterals, fully integrated: stiffness, stresses,
projections.

Stresses are symmetric tensors of six components in VTK's order: xx, yy, zz, xy, yz, xz, in MPa, tension positive. A
planar body does not change along y: its displacements in the plane (plane strain) and out of it (antiplane shear)
decouple, and both follow from a brick's formulas with all derivatives along y zero. It has three unknowns per node, as
a brick has. scikit-fem assembles the stiffness.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import bsr_matrix, csr_matrix, diags

from geometry import Elastic, HexMesh, QuadMesh
from geometry.arrays import Array, IntArray
from geometry.elements import BRICK, QUADRILATERAL, ElementKind
from solvers.errors import SolverError
from solvers.jit_cache import compiled, inlined

if TYPE_CHECKING:
    from skfem import Basis


_SKFEM_CORNERS = [0, 4, 3, 1, 7, 5, 2, 6]  # scikit-fem numbers the corners of a hexahedron differently from VTK.

_TRIED, _NEWTON = 3, 6  #: Cells tried for a place, and steps to its local coordinates.
_BESIDE = 2.0  #: Local coordinates are kept within this.
TENSOR_PLACES = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))  #: Rows and columns of the six components.


def stiffness_matrix(mesh: HexMesh | QuadMesh, material: Elastic) -> csr_matrix:
    """Stiffness matrix (3 n, 3 n) in N/mm (of a planar body per mm of thickness, of a ring per mm of the circumference
    at z = 0) of a mesh with n nodes.

    The displacement of node i in direction k is unknown 3 i + k. Poisson's ratio must be below 0.5. The matrix is
    assembled from the scalar forms G_ab = integral of (d phi_i / d x_a)(d phi_j / d x_b), several times faster than
    from the vector form: the block of directions a, b is lambda G_ab + mu G_ba + delta_ab mu trace(G). In a ring the
    circumference is strained by u_z/r, and turning by u_y shears by -u_y/r.
    """
    from skfem import BilinearForm
    from skfem.models.elasticity import lame_parameters

    axis = _axis_mm(mesh)
    basis, axes = _basis(mesh)
    lame_lambda, shear = lame_parameters(material.youngs_modulus_MPa, material.poissons_ratio)
    n, corners = len(mesh.points), basis.element_dofs.astype(np.int64)
    # All integrals have the same pattern of nodes that share a cell.
    coupled, place = np.unique((n * corners + corners[:, None]).ravel(), return_inverse=True)
    transposed = np.searchsorted(coupled, n * (coupled % n) + coupled // n)

    def integral(product: Callable[..., Array]) -> Array:
        form = BilinearForm(product)
        if axis is not None:
            form = BilinearForm(lambda u, v, w: product(u, v, w) * np.abs(w.x[1] / axis - 1.0))
        return np.asarray(np.bincount(place, form.coo_data(basis).data), dtype=np.float64)

    gradients = np.zeros((3, 3, len(coupled)))
    for i, a in enumerate(axes):
        for j, b in list(enumerate(axes))[i:]:
            found = integral(lambda u, v, _, i=i, j=j: v.grad[i] * u.grad[j])
            gradients[a, b] = found
            gradients[b, a] = found if a == b else found[transposed]
    blocks = lame_lambda * gradients + shear * np.swapaxes(gradients, 0, 1)
    for a in range(3):
        blocks[a, a] += shear * np.trace(gradients)
    if axis is not None:
        around = integral(lambda u, v, w: v * u / (w.x[1] - axis) ** 2)
        along, out = (integral(lambda u, v, w, i=i: v * u.grad[i] / (w.x[1] - axis)) for i in (0, 1))
        blocks[0, 2] += lame_lambda * along[transposed]
        blocks[2, 0] += lame_lambda * along
        blocks[1, 1] += shear * (around - out - out[transposed])
        blocks[2, 2] += (lame_lambda + 2.0 * shear) * around + lame_lambda * (out + out[transposed])
    starts = np.searchsorted(coupled, n * np.arange(n + 1))
    by_node = np.ascontiguousarray(np.moveaxis(blocks, 2, 0))
    matrix = bsr_matrix((by_node, coupled % n, starts), shape=(3 * n, 3 * n)).tocsr()
    matrix.eliminate_zeros()
    return matrix


@lru_cache(maxsize=1)
def _basis(mesh: HexMesh | QuadMesh) -> tuple[Basis, tuple[int, ...]]:
    """scikit-fem's shape functions with quadrature, and the world directions in which the mesh's fields vary; those of
    the last mesh are kept, as stiffness and projection ask one after the other.
    """
    from skfem import Basis, ElementHex1, ElementQuad1, MeshHex, MeshQuad

    points = np.ascontiguousarray(mesh.points.T)
    if isinstance(mesh, QuadMesh):
        quads = MeshQuad(points, np.ascontiguousarray(mesh.cells.T), sort_t=False, validate=False)
        return Basis(quads, ElementQuad1(), intorder=3), (0, 2)
    bricks = MeshHex(points, np.ascontiguousarray(mesh.cells.T[_SKFEM_CORNERS]), sort_t=False, validate=False)
    return Basis(bricks, ElementHex1(), intorder=3), (0, 1, 2)


def von_mises(stress: Array) -> Array:
    """Von Mises' equivalent stress √(3 J2), (...), in the unit of the six stress components (..., 6)."""
    xx, yy, zz, xy, yz, xz = np.moveaxis(stress, -1, 0)
    normal = (xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2
    return np.asarray(np.sqrt(0.5 * normal + 3.0 * (xy**2 + yz**2 + xz**2)))


def principal(stress: Array) -> Array:
    """Principal stresses (..., 3), the largest first, tension positive, of six stress components (..., 6)."""
    return np.asarray(np.linalg.eigvalsh(tensors(stress))[..., ::-1])


def hydrostatic(stress: Array) -> Array:
    """Mean of the three normal stresses, (...), of six stress components (..., 6); tension positive."""
    return np.asarray(stress[..., :3].mean(axis=-1))


def turned(stress: Array, rotation: Array) -> Array:
    """Stresses (..., 6) in other axes; `rotation` (3, 3) turns vectors from the present axes into those."""
    return components(rotation @ tensors(stress) @ rotation.T)


@dataclass(frozen=True)
class IntegrationPoints:
    """The q integration points, two in each direction, of each of m cells, of c nodes, of a mesh in d dimensions."""

    mesh: HexMesh | QuadMesh
    gradients: Array  #: (m, q, c, 3) gradients of the shape functions, 1/mm.
    volumes: Array  #: (m, q) volume that belongs to each point, mm³ (of a planar body mm²).
    shapes: Array  #: (q, c) values of the shape functions.

    @cached_property
    def positions(self) -> Array:
        """Positions (m, q, d) of the integration points in mm."""
        return np.asarray(np.einsum("qc,mcd->mqd", self.shapes, self.mesh.points[self.mesh.cells]))

    def stresses(self, material: Elastic, displacement: Array) -> Array:
        """Stresses (m, q, 6) in MPa at the points, from displacements (n, 3) in mm of the mesh's nodes."""
        count = self.gradients.shape[:2]
        change = _changes(np.ascontiguousarray(displacement), self.mesh.cells, self.gradients)
        if (axis := _axis_mm(self.mesh)) is not None:
            # A ring is stretched around its axis by what moves away from it, and shorn by what turns about it.
            moved = displacement[self.mesh.cells]
            over = np.einsum("qc,mci->mqi", self.shapes, moved) / (self.positions[..., 1:] - axis)
            change[..., 1, 1], change[..., 2, 1] = over[..., 2], -over[..., 1]
        shear = material.shear_modulus_MPa
        trace = material.lame_MPa * np.trace(change, axis1=2, axis2=3)
        stress = np.empty((*count, 6))
        for k, (i, j) in enumerate(TENSOR_PLACES):
            stress[..., k] = shear * (change[..., i, j] + change[..., j, i])
            if i == j:
                stress[..., k] += trace
        return stress

    def internal_forces(self, stresses: Array) -> Array:
        """Nodal forces (n, 3) in N (planar: N per mm) in equilibrium with stresses (m, q, 6) in MPa at the points."""
        tensor = tensors(stresses) * self.volumes[..., None, None]
        of_cells = np.einsum("mqca,mqab->mcb", self.gradients, tensor, optimize=True)
        return scattered(self.mesh.cells, of_cells, len(self.mesh.points))

    def at_nodes(self, values: Array) -> Array:
        """Nodal fields (n, k) closest in the mean square to values (m, q, k) at the integration points of a mesh all of
        whose nodes have cells. Raises SolverError when the projection does not converge.
        """
        mass = Projection.of(self.mesh).mass
        result = np.zeros((len(self.mesh.points), values.shape[-1]))
        for k, load in enumerate(self.loads(values).T):
            result[:, k] = solved_for_mass(mass, load)
        return result

    def loads(self, values: Array) -> Array:
        """Integrals (n, k) of shape functions times values (m, q, k)."""
        of_cells = np.einsum("qc,mqk,mq->mck", self.shapes, values, self.volumes, optimize=True)
        return scattered(self.mesh.cells, of_cells, len(self.mesh.points))


def integration_points(mesh: HexMesh | QuadMesh) -> IntegrationPoints:
    kind = _kind(mesh)
    at = kind.nodes / np.sqrt(3.0)
    axes = [0, 1, 2] if at.shape[1] == 3 else [0, 2]
    points, slopes = np.zeros((len(mesh.points), 3)), np.zeros((*at.shape[:1], *at.shape[:1], 3))
    points[:, axes], slopes[..., axes] = mesh.points, kind.slopes(at)
    gradients, determinants = _gradients(points, mesh.cells, slopes, len(axes) == 2)
    return IntegrationPoints(mesh, gradients, np.abs(determinants), kind.shapes(at))


@compiled
def _gradients(points: Array, cells: IntArray, slopes: Array, is_planar: bool) -> tuple[Array, Array]:
    """Gradients (m, q, c, 3) of shape functions at points of cells (m, c), and Jacobian determinants (m, q).

    slopes: (q, c, 3) in local coordinates. A planar cell is one of unit thickness along y.
    """
    count, corners = slopes.shape[:2]
    gradients, determinants = np.zeros((len(cells), count, corners, 3)), np.zeros((len(cells), count))
    jacobian, cofactor = np.zeros((3, 3)), np.zeros((3, 3))
    for m in range(len(cells)):
        for q in range(count):
            jacobian[:] = 0.0
            jacobian[1, 1] = 1.0 if is_planar else 0.0
            for c in range(corners):
                for k in range(9):
                    jacobian[k // 3, k % 3] += points[cells[m, c], k // 3] * slopes[q, c, k % 3]
            determinants[m, q] = _cofactors(jacobian, cofactor)
            for k in range(9):
                cofactor[k // 3, k % 3] /= determinants[m, q]
            for c in range(corners):
                for i in range(3):
                    for j in range(3):
                        gradients[m, q, c, i] += slopes[q, c, j] * cofactor[i, j]
    return gradients, determinants


@compiled
def _changes(displacement: Array, cells: IntArray, gradients: Array) -> Array:
    """How each component of displacements (n, 3) changes along each axis, (m, q, 3, 3), at points with gradients
    (m, q, c, 3) of shape functions.
    """
    count, corners = gradients.shape[1:3]
    change = np.zeros((len(cells), count, 3, 3))
    for m in range(len(cells)):
        for q in range(count):
            for c in range(corners):
                for i in range(3):
                    for j in range(3):
                        change[m, q, i, j] += displacement[cells[m, c], i] * gradients[m, q, c, j]
    return change


@inlined
def _cofactors(matrix: Array, cofactor: Array) -> float:
    """Write the cofactors (3, 3) of a matrix (3, 3), and return its determinant."""
    for k in range(9):
        i, j = k // 3 - 2, k % 3 - 2
        cofactor[i + 2, j + 2] = matrix[i, j] * matrix[i + 1, j + 1] - matrix[i, j + 1] * matrix[i + 1, j]
    return float(matrix[0, 0] * cofactor[0, 0] + matrix[0, 1] * cofactor[0, 1] + matrix[0, 2] * cofactor[0, 2])


def solved_for_mass(mass: csr_matrix, load: Array) -> Array:
    """Nodal values (n,) by which a mass matrix (n, n) makes a load (n,), to 1e-7 of it. Raises SolverError when
    conjugate gradients do not converge.
    """
    from scipy.sparse.linalg import cg

    found, failed = cg(mass, load, M=diags(1.0 / mass.diagonal()), rtol=1e-7)
    if failed:
        raise SolverError("stresses could not be projected to the nodes; please report this study")
    return np.asarray(found)


@dataclass(frozen=True, eq=False)
class Projection:
    """Integrals over a mesh of n nodes by which stresses are projected to them.

    mass: (n, n) integrals of the products of two shape functions. slopes: one matrix (n, n) for each of x, y and z, of
    the products of a shape function and the derivative of another along this axis. around: (n, n) of a ring, of the
    products of two shape functions over the height above its axis.
    """

    mass: csr_matrix
    slopes: tuple[csr_matrix, ...]
    around: csr_matrix | None = None

    @classmethod
    def of(cls, mesh: HexMesh | QuadMesh) -> Projection:
        from skfem import BilinearForm

        basis, axes = _basis(mesh)
        slopes = [csr_matrix((len(mesh.points), len(mesh.points)))] * 3
        for i, axis in enumerate(axes):
            slopes[axis] = BilinearForm(lambda u, v, _, i=i: v * u.grad[i]).assemble(basis)
        mass, axis_mm = BilinearForm(lambda u, v, _: v * u).assemble(basis), _axis_mm(mesh)
        if axis_mm is None:
            return cls(mass, tuple(slopes))
        around = BilinearForm(lambda u, v, w: v * u / (w.x[1] - axis_mm)).assemble(basis)
        return cls(mass, tuple(slopes), around)

    def loads(self, material: Elastic, displacements: Array) -> Array:
        """Integrals (n, s, 6) of shape functions times the stresses in MPa of displacements (s, n, 3) in mm."""
        moved = np.ascontiguousarray(np.swapaxes(displacements, 0, 1))
        change = [(each @ moved.reshape(len(moved), -1)).reshape(-1, *moved.shape[1:]) for each in self.slopes]
        result = np.empty((*change[0].shape[:2], 6))
        for k, (i, j) in enumerate(TENSOR_PLACES):
            result[..., k] = material.shear_modulus_MPa * (change[j][..., i] + change[i][..., j])
        result[..., :3] += material.lame_MPa * sum(change[i][..., i, None] for i in range(3))
        if self.around is not None:
            over = (self.around @ moved.reshape(len(moved), -1)).reshape(-1, *moved.shape[1:])
            result[..., :3] += material.lame_MPa * over[..., 2, None]
            result[..., 1] += 2.0 * material.shear_modulus_MPa * over[..., 2]
            result[..., 4] -= material.shear_modulus_MPa * over[..., 1]
        return result


def interpolation(mesh: HexMesh | QuadMesh, places: Array) -> csr_matrix:
    """Sparse matrix (p, n) that takes nodal fields (n, ...) to their values at places (p, d) in mm, inside the mesh or
    at most a cell outside it, where the nearest cell's field is continued.
    """
    from scipy.spatial import cKDTree

    kind = _kind(mesh)
    count, d = kind.nodes.shape
    at = mesh.points[mesh.cells]
    # Long thin cells are found by points inside them; of those near, the one that holds the place best is taken.
    inside = np.einsum("qc,mcd->mqd", kind.shapes(0.5 * kind.nodes), at).reshape(-1, d)
    tried = cKDTree(inside).query(places, k=_TRIED)[1] // count
    nodes = at[tried]
    local = np.zeros((*tried.shape, d))
    for _ in range(_NEWTON):
        missed = places[:, None] - np.einsum("ptc,ptcd->ptd", kind.shapes(local), nodes)
        jacobian = np.einsum("ptcd,ptck->ptdk", nodes, kind.slopes(local), optimize=True)
        local = np.clip(local + np.linalg.solve(jacobian, missed[..., None])[..., 0], -_BESIDE, _BESIDE)
    best = np.abs(local).max(axis=-1).argmin(axis=1)
    chosen = np.arange(len(places))
    weights, columns = kind.shapes(local[chosen, best]), mesh.cells[tried[chosen, best]]
    rows = np.repeat(chosen, count)
    return csr_matrix((weights.ravel(), (rows, columns.ravel())), shape=(len(places), len(mesh.points)))


def _axis_mm(mesh: HexMesh | QuadMesh) -> float | None:
    """Height of the axis about which a mesh turns into a ring; None if it does not."""
    return mesh.axis_mm if isinstance(mesh, QuadMesh) else None


def _kind(mesh: HexMesh | QuadMesh) -> ElementKind:
    return QUADRILATERAL if isinstance(mesh, QuadMesh) else BRICK


def tensors(components: Array) -> Array:
    """Symmetric matrices (..., 3, 3) from six components (..., 6)."""
    return components[..., [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]


def components(matrices: Array) -> Array:
    """Six components (..., 6) of symmetric matrices (..., 3, 3); inverse of `tensors`."""
    rows, columns = zip(*TENSOR_PLACES, strict=True)
    return matrices[..., rows, columns]


def scattered(cells: IntArray, values: Array, size: int) -> Array:
    """Sums (size, k), for each of `size` nodes, of the values (m, c, k) that cells give to their nodes (m, c)."""
    flat = values.reshape(-1, values.shape[-1])
    return np.column_stack([np.bincount(cells.ravel(), column, size) for column in flat.T])
