"""Cattaneo–Mindlin partial slip of equal wires crossed at right angles, and their final shape under wear.

The drive is prescribed behind a rigid rig, so that the closed forms are evaluated at the computed force. Wear at
constant approach ends at a known shape that depends steeply on the radius of the stuck core: 1 % of the radius is 10 %
of the worn volume. The core's edge is resolved by whole nodes, which limits the volume's accuracy.
"""

from math import pi, sqrt
from typing import Any

import numpy as np

import solvers
from geometry.arrays import Array
from solvers.elasticity.pairing import pair
from wirewear import reference
from wirewear.results import RunResult
from wirewear.simulation import last_of, simulate
from wirewear.test import LineStudy, study_from_tables
from wirewear.verification.hertz import (
    LOAD_N,
    STEEL,
    CONTACT_MODULUS_MPa,
    CONTACT_RADIUS_mm,
    RADIUS_mm,
    condensed,
    crossed,
    crossed_bulk_compliance,
    element_mm,
    wire_geometry,
)
from wirewear.verification.rows import Level, Row, compared

_MIRROR_TOLERANCE = 0.02
_JUMP_TOLERANCE = 0.005
#: Columns of the evolution.
_PRESSURES = {"mid_stroke_pressure_MPa": "pressure at mid-stroke", "max_mean_pressure_MPa": "largest mean pressure"}
#: What is made finer. The tolerance of jumps goes with the square of their change.
_FINER = {
    "half the elements' size": {"mesh_refinement": 2.0},
    "twice the positions": {"increments_refinement": 2.0},
    "half the jumps": {"jump_tolerance": 0.25 * _JUMP_TOLERANCE},
}

_FRICTION = 0.6
_APPROACH_mm = CONTACT_RADIUS_mm**2 / RADIUS_mm
#: About two thirds of the fresh contact stick.
_AMPLITUDE_mm = 2.0e-4
_DRIVE = solvers.Drive(_AMPLITUDE_mm)
_RATE_mm3_per_mJ = 1.5e-7
_INCREMENTS = 16
#: Jumps of growing size until next to nothing wears.
_JUMPS = tuple(9.0 * 2.5**k for k in range(11))
_DEPTH_TOLERANCE = 0.5

FRICTION = 0.6
_SHARES = (0.5, 0.9)
_COMPLIANCE_TOLERANCE = 0.04


def worn_pressure_rows(level: Level) -> tuple[Row, ...]:
    """Rows on the mirror error of a worn line contact's pressures, and on pressures beside three finer runs."""
    cycles = level.worn_line_cycles
    name, own = f"Worn line contact, {cycles} cycles", _worn(cycles, {})
    mirror = compared(
        name, "mirror error of the pressures", own.quality["mirror_error"], 0.0, _MIRROR_TOLERANCE, scale=1.0
    )
    finer = {what: _worn(cycles, mesh) for what, mesh in _FINER.items()}
    pressures = (
        compared(name, f"{quantity} [MPa], exact: {what}", last_of(column)(own), last_of(column)(other), 0.05)
        for what, other in finer.items()
        for column, quantity in _PRESSURES.items()
    )
    return (mirror, *pressures)


def _worn(cycles: int, mesh: dict[str, float]) -> RunResult:
    return simulate(_study(cycles, {"jump_tolerance": _JUMP_TOLERANCE} | mesh), fidelity="quick")


