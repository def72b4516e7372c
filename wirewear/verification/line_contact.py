"""Cattaneo–Mindlin line contact in plane strain: a cylinder on a flat, by the contact code with planar bodies.

The tension at the trailing edge (McEwen's sliding cylinder) is checked at the resolutions of standard and fine runs,
too. The bodies are some forty contact half-widths wide and high, so that their finite size hardly changes pressure and
width; displacements diverge logarithmically on a half-plane and are not compared. The holder is rigid and the flat's
displacement prescribed: it grows until the tangential force reaches Q*, then falls until the force reaches zero. The
closed forms are evaluated at the computed force.
"""

import numpy as np

import solvers
from geometry import BodyMesh, Cylinder, Elastic, Flat, GradedAxis, PlanarGeometry, PlanarMesh, build_planar
from geometry.arrays import Array
from solvers import advance, press, unloaded_state
from solvers.elasticity.linear_elasticity import integration_points
from solvers.stress.body_forces import forces_on_bodies
from solvers.stress.interior import Interior
from solvers.stress.line_surface_stress import LineSurfaceStress
from solvers.stress.surface_stress import SurfaceStress
from wirewear import reference
from wirewear.simulation import mean_pressures
from wirewear.verification.rows import Level, Row, compared

DEPTH_mm = 1.0
_BLOCK_mm = 60.0


RADIUS_mm = 6.0
LOAD_N_per_mm = 120.0
FRICTION = 0.6
MATERIAL = Elastic(200_000.0, 0.3)
_SHARE = 0.5
_TOLERANCE = 0.02
_MOST_STEPS = 60

_SURFACE_SHARE = 0.64
_SLIDE_mm, _INCREMENTS = 1e-2, 5

#: Bulk tension of the flat over µp0, which shifts the stick zone by a fifth of the contact's half-width.
_BULK_SHARE = 0.8


def stuck_line_rows(level: Level) -> tuple[Row, ...]:
    """Row on the tangential stiffness per length between points 1 mm deep under a stuck contact 0.2 mm wide."""
    a = 0.1
    along = GradedAxis(a / level.line_resolution, 1.2 * a, a, 3.0 * a)
    block = build_planar(PlanarGeometry(Flat(), _BLOCK_mm, _BLOCK_mm, along, 3.0, 1.2))
    material = Elastic(MATERIAL.youngs_modulus_MPa, MATERIAL.poissons_ratio)
    computed = solvers.move_stuck(block, block, material, material, a).stiffness_between(DEPTH_mm)
    exact = reference.half_plane_line_stiffness(MATERIAL, MATERIAL, a, 1.0, DEPTH_mm)
    return (compared("Line contact, stuck", "stiffness, points 1 mm deep [N/mm²]", computed, exact, _TOLERANCE),)


def line_contact_rows(level: Level) -> tuple[Row, ...]:
    """Rows on half-width, pressures, stick zone at Q* = 0.5 µP, and inner edge of the reverse slip back at Q = 0."""
    exact = reference.hertz_line(LOAD_N_per_mm, RADIUS_mm, reference.contact_modulus(MATERIAL, MATERIAL))
    problem = cylinder_on_flat(exact.half_width_mm / level.line_resolution)
    pressed, report = solvers.press(problem, solvers.unloaded_state(problem))
    a = half_width(problem, pressed.traction[:, 2])
    limit = FRICTION * LOAD_N_per_mm
    loaded = to_force(problem, pressed, _SHARE * limit)
    forward = tangential_force(loaded)
    name = f"Line contact, Q = {forward / limit:.3f} µP"
    c = half_width(problem, FRICTION * loaded.traction[:, 2] - _shear(loaded))
    unloaded = to_force(problem, loaded, 0.0)
    change = 0.5 * (_shear(loaded) - _shear(unloaded))
    back = half_width(problem, FRICTION * unloaded.traction[:, 2] - change)
    returned = tangential_force(unloaded)
    return (
        compared("Line contact", "peak pressure [MPa]", report.max_pressure, exact.peak_pressure_MPa, _TOLERANCE),
        compared(
            "Line contact",
            "mean pressure over a [MPa]",
            float(mean_pressures(problem, [pressed], exact.half_width_mm)[0]),
            exact.mean_over_segment_MPa(exact.half_width_mm),
            _TOLERANCE,
        ),
        compared("Line contact", "half-width [mm]", a, exact.half_width_mm, _TOLERANCE),
        compared(name, "stick zone c/a", c / a, reference.line_stick_ratio(forward, limit), _TOLERANCE),
        compared(
            f"Line contact, back at Q = {returned / limit:.3f} µP",
            "edge of reverse slip c'/a",
            back / a,
            reference.line_stick_ratio_after_reversal(returned, forward, limit),
            _TOLERANCE,
        ),
    )


