"""A cycle jump: a traced cycle, two implicit stages on its positions, and the state that they leave.

The stages are those of Alexander's singly diagonal Runge-Kutta method of second order (SIAM J. Numer. Anal. 14 (1977)
1006): its last stage is the result, which keeps the contact conditions on the new surface, it damps what is fast
(L-stability), and all its weights are positive, so that every depth is worn by work that was done.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solvers.compliance import displacement_at
from solvers.contact import ContactProblem
from solvers.contact.acceptance import require_inside_patches
from solvers.contact.gaps import faced, levers, vertical_gaps
from solvers.contact_state import ContactState, WearState
from solvers.errors import NotConvergedError
from solvers.fretting import CycleTrace
from solvers.guide import Guide, guide_from
from solvers.oxygen import edge_distances
from solvers.wear_step.influence import influence
from solvers.wear_step.orbits import Orbits, orbits_of
from solvers.wear_step.positions import Position, facing_nodes, positions_of
from solvers.wear_step.stage import StageSolution, solve_stage, worn_by
from solvers.wear_step.surfaces import Cycle
from solvers.wear_step.symmetry import Mirror, Symmetry, with_images

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Of Alexander's method: where the first stage lies in the step, and the weight of both stages' own rates.
_STAGE = 1.0 - 0.5**0.5
# Of a pressure before the step: less than the first share after the first stage counts as fading, more than the second
# as lasting.
_FADED, _LASTS = 0.25, 0.5
# Nodes whose gap is below this multiple of the bodies' overlap may come to touch during the step.
_MARGIN = 1.5
_MOST_SEARCHES = 6
# Wear work that fading pressures lose is given to lasting ones until that changes by less than this share.
_BALANCED = 2e-3
_MOST_BALANCES = 3

#: The problem after so many cycles and so much friction energy (mJ).
ProblemAt = Callable[[float, float], ContactProblem]


@dataclass(frozen=True)
class CycleJump:
    """What a jump came to.

    state: after it, at the end of the stroke where the traced cycle, or half of it, ended.
    pressure_change: by how much pressures of the two stages differ: half the mean difference over the load, 0 to 1.
    unknowns, active: pressures solved for, and how many of them are not zero.  iterations: of active sets.
    """

    state: ContactState
    guide: Guide
    pressure_change: float
    unknowns: int
    active: int
    iterations: int


def jump_cycles(
    problem_at: ProblemAt, start: ContactState, trace: CycleTrace, symmetry: Symmetry, done: float, cycles: float
) -> CycleJump:
    """Let the surfaces wear for `cycles` cycles after `done`.

    start, trace: the state at an end of the stroke, and the cycle from there with the wear frozen; its first half where
    the symmetry maps that onto the second.

    Raises:
        NotConvergedError: no pressures were found that fit.
        PatchLeftError: the contact has reached the edge of either patch.
    """
    problem = problem_at(done, start.wear.energy_mJ)
    states, across = trace.states, symmetry.across
    nodes = [_with_images(facing_nodes(problem, state, _MARGIN), across) for state in states]
    known: dict[int, Array] = {}
    work = trace.friction_work * (1.0 if symmetry.half_cycle is None else 2.0)
    for _ in range(_MOST_SEARCHES):
        kept, cycle = _cycle(problem, start, states, nodes, symmetry, known, work)
        stages = _stages(problem_at, cycle, start, trace, done, cycles)
        missing = [_missing(stages, cycle, index) for index in range(len(cycle.positions))]
        if not any(len(found) for found in missing):
            _require_inside(stages.problem, cycle, stages.last)
            return _outcome(stages, cycle, kept, trace, symmetry.half_cycle)
        for k, more in zip(kept, missing, strict=True):
            if len(more):
                nodes[k] = _with_images(np.union1d(nodes[k], more), across)
                known.pop(k, None)
    raise NotConvergedError("the nodes that come to touch as the surfaces wear were not found")


@dataclass(frozen=True)
class _Stages:
    """Both stages' solutions, the problem after the step, and the wear state that they leave."""

    problem: ContactProblem
    first: StageSolution
    last: StageSolution
    wear: WearState


