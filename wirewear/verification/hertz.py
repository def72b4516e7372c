"""Hertz contact of wires crossed at right angles and at 60° (Johnson 1985, section 4.2), and bodies of other checks.

The closed forms are for half-spaces; a wire of radius R gripped at its back is one only near the contact. Displacement
at a distance r from a point force is that on a half-space (Boussinesq, Cerruti) plus the body's own: bending and shear
of the gripped wire, less what the half-space does beyond it. That part varies on the scale of R, so over a contact of
radius a it is a constant kappa, the bulk compliance, times the force, up to relative terms of (a/R)². kappa is read
from the condensed compliance alone, as the mean of u(r) - u_half-space(r) over a ring just outside the contact; neither
a contact solution nor a contact formula enters it. Approach and tangential displacement are compared after subtracting
kappa times the force for both bodies; in series with a rig's spring it is a second spring. Table rows also give the
error without this correction. With a/R = 0.03-0.05 the remaining error is below half a per cent. Pressures, radii and
the energy at a given force need no correction, as rigid motion does not change them.
"""

from dataclasses import dataclass, replace
from functools import cache
from math import degrees, radians

import numpy as np

from geometry import BodyGeometry, ContactPatch, Cylinder, Elastic, GradedAxis, Layering, WireGeometry, build_body
from solvers import CondensedBody, ContactProblem, Holder, WearRates, condense, facing, place, press, unloaded_state
from solvers.elasticity.patch_compliance import Bricks
from wirewear import reference
from wirewear.reference import PointContact
from wirewear.simulation import mean_pressures
from wirewear.verification.rows import Level, Row, compared, falling, observed_order

STEEL = Elastic(210_000.0, 0.3)
RADIUS_mm = 0.5
#: Contact radius for which the meshes are made, 0.03 R.
CONTACT_RADIUS_mm = 0.015
CONTACT_MODULUS_MPa = reference.contact_modulus(STEEL, STEEL)
#: Normal load that gives this radius to equal wires crossed at right angles.
LOAD_N = 4.0 * CONTACT_MODULUS_MPa * CONTACT_RADIUS_mm**3 / (3.0 * RADIUS_mm)

_ANGLE_deg = 60.0
_SMALL_RADIUS_mm = 0.6 * RADIUS_mm
_ROUND = 1.001  #: Contacts of a smaller ratio of their axes are taken for round.

# The figures scatter by so much with where the contact's edge falls between grid lines; smaller errors cannot fall.
_FLOOR = 0.003


def wire_geometry(resolution: float, *, radius_mm: float = RADIUS_mm, long_patch: bool = False) -> WireGeometry:
    """A wire with `resolution` elements per contact radius; on a long patch the contact can slide by 3 radii."""
    a = CONTACT_RADIUS_mm
    element, outer = a / resolution, max(a / resolution, 0.75 * a)
    axial = GradedAxis(element, 4.2 * a, outer, 4.5 * a) if long_patch else GradedAxis(element, 2.0 * a, outer, 4.0 * a)
    transverse = GradedAxis(element, 2.0 * a, outer, 3.0 * a if long_patch else 4.0 * a)
    diameter = 2.0 * radius_mm
    # One layer more than in a run: what is compared with closed forms may cost more.
    layering = Layering(6, 1.2, 0.6).refined(max(1.0, resolution / 4.0))
    return WireGeometry(diameter, 2.2 * diameter, axial, transverse, 0.155 * diameter, layering=layering)


@cache
def condensed(geometry: BodyGeometry) -> CondensedBody:
    """A steel body of this geometry, always condensed here, as a verification must not use the cache on disk."""
    meshed = build_body(geometry)
    return replace(condense(meshed.mesh, meshed.patch, STEEL), bricks=Bricks(STEEL, geometry.layers))


def scaled_patch(wire: ContactPatch, radius_mm: float, factor: float) -> ContactPatch:
    """A copy of the patch of a wire of this radius, with all lengths multiplied by `factor`."""
    axial, transverse, profile = factor * wire.axial_mm, factor * wire.transverse_mm, Cylinder(factor * radius_mm)
    return replace(wire, axial_mm=axial, transverse_mm=transverse, profile=profile)


def crossed(
    lower: CondensedBody,
    upper: CondensedBody,
    holder: Holder,
    *,
    friction: float = 0.0,
    angle_deg: float = 90.0,
    wear: WearRates | None = None,
    primary_is_upper: bool = True,
) -> ContactProblem:
    """Contact problem of two bodies: the lower one's axis along the motion, the upper one's at `angle_deg` to it.

    wear: None for none. primary_is_upper: True if the upper body's nodes carry the tractions, False if the lower's do.
    """
    above = place(upper, upper=True, axis_angle_rad=float(np.radians(angle_deg)))
    below = place(lower, upper=False, axis_angle_rad=0.0)
    return ContactProblem(
        upper=facing(above, below) if primary_is_upper else above,
        lower=below if primary_is_upper else facing(below, above),
        holder=holder,
        friction=friction,
        wear=wear or WearRates(),
        primary_is_upper=primary_is_upper,
    )


