"""Cattaneo–Mindlin partial slip of equal wires crossed at right angles behind a rigid rig.

The drive is prescribed, so forces come out near the intended share of µP, and the closed forms are evaluated at the
force that was computed.
"""

import numpy as np

from geometry.arrays import Array
from solvers import CondensedBody, ContactProblem, ContactState, Holder, advance, press, unloaded_state
from solvers.pairing import pair
from wirewear import reference
from wirewear.verification.hertz import (
    LOAD_N,
    STEEL,
    CONTACT_RADIUS_mm,
    condensed,
    crossed,
    crossed_bulk_compliance,
    element_mm,
    wire_geometry,
)
from wirewear.verification.rows import Level, Row, compared

FRICTION = 0.6
_SHARES = (0.5, 0.9)
_INITIAL_SHARE = 0.01
_COMPLIANCE_TOLERANCE = 0.04


def partial_slip_rows(level: Level) -> tuple[Row, ...]:
    """Initial compliance; stick radius, displacement and energy of a closed cycle at two tangential forces."""
    load, radius = LOAD_N * level.enlarged**3, CONTACT_RADIUS_mm * level.enlarged
    modulus = reference.tangential_contact_modulus(STEEL, STEEL)
    exact = reference.partial_slip_point(load, FRICTION, radius, modulus)
    body = condensed(wire_geometry(level.hertz_resolutions[-1]))
    bulk = crossed_bulk_compliance(body, normal=False, contact_radius_mm=radius)
    problem = crossed(body, body, Holder(load), friction=FRICTION)
    return sliding_rows(problem, exact, bulk, body, level)


def sliding_rows(
    problem: ContactProblem,
    exact: reference.PartialSlipPoint,
    bulk: float,
    body: CondensedBody,
    level: Level,
    shares: tuple[float, ...] = _SHARES,
    of: str = "Mindlin",
) -> tuple[Row, ...]:
    """Bodies in partial slip beside the closed form; `bulk` is what is not the contact's in their compliance."""
    pressed, _ = press(problem, unloaded_state(problem))
    rows = [_initial_compliance(problem, pressed, exact, bulk, of)]
    for share in shares:
        rows += _at_share(problem, pressed, exact, bulk, share, body, level, of)
    return tuple(rows)


def _initial_compliance(
    problem: ContactProblem, pressed: ContactState, exact: reference.PartialSlipPoint, bulk: float, of: str
) -> Row:
    force = _INITIAL_SHARE * exact.limit_N
    drive = float(reference.loading_displacement(exact, force)) + bulk * force
    state, _ = advance(problem, pressed, drive, 0.0)
    computed = _tangential(state)
    truth = float(reference.loading_displacement(exact, computed)) / computed
    raw = drive / computed
    name = f"{of}, Q = {computed / exact.limit_N:.3f} µP"
    return compared(name, "compliance u/Q [mm/N]", raw - bulk, truth, _COMPLIANCE_TOLERANCE, raw=raw)


def _at_share(
    problem: ContactProblem,
    pressed: ContactState,
    exact: reference.PartialSlipPoint,
    bulk: float,
    share: float,
    body: CondensedBody,
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


def _along(problem: ContactProblem, state: ContactState, drives_mm: Array) -> tuple[ContactState, float]:
    """State at the end of a path and the friction work on it, mJ."""
    work = 0.0
    for drive in drives_mm:
        state, reports = advance(problem, state, float(drive), 0.0)
        work += sum(report.friction_work for report in reports)
    return state, work


def _tangential(state: ContactState) -> float:
    return float(state.primary_force[:, 0].sum())


def _stick_radius(problem: ContactProblem, state: ContactState) -> float:
    """Radius of the circle with the area of the nodes whose friction stays below its limit."""
    nodes = np.flatnonzero(state.traction[:, 2] > 0.0)
    wear = state.wear
    offset = problem.offset(state.drive, state.holder_x)
    pairing = pair(problem.surface, problem.secondary, nodes, offset, wear.primary_depth, wear.secondary_depth)
    local = np.einsum("ikj,ij->ik", pairing.frames, state.traction[nodes])
    sticking = np.linalg.norm(local[:, 1:], axis=1) < problem.friction * local[:, 0] * (1.0 - 1e-4)
    return float(np.sqrt(pairing.areas[sticking].sum() / np.pi))
