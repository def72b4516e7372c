"""The state that a converged increment leaves, and what is reported of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from solvers.contact.problem import ContactProblem
from solvers.contact_state import ContactState, IncrementReport
from solvers.errors import PatchLeftError
from solvers.newton import NewtonOutcome
from solvers.pairing import Pairing
from solvers.wear import deposited

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def accepted(
    problem: ContactProblem,
    state: ContactState,
    pairing: Pairing,
    outcome: NewtonOutcome,
    drive: float,
    cycles: float,
    overlap_area: float,
    iterations: int,
    pairings: int,
) -> tuple[ContactState, IncrementReport]:
    """The state after the increment, its wear deposited on both surfaces, and the report of it.

    Raises:
        PatchLeftError: the contact has reached the edge of either patch.
    """
    pressed = outcome.traction[:, 2] > 0.0
    if np.any(pressed & ~pairing.inside):
        raise PatchLeftError(
            f"the contact has left the finely meshed patch of the {'lower' if problem.primary_is_upper else 'upper'} "
            f"body at a displacement of {1e3 * drive:.2f} um; give a larger patch (scar_half_width_um)"
        )
    _require_inside_primary(problem, pairing.nodes[pressed], drive)
    traction = np.zeros_like(state.traction)
    traction[pairing.nodes] = outcome.traction
    slid = state.primary_slid.copy()
    slid[pairing.nodes] += outcome.slip_length
    energy = outcome.friction_energy
    wear = deposited(
        state.wear,
        pairing,
        energy,
        outcome.wear_work,
        cycles,
        problem.wear.split(problem.primary_is_upper),
        problem.secondary.patch,
    )
    new = replace(
        state,
        wear=wear,
        drive=drive,
        holder_x=outcome.holder_x,
        holder_z=outcome.height,
        holder_tilt=outcome.tilt,
        holder_rate=(outcome.holder_x - state.holder_x) / (drive - state.drive) if drive != state.drive else 1.0,
        overlap_area=overlap_area,
        traction=traction,
        primary_force=pairing.primary.T @ outcome.traction,
        secondary_force=pairing.secondary.T @ outcome.traction,
        primary_slid=slid,
        secondary_slid=state.secondary_slid
        + (pairing.secondary.T @ outcome.slip_length) / problem.secondary.patch.node_areas(),
    )
    return new, _report(problem, pairing, outcome, energy, iterations, pairings)


def _require_inside_primary(problem: ContactProblem, nodes: IntArray, drive: float) -> None:
    if problem.primary.patch.edge_nodes()[nodes].any():
        raise PatchLeftError(
            f"the contact has reached the edge of the finely meshed patch of the "
            f"{'upper' if problem.primary_is_upper else 'lower'} body at a displacement of {1e3 * drive:.2f} um; "
            "give a larger patch (scar_half_width_um)"
        )


def _report(
    problem: ContactProblem, pairing: Pairing, outcome: NewtonOutcome, energy: Array, iterations: int, pairings: int
) -> IncrementReport:
    force = pairing.areas @ outcome.traction
    pressed = outcome.traction[:, 2] > 0.0
    normals = pairing.frames[:, 0, :]
    pressure = np.einsum("ij,ij->i", outcome.traction, normals) * normals[:, 2]
    position = problem.primary.node_positions[pairing.nodes[pressed]]
    half = 0.5 * np.ptp(position, axis=0) if len(position) else np.zeros(2)
    return IncrementReport(
        tangential_force=float(force[0]),
        normal_force=float(force[2]),
        friction_work=float(pairing.areas @ energy),
        iterations=iterations,
        pairings=pairings,
        active=int(pressed.sum()),
        sticking=outcome.sticking,
        contact_area=float(pairing.areas[pressed].sum()),
        max_pressure=float(pressure.max()),
        half_width_x=float(half[0]),
        half_width_y=float(half[1]),
        force_error=outcome.force_error,
        penetration=outcome.penetration,
        complementarity=outcome.complementarity,
        slip_direction_error=outcome.slip_direction_error,
        elastic_slip=outcome.elastic_slip,
    )
