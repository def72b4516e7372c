"""Hertz contact of equal wires that cross, at right angles and as an ellipse (Johnson 1985, section 4.2)."""

from dataclasses import dataclass
from math import degrees

import numpy as np

from solvers import CondensedBody, Holder, press, unloaded_state
from wirewear import reference
from wirewear.reference import PointContact
from wirewear.simulation import mean_pressures
from wirewear.verification.rows import Level, Row, compared, falling, observed_order
from wirewear.verification.wires import (
    LOAD_N,
    STEEL,
    CONTACT_MODULUS_MPa,
    CONTACT_RADIUS_mm,
    RADIUS_mm,
    bulk_compliance,
    condensed,
    crossed,
    crossed_bulk_compliance,
    element_mm,
    wire_geometry,
)

_ANGLE_deg = 60.0
_SMALL_RADIUS_mm = 0.6 * RADIUS_mm
#: Contacts of a smaller ratio of their axes are taken for round.
_ROUND = 1.001

# The figures scatter by so much with where the contact's edge falls between grid lines; smaller errors cannot fall.
_FLOOR = 0.003


def ellipse_rows(level: Level) -> tuple[Row, ...]:
    """Peak pressure, approach, both semi-axes and the direction of the major one."""
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
    """Two bodies pressed together beside Hertz's contact, the upper one's axis at an angle to the lower one's.

    The semi-axes are those of the Hertz pressure with the same second moments, a² = 5 <x²>. A round contact has no
    direction.
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
    bulk = sum(bulk_compliance(body, 2, exact.contact_radius_mm) for body in (lower, upper))
    raw = -state.holder_z
    tolerance = level.ellipse_tolerance
    rows = (
        compared(name, "p0 [MPa]", report.max_pressure, exact.peak_pressure_MPa, tolerance),
        compared(name, "approach [mm]", raw - bulk * load_N, exact.approach_mm, tolerance, raw=raw),
        compared(name, "major semi-axis [mm]", float(np.sqrt(major)), exact.major_semi_axis_mm, tolerance),
        compared(name, "minor semi-axis [mm]", float(np.sqrt(minor)), exact.minor_semi_axis_mm, tolerance),
    )
    if exact.major_semi_axis_mm < _ROUND * exact.minor_semi_axis_mm:
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
    """Peak pressure, approach and radius on each mesh, whether their errors fall, and the finest's mean over a disc.

    The radius is that of the Hertz pressure with the same second moment, a² = 5/2 <r²>; the radius of the nodes in
    contact, which comes in steps, is checked to within an element. The layers under the patch are refined with it; with
    their number fixed, the errors would level off at about 1 %.
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
            "radius of nodes in contact [mm]",
            finest.area_radius_mm,
            exact.contact_radius_mm,
            finest.element_mm / exact.contact_radius_mm,
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
