"""From a rig stiffness study to meshes, steps and the contact problem of each case and scenario."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import pi, sqrt
from typing import Any, Literal

from geometry import Cylinder, EdgeGradedAxis, Flat, GradedAxis, PlanarGeometry, RoundedFlat
from solvers import ContactProblem, Holder, PlacedBody, WearRates
from wirewear import reference
from wirewear.planar.bodies import placed_body, require_room
from wirewear.planar.rig_stiffness.tables import ContactTable, CylinderContact, FlatContact, RigStiffnessStudy
from wirewear.study.fidelity import RIG_STIFFNESS_LEVELS

#: 1: the pad translates on a spring; 2: it rotates on one.
Scenario = Literal[1, 2]
SCENARIOS: tuple[Scenario, ...] = (1, 2)


# Elements in the middle of a flat contact, where nothing changes quickly, over those at its edges.
_MIDDLE = 5.0
_MARGIN = 1.15


@dataclass(frozen=True)
class ContactPlan:
    """Meshes of pad and specimen and the steps of a cycle."""

    pad: PlanarGeometry
    specimen: PlanarGeometry
    increments_per_cycle: int

    def settings(self) -> dict[str, Any]:
        """What a result records of it."""
        return asdict(self)


def plan_contact(study: RigStiffnessStudy, name: str, fidelity: str) -> ContactPlan:
    """Meshes and steps for the contact `name` of the study.

    Raises:
        StudyError: the contact does not fit on a body.
    """
    contact, level, mesh = study.contacts[name], RIG_STIFFNESS_LEVELS[fidelity], study.mesh
    fine = 1e-3 * (mesh.contact_mesh_um or level.contact_mesh_um)
    stroke = 1e-3 * study.conditions.displacement_amplitude_um
    pad, specimen = _profile_and_axes(study, contact, fine, stroke)
    for body, half, along in (
        ("pad", contact.pad_half_width_mm, pad[1]),
        ("specimen", contact.specimen_half_width_mm, specimen[1]),
    ):
        remedy = f"give a wider {body} or less load"
        require_room(f"{body} of [{name}]", f"{body}_half_width_mm", along.half_extent_mm, half, remedy)
    far = mesh.far_mesh_mm
    return ContactPlan(
        PlanarGeometry(pad[0], contact.pad_half_width_mm, contact.pad_height_mm, pad[1], far),
        PlanarGeometry(specimen[0], contact.specimen_half_width_mm, contact.specimen_height_mm, specimen[1], far),
        mesh.increments_per_cycle or level.increments_per_cycle,
    )


def bodies(study: RigStiffnessStudy, plan: ContactPlan) -> tuple[PlacedBody, PlacedBody]:
    """Mesh, condense and place pad and specimen."""
    material = study.material.elastic
    return placed_body(plan.pad, material, upper=True), placed_body(plan.specimen, material, upper=False)


def problem(
    study: RigStiffnessStudy, name: str, case: int, scenario: Scenario, pad: PlacedBody, specimen: PlacedBody
) -> ContactProblem:
    """The contact problem of a case, counted from 1, in a scenario."""
    contact = study.contacts[name]
    if scenario == 1:
        stiffness = contact.tangential_stiffness_N_per_mm2[case - 1]
        holder = Holder(contact.normal_load_N_per_mm, tangential_compliance_mm_per_N=1.0 / stiffness)
    else:
        stiffness = contact.rotational_stiffness_N_per_rad[case - 1]
        holder = Holder(
            contact.normal_load_N_per_mm,
            rotational_compliance_rad_per_N_mm=1.0 / stiffness,
            pivot_height_mm=contact.pivot_height_mm,
        )
    return ContactProblem(pad, specimen, holder, study.conditions.friction, WearRates(0.0, 0.0))


_Surface = tuple[Cylinder | RoundedFlat | Flat, GradedAxis | EdgeGradedAxis]


def _profile_and_axes(
    study: RigStiffnessStudy, contact: ContactTable, fine: float, stroke: float
) -> tuple[_Surface, _Surface]:
    """Surface and mesh lines of pad and specimen; the contact rolls by radius times tilt, the specimen moves too."""
    modulus = reference.contact_modulus(study.material.elastic, study.material.elastic)
    largest_tilt = stroke / contact.pivot_height_mm
    match contact:
        case CylinderContact(radius_mm=radius):
            hertz = reference.hertz_line(contact.normal_load_N_per_mm, radius, modulus).half_width_mm
            half = _MARGIN * (hertz + radius * largest_tilt)
            wider = half + stroke
            cylinder = Cylinder(radius, curved_along=True)
            return (cylinder, GradedAxis(fine, half, fine, half)), (Flat(), GradedAxis(fine, wider, fine, wider))
        case FlatContact(face_half_width_mm=face, edge_radius_mm=radius):
            # Were all the load on one rounded edge, the contact would reach so far beyond the flat, and inside it.
            reach = sqrt(4.0 * contact.normal_load_N_per_mm * radius / (pi * modulus))
            half = face + _MARGIN * (reach + radius * largest_tilt)
            inner = max(face - reach, 0.25 * face)
            rounded = RoundedFlat(face, radius)
            coarse = _MIDDLE * fine
            return (
                (rounded, EdgeGradedAxis(fine, coarse, inner, half)),
                (Flat(), EdgeGradedAxis(fine, coarse, max(inner - stroke, 0.25 * face), half + stroke)),
            )
        case _:
            raise TypeError(f"no surface is known for {type(contact).__name__}")
