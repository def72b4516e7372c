"""The expected contact and scar of a study, for its meshes, and the pressure that its bodies bear at most.

Also estimates of how well laws that depend on pressure or on the distance from the edge are integrated over a contact
of few elements. The gap between unworn bodies is Ax² + By²; angles are about the normal from the driven body's axis. A
face is the profile of a pad.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, hypot, nan, pi, radians, sin, sqrt

import numpy as np

from geometry import Flat, LoweredSurface
from geometry.arrays import Array, BoolArray
from solvers import Archard, ContactProblem, ContactState, Coulomb, EnergyLaw, WearRates
from solvers.contact.between_nodes import SpreadPressure
from wirewear import reference
from wirewear.effects import Age, AnyEffect, ContactLaw, Loading, Seam, Specimens, applied
from wirewear.results import BORNE, BORNE_IS
from wirewear.results.scar import called
from wirewear.simulation.control import point_sticks
from wirewear.simulation.yielding import limit_of_points, spread_by_yield
from wirewear.test import AnyStudy, Study
from wirewear.test.faces import Face, half_width_of
from wirewear.test.gaps import Gap, hertz_of, on_pad
from wirewear.test.life import TENSILE_STRENGTH, LifeTable
from wirewear.test.surfaces import StatedSurface

# Effects may add this factor to the worn volume before the patch grows: 8 % of its half-width in 3D. Runs with and
# without effects that fit into the margin have the same meshes and differ by nothing else.
_MARGIN = 1.35
_AGES = 200

#: Curvatures A ≤ B of the gap Ax² + By² in 1/mm, and the angle of its x axis from the driven body's.
GapCurvatures = tuple[float, float, float]


#: Hardness over yield strength, the mean pressure of full plasticity (Tabor, The Hardness of Metals (1951)), which
#: local pressures hardly exceed.
_FULLY_PLASTIC = 2.8


@dataclass(frozen=True)
class Ellipse:
    """Outline of a contact or scar, centred on the first contact: semi-axes, and angle of the major one."""

    major_mm: float
    minor_mm: float
    angle_rad: float

    def reach(self, axis_rad: float) -> float:
        """Half of the ellipse's extent in mm along the axis at angle `axis_rad` (half of its bounding box)."""
        c, s = cos(axis_rad - self.angle_rad), sin(axis_rad - self.angle_rad)
        return hypot(self.major_mm * c, self.minor_mm * s)

    def chord(self, axis_rad: float) -> float:
        """Half of the chord in mm through the centre at angle `axis_rad`: the length over which pressure varies along
        it. A bilinear interpolant of spacing h along each axis errs by h² times the second derivative along that axis,
        which for pressure and gap is proportional to 1 / chord²; the mixed derivative costs nothing.
        """
        c, s = cos(axis_rad - self.angle_rad), sin(axis_rad - self.angle_rad)
        return 1.0 / hypot(c / self.major_mm, s / self.minor_mm)

    def enlarged(self, factor: float) -> "Ellipse":
        """An ellipse with both semi-axes multiplied by `factor`."""
        return Ellipse(self.major_mm * factor, self.minor_mm * factor, self.angle_rad)


@dataclass(frozen=True)
class PatchAxis:
    """One axis of a body's patch: its angle, and how far the contact's centre moves along it to each side."""

    angle_rad: float
    travel_mm: float


@dataclass(frozen=True)
class PatchAxes:
    """The axes of a body's patch: along the body's axis (axial) and across it (transverse)."""

    axial: PatchAxis
    transverse: PatchAxis


def fresh_ellipse(hertz: reference.PointContact) -> Ellipse:
    """Outline of Hertz's contact of the unworn bodies."""
    return Ellipse(hertz.major_semi_axis_mm, hertz.minor_semi_axis_mm, hertz.major_angle_rad)


def scar_ellipse(volume_mm3: float, gap: GapCurvatures) -> Ellipse:
    """Outline of the scar of a worn volume (both bodies together): the gap Ax² + By² cut off by a plane. gap: (A, B,
    angle). The cap of depth d has the semi-axes sqrt(d/A), sqrt(d/B) and the volume pi d² / (2 sqrt(AB)); for wires of
    equal radius R crossed at right angles the scar's radius is (4 R V / pi)^(1/4).
    """
    small, large, angle = gap
    depth = (2.0 * volume_mm3 * (small * large) ** 0.5 / pi) ** 0.5
    return Ellipse((depth / small) ** 0.5, (depth / large) ** 0.5, angle)


