"""Two implicit stages of a cycle jump on the positions of a traced cycle, and the states at which they end.

A jump lets surfaces wear for many cycles in one step, from one traced cycle; N counts the unknown pressures of all its
positions. The stages are those of Alexander's singly diagonal Runge-Kutta method of second order (SIAM J. Numer. Anal.
14 (1977) 1006): its last stage is the result, which keeps the contact conditions on the new surface, it damps what is
fast (L-stability), and all its weights are positive, so that every depth is worn by work that was done.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact import ContactProblem
from solvers.contact.acceptance import require_inside_patches
from solvers.contact.between_nodes import WithinElements
from solvers.contact.linearising import within_elements
from solvers.contact.problem import faced, levers, vertical_gaps
from solvers.contact_state import ContactState, Guide, WearState, guide_from
from solvers.elasticity.compliance import displacement_at
from solvers.errors import NotConvergedError
from solvers.fretting import CycleTrace
from solvers.wear_step.influence import Influences
from solvers.wear_step.orbits import Orbits, Position, facing_nodes, orbits_of, positions_of
from solvers.wear_step.places import WearStop, stops_of
from solvers.wear_step.prints import as_printed, printed_by
from solvers.wear_step.stage import StageSolution, solve_stage, worn_by
from solvers.wear_step.strokes import mean_slip
from solvers.wear_step.surfaces import Cycle
from solvers.wear_step.symmetry import Mirror, Symmetry, with_images
from solvers.wear_step.warming import times_of, warming_of

# Of Alexander's method: where the first stage lies in the step, and the weight of both stages' own rates.
_STAGE = 1.0 - 0.5**0.5
# Of a pressure before the step: less than the first share after the first stage counts as fading, more than the second
# as lasting.
_FADED, _LASTS = 0.25, 0.5

#: The problem after so many cycles and so much friction energy (mJ).
ProblemAt = Callable[[float, float], ContactProblem]


# Nodes whose gap is below this multiple of the bodies' overlap may come to touch during the step. Too many of them cost
# less than the whole step taken again for one that was missing: of the 23 jumps of steel wires in 100 000 cycles 6 were
# with 3, 3 with 4, and 2 with 5.
_MARGIN = 5.0


@dataclass(frozen=True)
class Stages:
    """Solutions of the first and the last stage of a jump; `problem` after all its cycles, and the `wear` that both
    stages leave together.
    """

    problem: ContactProblem
    first: StageSolution
    last: StageSolution
    wear: WearState


def two_stages(
    problem_at: ProblemAt, cycle: Cycle, start: ContactState, trace: CycleTrace, done: float, cycles: float
) -> Stages:
    """Wear both bodies for `cycles` cycles (a number, not necessarily whole) after the first `done` of the test.

    problem_at: the contact problem after a number of cycles and a friction energy in mJ. start, trace: the state where
    the traced cycle starts, and its trace. Raises NotConvergedError if a stage's pressures are not found.
    """
    per_cycle = trace.friction_work * (2.0 if cycle.half else 1.0)
    energy, every = start.wear.energy_mJ, np.ones(cycle.orbits.count)
    traced = cycle.traced_pressures
    own = _STAGE * cycles
    early = problem_at(done + own, energy + own * per_cycle)
    first = solve_stage(early, cycle, cycle.wear, lambda _: own * every, traced)
    late = problem_at(done + cycles, energy + cycles * per_cycle)
    lasting, rest = _lasting(traced, first.pressure), (1.0 - _STAGE) * cycles
    rising = (rest - own) * _rise(traced, first.pressure)
    last_for = _on_fronts(late, cycle, cycles - rest * lasting, rising, first.pressure)
    last, ahead = first, np.zeros_like(lasting)
    # Wear work that fading pressures lose is given to lasting ones.
    for _ in range(3):
        balanced = rest * lasting * _taken_over(early, cycle, lasting, first.wear_work, last.wear_work)
        if np.abs(balanced - ahead).max() <= 2e-3 * rest:
            break
        ahead = balanced
        between = worn_by(early, cycle, cycle.wear, first.works, ahead)[0]
        last = solve_stage(late, cycle, between, last_for, last.pressure)
    wear = start.wear
    for problem, stage, count in ((early, first, ahead), (late, last, last.cycles)):
        wear = worn_by(problem, cycle, wear, stage.works, count)[0]
    return Stages(late, first, last, wear)


def _lasting(traced: Array, first: Array) -> Array:
    """Share (N,) of each pressure of the first stage that is counted on for the rest of the step.

    Where a pressure fades within the first stage, what is left of it says nothing of the rest of the step: a place that
    wears until it bears no more load would be dug by its last bit of load again and again, and no wear can be undone.
    There the last stage alone wears, for the whole step; the work lost so is done by those that last.
    """
    kept = np.divide(first, traced, out=np.ones_like(first), where=traced > 0.0)
    return np.clip((kept - _FADED) / (_LASTS - _FADED), 0.0, 1.0)


def _on_fronts(
    problem: ContactProblem, cycle: Cycle, elsewhere: Array, later: Array, first: Array
) -> Callable[[Array], Array]:
    """How many cycles (N,) the last stage wears by, as a law of its pressures (N,).

    A growing contact passes over nodes during a step. Under an even pressure p, one that it meets at a time t within
    the first stage S wears from then on, and shares the time from t to S of it: the first stage has a pressure of
    p (S - t) / S there. If the last stage counted as elsewhere, such a node would stand out and carry up to (1 - S) / S
    = 2.4 times p. With cycles that grow evenly from S to 1 - S while t grows from 0 to S, it has worn for 1 - t.
    Nodes that the front has not passed by the step's end carry less than the mean pressure and gain as it passes: so
    much less do they count as met. The other nodes of the position, which carry its load together, wear less for it.

    elsewhere: cycles of nodes whose pressure stays.  later: how many more where a contact comes after the first stage,
    whose pressures are `first`.
    """
    orbits = cycle.orbits
    weights, load_stays = orbits.areas * orbits.twice, _load_stays(problem, cycle)

    def at_positions(part: Array) -> Array:
        return np.maximum(np.bincount(orbits.position, weights * part, len(orbits.rows)), 1e-300)

    def cycles(pressure: Array) -> Array:
        bearing = np.maximum(pressure, 0.0)
        mean = (at_positions(bearing) / at_positions(np.sign(bearing)))[orbits.position]
        wanted = elsewhere + later * _rise(first, bearing) * np.minimum(bearing / mean, 1.0)
        if not load_stays:
            return wanted
        shares = at_positions(bearing * elsewhere) / at_positions(bearing * wanted)
        return np.asarray(wanted * shares[orbits.position])

    return cycles


def _rise(before: Array, after: Array) -> Array:
    """Share (N,) of pressures that was not there before, 0 where they fall; 1 where there is none at either time."""
    return np.where(after > before, 1.0 - before / np.maximum(after, 1e-300), np.where(before > 0.0, 0.0, 1.0))


def _load_stays(problem: ContactProblem, cycle: Cycle) -> bool:
    """Whether what some nodes of a position no longer carry is carried by others that wear: it is lost under a held
    approach, and may go to a core that sticks.
    """
    return problem.holder.approach_mm is None and not cycle.positions[-1].state.core.any()


def _taken_over(problem: ContactProblem, cycle: Cycle, lasting: Array, first: Array, last: Array) -> Array:
    """By how much (N,) more the pressures that last have to work for those of their position that fade."""
    if not _load_stays(problem, cycle):
        return np.ones_like(lasting)
    orbits = cycle.orbits
    weights = orbits.areas * orbits.twice
    parts = (weights * (first - (1.0 - lasting) * last), weights * lasting * first)
    wanted, counted = (np.bincount(orbits.position, part, len(orbits.rows)) for part in parts)
    factors = np.divide(wanted, counted, out=np.ones_like(wanted), where=counted > np.maximum(0.5 * wanted, 0.0))
    return np.asarray(np.maximum(factors, 1.0)[orbits.position])


def state_at(stages: Stages, cycle: Cycle, index: int) -> ContactState:
    """The state at this index's position after the jump, in equilibrium on the worn surfaces where bodies slide."""
    problem, orbits, position = stages.problem, cycle.orbits, cycle.positions[index]
    face, at, pairing, nodes = stages.last.facing, cycle.at(index), position.pairing, position.nodes
    rows, images = orbits.rows[index], orbits.images[index]
    own = stages.last.pressure[orbits.start[index] : orbits.start[index + 1]]
    pressure, friction = np.zeros((2, len(nodes)))
    pressure[rows], pressure[images] = own, own
    limit = stages.last.friction.limit(stages.last.pressure)[orbits.start[index] : orbits.start[index + 1]]
    friction[rows], friction[images] = limit, limit
    traction = np.where(
        (pressure > 0.0)[:, None],
        pressure[:, None] * face.normals[at] + friction[:, None] * face.frictions[at] + face.stuck[at],
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


@dataclass(frozen=True)
class CycleJump:
    """The contact after a cycle jump."""

    state: ContactState  #: At the end of the stroke where the traced cycle, or half of it, ended.
    guide: Guide  #: First guesses for a whole cycle on the worn surfaces.
    #: How far pressures, or local coefficients of friction, differ between the two stages: half the sum of the
    #: differences over the mean load, 0 to 1; the larger of the two.
    pressure_change: float
    friction_work: float  #: Of a whole cycle on the surfaces after the jump, mJ.
    uncertain: bool  #: True if a cycle traced on them may have another friction work; see `Cycle.uncertain`.
    unknowns: int  #: Number of pressures solved for.
    active: int  #: How many of them are above 0.
    iterations: int  #: Steps of both stages together.


def jump_cycles(
    problem_at: ProblemAt, start: ContactState, trace: CycleTrace, symmetry: Symmetry, done: float, cycles: float
) -> CycleJump:
    """Let the surfaces wear for `cycles` cycles after the first `done` of a test, in one step.

    problem_at: the contact problem after a number of cycles and a friction energy in mJ. start, trace: the state at an
    end of the stroke, and the cycle traced from there with worn depths held fixed; its first half only where the
    symmetry maps that onto the second. Raises NotConvergedError if no pressures were found that fit, and PatchLeftError
    if the contact reaches the edge of either patch.
    """
    start, trace = as_printed(start, trace, symmetry)
    problem, across = problem_at(done, start.wear.energy_mJ), symmetry.across
    passed = stops_of(start, trace, symmetry.half_cycle)
    nodes = [_with_images(facing_nodes(problem, stop.state, _MARGIN), across) for stop in passed]
    if start.core.any():
        # Around a core surfaces face each other alike at all positions: so do their nodes.
        nodes = [np.unique(np.concatenate(nodes))] * len(nodes)
    work = symmetry.strokes * trace.friction_work
    for _ in range(6):
        kept, cycle = _cycle(problem, start.wear, passed, nodes, symmetry, work, trace.time)
        stages = two_stages(problem_at, cycle, start, trace, done, cycles)
        wear = printed_by(stages.problem, cycle, symmetry, stages.wear, stages.last.pressure)
        stages = replace(stages, wear=wear)
        worn = [state_at(stages, cycle, index) for index in range(len(cycle.positions))]
        missing = [_missing(stages.problem, of.nodes, state) for of, state in zip(cycle.positions, worn, strict=True)]
        if not any(len(found) for found in missing):
            _require_inside(stages.problem, cycle, stages.last)
            at = [passed[k].increment for k in kept]
            return _outcome(stages, cycle, dict(zip(at, worn, strict=True)), trace, symmetry)
        for k, more in zip(kept, missing, strict=True):
            if len(more):
                nodes[k] = _with_images(np.union1d(nodes[k], more), across)
    raise NotConvergedError("the nodes that come to touch as the surfaces wear were not found")


def _cycle(
    problem: ContactProblem,
    wear: WearState,
    passed: Sequence[WearStop],
    nodes: list[IntArray],
    symmetry: Symmetry,
    work_mJ: float,
    times: Array,
) -> tuple[list[int], Cycle]:
    """Numbers, among the stops of the traced cycle, of those at which the contact slides, with the last one if bodies
    touch there (without any, the first one at which they touch); and the cycle that the wear step solves at these.

    passed: stops of the traced cycle. nodes: nodes that may touch at each. work_mJ: friction work of the whole cycle.
    times: shares of the cycle passed at the ends of all its increments.
    """
    every = positions_of(problem, passed, nodes, symmetry.half_cycle)
    touch = [k for k, own in enumerate(every) if len(own.nodes)]
    kept = [k for k in touch if every[k].slides or k == len(every) - 1] or touch[:1]
    positions = tuple(every[k] for k in kept)
    orbits = orbits_of(problem, positions, symmetry)
    influences = Influences(
        (problem.primary, problem.secondary), [position.pairing for position in positions], orbits.rows, symmetry.across
    )
    within = within_elements(problem, [position.state for position in positions], orbits.position)
    cycle = Cycle(positions, orbits, influences, wear, symmetry.half_cycle, 1.0, problem.layers, within)
    if (heat := problem.wear.heat) is not None:
        warming = warming_of(
            problem, heat, positions, orbits, symmetry.half_cycle, times_of(passed, times, kept, 1.0 / symmetry.strokes)
        )
        slip, pressure = cycle.slip_lengths(), cycle.traced_pressures
        work = cycle.law_at(problem, wear, slip, pressure).limit(pressure) * slip
        wear = replace(cycle, warming=warming).warmed(wear, work)
        cycle = replace(cycle, warming=warming, wear=wear)
    traced = _TracedCycle(problem, positions, orbits, work_mJ, symmetry.strokes, within, wear.rise_K)
    wearing = traced.at_unknowns(problem.wear.factor(traced))
    cycle = replace(cycle, wearing=wearing)
    if problem.debris is None:
        return kept, cycle
    protected = problem.debris.wearing(orbits.opening(*wear.debris(problem.retained)))
    return kept, replace(cycle, wearing=wearing * protected, to_edge=cycle.distances_to_edge(problem))


@dataclass(frozen=True)
class _TracedCycle:
    """What a wear law may know of a traced cycle; see `WornCycle`."""

    problem: ContactProblem
    positions: tuple[Position, ...]
    orbits: Orbits
    work_mJ: float  #: Friction work of the whole cycle.
    strokes: int  #: How often the positions come by in it.
    within: WithinElements  #: Of the positions, for the unknowns.
    rise_K: float  #: Mean rise of the temperature where it heats the surfaces.

    @property
    def frequency_Hz(self) -> float:
        return self.problem.timing.frequency_Hz

    @property
    def slip_amplitude_mm(self) -> float:
        return 0.25 * self.strokes * sum(map(mean_slip, self.positions))

    @property
    def pressure_MPa(self) -> float:
        areas = self.problem.surface.areas
        load = float(np.mean([areas @ position.state.traction[:, 2] for position in self.positions]))
        return load / max(self._area, 1e-300)

    @property
    def power_density_W_per_mm2(self) -> float:
        return 1e-3 * self.work_mJ * self.frequency_Hz / max(self._area, 1e-300)

    @property
    def edge_distance_mm(self) -> Array:
        # What comes into contact only as it wears lies at its edge, the last place.
        return np.concatenate([*(spread.edge_distance_mm for spread in self.within.spreads), [0.0]])

    def at_unknowns(self, factor: float | Array) -> float | Array:
        """A factor, one for all or one for each place (N,), as means over the unknowns' supports."""
        if not isinstance(factor, np.ndarray) or factor.ndim == 0:
            return float(factor)
        parts = np.split(factor[:-1], np.cumsum([len(spread.pressure_MPa) for spread in self.within.spreads])[:-1])
        found = [
            spread.averaged(part, float(factor[-1]))[position.nodes][rows]
            for spread, part, position, rows in zip(
                self.within.spreads, parts, self.positions, self.orbits.rows, strict=True
            )
        ]
        return np.concatenate(found)

    @property
    def _area(self) -> float:
        return float(np.mean([spread.area_mm2 for spread in self.within.spreads]))


def _missing(problem: ContactProblem, nodes: IntArray, state: ContactState) -> IntArray:
    """Where nodes beside those of a position touch on the worn surfaces: all that overlap there, and some that nearly
    do. Most of those that overlap while the bodies are undeformed do not touch under load.
    """
    gap = vertical_gaps(problem, state, state.drive, state.holder_x) + state.holder_z
    beside = np.ones(len(gap), dtype=bool)
    beside[nodes] = False
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


def _outcome(
    stages: Stages, cycle: Cycle, worn: dict[int, ContactState], trace: CycleTrace, symmetry: Symmetry
) -> CycleJump:
    orbits, first, last = cycle.orbits, stages.first.pressure, stages.last.pressure
    weights = orbits.areas * orbits.twice
    states = [worn.get(k) or replace(state, wear=stages.wear) for k, state in enumerate(trace.states)]
    # What pressures change by, and friction that remembers, show alike how far apart the stages are.
    pressures = float(weights @ np.abs(last - first)) / float(weights @ (last + first))
    friction = stages.last.friction.change_since(stages.first.friction, weights * (last + first))
    return CycleJump(
        state=states[-1],
        guide=with_images(guide_from(trace.phase, states), symmetry.half_cycle),
        pressure_change=max(pressures, friction),
        friction_work=symmetry.strokes * float(weights @ stages.last.friction_work),
        uncertain=cycle.uncertain,
        unknowns=orbits.count,
        active=int((last > 0.0).sum()),
        iterations=stages.first.iterations + stages.last.iterations,
    )
