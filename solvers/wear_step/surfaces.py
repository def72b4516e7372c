"""The contact conditions of all positions of a cycle on given surfaces.

A position is one instant of the traced cycle with the nodes of the primary that may touch there, K nodes of all
positions one after another; N of them, the unknowns, are those whose pressures are solved for (the others are their
mirror images). Forces and displacements are the upper body's relative to the lower, in world axes; a gap is along z.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy

from geometry import ContactPatch
from geometry.arrays import Array, BoolArray, IntArray
from solvers.contact import ContactProblem
from solvers.contact.between_nodes import WithinElements
from solvers.contact_state import WearState
from solvers.elasticity.nodal_transfer import weighted_sums
from solvers.elasticity.pairing import frames_on
from solvers.elasticity.quadrature import gradient
from solvers.jit_cache import compiled, inlined
from solvers.laws.friction_law import Friction
from solvers.laws.layers import ContactLayer
from solvers.laws.local_state import LocalState
from solvers.wear_step.coupled import SimilarEquations
from solvers.wear_step.influence import Influences
from solvers.wear_step.orbits import Orbits, Position
from solvers.wear_step.strokes import slip_is_left_over, strain_counts
from solvers.wear_step.symmetry import Mirror
from solvers.wear_step.warming import Warming

Depths = tuple[Array, Array]  #: Worn depths (mm) of the primary and the secondary body, each of the shape of its patch.


class Facing(NamedTuple):
    """Normals of the worn surfaces, and forces by the tractions on them, at all positions, one after another. N: number
    of unknown pressures; K: number of nodes.
    """

    upward: Array  #: (N,) z component of the unknowns' unit normals.
    by_stuck: Array  #: (N,) normal displacement in mm by the fixed tractions of sticking nodes.
    #: (2, N) force along z in N per MPa of pressure, row 0, and of friction, row 1, at each unknown and its image.
    lift: Array
    pull: Array  #: (2, N) force along x likewise.
    stuck_lift: Array  #: (positions,) force along z in N of the sticking nodes' tractions.
    stuck_pull: Array  #: (positions,) their force along x, N.
    normals: Array  #: (K, 3) unit normals, from the lower to the upper body.
    frictions: Array  #: (K, 3) unit vectors of the friction on the upper body, 0 at nodes that stick.
    stuck: Array  #: (K, 3) tangential traction of nodes that stick, MPa; 0 at others.


class CycleNodes(NamedTuple):
    """The K nodes of all positions of a cycle as they were traced, one position after another; n nodes on a patch."""

    start: IntArray  #: (positions + 1,) index of each position's first node, and K.
    rows: IntArray  #: (N,) index among the K of each unknown.
    nodes: IntArray  #: (K,) node of the primary's patch.
    areas: Array  #: (K,) mm².
    frames: Array  #: (K, 3, 3) normal and tangents as rows, see `Pairing`.
    core: BoolArray  #: (K,) True where a node has stuck ever since the bodies were pressed together.
    direction: Array  #: (K, 2) unit vector of friction in the tangents, 0 where a node sticks.
    stuck: Array  #: (K, 2) traction in MPa, in the tangents, of nodes that stick.
    first: IntArray  #: (K + 1,) with columns and weights: `NodalTransfer` of the secondary at the K nodes.
    columns: IntArray
    weights: Array

    @classmethod
    def of(cls, positions: Sequence[Position], rows: Sequence[IntArray]) -> "CycleNodes":
        """The nodes of all positions, joined; rows: for each position, (u,) which of its nodes are unknowns."""
        start = np.concatenate([[0], np.cumsum([len(position.nodes) for position in positions])])
        of_each = []
        for position, begin, own in zip(positions, start, rows, strict=False):
            pairing, transfer, core = position.pairing, position.pairing.opposite, position.state.core[position.nodes]
            traced = (pairing.areas, pairing.frames, core, position.direction, position.stuck)
            faced = (np.diff(transfer.first), transfer.columns, transfer.weights)
            of_each.append((begin + own, position.nodes, *traced, *faced))
        *joined, counts, columns, weights = (np.concatenate(parts) for parts in zip(*of_each, strict=True))
        return cls._make((start, *joined, np.concatenate([[0], np.cumsum(counts)]), columns, weights))


@dataclass(frozen=True)
class Cycle:
    """Positions of a cycle traced in the state `wear`, their unknowns, and both bodies' motion by unit tractions."""

    positions: tuple[Position, ...]
    orbits: Orbits  #: The N unknowns.
    influences: Influences  #: Displacements of a position's unknowns by unit tractions on one of them.
    wear: WearState  #: As the cycle was traced; depths and gaps below count from it.
    #: The mirror that maps these positions onto the other half of the cycle; None if they cover all of it.
    half_cycle: Mirror | None
    wearing: float | Array  #: Factor on the unknowns' wear work by law and oxygen, (N,) or one for all.
    layers: tuple[ContactLayer, ...] = ()  #: Between the surfaces as the cycle was traced.
    within: WithinElements | None = None  #: How pressure is spread within elements, for the unknowns.
    #: Distances in mm that debris on (primary, secondary) passes to leave, see `distances_to_edge`; None: it stays.
    to_edge: Depths | None = None
    warming: Warming | None = None  #: How its work warms both surfaces; None where that is not asked for.
    #: Solver of the pressures' equations, which keeps factors of earlier ones.
    similar: SimilarEquations = field(default_factory=SimilarEquations)

    @property
    def half(self) -> bool:
        return self.half_cycle is not None

    @cached_property
    def nodes(self) -> CycleNodes:
        return CycleNodes.of(self.positions, self.orbits.rows)

    @cached_property
    def sticks(self) -> BoolArray:
        return np.asarray(self.nodes.stuck[self.nodes.rows].any(axis=1))

    @cached_property
    def traced_slips(self) -> tuple[Array, Array]:
        """Slips (N,) in mm of the unknowns in the traced cycle: up to their position, and from it to the next."""
        before, after = (
            np.concatenate([slip[rows] for slip, rows in zip(slips, self.orbits.rows, strict=True)])
            for slips in zip(*((position.before, position.after) for position in self.positions), strict=True)
        )
        return before, after

    def slip_lengths(self, stretch: tuple[Array, Array] | None = None) -> Array:
        """Slip (N,) in mm that each unknown's pressure stands for: half of that before and half of that after it, and
        of positions that are left out as much as does the same work.

        stretch: (N,) factors on the slip before and after each position; None: as traced.
        """
        before, after = self.traced_slips
        shares = np.array([position.share for position in self.positions])[self.orbits.position]
        one, other = stretch or (1.0, 1.0)
        return np.asarray(0.5 * shares * (one * before + other * after))

    @cached_property
    def traced_pressures(self) -> Array:
        """Pressures (N,) in MPa of the unknowns in the traced cycle, at least 0."""
        pressures = [
            np.maximum(np.einsum("ij,ij->i", p.state.traction[p.nodes], p.pairing.frames[:, 0, :]), 0.0)[rows]
            for p, rows in zip(self.positions, self.orbits.rows, strict=True)
        ]
        return np.concatenate(pressures)

    @cached_property
    def strained(self) -> bool:
        """True if slip follows from the bodies' strain at the ends of strokes; see `strain_counts`."""
        return strain_counts(self.positions, self.half_cycle)

    @cached_property
    def uncertain(self) -> bool:
        """True if slip follows from bodies' strain, or is a small difference of large motions (`slip_is_left_over`)."""
        return self.strained or slip_is_left_over(self.positions, self.half_cycle)

    def facing(self, problem: ContactProblem, depths: Depths) -> Facing:
        """Normals and loads at all positions once surfaces are open to `depths`, in mm in all; see `WearState.opened`.

        Normals turn by the slopes of what wore since the trace, but not at nodes of the core; nodes, areas and
        influences stay as traced.
        """
        averaging, nodes, before = problem.surface.averaging, self.nodes, self.wear.opened(problem.retained)
        primary, secondary = (
            -body.facing * gradient(new - old, body.patch) @ body.world_to_patch
            for body, new, old in zip((problem.primary, problem.secondary), depths, before, strict=True)
        )
        own = averaging.averaged(primary, nodes.nodes)
        weights = self.orbits.areas * self.orbits.twice
        influences = self.influences
        return Facing(*_faced(nodes, own, secondary, self.orbits.start, weights, influences.store, influences.at))

    def spread(self, work: Array) -> Depths:
        """Work per area (N,) at the unknowns, summed on the nodes of (primary, secondary), of their patches' shapes."""
        primary, secondary = self.orbits.deposited(work)
        return primary.reshape(self.wear.primary_depth.shape), secondary.reshape(self.wear.secondary_depth.shape)

    def distances_to_edge(self, problem: ContactProblem) -> Depths:
        """Distances in mm from the nodes of (primary, secondary) to the edge of what the contact touches in the cycle,
        at least half an element.
        """
        touched = self.spread((self.traced_pressures > 0.0).astype(float))
        bodies = problem.primary.patch, problem.secondary.patch
        primary, secondary = (_to_edge(patch, nodes > 1e-9) for patch, nodes in zip(bodies, touched, strict=True))
        return primary, secondary

    def law_at(self, problem: ContactProblem, wear: WearState, slip: Array, pressure: Array) -> Friction:
        """The friction law at the N unknowns in a state of wear, on which, as on slip and pressure, the coefficient may
        depend. slip: (N,) mean slip in mm before and after each unknown's position. pressure: (N,) MPa.
        """
        orbits = self.orbits

        def sliding() -> Array:
            timing = problem.timing
            speeds = [timing.speed_mm_per_s(p.state.drive, falling=p.moved < 0.0) for p in self.positions]
            shares = [speed / max(p.driven, 1e-300) for speed, p in zip(speeds, self.positions, strict=True)]
            return np.asarray(np.array(shares)[orbits.position] * slip)

        local = LocalState(
            wear,
            lambda field: field[orbits.nodes],
            lambda field: orbits.secondary @ field,
            sliding,
            lambda: np.maximum(pressure, 0.0),
            problem.primary_is_upper,
            problem.cycle,
            problem.fields,
        )
        return replace(problem.law_at(local), within=self.within)

    def warmed(self, wear: WearState, work: Array) -> WearState:
        """The wear state with temperatures as friction work (N,) of one cycle per area in mJ/mm² at the unknowns raises
        them.
        """
        if self.warming is None:
            return wear
        primary, secondary, mean = self.warming.by(work)
        return replace(wear, primary_rise=primary, secondary_rise=secondary, rise_K=mean)

    def at(self, index: int) -> slice:
        """The nodes of the position of this index, as a slice of the K nodes of all positions, one after another."""
        return slice(*self.nodes.start[index : index + 2])

    def gaps(self, problem: ContactProblem, depths: Depths) -> Array:
        """Gaps (N,) in mm along z of the undeformed surfaces open to `depths` (in mm in all, see `WearState.opened`),
        with the holder at height 0; negative where the bodies overlap.
        """
        fresh = [
            (p.pairing.gap + p.lever * p.state.holder_tilt)[rows]
            for p, rows in zip(self.positions, self.orbits.rows, strict=True)
        ]
        traced = self.wear.opened(problem.retained)
        return np.asarray(np.concatenate(fresh) + self.orbits.opening(depths[0] - traced[0], depths[1] - traced[1]))