def _study(cycles: int, mesh: dict[str, float]) -> LineStudy:
    """Study of a steel cylinder in gross slip on a rigid rig, with this table of the mesh."""
    steel = {"youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3}
    tables: dict[str, Any] = {
        "format": 1,
        "name": "worn line contact",
        "kind": "cylinder-on-flat",
        "pad": {"radius_mm": 6.0, **steel},
        "specimen": steel,
        "conditions": {"normal_load_N_per_mm": 20.0, "displacement_amplitude_um": 30.0, "cycles": cycles},
        "contact": {"friction": 0.6},
        "wear": {"pad_energy_mm3_per_J": 2e-5, "specimen_energy_mm3_per_J": 4e-5},
        "log": {"loop_cycles": [1, cycles]},
        "mesh": mesh,
    }
    study: LineStudy = study_from_tables(tables, "the reference problem")
    return study


def partial_slip_wear_rows(level: Level) -> tuple[Row, ...]:
    """Rows on the radius of the stuck core, worn volume and largest depth of both wires after wear has ended."""
    body = condensed(wire_geometry(level.partial_slip_wear_resolution))
    bulk = [crossed_bulk_compliance(body, normal=n, contact_radius_mm=CONTACT_RADIUS_mm) for n in (True, False)]
    shear = reference.tangential_contact_modulus(STEEL, STEEL)
    contact = reference.WearingContact(RADIUS_mm, CONTACT_MODULUS_MPa, shear, _FRICTION, _AMPLITUDE_mm, *bulk)
    exact = contact.under_approach(_APPROACH_mm)
    rates = solvers.WearRates(_RATE_mm3_per_mJ, _RATE_mm3_per_mJ)
    holder = solvers.Holder(LOAD_N, approach_mm=_APPROACH_mm)
    problem = crossed(body, body, holder, friction=_FRICTION, wear=rates)
    worn = _worn_out(problem)
    wear, name = worn.wear, f"Partial slip, worn out, {CONTACT_RADIUS_mm / element_mm(body):.1f} elements a radius"
    radius = sqrt(float(problem.surface.areas[worn.core].sum()) / pi)
    volume = wear.primary_volume_mm3 + wear.secondary_volume_mm3
    # Equal wires crossed at right angles: what is axial on one is transverse on the other.
    depth = float((wear.primary_depth + wear.secondary_depth.T).max())
    size = element_mm(body)
    return (
        compared(name, "radius that sticks [mm]; error in elements", radius, exact.stick_radius_mm, 1.0, scale=size),
        compared(name, "worn volume of both wires [mm³]", volume, exact.volume_mm3, level.partial_slip_wear_tolerance),
        compared(name, "largest depth of both wires [mm]", depth, exact.deepest_mm[0], _DEPTH_TOLERANCE),
    )


def _worn_out(problem: solvers.ContactProblem) -> solvers.ContactState:
    pressed, _ = solvers.press(problem, solvers.unloaded_state(problem))
    state, done, guide = solvers.first_quarter(problem, pressed, _DRIVE, _INCREMENTS), 1.0, None
    symmetry = solvers.symmetry_of(problem)
    for cycles in _JUMPS:
        kept = solvers.kept_by(symmetry, state)
        start, trace = solvers.closed_trace(problem, state, _DRIVE, _INCREMENTS, kept, guide=guide)
        jump = solvers.jump_cycles(lambda *_: problem, start, trace, kept, done, cycles)
        state, guide, done = jump.state, jump.guide, done + cycles
    return solvers.closed_trace(problem, state, _DRIVE, _INCREMENTS, solvers.kept_by(symmetry, state), guide=guide)[0]


def partial_slip_rows(level: Level) -> tuple[Row, ...]:
    """Rows on initial compliance, and on stick radius, displacement and energy of a cycle at two force amplitudes."""
    load, radius = LOAD_N * level.enlarged**3, CONTACT_RADIUS_mm * level.enlarged
    modulus = reference.tangential_contact_modulus(STEEL, STEEL)
    exact = reference.partial_slip_point(load, FRICTION, radius, modulus)
    body = condensed(wire_geometry(level.hertz_resolutions[-1]))
    bulk = crossed_bulk_compliance(body, normal=False, contact_radius_mm=radius)
    problem = crossed(body, body, solvers.Holder(load), friction=FRICTION)
    return sliding_rows(problem, exact, bulk, body, level)


def sliding_rows(
    problem: solvers.ContactProblem,
    exact: reference.PartialSlipPoint,
    bulk: float,
    body: solvers.CondensedBody,
    level: Level,
    shares: tuple[float, ...] = _SHARES,
    of: str = "Mindlin",
) -> tuple[Row, ...]:
    """Rows that compare a solved circular contact in partial slip with the closed form `exact`.

    The first row is on the initial tangential compliance; for each force amplitude in `shares`, of the friction limit
    µP, follow rows on stick radius, displacement and energy of a closed cycle. bulk: tangential compliance of the
    bodies beyond half-spaces, mm/N. body: the condensed body of the problem. of: name of the theory in the rows.
    """
    pressed, _ = solvers.press(problem, solvers.unloaded_state(problem))
    rows = [_initial_compliance(problem, pressed, exact, bulk, of)]
    for share in shares:
        rows += _at_share(problem, pressed, exact, bulk, share, body, level, of)
    return tuple(rows)


def _initial_compliance(
    problem: solvers.ContactProblem,
    pressed: solvers.ContactState,
    exact: reference.PartialSlipPoint,
    bulk: float,
    of: str,
) -> Row:
    force = 0.01 * exact.limit_N
    drive = float(reference.loading_displacement(exact, force)) + bulk * force
    state, _ = solvers.advance(problem, pressed, drive, 0.0)
    computed = _tangential(state)
    truth = float(reference.loading_displacement(exact, computed)) / computed
    raw = drive / computed
    name = f"{of}, Q = {computed / exact.limit_N:.3f} µP"
    return compared(name, "compliance u/Q [mm/N]", raw - bulk, truth, _COMPLIANCE_TOLERANCE, raw=raw)


def _at_share(
    problem: solvers.ContactProblem,
    pressed: solvers.ContactState,
    exact: reference.PartialSlipPoint,
    bulk: float,
    share: float,
    body: solvers.CondensedBody,
    level: Level,
    of: str,
) -> list[Row]:
    target = share * exact.limit_N
    amplitude = float(reference.loading_displacement(exact, target)) + bulk * target
    path = amplitude * np.arange(1, level.slip_increments + 1) / level.slip_increments
    loaded, _ = _along(problem, pressed, path)
    force = _tangential(loaded)
    name = f"{of}, Q = {force / exact.limit_N:.3f} µP"
    radius = float(reference.stick_radius(exact, force))
    raw = amplitude / force
    # From the end of the stroke and back, in increments of twice the size as the branch is twice as long.
    back = amplitude * (1.0 - 2.0 * np.arange(1, level.slip_increments + 1) / level.slip_increments)
    unloaded, work_back = _along(problem, loaded, back)
    reloaded, work_forth = _along(problem, unloaded, -back)
    reversal = 0.5 * (_tangential(reloaded) - _tangential(unloaded))
    return [
        compared(
            name,
            "stick radius [mm]; error in elements",
            _stick_radius(problem, loaded),
            radius,
            1.0,
            scale=element_mm(body),
        ),
        compared(
            name,
            "compliance u/Q [mm/N]",
            raw - bulk,
            float(reference.loading_displacement(exact, force)) / force,
            _COMPLIANCE_TOLERANCE,
            raw=raw,
        ),
        compared(
            name,
            "energy of unloading and reloading [mJ]",
            work_back + work_forth,
            reference.energy_per_cycle(exact, reversal),
            level.slip_energy_tolerance,
        ),
    ]


def _along(
    problem: solvers.ContactProblem, state: solvers.ContactState, drives_mm: Array
) -> tuple[solvers.ContactState, float]:
    """State at the end of a path of drive displacements (n,), and the friction work on it in mJ."""
    work = 0.0
    for drive in drives_mm:
        state, reports = solvers.advance(problem, state, float(drive), 0.0)
        work += sum(report.friction_work for report in reports)
    return state, work


def _tangential(state: solvers.ContactState) -> float:
    return float(state.primary_force[:, 0].sum())


def _stick_radius(problem: solvers.ContactProblem, state: solvers.ContactState) -> float:
    """Radius of the circle whose area is that of the nodes with friction below its limit."""
    nodes = np.flatnonzero(state.traction[:, 2] > 0.0)
    wear = state.wear
    offset = problem.offset(state.drive, state.holder_x)
    pairing = pair(problem.surface, problem.secondary, nodes, offset, wear.primary_depth, wear.secondary_depth)
    local = np.einsum("ikj,ij->ik", pairing.frames, state.traction[nodes])
    sticking = np.linalg.norm(local[:, 1:], axis=1) < problem.friction * local[:, 0] * (1.0 - 1e-4)
    return float(np.sqrt(pairing.areas[sticking].sum() / np.pi))
