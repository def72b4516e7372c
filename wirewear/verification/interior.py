"""Stresses inside the bodies and at the contact's edge: Hertz, McEwen, Hamilton's sliding sphere, Cattaneo–Mindlin.

Bodies of edge stresses are thick, as the closed forms are for half-spaces: on wires 33 contact radii thick, curvature
alone changes the tension across a wire by 3 %.
"""

from collections.abc import Callable

import numpy as np

from geometry import BlockGeometry, BodyGeometry, BodyMesh, GradedAxis, Layering, WireGeometry, build_body, build_planar
from geometry.arrays import Array, IntArray
from solvers import ContactProblem, ContactState, Holder, advance, condense, press, unloaded_state
from solvers.elasticity.linear_elasticity import IntegrationPoints, integration_points, von_mises
from solvers.stress.body_forces import forces_on_bodies
from solvers.stress.interior import Interior
from solvers.stress.surface_stress import SurfaceStress
from wirewear import reference
from wirewear.verification.hertz import (
    LOAD_N,
    STEEL,
    CONTACT_MODULUS_MPa,
    CONTACT_RADIUS_mm,
    condensed,
    crossed,
    element_mm,
    wire_geometry,
)
from wirewear.verification.hertz import RADIUS_mm as WIRE_RADIUS_mm
from wirewear.verification.line_contact import (
    MATERIAL,
    LOAD_N_per_mm,
    RADIUS_mm,
    cylinder_on_flat,
    largest_tension,
    pad_geometry,
)
from wirewear.verification.rows import Level, Row, compared

_BALANCE = 1e-8  #: Static equilibrium holds to round-off of the factor.
_DEEPEST = 2.0  #: Depth, in contact radii, down to which the largest stress is looked for.

FRICTION = 0.62
_RADIUS_mm = 2.0
_LOAD_N = 4.0 * CONTACT_MODULUS_MPa * CONTACT_RADIUS_mm**3 / (3.0 * _RADIUS_mm)
_PEAK_MPa = 1.5 * _LOAD_N / (np.pi * CONTACT_RADIUS_mm**2)

#: Increments on each path; the paths' ends over the displacement at which half-spaces begin to slide.
_INCREMENTS = 8
_PARTIAL, _SLIDING = 0.5, 3.0


def interior_rows(level: Level) -> tuple[Row, ...]:
    """Rows on the largest von Mises stress and its depth under wires and lines, and on equilibrium of a wire."""
    return (*wire_rows(level), *line_rows(level))


def wire_rows(level: Level) -> tuple[Row, ...]:
    """Rows of `interior_rows` on crossed wires."""
    resolution = level.hertz_resolutions[-1]
    exact = reference.hertz_point(LOAD_N, WIRE_RADIUS_mm, CONTACT_MODULUS_MPa)
    a = exact.contact_radius_mm
    body = condensed(wire_geometry(resolution))
    problem = crossed(body, body, Holder(LOAD_N))
    state, _ = press(problem, unloaded_state(problem))
    force = forces_on_bodies(problem, state)[1]
    wire = build_body(wire_geometry(resolution))
    interior = Interior(wire.mesh, STEEL, wire.mesh.surface_nodes("grip"))
    nodes = wire.patch.nodes.ravel()
    displacement = interior.displacements(nodes, force[None])[0]
    points = integration_points(wire.mesh)
    stress = points.stresses(STEEL, displacement)
    element = element_mm(body)
    name = f"Hertz beneath the surface, mesh a/{a / element:.1f}"

    def true(depth: Array) -> Array:
        peak, nu = exact.peak_pressure_MPa, STEEL.poissons_ratio
        return reference.hertz_stress(0.0, 0.0, depth, contact_radius_mm=a, peak_pressure_MPa=peak, poissons_ratio=nu)

    return (
        *_peak_rows(name, _peak(points, stress, a), true, a, element, level.stress_tolerance),
        *_balance_rows(points, stress, nodes, force, interior.held),
    )


