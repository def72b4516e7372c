"""Mirror symmetry of meshes, tested to the last bit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geometry.hexmesh import HexMesh
from geometry.quadmesh import QuadMesh

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def mirror_images(mesh: HexMesh | QuadMesh, axis: int) -> IntArray | None:
    """The mirror image of each node about the plane through zero on `axis`, shape (n,).

    None unless points and cells are their own mirror image to the last bit and no cell crosses the plane.
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
    return image if _same_cells(cells, image[cells]) else None


def _same_cells(first: IntArray, second: IntArray) -> bool:
    """Whether two lists of cells (m, c) have the same nodes in each cell, whatever the order of cells."""
    one, other = np.sort(first, axis=1), np.sort(second, axis=1)
    return bool(np.array_equal(one[np.lexsort(one.T)], other[np.lexsort(other.T)]))
