"""The positions of a traced cycle: where the bodies face each other, how far and which way each node slides there."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from solvers.contact import ContactProblem
from solvers.contact.linearisation import faced, levers, vertical_gaps
from solvers.contact_layer import layers_at_nodes
from solvers.contact_state import ContactState
from solvers.pairing import Pairing
from solvers.wear_step.influence import displaced
from solvers.wear_step.symmetry import Mirror, mirrored


@dataclass(frozen=True)
class Position:
    """One position of a cycle, with the k nodes of the primary that may touch there.

    state: of the traced cycle.  pairing: of the nodes.  lever: (k,) distance ahead of the holder's pivot, mm.
    direction: (k, 2) unit vector of friction in the local tangents, zero where a node sticks.
    stuck: (k, 2) tangential traction of nodes that stick, in the local tangents, MPa.
    before, after: (k,) slip, mm, of the increment that ends here and of the next one; zero where a node sticks.
    moved, moves: relative motion of the rigid bodies along x over the two increments, mm.
    """

    state: ContactState
    pairing: Pairing
    lever: Array
    direction: Array
    stuck: Array
    before: Array
    after: Array
    moved: float
    moves: float

    @property
    def nodes(self) -> IntArray:
        """The (k,) nodes of the primary."""
        return self.pairing.nodes

    @property
    def slides(self) -> bool:
        """Whether any slip belongs to this position."""
        return bool(self.before.any() or self.after.any())


def positions_of(
    problem: ContactProblem,
    start: ContactState,
    states: Sequence[ContactState],
    nodes: Sequence[IntArray],
    half_cycle: Mirror | None,
) -> tuple[Position, ...]:
    """The positions of a cycle traced with the wear frozen, from `start` through the ends of its increments.

    states: of the whole closed cycle, or of its first half where `half_cycle` maps that onto the second.
    nodes: of the primary that may touch at each position.
    """
    last = states[0] if half_cycle is None else mirrored(states[0], half_cycle)
    passed = zip((start, *states[:-1]), states, (*states[1:], last), nodes, strict=True)
    met = [_met(problem, old, new, following, of) for old, new, following, of in passed]
    sticks = met[0].sticks if half_cycle is None else half_cycle.image(met[0].sticks, half_cycle.primary)
    following = (*(row.sticks for row in met[1:]), sticks)
    return tuple(_position(row, state, after) for row, state, after in zip(met, states, following, strict=True))


def facing_nodes(problem: ContactProblem, state: ContactState, margin: float) -> IntArray:
    """Nodes of the primary that touch, or come as close as `margin` times the largest overlap of the rigid bodies."""
    gap = vertical_gaps(problem, state, state.drive, state.holder_x) + state.holder_z
    return np.flatnonzero((gap < -margin * min(float(gap.min()), 0.0)) | (state.traction[:, 2] > 0.0))


@dataclass(frozen=True)
class _Met:
    """A position by itself, between the one before it and the next.

    sticks: (n,) which of all the primary's nodes stick there under pressure.  after: (k,) slip of all nodes.
    """

    pairing: Pairing
    lever: Array
    before: Array
    after: Array
    sticks: BoolArray
    direction: Array
    stuck: Array
    moved: float
    moves: float


def _met(
    problem: ContactProblem, old: ContactState, new: ContactState, following: ContactState, nodes: IntArray
) -> _Met:
    pairing = faced(problem, new, nodes, new.drive, new.holder_x, new.holder_tilt)
    lever = levers(problem, new.drive, new.holder_x)[nodes]
    # Slip after a position is that of the points that face each other there, as slip before it is: friction work is
    # then that of the mean traction, also where points move into and out of a strained contact.
    slip, later = _slips(problem, pairing, lever, (old, new, following))
    size = np.linalg.norm(slip, axis=1)
    traction = new.traction[nodes]
    pressure = np.einsum("ij,ij->i", traction, pairing.frames[:, 0, :])
    tangential = np.einsum("ij,ikj->ik", traction, pairing.frames[:, 1:, :])
    # Newton's method knows which nodes stick: what else moves a little is the bodies' strain along the motion.
    still = new.primary_slid[nodes] == old.primary_slid[nodes]
    sticks = (pressure > 0.0) & still & (problem.law.limit(pressure) > 0.0)
    moving = ~sticks & (size > 0.0)
    direction = np.zeros_like(slip)
    direction[moving] = -slip[moving] / size[moving, None]
    everywhere = np.zeros(problem.primary.patch.size, dtype=bool)
    everywhere[nodes] = sticks
    return _Met(
        pairing=pairing,
        lever=lever,
        before=np.where(sticks, 0.0, size),
        after=np.linalg.norm(later, axis=1),
        sticks=everywhere,
        direction=direction,
        stuck=np.where(sticks[:, None], tangential, 0.0),
        moved=_rigid_motion(old, new),
        moves=_rigid_motion(new, following),
    )


def _position(met: _Met, state: ContactState, sticks: BoolArray) -> Position:
    """sticks: (n,) which of all the primary's nodes stick at the next position."""
    return Position(
        state=state,
        pairing=met.pairing,
        lever=met.lever,
        direction=met.direction,
        stuck=met.stuck,
        before=met.before,
        after=np.where(sticks[met.pairing.nodes], 0.0, met.after),
        moved=met.moved,
        moves=met.moves,
    )


def _rigid_motion(old: ContactState, new: ContactState) -> float:
    return (new.drive - old.drive) - (new.holder_x - old.holder_x)


def _slips(problem: ContactProblem, pairing: Pairing, lever: Array, states: Sequence[ContactState]) -> list[Array]:
    """Slips (k, 2) in the local tangents of what faces each other in a pairing, from each state to the next, mm."""
    steps = list(pairwise(states))
    own = displaced(
        problem.primary, pairing.nodes, np.array([new.primary_force - old.primary_force for old, new in steps])
    )
    faced = np.unique(pairing.opposite.columns)
    other = displaced(
        problem.secondary, faced, np.array([new.secondary_force - old.secondary_force for old, new in steps])
    )
    slips = []
    for (old, new), mine, its in zip(steps, own, other, strict=True):
        moved = np.zeros((pairing.opposite.size, 3))
        moved[faced] = its
        elastic = mine + pairing.opposite.averaged(moved) / pairing.areas[:, None]
        motion = _relative_motion(problem, pairing, lever, old, new, elastic)
        slips.append(np.asarray(np.einsum("ij,ikj->ik", motion, pairing.frames[:, 1:, :])))
    return slips


def _relative_motion(
    problem: ContactProblem, pairing: Pairing, lever: Array, old: ContactState, new: ContactState, elastic: Array
) -> Array:
    """Motion (k, 3) of the upper against the lower body at the nodes from one state to the next, mm.

    elastic: (k, 3) the part of it that is both bodies' strain.
    """
    nodes, motion = pairing.nodes, elastic
    motion[:, 0] += new.holder_x - old.holder_x - (new.drive - old.drive)
    motion[:, 2] += new.holder_z - old.holder_z + lever * (new.holder_tilt - old.holder_tilt)
    motion += problem.layer_mm_per_MPa * (new.traction[nodes] - old.traction[nodes])
    if problem.layers:
        other_depth = pairing.opposite.averaged(new.wear.secondary_depth.ravel()) / pairing.areas
        worn = new.wear.primary_depth.ravel()[nodes] + other_depth
        normals = pairing.frames[:, 0, :]
        after, before = (layers_at_nodes(problem.layers, worn, of.traction[nodes], normals) for of in (new, old))
        motion += after.old_displacement - before.old_displacement
    return np.asarray(motion)