def _cycle(
    problem: ContactProblem,
    start: ContactState,
    states: tuple[ContactState, ...],
    nodes: list[IntArray],
    symmetry: Symmetry,
    known: dict[int, Array],
    work_mJ: float,
) -> tuple[list[int], Cycle]:
    """The positions of the traced cycle that slide, and the last one, by their numbers; known: influences so far.

    work_mJ: friction work of the whole cycle.
    """
    every = positions_of(problem, start, states, nodes, symmetry.half_cycle)
    kept = [k for k, position in enumerate(every) if position.slides or k == len(every) - 1]
    positions = tuple(every[k] for k in kept)
    orbits = orbits_of(problem, positions, symmetry)
    for k, position, rows, images in zip(kept, positions, orbits.rows, orbits.images, strict=True):
        if k not in known:
            known[k] = influence(problem.primary, problem.secondary, position.pairing, rows, images)
    depths = start.wear.primary_depth, start.wear.secondary_depth
    influences = tuple(known[k] for k in kept)
    half = symmetry.half_cycle is not None
    return kept, Cycle(positions, orbits, influences, depths, half, _wearing(problem, positions, orbits, work_mJ))


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


def _stages(
    problem_at: ProblemAt, cycle: Cycle, start: ContactState, trace: CycleTrace, done: float, cycles: float
) -> _Stages:
    per_cycle = trace.friction_work * (2.0 if cycle.half else 1.0)
    energy, every = start.wear.energy_mJ, np.ones(cycle.orbits.count)
    traced = _traced_pressures(cycle)
    own = _STAGE * cycles
    early = problem_at(done + own, energy + own * per_cycle)
    first = solve_stage(early, cycle, cycle.depths, own * every, traced)
    late = problem_at(done + cycles, energy + cycles * per_cycle)
    lasting, rest = _lasting(traced, first.pressure), (1.0 - _STAGE) * cycles
    last, last_for, ahead = first, cycles - rest * lasting, np.zeros_like(lasting)
    for _ in range(_MOST_BALANCES):
        balanced = rest * lasting * _taken_over(cycle.orbits, lasting, first.wear_work, last.wear_work)
        if np.abs(balanced - ahead).max() <= _BALANCED * rest:
            break
        ahead = balanced
        between = worn_by(early, cycle.orbits, cycle.depths, first.wear_work, ahead)
        last = solve_stage(late, cycle, between, last_for, last.pressure)
    wear = start.wear
    for problem, stage, count in ((early, first, ahead), (late, last, last_for)):
        wear = _worn(problem, cycle.orbits, wear, stage, count)
    return _Stages(late, first, last, wear)


def _lasting(traced: Array, first: Array) -> Array:
    """Share (N,) of each pressure of the first stage that is counted on for the rest of the step.

    Where a pressure fades within the first stage, what is left of it says nothing of the rest of the step: a place that
    wears until it bears no more load would be dug by its last bit of load again and again, and no wear can be undone.
    There the last stage alone wears, for the whole step; the work lost so is done by those that last.
    """
    kept = np.divide(first, traced, out=np.ones_like(first), where=traced > 0.0)
    return np.clip((kept - _FADED) / (_LASTS - _FADED), 0.0, 1.0)


def _taken_over(orbits: Orbits, lasting: Array, first: Array, last: Array) -> Array:
    """By how much (N,) more the pressures that last have to work for those of their position that fade."""
    weights = orbits.areas * orbits.twice
    parts = (weights * (first - (1.0 - lasting) * last), weights * lasting * first)
    wanted, counted = (np.bincount(orbits.position, part, len(orbits.rows)) for part in parts)
    factors = np.divide(wanted, counted, out=np.ones_like(wanted), where=counted > 0.5 * wanted)
    return np.asarray(np.maximum(factors, 1.0)[orbits.position])


def _traced_pressures(cycle: Cycle) -> Array:
    pressures = [
        np.maximum(np.einsum("ij,ij->i", p.state.traction[p.nodes], p.pairing.frames[:, 0, :]), 0.0)[rows]
        for p, rows in zip(cycle.positions, cycle.orbits.rows, strict=True)
    ]
    return np.concatenate(pressures)


