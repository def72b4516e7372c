"""The contact conditions of all positions of a cycle on surfaces of given depth: normals, gaps, elastic influence."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled, inlined
from solvers.contact import ContactProblem
from solvers.contact_layer import ContactLayer, open_share
from solvers.nodal_transfer import weighted_sums
from solvers.pairing import frames_on
from solvers.quadrature import gradient
from solvers.wear_step.influence import Influence
from solvers.wear_step.orbits import Orbits
from solvers.wear_step.positions import Position
from solvers.wear_step.similar_equations import SimilarEquations
from solvers.wear_step.strokes import slip_is_left_over, strain_counts
from solvers.wear_step.symmetry import Mirror

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

#: Worn depths (mm) of the primary and the secondary body, each of the shape of its patch.
Depths = tuple[Array, Array]


class Facing(NamedTuple):
    """One position on surfaces of given depth, with its u unknowns; tractions in MPa, lengths in mm.

    upward: (u,) z component of the normals.  on: (a,) unknowns in contact.  by_pressure, by_friction: (u, a) normal
    displacement by unit pressure and by unit friction in its direction on these.  by_stuck: (u,) that by the tractions
    of sticking nodes.
    lift, pull: (2, u) load along z and x by unit pressure and by unit friction at each unknown and its image, mm².
    stuck_lift, stuck_pull: what sticking nodes add, N.
    normals, frictions, stuck: (k, 3) unit normal, direction of friction and stuck traction of all nodes.
    """

    upward: Array
    on: IntArray
    by_pressure: Array
    by_friction: Array
    by_stuck: Array
    lift: Array
    pull: Array
    stuck_lift: float
    stuck_pull: float
    normals: Array
    frictions: Array
    stuck: Array


@dataclass(frozen=True)
class Cycle:
    """The positions of a cycle, traced on surfaces worn to `depths`, their unknowns, and both bodies' influence there.

    influences: for each position, of its u unknowns.  half_cycle: the mirror whose image of the positions is
    the other half of the cycle, where they are half of one.  wearing: (N,) factor on the wear coefficients.
    layers: between the surfaces as the cycle was traced.  similar: what is known so far of the equations of its
    pressures.
    """

    positions: tuple[Position, ...]
    orbits: Orbits
    influences: tuple[Influence, ...]
    depths: Depths
    half_cycle: Mirror | None
    wearing: Array
    layers: tuple[ContactLayer, ...] = ()
    similar: SimilarEquations = field(default_factory=SimilarEquations)

    @property
    def half(self) -> bool:
        """Whether the positions are those of half a cycle."""
        return self.half_cycle is not None

    @cached_property
    def traced_slips(self) -> tuple[Array, Array]:
        """Slips (N,) in mm before and after the unknowns' positions, as the cycle was traced."""
        before, after = (
            np.concatenate([slip[rows] for slip, rows in zip(slips, self.orbits.rows, strict=True)])
            for slips in zip(*((position.before, position.after) for position in self.positions), strict=True)
        )
        return before, after

    @cached_property
    def strained(self) -> bool:
        """Whether slip depends on the bodies' strain; see `strain_counts`."""
        return strain_counts(self.positions, self.half_cycle)

    @cached_property
    def uncertain(self) -> bool:
        """Whether slip depends on the bodies' strain, or is what rig and strain leave over; see `slip_is_left_over`."""
        return self.strained or slip_is_left_over(self.positions, self.half_cycle)

    def facing(self, problem: ContactProblem, depths: Depths, active: BoolArray) -> tuple[Facing, ...]:
        """All positions on surfaces worn to other depths, where only the normals turn; active: (N,) in contact."""
        share, averaging = open_share(problem.layers), problem.surface.averaging
        primary, secondary = (
            -share * body.facing * gradient(new - old, body.patch) @ body.world_to_patch
            for body, new, old in zip((problem.primary, problem.secondary), depths, self.depths, strict=True)
        )
        found, start = [], self.orbits.start
        weights = self.orbits.areas * self.orbits.twice
        for k, (position, rows) in enumerate(zip(self.positions, self.orbits.rows, strict=True)):
            pairing, own = position.pairing, slice(start[k], start[k + 1])
            on, loaded = np.flatnonzero(active[own]), active[own] | position.stuck[rows].any(axis=1)
            faced = _faced(
                averaging.first,
                averaging.columns,
                averaging.weights,
                primary,
                pairing.opposite.first,
                pairing.opposite.columns,
                pairing.opposite.weights,
                secondary,
                pairing.nodes,
                pairing.areas,
                pairing.frames,
                position.state.core,
                position.direction,
                position.stuck,
                self.influences[k].of(np.flatnonzero(loaded)),
                rows,
                on,
                weights[own],
            )
            found.append(Facing(*faced))
        return tuple(found)

    def gaps(self, problem: ContactProblem, depths: Depths) -> Array:
        """Gap (N,) along z of the undeformed surfaces worn to these depths, with the holder at height 0, mm."""
        fresh = [
            (p.pairing.gap + p.lever * p.state.holder_tilt)[rows]
            for p, rows in zip(self.positions, self.orbits.rows, strict=True)
        ]
        opened = self.orbits.opening(depths[0] - self.depths[0], depths[1] - self.depths[1])
        return np.asarray(np.concatenate(fresh) + open_share(problem.layers) * opened)


