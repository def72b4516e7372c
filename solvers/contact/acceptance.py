"""The state that a converged increment leaves, its report, and its friction work, wear work and slip node by node.

Works and slips are integrated by the trapezoidal rule in time: half is counted at the nodes paired at the increment's
start, with their pressures and positions, half at those paired at its end. Slip counts only at the friction limit: a
node that first sticks and then slips dissipates the limit times its slip, not the mean of its tractions.

Small-strain normals do not turn with the loaded surfaces, so that sliding nodes move a little along their normals. The
pressure's work on this motion, the lifting work, is mostly given back at other nodes and positions. Its rest over a
closed loop is part of the loop's area: 0.3 % of it under a fresh Hertz contact of steel wires. It is left out where a
node opens or closes. The closure of layers does not count as such a motion; its work is stored.
"""

from dataclasses import replace

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact.linearising import law_at, layers_between, normal_of
from solvers.contact.problem import ContactProblem, facing_offset, levers
from solvers.contact_conditions import ContactOutcome, Linearisation
from solvers.contact_extent import Footprint
from solvers.contact_state import ContactState, IncrementReport, WearState
from solvers.elasticity.pairing import Pairing
from solvers.errors import PatchLeftError
from solvers.jit_cache import compiled
from solvers.laws.friction_law import Friction
from solvers.laws.layers import LayersAtNodes
from solvers.laws.yielding import YieldAtNodes
from solvers.wear import Sliding, deposited


def slid(
    problem: ContactProblem,
    state: ContactState,
    system: Linearisation,
    outcome: ContactOutcome,
    drive: float,
    traction: Array,
    forces: tuple[Array, Array],
) -> tuple[Sliding, Sliding]:
    """Sliding in an increment from `state` to its outcome at `drive` (mm), each half of it: at the nodes paired at its
    start, and at those paired at its end.

    traction: (n, 3) in MPa at its end. forces: (n, 3) nodal forces in N then, of (primary, secondary).
    """
    end, start = system.pairing, system.before
    moved_end, moved_start = system.compliance.moved(outcome.traction, forces)
    step = outcome.holder_x - state.holder_x - (drive - state.drive), outcome.height - state.holder_z
    holder = (*step, outcome.tilt - state.holder_tilt)
    slides = np.zeros(len(traction), dtype=bool)
    slides[end.nodes] = outcome.sliding

    old = state.traction[end.nodes]
    pressure, lifted, _ = _parts(moved_end, moved_end, outcome.traction, end.frames, system.lever, holder)
    if system.layers is not None:
        lifted += _closed(system.layers, outcome.traction, end) - _closed(system.layers, old, end)
    lifted = np.where(outcome.sliding & (old[:, 2] > 0.0), 0.5 * lifted, 0.0)
    last = _sliding(problem, system.friction, end, pressure, 0.5 * outcome.slip_length, lifted)

    before, after = state.traction[start.nodes], traction[start.nodes]
    slip = moved_start + problem.layer_mm_per_MPa * (after - before)
    if state.bulk_step.any():
        offset = facing_offset(problem, state, state.drive, state.holder_x)
        slip += problem.stretched(state.bulk_step, start.nodes, offset)
    closed: float | Array = 0.0
    if system.layers is not None:
        layers = layers_between(problem, state, start, after)
        if problem.layers:
            slip += layers.old_displacement - layers_between(problem, state, start, before).old_displacement
        closed = _closed(layers, after, start) - _closed(layers, before, start)
    lever = levers(problem, state.drive, state.holder_x)[start.nodes]
    pressure, lifted, length = _parts(moved_start, slip, before, start.frames, lever, holder)
    still = after[:, 2] > 0.0
    slides_or_opens = slides[start.nodes] | ~still
    friction = law_at(problem, state, start, state.slip_share, state.drive, state.traction)
    lifted = np.where(still & slides_or_opens, 0.5 * (lifted + closed), 0.0)
    first = _sliding(problem, friction, start, pressure, np.where(slides_or_opens, 0.5 * length, 0.0), lifted)
    return first, last


