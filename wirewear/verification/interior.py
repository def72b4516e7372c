"""Stresses inside the bodies: Hertz and McEwen beneath the surface, the sliding sphere's, and the grip's reactions."""

from collections.abc import Callable

import numpy as np

from geometry import build_body, build_planar
from geometry.arrays import Array, IntArray
from solvers import Holder, press, unloaded_state
from solvers.interior import Interior, forces_on_bodies
from solvers.strain import IntegrationPoints, integration_points, von_mises
from wirewear import reference
from wirewear.verification.hertz import (
    LOAD_N,
    STEEL,
    CONTACT_MODULUS_MPa,
    condensed,
    crossed,
    element_mm,
    wire_geometry,
)
from wirewear.verification.hertz import RADIUS_mm as WIRE_RADIUS_mm
from wirewear.verification.line_contact import MATERIAL, LOAD_N_per_mm, RADIUS_mm, cylinder_on_flat, pad_geometry
from wirewear.verification.rows import Level, Row, compared

_BALANCE = 1e-8  #: Static equilibrium holds to round-off of the factor.
_DEEPEST = 2.0  #: Depth, in contact radii, down to which the largest stress is looked for.


def interior_rows(level: Level) -> tuple[Row, ...]:
    """Largest von Mises stress and its depth under wires and a line contact, and what holds the wire."""
    return (*_wire_rows(level), *_line_rows(level))


def _wire_rows(level: Level) -> tuple[Row, ...]:
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
    """St. Venant: the grip's reaction has the contact's force and moment, and nothing acts in between."""
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


def _line_rows(level: Level) -> tuple[Row, ...]:
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
    """Depth and size of the largest von Mises stress beside those of the stresses (n, 6) at depths (n,).

    element_mm: of those at that depth, which grow towards the back of a pad.
    """
    depths = np.linspace(0.0, _DEEPEST * radius_mm, 2001)
    exact = von_mises(true(depths))
    return (
        compared(name, "largest von Mises stress [MPa]", found[1], exact.max(), tolerance),
        compared(name, "its depth [mm]", found[0], depths[exact.argmax()], 0.5 * element_mm, scale=1.0),
    )


def _peak(points: IntegrationPoints, stress: Array, radius_mm: float) -> tuple[float, float]:
    """Depth and size of the largest von Mises stress under the middle: of a parabola through the nodes next to it."""
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
