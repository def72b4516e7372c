"""Hertz contacts, circular, elliptic (crossed cylinders) and of lines, their moduli and first yield (N, mm, MPa)."""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from geometry import Elastic
from geometry.arrays import Array
from solvers.laws.yielding import PressureLimit

#: Excess over a circle's value as a share of a line's, for ratios of the semi-axes; integrated from Boussinesq's
#: stresses for a Poisson's ratio of 0.3, with which it hardly changes.
_RATIOS = (0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 1.0)
_LINE, _CIRCLE = 1.794, 1.613
_SHARES = tuple((ratio - _CIRCLE) / (_LINE - _CIRCLE) for ratio in (_LINE, 1.772, 1.706, 1.653, 1.627, 1.616, _CIRCLE))
_DEPTHS = np.linspace(0.02, 3.0, 3000)  #: Over the minor semi-axis.


def contact_modulus(first: Elastic, second: Elastic) -> float:
    """Contact modulus E* in MPa, 1/E* = Σ (1 − ν²)/E (Johnson, Contact Mechanics, 1985, section 4.2)."""
    return 1.0 / sum((1.0 - body.poissons_ratio**2) / body.youngs_modulus_MPa for body in (first, second))


def tangential_contact_modulus(first: Elastic, second: Elastic) -> float:
    """Tangential modulus G* in MPa, 1/G* = Σ (2 − ν)/(4G) (Mindlin 1949; Johnson 1985, section 7.2)."""
    return 1.0 / sum((2.0 - body.poissons_ratio) / (4.0 * body.shear_modulus_MPa) for body in (first, second))


def require_positive(**values: float) -> None:
    """Raise ValueError naming the first of the arguments, given by name, that is not a positive number."""
    for name, value in values.items():
        if not value > 0.0:
            raise ValueError(f"{name} must be positive, not {value:g}")


@dataclass(frozen=True)
class PointContact:
    """Elliptic (or circular) Hertz contact.

    major_angle_rad is the direction of the major semi-axis, counter-clockwise from the first body's axis.
    """

    normal_load_N: float
    major_semi_axis_mm: float
    minor_semi_axis_mm: float
    approach_mm: float
    peak_pressure_MPa: float
    major_angle_rad: float = 0.0

    @property
    def contact_radius_mm(self) -> float:
        """Radius of the circle of equal area, √(ab)."""
        return math.sqrt(self.major_semi_axis_mm * self.minor_semi_axis_mm)

    @property
    def mean_pressure_MPa(self) -> float:
        return 2.0 / 3.0 * self.peak_pressure_MPa

    def pressure(self, x_mm: ArrayLike, y_mm: ArrayLike = 0.0) -> Array:
        """Pressure p = p0 √(1 − x²/a² − y²/b²) in MPa at coordinates from the middle, x along the major axis (shapes
        broadcast); 0 outside.
        """
        x, y = np.asarray(x_mm, float), np.asarray(y_mm, float)
        inside = 1.0 - (x / self.major_semi_axis_mm) ** 2 - (y / self.minor_semi_axis_mm) ** 2
        return self.peak_pressure_MPa * np.sqrt(np.maximum(inside, 0.0))

    def mean_over_disc_MPa(self, diameter_mm: float) -> float:
        """Mean pressure in MPa over a disc about the middle of a circular contact: load on the disc over its area,
        which may exceed the contact's.

        Raises ValueError if the contact is not circular.
        """
        if not math.isclose(self.major_semi_axis_mm, self.minor_semi_axis_mm, rel_tol=1e-9):
            raise ValueError("means over a disc are of a circular contact")
        share = 0.5 * diameter_mm / self.contact_radius_mm
        carried = 1.0 - math.pow(max(1.0 - share**2, 0.0), 1.5)
        return self.mean_pressure_MPa * carried / share**2