@compiled
def _faced(
    first: IntArray,
    columns: IntArray,
    shares: Array,
    primary: Array,
    other_first: IntArray,
    other_columns: IntArray,
    other_shares: Array,
    secondary: Array,
    nodes: IntArray,
    areas: Array,
    frames: Array,
    core: BoolArray,
    direction: Array,
    stuck: Array,
    influence: Array,
    rows: IntArray,
    on: IntArray,
    weights: Array,
) -> tuple[Array, IntArray, Array, Array, Array, Array, Array, float, float, Array, Array, Array]:
    """The entries of `Facing` of one position.

    primary, secondary: (n, 2) by how much slopes turn at the nodes of either patch, which the averaging of the one and
    the transfer to the other take to k paired nodes.  core: (n,).  rows, weights: (u,) of the
    unknowns, `on` (a,) in contact.
    """
    own = weighted_sums(first, columns, shares, primary, nodes)
    other = weighted_sums(other_first, other_columns, other_shares, secondary, np.arange(len(nodes)))
    slope = np.empty((len(nodes), 2))
    for k in range(len(nodes)):
        for c in range(2):
            turned = 0.0 if core[nodes[k]] else 0.5 * (own[k, c] + other[k, c]) / areas[k]
            slope[k, c] = turned - frames[k, 0, c] / frames[k, 0, 2]
    turned_frames = frames_on(slope)
    normals, frictions, held = np.empty((len(nodes), 3)), np.empty((len(nodes), 3)), np.empty((len(nodes), 3))
    stuck_lift = stuck_pull = 0.0
    for k in range(len(nodes)):
        frame = turned_frames[k]
        for c in range(3):
            normals[k, c] = frame[0, c]
            frictions[k, c] = direction[k, 0] * frame[1, c] + direction[k, 1] * frame[2, c]
            held[k, c] = stuck[k, 0] * frame[1, c] + stuck[k, 1] * frame[2, c]
        stuck_lift += areas[k] * held[k, 2]
        stuck_pull += areas[k] * held[k, 0]
    count, held_rows, sticking = len(rows), np.empty(len(rows), np.int64), 0
    upward, lift, pull = np.empty(count), np.empty((2, count)), np.empty((2, count))
    for i in range(count):
        node = rows[i]
        upward[i] = normals[node, 2]
        lift[0, i], lift[1, i] = weights[i] * normals[node, 2], weights[i] * frictions[node, 2]
        pull[0, i], pull[1, i] = weights[i] * normals[node, 0], weights[i] * frictions[node, 0]
        if held[node, 0] != 0.0 or held[node, 1] != 0.0 or held[node, 2] != 0.0:
            held_rows[sticking] = i
            sticking += 1
    by_pressure, by_friction, by_stuck = _along_normals(
        influence, normals, frictions, held, rows, on, held_rows[:sticking]
    )
    return upward, on, by_pressure, by_friction, by_stuck, lift, pull, stuck_lift, stuck_pull, normals, frictions, held


@inlined
def _along_normals(
    influence: Array,
    normals: Array,
    frictions: Array,
    stuck: Array,
    rows: IntArray,
    on: IntArray,
    sticking: IntArray,
) -> tuple[Array, Array, Array]:
    """Normal displacement at the rows (u,) by unit pressures and by unit friction on some of them, (u, a), and (u,) by
    stuck tractions on others; all vectors are (k, 3).
    """
    count = len(rows)
    by_pressure, by_friction, by_stuck = np.empty((count, len(on))), np.empty((count, len(on))), np.zeros(count)
    for i in range(count):
        own, target = influence[i], normals[rows[i]]
        for a in range(len(on)):
            j, along = on[a], normals[rows[on[a]]]
            side = frictions[rows[j]]
            pressed = rubbed = 0.0
            for c in range(3):
                moved = target[0] * own[0, j, c] + target[1] * own[1, j, c] + target[2] * own[2, j, c]
                pressed += moved * along[c]
                rubbed += moved * side[c]
            by_pressure[i, a], by_friction[i, a] = pressed, rubbed
        for j in sticking:
            held = stuck[rows[j]]
            for c in range(3):
                moved = target[0] * own[0, j, c] + target[1] * own[1, j, c] + target[2] * own[2, j, c]
                by_stuck[i] += moved * held[c]
    return by_pressure, by_friction, by_stuck
