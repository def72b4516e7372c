"""Surface-to-surface coupling of two bodies by a mortar method on the plane of contact.

The primary body carries the contact tractions, one per node and unit plane area. The secondary surface is averaged
over the support of each node: its facets' heights and displacements are integrated with the node's shape function at
Gauss points of the primary's facets, projected along z. On the primary the same integrals are lumped to the node,
which keeps the pressure free of the oscillations that consistent integration gives on coarse meshes. The same operators
transfer forces and displacements, so the coupling conserves forces and work. A uniform pressure arrives as the exact
nodal forces between equally spaced grids; else single nodal forces err by the quadrature, up to 2 % when the primary
is the finer grid and ten times that when it is half as coarse again as the secondary (Puso & Laursen, Comput. Methods
Appl. Mech. Eng. 193 (2004) 601; for lumping: Wohlmuth, SIAM J. Numer. Anal. 38 (2000) 989).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from solvers.placement import PlacedBody

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

_GAUSS_POINTS = 5


@dataclass(frozen=True)
class PrimarySurface:
    """Quadrature on the primary body's patch, independent of where the secondary body is.

    points: (g, 2) plane positions of the Gauss points.  test: (n, g) sparse, shape function of node j at point g
    times the point's plane area.  areas: (n,) plane area of each node.  fresh_slope: (n, 2) mean slope of the unworn
    surface about each node, in the patch's axes.  averaging: (n, n) sparse, mean of a nodal field about each node.
    """

    body: PlacedBody
    points: Array
    test: csr_matrix
    areas: Array
    fresh_slope: Array
    averaging: csr_matrix

    def mean_slope(self, nodes: IntArray, depth_mm: Array) -> Array:
        """Mean slope (k, 2) of the surface worn by depth (n_a, n_t) about chosen nodes, in world axes."""
        gradient = self.body.patch.gradient(depth_mm)
        local = self.fresh_slope[nodes] - self.averaging[nodes] @ gradient
        return np.asarray(self.body.facing * local @ self.body.world_to_patch + [self.body.incline, 0.0])


@dataclass(frozen=True)
class Pairing:
    """Both surfaces as they face each other at one relative position, for k chosen primary nodes.

    nodes: (k,) primary nodes.  areas: (k,), mm².
    gap: (k,) vertical gap of the undeformed worn surfaces at zero approach, mm, the secondary averaged.
    gap_rate: (k,) change of the gap per motion of the upper body along x.
    frames: (k, 3, 3), rows are the normal (from lower to upper) and two tangents, in world axes; the first tangent
    is the motion's direction x projected on the tangent plane.
    primary, secondary: (k, n) sparse transfer operators: force per area -> nodal forces (transposed), nodal
    displacements -> area-weighted mean displacements.
    inside: (k,) whether the secondary patch faces the whole support of the node.
    """

    nodes: IntArray
    areas: Array
    gap: Array
    gap_rate: Array
    frames: Array
    primary: csr_matrix
    secondary: csr_matrix
    inside: BoolArray


def primary_surface(body: PlacedBody) -> PrimarySurface:
    """Set up the quadrature of a body's patch."""
    local, area = body.patch.quadrature(_GAUSS_POINTS)
    points = local @ body.world_to_patch
    sample = body.sample(points, np.zeros(body.patch.shape))
    shape = _interpolation(sample.nodes, sample.weights, body.patch.size)
    test = shape.multiply(area[:, None]).T.tocsr()
    areas = np.asarray(test.sum(axis=1)).ravel()
    averaging = (test @ shape).multiply(1.0 / areas[:, None]).tocsr()
    fresh_slope = (test @ body.patch.profile.slope(local)) / areas[:, None]
    return PrimarySurface(body, points, test, areas, fresh_slope, averaging)


def vertical_gap(
    surface: PrimarySurface, secondary: PlacedBody, offset_mm: Array, primary_depth: Array, secondary_depth: Array
) -> Array:
    """Gap along z at the primary's nodes at zero approach, shape (n,); infinite beside the secondary's patch."""
    positions = surface.body.node_positions
    other, inside = secondary.heights(positions - offset_mm, secondary_depth)
    # Upper height minus lower height, whichever of the two is the primary.
    gap = surface.body.facing * (other - surface.body.node_heights(primary_depth))
    return np.where(inside, gap, np.inf)


def pair(
    surface: PrimarySurface,
    secondary: PlacedBody,
    nodes: IntArray,
    offset_mm: Array,
    primary_depth: Array,
    secondary_depth: Array,
    upper_tilt_rad: float = 0.0,
) -> Pairing:
    """Couple chosen primary nodes (k,) with the secondary body, whose origin lies `offset_mm` (2,) from the primary's.

    primary_depth, secondary_depth: (n_a, n_t) worn depths of the patches, mm.  upper_tilt_rad: rotation of the upper
    body about y, which turns the normals; the gap at zero approach is that of the upright body.
    """
    test, points = _compressed(surface.test[nodes])
    other = secondary.sample(surface.points[points] - offset_mm, secondary_depth)
    areas = surface.areas[nodes]
    at_nodes = surface.body.node_heights(primary_depth)[nodes]
    gap = surface.body.facing * (test @ other.height / areas - at_nodes)
    tilted = np.array([upper_tilt_rad, 0.0])
    own_tilt, other_tilt = (tilted, 0.0) if surface.body.facing < 0 else (0.0, tilted)
    other_slope = (test @ other.slope) / areas[:, None] + other_tilt
    slope = 0.5 * (surface.mean_slope(nodes, primary_depth) + own_tilt + other_slope)
    interpolation = _interpolation(other.nodes, other.weights, secondary.patch.size)
    outside = test @ (~other.inside).astype(float) > 0.0
    return Pairing(
        nodes=nodes,
        areas=areas,
        gap=gap,
        gap_rate=-other_slope[:, 0],
        frames=_frames(slope),
        primary=csr_matrix((areas, nodes, np.arange(len(nodes) + 1)), shape=(len(nodes), surface.body.patch.size)),
        secondary=(test @ interpolation).tocsr(),
        inside=~outside,
    )


def _compressed(matrix: csr_matrix) -> tuple[csr_matrix, IntArray]:
    """The matrix without its empty columns, and which columns are left."""
    used = np.zeros(matrix.shape[1], dtype=bool)
    used[matrix.indices] = True
    kept = np.flatnonzero(used)
    place = np.cumsum(used) - 1
    return csr_matrix((matrix.data, place[matrix.indices], matrix.indptr), shape=(matrix.shape[0], len(kept))), kept


def _interpolation(nodes: IntArray, weights: Array, size: int) -> csr_matrix:
    count, corners = nodes.shape
    pointers = np.arange(0, corners * count + 1, corners)
    return csr_matrix((weights.ravel(), nodes.ravel(), pointers), shape=(count, size))


def _frames(slope: Array) -> Array:
    normal = np.column_stack([-slope, np.ones(len(slope))])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first = np.zeros_like(normal)
    first[:, 0] = 1.0
    first -= normal[:, :1] * normal
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([normal, first, np.cross(normal, first)], axis=1)