def cylinder_on_flat(element_mm: float) -> solvers.ContactProblem:
    """Contact problem of a cylindrical pad on a flat, both 8 mm high, with elements of this size under the contact."""
    pad = build_planar(pad_geometry(element_mm))
    specimen = build_planar(PlanarGeometry(Flat(), 8.0, 8.0, pad.geometry.along))
    upper, lower = (solvers.condense(body.mesh, body.patch, MATERIAL) for body in (pad, specimen))
    return solvers.ContactProblem(
        upper=solvers.place(upper, upper=True, axis_angle_rad=0.0),
        lower=solvers.place(lower, upper=False, axis_angle_rad=0.0),
        holder=solvers.Holder(LOAD_N_per_mm),
        friction=FRICTION,
        wear=solvers.WearRates(),
    )


def pad_geometry(element_mm: float) -> PlanarGeometry:
    """Cylindrical pad with elements of this size under the contact."""
    exact = reference.hertz_line(LOAD_N_per_mm, RADIUS_mm, reference.contact_modulus(MATERIAL, MATERIAL))
    a = exact.half_width_mm
    along = GradedAxis(element_mm, 1.25 * a, max(element_mm, 0.25 * a), 2.5 * a)
    return PlanarGeometry(Cylinder(RADIUS_mm, curved_along=True), 5.0, 8.0, along)


def to_force(
    problem: solvers.ContactProblem, state: solvers.ContactState, force_N_per_mm: float
) -> solvers.ContactState:
    """The state after displacing the flat until the tangential force equals `force_N_per_mm`, the last step being
    shortened. Raises ValueError if the force is not reached, as beyond µP.
    """
    start = tangential_force(state)
    step = float(np.copysign(2e-4, force_N_per_mm - start))
    for _ in range(_MOST_STEPS):
        ahead, _reports = solvers.advance(problem, state, state.drive + step, 0.0)
        before, after = tangential_force(state), tangential_force(ahead)
        share = (force_N_per_mm - before) / (after - before) if after != before else np.inf
        if share <= 1.0:
            return solvers.advance(problem, state, state.drive + share * step, 0.0)[0]
        state = ahead
    raise ValueError(f"a tangential force of {force_N_per_mm:g} N/mm was not reached")


def tangential_force(state: solvers.ContactState) -> float:
    """Tangential force on the pad along the motion in N/mm."""
    return float(state.primary_force[:, 0].sum())


def half_width(problem: solvers.ContactProblem, elliptic: Array) -> float:
    """Half-width a in mm of a distribution p0 √(1 − x²/a²), `elliptic` (n,) at the primary's nodes: a² = 4 <x²>."""
    weight = problem.primary.patch.node_areas() * elliptic
    x = problem.primary.node_positions[:, 0]
    x = x - (weight * x).sum() / weight.sum()
    return float(2.0 * np.sqrt((weight * x**2).sum() / weight.sum()))


def _shear(state: solvers.ContactState) -> Array:
    return state.traction[:, 0]


def line_surface_rows(level: Level) -> tuple[Row, ...]:
    """Rows on the tension at the trailing edge of cylinder and flat, in partial slip and in sliding."""
    exact = reference.hertz_line(LOAD_N_per_mm, RADIUS_mm, reference.contact_modulus(MATERIAL, MATERIAL))
    element = exact.half_width_mm / level.line_surface_resolution
    problem = cylinder_on_flat(element)
    state, _ = press(problem, unloaded_state(problem))
    state = to_force(problem, state, _SURFACE_SHARE * FRICTION * LOAD_N_per_mm)
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
                    largest_tension(body, LineSurfaceStress.of(body, MATERIAL), force),
                    _exact_tension(exact, share),
                    level.line_surface_tolerance,
                )
            )
    return tuple(rows)


