"""Shapes of bodies: wires and tubes, blocks with a curved face, and planar pads and specimens with their meshes.

A planar body is a slice of 1 mm thickness in the plane (x, z), for line contacts. The contact is at the origin, the
patch is the part of the surface that may touch, the back is the side opposite to it, the grip what the holder holds.
"""

from dataclasses import dataclass, field, replace
from math import pi

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from geometry.body import BodyGeometry
from geometry.errors import GeometryError
from geometry.grading import EdgeGradedAxis, GradedAxis, Layering, RimGradedAxis, graded_layers
from geometry.mesh import QuadMesh
from geometry.patch import ContactPatch
from geometry.profiles import Barrel, Cylinder, Profile, Turned
from geometry.ring import RingGeometry
from geometry.sections import block_section, wire_section

_LEAST_QUALITY = 0.2


@dataclass(frozen=True)
class WireGeometry(BodyGeometry):
    """Dimensions and mesh sizes of a wire or, with a bore, a tube; see `BodyGeometry`. Raises GeometryError for a patch
    too large for it.
    """

    diameter_mm: float
    length_mm: float
    axial: GradedAxis | RimGradedAxis
    transverse: GradedAxis | RimGradedAxis
    coarse_mm: float
    #: Largest angle from the back, either way round, at which the lateral surface is gripped.
    grip_half_angle_rad: float = pi / 4
    grip_half_length_mm: float | None = None  #: Largest distance from the middle at which it is; None: all along.
    grip_stiffness_N_per_mm3: float | None = None
    layering: Layering = field(default_factory=Layering)
    gripped_at_ends: bool = False  #: True if the holder grips both end faces instead.
    bore_mm: float = 0.0  #: A tube's inner diameter; 0: a wire.

    def __post_init__(self) -> None:
        if not 0.0 <= self.bore_mm < self.diameter_mm:
            raise GeometryError(
                f"a tube's bore must be narrower than its diameter of {self.diameter_mm} mm, but is {self.bore_mm} mm"
            )
        if self.transverse.half_extent_mm > 0.42 * self.diameter_mm:
            raise GeometryError(
                f"the contact patch reaches {self.transverse.half_extent_mm:.4g} mm to each side of a wire of diameter "
                f"{self.diameter_mm} mm; at most 0.42 diameters can be meshed"
            )
        if self.axial.half_extent_mm > 0.45 * self.length_mm:
            raise GeometryError(
                f"the contact patch reaches {self.axial.half_extent_mm:.4g} mm to each side along a wire of length "
                f"{self.length_mm} mm; it must leave a tenth of the length free: give a longer wire"
            )

    @property
    def radius_mm(self) -> float:
        return self.diameter_mm / 2.0

    @property
    def profile(self) -> Cylinder:
        return Cylinder(self.radius_mm)

    @property
    def round_mm(self) -> float:
        return self.radius_mm

    @property
    def half_length_mm(self) -> float:
        return self.length_mm / 2.0

    @property
    def least_extent_mm(self) -> float:
        return min(0.5 * (self.diameter_mm - self.bore_mm) if self.bore_mm else self.diameter_mm, self.length_mm)

    def section(self) -> tuple[Array, IntArray]:
        lines, bore = self.transverse.half_lines(), 0.5 * self.bore_mm
        return wire_section(self.radius_mm, lines, self.coarse_mm, self.layering, self.finest_mm, bore)

    def gripped(self, centres_mm: Array) -> BoolArray:
        x, y, z = centres_mm.T
        from_back = np.abs(np.arctan2(y, -(z + self.radius_mm)))
        reach = self.half_length_mm * (1.0 - 1e-9)
        if self.gripped_at_ends:
            return np.asarray(np.abs(x) > reach)
        outside = np.hypot(y, z + self.radius_mm) > 0.5 * (self.radius_mm + 0.5 * self.bore_mm)
        if self.grip_half_length_mm is not None:
            reach = min(reach, self.grip_half_length_mm)
        return np.asarray(outside & (from_back <= self.grip_half_angle_rad) & (np.abs(x) <= reach))