@dataclass(frozen=True)
class LineContact:
    """Hertz line contact; its load is per mm of its length."""

    normal_load_N_per_mm: float
    half_width_mm: float
    peak_pressure_MPa: float

    @property
    def mean_pressure_MPa(self) -> float:
        return math.pi / 4.0 * self.peak_pressure_MPa

    def pressure(self, x_mm: ArrayLike) -> Array:
        """Pressure p = p0 √(1 − x²/a²) in MPa at distances x from the middle, of their shape; 0 outside."""
        x = np.asarray(x_mm, float)
        return self.peak_pressure_MPa * np.sqrt(np.maximum(1.0 - (x / self.half_width_mm) ** 2, 0.0))

    def mean_over_segment_MPa(self, length_mm: float) -> float:
        """Mean pressure in MPa over a segment of this length across the contact, about its middle; it may be longer
        than the contact is wide.
        """
        share = 0.5 * length_mm / self.half_width_mm
        within = min(share, 1.0)
        return self.peak_pressure_MPa * (within * math.sqrt(1.0 - within**2) + math.asin(within)) / (2.0 * share)


def hertz_point(normal_load_N: float, radius_mm: float, modulus_MPa: float) -> PointContact:
    """Hertz contact of a sphere of radius R on a half-space, or of equal wires of radius R crossed at 90°.

    a³ = 3PR/(4E*), approach a²/R, p0 = 3P/(2πa²) (Johnson, Contact Mechanics, 1985, section 4.2); modulus_MPa is E*.
    Raises ValueError for an argument that is not positive.
    """
    require_positive(normal_load_N=normal_load_N, radius_mm=radius_mm, modulus_MPa=modulus_MPa)
    a = (3.0 * normal_load_N * radius_mm / (4.0 * modulus_MPa)) ** (1.0 / 3.0)
    peak = 3.0 * normal_load_N / (2.0 * math.pi * a**2)
    return PointContact(normal_load_N, a, a, a**2 / radius_mm, peak)


def hertz_line(normal_load_N_per_mm: float, radius_mm: float, modulus_MPa: float) -> LineContact:
    """Hertz contact of a cylinder of (relative) radius R on a half-space: a² = 4PR/(πE*), p0 = 2P/(πa).

    Johnson 1985, section 4.2; modulus_MPa is E*. Raises ValueError for an argument that is not positive.
    """
    require_positive(normal_load_N_per_mm=normal_load_N_per_mm, radius_mm=radius_mm, modulus_MPa=modulus_MPa)
    a = math.sqrt(4.0 * normal_load_N_per_mm * radius_mm / (math.pi * modulus_MPa))
    return LineContact(normal_load_N_per_mm, a, 2.0 * normal_load_N_per_mm / (math.pi * a))


def relative_curvatures(
    first_radius_mm: float, second_radius_mm: float, crossing_angle_deg: float
) -> tuple[float, float, float]:
    """Gap Ax² + By² of two cylinders of radii R1 and R2, crossed at the angle ω: (A, B, angle), with A ≤ B in 1/mm.

    The angle in rad is that of the x axis, the contact's major axis, from the first cylinder's axis. 4AB = sin²ω/(R1
    R2) (Johnson 1985, section 4.1). Raises ValueError for a radius that is not positive, or an angle not between 0 and
    180°.
    """
    require_positive(first_radius_mm=first_radius_mm, second_radius_mm=second_radius_mm)
    if not 0.0 < crossing_angle_deg < 180.0:
        raise ValueError(f"crossing_angle_deg must lie between 0 and 180 (exclusive), not {crossing_angle_deg:g}")
    first, second = (0.0, 1.0 / first_radius_mm), (0.0, 1.0 / second_radius_mm)
    return gap_curvatures(first, second, math.radians(crossing_angle_deg))


