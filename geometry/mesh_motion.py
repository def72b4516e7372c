"""Mesh motion: surface nodes moved into the worn surface, inner nodes moved after them.

The surface recedes along its local normal. How its nodes slide within it is free (arbitrary Lagrangian-Eulerian
motion); here they stay above their places in the plane, so that the patch remains a rectilinear grid: a node moves
down by the vertical depth, which is the recession along the normal over the normal's z component. Inner nodes follow
by springs along the elements' edges, stiffer the shorter the edge, so that small elements near the surface move as a
whole and large ones below take up the strain (Batina, AIAA J. 28 (1990) 1381; Farhat et al., Comput. Methods Appl.
Mech. Eng. 163 (1998) 231).
"""

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags

from geometry.arrays import Array, IntArray
from geometry.errors import GeometryError
from geometry.mesh import HexMesh, QuadMesh

_EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]], dtype=np.int64
)
_STIFFENING = 2.0  #: Stiffness of an edge's spring over 1 / length^_STIFFENING.
_TOLERANCE = 1e-9  #: Residual of the inner nodes' equilibrium; their places need not be exact.


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


def lowered(mesh: HexMesh, nodes: IntArray, depth_mm: Array) -> HexMesh:
    """The mesh with its surface nodes (k,) moved down, towards -z, by a depth (k,) and its inside smoothed.

    All other nodes of the boundary stay where they are, so the volume shrinks by the integral of the depth exactly. A
    symmetric mesh stays so to the last bit under a depth that is.
    GeometryError when the depth is negative or not finite; whether the elements are still sound, `require_quality`
    tells.
    """
    if not np.all((depth_mm >= 0.0) & np.isfinite(depth_mm)):
        raise GeometryError("the depth by which nodes are moved into a worn surface must be a number not below zero")
    drop = np.zeros(len(mesh.points))
    drop[nodes] = depth_mm
    held = np.unique(np.concatenate([mesh.boundary_facets().ravel(), nodes]))
    inner = np.setdiff1d(np.arange(len(mesh.points)), held)
    if inner.size:
        springs = _springs(mesh)[inner]
        surface = drop.copy()
        drop[inner] = _solved(springs[:, inner].tocsr(), -(springs[:, held] @ drop[held]))
        drop = _as_symmetric(mesh, surface, drop)
    points = mesh.points.copy()
    points[:, 2] -= drop
    return HexMesh(points, mesh.cells, mesh.surfaces)


def _as_symmetric(mesh: HexMesh, surface: Array, drop: Array) -> Array:
    """The drop of all nodes (n,) made symmetric to the last bit where the mesh and the drop of its surface are."""
    for axis in (0, 1):
        image = mirror_images(mesh, axis)
        if image is not None and np.array_equal(surface, surface[image]):
            drop = 0.5 * (drop + drop[image])
    return drop


def _solved(matrix: csr_matrix, force: Array) -> Array:
    """Conjugate gradients with diagonal scaling: far cheaper than factors of a three-dimensional mesh."""
    from scipy.sparse.linalg import LinearOperator, cg

    scale = matrix.diagonal()
    preconditioner = LinearOperator(matrix.shape, matvec=lambda residual: residual / scale, dtype=np.float64)
    solution, failed = cg(matrix, force, rtol=_TOLERANCE, M=preconditioner)
    if failed:
        raise GeometryError(
            "the inside of the body could not be moved after its worn surface; please report this study"
        )
    return np.asarray(solution)


def _springs(mesh: HexMesh) -> csr_matrix:
    """Graph Laplacian of the elements' edges, (n, n)."""
    edges = np.unique(np.sort(mesh.cells[:, _EDGES].reshape(-1, 2), axis=1), axis=0)
    lengths = np.linalg.norm(mesh.points[edges[:, 0]] - mesh.points[edges[:, 1]], axis=1)
    stiffness = (lengths.mean() / lengths) ** _STIFFENING
    size = len(mesh.points)
    upper = coo_matrix((stiffness, (edges[:, 0], edges[:, 1])), shape=(size, size)).tocsr()
    both = upper + upper.T
    return csr_matrix(diags(np.asarray(both.sum(axis=1)).ravel()) - both)
