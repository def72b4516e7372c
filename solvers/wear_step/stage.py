"""One implicit stage: pressures of all positions of a cycle on the surface that they wear, and slip as friction fades.

With pressures p_k and holder heights z_k of every position k together,

    gap_k = n_z [gap_k(h) + z_k] + C_k p_k + n_z N (opening by one cycle's wear at all positions j under p_j),
    0 <= p_k, gap_k >= 0, one of them zero;     sum of A v_z p_k = P(z_k),

where h is the surface before, N the stage's cycles, and friction follows the pressure where a node slides. On given
normals this is close to a convex quadratic programme, and an active set is changed until it fits; the normals and the
slip, which the holder's place changes, follow in an outer iteration.

A cycle is traced with the wear frozen. What wears beside a sticking core then loses pressure and friction, and springs
back towards where the bodies would have it: it slides farther than traced, by as much as the slip itself in partial
slip. The core does not move; it takes over what the others no longer bear. In a contact that barely slides more of the
motion is strain where friction grows. Only the ends of both strokes matter, for there everything beside the core
slides: the slip of a stroke is the motion from one end to the other. Layers between the surfaces are sheared less when
they bear less, or wear in.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem
from solvers.contact_state import WearState
from solvers.errors import NotConvergedError
from solvers.laws.debris import staying
from solvers.laws.friction_law import Friction
from solvers.laws.layers import ContactLayer, layers_at_nodes
from solvers.wear import Rate, Recession, after_work
from solvers.wear_step.active_set import CycleEquations
from solvers.wear_step.prints import yield_at
from solvers.wear_step.strokes import ends_of_strokes
from solvers.wear_step.surfaces import Cycle, Depths, Facing

_LEAST, _LARGEST = 0.25, 4.0
_LEAST_SLIP = 0.02  # Of the largest slip of a stroke: nodes that slide less keep the slip that they have.

_MOST_ITERATIONS = 60

# Iterations in which the cycles follow the pressures; they stay from then on, for the two might go on in turns.
_FOLLOWED = 8


# Pressures have settled when they change by no more than this share of the largest; where layers stiffen with them,
# by no more than the second.
_SETTLED, _SETTLED_LAYERS = 1e-3, 1e-6

_LEAST_STRETCH, _LARGEST_STRETCH = 0.5, 2.0


def released_slip(
    problem: ContactProblem, cycle: Cycle, facing: Facing, pressure: Array, worn: Depths, friction: Friction
) -> tuple[Array, Array]:
    """Factors (N,) on the unknowns' slip before and after their positions where slip follows from strain, both between
    0.25 and 4.

    pressure: (N,) MPa. worn: depths whose debris is still there then. friction: the law at the unknowns there.
    """
    half_cycle, ends = cycle.half_cycle, ends_of_strokes(cycle.positions, cycle.half_cycle)
    before, after = cycle.traced_slips
    laws = cycle.law_at(problem, cycle.wear, 0.5 * (before + after), cycle.traced_pressures), friction
    moved = [_released(problem, cycle, facing, pressure, worn, laws, end) for end in ends]
    starts = [half_cycle.image(moved[0], half_cycle.primary)] if half_cycle is not None else moved[::-1]
    fields, begin = [], 0
    for end, there, here in zip(ends, starts, moved, strict=True):
        fields.append(_stretched(cycle, range(begin, end + 1), end, facing, here - there))
        begin = end + 1
    stroke = np.searchsorted(ends, np.arange(len(cycle.positions)))
    following = np.append(stroke[1:], 0)
    if half_cycle is not None:
        # The next stroke is the mirror image of this one.
        fields.append(half_cycle.image(fields[0], half_cycle.primary))
        following[-1] = 1
    nodes = [p.nodes[rows] for p, rows in zip(cycle.positions, cycle.orbits.rows, strict=True)]
    before = np.concatenate([fields[of][own] for of, own in zip(stroke, nodes, strict=True)])
    return before, np.concatenate([fields[of][own] for of, own in zip(following, nodes, strict=True)])


def _released(
    problem: ContactProblem,
    cycle: Cycle,
    face: Facing,
    pressure: Array,
    worn: Depths,
    laws: tuple[Friction, Friction],
    end: int,
) -> Array:
    """Motion (n, 3) in mm of all the primary's nodes against those that they face, from the traced pressures to these.

    laws: at the unknowns, as traced and now.
    """
    position, orbits = cycle.positions[end], cycle.orbits
    own, rows = slice(orbits.start[end], orbits.start[end + 1]), orbits.rows[end]
    traction = position.state.traction[position.nodes[rows]]
    normals, frictions = face.normals[cycle.at(end)][rows], face.frictions[cycle.at(end)][rows]
    before = np.maximum(np.einsum("ij,ij->i", traction, position.pairing.frames[rows, 0, :]), 0.0)
    now = np.maximum(pressure[own], 0.0)
    more = (laws[1].among(own).limit(now) - laws[0].among(own).limit(before))[:, None]
    change = (now - before)[:, None] * normals + more * frictions
    held = np.flatnonzero((before > 0.0) & ~frictions.any(axis=1))
    influence, weights = cycle.influences.dense(end), orbits.areas[own] * orbits.twice[own]
    moved = np.einsum("iajb,jb->ia", influence, change)
    sheared = _shear_compliance(problem.layers, cycle, worn, now, own)
    if len(sheared):
        tangential = traction - before[:, None] * position.pairing.frames[rows, 0, :]
        moved += (sheared - _shear_compliance(cycle.layers, cycle, problem.bedded(cycle.wear), before, own))[
            :, None
        ] * tangential
        moved += sheared[:, None] * more * frictions
    compliance = problem.holder.compliance_at_contact_mm_per_N
    size = 2 * len(held)
    # Tractions of the core along x and y, and the holder's motion, so that the core stays and the forces balance.
    matrix, rhs = np.zeros((size + 1, size + 1)), np.zeros(size + 1)
    matrix[:size, :size] = influence[held][:, :2, held, :2].reshape(size, size)
    if cycle.influences.across:
        # What lies on the plane of a mirror carries nothing across it.
        across = 2 * np.flatnonzero(orbits.images[end][held] == rows[held]) + 1
        matrix[across, across] = 1.0
    if len(sheared):
        matrix[np.arange(size), np.arange(size)] += np.repeat(sheared[held], 2)
    matrix[:size:2, size] = 1.0
    matrix[size, :size:2] = compliance * weights[held]
    matrix[size, size] = -1.0
    rhs[:size] = -moved[held, :2].ravel()
    rhs[size] = -compliance * float(weights @ change[:, 0])
    found = np.linalg.solve(matrix, rhs)
    moved += np.einsum("iajb,jb->ia", influence[:, :, held, :2], found[:size].reshape(-1, 2))
    moved[:, 0] += found[size]
    everywhere = np.zeros((problem.primary.patch.size, 3))
    everywhere[position.nodes[rows]] = moved
    images = position.nodes[orbits.images[end]]
    beside = images != position.nodes[rows]
    everywhere[images[beside]] = moved[beside] * np.array([1.0, -1.0, 1.0])
    return everywhere


def _shear_compliance(
    layers: tuple[ContactLayer, ...], cycle: Cycle, worn: Depths, pressure: Array, own: slice
) -> Array:
    """Shear (u,) of layers by unit tractions on a position's unknowns, mm per MPa; (0,) where there are none."""
    if not layers:
        return np.zeros(0)
    none = np.zeros((len(pressure), 3))
    return layers_at_nodes(layers, cycle.orbits.opening(*worn)[own], none, none).shear_compliance(pressure)[0]


