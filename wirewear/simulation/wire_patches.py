"""The finely meshed patch of each wire: how far it must reach, how fine it must be, and what that comes to."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, hypot, radians

from geometry import GradedAxis, Layering, WireGeometry
from wirewear.base.errors import StudyError
from wirewear.simulation.expected_contact import Ellipse, PatchAxes, WireAxis, patch_axes
from wirewear.study import Study, Wire
from wirewear.study.fidelity import WireLevel

#: The predicted scar is enlarged by this factor to give the finely meshed patch.
SCAR_MARGIN = 1.2
_FRESH_MARGIN = 2.4
_FINE_MARGIN = 1.15
# Beside the scar elements grow by this factor from one to the next, up to that multiple of those within.
_GROWTH_BESIDE = 1.3
_LARGEST_BESIDE = 2.5
_COARSE_PER_DIAMETER = 0.155
_COARSENING_STEP = 1.05


@dataclass(frozen=True)
class ElementSizes:
    """What patches have to resolve and to hold; lengths in mm.

    contact: the fresh one.  scar: held by the patch, None without wear.
    fresh: whether the contact is still about as small as the fresh one, which is then resolved where it goes.
    widening: of the patch beyond its need.
    contact_mm, outer_mm: element sizes that the study gives, the former across the contact's narrowest axis.
    """

    contact: Ellipse
    scar: Ellipse | None
    fresh: bool = True
    widening: float = 1.0
    contact_mm: float | None = None
    outer_mm: float | None = None


def unknowns(wire: WireGeometry) -> int:
    """Displacements of a wire's patch: the size of its condensed compliance."""
    return 3 * len(wire.axial.lines()) * len(wire.transverse.lines())


def affordable_wires(study: Study, sizes: ElementSizes, level: WireLevel) -> tuple[WireGeometry, WireGeometry, float]:
    """Meshes of the moving and the fixed wire, and by how much their elements are larger than the level asks for.

    ElementSizes that the study gives are kept whatever they cost.

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


def wire_geometries(study: Study, sizes: ElementSizes, level: WireLevel) -> tuple[WireGeometry, WireGeometry]:
    """Meshes of the moving and the fixed wire.

    Raises:
        StudyError: a patch would not fit on its wire.
    """
    on_moving, on_fixed = _with_equal_travel(*wire_axes(study)) if level.sticking else wire_axes(study)
    motion = radians(study.conditions.motion_angle_deg)
    return (
        _geometry(study.moving_wire, on_moving, sizes, level, motion, "moving"),
        _geometry(study.fixed_wire, on_fixed, sizes, level, motion, "fixed"),
    )


def _with_equal_travel(*wires: PatchAxes) -> tuple[PatchAxes, ...]:
    """The same axes with the largest travel on each: mesh lines are stretched to the patch's edge, and so alike."""
    travel = max(axis.travel_mm for wire in wires for axis in (wire.axial, wire.transverse))
    return tuple(
        PatchAxes(replace(wire.axial, travel_mm=travel), replace(wire.transverse, travel_mm=travel)) for wire in wires
    )


def needed_reach_mm(axis: WireAxis, contact: Ellipse, scar: Ellipse | None) -> float:
    """Half-extent along an axis that a patch must have besides the travel."""
    reach = contact.reach(axis.angle_rad)
    fresh = _FRESH_MARGIN * reach
    return fresh if scar is None else max(fresh, SCAR_MARGIN * (scar.reach(axis.angle_rad) + 0.5 * reach))


def _scar_element_mm(scar: Ellipse, motion_rad: float, axis_rad: float, level: WireLevel) -> float:
    """Spacing along an axis that resolves a scar; both angles are from the moving wire's axis.

    A bilinear interpolant errs by h² times the second derivative along each axis. That of the scar itself goes with
    1 / chord²; the band of contact adds one along the motion, of which an oblique axis sees the squared cosine.
    """
    scar_part = level.across_motion / scar.chord(axis_rad)
    band = max(level.along_motion**2 - level.across_motion**2, 0.0) ** 0.5 / scar.chord(motion_rad)
    return 1.0 / hypot(scar_part, band * cos(axis_rad - motion_rad))


def _graded(
    axis: WireAxis, narrowest_mm: float, sizes: ElementSizes, level: WireLevel, motion_rad: float
) -> GradedAxis:
    contact, scar, angle = sizes.contact, sizes.scar, axis.angle_rad
    finest = narrowest_mm / level.per_contact_radius if sizes.contact_mm is None else sizes.contact_mm
    fine = finest * contact.chord(angle) / narrowest_mm
    within = fine
    if sizes.outer_mm is not None:
        within = max(fine, sizes.outer_mm)
    elif scar is not None:
        within = max(fine, sizes.widening * _scar_element_mm(scar, motion_rad, angle, level))
    half = axis.travel_mm + sizes.widening * needed_reach_mm(axis, contact, scar)
    if sizes.fresh or scar is None:
        finely = axis.travel_mm + _FINE_MARGIN * contact.reach(angle)
        return GradedAxis(fine, min(finely, half), within, half)
    scarred = axis.travel_mm + sizes.widening * scar.reach(angle)
    return GradedAxis(within, min(scarred, half), _LARGEST_BESIDE * within, half, _GROWTH_BESIDE)


def _geometry(
    wire: Wire, axes: PatchAxes, sizes: ElementSizes, level: WireLevel, motion_rad: float, name: str
) -> WireGeometry:
    narrowest = min(sizes.contact.chord(axis.angle_rad) for axis in (axes.axial, axes.transverse))
    axial, transverse = (_graded(axis, narrowest, sizes, level, motion_rad) for axis in (axes.axial, axes.transverse))
    reach, limit = transverse.half_extent_mm, 0.42 * wire.diameter_mm
    if reach > limit:
        raise StudyError(
            f"the {name} wire is too thin for this test: the contact is expected to need {1e3 * reach:.0f} um to each "
            f"side of its crown, but at most {1e3 * limit:.0f} um of a wire of {wire.diameter_mm:g} mm can be meshed; "
            "lower the cycles, load, stroke or wear coefficient, or give a smaller scar_half_width_um in [mesh]"
        )
    shortest = 2.0 * axial.half_extent_mm / 0.9
    length = wire.length_mm or max(2.2 * wire.diameter_mm, shortest + wire.diameter_mm)
    if length < shortest:
        raise StudyError(
            f"length_mm = {length:g} of the {name} wire is too short: stroke and scar need at least {shortest:.3g} mm"
        )
    given, held = sizes.contact_mm, wire.grip_stiffness_N_per_mm3
    return WireGeometry(
        wire.diameter_mm,
        length,
        axial,
        transverse,
        _COARSE_PER_DIAMETER * wire.diameter_mm,
        grip_half_angle_rad=0.5 * radians(wire.grip_angle_deg),
        grip_half_length_mm=None if wire.grip_length_mm is None else 0.5 * wire.grip_length_mm,
        grip_stiffness_N_per_mm3=None if held == "rigid" else held,
        layering=Layering.resolving(level.per_contact_radius if given is None else narrowest / given),
    )