def scar_outline(volume_mm3: float, gap: GapCurvatures, face: Face | None) -> Ellipse:
    """Outline of the scar of a worn volume of both bodies: `scar_ellipse`, or under a pad (`face`) a circle.
    Raises StudyError if the pad is too small for it.
    """
    if face is None:
        return scar_ellipse(volume_mm3, gap)
    radius = on_pad(lambda: reference.turned_scar(face, volume_mm3, half_width_of(face)))
    return Ellipse(radius, radius, 0.0)


def patch_axes(
    stroke_mm: float,
    direction_rad: float,
    curvatures_per_mm: tuple[tuple[float, float], tuple[float, float]],
    crossing_rad: float,
) -> tuple[PatchAxes, PatchAxes]:
    """(driven, held): axes of both bodies' patches, with the contact's travel along them.

    stroke_mm: amplitude of the driven body. direction_rad: angle of its motion; crossing_rad: of the held body's axis.
    curvatures_per_mm: (along, across) of each body. Bodies of curvatures K and L touch where their surfaces are
    parallel: displaced by d, K (x - d) + L x = 0. So a wire that moves along itself moves the contact on itself only,
    and under a ball the contact moves on the flat.
    """
    turn = np.array([[cos(crossing_rad), -sin(crossing_rad)], [sin(crossing_rad), cos(crossing_rad)]])
    own, other = np.diag(curvatures_per_mm[0]), turn @ np.diag(curvatures_per_mm[1]) @ turn.T
    moved = stroke_mm * np.array([cos(direction_rad), sin(direction_rad)])
    on_held = np.linalg.solve(own + other, own @ moved)
    # Travel that round-off alone makes is none.
    driven, held = (np.abs(np.round(travel, 14)) for travel in (on_held - moved, turn.T @ on_held))
    return (
        PatchAxes(PatchAxis(0.0, float(driven[0])), PatchAxis(0.5 * pi, float(driven[1]))),
        PatchAxes(PatchAxis(crossing_rad, float(held[0])), PatchAxis(crossing_rad + 0.5 * pi, float(held[1]))),
    )


@dataclass(frozen=True)
class WearFactors:
    """Mean and largest factor by which effects change the wear per cycle in gross slip, over the cycles of a test."""

    mean: float
    largest: float

    @property
    def beyond_margin(self) -> float:
        """Factor on the worn volume for which a mesh must have more room; 1 if its margin of 35 % suffices."""
        return max(self.mean / _MARGIN, 1.0)


def wear_factors(effects: Sequence[AnyEffect], friction: float, load_N: float, cycles: float) -> WearFactors:
    """Factors of effects on the wear per cycle, over `cycles` cycles, relative to the nominal friction coefficient and
    load; 1 without effects or friction.
    """
    if not effects or friction * load_N == 0.0:
        return WearFactors(1.0, 1.0)
    nominal = ContactLaw(friction), Loading(load_N)
    factors = [_work(effects, *nominal, Age(n, 0.0)) for n in np.linspace(0.0, cycles, _AGES)]
    return WearFactors(float(np.mean(factors)) / (friction * load_N), max(factors) / (friction * load_N))


def _work(effects: Sequence[AnyEffect], contact: ContactLaw, loading: Loading, age: Age) -> float:
    """Friction force in N times the factor on the wear coefficient, at an age of the test."""
    friction = applied(effects, Seam.CONTACT, contact, age).friction
    load = applied(effects, Seam.LOADING, loading, age).normal_load_N
    return friction * load * applied(effects, Seam.WEAR, WearRates(1.0, 1.0), age).upper_mm3_per_mJ


@dataclass(frozen=True)
class ExpectedContact:
    """The expected contact of the unworn bodies, and scar of the worn ones, from which meshes are sized.

    gap: of the unworn bodies, under a pad that of a ball with as large a contact. scar: its final outline in gross slip
    on a rigid rig, None without wear. flattened_mm3, lacking_mm3: volume of both bodies that an effect removes before
    the first cycle, and that measured surfaces lack. sticks: True if the middle sticks for good. face: of a pad, else
    None. spread: size of the fresh contact over Hertz's, above 1 if bodies yield.
    """

    gap: GapCurvatures
    hertz: reference.PointContact
    scar: Ellipse | None
    flattened_mm3: float
    wear_factors: WearFactors
    sticks: bool = False
    face: Face | None = None
    lacking_mm3: float = 0.0
    spread: float = 1.0

    @property
    def fresh(self) -> Ellipse:
        """Outline of the fresh contact, larger than Hertz's if bodies yield."""
        return fresh_ellipse(self.hertz).enlarged(self.spread)

    def scar_half_width_mm(self, worn_volume_mm3: float) -> float:
        """Largest half-width in mm of the scar once both bodies have lost this volume; at least the fresh contact's."""
        missing = worn_volume_mm3 + self.lacking_mm3
        if missing <= 0.0:
            return self.fresh.major_mm
        return max(self.fresh.major_mm, scar_outline(missing, self.gap, self.face).major_mm)


