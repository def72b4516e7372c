"""From a study to meshes and steps: where the contact will be, how fine it must be resolved, and what that comes to."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import cos, pi, radians, sin
from typing import Any

from geometry import GradedAxis, WireGeometry
from wirewear.errors import StudyError
from wirewear.reference import Elastic as ReferenceElastic
from wirewear.reference import PointContact, contact_modulus, explicit_stability_limit, hertz_crossed_cylinders
from wirewear.study import Study, Wire


@dataclass(frozen=True)
class Level:
    """What a level of fidelity means, where the study does not say otherwise.

    per_contact_radius: elements per radius of the fresh contact.  per_scar: elements per half-width of the scar.
    Wear depends on increments less than the shape of a loop does, so cycles that only wear take fewer of them.
    """

    per_contact_radius: float
    per_scar: float
    increments_per_cycle: int
    jump_tolerance: float


LEVELS = {
    "quick": Level(per_contact_radius=1.9, per_scar=9.0, increments_per_cycle=32, jump_tolerance=0.15),
    "standard": Level(per_contact_radius=3.5, per_scar=13.0, increments_per_cycle=40, jump_tolerance=0.08),
    "fine": Level(per_contact_radius=5.0, per_scar=18.0, increments_per_cycle=64, jump_tolerance=0.04),
}

# The predicted scar is enlarged by this factor to give the finely meshed patch.
_SCAR_MARGIN = 1.2
_FRESH_MARGIN = 2.4
_COARSE_PER_DIAMETER = 0.155
_WEAR_INCREMENTS = 0.65


@dataclass(frozen=True)
class Discretisation:
    """Meshes of both wires and the steps of a run; lengths in mm."""

    moving: WireGeometry
    fixed: WireGeometry
    increments_per_cycle: int
    increments_per_wear_cycle: int
    jump_tolerance: float
    hertz: PointContact
    predicted_scar_half_width_mm: float

    def settings(self) -> dict[str, Any]:
        """What a result records of it."""
        return {
            "contact_mesh_um": 1e3 * self.fixed.transverse.fine_mm,
            "outer_mesh_um": 1e3 * self.fixed.transverse.outer_mm,
            "patch_half_width_um": 1e3 * self.fixed.axial.half_extent_mm,
            "increments_per_cycle": self.increments_per_cycle,
            "increments_per_wear_cycle": self.increments_per_wear_cycle,
            "jump_tolerance": self.jump_tolerance,
            "hertz_contact_radius_um": 1e3 * self.hertz.contact_radius_mm,
            "hertz_pressure_MPa": self.hertz.peak_pressure_MPa,
            "hertz_approach_um": 1e3 * self.hertz.approach_mm,
            "predicted_scar_half_width_um": 1e3 * self.predicted_scar_half_width_mm,
            "moving_wire": asdict(self.moving),
            "fixed_wire": asdict(self.fixed),
        }


def fresh_contact(study: Study) -> PointContact:
    """Hertz contact of the unworn wires."""
    moving, fixed = study.moving_wire, study.fixed_wire
    return hertz_crossed_cylinders(
        study.conditions.normal_load_N,
        moving.diameter_mm / 2.0,
        fixed.diameter_mm / 2.0,
        study.wires.crossing_angle_deg,
        first=ReferenceElastic(moving.youngs_modulus_MPa, moving.poissons_ratio),
        second=ReferenceElastic(fixed.youngs_modulus_MPa, fixed.poissons_ratio),
    )


def discretise(study: Study, fidelity: str) -> Discretisation:
    """Meshes and steps of a study at a level of fidelity.

    Raises:
        StudyError: the fine patch would not fit on a wire, or the contact would leave it during the stroke.
    """
    level, chosen = LEVELS[fidelity], study.fidelity(fidelity)
    hertz = fresh_contact(study)
    largest_axis = hertz.major_semi_axis_mm
    smallest_axis = hertz.minor_semi_axis_mm
    stroke = study.conditions.displacement_amplitude_um * 1e-3
    predicted = _predicted_scar(study, largest_axis)
    given = study.mesh.scar_half_width_um
    if given is not None and given * 1e-3 < predicted / _SCAR_MARGIN:
        raise StudyError(
            f"scar_half_width_um = {given:g} in [mesh] is too small: the contact is expected to grow to "
            f"{1e3 * predicted / _SCAR_MARGIN:.0f} um on each side and would leave the finely meshed patch during the "
            f"stroke; give at least {1e3 * predicted:.0f}, or leave the key out"
        )
    half_width = predicted if given is None else given * 1e-3
    fine = smallest_axis / level.per_contact_radius if chosen.contact_mesh_um is None else chosen.contact_mesh_um * 1e-3
    coarsest = max(fine, half_width / level.per_scar)
    outer = coarsest if chosen.outer_mesh_um is None else max(chosen.outer_mesh_um * 1e-3, fine)

    def axis(travel: float) -> GradedAxis:
        half = travel + half_width
        return GradedAxis(fine, min(travel + 1.15 * largest_axis, half), outer, half)

    moving = _geometry(study.moving_wire, axis(stroke), axis(0.0), "moving")
    fixed = _geometry(study.fixed_wire, axis(0.0), axis(0.0), "fixed")
    increments = chosen.increments_per_cycle or level.increments_per_cycle
    wear_increments = max(8, 4 * round(_WEAR_INCREMENTS * increments / 4.0))
    _require_stable_update(
        study, min(line.fine_mm for w in (moving, fixed) for line in (w.axial, w.transverse)), wear_increments
    )
    return Discretisation(
        moving=moving,
        fixed=fixed,
        increments_per_cycle=increments,
        increments_per_wear_cycle=wear_increments,
        jump_tolerance=chosen.jump_tolerance or level.jump_tolerance,
        hertz=hertz,
        predicted_scar_half_width_mm=half_width,
    )


def _require_stable_update(study: Study, element_mm: float, increments: int) -> None:
    """Refuse explicit cycle jumps beyond the stability limit."""
    wear = study.wear
    per_sliding = wear.volume_per_sliding_mm3_per_N_m(study.contact.friction) if wear else 0.0
    if wear is None or wear.explicit_jump_cycles is None or per_sliding == 0.0:
        return
    moving, fixed = (
        ReferenceElastic(wire.youngs_modulus_MPa, wire.poissons_ratio) for wire in (study.moving_wire, study.fixed_wire)
    )
    longest_step_mm = 1e-3 * study.conditions.displacement_amplitude_um * sin(2.0 * pi / increments)
    limit = explicit_stability_limit(
        element_mm, per_sliding, 1.0, contact_modulus(moving, fixed), longest_step_mm, plane=False
    ) / max((factor for _, factor in wear.variation_points), default=1.0)
    if wear.explicit_jump_cycles > limit:
        raise StudyError(
            f"explicit_jump_cycles = {wear.explicit_jump_cycles:g} in [wear] is unstable: on this mesh an explicit "
            f"update diverges beyond {limit:.3g} cycles; take at most {0.5 * limit:.2g}, "
            'or update = "implicit", which has no limit'
        )


def _predicted_scar(study: Study, contact_axis_mm: float) -> float:
    """Half-width that the patch needs for the final scar in gross slip on a rigid rig, (4 R V / pi)^(1/4)."""
    fresh = _FRESH_MARGIN * contact_axis_mm
    if study.wear is None:
        return fresh
    conditions = study.conditions
    sliding_m = 4e-6 * conditions.displacement_amplitude_um * conditions.cycles
    largest = max((factor for _, factor in study.wear.variation_points), default=1.0)
    per_sliding = largest * study.wear.volume_per_sliding_mm3_per_N_m(study.contact.friction)
    volume = per_sliding * conditions.normal_load_N * sliding_m
    radius = 0.25 * (study.moving_wire.diameter_mm + study.fixed_wire.diameter_mm)
    # Wires crossed at an acute angle wear an elongated scar.
    elongation = (
        cos(radians(study.wires.crossing_angle_deg) / 2.0) / sin(radians(study.wires.crossing_angle_deg) / 2.0)
    ) ** 0.5
    scar = (4.0 * radius * volume / pi) ** 0.25 * max(elongation, 1.0)
    return float(max(fresh, _SCAR_MARGIN * (scar + 0.5 * contact_axis_mm)))


def _geometry(wire: Wire, axial: GradedAxis, transverse: GradedAxis, name: str) -> WireGeometry:
    reach, limit = transverse.half_extent_mm, 0.42 * wire.diameter_mm
    if reach > limit:
        raise StudyError(
            f"the {name} wire is too thin for this test: the contact is expected to need {1e3 * reach:.0f} um to each "
            f"side of its crown, but at most {1e3 * limit:.0f} um of a wire of {wire.diameter_mm:g} mm can be meshed; "
            "lower the cycles, load, stroke or wear coefficient, or give a smaller scar_half_width_um in [mesh]"
        )
    shortest = 2.0 * axial.half_extent_mm / 0.9
    length = wire.length_mm if wire.length_mm is not None else max(2.2 * wire.diameter_mm, shortest + wire.diameter_mm)
    if length < shortest:
        raise StudyError(
            f"length_mm = {length:g} of the {name} wire is too short: stroke and scar need at least {shortest:.3g} mm"
        )
    return WireGeometry(wire.diameter_mm, length, axial, transverse, _COARSE_PER_DIAMETER * wire.diameter_mm)
