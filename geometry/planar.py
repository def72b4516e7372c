"""Structured, graded quadrilateral meshes of planar bodies: pads with a cylindrical or rounded face, specimens."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.errors import GeometryError
from geometry.grading import EdgeGradedAxis, GradedAxis, graded_layers
from geometry.patch import ContactPatch
from geometry.profiles import Profile
from geometry.quadmesh import QuadMesh

Array = NDArray[np.float64]

_LEAST_QUALITY = 0.2


@dataclass(frozen=True)
class PlanarGeometry:
    """A body of unit thickness below a contact surface, held at its back.

    profile: the contact surface.  half_width_mm, height_mm: of the body around and below the point of first contact.
    along: mesh lines of the contact patch.  far_mm: largest element far away.  growth: of elements from one to the
    next on the way there.
    """

    profile: Profile
    half_width_mm: float
    height_mm: float
    along: GradedAxis | EdgeGradedAxis
    far_mm: float = 1.0
    growth: float = 1.3

    def __post_init__(self) -> None:
        if not self.half_width_mm > self.along.half_extent_mm:
            raise GeometryError(
                f"a contact patch of half-extent {self.along.half_extent_mm} mm does not fit on a body of half-width "
                f"{self.half_width_mm} mm"
            )
        if not self.height_mm > self.along.fine_mm:
            raise GeometryError(
                f"a body {self.height_mm} mm high holds no element of {self.along.fine_mm} mm; give a finer mesh"
            )
        if not (self.far_mm > 0.0 and self.growth > 1.0):
            raise GeometryError(
                f"far elements must be larger than nothing and grow, but are {self.far_mm} mm and grow by {self.growth}"
            )
        self.profile.require_within(self.half_width_mm, 0.0)
        rim = self.profile.height(np.array([[self.half_width_mm, 0.0]]))[0]
        if not self.height_mm > -1.2 * rim:
            raise GeometryError(
                f"a body {self.height_mm} mm high ends beside its own contact surface, which falls by {-rim:.3f} mm; "
                "make it higher or narrower"
            )


@dataclass(frozen=True)
class PlanarMesh:
    """A meshed planar body in its own frame: z outwards at the point of first contact, which is the origin."""

    geometry: PlanarGeometry
    mesh: QuadMesh
    patch: ContactPatch
    quality: float


def build_planar(geometry: PlanarGeometry) -> PlanarMesh:
    """Mesh a planar body; its surfaces are 'contact', 'grip' (the back) and 'sides'.

    GeometryError when an element is too distorted.
    """
    x = _lines_to_sides(geometry)
    fine = geometry.along.fine_mm
    layers = graded_layers(fine, geometry.growth, geometry.far_mm, geometry.height_mm)
    depth = np.concatenate([np.cumsum(layers)[::-1], [0.0]]) / layers.sum()
    across = np.zeros_like(x)
    face = geometry.profile.height(np.column_stack([x, across]))
    # The rows follow the face and flatten out towards the back.
    z = face[:, None] * (1.0 - depth) - geometry.height_mm * depth
    n = np.arange(z.size).reshape(z.shape)
    points = np.column_stack([np.repeat(x, len(depth)), z.ravel()])
    cells = np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], axis=-1).reshape(-1, 4)
    inside = np.flatnonzero(np.abs(x) <= geometry.along.half_extent_mm * (1.0 + 1e-12))
    top = n[inside, -1]
    surfaces = {
        "contact": np.column_stack([top[:-1], top[1:]]),
        "grip": np.column_stack([n[:-1, 0], n[1:, 0]]),
        "sides": np.vstack([np.column_stack([side[:-1], side[1:]]) for side in (n[0], n[-1])]),
    }
    mesh = QuadMesh(points, cells, surfaces)
    patch = ContactPatch(x[inside], np.zeros(1), top[:, None], geometry.profile)
    return PlanarMesh(geometry, mesh, patch, mesh.require_quality(_LEAST_QUALITY))


def _lines_to_sides(geometry: PlanarGeometry) -> Array:
    """Mesh lines over the body's width: the patch's lines, then growing ones; exactly antisymmetric."""
    half = geometry.along.half_lines()
    last = half[-1] - half[-2]
    rest = geometry.half_width_mm - half[-1]
    first = min(last * geometry.growth, rest)
    layers = graded_layers(first, geometry.growth, max(geometry.far_mm, first), rest)
    outer = half[-1] + np.cumsum(layers)
    outer[-1] = geometry.half_width_mm
    half = np.concatenate([half, outer])
    return np.concatenate([-half[:0:-1], half])
