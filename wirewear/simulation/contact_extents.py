"""Where on each wire the contact will be: contact, scar and travel seen along the axes of the wires' patches."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, pi, sin

from wirewear.reference import PointContact, relative_curvatures


@dataclass(frozen=True)
class Ellipse:
    """A contact or scar centred on the crossing point; the angle is that of its major axis from the moving wire's."""

    major_mm: float
    minor_mm: float
    angle_rad: float

    def reach(self, axis_rad: float) -> float:
        """Largest distance from the centre along an axis at an angle to the moving wire's: half the bounding box."""
        c, s = cos(axis_rad - self.angle_rad), sin(axis_rad - self.angle_rad)
        return hypot(self.major_mm * c, self.minor_mm * s)

    def chord(self, axis_rad: float) -> float:
        """Half the chord through the centre along such an axis: the length over which pressure varies along it.

        A bilinear interpolant of spacing h along each axis errs by h² times the second derivative along that axis,
        which for the pressure and the gap is proportional to 1 / chord²; the mixed derivative costs nothing.
        """
        c, s = cos(axis_rad - self.angle_rad), sin(axis_rad - self.angle_rad)
        return 1.0 / hypot(c / self.major_mm, s / self.minor_mm)

    def enlarged(self, factor: float) -> Ellipse:
        """An ellipse of the same shape."""
        return Ellipse(self.major_mm * factor, self.minor_mm * factor, self.angle_rad)


@dataclass(frozen=True)
class WireAxis:
    """One axis of a wire's patch.

    angle_rad: from the moving wire's axis.  travel_mm: how far the contact's centre moves along it to each side.
    """

    angle_rad: float
    travel_mm: float


@dataclass(frozen=True)
class PatchAxes:
    """Both axes of a wire's patch."""

    axial: WireAxis
    transverse: WireAxis


def fresh_ellipse(hertz: PointContact) -> Ellipse:
    """Contact of the unworn wires."""
    return Ellipse(hertz.major_semi_axis_mm, hertz.minor_semi_axis_mm, hertz.major_angle_rad)


def scar_ellipse(
    volume_mm3: float, first_radius_mm: float, second_radius_mm: float, crossing_angle_deg: float
) -> Ellipse:
    """Outline of the scar of a worn volume (both wires together): the gap Ax² + By² cut off by a plane.

    The cap of depth d has the semi-axes sqrt(d/A), sqrt(d/B) and the volume pi d² / (2 sqrt(AB)); with wires of equal
    radius R crossed at right angles the scar's radius is (4 R V / pi)^(1/4).
    """
    small, large, angle = relative_curvatures(first_radius_mm, second_radius_mm, crossing_angle_deg)
    depth = (2.0 * volume_mm3 * (small * large) ** 0.5 / pi) ** 0.5
    return Ellipse((depth / small) ** 0.5, (depth / large) ** 0.5, angle)


def patch_axes(stroke_mm: float, direction_rad: float, crossing_rad: float) -> tuple[PatchAxes, PatchAxes]:
    """Axes of the patches of the moving and the fixed wire, with the contact's travel along them.

    stroke_mm: amplitude of the moving wire.  direction_rad: of its motion, crossing_rad: of the fixed wire's axis, both
    from the moving wire's axis. Two cylinders touch where their crowns cross, seen from above; when the moving wire is
    displaced by d, that point moves along each wire's crown by the component of d along that crown, d being resolved
    along both crowns. So a wire that moves along itself moves the contact on itself only, and no crossing of crowns
    moves the contact across a wire.
    """
    on_moving = abs(stroke_mm * sin(crossing_rad - direction_rad) / sin(crossing_rad))
    on_fixed = abs(stroke_mm * sin(direction_rad) / sin(crossing_rad))
    return (
        PatchAxes(WireAxis(0.0, on_moving), WireAxis(0.5 * pi, 0.0)),
        PatchAxes(WireAxis(crossing_rad, on_fixed), WireAxis(crossing_rad + 0.5 * pi, 0.0)),
    )