def _balance_rows(
    points: IntegrationPoints, stress: Array, nodes: IntArray, force: Array, held: IntArray
) -> tuple[Row, ...]:
    """Rows on static equilibrium: the grip's reaction balances the contact's force and moment, and no other node
    carries any.
    """
    residual = points.internal_forces(stress)
    residual[nodes] -= force
    reaction, places = residual[held], points.mesh.points
    total = float(np.abs(force.sum(axis=0)).max())
    moment = np.cross(places[nodes], force).sum(axis=0) + np.cross(places[held], reaction).sum(axis=0)
    lever = total * WIRE_RADIUS_mm
    free = np.delete(residual, held, axis=0)
    name = "Wire held at its back"
    unbalanced = float(np.abs(reaction.sum(axis=0) + force.sum(axis=0)).max())
    return (
        compared(name, "reaction + contact force [N]", unbalanced, 0.0, _BALANCE, scale=total),
        compared(name, "their moments [N mm]", float(np.abs(moment).max()), 0.0, _BALANCE, scale=lever),
        compared(name, "largest force left inside [N]", float(np.abs(free).max()), 0.0, _BALANCE, scale=total),
    )


def line_rows(level: Level) -> tuple[Row, ...]:
    """Rows of `interior_rows` on a line contact."""
    exact = reference.hertz_line(LOAD_N_per_mm, RADIUS_mm, reference.contact_modulus(MATERIAL, MATERIAL))
    a = exact.half_width_mm
    element = a / level.line_resolution
    problem = cylinder_on_flat(element)
    state, _ = press(problem, unloaded_state(problem))
    force = forces_on_bodies(problem, state)[0]
    pad = build_planar(pad_geometry(element))
    interior = Interior(pad.mesh, MATERIAL, pad.mesh.surface_nodes("grip"))
    points = integration_points(pad.mesh)
    stress = points.stresses(MATERIAL, interior.displacements(pad.patch.nodes.ravel(), force[None])[0])
    name = f"McEwen's line contact, mesh a/{level.line_resolution:g}"

    def true(depth: Array) -> Array:
        peak, nu = exact.peak_pressure_MPa, MATERIAL.poissons_ratio
        return reference.line_stress(0.0, depth, half_width_mm=a, peak_pressure_MPa=peak, poissons_ratio=nu)

    peak = _peak(points, stress, a)
    rows = pad.geometry.layers()
    beneath = float(rows[int(np.searchsorted(np.cumsum(rows), peak[0]))])
    return _peak_rows(name, peak, true, a, beneath, level.stress_tolerance)


def _peak_rows(
    name: str,
    found: tuple[float, float],
    true: Callable[[Array], Array],
    radius_mm: float,
    element_mm: float,
    tolerance: float,
) -> tuple[Row, Row]:
    """Rows on the largest von Mises stress and its depth; `true` gives the exact stresses (n, 6) at depths (n,).

    found: computed depth and stress.  element_mm: size of the elements at that depth.
    """
    depths = np.linspace(0.0, _DEEPEST * radius_mm, 2001)
    exact = von_mises(true(depths))
    return (
        compared(name, "largest von Mises stress [MPa]", found[1], exact.max(), tolerance),
        compared(name, "its depth [mm]", found[0], depths[exact.argmax()], 0.5 * element_mm, scale=1.0),
    )


def _peak(points: IntegrationPoints, stress: Array, radius_mm: float) -> tuple[float, float]:
    """Depth and value of the largest von Mises stress under the middle, from a parabola through three nodes."""
    places = points.mesh.points
    middle = np.flatnonzero(
        (np.abs(places[:, :-1]).max(axis=1) < 1e-9) & (places[:, -1] > -_DEEPEST * radius_mm - 1e-9)
    )
    middle = middle[np.argsort(-places[middle, -1])]
    depth, value = -places[middle, -1], von_mises(points.at_nodes(stress))[middle]
    k = int(np.clip(value.argmax(), 1, len(value) - 2))
    fit = np.polynomial.Polynomial.fit(depth[k - 1 : k + 2], value[k - 1 : k + 2], 2)
    top = float(fit.deriv().roots()[0].real)
    return top, float(fit(top))