def _stretched(cycle: Cycle, stroke: range, end: int, face: Facing, released: Array) -> Array:
    """Factors (n,) on the slip of a stroke at all the primary's nodes, which move by `released` (n, 3) more over it."""
    slip = np.zeros(len(released))
    for k in stroke:
        position = cycle.positions[k]
        slip[position.nodes] += position.before
    nodes = cycle.positions[end].nodes
    more = -np.einsum("ij,ij->i", released[nodes], face.frictions[cycle.at(end)])
    factors = np.ones(len(released))
    slides = slip[nodes] > _LEAST_SLIP * float(slip.max())
    chosen = nodes[slides]
    factors[chosen] = np.clip(1.0 + more[slides] / slip[chosen], _LEAST, _LARGEST)
    return factors


@dataclass(frozen=True)
class StageSolution:
    """Solution of one stage of a cycle jump; N unknown pressures of all positions."""

    pressure: Array  #: (N,) MPa, at least 0.
    height: Array  #: (positions,) of the holder, mm.
    facing: Facing  #: Normals and loads on the worn surfaces.
    friction: Friction  #: The law at the unknowns.
    friction_work: Array  #: (N,) of one cycle per area, mJ/mm².
    wear_work: Array  #: (N,) likewise, as the wear law counts it.
    cycles: Array  #: (N,) number of cycles for which each unknown has worn.
    iterations: int  #: Steps of Newton's method, each on another surface.

    @property
    def works(self) -> tuple[Array, Array]:
        return self.friction_work, self.wear_work


