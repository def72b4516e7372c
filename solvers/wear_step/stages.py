"""Two implicit stages of a cycle jump on the positions of a traced cycle, and the states that they leave.

The stages are those of Alexander's singly diagonal Runge-Kutta method of second order (SIAM J. Numer. Anal. 14 (1977)
1006): its last stage is the result, which keeps the contact conditions on the new surface, it damps what is fast
(L-stability), and all its weights are positive, so that every depth is worn by work that was done.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem
from solvers.contact.linearisation import vertical_gaps
from solvers.contact_state import ContactState, WearState
from solvers.fretting import CycleTrace
from solvers.wear_step.orbits import Orbits
from solvers.wear_step.stage import StageSolution, solve_stage, worn_by
from solvers.wear_step.surfaces import Cycle

# Of Alexander's method: where the first stage lies in the step, and the weight of both stages' own rates.
_STAGE = 1.0 - 0.5**0.5
# Of a pressure before the step: less than the first share after the first stage counts as fading, more than the second
# as lasting.
_FADED, _LASTS = 0.25, 0.5
# Wear work that fading pressures lose is given to lasting ones until that changes by less than this share.
_BALANCED = 2e-3
_MOST_BALANCES = 3

#: The problem after so many cycles and so much friction energy (mJ).
ProblemAt = Callable[[float, float], ContactProblem]


@dataclass(frozen=True)
class Stages:
    """Both stages' solutions, the problem after the step, and the wear state that they leave."""

    problem: ContactProblem
    first: StageSolution
    last: StageSolution
    wear: WearState


def two_stages(
    problem_at: ProblemAt, cycle: Cycle, start: ContactState, trace: CycleTrace, done: float, cycles: float
) -> Stages:
    """Wear both bodies by the cycle for `cycles` cycles after `done`, from the state where it starts."""
    per_cycle = trace.friction_work * (2.0 if cycle.half else 1.0)
    energy, every = start.wear.energy_mJ, np.ones(cycle.orbits.count)
    traced = _traced_pressures(cycle)
    own = _STAGE * cycles
    early = problem_at(done + own, energy + own * per_cycle)
    first = solve_stage(early, cycle, cycle.depths, lambda _: own * every, traced)
    late = problem_at(done + cycles, energy + cycles * per_cycle)
    lasting, rest = _lasting(traced, first.pressure), (1.0 - _STAGE) * cycles
    rising = (rest - own) * _rise(traced, first.pressure)
    last_for = _on_fronts(late, cycle, cycles - rest * lasting, rising, first.pressure)
    last, ahead = first, np.zeros_like(lasting)
    for _ in range(_MOST_BALANCES):
        balanced = rest * lasting * _taken_over(early, cycle, lasting, first.wear_work, last.wear_work)
        if np.abs(balanced - ahead).max() <= _BALANCED * rest:
            break
        ahead = balanced
        between = worn_by(early, cycle.orbits, cycle.depths, first.wear_work, ahead)
        last = solve_stage(late, cycle, between, last_for, last.pressure)
    wear = start.wear
    for problem, stage, count in ((early, first, ahead), (late, last, last.cycles)):
        wear = _worn(problem, cycle.orbits, wear, stage, count)
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


def _traced_pressures(cycle: Cycle) -> Array:
    pressures = [
        np.maximum(np.einsum("ij,ij->i", p.state.traction[p.nodes], p.pairing.frames[:, 0, :]), 0.0)[rows]
        for p, rows in zip(cycle.positions, cycle.orbits.rows, strict=True)
    ]
    return np.concatenate(pressures)


def state_at(stages: Stages, cycle: Cycle, index: int) -> ContactState:
    """The state at a position of the worn cycle, in equilibrium on the new surfaces where the bodies slide."""
    problem, orbits, position = stages.problem, cycle.orbits, cycle.positions[index]
    face, at, pairing, nodes = stages.last.facing, cycle.at(index), position.pairing, position.nodes
    rows, images = orbits.rows[index], orbits.images[index]
    own = stages.last.pressure[orbits.start[index] : orbits.start[index + 1]]
    pressure = np.zeros(len(nodes))
    pressure[rows], pressure[images] = own, own
    friction = problem.law.limit(pressure)
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
