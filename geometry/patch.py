"""The contact patch of a body: a rectilinear grid of surface nodes over the plane, and the unworn height above it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.errors import GeometryError

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class ContactPatch:
    """Surface nodes that may come into contact, on a rectilinear grid in the plane that touches the fresh surface.

    axial_mm: (n_a,) and transverse_mm: (n_t,) increasing grid lines in the body's own frame, whose origin is the
    point of first contact and whose z axis is the outward normal there.
    nodes: (n_a, n_t) indices into the body's mesh.
    radius_mm: the cylinder's radius; its surface lies at height sqrt(R^2 - t^2) - R.
    Facets of the mesh project onto the rectangles of this grid, so the finite elements' trace is bilinear on them.
    """

    axial_mm: Array
    transverse_mm: Array
    nodes: IntArray
    radius_mm: float

    def __post_init__(self) -> None:
        if self.nodes.shape != (len(self.axial_mm), len(self.transverse_mm)):
            raise GeometryError(
                f"a patch of {len(self.axial_mm)} by {len(self.transverse_mm)} lines cannot hold nodes of shape "
                f"{self.nodes.shape}"
            )
        if np.any(np.diff(self.axial_mm) <= 0) or np.any(np.diff(self.transverse_mm) <= 0):
            raise GeometryError("the grid lines of a contact patch must increase")
        reach = float(np.abs(self.transverse_mm).max())
        if reach >= self.radius_mm:
            raise GeometryError(
                f"a contact patch {reach} mm to the side does not fit on a wire of radius {self.radius_mm} mm"
            )

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of nodes along and across the wire."""
        return len(self.axial_mm), len(self.transverse_mm)

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.axial_mm) * len(self.transverse_mm)

    def grid(self) -> Array:
        """Plane coordinates (axial, transverse) of all nodes, shape (size, 2), in the order of `nodes.ravel()`."""
        a, t = np.meshgrid(self.axial_mm, self.transverse_mm, indexing="ij")
        return np.column_stack([a.ravel(), t.ravel()])

    def height(self, plane_mm: Array) -> Array:
        """Unworn height at plane points (n, 2), shape (n,), in mm: zero at the origin, negative elsewhere."""
        t = plane_mm[:, 1]
        return -(t**2) / (self.radius_mm + np.sqrt(self.radius_mm**2 - t**2))

    def slope(self, plane_mm: Array) -> Array:
        """Gradient of the unworn height at plane points (n, 2), shape (n, 2)."""
        t = plane_mm[:, 1]
        return np.column_stack([np.zeros_like(t), -t / np.sqrt(self.radius_mm**2 - t**2)])

    def node_areas(self) -> Array:
        """Plane area that belongs to each node (integral of its bilinear shape function), shape (size,), mm²."""
        return np.outer(_line_weights(self.axial_mm), _line_weights(self.transverse_mm)).ravel()


def _line_weights(lines: Array) -> Array:
    spacing = np.diff(lines)
    weights = np.zeros(len(lines))
    weights[:-1] += spacing / 2.0
    weights[1:] += spacing / 2.0
    return weights
