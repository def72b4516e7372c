"""Meshes and steps of a run of a contact at a point: extent of the fine patches, sizes of their elements, increments.

A patch is the finely meshed part of a body's surface that may touch; its axes run along and across the body's axis. The
core is the part of a contact that sticks in its middle. Coarsening is the factor on element sizes that keeps to a
level's number of unknowns.
"""

from dataclasses import dataclass, replace
from math import ceil, cos, hypot, pi, radians, sin
from typing import Any

from geometry import BodyGeometry, GradedAxis, Layering, RimGradedAxis
from wirewear.base.errors import StudyError
from wirewear.reference import PointContact, contact_modulus, explicit_stability_limit, worn_under_load
from wirewear.results.scar import called
from wirewear.simulation.control import point_sticks
from wirewear.simulation.core_lines import fitted_to_core
from wirewear.simulation.expected_contact import (
    Ellipse,
    ExpectedContact,
    PatchAxes,
    PatchAxis,
    expected_contact,
    patch_axes,
)
from wirewear.test import Body, Study
from wirewear.test.fidelity import WIRE_LEVELS, WireLevel, level_of
from wirewear.test.own_bodies import StiffBody

#: The predicted scar is enlarged by this factor to give the finely meshed patch.
SCAR_MARGIN = 1.2


# Extent of the patch over that of a contact that sticks in its middle, without wear and with it, which widens it.
_STUCK_MARGIN, _WORN_MARGIN = 1.3, 1.6
_EDGE_MARGIN = 1.1  #: Extent of the patch over that of the worn annulus at its end.
_LEAST_RADIUS = 0.6  #: Of the contact under the test's load: elements are fitted to no smaller one within a cycle.
_EVENLY, _EVEN_MORE = 0.01, 1.25  #: Grading of lines that are spaced evenly, and how many more elements they need.


@dataclass(frozen=True)
class Discretisation:
    """Meshes of the driven (moving) and the held (fixed) body, and the steps of a run; lengths in mm.

    bodies: names (driven, held). level: of fidelity, refined as the study asks. expected: the contact and scar that the
    meshes are for. coarsening: factor by which elements are larger than the level asks for.
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
        return self.expected.hertz

    @property
    def unknowns(self) -> int:
        return unknowns(self.moving) + unknowns(self.fixed)

    def settings(self) -> dict[str, Any]:
        """The values that a result records of the discretisation, by key: sizes in µm, increments, Hertz's contact."""
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


