"""The state that a converged increment leaves, and what is reported of it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact.problem import ContactProblem
from solvers.contact.sliding import slid
from solvers.contact_state import ContactState, IncrementReport
from solvers.errors import PatchLeftError
from solvers.kept_code import compiled
from solvers.newton import Linearisation, NewtonOutcome
from solvers.pairing import Pairing
from solvers.wear import Sliding, deposited


def largest_within(pressure: Array) -> float:
    """The largest pressure inside a contact, from nodal pressures (n_a, n_t) on the lines of a patch, 0 out of contact.

    Of nodes whose neighbours all touch their own pressure counts, of all others the means over elements. A patch of one
    line has neighbours along it only.
    """
    return float(_largest_within(np.ascontiguousarray(pressure)))


@compiled
def _largest_within(pressure: Array) -> float:
    rows, columns = pressure.shape
    beside_a, beside_t = min(rows - 1, 1), min(columns - 1, 1)
    largest = 0.0
    for i in range(rows - beside_a):
        for j in range(columns - beside_t):
            here = 0.5 * (pressure[i + beside_a, j] + pressure[i, j])
            next_to = 0.5 * (pressure[i + beside_a, j + beside_t] + pressure[i, j + beside_t])
            largest = max(largest, 0.5 * (next_to + here))
    for i in range(beside_a, rows - beside_a):
        for j in range(beside_t, columns - beside_t):
            if pressure[i, j] > largest:
                all_touch = True
                for a in range(i - beside_a, i + beside_a + 1):
                    for t in range(j - beside_t, j + beside_t + 1):
                        all_touch &= pressure[a, t] > 0.0
                if all_touch:
                    largest = pressure[i, j]
    return largest


def accepted(
    problem: ContactProblem,
    state: ContactState,
    system: Linearisation,
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
    pairing = system.pairing
    require_inside_patches(problem, pairing, np.flatnonzero(outcome.traction[:, 2] > 0.0), drive)
    traction = np.zeros_like(state.traction)
    traction[pairing.nodes] = outcome.traction
    forces = pairing.own.spread(outcome.traction), pairing.opposite.spread(outcome.traction)
    parts = slid(problem, state, system, outcome, drive, forces)
    primary_slid, secondary_slid = _slid_so_far(problem, state, parts)
    wear = deposited(state.wear, parts, cycles, problem.wear.split(problem.primary_is_upper), problem.secondary.patch)
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
        primary_force=forces[0],
        secondary_force=forces[1],
        primary_slid=primary_slid,
        secondary_slid=secondary_slid,
        core=state.core & (traction[:, 2] > 0.0) & (primary_slid == state.primary_slid),
    )
    friction_work = sum(part.friction_work for part in parts)
    return new, _report(problem, drive, pairing, outcome, friction_work, iterations, pairings)


def _slid_so_far(problem: ContactProblem, state: ContactState, parts: Sequence[Sliding]) -> tuple[Array, Array]:
    """Distance that each node of the primary and of the secondary has slid, (n,), mm."""
    primary, secondary = state.primary_slid.copy(), state.secondary_slid
    for part in parts:
        primary[part.pairing.nodes] += part.length
        secondary = secondary + part.pairing.opposite.spread(part.length) / problem.secondary.node_areas
    return primary, secondary


def require_inside_patches(problem: ContactProblem, pairing: Pairing, pressed: IntArray, drive: float) -> None:
    """See that pressed nodes, by their numbers in the pairing, lie inside their patch and face the other one.

    Raises:
        PatchLeftError: the contact has reached the edge of either patch.
    """
    if not pairing.inside[pressed].all():
        raise PatchLeftError(
            f"the contact has left the finely meshed patch of the {'lower' if problem.primary_is_upper else 'upper'} "
            f"body at a displacement of {1e3 * drive:.2f} um; give a larger patch (scar_half_width_um)"
        )
    if problem.primary.edge_nodes[pairing.nodes[pressed]].any():
        raise PatchLeftError(
            f"the contact has reached the edge of the finely meshed patch of the "
            f"{'upper' if problem.primary_is_upper else 'lower'} body at a displacement of {1e3 * drive:.2f} um; "
            "give a larger patch (scar_half_width_um)"
        )


def _report(
    problem: ContactProblem,
    drive: float,
    pairing: Pairing,
    outcome: NewtonOutcome,
    friction_work: float,
    iterations: int,
    pairings: int,
) -> IncrementReport:
    force = pairing.areas @ outcome.traction
    pressed = outcome.traction[:, 2] > 0.0
    normals = pairing.frames[:, 0, :]
    pressure = np.einsum("ij,ij->i", outcome.traction, normals) * normals[:, 2]
    position = problem.primary.node_positions[pairing.nodes[pressed]]
    everywhere = np.zeros(problem.primary.patch.size)
    everywhere[pairing.nodes] = pressure
    half = 0.5 * np.ptp(position, axis=0) if len(position) else np.zeros(2)
    return IncrementReport(
        drive=drive,
        tangential_force=float(force[0]),
        normal_force=float(force[2]),
        friction_work=friction_work,
        iterations=iterations,
        pairings=pairings,
        active=int(pressed.sum()),
        sticking=outcome.sticking,
        contact_area=float(pairing.areas[pressed].sum()),
        max_pressure=float(pressure.max()),
        inner_pressure=largest_within(everywhere.reshape(problem.primary.patch.shape)),
        half_width_x=float(half[0]),
        half_width_y=float(half[1]),
        force_error=outcome.force_error,
        penetration=outcome.penetration,
        complementarity=outcome.complementarity,
        slip_direction_error=outcome.slip_direction_error,
        elastic_slip=outcome.elastic_slip,
    )
