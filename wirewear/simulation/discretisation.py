"""From a study to meshes and steps: where the contact will be, how fine it must be resolved, and what that comes to."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from math import pi, radians, sin
from typing import Any

from geometry import GradedAxis, Layering, WireGeometry
from wirewear.errors import StudyError
from wirewear.reference import PointContact, contact_modulus, explicit_stability_limit
from wirewear.simulation.contact_extents import Ellipse, PatchAxes, WireAxis, fresh_ellipse, patch_axes
from wirewear.simulation.expected_contact import fresh_contact, predicted_scar
from wirewear.simulation.expected_wear import wear_factors_of
from wirewear.study import Study, Wire
from wirewear.study.fidelity import WIRE_LEVELS, WireLevel

# The predicted scar is enlarged by this factor to give the finely meshed patch.
_SCAR_MARGIN = 1.2
_FRESH_MARGIN = 2.4
_FINE_MARGIN = 1.15
_COARSE_PER_DIAMETER = 0.155
_COARSENING_STEP = 1.05


@dataclass(frozen=True)
class Discretisation:
    """Meshes of both wires and the steps of a run; lengths in mm.

    coarsening: by how much elements are larger than the level asks for, to keep the patches to its number of unknowns.
    """

    moving: WireGeometry
    fixed: WireGeometry
    increments_per_cycle: int
    increments_per_wear_cycle: int
    jump_tolerance: float
    hertz: PointContact
    predicted_scar_half_width_mm: float
    coarsening: float = 1.0

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
            "moving_wire": asdict(self.moving),
            "fixed_wire": asdict(self.fixed),
        }


def discretise(study: Study, fidelity: str) -> Discretisation:
    """Meshes and steps of a study at a level of fidelity.

    Raises:
        StudyError: the fine patch would not fit on a wire, or the contact would leave it during the stroke.
    """
    level, chosen = level_of(study, fidelity), study.fidelity(fidelity)
    hertz = fresh_contact(study)
    fresh, scar = fresh_ellipse(hertz), predicted_scar(study)
    axes = wire_axes(study)
    needed = max(_zone(axis, fresh, scar)[0] for wire in axes for axis in (wire.axial, wire.transverse))
    given = study.mesh.scar_half_width_um
    if given is not None and given * 1e-3 < needed / _SCAR_MARGIN:
        raise StudyError(
            f"scar_half_width_um = {given:g} in [mesh] is too small: the contact is expected to grow to "
            f"{1e3 * needed / _SCAR_MARGIN:.0f} um on each side and would leave the finely meshed patch during the "
            f"stroke; give at least {1e3 * needed:.0f}, or leave the key out"
        )
    half_width = needed if given is None else given * 1e-3
    sizes = Sizes(
        fresh,
        scar,
        half_width / needed,
        None if chosen.contact_mesh_um is None else chosen.contact_mesh_um * 1e-3,
        None if chosen.outer_mesh_um is None else chosen.outer_mesh_um * 1e-3,
    )
    moving, fixed, coarsening = affordable_wires(study, sizes, level)
    increments = chosen.increments_per_cycle or level.increments_per_cycle
    wear_increments = chosen.increments_per_wear_cycle or max(8, 4 * round(level.wear_increments * increments / 4.0))
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
        coarsening=coarsening,
    )


def _require_stable_update(study: Study, element_mm: float, increments: int) -> None:
    """Refuse explicit cycle jumps beyond the stability limit."""
    wear = study.wear
    per_sliding = wear.volume_per_sliding_mm3_per_N_m(study.contact.friction) if wear else 0.0
    if wear is None or wear.explicit_jump_cycles is None or per_sliding == 0.0:
        return
    moving, fixed = (wire.material for wire in (study.moving_wire, study.fixed_wire))
    longest_step_mm = 1e-3 * study.conditions.displacement_amplitude_um * sin(2.0 * pi / increments)
    limit = explicit_stability_limit(
        element_mm, per_sliding, 1.0, contact_modulus(moving, fixed), longest_step_mm, plane=False
    ) / (max((factor for _, factor in wear.variation_points), default=1.0) * wear_factors_of(study).largest)
    if wear.explicit_jump_cycles > limit:
        raise StudyError(
            f"explicit_jump_cycles = {wear.explicit_jump_cycles:g} in [wear] is unstable: on this mesh an explicit "
            f"update diverges beyond {limit:.3g} cycles; take at most {0.5 * limit:.2g}, "
            'or update = "implicit", which has no limit'
        )


@dataclass(frozen=True)
class Sizes:
    """What patches have to resolve and to hold; lengths in mm.

    contact: resolved finely.  scar: held by the patch, None without wear.  widening: of the patch beyond its need.
    contact_mm, outer_mm: element sizes that the study gives, the former across the contact's narrowest axis.
    """

    contact: Ellipse
    scar: Ellipse | None
    widening: float = 1.0
    contact_mm: float | None = None
    outer_mm: float | None = None


def unknowns(wire: WireGeometry) -> int:
    """Displacements of a wire's patch: the size of its condensed compliance."""
    return 3 * len(wire.axial.lines()) * len(wire.transverse.lines())