@dataclass(frozen=True)
class BlockGeometry(BodyGeometry):
    """A block with a barrel-shaped face, held at its back and its four sides. Raises GeometryError for a patch too
    large for it.
    """

    curvature_along_per_mm: float  #: One over the face's radius along x, 0 where straight.
    curvature_across_per_mm: float  #: One over that across, along y.
    half_width_along_mm: float  #: How far the block reaches to each side along x.
    half_width_across_mm: float  #: How far along y.
    height_mm: float  #: From the contact to the back.
    axial: GradedAxis | RimGradedAxis
    transverse: GradedAxis | RimGradedAxis
    coarse_mm: float
    grip_stiffness_N_per_mm3: float | None = None
    layering: Layering = field(default_factory=Layering)
    #: The face of a pad of revolution, which lies below the barrel that is meshed; None: the barrel.
    face: Turned | None = None

    def __post_init__(self) -> None:
        widths = self.half_width_along_mm, self.half_width_across_mm
        for axis, width in zip((self.axial, self.transverse), widths, strict=True):
            if axis.half_extent_mm > 0.9 * width:
                raise GeometryError(
                    f"the contact patch reaches {axis.half_extent_mm:.4g} mm to each side of a block of half-width "
                    f"{width} mm; it must leave a tenth of it free: give a wider block"
                )
        self.meshed_profile.require_within(*widths)

    @property
    def profile(self) -> Profile:
        return self.face or self.meshed_profile

    @property
    def meshed_profile(self) -> Profile:
        return Barrel(self.curvature_along_per_mm, self.curvature_across_per_mm)

    @property
    def half_length_mm(self) -> float:
        return self.half_width_along_mm

    @property
    def least_extent_mm(self) -> float:
        return min(2.0 * self.half_width_along_mm, 2.0 * self.half_width_across_mm, self.height_mm)

    def section(self) -> tuple[Array, IntArray]:
        lines = self.transverse.half_lines()
        return block_section(
            self.half_width_across_mm, self.height_mm, lines, self.coarse_mm, self.layering, self.finest_mm
        )

    def bent(self, points_mm: Array) -> Array:
        """Points (n, 3) in mm moved down so that the top follows the meshed face; less so below, none at the back."""
        share = np.maximum(1.0 + points_mm[:, 2] / self.height_mm, 0.0)
        bent = points_mm.copy()
        bent[:, 2] += share * self.meshed_profile.height(points_mm[:, :2])
        return bent

    def gripped(self, centres_mm: Array) -> BoolArray:
        x, y, z = centres_mm.T
        aside = np.maximum(np.abs(x) / self.half_width_along_mm, np.abs(y) / self.half_width_across_mm)
        return np.asarray((aside > 1.0 - 1e-9) | (z < -self.height_mm * (1.0 - 1e-9)))


@dataclass(frozen=True)
class PlanarGeometry:
    """Dimensions and mesh sizes of a planar body below a contact surface, held at its back. Raises GeometryError if it
    is too small for its patch, or a face.

    With an axis it is a ring about it: a shaft, or a hub around one, held along its axis at one end.
    """

    profile: Profile  #: The contact surface.
    half_width_mm: float  #: How far the body reaches to each side of the point of first contact.
    height_mm: float  #: Distance from the point of first contact to the back.
    along: GradedAxis | EdgeGradedAxis  #: Mesh lines of the contact patch.
    far_mm: float = 1.0  #: Largest element far away.
    growth: float = 1.3  #: Ratio of the sizes of neighbouring elements away from the patch.
    grip_half_width_mm: float | None = None  #: Half-width of the held part of the back; None: all of it.
    grip_stiffness_N_per_mm3: float | None = None  #: Stiffness of the grip per area; None: the grip is rigid.
    axis_mm: float | None = None  #: Height of the ring's axis: below 0 for a shaft, above for a hub.
    rise: float = 0.0  #: Of the ring's contact surface along x beyond its profile, mm per mm: a taper.
    held_end: int = 1  #: The end of a ring that is held: 1 at the largest x, -1 at the smallest.

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
        self.profile.require_within(self.half_width_mm, 0.0)
        rim = self.profile.height(np.array([[self.half_width_mm, 0.0]]))[0]
        if not self.height_mm > -1.2 * rim:
            raise GeometryError(
                f"a body {self.height_mm} mm high ends beside its own contact surface, which falls by {-rim:.3f} mm; "
                "make it higher or narrower"
            )

    def layers(self) -> Array:
        """Thicknesses (n,) in mm of the rows of elements at x = 0, from the surface down."""
        return graded_layers(self.along.fine_mm, self.growth, self.far_mm, self.height_mm)

    def above_back(self, points_mm: Array) -> Array:
        """Share (n,) of the way from the back to the contact surface above at points (n, 2) of the body."""
        face = self.profile.height(np.column_stack([points_mm[:, 0], np.zeros(len(points_mm))]))
        return np.asarray((points_mm[:, 1] + self.height_mm) / (face + self.height_mm))

    def meshed(self) -> tuple[QuadMesh, ContactPatch]:
        """The mesh, with the surfaces 'contact', 'grip' and 'sides', and its patch."""
        x = _lines_to_sides(self)
        layers = self.layers()
        depth = np.concatenate([np.cumsum(layers)[::-1], [0.0]]) / layers.sum()
        face = self.profile.height(np.column_stack([x, np.zeros_like(x)]))
        # The rows follow the face and flatten out towards the back.
        z = (face + self.rise * x)[:, None] * (1.0 - depth) - self.height_mm * depth
        n = np.arange(z.size).reshape(z.shape)
        points = np.column_stack([np.repeat(x, len(depth)), z.ravel()])
        cells = np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], axis=-1).reshape(-1, 4)
        inside = np.flatnonzero(np.abs(x) <= self.along.half_extent_mm * (1.0 + 1e-12))
        top = n[inside, -1]
        ends = [np.column_stack([side[:-1], side[1:]]) for side in (n[0], n[-1])]
        surfaces = {
            "contact": np.column_stack([top[:-1], top[1:]]),
            "grip": ends[self.held_end > 0]
            if self.axis_mm is not None
            else _held(np.column_stack([n[:-1, 0], n[1:, 0]]), points, self.grip_half_width_mm),
            "sides": np.vstack(ends),
        }
        patch = ContactPatch(x[inside], np.zeros(1), top[:, None], self.profile)
        return QuadMesh(points, cells, surfaces, self.axis_mm), patch


