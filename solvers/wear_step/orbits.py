"""The unknowns of a cycle, one for each set of nodes that its symmetries make alike, and how they share the wear.

A position is a stop of the traced cycle with the nodes that may touch there. Local tangents are rows 1 and 2 of a
node's frame, see `Pairing`; the first lies along the motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix, hstack, vstack

from geometry.arrays import Array, BoolArray, IntArray
from solvers.contact import ContactProblem
from solvers.contact.problem import faced, facing_offset, levers, vertical_gaps
from solvers.contact_state import ContactState
from solvers.elasticity.pairing import Pairing
from solvers.jit_cache import compiled
from solvers.laws.layers import layers_at_nodes
from solvers.wear import Rate
from solvers.wear_step.influence import displaced
from solvers.wear_step.places import WearStop
from solvers.wear_step.symmetry import Mirror, Symmetry

_ON_THE_PLANE = 1e-10  # Nodes nearer than this to the plane of symmetry lie on it, mm.


@dataclass(frozen=True)
class Position:
    """One position of a cycle, with the k nodes of the primary that may touch there."""

    state: ContactState  #: As traced.
    pairing: Pairing  #: The k nodes with what they face.
    lever: Array  #: (k,) distance along x of the nodes ahead of the holder's pivot, mm.
    #: (k, 2) unit vector, in the local tangents, of the friction on the upper body; 0 where a node sticks.
    direction: Array
    stuck: Array  #: (k, 2) tangential traction of nodes that stick, in the local tangents, MPa.
    before: Array  #: (k,) length of the slip up to here, from the stop before, mm; 0 where a node sticks.
    after: Array  #: (k,) length of the slip from here to the next stop, mm; 0 where a node sticks at that.
    moved: float  #: Motion along x of the lower relative to the upper body, both rigid, up to here, mm.
    moves: float  #: Likewise from here to the next stop, mm.
    driven: float  #: Length of the drive's motion, mean of before and after, mm.
    #: Load times slip for which it stands over its own load times slip; 1 unless increments beside it have no stop.
    share: float

    @property
    def nodes(self) -> IntArray:
        return self.pairing.nodes

    @property
    def slides(self) -> bool:
        return bool(self.before.any() or self.after.any())


def positions_of(
    problem: ContactProblem, stops: Sequence[WearStop], nodes: Sequence[IntArray], half_cycle: Mirror | None
) -> tuple[Position, ...]:
    """The positions at the stops of a cycle. nodes: for each, (k,) nodes of the primary that may touch there.
    half_cycle: the mirror onto the other half of the cycle; None if the stops cover all of it.
    """
    pairings = [
        faced(problem, state, of, state.drive, state.holder_x, state.holder_tilt)
        for (state, *_), of in zip(stops, nodes, strict=True)
    ]
    strains = _strains(problem, stops, pairings)
    met = [_met(problem, *each) for each in zip(pairings, stops, strains, strict=True)]
    sticks = met[0][1] if half_cycle is None else half_cycle.image(met[0][1], half_cycle.primary)
    following = (*(later for _, later in met[1:]), sticks)
    return tuple(_joined(one, stop, after) for (one, _), stop, after in zip(met, stops, following, strict=True))


def facing_nodes(problem: ContactProblem, state: ContactState, margin: float) -> IntArray:
    """Indices (k,) of the primary's nodes that are under pressure, or whose gap in rigid bodies is less than `margin`
    times the largest overlap.
    """
    gap = vertical_gaps(problem, state, state.drive, state.holder_x) + state.holder_z
    return np.flatnonzero((gap < -margin * min(float(gap.min()), 0.0)) | (state.traction[:, 2] > 0.0))


def _met(
    problem: ContactProblem, pairing: Pairing, stop: WearStop, strains: Sequence[tuple[Array, Array]]
) -> tuple[Position, BoolArray]:
    """The position as if no node stuck at the next one, and which (n,) of all the primary's nodes stick here under
    pressure. strains: motions (n, 3) of both bodies' nodes over each of the stop's legs.
    """
    old, new, following, nodes = stop.begins, stop.state, stop.ends, pairing.nodes
    lever = levers(problem, new.drive, new.holder_x)[nodes]
    # Slip after a position is that of the points that face each other there, as slip before it is: friction work is
    # then that of the mean traction, also where points move into and out of a strained contact.
    slip, later, *own = (
        _slip(problem, pairing, lever, *leg, moved) for leg, moved in zip(stop.legs, strains, strict=True)
    )
    # Friction opposes the slip of the moment: before, the bodies may have stuck, or slid the other way.
    latest = own[0] if own else slip
    size = np.linalg.norm(latest, axis=1)
    traction = new.traction[nodes]
    pressure = np.einsum("ij,ij->i", traction, pairing.frames[:, 0, :])
    tangential = np.einsum("ij,ikj->ik", traction, pairing.frames[:, 1:, :])
    # Newton's method knows which nodes stick: what else moves a little is the bodies' strain along the motion.
    still = new.primary_slid[nodes] == stop.approached.primary_slid[nodes]
    sticks = (pressure > 0.0) & still & (problem.law.limit(pressure) > 0.0)
    moving = ~sticks & (size > 0.0)
    direction = np.zeros_like(slip)
    direction[moving] = -latest[moving] / size[moving, None]
    everywhere = np.zeros(problem.primary.patch.size, dtype=bool)
    everywhere[nodes] = sticks
    driven = 0.5 * (abs(new.drive - old.drive) + abs(following.drive - new.drive))
    position = Position(
        state=new,
        pairing=pairing,
        lever=lever,
        before=np.where(sticks, 0.0, np.linalg.norm(slip, axis=1)),
        after=np.linalg.norm(later, axis=1),
        direction=direction,
        stuck=np.where(sticks[:, None], tangential, 0.0),
        moved=(new.drive - old.drive) - (new.holder_x - old.holder_x),
        moves=(following.drive - new.drive) - (following.holder_x - new.holder_x),
        driven=driven if stop.driven is None else stop.driven,
        share=1.0,
    )
    return position, everywhere


def _joined(position: Position, stop: WearStop, sticks: BoolArray) -> Position:
    """The position before one at which all nodes `sticks` (n,) of the primary stick."""
    after = np.where(sticks[position.nodes], 0.0, position.after)
    load = position.pairing.areas * np.maximum(stop.state.traction[position.nodes, 2], 0.0)
    own = 0.5 * float(load @ (position.before + after))
    return replace(position, after=after, share=1.0 if stop.load_slip is None or own == 0.0 else stop.load_slip / own)


def _strains(
    problem: ContactProblem, stops: Sequence[WearStop], pairings: Sequence[Pairing]
) -> list[list[tuple[Array, Array]]]:
    """Displacements (n, 3) of the primary and the secondary over each leg of each stop, where paired."""
    # The slip after a stop is mostly that before the next one.
    legs = {(id(old), id(new)): (old, new) for stop in stops for old, new in stop.legs}
    changes = (
        np.array([new.primary_force - old.primary_force for old, new in legs.values()]),
        np.array([new.secondary_force - old.secondary_force for old, new in legs.values()]),
    )
    reached = [pairing.nodes for pairing in pairings], [pairing.opposite.columns for pairing in pairings]
    moved = (
        displaced(body, np.unique(np.concatenate(nodes)), change)
        for body, nodes, change in zip((problem.primary, problem.secondary), reached, changes, strict=True)
    )
    known = dict(zip(legs, zip(*moved, strict=True), strict=True))
    return [[known[id(old), id(new)] for old, new in stop.legs] for stop in stops]


def _slip(
    problem: ContactProblem,
    pairing: Pairing,
    lever: Array,
    old: ContactState,
    new: ContactState,
    strains: tuple[Array, Array],
) -> Array:
    """Slip (k, 2) in the local tangents of what faces each other in a pairing, from one state to another, mm."""
    own, other = strains
    elastic = own[pairing.nodes] + pairing.opposite.averaged(other) / pairing.areas[:, None]
    motion = _relative_motion(problem, pairing, lever, old, new, elastic)
    return np.asarray(np.einsum("ij,ikj->ik", motion, pairing.frames[:, 1:, :]))


def _relative_motion(
    problem: ContactProblem, pairing: Pairing, lever: Array, old: ContactState, new: ContactState, elastic: Array
) -> Array:
    """Motion (k, 3) of the upper against the lower body at the nodes from one state to the next, mm.

    elastic: (k, 3) the part of it that is both bodies' strain.
    """
    nodes, motion = pairing.nodes, elastic
    motion[:, 0] += new.holder_x - old.holder_x - (new.drive - old.drive)
    motion[:, 2] += new.holder_z - old.holder_z + lever * (new.holder_tilt - old.holder_tilt)
    step = new.bulk - old.bulk
    if step.any():
        motion += problem.stretched(step, nodes, facing_offset(problem, new, new.drive, new.holder_x))
    motion += problem.layer_mm_per_MPa * (new.traction[nodes] - old.traction[nodes])
    if problem.layers:
        primary, secondary = problem.bedded(new.wear)
        worn = primary.ravel()[nodes] + pairing.opposite.averaged(secondary.ravel()) / pairing.areas
        normals = pairing.frames[:, 0, :]
        after, before = (layers_at_nodes(problem.layers, worn, of.traction[nodes], normals) for of in (new, old))
        motion += after.old_displacement - before.old_displacement
    return np.asarray(motion)


class Opening(NamedTuple):
    """Linear map from wear work per area at the N unknowns (mJ/mm²) to the gap along z (mm) that its wear opens at
    them. Both bodies wear at the n nodes of their patches: `worked` brings work there, `faced` the wear back.
    """

    #: (N, n) sparse, mean over the nodes that face each other at an unknown, times their wear coefficients, mm³/mJ.
    faced: csr_matrix
    #: (N, n) sparse, work per area on the nodes, summed over all places alike, by unit work per area at an unknown.
    #: `faced` times its transpose is what one unknown opens at another, of which few entries are ever needed.
    worked: csr_matrix

    def by(self, work: Array) -> Array:
        """Gap (N,) in mm that opens along z at the unknowns by wear work per area (N,), in mJ/mm², at them."""
        return np.asarray(self.faced @ (self.worked.T @ work))


@dataclass(frozen=True)
class Orbits:
    """The N unknown pressures of a cycle's positions: with a mirror y -> -y, those of the nodes with y >= 0 only."""

    rows: tuple[IntArray, ...]  #: For each position, (u,) which of its nodes are unknowns.
    #: For each position, (u,) which of its nodes are their mirror images; the unknown itself if it has none.
    images: tuple[IntArray, ...]
    twice: Array  #: (N,) 2 where an unknown stands for its image, too, else 1.
    start: IntArray  #: (positions + 1,) index of each position's first unknown, and N.
    areas: Array  #: (N,) of the unknown's own node, mm².
    nodes: IntArray  #: (N,) node of the primary's patch.
    secondary: csr_matrix  #: (N, n) sparse, mean over the secondary's n nodes that each unknown faces.
    worked: csr_matrix  #: As in `Opening`: columns are the nodes of the primary, then those of the secondary.

    @property
    def count(self) -> int:
        return int(self.start[-1])

    @cached_property
    def position(self) -> IntArray:
        return np.repeat(np.arange(len(self.rows)), np.diff(self.start))

    @cached_property
    def _primary(self) -> int:
        """Number of the primary's nodes."""
        return int(self.worked.shape[1] - self.secondary.shape[1])

    @cached_property
    def _faced(self) -> csr_matrix:
        """Mean (N, n) over the nodes of both patches that face each other at each unknown."""
        own = csr_matrix((np.ones(self.count), self.nodes, np.arange(self.count + 1)), (self.count, self._primary))
        return hstack([own, self.secondary]).tocsr()

    def opening_by(self, rates: tuple[Rate, Rate]) -> Opening:
        """The map from wear work to the gap that it opens, by wear coefficients in mm³/mJ of the primary and the
        secondary: one for a whole body, or (n_a, n_t) for its nodes.
        """
        coefficients = np.empty(self.worked.shape[1])
        coefficients[: self._primary], coefficients[self._primary :] = map(np.ravel, rates)
        return Opening(_scaled_columns(self._faced, coefficients), self.worked)

    def deposited(self, work: Array) -> tuple[Array, Array]:
        """Work per area in mJ/mm² on the nodes of the primary's patch, and on those of the secondary's, each (n,): the
        sum of what all unknowns leave there. work: (N,) in mJ/mm² at the unknowns, and at each place that a symmetry
        makes like one.
        """
        both = self.worked.T @ work
        return both[: self._primary], both[self._primary :]

    def opening(self, primary_depth: Array, secondary_depth: Array) -> Array:
        """Opening (N,) in mm of the gap along z at the unknowns by depths in mm on both patches, each of its patch's
        shape (n_a, n_t).
        """
        return np.asarray(primary_depth.ravel()[self.nodes] + self.secondary @ secondary_depth.ravel())


