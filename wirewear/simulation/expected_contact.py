"""What contact and scar of a study are expected to be, for meshes that hold them: worked out once for a run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, hypot, pi, sin, sqrt
from typing import Any

import numpy as np

from solvers import WearRates
from wirewear.effects import Age, ContactLaw, Effect, Loading, Seam, Specimens, applied
from wirewear.reference import (
    PointContact,
    hertz_crossed_cylinders,
    partial_slip_point,
    relative_curvatures,
    tangential_contact_modulus,
)
from wirewear.study import Study

# Effects may add this factor to the worn volume before the patch grows: 8 % of its half-width in 3D. Runs with and
# without effects that fit into the margin have the same meshes and differ by nothing else.
_MARGIN = 1.35
_AGES = 200


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


@dataclass(frozen=True)
class WearFactors:
    """Mean and largest factor of effects on the wear per cycle in gross slip, over the cycles of a test."""

    mean: float
    largest: float

    @property
    def beyond_margin(self) -> float:
        """Factor on the worn volume for which a mesh must have room, 1 where its margin will do."""
        return max(self.mean / _MARGIN, 1.0)


def wear_factors(effects: Sequence[Effect[Any]], friction: float, load_N: float, cycles: float) -> WearFactors:
    """The factors of effects on a nominal friction, load and wear law."""
    if not effects or friction * load_N == 0.0:
        return WearFactors(1.0, 1.0)
    nominal = ContactLaw(friction), Loading(load_N)
    factors = [_work(effects, *nominal, Age(n, 0.0)) for n in np.linspace(0.0, cycles, _AGES)]
    return WearFactors(float(np.mean(factors)) / (friction * load_N), max(factors) / (friction * load_N))


def _work(effects: Sequence[Effect[Any]], contact: ContactLaw, loading: Loading, age: Age) -> float:
    """Friction force times the factor on the wear coefficient, N; by Archard's law likewise."""
    friction = applied(effects, Seam.CONTACT, contact, age).friction
    load = applied(effects, Seam.LOADING, loading, age).normal_load_N
    return friction * load * applied(effects, Seam.WEAR, WearRates(1.0, 1.0), age).upper_mm3_per_mJ


@dataclass(frozen=True)
class ExpectedContact:
    """Contact of the unworn wires and scar of the worn ones.

    radii_mm: of the moving and the fixed wire.  hertz: the fresh contact.  scar: outline of the final scar in gross
    slip on a rigid rig, None without wear and flattening.  flattened_mm3: volume of both wires that an effect takes
    away before the first cycle.  wear_factors: of the effects, over the test.
    sticks: whether the middle of the contact sticks for good.
    """

    radii_mm: tuple[float, float]
    crossing_angle_deg: float
    hertz: PointContact
    scar: Ellipse | None
    flattened_mm3: float
    wear_factors: WearFactors
    sticks: bool = False

    @property
    def fresh(self) -> Ellipse:
        """Outline of the fresh contact."""
        return fresh_ellipse(self.hertz)

    def scar_half_width_mm(self, worn_volume_mm3: float) -> float:
        """Largest half-width when both wires together have lost a volume, never below the fresh contact's."""
        if worn_volume_mm3 <= 0.0:
            return self.fresh.major_mm
        return max(self.fresh.major_mm, _scar(worn_volume_mm3, self.radii_mm, self.crossing_angle_deg).major_mm)


def expected_contact(study: Study) -> ExpectedContact:
    """What is expected of a study."""
    moving, fixed = study.moving_wire, study.fixed_wire
    radii, angle = (moving.diameter_mm / 2.0, fixed.diameter_mm / 2.0), study.wires.crossing_angle_deg
    conditions = study.conditions
    hertz = hertz_crossed_cylinders(
        conditions.normal_load_N, *radii, angle, first=moving.material, second=fixed.material
    )
    factors = wear_factors(study.effects, study.contact.friction, conditions.normal_load_N, float(conditions.cycles))
    flattened = _flattened_volume(study, radii)
    volume = max(_worn_volume(study, factors), flattened)
    sticks = _sticks(study, hertz)
    if volume == 0.0:
        scar = None
    elif sticks:
        # A contact that sticks in its middle for good wears within its fresh outline.
        scar = fresh_ellipse(hertz)
    else:
        scar = _scar(volume, radii, angle)
    return ExpectedContact(radii, angle, hertz, scar, flattened, factors, sticks)


def _scar(volume_mm3: float, radii_mm: tuple[float, float], crossing_angle_deg: float) -> Ellipse:
    return scar_ellipse(volume_mm3, *radii_mm, crossing_angle_deg)


def _sticks(study: Study, hertz: PointContact) -> bool:
    """Whether the displacement is too small for the unworn wires to slide by Cattaneo and Mindlin, on a rigid rig.

    The contact between gripped wires is softer and slides later. Effects may make it slide earlier: with any, it is
    taken to slide.
    """
    if study.effects or not study.contact.friction:
        return False
    radius = (hertz.major_semi_axis_mm * hertz.minor_semi_axis_mm) ** 0.5
    modulus = tangential_contact_modulus(study.moving_wire.material, study.fixed_wire.material)
    contact = partial_slip_point(study.conditions.normal_load_N, study.contact.friction, radius, modulus)
    return 1e-3 * study.conditions.displacement_amplitude_um < contact.full_slip_displacement_mm


def _worn_volume(study: Study, factors: WearFactors) -> float:
    """Volume in mm³ that both wires lose over the test in gross slip on a rigid rig."""
    if study.wear is None:
        return 0.0
    conditions = study.conditions
    sliding_m = 4e-6 * conditions.displacement_amplitude_um * conditions.cycles
    largest = study.wear.largest_factor * factors.beyond_margin
    per_sliding = largest * study.wear.volume_per_sliding_mm3_per_N_m(study.contact.friction)
    return per_sliding * conditions.normal_load_N * sliding_m


def _flattened_volume(study: Study, radii_mm: tuple[float, float]) -> float:
    """Volume in mm³ on which the unworn wires overlap when they are flattened by an effect, crossed at right angles."""
    nominal = Specimens(study.wires.crossing_angle_deg)
    depth = applied(study.effects, Seam.SPECIMENS, nominal, Age.new()).flattening_mm
    return pi * sqrt(radii_mm[0] * radii_mm[1]) * depth**2