def _worn(problem: ContactProblem, orbits: Orbits, wear: WearState, stage: StageSolution, cycles: Array) -> WearState:
    rates = problem.wear.split(problem.primary_is_upper)
    energy = orbits.deposited(cycles * stage.friction_work)
    is_energy = problem.wear.law == "energy" and problem.wear.oxygen is None
    work = energy if is_energy else orbits.deposited(cycles * stage.wear_work)
    areas = problem.surface.areas
    shape, other_shape = wear.primary_depth.shape, wear.secondary_depth.shape
    total = float(areas @ work[0])
    return WearState(
        primary_depth=wear.primary_depth + rates[0] * work[0].reshape(shape),
        secondary_depth=wear.secondary_depth + rates[1] * work[1].reshape(other_shape),
        primary_energy=wear.primary_energy + energy[0].reshape(shape),
        secondary_energy=wear.secondary_energy + energy[1].reshape(other_shape),
        energy_mJ=wear.energy_mJ + float(areas @ energy[0]),
        primary_volume_mm3=wear.primary_volume_mm3 + rates[0] * total,
        secondary_volume_mm3=wear.secondary_volume_mm3 + rates[1] * total,
    )


def _missing(stages: _Stages, cycle: Cycle, index: int) -> IntArray:
    """Where nodes beside those of a position touch on the worn surfaces: all that overlap there, and some that nearly
    do. Most of those that overlap while the bodies are undeformed do not touch under load.
    """
    problem, position = stages.problem, cycle.positions[index]
    state = _state(stages, cycle, index)
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


def _outcome(stages: _Stages, cycle: Cycle, kept: list[int], trace: CycleTrace, half_cycle: Mirror | None) -> CycleJump:
    orbits, first, last = cycle.orbits, stages.first.pressure, stages.last.pressure
    weights = orbits.areas * orbits.twice
    states = [replace(state, wear=stages.wear) for state in trace.states]
    for index, k in enumerate(kept):
        states[k] = _state(stages, cycle, index)
    return CycleJump(
        state=states[-1],
        guide=with_images(guide_from(trace.phase, states), half_cycle),
        pressure_change=float(weights @ np.abs(last - first)) / float(weights @ (last + first)),
        unknowns=orbits.count,
        active=int((last > 0.0).sum()),
        iterations=stages.first.iterations + stages.last.iterations,
    )


def _state(stages: _Stages, cycle: Cycle, index: int) -> ContactState:
    """The state at a position of the worn cycle, in equilibrium on the new surfaces where the bodies slide."""
    problem, orbits, position = stages.problem, cycle.orbits, cycle.positions[index]
    face, pairing, nodes = stages.last.facing[index], position.pairing, position.nodes
    rows, images = orbits.rows[index], orbits.images[index]
    own = stages.last.pressure[orbits.start[index] : orbits.start[index + 1]]
    pressure = np.zeros(len(nodes))
    pressure[rows], pressure[images] = own, own
    friction = problem.law.limit(pressure)
    traction = np.where(
        (pressure > 0.0)[:, None],
        pressure[:, None] * face.normals + friction[:, None] * face.frictions + face.stuck,
        0.0,
    )
    whole = np.zeros_like(position.state.traction)
    whole[nodes] = traction
    force, before = pairing.own.spread(traction), position.state.primary_force
    shift = problem.holder.compliance_at_contact_mm_per_N * float(force[:, 0].sum() - before[:, 0].sum())
    height = float(stages.last.height[index])
    moved = replace(
        position.state,
        wear=stages.wear,
        holder_x=position.state.holder_x + shift,
        holder_z=height,
        holder_tilt=position.state.holder_tilt + problem.holder.tilt_per_motion_rad_per_mm * shift,
        traction=whole,
        primary_force=force,
        secondary_force=pairing.opposite.spread(traction),
    )
    gap = vertical_gaps(problem, moved, moved.drive, moved.holder_x) + height
    return replace(moved, overlap_area=float(problem.surface.areas[gap < 0.0].sum()))