def orbits_of(problem: ContactProblem, positions: Sequence[Position], symmetry: Symmetry) -> Orbits:
    """The unknowns of the positions of a cycle; if the symmetry has a `half_cycle`, the positions are those of its
    first half.
    """
    across, later = symmetry.across, symmetry.half_cycle
    side = problem.primary.node_positions[:, 1]
    n = problem.primary.patch.size
    rows, images, twice = [], [], []
    own, other, worn = [], [], []
    kept = ~_faces_core(problem, positions, later)
    for position in positions:
        nodes = position.nodes
        chosen = np.flatnonzero(side[nodes] > -_ON_THE_PLANE) if across else np.arange(len(nodes))
        place = np.zeros(n, dtype=np.int64)
        place[nodes] = np.arange(len(nodes))
        rows.append(chosen)
        images.append(place[across.primary[nodes[chosen]]] if across else chosen)
        twice.append(np.where(side[nodes[chosen]] > _ON_THE_PLANE, 2.0, 1.0) if across else np.ones(len(chosen)))
        own.append(nodes[chosen])
        faced = position.pairing.depths.sparse[chosen]
        other.append(faced)
        worn.append(_among(faced, kept))
    factor, areas = np.concatenate(twice), problem.secondary.patch.node_areas()
    every = np.concatenate(own)
    primary = csr_matrix((np.ones(len(every)), every, np.arange(len(every) + 1)), shape=(len(every), n))
    secondary = vstack(worn).tocsr()
    for mirror, image in ((across, factor - 1.0), (later, np.ones(len(factor)))):
        if mirror:
            primary = _with_images(primary, mirror.primary, image)
            secondary = _with_images(secondary, mirror.secondary, image)
    own_areas = np.concatenate([p.pairing.areas[chosen] for p, chosen in zip(positions, rows, strict=True)])
    return Orbits(
        rows=tuple(rows),
        images=tuple(images),
        twice=factor,
        start=np.concatenate([[0], np.cumsum([len(chosen) for chosen in rows])]),
        areas=own_areas,
        nodes=every,
        secondary=scaled_rows(vstack(other).tocsr(), 1.0 / own_areas),
        worked=hstack([primary, _scaled_columns(secondary, 1.0 / areas)]).tocsr(),
    )


