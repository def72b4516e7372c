"""From a study to the meshes and steps of a run."""

from dataclasses import dataclass, replace
from math import pi, sin
from typing import Any

from geometry import BodyGeometry
from wirewear.base.errors import StudyError
from wirewear.reference import PointContact, contact_modulus, explicit_stability_limit
from wirewear.results.scar import called
from wirewear.simulation.expected_contact import ExpectedContact, expected_contact
from wirewear.simulation.patches import SCAR_MARGIN, ElementSizes, affordable_meshes, axes_of, needed_reach_mm, unknowns
from wirewear.study import Study
from wirewear.study.fidelity import WIRE_LEVELS, WireLevel, level_of

#: Elements of a pad's contact over those of a ball's: at a flat's edge pressure rises within a fifth of its radius.
_AT_EDGES = 2.5


@dataclass(frozen=True)
class Discretisation:
    """Meshes of the driven and the held body and the steps of a run; lengths in mm.

    bodies: what they are called.  level: of fidelity, refined as the study asks.
    expected: the contact and the scar that the meshes are for.
    coarsening: by how much elements are larger than the level asks for, to keep the patches to its number of unknowns.
    """

    moving: BodyGeometry
    fixed: BodyGeometry
    bodies: tuple[str, str]
    increments_per_cycle: int
    increments_per_wear_cycle: int
    jump_tolerance: float
    level: WireLevel
    expected: ExpectedContact
    predicted_scar_half_width_mm: float
    coarsening: float

    @property
    def hertz(self) -> PointContact:
        """The fresh contact."""
        return self.expected.hertz

    @property
    def unknowns(self) -> int:
        """Displacements of both patches."""
        return unknowns(self.moving) + unknowns(self.fixed)

    def settings(self) -> dict[str, Any]:
        """What a result records of it."""
        return {
            "contact_mesh_um": 1e3 * self.fixed.transverse.fine_mm,
            "outer_mesh_um": 1e3 * self.fixed.transverse.outer_mm,
            "patch_half_width_um": 1e3 * self.fixed.axial.half_extent_mm,
            "mesh_coarsening": self.coarsening,
            "increments_per_cycle": self.increments_per_cycle,
            "increments_per_wear_cycle": self.increments_per_wear_cycle,
            "jump_tolerance": self.jump_tolerance,
            "hertz_contact_radius_um": 1e3 * self.hertz.contact_radius_mm,
            "hertz_pressure_MPa": self.hertz.peak_pressure_MPa,
            "hertz_approach_um": 1e3 * self.hertz.approach_mm,
            "predicted_scar_half_width_um": 1e3 * self.predicted_scar_half_width_mm,
            **{
                called(body).replace(" ", "_"): geometry.as_table()
                for body, geometry in zip(self.bodies, (self.moving, self.fixed), strict=True)
            },
        }


def discretise(study: Study, fidelity: str) -> Discretisation:
    """Meshes and steps of a study at a level of fidelity.
    Raises StudyError if the fine patch would not fit on a body, or the contact would leave it during the stroke.
    """
    level, chosen = _level_of(study, fidelity), study.fidelity(fidelity)
    expected = expected_contact(study)
    if expected.sticks and study.wear is not None:
        level = level.for_sticking()
    if expected.face is not None:
        level = replace(level, per_contact_radius=_AT_EDGES * level.per_contact_radius)
    fresh, scar = expected.fresh, expected.scar
    needed = max(
        needed_reach_mm(axis, fresh, scar) for body in axes_of(study) for axis in (body.axial, body.transverse)
    )
    given = study.mesh.scar_half_width_um
    if given is not None and given * 1e-3 < needed / SCAR_MARGIN:
        raise StudyError(
            f"scar_half_width_um = {given:g} in [mesh] is too small: the contact is expected to grow to "
            f"{1e3 * needed / SCAR_MARGIN:.0f} um on each side and would leave the finely meshed patch during the "
            f"stroke; give at least {1e3 * needed:.0f}, or leave the key out"
        )
    half_width = needed if given is None else given * 1e-3
    sizes = ElementSizes(
        fresh,
        scar,
        widening=half_width / needed,
        contact_mm=None if chosen.contact_mesh_um is None else chosen.contact_mesh_um * 1e-3,
        outer_mm=None if chosen.outer_mesh_um is None else chosen.outer_mesh_um * 1e-3,
    )
    moving, fixed, coarsening = affordable_meshes(study, sizes, level)
    increments = chosen.increments_per_cycle or level.increments_per_cycle
    wear_increments = chosen.increments_per_wear_cycle or max(8, 4 * round(level.wear_increments * increments / 4.0))
    finest = min(line.fine_mm for body in (moving, fixed) for line in (body.axial, body.transverse))
    _require_stable_update(study, expected, finest, wear_increments)
    return Discretisation(
        moving=moving,
        fixed=fixed,
        bodies=(study.bodies[0].name, study.bodies[1].name),
        increments_per_cycle=increments,
        increments_per_wear_cycle=wear_increments,
        jump_tolerance=chosen.jump_tolerance or level.jump_tolerance,
        level=level,
        expected=expected,
        predicted_scar_half_width_mm=half_width,
        coarsening=coarsening,
    )


def _require_stable_update(study: Study, expected: ExpectedContact, element_mm: float, increments: int) -> None:
    """Refuse explicit cycle jumps beyond the stability limit."""
    wear = study.wear
    per_sliding = wear.volume_per_sliding_mm3_per_N_m(study.contact.friction) if wear else 0.0
    if wear is None or wear.explicit_jump_cycles is None or per_sliding == 0.0:
        return
    moving, fixed = (body.material for body in study.bodies)
    longest_step_mm = 1e-3 * study.conditions.displacement_amplitude_um * sin(2.0 * pi / increments)
    limit = explicit_stability_limit(
        element_mm, per_sliding, 1.0, contact_modulus(moving, fixed), longest_step_mm, plane=False
    ) / (wear.largest_factor * expected.wear_factors.largest)
    if wear.explicit_jump_cycles > limit:
        raise StudyError(
            f"explicit_jump_cycles = {wear.explicit_jump_cycles:g} in [wear] is unstable: on this mesh an explicit "
            f"update diverges beyond {limit:.3g} cycles; take at most {0.5 * limit:.2g}, "
            'or update = "implicit", which has no limit'
        )


def _level_of(study: Study, fidelity: str) -> WireLevel:
    """A level of fidelity with the study's refinement of the mesh, which also raises the number of unknowns allowed."""
    level, refinement = level_of(WIRE_LEVELS, fidelity), study.fidelity(fidelity).mesh_refinement
    return replace(level.coarser(1.0 / refinement), most_unknowns=round(level.most_unknowns * refinement**2))