def level_of(study: Study, fidelity: str) -> WireLevel:
    """A level of fidelity with the study's refinement of the mesh, which also raises the number of unknowns allowed."""
    level, refinement = WIRE_LEVELS[fidelity], study.fidelity(fidelity).mesh_refinement
    return replace(level.coarser(1.0 / refinement), most_unknowns=round(level.most_unknowns * refinement**2))


def affordable_wires(study: Study, sizes: Sizes, level: WireLevel) -> tuple[WireGeometry, WireGeometry, float]:
    """Meshes of the moving and the fixed wire, and by how much their elements are larger than the level asks for.

    Sizes that the study gives are kept whatever they cost.

    Raises:
        StudyError: a patch would not fit on its wire.
    """
    coarsening = 1.0
    moving, fixed = wire_geometries(study, sizes, level)
    while sizes.contact_mm is None and max(unknowns(moving), unknowns(fixed)) > level.most_unknowns:
        coarsening *= _COARSENING_STEP
        moving, fixed = wire_geometries(study, sizes, level.coarser(coarsening))
    return moving, fixed, coarsening


def wire_axes(study: Study) -> tuple[PatchAxes, PatchAxes]:
    """Axes of the patches of the moving and the fixed wire; the moving wire moves along itself."""
    stroke = study.conditions.displacement_amplitude_um * 1e-3
    return patch_axes(stroke, radians(study.conditions.motion_angle_deg), radians(study.wires.crossing_angle_deg))


def wire_geometries(study: Study, sizes: Sizes, level: WireLevel) -> tuple[WireGeometry, WireGeometry]:
    """Meshes of the moving and the fixed wire.

    Raises:
        StudyError: a patch would not fit on its wire.
    """
    on_moving, on_fixed = wire_axes(study)
    return (
        _geometry(study.moving_wire, on_moving, sizes, level, "moving"),
        _geometry(study.fixed_wire, on_fixed, sizes, level, "fixed"),
    )


def _zone(axis: WireAxis, contact: Ellipse, scar: Ellipse | None) -> tuple[float, float]:
    """Half-extent along an axis that a patch must have besides the travel, and the half-chord of what lies in it."""
    reach, chord = contact.reach(axis.angle_rad), contact.chord(axis.angle_rad)
    fresh = (_FRESH_MARGIN * reach, _FRESH_MARGIN * chord)
    if scar is None:
        return fresh
    worn = (
        _SCAR_MARGIN * (scar.reach(axis.angle_rad) + 0.5 * reach),
        _SCAR_MARGIN * (scar.chord(axis.angle_rad) + 0.5 * chord),
    )
    return max(fresh, worn)


def _graded(axis: WireAxis, narrowest_mm: float, sizes: Sizes, level: WireLevel) -> GradedAxis:
    chord = sizes.contact.chord(axis.angle_rad)
    wanted = narrowest_mm / level.per_contact_radius if sizes.contact_mm is None else sizes.contact_mm
    reach, zone_chord = _zone(axis, sizes.contact, sizes.scar)
    half = axis.travel_mm + sizes.widening * reach
    fine = wanted * chord / narrowest_mm
    outer = max(fine, sizes.widening * zone_chord / level.per_scar if sizes.outer_mm is None else sizes.outer_mm)
    finely = axis.travel_mm + _FINE_MARGIN * sizes.contact.reach(axis.angle_rad)
    return GradedAxis(fine, min(finely, half), outer, half)


def _geometry(wire: Wire, axes: PatchAxes, sizes: Sizes, level: WireLevel, name: str) -> WireGeometry:
    narrowest = min(sizes.contact.chord(axis.angle_rad) for axis in (axes.axial, axes.transverse))
    axial, transverse = (_graded(axis, narrowest, sizes, level) for axis in (axes.axial, axes.transverse))
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
    return WireGeometry(
        wire.diameter_mm,
        length,
        axial,
        transverse,
        _COARSE_PER_DIAMETER * wire.diameter_mm,
        layering=Layering.resolving(sizes.contact.chord(axes.transverse.angle_rad) / transverse.fine_mm),
    )
