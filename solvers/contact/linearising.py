"""The linear system that an increment poses for one pairing of the surfaces, with friction and layers at its nodes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact.between_nodes import WithinElements
from solvers.contact.problem import ContactProblem, faced, facing_offset, levers
from solvers.contact_conditions import Linearisation
from solvers.contact_state import ContactState
from solvers.elasticity.compliance import PairedCompliance
from solvers.elasticity.pairing import Pairing
from solvers.jit_cache import compiled
from solvers.laws.friction_law import Friction
from solvers.laws.layers import LayersAtNodes, layers_at_nodes
from solvers.laws.local_state import LocalState
from solvers.laws.yielding import YieldAtNodes


def paired_before(problem: ContactProblem, state: ContactState) -> Pairing:
    """The pairing, at the state's own drive and holder position, of the nodes that carry load in it."""
    loaded = np.flatnonzero(state.traction[:, 2] > 0.0)
    return faced(problem, state, loaded, state.drive, state.holder_x, state.holder_tilt)


def linearised(
    problem: ContactProblem,
    state: ContactState,
    before: Pairing | None,
    pairing: Pairing,
    drive: float,
    holder_x: float,
    prescribed_height: float | None,
    slip_share: Array,
    guess: Array,
) -> Linearisation:
    """The linear system of a pairing, made with the holder at `holder_x` (mm), for a step from `state` to `drive` (mm).

    before: pairing of the nodes loaded before the step; None if these are among those of `pairing`, and go on facing
    each other as they did. prescribed_height: of the holder, in mm, in place of the load;
    None: loaded, or lowered by the holder's own approach. slip_share, guess: (n,) slip per drive's motion and (n, 3)
    tractions in MPa, on which friction may depend; see `ContactState`.
    """
    holder = problem.holder.under(state.load_share)
    if prescribed_height is None and holder.approach_mm is not None:
        prescribed_height = -holder.approach_mm
    bodies, forces = (problem.primary, problem.secondary), (state.primary_force, state.secondary_force)
    traction, still = state.traction[pairing.nodes], None
    if before is None:
        rows = np.flatnonzero(traction[:, 2] > 0.0)
        before, still = pairing.among(rows), (rows, traction)
    compliance = PairedCompliance(pairing, before, bodies, forces, problem.layer_mm_per_MPa, still)
    before_step = law_at(problem, state, pairing, state.slip_share, state.drive, state.traction)
    limit = before_step.limit(normal_of(traction, pairing.frames))
    old_displacement = _old_displacement(
        *(compliance.old, compliance.old_before, problem.layer_mm_per_MPa, traction, limit),
        *(pairing.nodes, before.nodes, pairing.frames),
    )
    if state.bulk_step.any():
        offset = facing_offset(problem, state, drive, holder_x)
        old_displacement -= problem.stretched(state.bulk_step, pairing.nodes, offset)
    return Linearisation(
        pairing=pairing,
        before=before,
        compliance=compliance,
        old_displacement=old_displacement,
        friction=law_at(problem, state, pairing, slip_share, drive, guess),
        paired_holder_x=holder_x,
        old_holder_x=state.holder_x,
        old_height=state.holder_z,
        drive_step=drive - state.drive,
        old_tilt=state.holder_tilt,
        lever=levers(problem, drive, holder_x)[pairing.nodes],
        holder=holder,
        pressed_height=state.pressed_z,
        prescribed_height=prescribed_height,
        old_place_in_play=holder.place_in_play_mm(
            state.holder_x, state.holder_tilt, float(state.primary_force[:, 0].sum())
        ),
        layers=layers_between(problem, state, pairing, traction) if problem.layers or problem.limit else None,
        late=_late(problem, state, pairing, drive - holder_x, compliance.old),
    )


def _late(
    problem: ContactProblem, state: ContactState, pairing: Pairing, ahead: float, displacement: Array
) -> Array | None:
    """What nodes that carry nothing in `state` slip before they touch, see `Linearisation.late`; None where it is
    nothing.

    ahead: of the drive before the holder where the bodies are paired, mm. displacement: (k, 3) in mm before the
    increment. Bodies that have parted stick from where they meet.
    """
    apart = state.traction[pairing.nodes, 2] == 0.0
    if problem.friction == 0.0 or not apart.any() or apart.all():
        return None
    normals, lever = pairing.frames[:, 0], levers(problem, state.drive, state.holder_x)[pairing.nodes]
    rigid = pairing.gap + pairing.gap_rate * (ahead - state.drive + state.holder_x)
    rigid += state.holder_z + lever * state.holder_tilt
    gap = np.where(apart, normals[:, 2] * rigid + np.einsum("ij,ij->i", displacement, normals), 0.0)
    along, _, across = problem.nodal_compliance
    return np.maximum(gap, 0.0) * (along / across) if gap.max() > 0.0 else None


