"""Quadrilateral meshes of planar bodies as values: points, cells, named edges, quality, export."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from geometry.arrays import Array, IntArray
from geometry.errors import GeometryError


@dataclass(frozen=True)
class QuadMesh:
    """Four-node quadrilaterals in the plane of x and z.

    points: (n, 2) coordinates (x, z) in mm.  cells: (m, 4) node indices, counter-clockwise with z upwards.
    surfaces: name -> (k, 2) node indices of boundary edges.
    """

    points: Array
    cells: IntArray
    surfaces: Mapping[str, IntArray]

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 2:
            raise GeometryError(f"points of a planar mesh must have shape (n, 2), not {self.points.shape}")
        if self.cells.ndim != 2 or self.cells.shape[1] != 4:
            raise GeometryError(f"quadrilaterals must have shape (m, 4), not {self.cells.shape}")
        object.__setattr__(self, "surfaces", MappingProxyType(dict(self.surfaces)))

    def surface_nodes(self, name: str) -> IntArray:
        """Sorted node indices of a named surface, shape (k,); GeometryError when there is no such surface."""
        if name not in self.surfaces:
            raise GeometryError(f"the mesh has no surface '{name}'; it has {', '.join(sorted(self.surfaces))}")
        return np.unique(self.surfaces[name])

    def surface_lengths(self, name: str) -> Array:
        """Length of a named surface that belongs to each node, shape (n,), mm; GeometryError without such a surface."""
        self.surface_nodes(name)
        edges = self.surfaces[name]
        shares = np.repeat(0.5 * np.linalg.norm(self.points[edges[:, 1]] - self.points[edges[:, 0]], axis=1), 2)
        return np.bincount(edges.ravel(), shares, len(self.points)).astype(np.float64)

    def boundary_edges(self) -> IntArray:
        """Sides that belong to one cell only, shape (k, 2)."""
        sides = np.stack([self.cells, np.roll(self.cells, -1, axis=1)], axis=-1).reshape(-1, 2)
        _, first, counts = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
        return np.asarray(sides[first[counts == 1]])

    def scaled_jacobians(self) -> Array:
        """Smallest sine of the four corner angles of each cell, shape (m,); negative where it is inside out.

        Knupp, "Algebraic mesh quality metrics", SIAM J. Sci. Comput. 23 (2001).
        """
        corners = self.points[self.cells]
        ahead = np.roll(corners, -1, axis=1) - corners
        lengths = np.linalg.norm(ahead, axis=2, keepdims=True)
        ahead = ahead / np.where(lengths > 0.0, lengths, 1.0)
        before = np.roll(ahead, 1, axis=1)
        return np.asarray((before[..., 0] * ahead[..., 1] - before[..., 1] * ahead[..., 0]).min(axis=1))

    def require_quality(self, least: float) -> float:
        """Smallest scaled Jacobian of the mesh; GeometryError naming the worst cell's place when below `least`."""
        jacobians = self.scaled_jacobians()
        worst = int(np.argmin(jacobians))
        if not jacobians[worst] >= least:
            x, z = self.points[self.cells[worst]].mean(axis=0)
            raise GeometryError(
                f"the planar mesh is too distorted: the element at x = {x:.4f}, z = {z:.4f} mm has a scaled Jacobian "
                f"of {jacobians[worst]:.3f}, at least {least} is needed; make the body narrower or higher"
            )
        return float(jacobians[worst])

    def area_mm2(self) -> float:
        """Area of the body."""
        first, second = (self.points[self.cells[:, k]] - self.points[self.cells[:, k - 2]] for k in (2, 3))
        return 0.5 * float((first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]).sum())

    def write(self, path: Path) -> None:
        """Write the mesh as .vtu with y = 0; GeometryError at any other ending."""
        import meshio

        if path.suffix != ".vtu":
            raise GeometryError(f"cannot write a planar mesh to '{path.name}': the name must end in .vtu")
        points = np.column_stack([self.points[:, 0], np.zeros(len(self.points)), self.points[:, 1]])
        meshio.Mesh(points, [("quad", self.cells)]).write(path, file_format="vtu")