def _to_edge(patch: ContactPatch, touched: BoolArray) -> Array:
    """Distance in mm of each node (n_a, n_t) from the edge half an element beside the nearest node that is not touched;
    at least half an element.
    """
    half = 0.5 * patch.smallest_element
    places = np.stack(np.meshgrid(patch.axial_mm, patch.transverse_mm, indexing="ij"), axis=-1)
    beside = places[~touched]
    if not len(beside):
        return np.full(touched.shape, np.inf)
    return np.asarray(np.maximum(scipy.spatial.KDTree(beside).query(places)[0] - half, half))


@compiled
def _faced(
    nodes: CycleNodes, own: Array, secondary: Array, start: IntArray, weights: Array, store: Array, at: IntArray
) -> tuple[Array, Array, Array, Array, Array, Array, Array, Array, Array]:
    """The entries of `Facing`.

    own: (K, 2) by how much the primary's slopes turn about each node, times its area.  secondary: (n, 2) the other's
    at the nodes of its patch.  start: (positions + 1,) where unknowns begin.  weights: (N,) mm².  store, at: see
    `Influences`.
    """
    count = len(nodes.areas)
    other = weighted_sums(nodes.first, nodes.columns, nodes.weights, secondary, np.arange(count))
    slope = np.empty((count, 2))
    for k in range(count):
        for c in range(2):
            turned = 0.0 if nodes.core[k] else 0.5 * (own[k, c] + other[k, c]) / nodes.areas[k]
            slope[k, c] = turned - nodes.frames[k, 0, c] / nodes.frames[k, 0, 2]
    frames = frames_on(slope)
    normals, frictions, held = np.empty((count, 3)), np.empty((count, 3)), np.empty((count, 3))
    for k in range(count):
        for c in range(3):
            normals[k, c] = frames[k, 0, c]
            frictions[k, c] = nodes.direction[k, 0] * frames[k, 1, c] + nodes.direction[k, 1] * frames[k, 2, c]
            held[k, c] = nodes.stuck[k, 0] * frames[k, 1, c] + nodes.stuck[k, 1] * frames[k, 2, c]
    size, positions = len(nodes.rows), len(start) - 1
    upward, by_stuck, lift, pull = np.empty(size), np.zeros(size), np.empty((2, size)), np.empty((2, size))
    stuck_lift, stuck_pull = np.zeros(positions), np.zeros(positions)
    for position in range(positions):
        for k in range(nodes.start[position], nodes.start[position + 1]):
            stuck_lift[position] += nodes.areas[k] * held[k, 2]
            stuck_pull[position] += nodes.areas[k] * held[k, 0]
        begin, end = start[position], start[position + 1]
        for j in range(begin, end):
            node, weight = nodes.rows[j], weights[j]
            upward[j] = normals[node, 2]
            lift[0, j], lift[1, j] = weight * normals[node, 2], weight * frictions[node, 2]
            pull[0, j], pull[1, j] = weight * normals[node, 0], weight * frictions[node, 0]
            x, y, z = held[node, 0], held[node, 1], held[node, 2]
            if x != 0.0 or y != 0.0 or z != 0.0:
                for i in range(begin, end):
                    by_stuck[i] += moved_along(store, at[j] + 9 * (i - begin), normals[nodes.rows[i]], x, y, z)
    return upward, by_stuck, lift, pull, stuck_lift, stuck_pull, normals, frictions, held


@inlined
def moved_along(store: Array, block: int, normal: Array, x: float, y: float, z: float) -> float:
    """Displacement in mm of one node along a normal (3,), by a traction (x, y, z) in MPa at another. The 9 influences
    (3, 3) in mm/MPa stand row by row in `store` from index `block` on (see `Influences`).
    """
    moved: float = normal[0] * (x * store[block] + y * store[block + 1] + z * store[block + 2])
    moved += normal[1] * (x * store[block + 3] + y * store[block + 4] + z * store[block + 5])
    moved += normal[2] * (x * store[block + 6] + y * store[block + 7] + z * store[block + 8])
    return moved