def _faces_core(problem: ContactProblem, positions: Sequence[Position], later: Mirror | None) -> BoolArray:
    """Which of the secondary's nodes (n,) are those that nodes face which stick throughout the cycle.

    They stick as well: work at the edge of the sticking core, spread over a node's support, must not wear into it.
    """
    core, others = positions[-1].state.core, problem.secondary.patch.size
    if later:
        core = core & core[later.primary]
    if not core.any():
        return np.zeros(others, dtype=bool)
    faced_by_core = np.zeros(others)
    for position in positions:
        faced_by_core += position.pairing.depths.spread(core[position.nodes].astype(float))
    return np.asarray(faced_by_core > 0.0)


def _among(matrix: csr_matrix, kept: BoolArray) -> csr_matrix:
    """The matrix with its weights on some columns only, each row with its sum; rows that have none there stay."""
    if kept.all():
        return matrix
    masked = csr_matrix((matrix.data * kept[matrix.indices], matrix.indices, matrix.indptr), shape=matrix.shape)
    whole, left = np.asarray(matrix.sum(axis=1)).ravel(), np.asarray(masked.sum(axis=1)).ravel()
    lost = left <= 0.0
    if lost.any():
        keep = np.repeat(lost, np.diff(matrix.indptr)) | kept[matrix.indices]
        masked = csr_matrix((matrix.data * keep, matrix.indices, matrix.indptr), shape=matrix.shape)
        left = np.where(lost, whole, left)
    return scaled_rows(masked, whole / left)


