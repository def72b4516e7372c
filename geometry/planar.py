"""Structured, graded quadrilateral meshes of planar bodies: pads with a cylindrical or rounded face, specimens."""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array, IntArray
from geometry.errors import GeometryError
from geometry.grading import EdgeGradedAxis, GradedAxis, graded_layers
from geometry.mesh import QuadMesh
from geometry.patch import ContactPatch
from geometry.profiles import Profile

_LEAST_QUALITY = 0.2


@dataclass(frozen=True)
class PlanarGeometry:
    """A body of unit thickness below a contact surface, held at its back.

    profile: the contact surface.  half_width_mm, height_mm: of the body around and below the point of first contact.
    along: mesh lines of the contact patch.  far_mm: largest element far away.  growth: of elements from one to the
    next on the way there.  grip_half_width_mm: of the part of the back that is held, about the middle; all without it.
    grip_stiffness_N_per_mm3: of an elastic grip per area; without it the grip is rigid.
    """

    profile: Profile
    half_width_mm: float
    height_mm: float
    along: GradedAxis | EdgeGradedAxis
    far_mm: float = 1.0
    growth: float = 1.3
    grip_half_width_mm: float | None = None
    grip_stiffness_N_per_mm3: float | None = None

    def __post_init__(self) -> None:
        if self.grip_half_width_mm is not None and not self.grip_half_width_mm > 0.0:
            raise GeometryError(f"the grip's half-width must be positive, but is {self.grip_half_width_mm} mm")
        if self.grip_stiffness_N_per_mm3 is not None and not self.grip_stiffness_N_per_mm3 > 0.0:
            raise GeometryError(f"the grip's stiffness must be positive, but is {self.grip_stiffness_N_per_mm3} N/mm³")
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

    def layers(self) -> Array:
        """Thicknesses (n,) of the rows of elements at the middle, in mm, from the surface down."""
        return graded_layers(self.along.fine_mm, self.growth, self.far_mm, self.height_mm)


@dataclass(frozen=True)
class PlanarMesh:
    """A meshed planar body in its own frame: z outwards at the point of first contact, which is the origin."""

    geometry: PlanarGeometry
    mesh: QuadMesh
    patch: ContactPatch
    quality: float

    @property
    def bedding(self) -> Array | None:
        """Stiffness (n,) in N/mm per mm by which an elastic grip holds each node, None where the grip is rigid."""
        stiffness = self.geometry.grip_stiffness_N_per_mm3
        return None if stiffness is None else stiffness * self.mesh.surface_lengths("grip")

    def worn(self, depth_mm: Array) -> "PlanarMesh":
        """This mesh with the nodes of its patch moved into a surface worn by a vertical depth (n,).

        Those beneath follow, each column as a whole, ever less towards the held back. GeometryError when the depth has
        another shape than the patch or is negative somewhere, or where an element becomes too distorted.
        """
        patch, points = self.patch, self.mesh.points.copy()
        if depth_mm.shape != (patch.size,):
            raise GeometryError(f"a depth of shape {depth_mm.shape} does not belong to a patch of {patch.size} nodes")
        if not np.all((depth_mm >= 0.0) & np.isfinite(depth_mm)):
            raise GeometryError(
                "the depth by which nodes are moved into a worn surface must be a number not below zero"
            )
        along = np.interp(points[:, 0], patch.axial_mm, depth_mm, 0.0, 0.0)
        face = self.geometry.profile.height(np.column_stack([points[:, 0], np.zeros(len(points))]))
        bottom = -self.geometry.height_mm
        points[:, 1] -= along * (points[:, 1] - bottom) / (face - bottom)
        mesh = QuadMesh(points, self.mesh.cells, self.mesh.surfaces)
        moved = replace(patch, repositioned_depth_mm=depth_mm[:, None])
        return PlanarMesh(self.geometry, mesh, moved, mesh.require_quality(_LEAST_QUALITY))


def build_planar(geometry: PlanarGeometry) -> PlanarMesh:
    """Mesh a planar body; its surfaces are 'contact', 'grip' (the back) and 'sides'.

    GeometryError when an element is too distorted.
    """
    x = _lines_to_sides(geometry)
    layers = geometry.layers()
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
        "grip": _held(np.column_stack([n[:-1, 0], n[1:, 0]]), points, geometry.grip_half_width_mm),
        "sides": np.vstack([np.column_stack([side[:-1], side[1:]]) for side in (n[0], n[-1])]),
    }
    mesh = QuadMesh(points, cells, surfaces)
    patch = ContactPatch(x[inside], np.zeros(1), top[:, None], geometry.profile)
    return PlanarMesh(geometry, mesh, patch, mesh.require_quality(_LEAST_QUALITY))


def _held(back: IntArray, points: Array, half_width_mm: float | None) -> IntArray:
    """The sides (k, 2) of the back whose middles are held."""
    if half_width_mm is None:
        return back
    return np.asarray(back[np.abs(points[back, 0].mean(axis=1)) <= half_width_mm])


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