def _sliding(
    problem: ContactProblem, friction: Friction, pairing: Pairing, pressure: Array, length: Array, lifted: Array
) -> Sliding:
    """Sliding of paired nodes under pressure (k,) in MPa along a length (k,), while they move by `lifted` (k,) along
    their normals; both in mm.
    """
    energy, worn = friction.limit(pressure) * length, problem.wear.law.work_per_slip(friction)
    wear_work = energy if worn is friction else worn.limit(pressure) * length
    return Sliding(pairing, energy, wear_work, length, 0.0 * energy if problem.law.none else pressure * lifted)


def _closed(layers: LayersAtNodes, traction: Array, pairing: Pairing) -> Array:
    """Closure (k,) in mm of layers under tractions (k, 3)."""
    return layers.closure(normal_of(traction, pairing.frames))[0]


@compiled
def _parts(
    moved: Array, slip: Array, traction: Array, frames: Array, lever: Array, holder: tuple[float, float, float]
) -> Array:
    """Three rows (3, k): pressures from tractions (k, 3), normal components of motions `moved` (k, 3), and lengths of
    slips (k, 3) in the tangent planes; mm, MPa.

    holder: its motion along x and z and its change of tilt, which are added to the motions.
    """
    result = np.empty((3, len(moved)))
    for k in range(len(moved)):
        n0, n1, n2 = frames[k, 0, 0], frames[k, 0, 1], frames[k, 0, 2]
        along, up = holder[0], holder[1] + lever[k] * holder[2]
        result[0, k] = max(traction[k, 0] * n0 + traction[k, 1] * n1 + traction[k, 2] * n2, 0.0)
        result[1, k] = (moved[k, 0] + along) * n0 + moved[k, 1] * n1 + (moved[k, 2] + up) * n2
        x, y, z = slip[k, 0] + along, slip[k, 1], slip[k, 2] + up
        normal = x * n0 + y * n1 + z * n2
        x, y, z = x - normal * n0, y - normal * n1, z - normal * n2
        result[2, k] = np.sqrt(x * x + y * y + z * z)
    return result