def gap_curvatures(
    first_per_mm: tuple[float, float], second_per_mm: tuple[float, float], angle_rad: float
) -> tuple[float, float, float]:
    """Gap Ax² + By² of two bodies: (A, B, angle), with A ≤ B in 1/mm, and in rad the angle of the x axis, the contact's
    major axis, counter-clockwise from the first body's axis (Johnson 1985, section 4.1).

    first_per_mm, second_per_mm: curvatures of each body (along its axis, across it), positive if convex. angle_rad: of
    the second body's axis from the first one's.
    """
    (k1, m1), (k2, m2) = first_per_mm, second_per_mm
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    h11, h22 = 0.5 * (k1 + k2 * c**2 + m2 * s**2), 0.5 * (m1 + k2 * s**2 + m2 * c**2)
    h12 = 0.5 * (k2 - m2) * s * c
    large = 0.5 * (h11 + h22) + math.hypot(0.5 * (h11 - h22), h12)
    # Principal minors of sums of squares: no difference of large numbers cancels at small angles.
    apart = (k1 * m1 + k2 * m2 + (k1 * k2 + m1 * m2) * s**2 + (k1 * m2 + m1 * k2) * c**2) / 4.0
    small = min(apart / large, large) if large else 0.0
    return small, large, 0.5 * math.atan2(-2.0 * h12, h22 - h11)


def semi_axis_ratio(curvature_ratio: float) -> float:
    """Ratio b/a ≤ 1 of the contact ellipse's semi-axes for the ratio B/A ≥ 1 of the gap's curvatures.

    Solves B/A = [(a/b)²E(e) − K(e)]/[K(e) − E(e)] (Johnson 1985, section 4.2), written with Carlson's integrals so that
    nothing cancels near the circle. Raises ValueError for a ratio below 1.
    """
    if not curvature_ratio >= 1.0:
        raise ValueError(f"curvature_ratio must be at least 1, not {curvature_ratio:g}")

    from scipy.special import elliprd, elliprf

    def excess(log_ratio: float) -> float:
        squared = math.exp(2.0 * log_ratio)
        d = float(elliprd(0.0, squared, 1.0)) / 3.0
        return math.log((float(elliprf(0.0, squared, 1.0)) - d) / (squared * d) / curvature_ratio)

    if excess(0.0) >= 0.0:
        return 1.0
    from scipy.optimize import brentq

    # b/a falls more slowly than A/B, so A/B itself is a lower bound
    return math.exp(float(brentq(excess, -math.log(curvature_ratio) - 1.0, 0.0, xtol=1e-15, rtol=1e-14)))


def hertz_elliptic(normal_load_N: float, smaller: float, larger: float, modulus_MPa: float) -> PointContact:
    """Elliptic Hertz contact under the load P = `normal_load_N` of bodies with the gap Ax² + By² between them. A =
    `smaller` and B = `larger`, in 1/mm; modulus_MPa is E*.

    Its semi-axes are a along x, by a³ = 3PD/(2πAE*), and b along y, its approach is 3PK/(2πaE*) and its largest
    pressure 3P/(2πab). D = (K − E)/e², with the complete elliptic integrals K and E of the eccentricity e, e² = 1 −
    b²/a² (Johnson 1985, section 4.2). Raises ValueError for an argument that is not positive or curvatures in the wrong
    order.
    """
    from scipy.special import elliprd, elliprf

    require_positive(normal_load_N=normal_load_N, smaller=smaller, modulus_MPa=modulus_MPa)
    ratio = semi_axis_ratio(larger / smaller)
    k = float(elliprf(0.0, ratio**2, 1.0))
    d = float(elliprd(0.0, ratio**2, 1.0)) / 3.0
    a = (3.0 * normal_load_N * d / (2.0 * math.pi * smaller * modulus_MPa)) ** (1.0 / 3.0)
    approach = 3.0 * normal_load_N * k / (2.0 * math.pi * a * modulus_MPa)
    peak = 3.0 * normal_load_N / (2.0 * math.pi * a**2 * ratio)
    return PointContact(normal_load_N, a, a * ratio, approach, peak)


