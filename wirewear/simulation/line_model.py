"""Meshes, steps and the contact problem of a line contact's study. Lengths in mm, forces and energies per mm of length.

A face is the profile of the pad along the motion; a patch is the finely meshed part of a body that may touch.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from math import asin, ceil, cos, inf, log, pi, sin, sqrt

import numpy as np

from geometry import (
    Cylinder,
    EdgeGradedAxis,
    Elastic,
    Flat,
    GradedAxis,
    PlanarGeometry,
    RingGeometry,
    RoundedFlat,
    TabledProfile,
    build_planar,
)
from solvers import ContactProblem, PlacedBody, PressureLimit, coated, condense, place
from wirewear import reference
from wirewear.base.errors import StudyError
from wirewear.results import PRESSURE_LENGTH
from wirewear.simulation.control import SlidingOnset, expected_to_stick
from wirewear.simulation.core_lines import core_of_line, even_lines
from wirewear.simulation.expected_contact import wear_factors
from wirewear.simulation.problem import laws_of, measured
from wirewear.simulation.yielding import pressure_limit, spread_by_yield
from wirewear.test.conditions import HolderTable
from wirewear.test.faces import Face, WIDEST_mm, half_width_of
from wirewear.test.fidelity import LINE_LEVELS, level_of
from wirewear.test.gaps import under_coats
from wirewear.test.study import LineStudy
from wirewear.test.surfaces import StatedSurface

_WIDEST_OF_PINS = 85.0 / 180.0 * pi  # In rad; a bore's patch reaches further.

_MARGIN, _UNWORN_MARGIN, _STUCK_MARGIN = 1.3, 1.15, 2.0

# Pressures of worn surfaces have a kink where neighbouring elements differ in size: 4 % of their mean at 1.2.
_GROWTH = 1.05

#: Radius of a contact at a point that feels a coating as a line contact does, over its half-width: it is then as wide
#: within 4 %, of coatings as in `Coating.felt`.
_AS_WIDE = 1.5


@dataclass(frozen=True)
class PinFace(Cylinder):
    """The face of a pin in a bore; lengths along it are measured around the pin."""

    bore_radius_mm: float = inf

    @property
    def clearance_mm(self) -> float:
        return self.bore_radius_mm - self.radius_mm


def _face_of(study: LineStudy) -> Face:
    """The face by which meshes are planned: of a pad, alike on both sides of its middle, or of a pin in a bore."""
    stated, bore = study.pad.profile, study.specimen.bore_radius_mm
    if isinstance(stated, Cylinder) and bore is not None:
        return PinFace(stated.radius_mm, curved_along=True, bore_radius_mm=bore)
    return stated.even if isinstance(stated, TabledProfile) else stated


def fresh_line_contact(
    face: Face, load_N_per_mm: float, modulus_MPa: float, pad_half_width_mm: float
) -> tuple[float, reference.LineContact]:
    """(`modulus_MPa` unchanged, the contact before any wear), between half-planes or of a pin in a bore. Raises
    ValueError if the pad is too narrow to carry the load.
    modulus_MPa: contact modulus E*; pad_half_width_mm: half of the pad's width.
    """
    if isinstance(face, PinFace):
        pin = reference.pin_in_bore(load_N_per_mm, face.radius_mm, face.bore_radius_mm, modulus_MPa)
        half_mm, peak_MPa = face.radius_mm * pin.half_angle_rad, float(pin.pressure(0.0))
        return modulus_MPa, reference.LineContact(load_N_per_mm, half_mm, peak_MPa)
    if isinstance(face, Cylinder):
        return modulus_MPa, reference.hertz_line(load_N_per_mm, face.radius_mm, modulus_MPa)
    return modulus_MPa, reference.even_line_contact(face, load_N_per_mm, modulus_MPa, pad_half_width_mm)


def edge_reach(face: Face, load_N_per_mm: float, modulus_MPa: float, contact: reference.LineContact) -> float:
    """Width in mm at the contact's edge over which pressure changes quickly. Of a flat with rounded edges, it is the
    half-width of the contact of one edge under the whole load; otherwise that of `contact`. modulus_MPa: contact
    modulus E*.
    """
    if isinstance(face, RoundedFlat):
        return sqrt(4.0 * load_N_per_mm * face.edge_radius_mm / (pi * modulus_MPa))
    return contact.half_width_mm


def farthest_contact(face: Face, reach_mm: float, tilt_rad: float, contact: reference.LineContact) -> float:
    """Distance in mm from the middle up to which a pad tilted by `tilt_rad` touches: where its face is as steep, plus
    `contact`'s half-width or, for a flat, reach_mm (`edge_reach`).
    """
    match face:
        case Cylinder(radius_mm=radius):
            return contact.half_width_mm + radius * tilt_rad
        case RoundedFlat(half_width_mm=flat, edge_radius_mm=radius):
            return flat + reach_mm + radius * tilt_rad
        case TabledProfile():
            x = np.linspace(0.0, face.reach_mm, 400)
            steep = -face.slope(np.column_stack([x, np.zeros_like(x)]))[:, 0] >= tilt_rad
            return contact.half_width_mm + float(x[steep][0] if steep.any() else x[-1])


def scar_half_width(face: Face, area_mm2: float, pad_half_width_mm: float) -> float:
    """Half-width in mm of the scar in gross slip that has the section `area_mm2` in both bodies together; 0 for no
    area.

    Raises ValueError if the pad is too narrow to hold it.
    """
    if area_mm2 <= 0.0:
        return 0.0
    if isinstance(face, PinFace):
        return reference.pin_scar(area_mm2, face.radius_mm, face.bore_radius_mm).half_width_mm
    if isinstance(face, Cylinder):
        return reference.line_contact_scar(area_mm2, face.radius_mm).half_width_mm
    return reference.even_line_scar(face, area_mm2, pad_half_width_mm).half_width_mm


def middle_of(face: RoundedFlat, reach_mm: float, moved_mm: float = 0.0) -> float:
    """Half-width in mm of the part of a flat contact that is away from both edges by reach_mm even once it has moved by
    `moved_mm`; at least a quarter of the flat's.
    """
    return max(face.half_width_mm - reach_mm - moved_mm, 0.25 * face.half_width_mm)


@dataclass(frozen=True)
class LinePlan:
    """Meshes of both bodies and the steps of a run of a line contact; lengths in mm. pressure_length_mm: over which
    pressures are averaged; hertz: the fresh contact.
    """

    pad: PlanarGeometry | RingGeometry
    specimen: PlanarGeometry | RingGeometry
    increments_per_cycle: int
    jump_tolerance: float
    pressure_length_mm: float
    hertz: reference.LineContact

    def settings(self) -> dict[str, object]:
        """The values that a result records of the plan, by key: sizes in µm, increments, the fresh contact."""
        return {
            "contact_mesh_um": 1e3 * self.pad.along.fine_mm,
            "outer_mesh_um": 1e3 * float(np.diff(self.pad.along.half_lines()).max()),
            "patch_half_width_um": 1e3 * self.pad.along.half_extent_mm,
            "increments_per_cycle": self.increments_per_cycle,
            "jump_tolerance": self.jump_tolerance,
            PRESSURE_LENGTH: 1e3 * self.pressure_length_mm,
            "hertz_half_width_um": 1e3 * self.hertz.half_width_mm,
            "hertz_pressure_MPa": self.hertz.peak_pressure_MPa,
            "pad": asdict(self.pad),
            "specimen": asdict(self.specimen),
        }


def line_plan(study: LineStudy, fidelity: str) -> LinePlan:
    """Meshes and steps of a line contact, for all blocks of its programme. The patch holds the scar that gross slip on
    a rigid rig would wear, and the contact of a pad that tilts as far as the stroke can tilt it, with a margin; on the
    specimen the stroke as well. Raises StudyError if the patch does not fit on a body.
    """
    driven = study.of_length(1.0).driven
    return _planned(driven.envelope, fidelity, [_sticks(own) for own in driven.schedule.studies])


def _planned(study: LineStudy, fidelity: str, sticking: Sequence[bool]) -> LinePlan:
    """The plan of one millimetre of an envelope study; sticking: for each block, True if the contact sticks in its
    middle.
    """
    level, mesh, conditions, stated = level_of(LINE_LEVELS, fidelity), study.mesh, study.conditions, study.pad.profile
    face = _face_of(study)
    load = conditions.drive.load.largest * conditions.normal_load_N
    stroke = 1e-3 * conditions.displacement_amplitude_um
    pad_half = study.pad.half_width_mm or half_width_of(face)
    try:
        modulus, fresh = under_coats(
            lambda *own: fresh_line_contact(face, load, reference.contact_modulus(*own), pad_half),
            (study.specimen.elastic, study.pad.elastic),
            study.tables.coatings,
            lambda found: _AS_WIDE * found[1].half_width_mm,
        )
        reach = edge_reach(face, load, modulus, fresh)
        predicted = _predicted(study, face, fresh.half_width_mm, pad_half)
    except ValueError as problem:
        raise StudyError(f"the pad is too narrow for this test: {problem}; give it more half_width_mm.") from None
    tilted = farthest_contact(face, reach, _largest_tilt(study.holder, stroke), fresh)
    spread = spread_by_yield(limit_of_lines(study, fresh), load, fresh.peak_pressure_MPa, line=True)
    wears, fits = max(study.energy_coefficients()) > 0.0 or _lacking(study) > 0.0, _lacking(study) == 0.0
    sticks = all(sticking) and fits and mesh.contact_mesh_um is None
    to_rim = level.to_rim_worn if wears else level.to_rim
    per_contact = to_rim if any(sticking) and fits else level.per_contact
    if mesh.scar_half_width_um is not None:
        half = 1e-3 * mesh.scar_half_width_um
    elif isinstance(face, RoundedFlat):
        half = face.half_width_mm + _UNWORN_MARGIN * spread * (tilted - face.half_width_mm)
        half = max(half, predicted) if wears and not sticks else half
    elif sticks:
        half = (_UNWORN_MARGIN if not wears else _STUCK_MARGIN) * spread * tilted
    else:
        half = max(predicted if wears else 0.0, _UNWORN_MARGIN * spread * tilted)
    finer = mesh.mesh_refinement
    fine = (1e-3 * mesh.contact_mesh_um if mesh.contact_mesh_um is not None else reach / per_contact) / finer

    around = sticks and wears and len(sticking) == 1
    core = core_of_line(study, lambda own: fresh_line_contact(face, own, modulus, pad_half)[1]) if around else None

    def along(half: float, moved: float = 0.0) -> GradedAxis | EdgeGradedAxis:
        if isinstance(face, RoundedFlat) or not wears or sticks:
            even = middle_of(face, reach, moved) if isinstance(face, RoundedFlat) else 0.0
            return even_lines(fine, half + moved, even, core)
        fine_to = min(1.5 * fresh.half_width_mm + moved, half + moved)
        return GradedAxis(fine, fine_to, max(fine, half / (finer * level.per_scar)), half + moved, _GROWTH)

    pad: PlanarGeometry | RingGeometry
    specimen: PlanarGeometry | RingGeometry
    if isinstance(face, PinFace):
        pad, specimen = _rings(study, face, half, along)
    else:
        specimen_half = study.specimen.half_width_mm or max(WIDEST_mm, 1.5 * (half + stroke))
        for name, room, needed in (("pad", pad_half, half), ("specimen", specimen_half, half + stroke)):
            remedy = f"lower cycles, stroke or wear, or give a wider {name}"
            _require_room(name, "half_width_mm", needed, room, remedy)
        far = mesh.far_mesh_mm / finer
        pad = study.pad.held(PlanarGeometry(stated, pad_half, study.pad.height_mm, along(half), far))
        specimen = study.specimen.held(
            PlanarGeometry(Flat(), specimen_half, study.specimen.height_mm, along(half, stroke), far)
        )
        pad, specimen = _around(study, pad, specimen)
    increments = mesh.increments_per_cycle or level.increments_per_cycle
    length = study.log.pressure_length_um
    return LinePlan(
        pad=pad,
        specimen=specimen,
        increments_per_cycle=4 * ceil(mesh.increments_refinement * increments / 4),
        jump_tolerance=mesh.jump_tolerance or level.jump_tolerance,
        # What elements are sized by, eight at quick: half the contact's width, or the reach of a rounded flat's edge.
        pressure_length_mm=reach if length is None else 1e-3 * length,
        hertz=fresh,
    )


def _rings(
    study: LineStudy, face: PinFace, half_mm: float, along: Callable[..., GradedAxis | EdgeGradedAxis]
) -> tuple[RingGeometry, RingGeometry]:
    """Pin and plate with a bore for a contact that reaches `half_mm` around the pin at mid-stroke.

    A pin that moves by s in a clearance c bears at ψ = asin(s/c) beside the middle, and as it climbs is pressed there
    by P/(cos ψ − µ sin ψ). The bore's patch reaches further by the stroke. Raises StudyError if the pin would wedge
    itself, or bear further around than can be meshed.
    """
    stroke = 1e-3 * study.conditions.displacement_amplitude_um
    pin_mm, bore_mm = face.radius_mm, face.bore_radius_mm
    moved = asin(min(stroke / face.clearance_mm, 1.0))
    pressed = cos(moved) - study.contact.friction * sin(moved)
    # Share of the pressing against the wall that carries the load: at least a tenth.
    if moved > _WIDEST_OF_PINS or pressed <= 0.1:
        raise StudyError(
            f"a pin that moves by {1e3 * stroke:g} um in a clearance of {1e3 * face.clearance_mm:g} um wedges itself "
            "against the wall of the bore: lower the stroke or friction, or give a wider bore"
        )
    angle = min(half_mm / pin_mm / sqrt(pressed) + moved, _WIDEST_OF_PINS)
    further = bore_mm * asin((pin_mm * sin(angle) + stroke) / bore_mm) - pin_mm * angle
    # Radii of a pin between its surface and its core, at most.
    pin = RingGeometry(pin_mm, min(study.pad.height_mm, 0.9 * pin_mm), along(pin_mm * angle))
    return study.pad.held(pin), study.specimen.held(
        RingGeometry(-bore_mm, study.specimen.height_mm, along(pin_mm * angle, further))
    )


def _around(study: LineStudy, hub: PlanarGeometry, shaft: PlanarGeometry) -> tuple[PlanarGeometry, PlanarGeometry]:
    """Both as rings if the study states a shaft, otherwise unchanged. Of a taper, the shaft is held at its wide end and
    the hub at its narrow one.
    """
    own, rise = study.specimen, study.specimen.taper
    if (radius := own.shaft_radius_mm) is None:
        return hub, shaft
    end = 1 if rise >= 0.0 else -1
    return (
        replace(hub, axis_mm=radius, rise=-rise, held_end=-end),
        replace(shaft, height_mm=min(own.height_mm, radius), axis_mm=-radius, rise=rise, held_end=end),
    )


def placed_body(
    geometry: PlanarGeometry | RingGeometry, material: Elastic, *, upper: bool, surface: StatedSurface | None = None
) -> PlacedBody:
    """A body meshed, condensed and placed. upper: True for the pad. surface: measured before the test, or None."""
    meshed = build_planar(geometry)
    body = condense(meshed.mesh, meshed.patch, material, bedding=meshed.bedding)
    placed = place(measured(body, surface, 0.0, upper=upper), upper=upper, axis_angle_rad=0.0)
    if isinstance(geometry, PlanarGeometry) and geometry.rise:
        return replace(placed, incline=-geometry.rise if upper else geometry.rise)
    return placed


def bodies(study: LineStudy, meshes: LinePlan) -> tuple[PlacedBody, PlacedBody]:
    """(pad, specimen), meshed, condensed and placed."""
    pad, specimen = study.pad, study.specimen
    upper = placed_body(meshes.pad, pad.elastic, upper=True, surface=pad.surface)
    return upper, placed_body(meshes.specimen, specimen.elastic, upper=False, surface=specimen.surface)


def bodies_stiffness_N_per_mm2(study: LineStudy) -> float:
    """Stiffness along the motion of pad and specimen in series, between where they are held, per mm of length.

    The traction is even over the width of the fresh contact. Raises StudyError if the patch does not fit on a body.
    """
    meshes = _planned(study.of_length(1.0).driven.envelope, "quick", (False,))
    compliance = 0.0
    for body in bodies(study, meshes):
        share = body.node_areas * (np.abs(body.node_positions[:, 0]) <= meshes.hertz.half_width_mm)
        share = share / share.sum()
        compliance += float(share @ body.compliance[::3, ::3] @ share)
    return 1.0 / compliance


def _sticks(study: LineStudy) -> bool:
    """True if the contact of a study of one block is expected to stick in its middle."""
    return expected_to_stick(study, partial(_onset, study))


def _onset(study: LineStudy, friction_N: float) -> SlidingOnset:
    """Force, motion, slip and energy at which a line contact just slides: of half-planes, and of the bodies for the
    motion.
    """
    own = study.pad.elastic, study.specimen.elastic
    spread = friction_N / pi * sum((1.0 - each.poissons_ratio) / each.shear_modulus_MPa for each in own)
    return SlidingOnset(
        friction_N,
        500.0 * log(2.0) * spread,
        friction_N * spread,
        lambda: 1e3 * friction_N / bodies_stiffness_N_per_mm2(study),
    )


def limit_of_lines(study: LineStudy, hertz: reference.LineContact) -> PressureLimit | None:
    """Pressure limit, from a study of 1 mm and the elastic contact `hertz`; None if no body yields."""
    conditions = study.envelope.conditions
    load = conditions.drive.load.largest * conditions.normal_load_N
    return pressure_limit(study, load, hertz.peak_pressure_MPa, (hertz.half_width_mm, inf), power=2.0)


def line_problem(study: LineStudy, pad: PlacedBody, specimen: PlacedBody) -> ContactProblem:
    """The contact problem of the pad on its rig above the specimen, without effects."""
    of_specimen, of_pad = study.tables.coatings
    return ContactProblem(upper=coated(pad, of_pad, of_specimen), lower=specimen, **laws_of(study))


def _largest_tilt(rig: HolderTable, stroke_mm: float) -> float:
    """Tilt in rad of a pad that rotates with the whole stroke."""
    if rig.rotational_stiffness_N_mm_per_rad == "rigid" or rig.pivot_height_mm is None:
        return 0.0
    return stroke_mm / rig.pivot_height_mm


def _predicted(study: LineStudy, face: Face, contact_mm: float, pad_half_mm: float) -> float:
    """Half-width in mm of the patch for the final scar in gross slip on a rigid rig, with a margin."""
    conditions = study.conditions
    energy_mJ = (
        4e-3
        * study.contact.friction
        * conditions.drive.mean_load
        * conditions.normal_load_N
        * conditions.displacement_amplitude_um
        * conditions.cycles
    )
    factors = wear_factors(study.effects, study.contact.friction, conditions.normal_load_N, float(conditions.cycles))
    area = 1e-3 * sum(study.energy_coefficients()) * energy_mJ * factors.beyond_margin + _lacking(study)
    scar = scar_half_width(face, area, pad_half_mm)
    # A flat that loses more than the pad is worn beyond the pad's scar by the stroke.
    stroke = 1e-3 * conditions.displacement_amplitude_um if area > 0.0 else 0.0
    if isinstance(face, RoundedFlat):
        return face.half_width_mm + _MARGIN * (max(scar, contact_mm) + 0.5 * stroke - face.half_width_mm)
    return _MARGIN * max(2.0 * contact_mm, scar + contact_mm + 0.5 * stroke)


def _lacking(study: LineStudy) -> float:
    """Area in mm² that the sections of both bodies lacked when they were measured before the test."""
    surfaces = (study.pad.surface, study.specimen.surface)
    return sum(surface.area_mm2 for surface in surfaces if surface is not None)


def _require_room(body: str, key: str, needed_mm: float, half_width_mm: float, remedy: str) -> None:
    """Raise StudyError if a body is too narrow for a contact that needs `needed_mm` to each side of its middle.

    The message names the key and ends with the remedy.
    """
    if needed_mm >= half_width_mm:
        raise StudyError(
            f"the {body} is too narrow for this test: the contact is expected to need {needed_mm:.3g} mm to each side "
            f"of its middle, but {key} is {half_width_mm:.3g}; {remedy}"
        )
