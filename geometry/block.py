"""A block whose face may be curved along and across: a segment of a ball or a barrel, a cylinder's crown, a flat."""

from dataclasses import dataclass, field

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from geometry.body import BodyGeometry
from geometry.errors import GeometryError
from geometry.grading import GradedAxis, Layering
from geometry.profiles import Barrel, Profile, Turned
from geometry.sections import block_section


@dataclass(frozen=True)
class BlockGeometry(BodyGeometry):
    """A block with a barrel's face, held at its back and its sides; lengths in mm.

    curvature_along_per_mm, curvature_across_per_mm: one over the face's radii, 0 where it is straight.
    half_width_along_mm, half_width_across_mm: to each side of the contact.  height_mm: from the contact to the back.
    face: that of a pad, which lies below the mesh's.
    """

    curvature_along_per_mm: float
    curvature_across_per_mm: float
    half_width_along_mm: float
    half_width_across_mm: float
    height_mm: float
    axial: GradedAxis
    transverse: GradedAxis
    coarse_mm: float
    grip_stiffness_N_per_mm3: float | None = None
    layering: Layering = field(default_factory=Layering)
    face: Turned | None = None

    def __post_init__(self) -> None:
        widths = self.half_width_along_mm, self.half_width_across_mm
        if not (min(widths) > 0.0 and self.height_mm > 0.0):
            raise GeometryError(
                f"a block's half-widths and height must be positive, but are {widths[0]}, {widths[1]} and "
                f"{self.height_mm} mm"
            )
        for axis, width in zip((self.axial, self.transverse), widths, strict=True):
            if axis.half_extent_mm > 0.9 * width:
                raise GeometryError(
                    f"the contact patch reaches {axis.half_extent_mm:.4g} mm to each side of a block of half-width "
                    f"{width} mm; it must leave a tenth of it free: give a wider block"
                )
        self.meshed_profile.require_within(*widths)

    @property
    def profile(self) -> Profile:
        """Curved along and across, or the pad's."""
        return self.face or self.meshed_profile

    @property
    def meshed_profile(self) -> Barrel:
        return Barrel(self.curvature_along_per_mm, self.curvature_across_per_mm)

    @property
    def half_length_mm(self) -> float:
        return self.half_width_along_mm

    @property
    def least_extent_mm(self) -> float:
        return min(2.0 * self.half_width_along_mm, 2.0 * self.half_width_across_mm, self.height_mm)

    def section(self) -> tuple[Array, IntArray]:
        """Half a rectangle."""
        lines = self.transverse.half_lines()
        return block_section(
            self.half_width_across_mm, self.height_mm, lines, self.coarse_mm, self.layering, self.finest_mm
        )

    def bent(self, points_mm: Array) -> Array:
        """The face lowered onto its profile, what is below in proportion, the back left where it is."""
        share = np.maximum(1.0 + points_mm[:, 2] / self.height_mm, 0.0)
        bent = points_mm.copy()
        bent[:, 2] += share * self.meshed_profile.height(points_mm[:, :2])
        return bent

    def gripped(self, centres_mm: Array) -> BoolArray:
        """At its back and all around."""
        x, y, z = centres_mm.T
        aside = np.maximum(np.abs(x) / self.half_width_along_mm, np.abs(y) / self.half_width_across_mm)
        return np.asarray((aside > 1.0 - 1e-9) | (z < -self.height_mm * (1.0 - 1e-9)))
