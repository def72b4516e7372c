"""Plane sections of bodies, as triangles that matplotlib draws."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: A section lies so far beside its plane [µm]: mirror planes are full of faces that would be cut twice.
_BESIDE_um = 1e-4


@dataclass(frozen=True, eq=False)
class Section:
    """A cut through a body: positions in the plane [µm], (n,) each, triangles (t, 3), a field (n,)."""

    along: Array
    height: Array
    triangles: IntArray
    values: Array

    @property
    def places(self) -> Triangulation:
        """Its triangles as matplotlib takes them."""
        return Triangulation(self.along, self.height, self.triangles)


def section(grid: pyvista.UnstructuredGrid, axis: int, at_um: float, field: str = "von_mises_MPa") -> Section:
    """The cut through a mesh where a coordinate, 0 (x) or 1 (y), has that value; along it runs the other one."""
    normal = np.eye(3)[axis]
    origin = tuple(normal * (at_um + _BESIDE_um))
    cut = grid.slice(normal=tuple(normal), origin=origin, generate_triangles=False)
    values = np.asarray(cut.point_data[field]) if cut.n_points else np.zeros(0)
    return fanned(np.asarray(cut.points)[:, [1 - axis, 2]], values, cut.irregular_faces if cut.n_cells else ())


def plane_section(
    grid: pyvista.UnstructuredGrid, field: str = "von_mises_MPa", *, within: IntArray | None = None
) -> Section:
    """A line contact's body, which is a section already: its quadrilaterals whose corners are all in `within`."""
    quads = np.asarray(grid.cells).reshape(-1, 5)[:, 1:]
    if within is not None:
        quads = quads[np.isin(quads, within).all(axis=1)]
    return fanned(np.asarray(grid.points)[:, [0, 2]], np.asarray(grid.point_data[field]), quads)


def fanned(points: Array, values: Array, polygons: Iterable[IntArray]) -> Section:
    """Polygons of points (n, 2), each in as many triangles about its middle as it has sides.

    Two triangles on one of a quadrilateral's diagonals would make contours of what is symmetric look slanted.
    """
    faces = [np.asarray(polygon) for polygon in polygons]
    triangles, middles, means = [np.zeros((0, 3), dtype=np.int64)], [points], [values]
    first = len(points)
    for corners in sorted({len(face) for face in faces}):
        alike = np.array([face for face in faces if len(face) == corners])
        middle = first + np.arange(len(alike))
        triangles += [np.column_stack([alike[:, k], alike[:, (k + 1) % corners], middle]) for k in range(corners)]
        middles.append(points[alike].mean(axis=1))
        means.append(values[alike].mean(axis=1))
        first += len(alike)
    where = np.vstack(middles)
    return Section(where[:, 0], where[:, 1], np.vstack(triangles), np.concatenate(means))