def discretise(study: Study, fidelity: str, *, sticks: bool | None = None, core: float | None = None) -> Discretisation:
    """Meshes and steps of a study without variants at a level of fidelity.

    sticks: True if the contact sticks in its middle for good, None to find out. core: share (0 to 1) of the fresh
    contact's axes that sticks and that mesh lines are fitted to, None for any lines. Raises StudyError if the fine
    patch would not fit on a body, or the contact would leave it during the stroke.
    """
    level, chosen = level_of(WIRE_LEVELS, fidelity), study.fidelity(fidelity)
    # A finer mesh may have more unknowns.
    allowed = round(level.most_unknowns * chosen.mesh_refinement**2)
    level = replace(level.coarser(1.0 / chosen.mesh_refinement), most_unknowns=allowed)
    expected = expected_contact(study, sticks=sticks)
    if expected.sticks and (expected.face is None or study.wear is not None):
        level = level.for_sticking(wears=study.wear is not None, steady=study.drive.load.steady)
    elif not study.drive.load.steady and point_sticks(study, under_largest_load=True):
        # It slides as a whole at low loads alone, under which it is smaller, and dissipates most in partial slip.
        smaller = min(study.drive.load.least, 1.0) ** (1.0 / 3.0)
        per_radius = max(level.per_contact_radius, level.per_sticking_radius) / max(smaller, _LEAST_RADIUS)
        level = replace(level, per_contact_radius=per_radius)
    if not study.contact.friction_law.proportional:
        # Elements a radius over those under Coulomb's law, for laws of friction that bend with the pressure.
        level = replace(level, per_contact_radius=1.25 * level.per_contact_radius)
    if any(study.tables.coatings):
        # The edge of a contact on a coat then falls on a node, where it is best known.
        level = replace(level, per_contact_radius=ceil(level.per_contact_radius))
    if expected.face is not None:
        # Elements of a pad's contact over those of a ball's: at a flat's edge pressure rises within a fifth of its
        # radius.
        level = replace(level, per_contact_radius=2.5 * level.per_contact_radius)
    # Where pressures stop at a limit its edge lies within an element: those of the elastic contact hold it better.
    level = replace(level, per_contact_radius=expected.spread * level.per_contact_radius)
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
    half_width, finer_mm = needed if given is None else given * 1e-3, 1e-3 / chosen.mesh_refinement
    sizes = ElementSizes(
        fresh,
        scar,
        widening=half_width / needed,
        contact_mm=None if chosen.contact_mesh_um is None else chosen.contact_mesh_um * finer_mm,
        outer_mm=None if chosen.outer_mesh_um is None else chosen.outer_mesh_um * finer_mm,
        sticks=expected.sticks and follows(study, fidelity) and expected.face is None,
        stuck_margin=_STUCK_MARGIN if study.wear is None else _worn_margin(core, fresh),
        core=core,
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


def _worn_margin(core: float | None, fresh: Ellipse) -> float:
    """Extent of the patch over that of a fresh contact whose share `core` sticks in the end; None: not known yet."""
    if core is None:
        return _WORN_MARGIN
    # Patches that are not their own mirror image cost four times as much, and have no finer lines at the rim to go on.
    least = _STUCK_MARGIN if _lies_across(fresh, 0.0) else _WORN_MARGIN
    # Of a ball of radius 1 whose contact has radius 1.
    return max(least, _EDGE_MARGIN * worn_under_load(1.0, 1.0, 4.0 / 3.0, 1.0 - core**3).edge_radius_mm)


def follows(study: Study, fidelity: str) -> bool:
    """True if meshes may follow the scar: the study states no mesh sizes of its own, nor asks for one mesh, nor has a
    body of known stiffness, whose nodes are given.
    """
    chosen = study.fidelity(fidelity)
    given = (study.mesh.scar_half_width_um, chosen.contact_mesh_um, chosen.outer_mesh_um)
    may = study.mesh.follow_scar and not any(isinstance(body, StiffBody) for body in study.bodies)
    return may and all(size is None for size in given)


def _require_stable_update(study: Study, expected: ExpectedContact, element_mm: float, increments: int) -> None:
    """Raise StudyError for explicit cycle jumps beyond the stability limit."""
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


@dataclass(frozen=True)
class ElementSizes:
    """The contact that patches resolve, the scar that they hold (None without wear), and sizes that the study states;
    in mm.

    fresh: True while the contact is about as small as fresh, and is resolved along its whole path. widening: factor on
    the extent that a patch needs. contact_mm, outer_mm: stated sizes of the elements, across the contact's narrowest
    axis and the largest; None for none. sticks: True if the middle sticks; the patch then extends stuck_margin times as
    far as the rim. core: share of the contact's axes that sticks and whose area the nodes in it are to have; None for
    any.
    """

    contact: Ellipse
    scar: Ellipse | None
    fresh: bool = True
    widening: float = 1.0
    contact_mm: float | None = None
    outer_mm: float | None = None
    sticks: bool = False
    stuck_margin: float = _STUCK_MARGIN
    core: float | None = None


def unknowns(body: BodyGeometry) -> int:
    """Number of displacement components of a body's patch, three per node: the size of its condensed compliance."""
    return 3 * len(body.axial.lines()) * len(body.transverse.lines())


def affordable_meshes(study: Study, sizes: ElementSizes, level: WireLevel) -> tuple[BodyGeometry, BodyGeometry, float]:
    """(driven body's mesh, held body's, coarsening): the meshes that keep to the level's number of unknowns.
    Element sizes that the study states are kept at any cost. Raises StudyError if a patch would not fit on its body.
    """
    coarsening = 1.0
    moving, fixed = geometries(study, sizes, level)
    while sizes.contact_mm is None and max(unknowns(moving), unknowns(fixed)) > level.most_unknowns:
        coarsening *= 1.05
        moving, fixed = geometries(study, sizes, level.coarser(coarsening))
    return moving, fixed, coarsening


def axes_of(study: Study) -> tuple[PatchAxes, PatchAxes]:
    """(driven, held): axes of both bodies' patches, with the contact's travel along them."""
    stroke, (driven, held) = study.conditions.displacement_amplitude_um * 1e-3, study.bodies
    curvatures = _leading(driven), _leading(held)
    return patch_axes(stroke, radians(study.motion_angle_deg), curvatures, radians(study.crossing_angle_deg))


def _leading(body: Body) -> tuple[float, float]:
    """Curvatures by which a body moves the contact with it; a pad, which keeps the contact under itself, counts as
    curved.
    """
    return body.curvatures_per_mm if body.face is None else (1.0, 1.0)


def geometries(study: Study, sizes: ElementSizes, level: WireLevel) -> tuple[BodyGeometry, BodyGeometry]:
    """(driven, held): meshes for these sizes at this level. Raises StudyError if a patch would not fit on a body."""
    axes = _with_equal_travel(*axes_of(study)) if level.sticking else axes_of(study)
    motion = radians(study.motion_angle_deg)
    driven, held = (_geometry(*one, sizes, level, motion) for one in zip(study.bodies, axes, strict=True))
    return driven, held


def _with_equal_travel(*bodies: PatchAxes) -> tuple[PatchAxes, ...]:
    """These axes with the largest travel on each, so that the mesh lines of both bodies are scaled alike."""
    travel = max(axis.travel_mm for body in bodies for axis in (body.axial, body.transverse))
    return tuple(
        PatchAxes(replace(body.axial, travel_mm=travel), replace(body.transverse, travel_mm=travel)) for body in bodies
    )


def needed_reach_mm(axis: PatchAxis, contact: Ellipse, scar: Ellipse | None) -> float:
    """Half-extent in mm along an axis that a patch needs for the fresh contact and the scar (None without wear),
    besides the contact's travel.
    """
    reach = contact.reach(axis.angle_rad)
    fresh = 2.4 * reach
    return fresh if scar is None else max(fresh, SCAR_MARGIN * (scar.reach(axis.angle_rad) + 0.5 * reach))


def _scar_element_mm(scar: Ellipse, motion_rad: float, axis_rad: float, level: WireLevel) -> float:
    """Element size in mm along an axis that resolves a scar; both angles are from the driven body's axis.

    A bilinear interpolant errs by h² times the second derivative along each axis. That of the scar itself goes with 1 /
    chord²; the band of contact adds one along the motion, of which an oblique axis sees the squared cosine.
    """
    scar_part = level.across_motion / scar.chord(axis_rad)
    band = max(level.along_motion**2 - level.across_motion**2, 0.0) ** 0.5 / scar.chord(motion_rad)
    return 1.0 / hypot(scar_part, band * cos(axis_rad - motion_rad))


def _graded(
    axis: PatchAxis, narrowest_mm: float, sizes: ElementSizes, level: WireLevel, motion_rad: float
) -> GradedAxis | RimGradedAxis:
    contact, scar, angle = sizes.contact, sizes.scar, axis.angle_rad
    if sizes.sticks:
        return _graded_to_rim(contact, angle, sizes.stuck_margin, level, 1.0 if sizes.core else _EVEN_MORE)
    finest = narrowest_mm / level.per_contact_radius if sizes.contact_mm is None else sizes.contact_mm
    fine = finest * contact.chord(angle) / narrowest_mm
    within = fine
    if sizes.outer_mm is not None:
        within = max(fine, sizes.outer_mm)
    elif scar is not None:
        within = max(fine, sizes.widening * _scar_element_mm(scar, motion_rad, angle, level))
    half = axis.travel_mm + sizes.widening * needed_reach_mm(axis, contact, scar)
    if sizes.fresh or scar is None:
        finely = axis.travel_mm + 1.15 * contact.reach(angle)
        return GradedAxis(fine, min(finely, half), within, half)
    scarred = axis.travel_mm + sizes.widening * scar.reach(angle)
    # Outside the scar elements grow by 1.3 from one to the next, up to 2.5 times those inside.
    return GradedAxis(within, min(scarred, half), 2.5 * within, half, 1.3)


def _graded_to_rim(contact: Ellipse, axis_rad: float, margin: float, level: WireLevel, more: float) -> RimGradedAxis:
    """Mesh lines for a contact that sticks in its middle, fine at its rim if the ellipse lies along the axes."""
    rim, chord = contact.reach(axis_rad), contact.chord(axis_rad)
    if _lies_across(contact, axis_rad):
        # Of the rim: where the last of them lies. One that only touches it makes what slips a tenth too small at Q/µP
        # of 0.15, in the mean of ellipses at 12 to 30° by cells on a half-space.
        return RimGradedAxis(0.99 * rim, round(more * level.to_rim * rim / chord), margin * rim, _EVENLY)
    return RimGradedAxis(rim, round(level.to_rim), margin * rim, level.rim_share)


def _lies_across(contact: Ellipse, axis_rad: float) -> bool:
    """True if lines across a patch's axis cannot be fine at the contact's rim, along which it lies askew."""
    return contact.chord(axis_rad) < 0.95 * contact.reach(axis_rad)


def _geometry(body: Body, axes: PatchAxes, sizes: ElementSizes, level: WireLevel, motion_rad: float) -> BodyGeometry:
    narrowest = min(sizes.contact.chord(axis.angle_rad) for axis in (axes.axial, axes.transverse))
    axial, transverse = (_graded(axis, narrowest, sizes, level, motion_rad) for axis in (axes.axial, axes.transverse))
    if sizes.core is not None and isinstance(axial, RimGradedAxis) and isinstance(transverse, RimGradedAxis):
        axial, transverse = fitted_to_core((axial, transverse), sizes.contact, sizes.core, axes.axial.angle_rad)
    per_radius = level.per_contact_radius if sizes.contact_mm is None else narrowest / sizes.contact_mm
    # Elements a radius, over those to the rim, for which layers resolve the depth below.
    per_radius = 0.6 * level.to_rim if sizes.sticks else per_radius
    elongation = (sizes.contact.major_mm * sizes.contact.minor_mm) ** 0.5 / narrowest
    return body.geometry(axial, transverse, Layering.resolving(per_radius, max(1.0, elongation)))
