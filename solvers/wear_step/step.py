"""A cycle jump: a traced cycle, the nodes that may touch as its positions wear, and the state that it leaves."""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.compliance import displacement_at
from solvers.contact import ContactProblem
from solvers.contact.acceptance import require_inside_patches
from solvers.contact.linearisation import faced, levers, vertical_gaps
from solvers.contact_state import ContactState
from solvers.errors import NotConvergedError
from solvers.fretting import CycleTrace
from solvers.holder import Guide, guide_from
from solvers.wear import edge_distances
from solvers.wear_step.influence import Influences
from solvers.wear_step.orbits import Orbits, orbits_of
from solvers.wear_step.positions import Position, facing_nodes, positions_of
from solvers.wear_step.stage import StageSolution
from solvers.wear_step.stages import ProblemAt, Stages, state_at, two_stages
from solvers.wear_step.surfaces import Cycle
from solvers.wear_step.symmetry import Mirror, Symmetry, with_images

# Nodes whose gap is below this multiple of the bodies' overlap may come to touch during the step. Too many of them cost
# less than the whole step taken anew for one that was missing: of the 23 jumps of steel wires in 100 000 cycles 6 were
# with 3, 3 with 4, and 2 with 5.
_MARGIN = 5.0
_MOST_SEARCHES = 6


@dataclass(frozen=True)
class CycleJump:
    """What a jump came to.

    state: after it, at the end of the stroke where the traced cycle, or half of it, ended.
    pressure_change: by how much pressures of the two stages differ: half the mean difference over the load, 0 to 1.
    friction_work: of a cycle on the surfaces after the jump, mJ.  uncertain: whether a
    cycle traced on them may well have another.
    unknowns, active: pressures solved for, and how many of them are not zero.  iterations: of active sets.
    """

    state: ContactState
    guide: Guide
    pressure_change: float
    friction_work: float
    uncertain: bool
    unknowns: int
    active: int
    iterations: int


def jump_cycles(
    problem_at: ProblemAt, start: ContactState, trace: CycleTrace, symmetry: Symmetry, done: float, cycles: float
) -> CycleJump:
    """Let the surfaces wear for `cycles` cycles after `done`.

    start, trace: the state at an end of the stroke, and the cycle from there with the wear frozen; its first half where
    the symmetry maps that onto the second.
    Raises NotConvergedError if no pressures were found that fit, and PatchLeftError if the contact has reached the edge
    of either patch.
    """
    problem = problem_at(done, start.wear.energy_mJ)
    states, across = trace.states, symmetry.across
    nodes = [_with_images(facing_nodes(problem, state, _MARGIN), across) for state in states]
    work = symmetry.strokes * trace.friction_work
    for _ in range(_MOST_SEARCHES):
        kept, cycle = _cycle(problem, start, states, nodes, symmetry, work)
        stages = two_stages(problem_at, cycle, start, trace, done, cycles)
        missing = [_missing(stages, cycle, index) for index in range(len(cycle.positions))]
        if not any(len(found) for found in missing):
            _require_inside(stages.problem, cycle, stages.last)
            return _outcome(stages, cycle, kept, trace, symmetry)
        for k, more in zip(kept, missing, strict=True):
            if len(more):
                nodes[k] = _with_images(np.union1d(nodes[k], more), across)
    raise NotConvergedError("the nodes that come to touch as the surfaces wear were not found")


def _cycle(
    problem: ContactProblem,
    start: ContactState,
    states: tuple[ContactState, ...],
    nodes: list[IntArray],
    symmetry: Symmetry,
    work_mJ: float,
) -> tuple[list[int], Cycle]:
    """The positions of the traced cycle that slide, and the last one, by their numbers.

    work_mJ: friction work of the whole cycle.
    """
    every = positions_of(problem, start, states, nodes, symmetry.half_cycle)
    kept = [k for k, position in enumerate(every) if position.slides or k == len(every) - 1]
    positions = tuple(every[k] for k in kept)
    orbits = orbits_of(problem, positions, symmetry)
    influences = Influences(
        (problem.primary, problem.secondary),
        [position.pairing for position in positions],
        list(zip(orbits.rows, orbits.images, strict=True)),
    )
    depths = start.wear.primary_depth, start.wear.secondary_depth
    half, wearing = symmetry.half_cycle, _wearing(problem, positions, orbits, work_mJ)
    return kept, Cycle(positions, orbits, influences, depths, half, wearing, problem.layers)


