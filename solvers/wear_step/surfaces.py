"""The contact conditions of all positions of a cycle on surfaces of given depth: normals, gaps, elastic influence."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled
from solvers.contact import ContactProblem
from solvers.contact_layer import ContactLayer, open_share
from solvers.pairing import frames_on
from solvers.quadrature import gradient
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


@dataclass(frozen=True)
class Facing:
    """One position on surfaces of given depth, with its u unknowns; tractions in MPa, lengths in mm.

    upward: (u,) z component of the normals.  by_pressure, by_friction: (u, u) normal displacement by unit pressure and
    by unit friction in its direction, of unknowns in contact; zero of others.  by_stuck: (u,) that by the tractions of
    sticking nodes.
    lift, pull: (2, u) load along z and x by unit pressure and by unit friction at each unknown and its image, mm².
    stuck_lift, stuck_pull: what sticking nodes add, N.
    normals, frictions, stuck: (k, 3) unit normal, direction of friction and stuck traction of all nodes.
    """

    upward: Array
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

    influences: for each position (u, 3, u, 3), see `influence`.  half_cycle: the mirror whose image of the positions is
    the other half of the cycle, where they are half of one.  wearing: (N,) factor on the wear coefficients.
    layers: between the surfaces as the cycle was traced.  similar: what is known so far of the equations of its
    pressures.
    """

    positions: tuple[Position, ...]
    orbits: Orbits
    influences: tuple[Array, ...]
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
        found = []
        for k, position in enumerate(self.positions):
            pairing = position.pairing
            turned = averaging.averaged(primary, pairing.nodes) + pairing.opposite.averaged(secondary)
            normals = pairing.frames[:, 0, :]
            slope = 0.5 * turned / pairing.areas[:, None]
            slope[position.state.core[pairing.nodes]] = 0.0
            slope -= normals[:, :2] / normals[:, 2:]
            found.append(self._faced(k, slope, active))
        return tuple(found)

    def gaps(self, problem: ContactProblem, depths: Depths) -> Array:
        """Gap (N,) along z of the undeformed surfaces worn to these depths, with the holder at height 0, mm."""
        fresh = [
            (p.pairing.gap + p.lever * p.state.holder_tilt)[rows]
            for p, rows in zip(self.positions, self.orbits.rows, strict=True)
        ]
        opened = self.orbits.opening(depths[0] - self.depths[0], depths[1] - self.depths[1])
        return np.asarray(np.concatenate(fresh) + open_share(problem.layers) * opened)

    def _faced(self, k: int, slope: Array, active: BoolArray) -> Facing:
        position, orbits = self.positions[k], self.orbits
        rows = orbits.rows[k]
        own = slice(orbits.start[k], orbits.start[k + 1])
        weights = orbits.areas[own] * orbits.twice[own]
        normals, frictions, stuck = _directions(frames_on(slope), position.direction, position.stuck)
        by_pressure, by_friction, by_stuck = _along_normals(
            self.influences[k], normals[rows], frictions[rows], stuck[rows], np.flatnonzero(active[own])
        )
        areas = position.pairing.areas
        return Facing(
            upward=normals[rows, 2],
            by_pressure=by_pressure,
            by_friction=by_friction,
            by_stuck=by_stuck,
            lift=weights * np.stack([normals[rows, 2], frictions[rows, 2]]),
            pull=weights * np.stack([normals[rows, 0], frictions[rows, 0]]),
            stuck_lift=float(areas @ stuck[:, 2]),
            stuck_pull=float(areas @ stuck[:, 0]),
            normals=normals,
            frictions=frictions,
            stuck=stuck,
        )


@compiled
def _directions(frames: Array, direction: Array, stuck: Array) -> tuple[Array, Array, Array]:
    """Normals, directions of friction and stuck tractions (k, 3) in frames (k, 3, 3), of which (k, 2) are given."""
    normals, frictions, held = np.empty((len(frames), 3)), np.empty((len(frames), 3)), np.empty((len(frames), 3))
    for k in range(len(frames)):
        for c in range(3):
            normals[k, c] = frames[k, 0, c]
            frictions[k, c] = direction[k, 0] * frames[k, 1, c] + direction[k, 1] * frames[k, 2, c]
            held[k, c] = stuck[k, 0] * frames[k, 1, c] + stuck[k, 1] * frames[k, 2, c]
    return normals, frictions, held


@compiled
def _along_normals(
    influence: Array, normals: Array, frictions: Array, stuck: Array, active: IntArray
) -> tuple[Array, Array, Array]:
    """Normal displacement (u, u) by unit pressures and by unit friction, all (u, 3), on active ones (a,), and (u,) by
    stuck tractions (u, 3).
    """
    count = len(normals)
    by_pressure, by_friction, by_stuck = np.zeros((count, count)), np.zeros((count, count)), np.zeros(count)
    sticks = stuck.any()
    # Component by component of displacement and then of traction: the first loop runs through memory in one go.
    rows, lifted = influence.reshape(count, 3, 3 * count), np.empty(3 * count)
    for i in range(count):
        n0, n1, n2, of_node = normals[i, 0], normals[i, 1], normals[i, 2], rows[i]
        for c in range(3 * count):
            lifted[c] = n0 * of_node[0, c] + n1 * of_node[1, c] + n2 * of_node[2, c]
        for j in active:
            x, y, z = lifted[3 * j], lifted[3 * j + 1], lifted[3 * j + 2]
            by_pressure[i, j] = x * normals[j, 0] + y * normals[j, 1] + z * normals[j, 2]
            by_friction[i, j] = x * frictions[j, 0] + y * frictions[j, 1] + z * frictions[j, 2]
        if sticks:
            for j in range(count):
                by_stuck[i] += (
                    lifted[3 * j] * stuck[j, 0] + lifted[3 * j + 1] * stuck[j, 1] + lifted[3 * j + 2] * stuck[j, 2]
                )
    return by_pressure, by_friction, by_stuck