def element_mm(body: CondensedBody) -> float:
    """Element size in the middle of the patch across the axis, which grading may change a little from the asked one."""
    lines = body.patch.transverse_mm
    return float(np.diff(lines)[len(lines) // 2])


def bulk_compliance(
    body: CondensedBody, axis: int, contact_radius_mm: float, ratio: float = 1.0, major_rad: float = 0.0
) -> float:
    """Bulk compliance kappa in mm/N of a body for forces along its own axis 0, 1 or 2: what exceeds a half-space's.

    It is the mean over nodes at 1 to 1.5 contact radii from a point force in the middle; half-space: Johnson, Contact
    Mechanics, 1985, sections 3.2 and 3.6. For an ellipse, `ratio` is that of its semi-axes, whose geometric mean is
    `contact_radius_mm`, and `major_rad` the angle of the major one from the body's axis.
    """
    positions = body.patch.grid()
    loaded = int(np.argmin((positions**2).sum(axis=1)))
    r = np.hypot(*positions.T)
    c, s = np.cos(major_rad), np.sin(major_rad)
    along, aside = positions @ [c, s], positions @ [-s, c]
    distance = np.hypot(along / ratio**0.5, aside * ratio**0.5) / contact_radius_mm
    ring = (distance > 1.0) & (distance < 1.5)
    moved = body.compliance.reshape(body.patch.size, 3, body.patch.size, 3)[ring, axis, loaded, axis]
    nu, modulus = STEEL.poissons_ratio, STEEL.youngs_modulus_MPa
    shape = 1.0 - nu**2
    if axis < 2:
        shape = (1.0 + nu) * (1.0 - nu + nu * positions[ring, axis] ** 2 / r[ring] ** 2)
    return float((moved - shape / (np.pi * modulus * r[ring])).mean())


def crossed_bulk_compliance(body: CondensedBody, *, normal: bool, contact_radius_mm: float) -> float:
    """Bulk compliance in mm/N of two wires like `body`, crossed at right angles, along the normal or the motion, as
    from `bulk_compliance`.
    """
    axes = (2, 2) if normal else (0, 1)
    return sum(bulk_compliance(body, axis, contact_radius_mm) for axis in axes)


def ellipse_rows(level: Level) -> tuple[Row, ...]:
    """Rows on peak pressure, approach, both semi-axes and direction of the major one, for wires crossed at 60°."""
    resolution = level.hertz_resolutions[-1]
    load = LOAD_N * level.enlarged**3
    large = condensed(wire_geometry(resolution))
    small = condensed(wire_geometry(resolution, radius_mm=_SMALL_RADIUS_mm))
    return (
        *_wire_rows("Ellipse, 60°, equal wires", large, large, RADIUS_mm, load, level),
        *_wire_rows("Ellipse, 60°, diameters 1 : 0.6", large, small, _SMALL_RADIUS_mm, load, level),
    )


def _wire_rows(
    name: str, lower: CondensedBody, upper: CondensedBody, upper_radius_mm: float, load_N: float, level: Level
) -> tuple[Row, ...]:
    exact = reference.hertz_crossed_cylinders(load_N, RADIUS_mm, upper_radius_mm, _ANGLE_deg, first=STEEL, second=STEEL)
    return pressed_rows(name, lower, upper, exact, _ANGLE_deg, level)


def pressed_rows(
    name: str, lower: CondensedBody, upper: CondensedBody, exact: PointContact, angle_deg: float, level: Level
) -> tuple[Row, ...]:
    """Rows that compare two pressed bodies with Hertz's contact `exact`. name: of the problem; angle_deg: between the
    bodies' axes. Semi-axes are those of the Hertz pressure with the same second moments, a² = 5 <x²>. The direction is
    left out for a round contact.
    """
    load_N = exact.normal_load_N
    problem = crossed(lower, upper, Holder(load_N), angle_deg=angle_deg)
    state, report = press(problem, unloaded_state(problem))
    force = state.primary_force[:, 2]
    position = problem.primary.node_positions
    spread = 5.0 * (position.T * force) @ position / force.sum()
    (minor, major), directions = np.linalg.eigh(spread)
    direction = float(np.arctan2(directions[1, 1], directions[0, 1]))
    off = (direction - exact.major_angle_rad + np.pi / 2.0) % np.pi - np.pi / 2.0
    radius, ratio = exact.contact_radius_mm, exact.major_semi_axis_mm / exact.minor_semi_axis_mm
    bulk = sum(
        bulk_compliance(body, 2, radius, ratio, exact.major_angle_rad - turn)
        for body, turn in ((lower, 0.0), (upper, radians(angle_deg)))
    )
    raw = -state.holder_z
    fine, tolerance = level.hertz_tolerances[-1], level.ellipse_tolerance
    rows = (
        compared(name, "p0 [MPa]", report.max_pressure, exact.peak_pressure_MPa, fine),
        compared(name, "approach [mm]", raw - bulk * load_N, exact.approach_mm, fine, raw=raw),
        compared(name, "major semi-axis [mm]", float(np.sqrt(major)), exact.major_semi_axis_mm, tolerance),
        compared(name, "minor semi-axis [mm]", float(np.sqrt(minor)), exact.minor_semi_axis_mm, tolerance),
    )
    if ratio < _ROUND:
        return rows
    return (
        *rows,
        compared(
            name,
            "direction of major axis [deg]; error [rad]",
            degrees(exact.major_angle_rad + off),
            degrees(exact.major_angle_rad),
            tolerance,
            scale=degrees(1.0),
        ),
    )


@dataclass(frozen=True)
class _Solution:
    element_mm: float
    peak_pressure_MPa: float
    mean_pressure_MPa: float
    raw_approach_mm: float
    approach_mm: float
    radius_mm: float
    area_radius_mm: float


def hertz_rows(level: Level) -> tuple[Row, ...]:
    """Rows on peak pressure, approach and radius on each of three meshes, on whether their errors fall, and on the
    finest mesh's mean pressure and contact area.

    The radius is that of the Hertz pressure with the same second moment, a² = 5/2 <r²>. The layers under the patch are
    refined as well; with their number fixed, the errors would level off at about 1 %.
    """
    exact = reference.hertz_point(LOAD_N, RADIUS_mm, CONTACT_MODULUS_MPa)
    solutions = [_solve(resolution) for resolution in level.hertz_resolutions]
    rows: list[Row] = []
    for quantity, attribute, truth in (
        ("p0 [MPa]", "peak_pressure_MPa", exact.peak_pressure_MPa),
        ("approach [mm]", "approach_mm", exact.approach_mm),
        ("radius from 2nd moment [mm]", "radius_mm", exact.contact_radius_mm),
    ):
        errors = [getattr(solution, attribute) / truth - 1.0 for solution in solutions]
        for i, solution in enumerate(solutions):
            tolerance = level.hertz_tolerances[i]
            order = None
            if i > 0 and abs(errors[i]) > _FLOOR:
                order = observed_order(errors[i - 1], errors[i], solutions[i - 1].element_mm / solution.element_mm)
            raw = solution.raw_approach_mm if attribute == "approach_mm" else None
            value = getattr(solution, attribute)
            rows.append(compared(_name(solution), quantity, value, truth, tolerance, raw=raw, order=order))
        rows.append(falling("Hertz, three meshes", quantity, errors, _FLOOR))
    finest = solutions[-1]
    rows.append(
        compared(
            _name(finest),
            "mean pressure over a disc of the diameter a [MPa]",
            finest.mean_pressure_MPa,
            exact.mean_over_disc_MPa(CONTACT_RADIUS_mm),
            level.hertz_tolerances[-1],
        )
    )
    rows.append(
        compared(
            _name(finest),
            "radius from the area of contact [mm]",
            finest.area_radius_mm,
            exact.contact_radius_mm,
            level.hertz_tolerances[-1],
        )
    )
    return tuple(rows)


def _name(solution: _Solution) -> str:
    return f"Hertz, mesh a/{CONTACT_RADIUS_mm / solution.element_mm:.1f}"


def _solve(resolution: float) -> _Solution:
    body = condensed(wire_geometry(resolution))
    problem = crossed(body, body, Holder(LOAD_N))
    state, report = press(problem, unloaded_state(problem))
    force = state.primary_force[:, 2]
    second_moment = force @ (problem.primary.node_positions**2).sum(axis=1) / force.sum()
    bulk = crossed_bulk_compliance(body, normal=True, contact_radius_mm=CONTACT_RADIUS_mm)
    return _Solution(
        element_mm=element_mm(body),
        peak_pressure_MPa=report.max_pressure,
        mean_pressure_MPa=float(mean_pressures(problem, [state], CONTACT_RADIUS_mm)[0]),
        raw_approach_mm=-state.holder_z,
        approach_mm=-state.holder_z - bulk * LOAD_N,
        radius_mm=float(np.sqrt(2.5 * second_moment)),
        area_radius_mm=float(np.sqrt(report.contact_area / np.pi)),
    )