def hertz_crossed_cylinders(
    normal_load_N: float,
    first_radius_mm: float,
    second_radius_mm: float,
    crossing_angle_deg: float,
    *,
    first: Elastic,
    second: Elastic,
) -> PointContact:
    """Hertz contact of two cylinders of any radii and materials, crossed at any angle between 0 and 180° (exclusive).

    Raises ValueError for an argument outside its range. Source: `relative_curvatures`, `hertz_elliptic`.
    """
    relative_curvatures(first_radius_mm, second_radius_mm, crossing_angle_deg)  # raises
    curvatures = (0.0, 1.0 / first_radius_mm), (0.0, 1.0 / second_radius_mm)
    return hertz_bodies(normal_load_N, *curvatures, math.radians(crossing_angle_deg), first=first, second=second)


def hertz_bodies(
    normal_load_N: float,
    first_per_mm: tuple[float, float],
    second_per_mm: tuple[float, float],
    angle_rad: float,
    *,
    first: Elastic,
    second: Elastic,
) -> PointContact:
    """Hertz contact of any two bodies that touch at a point; first, second: their materials, other arguments as in
    `gap_curvatures`.

    Raises ValueError where they touch along a line. Source: `gap_curvatures`, `hertz_elliptic`.
    """
    small, large, angle = gap_curvatures(first_per_mm, second_per_mm, angle_rad)
    return replace(hertz_elliptic(normal_load_N, small, large, contact_modulus(first, second)), major_angle_rad=angle)


def first_yield_ratio(axis_ratio: float, poissons_ratio: float) -> float:
    """Peak pressure over yield stress, p0/σ_y, at which an elliptic Hertz contact without friction first yields by von
    Mises, on the axis below it.

    axis_ratio: minor over major semi-axis, 0 for a line contact. Stresses on the axis of circle and line are in closed
    form (Johnson, Contact Mechanics (1985), sections 3.4 and 4.2); ellipses are interpolated between.
    """
    circle, line = _circle_and_line(poissons_ratio)
    return circle + float(np.interp(axis_ratio, _RATIOS, _SHARES)) * (line - circle)


@cache
def _circle_and_line(nu: float) -> tuple[float, float]:
    z = _DEPTHS
    pressed = -1.0 / (1.0 + z**2)
    beside = -(1.0 + nu) * (1.0 - z * np.arctan(1.0 / z)) - 0.5 * pressed
    root = np.sqrt(1.0 + z**2)
    along, down = -((1.0 + 2.0 * z**2) / root - 2.0 * z), -1.0 / root
    out = nu * (along + down)
    mises = np.sqrt(0.5 * ((along - down) ** 2 + (down - out) ** 2 + (out - along) ** 2))
    return 1.0 / float(np.abs(pressed - beside).max()), 1.0 / float(mises.max())


def kept_approach(load_N: float, contact_radius_mm: float, gap_radius_mm: float, yield_stress_MPa: float) -> float:
    """Approach in mm that bodies of a round contact keep once a load has made them yield; 0 if it does not.

    contact_radius_mm: of the elastic contact. gap_radius_mm: of the sphere that has the bodies' gap to a flat. Under
    the even pressure H of `solvers.PressureLimit` rigid bodies overlap by P/(2πRH), of which elastic ones recover the
    share (H/p0)^1.5: all of it where H is Hertz's largest pressure p0. Within 9 % of the runs in docs/yielding.md.
    """
    peak, ratio = 1.5 * load_N / (math.pi * contact_radius_mm**2), first_yield_ratio(1.0, 0.3)
    first = load_N * (ratio * yield_stress_MPa / peak) ** 3
    limit = float(PressureLimit(yield_stress_MPa, ratio, first, overlap_mm=1.0).limit_MPa(load_N))
    kept = 1.0 - min(limit / peak, 1.0) ** 1.5
    return float(kept * load_N / (2.0 * math.pi * gap_radius_mm * limit))