def _wearing(problem: ContactProblem, positions: tuple[Position, ...], orbits: Orbits, work_mJ: float) -> Array:
    """Factors (N,) on the wear coefficients: less where oxygen does not get in a cycle of that friction work."""
    oxygen = problem.wear.oxygen
    if oxygen is None:
        return np.ones(orbits.count)
    plane, areas = problem.primary.node_positions[:, :2], problem.surface.areas
    pressed = [position.state.traction[:, 2] > 0.0 for position in positions]
    area = float(np.mean([areas[nodes].sum() for nodes in pressed]))
    reach = oxygen.reach_mm(1e-3 * work_mJ * oxygen.frequency_Hz / max(area, 1e-300))
    found = [
        oxygen.factors(edge_distances(plane, own), reach)[position.nodes][rows]
        for position, own, rows in zip(positions, pressed, orbits.rows, strict=True)
    ]
    return np.concatenate(found)


def _missing(stages: Stages, cycle: Cycle, index: int) -> IntArray:
    """Where nodes beside those of a position touch on the worn surfaces: all that overlap there, and some that nearly
    do. Most of those that overlap while the bodies are undeformed do not touch under load.
    """
    problem, position = stages.problem, cycle.positions[index]
    state = state_at(stages, cycle, index)
    gap = vertical_gaps(problem, state, state.drive, state.holder_x) + state.holder_z
    beside = np.ones(len(gap), dtype=bool)
    beside[position.nodes] = False
    overlapping = np.flatnonzero(beside & (gap < 0.0))
    if not len(overlapping) or not _touch(problem, state, overlapping):
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(beside & (gap < -0.5 * float(gap.min())))


def _touch(problem: ContactProblem, state: ContactState, nodes: IntArray) -> bool:
    """Whether any of some unloaded nodes touch under the state's forces."""
    pairing = faced(problem, state, nodes, state.drive, state.holder_x, state.holder_tilt)
    forces = state.primary_force, state.secondary_force
    elastic = displacement_at(pairing, problem.primary, problem.secondary, forces)
    lever = levers(problem, state.drive, state.holder_x)[nodes]
    normals = pairing.frames[:, 0, :]
    rigid = pairing.gap + state.holder_z + lever * state.holder_tilt
    return bool((normals[:, 2] * rigid + np.einsum("ij,ij->i", elastic, normals) < 0.0).any())


def _with_images(nodes: IntArray, across: Mirror | None) -> IntArray:
    return nodes if across is None else np.union1d(nodes, across.primary[nodes])


def _require_inside(problem: ContactProblem, cycle: Cycle, stage: StageSolution) -> None:
    start = cycle.orbits.start
    for k, (position, rows) in enumerate(zip(cycle.positions, cycle.orbits.rows, strict=True)):
        pressed = rows[stage.pressure[start[k] : start[k + 1]] > 0.0]
        require_inside_patches(problem, position.pairing, pressed, position.state.drive)


def _outcome(stages: Stages, cycle: Cycle, kept: list[int], trace: CycleTrace, symmetry: Symmetry) -> CycleJump:
    orbits, first, last = cycle.orbits, stages.first.pressure, stages.last.pressure
    weights = orbits.areas * orbits.twice
    states = [replace(state, wear=stages.wear) for state in trace.states]
    for index, k in enumerate(kept):
        states[k] = state_at(stages, cycle, index)
    return CycleJump(
        state=states[-1],
        guide=with_images(guide_from(trace.phase, states), symmetry.half_cycle),
        pressure_change=float(weights @ np.abs(last - first)) / float(weights @ (last + first)),
        friction_work=symmetry.strokes * float(weights @ stages.last.friction_work),
        uncertain=cycle.uncertain,
        unknowns=orbits.count,
        active=int((last > 0.0).sum()),
        iterations=stages.first.iterations + stages.last.iterations,
    )