def law_at(
    problem: ContactProblem, state: ContactState, pairing: Pairing, slip_share: Array, drive: float, traction: Array
) -> Friction:
    """The friction law at paired nodes, with the coefficients that their local state at `drive` (mm) gives.

    slip_share: (n,) slip of the primary's nodes per motion of the drive. traction: (n, 3) latest tractions in MPa.
    """
    nodes, timing = pairing.nodes, problem.timing
    local = LocalState(
        state.wear,
        lambda field: field[nodes],
        lambda field: pairing.opposite.averaged(field) / pairing.areas,
        lambda: timing.speed_mm_per_s(drive, falling=bool(slip_share.min() < 0.0)) * np.abs(slip_share[nodes]),
        lambda: np.maximum(normal_of(traction[nodes], pairing.frames), 0.0),
        problem.primary_is_upper,
        problem.cycle,
        problem.fields,
    )
    law = problem.law_at(local)
    if len(state.grip):
        law = replace(law, coefficient=law.coefficient * state.grip[nodes])
    if law.law.proportional and problem.wear.law.work_per_slip(law).law.proportional:
        return law
    return replace(law, within=within_elements(problem, [state], np.zeros(len(nodes), dtype=int)))


def within_elements(problem: ContactProblem, states: Sequence[ContactState], position: IntArray) -> WithinElements:
    """Pressure within the primary's elements around k nodes; position: (k,) index of each node's state in `states`.

    Pressures are tractions along z: slopes are small where pressure vanishes.
    """
    wear = states[0].wear
    worn = float(wear.primary_depth.max() + wear.secondary_depth.max())
    # From half of the approach on, scars decide where the bodies touch.
    fresh = max(1.0 - 2.0 * worn / max(-states[0].holder_z, 1e-300), 0.0)
    return WithinElements(problem.primary.patch, [state.traction[:, 2] for state in states], position, fresh)


def sliding_force(problem: ContactProblem, state: ContactState) -> float:
    """Tangential force in N at which the contact of a state would slide as a whole, had its surfaces never slid."""
    pressure = state.traction[:, 2]
    within = within_elements(problem, [state], np.zeros(len(pressure), dtype=np.int64))
    return float(problem.surface.areas @ replace(problem.law, within=within).limit(pressure))


def stuck_share(problem: ContactProblem, state: ContactState) -> float:
    """Size (a length) of the core over that of the contact at the end of a first loading, from 0, also without core, to
    1.

    From the friction force and its limit, in a contact at a point: the force is the limit less what the limit of a
    contact as small as the core would be, and that grows with the cube of its size (Jäger; Mindlin and Deresiewicz
    1953).
    """
    limit, force = sliding_force(problem, state), np.linalg.norm(state.primary_force.sum(axis=0)[:2])
    return max(1.0 - float(force) / limit, 0.0) ** (1.0 / 3.0) if state.core.any() else 0.0


def layers_between(problem: ContactProblem, state: ContactState, pairing: Pairing, traction: Array) -> LayersAtNodes:
    """The layers at k paired nodes, with the limits that yielding sets there. traction: (k, 3) in MPa, before the
    increment.
    """
    primary, secondary = problem.bedded(state.wear)
    own, other = primary.ravel()[pairing.nodes], pairing.opposite.averaged(secondary.ravel()) / pairing.areas
    yielding = yield_between(problem, state, pairing)
    return layers_at_nodes(problem.layers, own + other, traction, pairing.frames[:, 0, :], yielding)


def yield_between(problem: ContactProblem, state: ContactState, pairing: Pairing) -> YieldAtNodes | None:
    """The pressure at which metal yields at k paired nodes, by the permanent depths that it already has; None for
    elastic bodies.
    """
    primary, secondary = state.wear.prints
    if problem.limit is None or primary is None or secondary is None:
        return None
    printed = primary.ravel()[pairing.nodes] + pairing.depths.averaged(secondary.ravel()) / pairing.areas
    return problem.limit.at_nodes(problem.holder.under(state.load_share).normal_load_N, printed)


@compiled
def _old_displacement(
    old: Array,
    old_before: Array,
    layer: float,
    traction: Array,
    limit: Array,
    nodes: IntArray,
    nodes_before: IntArray,
    frames: Array,
) -> Array:
    """Displacement (k, 3) in mm of surfaces and layer at nodes under the tractions before the increment, `traction` (k,
    3).

    old: (k, 3) displacements where the nodes are now, old_before: (l, 3) where the nodes loaded before were then;
    limit: (k,) of friction. The first are taken, since slip follows from material velocities, except at nodes that
    stuck: these face the same point as before, and the strain along the bodies' rigid motion would make them creep a
    little in every cycle.
    """
    result, b = np.empty((len(nodes), 3)), 0
    for k in range(len(nodes)):
        while b < len(nodes_before) and nodes_before[b] < nodes[k]:
            b += 1
        normal, tangential = 0.0, 0.0
        for c in range(3):
            normal += traction[k, c] * frames[k, 0, c]
        for c in range(3):
            tangential += (traction[k, c] - normal * frames[k, 0, c]) ** 2
        # Nodes this close to the friction limit, relative to it, count as slipping: normals turn a little between
        # increments.
        stuck = np.sqrt(tangential) < (1.0 - 0.02) * limit[k]
        stays = b < len(nodes_before) and nodes_before[b] == nodes[k] and stuck
        for c in range(3):
            result[k, c] = (old_before[b, c] if stays else old[k, c]) + layer * traction[k, c]
    return result


def normal_of(vectors: Array, frames: Array) -> Array:
    """Components (k,) of vectors (k, 3) along the normals, the first rows of frames (k, 3, 3)."""
    return np.asarray(np.einsum("ij,ij->i", vectors, frames[:, 0]))
