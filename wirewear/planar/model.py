"""From a planar study to meshes, steps and the contact problem."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from geometry import Cylinder, Flat, GradedAxis, PlanarGeometry
from solvers import ContactProblem, Holder, WearRates
from wirewear import reference
from wirewear.planar.bodies import placed_body, require_room
from wirewear.planar.tables import PlanarStudy
from wirewear.simulation.expected_wear import wear_factors
from wirewear.study.fidelity import LINE_LEVELS

_MARGIN = 1.3
_WIDEST_mm = 10.0
_ACROSS_RADIUS = 0.8
# Pressures of worn surfaces have a kink where neighbouring elements differ in size: 4 % of their mean at 1.2.
_GROWTH = 1.05


@dataclass(frozen=True)
class PlanarPlan:
    """Meshes of both bodies and the steps of a run; lengths in mm."""

    pad: PlanarGeometry
    specimen: PlanarGeometry
    increments_per_cycle: int
    jump_tolerance: float
    hertz: reference.LineContact

    def settings(self) -> dict[str, Any]:
        """What a result records of it."""
        return {
            "contact_mesh_um": 1e3 * self.pad.along.fine_mm,
            "outer_mesh_um": 1e3 * float(np.diff(self.pad.along.half_lines()).max()),
            "patch_half_width_um": 1e3 * self.pad.along.half_extent_mm,
            "increments_per_cycle": self.increments_per_cycle,
            "jump_tolerance": self.jump_tolerance,
            "hertz_half_width_um": 1e3 * self.hertz.half_width_mm,
            "hertz_pressure_MPa": self.hertz.peak_pressure_MPa,
            "pad": asdict(self.pad),
            "specimen": asdict(self.specimen),
        }


def plan(study: PlanarStudy, fidelity: str) -> PlanarPlan:
    """Meshes and steps of a planar study.

    The patch holds the scar that gross slip on a rigid rig would wear, with a margin, and on the specimen the stroke.

    Raises:
        StudyError: the patch does not fit on a body.
    """
    level, mesh, conditions = LINE_LEVELS[fidelity], study.mesh, study.conditions
    modulus = reference.contact_modulus(study.pad.elastic, study.specimen.elastic)
    hertz = reference.hertz_line(conditions.normal_load_N_per_mm, study.pad.radius_mm, modulus)
    a, stroke = hertz.half_width_mm, 1e-3 * conditions.displacement_amplitude_um
    scar = 1e-3 * mesh.scar_half_width_um if mesh.scar_half_width_um is not None else _predicted(study, a)
    fine = 1e-3 * mesh.contact_mesh_um if mesh.contact_mesh_um is not None else a / level.per_contact

    def along(half: float) -> GradedAxis:
        return GradedAxis(fine, min(1.5 * a + half - scar, half), max(fine, scar / level.per_scar), half, _GROWTH)

    pad_half = study.pad.half_width_mm or min(_WIDEST_mm, _ACROSS_RADIUS * study.pad.radius_mm)
    specimen_half = study.specimen.half_width_mm or max(_WIDEST_mm, 1.5 * (scar + stroke))
    for name, half, needed in (("pad", pad_half, scar), ("specimen", specimen_half, scar + stroke)):
        remedy = f"lower cycles, stroke or wear, or give a wider {name}"
        require_room(name, "half_width_mm", needed, half, remedy)
    far = mesh.far_mesh_mm
    return PlanarPlan(
        pad=PlanarGeometry(
            Cylinder(study.pad.radius_mm, curved_along=True), pad_half, study.pad.height_mm, along(scar), far
        ),
        specimen=PlanarGeometry(Flat(), specimen_half, study.specimen.height_mm, along(scar + stroke), far),
        increments_per_cycle=mesh.increments_per_cycle or level.increments_per_cycle,
        jump_tolerance=mesh.jump_tolerance or level.jump_tolerance,
        hertz=hertz,
    )


def planar_problem(study: PlanarStudy, meshes: PlanarPlan) -> ContactProblem:
    """Mesh, condense and place both bodies, the pad above on its rig."""
    stiffness = study.holder.tangential_stiffness_N_per_mm2
    pad, specimen = study.energy_coefficients()
    return ContactProblem(
        upper=placed_body(meshes.pad, study.pad.elastic, upper=True),
        lower=placed_body(meshes.specimen, study.specimen.elastic, upper=False),
        holder=Holder(study.conditions.normal_load_N_per_mm, 0.0 if stiffness == "rigid" else 1.0 / stiffness),
        friction=study.contact.friction,
        friction_law=study.contact.friction_law,
        wear=WearRates(upper_mm3_per_mJ=1e-3 * pad, lower_mm3_per_mJ=1e-3 * specimen),
    )


def _predicted(study: PlanarStudy, contact_mm: float) -> float:
    """Half-width of the final scar in gross slip on a rigid rig, (3 R A / 2)^(1/3), with a margin."""
    conditions = study.conditions
    energy_mJ = (
        4e-3
        * study.contact.friction
        * conditions.normal_load_N_per_mm
        * conditions.displacement_amplitude_um
        * conditions.cycles
    )
    factors = wear_factors(
        study.effects, study.contact.friction, conditions.normal_load_N_per_mm, float(conditions.cycles)
    )
    area = 1e-3 * sum(study.energy_coefficients()) * energy_mJ * factors.beyond_margin
    scar = reference.line_contact_scar(area, study.pad.radius_mm).half_width_mm if area > 0.0 else 0.0
    # A flat that loses more than the pad is worn beyond the pad's scar by the stroke.
    stroke = 1e-3 * conditions.displacement_amplitude_um if area > 0.0 else 0.0
    return _MARGIN * max(2.0 * contact_mm, scar + contact_mm + 0.5 * stroke)
