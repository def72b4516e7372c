"""From a rig stiffness study to the line contact of each case and scenario: one that does not wear."""

from __future__ import annotations

from typing import Literal

from wirewear.errors import StudyError
from wirewear.planar.model import PlanarPlan, plan
from wirewear.planar.rig_stiffness.tables import ContactTable, CylinderContact, FlatContact, RigStiffnessStudy
from wirewear.planar.tables import (
    Pad,
    PlanarConditions,
    PlanarContact,
    PlanarHolder,
    PlanarMeshing,
    PlanarStudy,
    Specimen,
)
from wirewear.study.fidelity import RIG_STIFFNESS_LEVELS, level_of

#: 1: the pad translates on a spring; 2: it rotates on one.
Scenario = Literal[1, 2]
SCENARIOS: tuple[Scenario, ...] = (1, 2)


def plan_contact(study: RigStiffnessStudy, name: str, fidelity: str) -> PlanarPlan:
    """Meshes and steps for the contact `name` of the study, the same for all its cases and both scenarios.

    Raises:
        StudyError: the contact does not fit on a body.
    """
    contact = study.contacts[name]
    stiffest = contact.normal_load_N_per_mm * contact.pivot_height_mm
    try:
        return plan(
            line_contact(
                study,
                name,
                PlanarHolder(
                    rotational_stiffness_N_per_rad=max(2.0 * stiffest, 1.0), pivot_height_mm=contact.pivot_height_mm
                ),
                fidelity,
            ),
            fidelity,
        )
    except StudyError as problem:
        raise StudyError(f"[{name}]: {problem}") from None


def rig_of(contact: ContactTable, scenario: Scenario, stiffness: float) -> PlanarHolder:
    """The rig of a scenario whose spring has that stiffness."""
    if scenario == 1:
        return PlanarHolder(tangential_stiffness_N_per_mm2=stiffness)
    return PlanarHolder(rotational_stiffness_N_per_rad=stiffness, pivot_height_mm=contact.pivot_height_mm)


def line_contact(study: RigStiffnessStudy, name: str, rig: PlanarHolder, fidelity: str) -> PlanarStudy:
    """The contact `name` on a rig as a study of its own, without wear."""
    contact, level, conditions = study.contacts[name], level_of(RIG_STIFFNESS_LEVELS, fidelity), study.conditions
    material = {
        "youngs_modulus_MPa": study.material.youngs_modulus_MPa,
        "poissons_ratio": study.material.poissons_ratio,
    }
    return PlanarStudy(
        format=study.format,
        name=f"{study.name}: {name}",
        kind="line-contact",
        pad=Pad(
            **material,
            **_face(contact),
            height_mm=contact.pad_height_mm,
            half_width_mm=contact.pad_half_width_mm,
        ),
        specimen=Specimen(
            **material, height_mm=contact.specimen_height_mm, half_width_mm=contact.specimen_half_width_mm
        ),
        conditions=PlanarConditions(
            normal_load_N_per_mm=contact.normal_load_N_per_mm,
            displacement_amplitude_um=conditions.displacement_amplitude_um,
            cycles=conditions.most_cycles,
        ),
        contact=PlanarContact(friction=conditions.friction),
        holder=rig,
        mesh=PlanarMeshing(
            contact_mesh_um=study.mesh.contact_mesh_um or level.contact_mesh_um,
            far_mesh_mm=study.mesh.far_mesh_mm,
            increments_per_cycle=study.mesh.increments_per_cycle or level.increments_per_cycle,
        ),
    )


def _face(contact: ContactTable) -> dict[str, float]:
    match contact:
        case CylinderContact(radius_mm=radius):
            return {"radius_mm": radius}
        case FlatContact(face_half_width_mm=face, edge_radius_mm=radius):
            return {"face_half_width_mm": face, "edge_radius_mm": radius}
        case _:
            raise TypeError(f"no face is known for {type(contact).__name__}")
