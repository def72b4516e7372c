"""Wires and strands as helices: angles, curvatures, where neighbours touch, how layers cross (mm, rad).

A right lay has the hand 1, a left one -1. The extrados is the outer side of a bent strand; slip along a helix is
largest at the neutral axis, a quarter of a turn from there.
"""

from dataclasses import dataclass
from math import atan, atan2, cos, degrees, hypot, pi, sin
from typing import Literal

Hand = Literal[1, -1]  #: Right and left lay.


@dataclass(frozen=True)
class Helix:
    """A helical centre line of this radius about an axis, with one turn in each lay length."""

    radius_mm: float
    lay_length_mm: float
    hand: Hand

    @property
    def angle_rad(self) -> float:
        """Lay angle α to the axis: tan α = 2πr/L, with radius r and lay length L."""
        return atan(2.0 * pi * self.radius_mm / self.lay_length_mm)

    @property
    def signed_angle_rad(self) -> float:
        return self.hand * self.angle_rad

    @property
    def curvature_per_mm(self) -> float:
        """Curvature sin²α/r of the helix, with lay angle α and radius r."""
        return sin(self.angle_rad) ** 2 / self.radius_mm

    def free_slip_mm(self, curvature_per_mm: float) -> float:
        """Slip r² cos²α κ/sin α along the helix at the neutral axis, when the strand is bent to the curvature κ without
        friction. It varies as the sine of the angle from the extrados, where it is zero (Feyrer, Wire Ropes, 2007;
        Papailiou, IEEE Trans. Power Delivery 12 (1997) 1576: strains of plane sections summed up along the helix).
        """
        return self.radius_mm**2 * cos(self.angle_rad) ** 2 * curvature_per_mm / sin(self.angle_rad)


def least_radius_mm(diameter_mm: float, lay_length_mm: float, count: int) -> float:
    """Radius at which `count` round wires of one layer touch their neighbours; infinite if they never fit.

    It is exact. Costello's r = d/2 √(1 + tan²(π/2 − π/n)/cos²α) (Theory of Wire Rope, 1997) takes sections for
    ellipses, and is some 0.2 % too small at 17°.
    """
    from scipy.optimize import brentq

    round_mm = 0.5 * diameter_mm / sin(pi / count)

    def apart(radius_mm: float) -> float:
        return _nearest((radius_mm, radius_mm), lay_length_mm, 2.0 * pi / count)[0] - diameter_mm

    if apart(10.0 * round_mm) < 0.0:
        return float("inf")
    return float(brentq(apart, round_mm * (1.0 - 1e-12), 10.0 * round_mm, xtol=1e-12))


def radial_share(helix: Helix, count: int) -> float:
    """Part along the radius of the force between touching neighbours of a layer of `count`, over that force."""
    radii = helix.radius_mm, helix.radius_mm
    distance_mm, turned_rad = _nearest(radii, helix.lay_length_mm, 2.0 * pi / count)
    return helix.radius_mm * (1.0 - cos(turned_rad)) / distance_mm


def valley_radius_mm(inner: Helix, inner_mm: float, outer_mm: float, count: int) -> float:
    """Radius of the helix of a layer that lies in the valleys of the layer `inner`, with as many wires and the same lay
    (Seale). inner_mm, outer_mm: diameters of the wires. The inner layer's radius if the valleys are so wide that the
    outer wires fall between the inner ones.
    """
    from scipy.optimize import brentq

    touching = 0.5 * (inner_mm + outer_mm)

    def apart(radius_mm: float) -> float:
        return _nearest((inner.radius_mm, radius_mm), inner.lay_length_mm, pi / count)[0] - touching

    low, high = inner.radius_mm, inner.radius_mm + touching
    # Where the valley is too wide, the outer wire falls in between.
    return low if apart(low) > 0.0 else float(brentq(apart, low, high, xtol=1e-12))


