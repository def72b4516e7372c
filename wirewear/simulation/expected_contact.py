"""What contact and scar of a study are expected to be, for meshes that hold them: worked out once for a run."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

from wirewear.effects import Age, Seam, Specimens, applied
from wirewear.reference import PointContact, hertz_crossed_cylinders, partial_slip_point, tangential_contact_modulus
from wirewear.simulation.contact_extents import Ellipse, fresh_ellipse, scar_ellipse
from wirewear.simulation.expected_wear import WearFactors, wear_factors
from wirewear.study import Study


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
