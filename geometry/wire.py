"""A wire or a tube: round across, straight along, gripped about its back or at its ends."""

from dataclasses import dataclass, field
from math import pi

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from geometry.body import BodyGeometry
from geometry.errors import GeometryError
from geometry.grading import GradedAxis, Layering
from geometry.profiles import Cylinder
from geometry.sections import wire_section


@dataclass(frozen=True)
class WireGeometry(BodyGeometry):
    """What a wire's mesh is built from; lengths in mm.

    axial, transverse: gradings of the contact patch along and across the wire.
    coarse_mm: largest element far from the contact.
    layering: of the elements under the patch.
    grip_half_angle_rad: half of the sector of the lateral surface, measured from the back, that the holder grips.
    gripped_at_ends: whether the holder grips both ends in its place.
    bore_mm: a tube's inner diameter.
    """

    diameter_mm: float
    length_mm: float
    axial: GradedAxis
    transverse: GradedAxis
    coarse_mm: float
    grip_half_angle_rad: float = pi / 4
    grip_half_length_mm: float | None = None
    grip_stiffness_N_per_mm3: float | None = None
    layering: Layering = field(default_factory=Layering)
    gripped_at_ends: bool = False
    bore_mm: float = 0.0

    def __post_init__(self) -> None:
        if not self.diameter_mm > 0.0:
            raise GeometryError(f"a wire's diameter must be positive, but is {self.diameter_mm} mm")
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
        if self.grip_half_length_mm is not None and not self.grip_half_length_mm > 0.0:
            raise GeometryError(f"the grip's half-length must be positive, but is {self.grip_half_length_mm} mm")
        if self.grip_stiffness_N_per_mm3 is not None and not self.grip_stiffness_N_per_mm3 > 0.0:
            raise GeometryError(f"the grip's stiffness must be positive, but is {self.grip_stiffness_N_per_mm3} N/mm³")
        if not 0.1 <= self.grip_half_angle_rad <= 2.0:
            raise GeometryError(f"the grip's half-angle must lie in 0.1 ... 2 rad, but is {self.grip_half_angle_rad}")

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
        """Half a circle, or half a ring."""
        lines, bore = self.transverse.half_lines(), 0.5 * self.bore_mm
        return wire_section(self.radius_mm, lines, self.coarse_mm, self.layering, self.finest_mm, bore)

    def gripped(self, centres_mm: Array) -> BoolArray:
        """About the back, all along it or as far as the grip goes and not at its ends; or at these alone."""
        x, y, z = centres_mm.T
        from_back = np.abs(np.arctan2(y, -(z + self.radius_mm)))
        reach = self.half_length_mm * (1.0 - 1e-9)
        if self.gripped_at_ends:
            return np.asarray(np.abs(x) > reach)
        outside = np.hypot(y, z + self.radius_mm) > 0.5 * (self.radius_mm + 0.5 * self.bore_mm)
        if self.grip_half_length_mm is not None:
            reach = min(reach, self.grip_half_length_mm)
        return np.asarray(outside & (from_back <= self.grip_half_angle_rad) & (np.abs(x) <= reach))
