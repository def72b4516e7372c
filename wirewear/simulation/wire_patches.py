"""The finely meshed patch of each wire: how far it must reach, how fine it must be, and what that comes to."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

from geometry import GradedAxis, Layering, WireGeometry
from wirewear.errors import StudyError
from wirewear.simulation.contact_extents import Ellipse, PatchAxes, WireAxis, patch_axes
from wirewear.study import Study, Wire
from wirewear.study.fidelity import WireLevel

#: The predicted scar is enlarged by this factor to give the finely meshed patch.
SCAR_MARGIN = 1.2
_FRESH_MARGIN = 2.4
_FINE_MARGIN = 1.15
_COARSE_PER_DIAMETER = 0.155
_COARSENING_STEP = 1.05


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


def patch_zone(axis: WireAxis, contact: Ellipse, scar: Ellipse | None) -> tuple[float, float]:
    """Half-extent along an axis that a patch must have besides the travel, and the half-chord of what lies in it."""
    reach, chord = contact.reach(axis.angle_rad), contact.chord(axis.angle_rad)
    fresh = (_FRESH_MARGIN * reach, _FRESH_MARGIN * chord)
    if scar is None:
        return fresh
    worn = (
        SCAR_MARGIN * (scar.reach(axis.angle_rad) + 0.5 * reach),
        SCAR_MARGIN * (scar.chord(axis.angle_rad) + 0.5 * chord),
    )
    return max(fresh, worn)


def _graded(axis: WireAxis, narrowest_mm: float, sizes: Sizes, level: WireLevel) -> GradedAxis:
    chord = sizes.contact.chord(axis.angle_rad)
    wanted = narrowest_mm / level.per_contact_radius if sizes.contact_mm is None else sizes.contact_mm
    reach, zone_chord = patch_zone(axis, sizes.contact, sizes.scar)
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