def surface_rows(level: Level) -> tuple[Row, ...]:
    """Rows on the tension at the trailing edge in partial slip and in sliding: on wires, on a flat and on a ball."""
    wire, flat, ball = (build_body(geometry) for geometry in _geometries(level.surface_resolution))
    return (
        *_pair_rows({"along the wire": (wire, 0), "across the wire": (wire, 1)}, 90.0, level),
        *_pair_rows({"on the flat": (flat, 0), "on the ball": (ball, 0)}, 0.0, level),
    )


def _pair_rows(pair: dict[str, tuple[BodyMesh, int]], angle_deg: float, level: Level) -> list[Row]:
    """Rows of the lower and the upper body, each with its mesh and the axis of it along which the motion runs."""
    lower, upper = (condense(mesh.mesh, mesh.patch, STEEL) for mesh, _ in pair.values())
    problem = crossed(lower, upper, Holder(_LOAD_N), friction=FRICTION, angle_deg=angle_deg)
    exact = reference.partial_slip_point(
        _LOAD_N, FRICTION, CONTACT_RADIUS_mm, reference.tangential_contact_modulus(STEEL, STEEL)
    )
    sliding = float(reference.loading_displacement(exact, exact.limit_N))
    state, _ = press(problem, unloaded_state(problem))
    rows: list[Row] = []
    for first, last in ((0.0, _PARTIAL), (_PARTIAL, _SLIDING)):
        for drive in sliding * np.linspace(first, last, _INCREMENTS + 1)[1:]:
            state, _ = advance(problem, state, float(drive), 0.0)
        rows += _tension_rows(pair, problem, state, level)
    return rows


def _tension_rows(
    pair: dict[str, tuple[BodyMesh, int]], problem: ContactProblem, state: ContactState, level: Level
) -> list[Row]:
    rows = []
    on_upper, on_lower = forces_on_bodies(problem, state)
    for (name, (mesh, axis)), force in zip(pair.items(), (on_lower, on_upper), strict=True):
        share = abs(float(force[:, axis].sum())) / (FRICTION * _LOAD_N)
        problem_name = "Hamilton" if share > 1.0 - 1e-6 else f"Cattaneo–Mindlin, Q = {share:.2f} µP"
        rows.append(
            compared(
                f"{problem_name}, mesh a/{level.surface_resolution:g}",
                f"tension at the edge, {name} [MPa]",
                largest_tension(mesh, SurfaceStress.of(mesh, STEEL), force, axis),
                _exact_tension(share),
                level.surface_tolerance,
            )
        )
    return rows


def _exact_tension(share: float) -> float:
    """Tension at the trailing edge in MPa, on first loading to this share of the sliding force."""
    stick = CONTACT_RADIUS_mm * max(1.0 - share, 1e-12) ** (1.0 / 3.0)
    return float(
        reference.partial_slip_stress(
            -CONTACT_RADIUS_mm,
            0.0,
            0.0,
            contact_radius_mm=CONTACT_RADIUS_mm,
            stick_radius_mm=stick,
            peak_pressure_MPa=_PEAK_MPa,
            friction=FRICTION,
            poissons_ratio=STEEL.poissons_ratio,
        )[0]
    )


def _geometries(resolution: float) -> tuple[BodyGeometry, ...]:
    a, diameter = CONTACT_RADIUS_mm, 2.0 * _RADIUS_mm
    lines = GradedAxis(a / resolution, 2.0 * a, 2.0 * a / resolution, 3.0 * a)
    layering = Layering.resolving(resolution)

    def block(curvature_per_mm: float, width_mm: float) -> BlockGeometry:
        size = width_mm, width_mm, _RADIUS_mm, lines, lines, 0.2 * width_mm
        return BlockGeometry(curvature_per_mm, curvature_per_mm, *size, layering=layering)

    wire = WireGeometry(diameter, 2.2 * diameter, lines, lines, 0.155 * diameter, layering=layering)
    return wire, block(0.0, 2.0 * _RADIUS_mm), block(1.0 / _RADIUS_mm, 0.6 * _RADIUS_mm)