@dataclass(frozen=True)
class PlanarMesh:
    """The mesh of a planar body in the body's own frame: the origin is the point of first contact, +z outwards.

    quality: smallest scaled Jacobian of its elements, 1 at best.
    """

    geometry: PlanarGeometry | RingGeometry
    mesh: QuadMesh
    patch: ContactPatch
    quality: float

    @property
    def bedding(self) -> Array | None:
        """(n,) stiffness in N/mm per mm of thickness by which an elastic grip holds each node; None if it is rigid."""
        stiffness = self.geometry.grip_stiffness_N_per_mm3
        return None if stiffness is None else stiffness * self.mesh.surface_lengths("grip")

    def worn(self, depth_mm: Array) -> "PlanarMesh":
        """A copy of this mesh, with the nodes of its patch at a depth `depth_mm` (n_a,) along z below where they are.

        Nodes below move with the surface node above them, by a share that falls linearly to 0 at the back. Raises
        GeometryError when an element becomes too distorted.
        """
        patch, points = self.patch, self.mesh.points.copy()
        along = np.interp(points[:, 0], patch.axial_mm, depth_mm, 0.0, 0.0)
        points[:, 1] -= along * self.geometry.above_back(points)
        mesh = replace(self.mesh, points=points)
        moved = replace(patch, repositioned_depth_mm=depth_mm[:, None])
        return PlanarMesh(self.geometry, mesh, moved, mesh.require_quality(_LEAST_QUALITY))


def build_planar(geometry: PlanarGeometry | RingGeometry) -> PlanarMesh:
    """Build the mesh of a planar body, with the named surfaces 'contact', 'grip' (what is held of its back) and, of a
    block, 'sides'.

    Raises GeometryError when an element is too distorted.
    """
    mesh, patch = geometry.meshed()
    return PlanarMesh(geometry, mesh, patch, mesh.require_quality(_LEAST_QUALITY))


def _held(back: IntArray, points: Array, half_width_mm: float | None) -> IntArray:
    """The sides (k, 2) of the back whose middles lie within `half_width_mm` of x = 0; all of them without a
    half-width.
    """
    if half_width_mm is None:
        return back
    return np.asarray(back[np.abs(points[back, 0].mean(axis=1)) <= half_width_mm])


def _lines_to_sides(geometry: PlanarGeometry) -> Array:
    """Mesh lines in mm over the body's whole width: the patch's lines, then ever wider spacings; exactly
    antisymmetric.
    """
    half = geometry.along.half_lines()
    last = half[-1] - half[-2]
    rest = geometry.half_width_mm - half[-1]
    first = min(last * geometry.growth, rest)
    layers = graded_layers(first, geometry.growth, max(geometry.far_mm, first), rest)
    outer = half[-1] + np.cumsum(layers)
    outer[-1] = geometry.half_width_mm
    half = np.concatenate([half, outer])
    return np.concatenate([-half[:0:-1], half])
