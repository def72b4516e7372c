"""Hexahedral meshes as values: points, cells, named surfaces, quality, mirror images, export."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from geometry.arrays import Array, IntArray
from geometry.errors import GeometryError

# meshio's names of the formats that a mesh can be written in.
_FORMATS = {".vtu": "vtu", ".msh": "gmsh22", ".inp": "abaqus"}

# The three edges that meet at each corner of a VTK-ordered hexahedron, in right-handed order.
_CORNER_EDGES = np.array(
    [[0, 1, 3, 4], [1, 2, 0, 5], [2, 3, 1, 6], [3, 0, 2, 7], [4, 7, 5, 0], [5, 4, 6, 1], [6, 5, 7, 2], [7, 6, 4, 3]]
)

# Outward-facing sides of a VTK-ordered hexahedron.
_SIDES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])


@dataclass(frozen=True)
class HexMesh:
    """Eight-node bricks.

    points: (n, 3) coordinates in mm.  cells: (m, 8) node indices in VTK order.
    surfaces: name -> (k, 4) node indices of boundary facets.
    """

    points: Array
    cells: IntArray
    surfaces: Mapping[str, IntArray]

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3:
            raise GeometryError(f"mesh points must have shape (n, 3), not {self.points.shape}")
        if self.cells.ndim != 2 or self.cells.shape[1] != 8:
            raise GeometryError(f"hexahedra must have shape (m, 8), not {self.cells.shape}")
        object.__setattr__(self, "surfaces", MappingProxyType(dict(self.surfaces)))

    def surface_nodes(self, name: str) -> IntArray:
        """Sorted node indices of a named surface, shape (k,); GeometryError when there is no such surface."""
        if name not in self.surfaces:
            raise GeometryError(f"the mesh has no surface '{name}'; it has {', '.join(sorted(self.surfaces))}")
        return np.unique(self.surfaces[name])

    def surface_areas(self, name: str) -> Array:
        """Area of a named surface that belongs to each node, shape (n,), mm²; GeometryError without such a surface."""
        self.surface_nodes(name)
        facets = self.surfaces[name]
        corners = self.points[facets]
        vectors = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        shares = np.repeat(0.25 * np.linalg.norm(vectors, axis=1), 4)
        return np.bincount(facets.ravel(), shares, len(self.points)).astype(np.float64)

    def boundary_facets(self) -> IntArray:
        """Sides that belong to one cell only, shape (k, 4), facing outwards."""
        sides = self.cells[:, _SIDES].reshape(-1, 4)
        _, first, counts = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
        return np.asarray(sides[first[counts == 1]])

    def scaled_jacobians(self) -> Array:
        """Smallest scaled Jacobian over the eight corners of each cell, shape (m,); 1 is a perfect brick.

        Knupp, "Algebraic mesh quality metrics", SIAM J. Sci. Comput. 23 (2001).
        """
        corners = self.points[self.cells]
        smallest = np.full(len(self.cells), np.inf)
        for node, *ends in _CORNER_EDGES:
            edges = corners[:, ends] - corners[:, [node]]
            lengths = np.linalg.norm(edges, axis=2)
            # An edge without length has no direction; the corner's determinant is zero either way.
            directions = edges / np.where(lengths > 0.0, lengths, 1.0)[:, :, None]
            smallest = np.minimum(smallest, np.linalg.det(directions))
        return smallest

    def require_quality(self, least: float) -> float:
        """Smallest scaled Jacobian of the mesh; GeometryError naming the worst cell's place when below `least`."""
        jacobians = self.scaled_jacobians()
        worst = int(np.argmin(jacobians))
        if not jacobians[worst] >= least:
            x, y, z = self.points[self.cells[worst]].mean(axis=0)
            raise GeometryError(
                f"the mesh is too distorted: the element at ({x:.4f}, {y:.4f}, {z:.4f}) mm has a scaled Jacobian of "
                f"{jacobians[worst]:.3f}, at least {least} is needed; use a finer outer mesh or a smaller patch"
            )
        return float(jacobians[worst])

    def volume_mm3(self) -> float:
        """Volume by the divergence theorem over cells split into tetrahedra about their centres."""
        corners = self.points[self.cells]
        centre = corners.mean(axis=1, keepdims=True)
        total = 0.0
        for quad in _SIDES:
            a, b, c, d = (corners[:, i] - centre[:, 0] for i in quad)
            for p, q, r in ((a, b, c), (a, c, d), (b, c, d), (b, d, a)):
                total += float(np.einsum("ij,ij->", p, np.cross(q, r))) / 12.0
        return total

    def with_mirror_image(self, axis: int) -> "HexMesh":
        """This mesh and its mirror image about the plane through zero on `axis`, sharing the nodes on that plane.

        All nodes must lie on the non-negative side, else GeometryError. Surfaces of the mirror image join those of the
        same name.
        """
        coordinate = self.points[:, axis]
        tolerance = 1e-9 * float(np.ptp(self.points))
        on_plane = np.abs(coordinate) <= tolerance
        if coordinate.min() < -tolerance:
            raise GeometryError(f"the mesh crosses its mirror plane: {'xyz'[axis]} reaches {coordinate.min():.4g} mm")
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
        """Write the mesh as .vtu, .msh or .inp, whichever `path` ends in; GeometryError at any other ending.

        point_data: name -> (n,) or (n, c) values at the points. The surfaces are written as named groups of
        quadrilaterals, physical groups in .msh and element sets in .inp, and left out of .vtu, which has no groups.
        """
        import meshio

        if path.suffix not in _FORMATS:
            raise GeometryError(f"cannot write a mesh to '{path.name}': the name must end in {', '.join(_FORMATS)}")
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
