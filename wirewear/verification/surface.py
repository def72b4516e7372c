"""Tension behind a contact, at its very edge: Hamilton's sliding sphere, and Cattaneo–Mindlin's partial slip.

Wires and a ball are thick beside their contact, as the closed forms are for half-spaces: on wires 33 contact radii
thick the curvature alone changes the tension across a wire by 3 %.
"""

import numpy as np

from geometry import BlockGeometry, BodyGeometry, BodyMesh, GradedAxis, Layering, WireGeometry, build_body
from geometry.arrays import Array
from solvers import ContactProblem, ContactState, Holder, advance, condense, press, unloaded_state
from solvers.interior import Interior, forces_on_bodies
from solvers.strain import integration_points
from solvers.surface_stress import SurfaceStress
from wirewear import reference
from wirewear.verification.hertz import STEEL, CONTACT_MODULUS_MPa, CONTACT_RADIUS_mm, crossed
from wirewear.verification.rows import Level, Row, compared

FRICTION = 0.62
_RADIUS_mm = 2.0
_LOAD_N = 4.0 * CONTACT_MODULUS_MPa * CONTACT_RADIUS_mm**3 / (3.0 * _RADIUS_mm)
_PEAK_MPa = 1.5 * _LOAD_N / (np.pi * CONTACT_RADIUS_mm**2)
#: Increments on each path; the paths' ends over the displacement at which half-spaces begin to slide.
_INCREMENTS = 8
_PARTIAL, _SLIDING = 0.5, 3.0


def surface_rows(level: Level) -> tuple[Row, ...]:
    """Tension at the trailing edge in partial slip and sliding, on wires along and across the motion, flat and ball."""
    wire, flat, ball = (build_body(geometry) for geometry in _geometries(level.surface_resolution))
    return (
        *_pair_rows({"along the wire": (wire, 0), "across the wire": (wire, 1)}, 90.0, level),
        *_pair_rows({"on the flat": (flat, 0), "on the ball": (ball, 0)}, 0.0, level),
    )


def _pair_rows(pair: dict[str, tuple[BodyMesh, int]], angle_deg: float, level: Level) -> list[Row]:
    """Of the lower and the upper body, each with its own axis along which the motion runs."""
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
                largest_tension(mesh, force, axis),
                _exact_tension(share),
                level.surface_tolerance,
            )
        )
    return rows


def largest_tension(wire: BodyMesh, force_N: Array, axis: int) -> float:
    """Largest stress along an axis of a steel wire where its contact ends, by forces (n, 3) on its patch's nodes."""
    nodes = wire.patch.nodes.ravel()
    interior = Interior(wire.mesh, STEEL, wire.mesh.surface_nodes("grip"))
    points = integration_points(wire.mesh)
    stress = points.at_nodes(points.stresses(STEEL, interior.displacements(nodes, force_N[None])[0]))[nodes]
    surface = SurfaceStress.of(wire, STEEL).under(force_N)
    edge = surface.edge()
    near, weights, _ = wire.patch.locate(edge)
    found = np.einsum("kc,kcs->ks", weights, stress[near]) + surface.correction(edge)
    return float(found[:, axis].max())


def _exact_tension(share: float) -> float:
    """At first loading to that share of the force of sliding."""
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
    """A wire, a flat and a ball."""
    a, diameter = CONTACT_RADIUS_mm, 2.0 * _RADIUS_mm
    lines = GradedAxis(a / resolution, 2.0 * a, 2.0 * a / resolution, 3.0 * a)
    layering = Layering.resolving(resolution)

    def block(curvature_per_mm: float, width_mm: float) -> BlockGeometry:
        size = width_mm, width_mm, _RADIUS_mm, lines, lines, 0.2 * width_mm
        return BlockGeometry(curvature_per_mm, curvature_per_mm, *size, layering=layering)

    wire = WireGeometry(diameter, 2.2 * diameter, lines, lines, 0.155 * diameter, layering=layering)
    return wire, block(0.0, 2.0 * _RADIUS_mm), block(1.0 / _RADIUS_mm, 0.6 * _RADIUS_mm)