def bulk_rows(level: Level) -> tuple[Row, ...]:
    """Rows on shift and width of the stick zone, friction work, and edge tension, of a flat under bulk tension with the
    motion.
    """
    exact = reference.hertz_line(LOAD_N_per_mm, RADIUS_mm, reference.contact_modulus(MATERIAL, MATERIAL))
    tension = _BULK_SHARE * FRICTION * exact.peak_pressure_MPa
    a, element = exact.half_width_mm, exact.half_width_mm / level.line_surface_resolution
    problem = cylinder_on_flat(element)
    pressed, _ = press(problem, unloaded_state(problem))
    drive = to_force(problem, pressed, _SURFACE_SHARE * FRICTION * LOAD_N_per_mm).drive
    flat = solvers.BulkStress(MATERIAL, (tension, 0.0, 0.0), plane_strain=True)
    bulk = solvers.Drive(drive, bulk=(flat, solvers.BulkStress(MATERIAL))).mean_bulk
    state, work = pressed, 0.0
    for share in np.linspace(0.0, 1.0, level.slip_increments + 1)[1:]:
        state, reports = advance(problem, state, share * drive, 0.0, bulk=share * bulk)
        work += sum(report.friction_work for report in reports)
    used = abs(tangential_force(state)) / (FRICTION * LOAD_N_per_mm)
    # Tilted normals alone give tractions along x.
    lacking = FRICTION * state.traction[:, 2] - np.abs(_shear(state) - _shear(pressed))
    weight = problem.primary.node_areas * lacking
    centre = float(weight @ problem.primary.node_positions[:, 0] / weight.sum())
    shift, ratio = reference.line_stick_shift(exact, FRICTION, tension), reference.line_stick_ratio(used, 1.0)
    body = build_planar(PlanarGeometry(Flat(), 8.0, 8.0, pad_geometry(element).along))
    surface = LineSurfaceStress.of(body, MATERIAL)
    modulus, force = reference.contact_modulus(MATERIAL, MATERIAL), used * FRICTION * LOAD_N_per_mm
    # Loading rubs a quarter of what a cycle does.
    energy = 0.25 * reference.line_energy_per_cycle(exact, FRICTION, modulus, force, tension)
    found = largest_tension(body, surface, forces_on_bodies(problem, state)[1]) + tension
    name = f"Nowell–Hills, Q = {used:.2f} µP, tension {_BULK_SHARE:g} µp0, mesh a/{level.line_surface_resolution:g}"
    return (
        compared(name, "shift of the stick zone [mm]; error in elements", -centre, shift, 1.0, scale=element),
        compared(name, "stick zone c/a", half_width(problem, lacking) / a, ratio, _TOLERANCE),
        compared(name, "friction work [mJ/mm]", work, energy, level.line_surface_tolerance),
        compared(
            name,
            "tension at the edge, flat [MPa]",
            found,
            _exact_tension(exact, used, shift) + tension,
            level.line_surface_tolerance,
        ),
    )


def largest_tension(
    body: PlanarMesh | BodyMesh, surface: LineSurfaceStress | SurfaceStress, force: Array, axis: int = 0
) -> float:
    """Largest normal stress in MPa along an axis (0 for x, 1 for y) at the edges of a body's contact, tension positive.

    force: (n, 3) on the patch's nodes, in N, or N/mm for a planar body. surface: corrects the stresses between nodes.
    """
    nodes = body.patch.nodes.ravel()
    points, material = integration_points(body.mesh), surface.material
    moved = Interior(body.mesh, material, body.mesh.surface_nodes("grip")).displacements(nodes, force[None])[0]
    stress = points.at_nodes(points.stresses(material, moved))[nodes]
    corrected = surface.under(force)
    edge = corrected.edge()
    near, weights, _ = body.patch.locate(edge)
    found = np.einsum("kc,kcs->ks", weights, stress[near]) + corrected.correction(edge)
    return float(found[:, axis].max())


def _exact_tension(contact: reference.LineContact, share: float, shift_mm: float = 0.0) -> float:
    """Tension at the trailing edge in MPa on first loading to this share of the sliding force, without the bulk stress.

    It is 2 µ p0 √share if the stick zone is centred (shift_mm = 0).
    """
    stress = reference.line_partial_slip_stress(
        -contact.half_width_mm,
        0.0,
        half_width_mm=contact.half_width_mm,
        stick_half_width_mm=contact.half_width_mm * max(1.0 - share, 1e-12) ** 0.5,
        peak_pressure_MPa=contact.peak_pressure_MPa,
        friction=FRICTION,
        poissons_ratio=MATERIAL.poissons_ratio,
        stick_centre_mm=shift_mm,
    )
    return float(stress[0])
