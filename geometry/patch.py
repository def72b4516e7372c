"""The contact patch of a body: a rectilinear grid of surface nodes over the plane of contact, and the unworn height
there.

n_a grid lines run along the body's axis, n_t across. A planar body's patch has a single line across, which stands for a
strip of 1 mm thickness: its fields have the shape (n_a, 1), areas are lengths times 1 mm, forces are per mm. Other
modules need not distinguish the two.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from geometry.profiles import Profile


@dataclass(frozen=True)
class ContactPatch:
    """Surface nodes that may come into contact, on a rectilinear grid in the plane that touches the unworn surface.

    Facets of the mesh project onto the rectangles of this grid, so displacements on the surface are bilinear on them.
    The body's own frame has its origin at the point of first contact and its z axis along the outward normal there.
    """

    axial_mm: Array  #: (n_a,) increasing grid lines.
    transverse_mm: Array  #: (n_t,) increasing grid lines; a planar body has one.
    nodes: IntArray  #: (n_a, n_t) indices into the body's mesh.
    profile: Profile  #: The unworn surface.
    #: (n_a, n_t) depth along z by which nodes of the mesh have been moved into a worn surface; None: not moved.
    repositioned_depth_mm: Array | None = None

    def __post_init__(self) -> None:
        self.profile.require_within(*(float(np.abs(lines).max()) for lines in self._axes))

    @property
    def _axes(self) -> tuple[Array, Array]:
        return self.axial_mm, self.transverse_mm

    @property
    def shape(self) -> tuple[int, int]:
        return len(self.axial_mm), len(self.transverse_mm)

    @property
    def size(self) -> int:
        return len(self.axial_mm) * len(self.transverse_mm)

    @property
    def smallest_element(self) -> float:
        return float(min(np.diff(lines).min() for lines in self._axes if len(lines) > 1))

    def facets(self) -> IntArray:
        """Corners (k, 4) of the patch's cells, as indices into the body's mesh, ordered so that the cells face
        outwards; not for planar patches.
        """
        n = self.nodes
        return np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], axis=-1).reshape(-1, 4)

    def grid(self) -> Array:
        """Plane coordinates (along, across) in mm of all nodes, (size, 2), in the order of `nodes.ravel()`."""
        a, t = np.meshgrid(self.axial_mm, self.transverse_mm, indexing="ij")
        return np.column_stack([a.ravel(), t.ravel()])

    def height(self, plane_mm: Array) -> Array:
        """Heights (n,) in mm of the surface at plane points (n, 2) in mm: the profile's, less the depth by which nodes
        have been moved.
        """
        fresh, depth = self.profile.height(plane_mm), self.repositioned_depth_mm
        if depth is None:
            return fresh
        nodes, weights, _ = self.locate(plane_mm)
        return np.asarray(fresh - np.einsum("ij,ij->i", weights, depth.ravel()[nodes]))

    def node_areas(self) -> Array:
        """(size,) area in mm² of the plane that belongs to each node: the integral of its bilinear shape function."""
        return np.outer(_line_weights(self.axial_mm), _line_weights(self.transverse_mm)).ravel()

    def edge_nodes(self) -> BoolArray:
        """(size,) True for nodes on the patch's outer edge."""
        edge = np.zeros(self.shape, dtype=bool)
        edge[[0, -1]] = True
        if len(self.transverse_mm) > 1:
            edge[:, [0, -1]] = True
        return edge.ravel()

    def locate(self, plane_mm: Array) -> tuple[IntArray, Array, BoolArray]:
        """Nodes and weights that interpolate a nodal field bilinearly at plane points (n, 2) in mm.

        Returns node indices in `grid`'s order and weights, both (n, 4), or (n, 2) on a planar patch, and whether each
        point lies on the patch, (n,). The weights of points outside it are zero.
        """
        return located(self.axial_mm, self.transverse_mm, plane_mm)

    def gradient(self, field: Array) -> Array:
        """Gradient (size, 2) along and across the patch at its nodes, of a field (n_a, n_t), by central differences."""
        if len(self.transverse_mm) == 1:
            along = np.gradient(field[:, 0], self.axial_mm)
            return np.column_stack([along, np.zeros_like(along)])
        along, across = np.gradient(field, *self._axes)
        return np.column_stack([along.ravel(), across.ravel()])


def located(axial: Array, transverse: Array, places: Array) -> tuple[IntArray, Array, BoolArray]:
    """Nodes and weights that interpolate a field bilinearly at places (n, 2) on a grid of increasing lines (n_a,) and
    (n_t,); returns as `ContactPatch.locate`.
    """
    i, u = _cell(axial, places[:, 0])
    if len(transverse) == 1:
        nodes, weights = np.column_stack([i, i + 1]), np.column_stack([1 - u, u])
        inside = (u >= -1e-9) & (u <= 1 + 1e-9)
    else:
        j, v = _cell(transverse, places[:, 1])
        n_t = len(transverse)
        corner = i * n_t + j
        nodes = np.column_stack([corner, corner + 1, corner + n_t, corner + n_t + 1])
        weights = np.column_stack([(1 - u) * (1 - v), (1 - u) * v, u * (1 - v), u * v])
        inside = (u >= -1e-9) & (u <= 1 + 1e-9) & (v >= -1e-9) & (v <= 1 + 1e-9)
    weights[~inside] = 0.0
    return nodes, weights, inside


def _line_weights(lines: Array) -> Array:
    if len(lines) == 1:
        return np.ones(1)
    spacing = np.diff(lines)
    weights = np.zeros(len(lines))
    weights[:-1] += spacing / 2.0
    weights[1:] += spacing / 2.0
    return weights


def _cell(lines: Array, values: Array) -> tuple[IntArray, Array]:
    cell = np.clip(np.searchsorted(lines, values, side="right") - 1, 0, len(lines) - 2)
    return cell, (values - lines[cell]) / (lines[cell + 1] - lines[cell])


def sides_of(lines: Array, at: Array) -> list[tuple[IntArray, Array]]:
    """The lines on either side of positions (n,) and their weights; of positions beside all, the outermost."""
    if len(lines) == 1:
        return [(np.zeros(len(at), dtype=np.int64), np.ones(len(at)))]
    i = np.clip(np.searchsorted(lines, at, side="right") - 1, 0, len(lines) - 2)
    part = np.clip((at - lines[i]) / (lines[i + 1] - lines[i]), 0.0, 1.0)
    return [(i, 1.0 - part), (i + 1, part)]


def linear_weights(lines: Array, at: Array) -> Array:
    """Weights (n, l) of values on l increasing lines for linear interpolation at positions (n,), held beyond."""
    weights = np.zeros((len(at), len(lines)))
    for column, part in sides_of(lines, at):
        weights[np.arange(len(at)), column] += part
    return weights