def solve_stage(
    problem: ContactProblem, cycle: Cycle, before: WearState, lasting: Callable[[Array], Array], pressure: Array
) -> StageSolution:
    """The pressures of a cycle on surfaces that wear under these very pressures, from the wear state `before`.

    lasting: from pressures (N,) in MPa to the number of cycles (N,) for which each unknown wears. pressure: (N,) first
    guess, MPa. Raises NotConvergedError if they have not settled within 60 steps.
    """
    nothing = np.zeros_like(before.primary_depth), np.zeros_like(before.secondary_depth)
    recession = problem.wear.recession(before, nothing, problem.primary_is_upper)
    worn, active, cycles, seen = before, pressure > 0.0, lasting(pressure), before.opened(problem.retained)
    every, yielding = np.ones(cycle.orbits.count), yield_at(problem, cycle)
    stretch = every, every
    friction = cycle.law_at(problem, before, cycle.slip_lengths(stretch), pressure)
    for iteration in range(1, _MOST_ITERATIONS + 1):
        # Normals, slip and layers follow the pressures at every step: that costs little beside solving the equations.
        cycle.influences.know(active | cycle.sticks)
        # Iterations after which normals follow the wear by half: where a flat's edge wears a wall, pressures turn its
        # normals so far in one step that the two go on in turns.
        one, other = worn.opened(problem.retained)
        seen = (one, other) if iteration <= 12 else (0.5 * (seen[0] + one), 0.5 * (seen[1] + other))
        facing, known = cycle.facing(problem, seen), friction
        slip = cycle.slip_lengths(stretch)
        friction = cycle.law_at(problem, worn, slip, pressure)
        if 1 < iteration <= _FOLLOWED:
            cycles = lasting(pressure)
        if iteration == 1 or cycle.to_edge is not None:
            base, opens = _staying(problem, cycle, before, cycles * (pressure > 0.0))
            base_gaps = cycle.gaps(problem, base.opened(problem.retained))
        gaps, tangent = base_gaps, recession.tangent
        opening = cycle.orbits.opening_by((opens[0] * tangent[0], opens[1] * tangent[1]))
        if recession.beyond is not None:
            gaps = gaps + cycle.orbits.opening(opens[0] * recession.beyond[0], opens[1] * recession.beyond[1])
        known_by = problem, cycle, facing, gaps, opening, slip, cycles, problem.bedded(worn), friction
        equations = CycleEquations(*known_by, yielding)
        found = equations.improved(pressure, active)
        change = float(np.abs(found.pressure - pressure).max())
        pressure, active = found.pressure, found.active
        works = equations.works(np.maximum(pressure, 0.0))
        worn, recession = worn_by(problem, cycle, before, works, cycles)
        stretch = _stretch(problem, cycle, facing, pressure, worn, friction)
        allowed = (_SETTLED if found.linear else _SETTLED_LAYERS) * float(pressure.max())
        settled = change <= allowed and not friction.differs(known)
        if found.fits and iteration > 1 and settled:
            return StageSolution(np.maximum(pressure, 0.0), found.height, facing, friction, *works, cycles, iteration)
    raise NotConvergedError(
        f"the pressures of a cycle did not settle on the surface that they wear within {_MOST_ITERATIONS} iterations"
    )


def worn_by(
    problem: ContactProblem, cycle: Cycle, before: WearState, works: tuple[Array, Array], cycles: Array
) -> tuple[WearState, Recession]:
    """The wear state after a cycle is repeated, and the rates by which both bodies recede in it.

    works: friction work and wear work (N,) of one cycle per area, mJ/mm². cycles: (N,) how often each unknown's work is
    done.
    """
    energy = cycle.spread(cycles * works[0])
    work = energy if works[1] is works[0] else cycle.spread(cycles * works[1])
    totals = float(problem.surface.areas @ energy[0].ravel()), float(problem.surface.areas @ work[0].ravel())
    before = cycle.warmed(before, works[0])
    recession = problem.wear.recession(before, work, problem.primary_is_upper)
    bodies = problem.primary, problem.secondary
    after = after_work(before, recession.secant, energy, work, totals, bodies)
    if cycle.to_edge is not None:
        left, opened = _staying(problem, cycle, before, cycles * (works[0] > 0.0))
        bare = 1.0 - problem.retained
        pairs = zip(
            *(bodies, before.debris(problem.retained), left.debris(0.0), opened),
            *(after.depths, before.depths),
            strict=True,
        )
        kept, gone = [], before.debris_left_mm3
        for body, old, stays, share, now, then in pairs:
            kept.append(stays + (1.0 - share) * (now - then))
            gone += float(body.node_areas @ (old - stays + (share - bare) * (now - then)).ravel())
        after = replace(after, primary_debris=kept[0], secondary_debris=kept[1], debris_left_mm3=gone)
    return after, recession