def expected_contact(study: Study, *, sticks: bool | None = None) -> ExpectedContact:
    """The expected contact and scar of a study. sticks: True if the contact sticks in its middle for good, None to find
    out.
    Raises StudyError if a pad is too small for its contact or scar.
    """
    driven, held = study.bodies
    gap = reference.gap_curvatures(driven.curvatures_per_mm, held.curvatures_per_mm, radians(study.crossing_angle_deg))
    conditions, face = study.conditions, driven.face or held.face
    load_N = conditions.drive.load.largest * conditions.normal_load_N
    hertz = hertz_of(load_N, driven, held)
    if face is not None:
        modulus = reference.contact_modulus(driven.material, held.material)
        curvature = 0.375 * load_N / (modulus * hertz.contact_radius_mm**3)
        gap = (curvature, curvature, 0.0)
    factors = wear_factors(study.effects, study.contact.friction, conditions.normal_load_N, float(conditions.cycles))
    nominal = Specimens(study.crossing_angle_deg)
    depth = applied(study.effects, Seam.SPECIMENS, nominal, Age.new()).flattening_mm
    flattened = float(0.5 * pi * depth**2 / (gap[0] * gap[1]) ** 0.5)
    lacking = sum(body.surface.volume_mm3 for body in (driven, held) if body.surface is not None)
    volume = max(_worn_volume(study, factors), flattened) + lacking
    sticks = lacking == 0.0 and flattened == 0.0 and (point_sticks(study) if sticks is None else sticks)
    spread = spread_by_yield(limit_of_points(study), load_N, hertz.peak_pressure_MPa)
    if volume == 0.0:
        scar = None
    elif sticks:
        # A contact that sticks in its middle for good wears within its fresh outline.
        scar = fresh_ellipse(hertz).enlarged(spread)
    else:
        scar = scar_outline(volume, gap, face)
    return ExpectedContact(gap, hertz, scar, flattened, factors, sticks, face, lacking, spread)


def stands_out(study: Study, reach_mm: float) -> str | None:
    """Part of a sentence on a stated surface that rises so far above its unworn shape that the bodies touch there and
    not in the middle, at the rim of its map or further than `reach_mm` from the middle; None if none does.
    """
    driven, held = bodies = study.bodies
    maps = [(body, *_map_of(body.surface, body.axis_angle_deg)) for body in bodies if body.surface is not None]
    load_N, middle = study.conditions.drive.load.largest * study.conditions.normal_load_N, np.zeros((1, 2))

    def gap(places: Array) -> Array:
        unworn = np.einsum("ni,ij,nj->n", places, Gap.like(load_N, driven, held).form, places)
        return np.asarray(unworn - sum(own.height(places) for _, own, _, _ in maps))

    for body, own, places, rim in maps:
        found = gap(places)
        first = int(found.argmin())
        # A load that levels the difference brings the middle into contact, too.
        alone = found[first] < gap(middle)[0] - hertz_of(load_N, driven, held).approach_mm
        out_um, at = 1e3 * own.height(places[[first]])[0], places[first]
        if out_um > 0.0 and alone and (rim[first] or hypot(*at) > reach_mm):
            where = "at the rim of its map" if rim[first] else "outside the finely meshed patch"
            return (
                f"the surface stated of the {called(body.name)} stands out by {out_um:.4g} um from its unworn shape (a "
                f"depth below 0) at ({1e3 * at[0]:.4g}, {1e3 * at[1]:.4g}) um, {where}, where the bodies would touch "
                "first: give depths, and no heights"
            )
    return None


def _map_of(surface: StatedSurface, axis_angle_deg: float) -> tuple[LoweredSurface, Array, BoolArray]:
    """A stated surface of a flat over places along and across the motion, in mm; the places (n, 2) of its map; which
    (n,) of them are at its rim.
    """
    angle = radians(axis_angle_deg) if surface.frame == "body" else 0.0
    turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
    lowered = surface.lowering(Flat(), turn.T)
    lines = [1e-3 * line for line in surface.map[:2]]
    at_ends = [np.isin(line, line[[0, -1]]) & (line.size > 1) for line in lines]
    places = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2) @ turn.T
    return lowered, places, np.logical_or.outer(*at_ends).ravel()