def largest_within(pressure: Array) -> float:
    """Largest pressure in MPa away from a contact's rim, from nodal pressures (n_a, n_t) of a patch, which are 0 out of
    contact.

    A node counts by its own pressure if all its neighbours touch; besides, means over the nodes of an element count. On
    a patch of one line, neighbours lie along it only.
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
    outcome: ContactOutcome,
    drive: float,
    cycles: float,
    overlap_area: float,
    slip_share: Array,
    iterations: int,
) -> tuple[ContactState, IncrementReport]:
    """The state after a converged increment, with wear and prints added on both surfaces, and the increment's report.

    drive: displacement at its end, mm. cycles: number of times that its wear counts. overlap_area, slip_share: as in
    `ContactState`. iterations: Newton steps that it took, for the report. Raises PatchLeftError if the contact has
    reached the edge of either patch.
    """
    pairing = system.pairing
    require_inside_patches(problem, pairing, np.flatnonzero(outcome.traction[:, 2] > 0.0), drive)
    traction = np.zeros_like(state.traction)
    traction[pairing.nodes] = outcome.traction
    forces = pairing.own.spread(outcome.traction), pairing.opposite.spread(outcome.traction)
    parts = slid(problem, state, system, outcome, drive, traction, forces)
    primary_slid, secondary_slid = state.primary_slid.copy(), state.secondary_slid
    for each in parts:
        primary_slid[each.pairing.nodes] += each.length
        secondary_slid = secondary_slid + each.pairing.opposite.spread(each.length) / problem.secondary.node_areas
    bodies = problem.primary, problem.secondary
    wear = deposited(state.wear, parts, cycles, problem.wear, bodies, problem.retained)
    if system.layers is not None and system.layers.yielding is not None:
        wear = printed(problem, wear, pairing, system.layers.yielding, normal_of(outcome.traction, pairing.frames))
    new = replace(
        state,
        wear=wear,
        drive=drive,
        holder_x=outcome.holder_x,
        holder_z=outcome.height,
        holder_tilt=outcome.tilt,
        holder_rate=(outcome.holder_x - state.holder_x) / (drive - state.drive) if drive != state.drive else 1.0,
        overlap_area=overlap_area,
        slip_share=slip_share,
        traction=traction,
        primary_force=forces[0],
        secondary_force=forces[1],
        primary_slid=primary_slid,
        secondary_slid=secondary_slid,
        core=state.core & (traction[:, 2] > 0.0) & (primary_slid == state.primary_slid),
    )
    friction_work = sum(part.friction_work for part in parts)
    return new, _report(problem, drive, pairing, outcome, friction_work, iterations)


def printed(
    problem: ContactProblem, wear: WearState, pairing: Pairing, yielding: YieldAtNodes, pressure: Array
) -> WearState:
    """The wear state with the prints that pressures (k,) in MPa above the limit at paired nodes leave on both bodies,
    shared as `problem.limit` says; unchanged where nothing yields.

    The secondary's part is spread over its elements; the primary takes the difference, so that the gaps at the nodes
    become exactly those in which they bear their pressure limits.
    """
    closure, _ = yielding.closure(pressure)
    own, other = wear.prints
    if not closure.any() or problem.limit is None or own is None or other is None:
        return wear
    upright = closure / pairing.frames[:, 0, 2]
    share = problem.limit.share(upper=problem.primary_is_upper)
    spread, wanted = np.zeros(problem.secondary.patch.size), (1.0 - share) * upright
    # Times that a print on the secondary is corrected for what its elements have spread of it.
    for _ in range(3):
        lacking = wanted - pairing.depths.averaged(spread) / pairing.areas
        spread = spread + pairing.opposite.spread(lacking) / problem.secondary.node_areas
    rest = np.zeros(problem.primary.patch.size)
    if share > 0.0:
        rest[pairing.nodes] = upright - pairing.depths.averaged(spread) / pairing.areas
    return replace(
        wear,
        primary_print=own + rest.reshape(own.shape),
        secondary_print=other + spread.reshape(other.shape),
        plastic_mJ=wear.plastic_mJ + float(pairing.areas @ yielding.work(pressure)),
    )


def require_inside_patches(problem: ContactProblem, pairing: Pairing, pressed: IntArray, drive: float) -> None:
    """Raise PatchLeftError unless all nodes `pressed`, indices into the pairing's, lie off their patch's edge and face
    the other patch with their whole support. drive: displacement in mm, for the message.
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
    outcome: ContactOutcome,
    friction_work: float,
    iterations: int,
) -> IncrementReport:
    force = pairing.areas @ outcome.traction
    pressed = outcome.traction[:, 2] > 0.0
    normals = pairing.frames[:, 0, :]
    pressure = np.einsum("ij,ij->i", outcome.traction, normals) * normals[:, 2]
    everywhere = np.zeros(problem.primary.patch.size)
    everywhere[pairing.nodes] = np.where(pressed, pressure, 0.0)
    return IncrementReport(
        drive=drive,
        tangential_force=float(force[0]),
        normal_force=float(force[2]),
        friction_work=friction_work,
        iterations=iterations,
        active=int(pressed.sum()),
        sticking=outcome.sticking,
        max_pressure=float(pressure.max()),
        inner_pressure=largest_within(everywhere.reshape(problem.primary.patch.shape)),
        force_error=outcome.force_error,
        penetration=outcome.penetration,
        complementarity=outcome.complementarity,
        slip_direction_error=outcome.slip_direction_error,
        elastic_slip=outcome.elastic_slip,
        footprint=Footprint(problem.primary.patch, np.maximum(everywhere, 0.0), problem.primary.world_to_patch),
    )