def _staying(
    problem: ContactProblem, cycle: Cycle, before: WearState, cycles: Array
) -> tuple[WearState, tuple[Rate, Rate]]:
    """The state `before` with what stays of its debris after so many cycles under pressure (N,), and the shares of the
    depth worn meanwhile on (primary, secondary) that debris does not fill.
    """
    if problem.debris is None or cycle.to_edge is None:
        return before, (1.0 - problem.retained, 1.0 - problem.retained)
    paths = cycle.spread(cycles * cycle.slip_lengths())
    (own, made), (other, made_there) = map(staying, map(problem.debris.passages, paths, cycle.to_edge))
    primary, secondary = before.debris(problem.retained)
    left = replace(before, primary_debris=own * primary, secondary_debris=other * secondary)
    return left, (1.0 - problem.retained * made, 1.0 - problem.retained * made_there)


def _stretch(
    problem: ContactProblem, cycle: Cycle, facing: Facing, pressure: Array, worn: WearState, friction: Friction
) -> tuple[Array, Array]:
    """Factors (N,) by which slips before and after each position are longer than traced."""
    if cycle.strained:
        return released_slip(problem, cycle, facing, pressure, problem.bedded(worn), friction)
    position = cycle.orbits.position
    before, after = _carried(problem, cycle, facing, pressure, friction)
    return before[position], after[position]


def _carried(
    problem: ContactProblem, cycle: Cycle, facing: Facing, pressure: Array, friction: Friction
) -> tuple[Array, Array]:
    """By how much (positions,) slips before and after each are longer because another friction force carries the
    holder to another place.
    """
    compliance, count = problem.holder.compliance_at_contact_mm_per_N, len(cycle.positions)
    if compliance == 0.0:
        return np.ones(count), np.ones(count)
    forces = facing.pull[0] * pressure + facing.pull[1] * friction.limit(pressure)
    traced = [float(position.state.primary_force[:, 0].sum()) for position in cycle.positions]
    force = np.bincount(cycle.orbits.position, forces, count) + facing.stuck_pull
    shift = np.asarray(compliance * (force - traced))
    sign = -1.0 if cycle.half else 1.0
    moved = np.array([position.moved for position in cycle.positions])
    moves = np.array([position.moves for position in cycle.positions])
    # Where the bodies move by less, slip is not rescaled.
    least = 0.05 * float(np.abs(moved).max())
    for k in map(int, np.flatnonzero(np.abs(moved) <= least)):
        # Where the contact sticks, the holder stands as it stood before, whatever friction could bear.
        shift[k] = shift[k - 1] if k else sign * shift[-1]
    earlier, later = np.append(sign * shift[-1], shift[:-1]), np.append(shift[1:], sign * shift[0])

    ends = ends_of_strokes(cycle.positions, cycle.half_cycle) if cycle.uncertain else range(count)
    before = _longer(moved, shift - earlier, least, ends)
    after = _longer(moves, later - shift, least, range(count))
    # The slip after a place is that before the next one, with what that makes up for.
    return before, np.where(moves == np.roll(moved, -1), np.roll(before, -1), after)


def _longer(motion: Array, change: Array, least: float, ends: Sequence[int]) -> Array:
    """By how much (positions,) slips over increments are longer where the holder moves by `change` more over them, mm.

    motion: of the rigid bodies over the increments, mm. A slip becomes `_LEAST_STRETCH` to `_LARGEST_STRETCH` as long;
    what is left is made up for by the next ones up to a position of `ends`.
    """
    factors, left = np.ones(len(motion)), 0.0
    for k in range(len(motion)):
        if abs(motion[k]) > least:
            wanted = 1.0 - change[k] / motion[k] + left / abs(motion[k])
            factors[k] = min(max(wanted, _LEAST_STRETCH), _LARGEST_STRETCH)
            left = (wanted - factors[k]) * abs(motion[k])
        if k in ends:
            left = 0.0
    return factors
