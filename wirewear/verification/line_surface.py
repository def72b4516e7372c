"""Tension behind a line contact, at its very edge: McEwen's sliding cylinder, and Cattaneo–Mindlin's partial slip.

The resolutions are those of runs at standard and fine fidelity.
"""

import numpy as np

from geometry import Flat, PlanarGeometry, PlanarMesh, build_planar
from geometry.arrays import Array
from solvers import advance, press, unloaded_state
from solvers.interior import Interior, forces_on_bodies
from solvers.line_surface_stress import LineSurfaceStress
from solvers.strain import integration_points
from wirewear import reference
from wirewear.verification.line_contact import (
    FRICTION,
    MATERIAL,
    LOAD_N_per_mm,
    RADIUS_mm,
    cylinder_on_flat,
    pad_geometry,
    tangential_force,
    to_force,
)
from wirewear.verification.rows import Level, Row, compared

_SHARE = 0.64
_SLIDE_mm, _INCREMENTS = 1e-2, 5


def line_surface_rows(level: Level) -> tuple[Row, ...]:
    """Tension at the trailing edge in partial slip and sliding, of the cylinder and of the flat."""
    exact = reference.hertz_line(LOAD_N_per_mm, RADIUS_mm, reference.contact_modulus(MATERIAL, MATERIAL))
    element = exact.half_width_mm / level.line_surface_resolution
    problem = cylinder_on_flat(element)
    state, _ = press(problem, unloaded_state(problem))
    state = to_force(problem, state, _SHARE * FRICTION * LOAD_N_per_mm)
    states = [state]
    for _ in range(_INCREMENTS):
        state, _report = advance(problem, state, state.drive + _SLIDE_mm / _INCREMENTS, 0.0)
    states.append(state)
    pad = pad_geometry(element)
    bodies = {"cylinder": build_planar(pad), "flat": build_planar(PlanarGeometry(Flat(), 8.0, 8.0, pad.along))}
    rows = []
    for state in states:
        share = min(abs(tangential_force(state)) / (FRICTION * LOAD_N_per_mm), 1.0)
        kind = "McEwen, sliding" if share > 1.0 - 1e-3 else f"Cattaneo–Mindlin, line, Q = {share:.2f} µP"
        for (name, body), force in zip(bodies.items(), forces_on_bodies(problem, state), strict=True):
            rows.append(
                compared(
                    f"{kind}, mesh a/{level.line_surface_resolution:g}",
                    f"tension at the edge, {name} [MPa]",
                    largest_tension(body, force),
                    _exact_tension(exact, share),
                    level.line_surface_tolerance,
                )
            )
    return tuple(rows)


def largest_tension(body: PlanarMesh, force_N_per_mm: Array) -> float:
    """Largest stress along the surface of a body where its contact ends, by forces (n, 3) on its patch's nodes."""
    nodes = body.patch.nodes.ravel()
    interior = Interior(body.mesh, MATERIAL, body.mesh.surface_nodes("grip"))
    points = integration_points(body.mesh)
    moved = interior.displacements(nodes, force_N_per_mm[None])[0]
    stress = points.at_nodes(points.stresses(MATERIAL, moved))[nodes]
    surface = LineSurfaceStress.of(body, MATERIAL).under(force_N_per_mm)
    edge = surface.edge()
    near, weights, _ = body.patch.locate(edge)
    found = np.einsum("kc,kcs->ks", weights, stress[near]) + surface.correction(edge)
    return float(found[:, 0].max())


def _exact_tension(contact: reference.LineContact, share: float) -> float:
    """At first loading to that share of the force of sliding: 2 µ p0 √share."""
    stress = reference.line_partial_slip_stress(
        -contact.half_width_mm,
        0.0,
        half_width_mm=contact.half_width_mm,
        stick_half_width_mm=contact.half_width_mm * max(1.0 - share, 1e-12) ** 0.5,
        peak_pressure_MPa=contact.peak_pressure_MPa,
        friction=FRICTION,
        poissons_ratio=MATERIAL.poissons_ratio,
    )
    return float(stress[0])
