"""The finely meshed patch of each body: how far it must reach, how fine it must be, and what that comes to."""

from dataclasses import dataclass, replace
from math import cos, hypot, radians

from geometry import BodyGeometry, GradedAxis, Layering
from wirewear.simulation.expected_contact import Ellipse, PatchAxes, PatchAxis, patch_axes
from wirewear.study import Body, Study
from wirewear.study.fidelity import WireLevel

#: The predicted scar is enlarged by this factor to give the finely meshed patch.
SCAR_MARGIN = 1.2
_FRESH_MARGIN = 2.4
_FINE_MARGIN = 1.15
# Beside the scar elements grow by this factor from one to the next, up to that multiple of those within.
_GROWTH_BESIDE = 1.3
_LARGEST_BESIDE = 2.5
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


def unknowns(body: BodyGeometry) -> int:
    """Displacements of a body's patch: the size of its condensed compliance."""
    return 3 * len(body.axial.lines()) * len(body.transverse.lines())


def affordable_meshes(study: Study, sizes: ElementSizes, level: WireLevel) -> tuple[BodyGeometry, BodyGeometry, float]:
    """Meshes of the driven and the held body, and by how much their elements are larger than the level asks for.

    ElementSizes that the study gives are kept whatever they cost.
    Raises StudyError if a patch would not fit on its body.
    """
    coarsening = 1.0
    moving, fixed = geometries(study, sizes, level)
    while sizes.contact_mm is None and max(unknowns(moving), unknowns(fixed)) > level.most_unknowns:
        coarsening *= _COARSENING_STEP
        moving, fixed = geometries(study, sizes, level.coarser(coarsening))
    return moving, fixed, coarsening


def axes_of(study: Study) -> tuple[PatchAxes, PatchAxes]:
    """Axes of the patches of the driven and the held body."""
    stroke, (driven, held) = study.conditions.displacement_amplitude_um * 1e-3, study.bodies
    curvatures = _leading(driven), _leading(held)
    return patch_axes(stroke, radians(study.motion_angle_deg), curvatures, radians(study.crossing_angle_deg))


def _leading(body: Body) -> tuple[float, float]:
    """Curvatures by which a body leads the contact along; a pad keeps it under itself."""
    return body.curvatures_per_mm if body.face is None else (1.0, 1.0)


def geometries(study: Study, sizes: ElementSizes, level: WireLevel) -> tuple[BodyGeometry, BodyGeometry]:
    """Meshes of the driven and the held body. Raises StudyError if a patch would not fit on its body."""
    axes = _with_equal_travel(*axes_of(study)) if level.sticking else axes_of(study)
    motion = radians(study.motion_angle_deg)
    driven, held = (_geometry(*one, sizes, level, motion) for one in zip(study.bodies, axes, strict=True))
    return driven, held


def _with_equal_travel(*bodies: PatchAxes) -> tuple[PatchAxes, ...]:
    """The same axes with the largest travel on each: mesh lines are stretched to the patch's edge, and so alike."""
    travel = max(axis.travel_mm for body in bodies for axis in (body.axial, body.transverse))
    return tuple(
        PatchAxes(replace(body.axial, travel_mm=travel), replace(body.transverse, travel_mm=travel)) for body in bodies
    )


def needed_reach_mm(axis: PatchAxis, contact: Ellipse, scar: Ellipse | None) -> float:
    """Half-extent along an axis that a patch must have besides the travel."""
    reach = contact.reach(axis.angle_rad)
    fresh = _FRESH_MARGIN * reach
    return fresh if scar is None else max(fresh, SCAR_MARGIN * (scar.reach(axis.angle_rad) + 0.5 * reach))


def _scar_element_mm(scar: Ellipse, motion_rad: float, axis_rad: float, level: WireLevel) -> float:
    """Spacing along an axis that resolves a scar; both angles are from the driven body's axis.

    A bilinear interpolant is off by h² times the second derivative along each axis. That of the scar itself goes with
    1 / chord²; the band of contact adds one along the motion, of which an oblique axis sees the squared cosine.
    """
    scar_part = level.across_motion / scar.chord(axis_rad)
    band = max(level.along_motion**2 - level.across_motion**2, 0.0) ** 0.5 / scar.chord(motion_rad)
    return 1.0 / hypot(scar_part, band * cos(axis_rad - motion_rad))


def _graded(
    axis: PatchAxis, narrowest_mm: float, sizes: ElementSizes, level: WireLevel, motion_rad: float
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


def _geometry(body: Body, axes: PatchAxes, sizes: ElementSizes, level: WireLevel, motion_rad: float) -> BodyGeometry:
    narrowest = min(sizes.contact.chord(axis.angle_rad) for axis in (axes.axial, axes.transverse))
    axial, transverse = (_graded(axis, narrowest, sizes, level, motion_rad) for axis in (axes.axial, axes.transverse))
    per_radius = level.per_contact_radius if sizes.contact_mm is None else narrowest / sizes.contact_mm
    elongation = (sizes.contact.major_mm * sizes.contact.minor_mm) ** 0.5 / narrowest
    return body.geometry(axial, transverse, Layering.resolving(per_radius, max(1.0, elongation)))