def valley_shares(inner: Helix, outer: Helix, count: int) -> tuple[float, float]:
    """(outer, inner): parts along either wire's radius of the force between a wire that lies in a valley and a wire
    below, over that force. count: number of wires in the inner layer.
    """
    distance_mm, turned_rad = _nearest((inner.radius_mm, outer.radius_mm), inner.lay_length_mm, pi / count)
    return (
        (outer.radius_mm - inner.radius_mm * cos(turned_rad)) / distance_mm,
        (outer.radius_mm * cos(turned_rad) - inner.radius_mm) / distance_mm,
    )


def _nearest(radii_mm: tuple[float, float], lay_length_mm: float, apart_rad: float) -> tuple[float, float]:
    """Shortest distance in mm of two centre lines of one lay, apart_rad apart about the axis, and the angle between
    both places.
    """
    from scipy.optimize import brentq

    pitch, (first, second) = lay_length_mm / (2.0 * pi), radii_mm

    def slope(turned: float) -> float:
        return first * second * sin(turned) + pitch**2 * (turned - apart_rad)

    # The nearest place lies ahead along the neighbour, so that less than the whole angle is left between both.
    turned = float(brentq(slope, 0.0, apart_rad, xtol=1e-14))
    across = hypot(first - second * cos(turned), second * sin(turned))
    return hypot(across, pitch * (apart_rad - turned)), turned


def crossing_spacing_mm(inner: Helix, inner_count: int, outer: Helix) -> float:
    """Distance along the axis between crossings of an outer wire with wires of the layer below, 1/(n_i |s_o/L_o −
    s_i/L_i|), with s the hand of lay; infinite if both layers have the same lay.
    """
    turns = abs(outer.hand / outer.lay_length_mm - inner.hand / inner.lay_length_mm)
    return 1.0 / (inner_count * turns) if turns > 1e-12 else float("inf")


@dataclass(frozen=True)
class DoubleHelix:
    """Wire of a strand that is itself laid around a rope's axis. strand: the strand's helix; wire: the wire's in the
    strand.

    Its lay length is stated in the frame that turns with the strand's path, one radius of which points to the rope's
    axis (Lee, Int. J. Mech. Sci. 33 (1991) 471); angles are those of the curve's tangents.
    """

    strand: Helix
    wire: Helix

    @property
    def twist(self) -> float:
        """Path of the wire around the strand per path along it, r(2πs/L + S sin β cos β/R): r, s, L of the wire, R, S,
        β (lay angle) of the strand; positive for a right lay.
        """
        beta = self.strand.angle_rad
        own = 2.0 * pi * self.wire.hand / self.wire.lay_length_mm
        return self.wire.radius_mm * (own + self.strand.hand * sin(beta) * cos(beta) / self.strand.radius_mm)

    @property
    def outermost_rad(self) -> float:
        """Angle of the wire to the rope's axis where it is farthest from it, positive for a right lay."""
        return self.strand.signed_angle_rad + atan2(self.twist, 1.0 + self._bent)

    @property
    def innermost_rad(self) -> float:
        """Angle of the wire to the rope's axis where it is nearest to it, positive for a right lay."""
        return self.strand.signed_angle_rad - atan2(self.twist, 1.0 - self._bent)

    @property
    def crown_curvature_per_mm(self) -> float:
        """Curvature of the wire towards the rope's axis where it is farthest from it."""
        along, twist = 1.0 + self._bent, self.twist
        turning = self.strand.curvature_per_mm * along + twist**2 / self.wire.radius_mm
        return turning / (along**2 + twist**2)

    def crown_spacing_mm(self, count: int) -> float:
        """Distance along the strand between places where one of its `count` outermost wires reaches the inner side."""
        return self.wire.lay_length_mm / count

    @property
    def _bent(self) -> float:
        return self.wire.radius_mm * self.strand.curvature_per_mm


def between_deg(first_rad: float, second_rad: float) -> float:
    """Smaller angle, 0 to 90°, between two lines at these angles."""
    apart = abs(degrees(second_rad - first_rad)) % 180.0
    return min(apart, 180.0 - apart)
