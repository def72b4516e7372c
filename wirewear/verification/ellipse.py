"""Elliptic Hertz contact: wires crossed at 60°, of equal and of unequal diameters (Johnson 1985, sections 4.1, 4.2)."""

from __future__ import annotations

from math import degrees

import numpy as np

from solvers import CondensedBody, Holder, press, unloaded_state
from wirewear import reference
from wirewear.verification.level import Level
from wirewear.verification.rows import Row, compared
from wirewear.verification.wires import LOAD_N, STEEL, RADIUS_mm, bulk_compliance, condensed, crossed, wire_geometry

_ANGLE_deg = 60.0
_SMALL_RADIUS_mm = 0.6 * RADIUS_mm


def ellipse_rows(level: Level) -> tuple[Row, ...]:
    """Peak pressure, approach, both semi-axes and the direction of the major one."""
    resolution = level.hertz_resolutions[-1]
    load = LOAD_N * level.enlarged**3
    large = condensed(wire_geometry(resolution))
    small = condensed(wire_geometry(resolution, radius_mm=_SMALL_RADIUS_mm))
    return (
        *_rows("Ellipse, 60°, equal wires", large, large, RADIUS_mm, load, level),
        *_rows("Ellipse, 60°, diameters 1 : 0.6", large, small, _SMALL_RADIUS_mm, load, level),
    )


def _rows(
    name: str, lower: CondensedBody, upper: CondensedBody, upper_radius_mm: float, load_N: float, level: Level
) -> tuple[Row, ...]:
    """The semi-axes are those of the Hertz pressure with the same second moments, a² = 5 <x²>."""
    exact = reference.hertz_crossed_cylinders(load_N, RADIUS_mm, upper_radius_mm, _ANGLE_deg, first=STEEL, second=STEEL)
    problem = crossed(lower, upper, Holder(load_N), angle_deg=_ANGLE_deg)
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
    return (
        compared(name, "p0 [MPa]", report.max_pressure, exact.peak_pressure_MPa, tolerance),
        compared(name, "approach [mm]", raw - bulk * load_N, exact.approach_mm, tolerance, raw=raw),
        compared(name, "major semi-axis [mm]", float(np.sqrt(major)), exact.major_semi_axis_mm, tolerance),
        compared(name, "minor semi-axis [mm]", float(np.sqrt(minor)), exact.minor_semi_axis_mm, tolerance),
        compared(
            name,
            "direction of major axis [deg]; error [rad]",
            degrees(exact.major_angle_rad + off),
            degrees(exact.major_angle_rad),
            tolerance,
            scale=degrees(1.0),
        ),
    )
