"""Plane sections of bodies, as triangles that matplotlib draws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
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


def section(grid: pyvista.UnstructuredGrid, axis: int, at_um: float, field: str = "von_mises_MPa") -> Section:
    """The cut through a mesh where a coordinate, 0 (x) or 1 (y), has that value; along it runs the other one."""
    normal = np.eye(3)[axis]
    cut = grid.slice(normal=tuple(normal), origin=tuple(normal * (at_um + _BESIDE_um)), generate_triangles=True)
    points = np.asarray(cut.points)
    faces = np.asarray(cut.faces).reshape(-1, 4)[:, 1:] if cut.n_cells else np.zeros((0, 3), dtype=np.int64)
    values = np.asarray(cut.point_data[field]) if cut.n_points else np.zeros(0)
    return Section(points[:, 1 - axis], points[:, 2], faces, values)