def _with_images(matrix: csr_matrix, images: IntArray, factors: Array) -> csr_matrix:
    """The matrix with its weights on the columns' images (n,) as well, there times a factor for each row (N,).

    Columns may stand in a row twice, and in any order.
    """
    first, columns, weights = _entries_with_images(matrix.indptr, matrix.indices, matrix.data, images, factors)
    return csr_matrix((weights, columns, first), shape=matrix.shape)


@compiled
def _entries_with_images(
    first: IntArray, columns: IntArray, weights: Array, images: IntArray, factors: Array
) -> tuple[IntArray, IntArray, Array]:
    starts = np.zeros_like(first)
    for row in range(len(factors)):
        count = first[row + 1] - first[row]
        starts[row + 1] = starts[row] + (count if factors[row] == 0.0 else 2 * count)
    found, values = np.empty(starts[-1], dtype=columns.dtype), np.empty(starts[-1])
    for row in range(len(factors)):
        used = starts[row]
        for entry in range(first[row], first[row + 1]):
            found[used], values[used] = columns[entry], weights[entry]
            used += 1
        if factors[row] != 0.0:
            for entry in range(first[row], first[row + 1]):
                found[used], values[used] = images[columns[entry]], factors[row] * weights[entry]
                used += 1
    return starts, found, values


def scaled_rows(matrix: csr_matrix, factors: Array) -> csr_matrix:
    """The sparse matrix (N, n) with each row multiplied by its factor (N,)."""
    return csr_matrix(
        (matrix.data * np.repeat(factors, np.diff(matrix.indptr)), matrix.indices, matrix.indptr), matrix.shape
    )


def _scaled_columns(matrix: csr_matrix, factors: Array) -> csr_matrix:
    return csr_matrix((matrix.data * factors[matrix.indices], matrix.indices, matrix.indptr), matrix.shape)