def _worn_volume(study: Study, factors: WearFactors) -> float:
    """Volume in mm³ that both bodies lose over the test in gross slip on a rigid rig."""
    if study.wear is None:
        return 0.0
    conditions = study.conditions
    sliding_m = 4e-6 * conditions.displacement_amplitude_um * conditions.cycles
    largest = study.wear.largest_factor * factors.beyond_margin
    per_sliding = largest * study.wear.volume_per_sliding_mm3_per_N_m(study.contact.friction)
    return per_sliding * conditions.drive.mean_load * conditions.normal_load_N * sliding_m


def borne_settings(study: AnyStudy) -> dict[str, float | str]:
    """{BORNE: largest pressure in MPa that the softer body bears, BORNE_IS: what it is taken from, in words}: the yield
    stress, else the strength in [life], else Young's modulus.
    """
    if yields := [own[0] for own in study.tables.yields.values() if own is not None]:
        # Largest pressures of full plasticity over mean ones.
        factor = 1.1 * _FULLY_PLASTIC
        return {BORNE: factor * min(yields), BORNE_IS: f"{factor:.3g} times the yield stress of {min(yields):g} MPa"}
    life: LifeTable | None = study.tables.life
    known = LifeTable() if life is None else life.of_material(None)
    for strength, words in (
        (known.yield_strength_MPa, "yield strength"),
        (known.tensile_strength_MPa, f"{TENSILE_STRENGTH.split('_')[0]} strength"),
    ):
        if strength is not None:
            stated = f"{_FULLY_PLASTIC:g} times the {words} of {strength:g} MPa that [life] states"
            return {BORNE: _FULLY_PLASTIC * strength, BORNE_IS: stated}
    body, softest = min(study.tables.materials.items(), key=lambda one: one[1].youngs_modulus_MPa)
    modulus = softest.youngs_modulus_MPa
    unknown = (
        f"a twentieth of Young's modulus of the {called(body)}, as the hardest metals have it: no strength is stated"
    )
    # Hardness over Young's modulus of the hardest metals: a steel of 1000 HV, 9.8 GPa, has 0.047.
    return {BORNE: 0.05 * modulus, BORNE_IS: unknown}


@dataclass(frozen=True)
class _SlidingCycle:
    """A cycle in which a contact slides with the drive, for wear laws; see `WornCycle`."""

    edge_distance_mm: Array
    pressure_MPa: float
    power_density_W_per_mm2: float
    slip_amplitude_mm: float
    frequency_Hz: float
    rise_K: float = 0.0


def law_error(problem: ContactProblem, pressed: ContactState) -> float:
    """Estimated relative error of the friction and wear laws because few elements resolve a pressed contact and its
    edge.
    NaN for Coulomb's law with a wear coefficient that is equal everywhere, which has none.
    """
    wear, friction = problem.wear, problem.law
    alike = type(wear.law) in (EnergyLaw, Archard) and wear.oxygen is None
    if type(problem.friction_law) is Coulomb and (wear.none or alike):
        return nan
    spread = SpreadPressure.of(problem.primary.patch, pressed.traction[:, 2])
    laws = [friction] if wear.none else [friction, wear.law.work_per_slip(friction)]
    found = max(spread.law_error(law) for law in laws)
    return found if wear.none or not len(spread.pressure_MPa) else max(found, _factor_error(problem, spread))


def _factor_error(problem: ContactProblem, spread: SpreadPressure) -> float:
    """Relative error of the mean factor on wear if the contact's edge lies farther out or farther in."""
    weights, hertz = spread.pressure_MPa * spread.parts_mm2, problem.timing.frequency_Hz
    pressure, amplitude = float(weights.sum()) / spread.area_mm2, problem.timing.drive.amplitude_mm
    power = 4e-3 * problem.friction * pressure * amplitude * hertz
    cycle = _SlidingCycle(spread.edge_distance_mm, pressure, power, amplitude, hertz)
    off = spread.edge_error * sqrt(spread.area_mm2 / pi)
    less, more = (
        float(weights @ (np.zeros(len(weights)) + problem.wear.factor(replace(cycle, edge_distance_mm=distance))))
        for distance in (np.maximum(spread.edge_distance_mm - off, 0.0), spread.edge_distance_mm + off)
    )
    return abs(less - more) / max(less + more, 1e-300)
