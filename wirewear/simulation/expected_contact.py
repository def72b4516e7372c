"""What contact and scar of a study are expected to be, for meshes that hold them."""

from __future__ import annotations

from wirewear.reference import PointContact, hertz_crossed_cylinders, partial_slip_point, tangential_contact_modulus
from wirewear.simulation.contact_extents import Ellipse, fresh_ellipse, scar_ellipse
from wirewear.simulation.expected_wear import flattened_volume, wear_factors_of
from wirewear.study import Study


def fresh_contact(study: Study) -> PointContact:
    """Hertz contact of the unworn wires."""
    moving, fixed = study.moving_wire, study.fixed_wire
    return hertz_crossed_cylinders(
        study.conditions.normal_load_N,
        moving.diameter_mm / 2.0,
        fixed.diameter_mm / 2.0,
        study.wires.crossing_angle_deg,
        first=moving.material,
        second=fixed.material,
    )


def predicted_scar(study: Study) -> Ellipse | None:
    """Outline of the final scar in gross slip on a rigid rig; None without wear and flattening.

    A contact that sticks in its middle for good wears within its fresh outline.
    """
    volume = max(_worn_volume(study), flattened_volume(study))
    if volume == 0.0:
        return None
    if _sticks(study):
        return fresh_ellipse(fresh_contact(study))
    return scar_of_volume(study, volume)


def scar_of_volume(study: Study, volume_mm3: float) -> Ellipse:
    """Outline of the scar when both wires together have lost a volume."""
    moving, fixed = study.moving_wire, study.fixed_wire
    return scar_ellipse(volume_mm3, moving.diameter_mm / 2.0, fixed.diameter_mm / 2.0, study.wires.crossing_angle_deg)


def _sticks(study: Study) -> bool:
    """Whether the displacement is too small for the unworn wires to slide by Cattaneo and Mindlin, on a rigid rig.

    The contact between gripped wires is softer and slides later. Effects may make it slide earlier: with any, it is
    taken to slide.
    """
    if study.effects or not study.contact.friction:
        return False
    hertz = fresh_contact(study)
    bodies = [wire.material for wire in (study.moving_wire, study.fixed_wire)]
    radius = (hertz.major_semi_axis_mm * hertz.minor_semi_axis_mm) ** 0.5
    contact = partial_slip_point(
        study.conditions.normal_load_N, study.contact.friction, radius, tangential_contact_modulus(*bodies)
    )
    return 1e-3 * study.conditions.displacement_amplitude_um < contact.full_slip_displacement_mm


def _worn_volume(study: Study) -> float:
    """Volume in mm³ that both wires lose over the test in gross slip on a rigid rig."""
    if study.wear is None:
        return 0.0
    conditions = study.conditions
    sliding_m = 4e-6 * conditions.displacement_amplitude_um * conditions.cycles
    largest = max((factor for _, factor in study.wear.variation_points), default=1.0)
    largest *= wear_factors_of(study).beyond_margin
    per_sliding = largest * study.wear.volume_per_sliding_mm3_per_N_m(study.contact.friction)
    return per_sliding * conditions.normal_load_N * sliding_m
