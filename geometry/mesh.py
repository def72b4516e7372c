"""Finite-element meshes as immutable values: named surfaces, quality, mirror images, and their motion with wear.

A worn surface recedes along its local normal. How its nodes slide within it is free (arbitrary Lagrangian-Eulerian
motion); here they move vertically, so that the patch remains a rectilinear grid: a node moves down by the vertical
depth, which is the recession along the normal over the normal's z component. Inner nodes follow by springs along the
elements' edges, stiffer the shorter the edge, so that small elements near the surface move as a whole and large ones
below take up the strain (Batina, AIAA J. 28 (1990) 1381; Farhat et al., Comput. Methods Appl. Mech. Eng. 163 (1998)
231).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import ClassVar

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags

from geometry.arrays import Array, BoolArray, IntArray
from geometry.errors import GeometryError

# meshio's names of the formats that a mesh can be written in.
_FORMATS = {".vtu": "vtu", ".msh": "gmsh22", ".inp": "abaqus"}

# The three edges that meet at each corner of a VTK-ordered hexahedron, in right-handed order.
_CORNER_EDGES = np.array(
    [[0, 1, 3, 4], [1, 2, 0, 5], [2, 3, 1, 6], [3, 0, 2, 7], [4, 7, 5, 0], [5, 4, 6, 1], [6, 5, 7, 2], [7, 6, 4, 3]]
)

_EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]], dtype=np.int64
)
_TOLERANCE = 1e-9  #: Residual of the inner nodes' equilibrium; their places need not be exact.


@dataclass(frozen=True, eq=False)
class ElementMesh(ABC):
    """A mesh of n nodes and m elements of c nodes, all of one shape, with named parts of its boundary."""

    points: Array  #: (n, d) coordinates in mm.
    cells: IntArray  #: (m, c) node indices.
    surfaces: Mapping[str, IntArray]  #: Name -> (k, s) nodes of boundary facets.

    #: Sides (f, s) of a cell that face outwards, as its nodes; what helps a distorted mesh.
    SIDES: ClassVar[IntArray]
    ADVICE: ClassVar[str]

    def __post_init__(self) -> None:
        object.__setattr__(self, "surfaces", MappingProxyType(dict(self.surfaces)))

    def surface_nodes(self, name: str) -> IntArray:
        """Sorted node indices (k,) of a named surface. Raises KeyError without such a surface."""
        return np.unique(self.surfaces[name])

    def boundary_facets(self) -> IntArray:
        """Nodes (k, s) of the sides that belong to one cell only, ordered so that the sides face outwards."""
        sides = self.cells[:, self.SIDES].reshape(-1, self.SIDES.shape[1])
        order, first = _sorted_rows(np.sort(sides, axis=1))
        alone = np.append(first[1:], True) & first
        return np.asarray(sides[order[alone]])

    @cached_property
    def boundary_nodes(self) -> IntArray:
        """Sorted node indices (k,) of the whole boundary."""
        return np.unique(self.boundary_facets())

    @abstractmethod
    def scaled_jacobians(self) -> Array:
        """(m,) smallest scaled Jacobian over the corners of each cell: 1 for a right-angled one, negative if inside
        out.

        Knupp, "Algebraic mesh quality metrics", SIAM J. Sci. Comput. 23 (2001).
        """

    @cached_property
    def quality(self) -> Array:
        """(m,) what `scaled_jacobians` gives, once worked out."""
        return self.scaled_jacobians()

    def require_quality(self, least: float) -> float:
        """The smallest scaled Jacobian of the mesh. Raises GeometryError, naming the place of the worst cell, if it is
        below `least`.
        """
        jacobians = self.quality
        worst = int(np.argmin(jacobians))
        if not jacobians[worst] >= least:
            place = ", ".join(f"{at:.4f}" for at in self.points[self.cells[worst]].mean(axis=0))
            raise GeometryError(
                f"the mesh is too distorted: the element at ({place}) mm has a scaled Jacobian of "
                f"{jacobians[worst]:.3f}, at least {least} is needed; {self.ADVICE}"
            )
        return float(jacobians[worst])

    def _spread(self, facets: IntArray, sizes: Array) -> Array:
        """Sizes (k,) of facets (k, s), each divided equally among its nodes and summed for every node of the mesh,
        (n,).
        """
        shares = np.repeat(sizes / facets.shape[1], facets.shape[1])
        return np.bincount(facets.ravel(), shares, len(self.points)).astype(np.float64)


class HexMesh(ElementMesh):
    """A mesh of eight-node hexahedra, nodes in VTK order; its facets are quadrilaterals."""

    SIDES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
    ADVICE = "use a finer outer mesh or a smaller patch"

    def surface_areas(self, name: str) -> Array:
        """(n,) area in mm² of a named surface that belongs to each node of the mesh, 0 for others. Raises KeyError
        without such a surface.
        """
        self.surface_nodes(name)
        facets = self.surfaces[name]
        corners = self.points[facets]
        vectors = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        return self._spread(facets, np.linalg.norm(vectors, axis=1))

    def scaled_jacobians(self) -> Array:
        corners = np.ascontiguousarray(self.points.T)[:, self.cells.T]
        smallest = np.full(len(self.cells), np.inf)
        for node, *ends in _CORNER_EDGES:
            edges = [corners[:, end] - corners[:, node] for end in ends]
            lengths = np.prod([np.sqrt((edge * edge).sum(axis=0)) for edge in edges], axis=0)
            # An edge without length has no direction; the corner's determinant is zero either way.
            smallest = np.minimum(smallest, _triple_product(*edges) / np.where(lengths > 0.0, lengths, 1.0))
        return smallest

    @cached_property
    def images(self) -> tuple[IntArray | None, IntArray | None]:
        """What `mirror_images` gives about x = 0 and about y = 0, kept for all states of wear of a fresh mesh."""
        return mirror_images(self, 0), mirror_images(self, 1)

    @cached_property
    def springs(self) -> csr_matrix:
        """Stiffness matrix (n, n), one unknown per node, of springs along the elements' edges: the graph Laplacian
        weighted by (mean length / length)².
        """
        edges = np.sort(self.cells[:, _EDGES].reshape(-1, 2), axis=1)
        order, first = _sorted_rows(edges)
        edges = edges[order[first]]
        lengths = np.linalg.norm(self.points[edges[:, 0]] - self.points[edges[:, 1]], axis=1)
        # Stiffness of an edge's spring over 1 / length².
        stiffness = (lengths.mean() / lengths) ** 2.0
        size = len(self.points)
        upper = coo_matrix((stiffness, (edges[:, 0], edges[:, 1])), shape=(size, size)).tocsr()
        both = upper + upper.T
        return csr_matrix(diags(np.asarray(both.sum(axis=1)).ravel()) - both)

    def volume_mm3(self) -> float:
        return float(self.cell_volumes().sum())

    def cell_volumes(self) -> Array:
        """(m,) volume in mm³ of each cell, by splitting it into tetrahedra about its centre."""
        corners = self.points[self.cells]
        centre = corners.mean(axis=1, keepdims=True)
        total = np.zeros(len(corners))
        for quad in self.SIDES:
            a, b, c, d = (corners[:, i] - centre[:, 0] for i in quad)
            for p, q, r in ((a, b, c), (a, c, d), (b, c, d), (b, d, a)):
                total += np.einsum("ij,ij->i", p, np.cross(q, r)) / 12.0
        return total

    def with_mirror_image(self, axis: int) -> "HexMesh":
        """This mesh joined with its mirror image about the plane where the coordinate `axis` is zero; nodes on it are
        shared.

        All nodes must have a coordinate >= 0. This mesh's nodes and cells keep their numbers, the image's follow. A
        named surface of the result holds the facets of both halves.
        """
        coordinate = self.points[:, axis]
        tolerance = 1e-9 * float(np.ptp(self.points))
        on_plane = np.abs(coordinate) <= tolerance
        points = self.points.copy()
        points[on_plane, axis] = 0.0
        image_of = np.empty(len(points), dtype=np.int64)
        image_of[on_plane] = np.flatnonzero(on_plane)
        image_of[~on_plane] = len(points) + np.arange(np.count_nonzero(~on_plane))
        image_points = points[~on_plane].copy()
        image_points[:, axis] *= -1.0
        # A mirror image turns bricks inside out; exchanging bottom and top face restores the orientation.
        image_cells = image_of[self.cells][:, [4, 5, 6, 7, 0, 1, 2, 3]]
        surfaces = {name: np.vstack([facets, image_of[facets][:, ::-1]]) for name, facets in self.surfaces.items()}
        return HexMesh(np.vstack([points, image_points]), np.vstack([self.cells, image_cells]), surfaces)

    def write(self, path: Path, point_data: Mapping[str, Array] | None = None) -> None:
        """Write the mesh as .vtu, .msh or .inp, as the ending of `path` says.

        point_data: name -> (n,) or (n, c) values at the nodes; None: none. The named surfaces are written as groups of
        quadrilaterals, physical groups in .msh and element sets in .inp, but not in .vtu, which has no groups.
        """
        import meshio

        named = {name: facets for name, facets in self.surfaces.items() if len(facets) and path.suffix != ".vtu"}
        blocks = [("hexahedron", self.cells), *(("quad", facets) for facets in named.values())]
        mesh = meshio.Mesh(self.points, blocks, point_data=dict(point_data or {}))
        if path.suffix == ".msh":
            groups = [np.full(len(block), tag, dtype=np.int32) for tag, (_, block) in enumerate(blocks, start=1)]
            mesh.cell_data = {"gmsh:physical": groups, "gmsh:geometrical": groups}
            mesh.field_data = {"body": np.array([1, 3])} | {
                name: np.array([tag, 2]) for tag, name in enumerate(named, start=2)
            }
        else:
            mesh.cell_sets = {
                name: [np.arange(len(block) if i == k else 0) for k, (_, block) in enumerate(blocks)]
                for i, name in enumerate(named, start=1)
            }
        mesh.write(path, file_format=_FORMATS[path.suffix])


@dataclass(frozen=True, eq=False)
class QuadMesh(ElementMesh):
    """A mesh of four-node quadrilaterals in the plane (x, z), counter-clockwise, z upwards; facets are edges (k, 2).

    axis_mm: height z of an axis along x about which the mesh turns into a ring; None: it has unit thickness along y.
    """

    axis_mm: float | None = None

    SIDES = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
    ADVICE = "make the body narrower or higher"

    def surface_lengths(self, name: str) -> Array:
        """(n,) length in mm of a named surface that belongs to each node of the mesh, 0 for others. Raises KeyError
        without such a surface.
        """
        self.surface_nodes(name)
        edges = self.surfaces[name]
        return self._spread(edges, np.linalg.norm(self.points[edges[:, 1]] - self.points[edges[:, 0]], axis=1))

    def scaled_jacobians(self) -> Array:
        """(m,) smallest sine of the four corner angles of each cell, negative if inside out."""
        corners = self.points[self.cells]
        ahead = np.roll(corners, -1, axis=1) - corners
        lengths = np.linalg.norm(ahead, axis=2, keepdims=True)
        ahead = ahead / np.where(lengths > 0.0, lengths, 1.0)
        before = np.roll(ahead, 1, axis=1)
        return np.asarray((before[..., 0] * ahead[..., 1] - before[..., 1] * ahead[..., 0]).min(axis=1))

    def area_mm2(self) -> float:
        first, second = (self.points[self.cells[:, k]] - self.points[self.cells[:, k - 2]] for k in (2, 3))
        return 0.5 * float((first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum())

    def write(self, path: Path) -> None:
        """Write the mesh as .vtu, its points at y = 0."""
        import meshio

        points = np.column_stack([self.points[:, 0], np.zeros(len(self.points)), self.points[:, 1]])
        meshio.Mesh(points, [("quad", self.cells)]).write(path, file_format="vtu")


def _sorted_rows(rows: IntArray) -> tuple[IntArray, BoolArray]:
    """Places (k,) of rows (k, 2 or 4) of node numbers in ascending order, and marks of those unlike the one before."""
    size = int(rows.max(initial=0)) + 1
    pairs = rows[:, ::2] * size + rows[:, 1::2]
    order = np.lexsort(pairs.T[::-1])
    ascending = pairs[order]
    first = np.ones(len(rows), dtype=bool)
    first[1:] = (ascending[1:] != ascending[:-1]).any(axis=1)
    return order, first


def _triple_product(a: Array, b: Array, c: Array) -> Array:
    """Determinants (m,) of the matrices with rows a, b and c, each (3, m)."""
    return np.asarray(
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    )


def mirror_images(mesh: HexMesh | QuadMesh, axis: int) -> IntArray | None:
    """(n,) index of each node's mirror image about the plane where the coordinate `axis` is zero; None unless points
    and cells are their own mirror image to the last bit and no cell crosses the plane.
    """
    points, cells = mesh.points, mesh.cells
    side = np.sign(points[:, axis])[cells]
    if np.any((side.min(axis=1) < 0.0) & (side.max(axis=1) > 0.0)):
        return None
    reflected = points.copy()
    reflected[:, axis] = 0.0 - reflected[:, axis]
    order, image_order = np.lexsort(points.T), np.lexsort(reflected.T)
    if not np.array_equal(points[order], reflected[image_order]):
        return None
    image = np.empty(len(points), dtype=np.int64)
    image[image_order] = order
    one, other = np.sort(cells, axis=1), np.sort(image[cells], axis=1)
    return image if np.array_equal(one[np.lexsort(one.T)], other[np.lexsort(other.T)]) else None


def lowered(mesh: HexMesh, nodes: IntArray, depth_mm: Array, moving: BoolArray | None = None) -> HexMesh:
    """A copy of the mesh with its surface nodes of index `nodes` (k,) moved towards -z by `depth_mm` (k,), and inner
    nodes moved smoothly with them: those of `moving` (n,), None for all.

    The other nodes of the boundary stay in place, so the volume shrinks by exactly the integral of the depth. A mesh
    that is symmetric to the last bit stays so if the depth is. Elements are not checked: see `require_quality`. Raises
    GeometryError if the inner nodes' equilibrium does not converge.
    """
    drop = np.zeros(len(mesh.points))
    drop[nodes] = depth_mm
    held = np.union1d(mesh.boundary_nodes, nodes)
    if moving is not None:
        held = np.union1d(held, np.flatnonzero(~moving))
    inner = np.setdiff1d(np.arange(len(mesh.points)), held)
    if inner.size:
        _, alike = np.unique(_orbits(mesh, drop)[inner], return_inverse=True)
        together = csr_matrix((np.ones(len(inner)), (np.arange(len(inner)), alike)))
        springs = mesh.springs[inner]
        force = together.T @ -(springs[:, held] @ drop[held])
        drop[inner] = _solved((together.T @ springs[:, inner] @ together).tocsr(), force)[alike]
    points = mesh.points.copy()
    points[:, 2] -= drop
    return HexMesh(points, mesh.cells, mesh.surfaces)


def _orbits(mesh: HexMesh, drop: Array) -> IntArray:
    """For each node the first (n,) of those that the mirror planes of both mesh and drop (n,) take into each other."""
    first = np.arange(len(mesh.points))
    for image in mesh.images:
        if image is not None and np.array_equal(drop, drop[image]):
            first = np.minimum(first, first[image])
    return first


def _solved(matrix: csr_matrix, force: Array) -> Array:
    """Solve matrix u = force by conjugate gradients with diagonal scaling; GeometryError when they do not converge."""
    from scipy.sparse.linalg import LinearOperator, cg

    scale = matrix.diagonal()
    preconditioner = LinearOperator(matrix.shape, matvec=lambda residual: residual / scale, dtype=np.float64)
    solution, failed = cg(matrix, force, rtol=_TOLERANCE, M=preconditioner)
    if failed:
        raise GeometryError(
            "the inside of the body could not be moved after its worn surface; please report this study"
        )
    return np.asarray(solution)
