"""The contact conditions of all positions of a cycle on surfaces of given depth: normals, gaps, elastic influence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers.contact import ContactProblem
from solvers.contact_layer import open_share
from solvers.wear_step.orbits import Orbits
from solvers.wear_step.positions import Position

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Worn depths (mm) of the primary and the secondary body, each of the shape of its patch.
Depths = tuple[Array, Array]


@dataclass(frozen=True)
class Facing:
    """One position on surfaces of given depth, with its u unknowns; tractions in MPa, lengths in mm.

    upward: (u,) z component of the normals.  by_pressure, by_friction: (u, u) normal displacement by unit pressure and
    by unit friction in its direction.  by_stuck: (u,) that by the tractions of sticking nodes.
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

    influences: for each position (u, 3, u, 3), see `influence`.  half: whether the positions are those of half a
    cycle whose mirror image is the other half.
    """

    positions: tuple[Position, ...]
    orbits: Orbits
    influences: tuple[Array, ...]
    depths: Depths
    half: bool

    def facing(self, problem: ContactProblem, depths: Depths) -> tuple[Facing, ...]:
        """All positions on surfaces worn to other depths, where only the normals turn."""
        share = open_share(problem.layers)
        change = share * (depths[0] - self.depths[0]), share * (depths[1] - self.depths[1])
        before = share * self.depths[0]
        gradient = problem.secondary.patch.gradient(change[1])
        found = []
        for k, position in enumerate(self.positions):
            pairing = position.pairing
            own = problem.surface.mean_slope(pairing.nodes, before + change[0])
            own = own - problem.surface.mean_slope(pairing.nodes, before)
            local = pairing.opposite.averaged(gradient) / pairing.areas[:, None]
            other = -problem.secondary.facing * local @ problem.secondary.world_to_patch
            normals = pairing.frames[:, 0, :]
            slope = -normals[:, :2] / normals[:, 2:] + 0.5 * (own + other)
            found.append(self._faced(k, slope))
        return tuple(found)

    def gaps(self, problem: ContactProblem, depths: Depths) -> Array:
        """Gap (N,) along z of the undeformed surfaces worn to these depths, with the holder at height 0, mm."""
        fresh = [
            (p.pairing.gap + p.lever * p.state.holder_tilt)[rows]
            for p, rows in zip(self.positions, self.orbits.rows, strict=True)
        ]
        opened = self.orbits.opening(depths[0] - self.depths[0], depths[1] - self.depths[1])
        return np.asarray(np.concatenate(fresh) + open_share(problem.layers) * opened)

    def _faced(self, k: int, slope: Array) -> Facing:
        position, orbits = self.positions[k], self.orbits
        rows = orbits.rows[k]
        own = slice(orbits.start[k], orbits.start[k + 1])
        weights = orbits.areas[own] * orbits.twice[own]
        normals, tangents = frames(slope)
        frictions = np.einsum("ik,ikj->ij", position.direction, tangents)
        stuck = np.einsum("ik,ikj->ij", position.stuck, tangents)
        lifted = np.einsum("ia,ialb->ilb", normals[rows], self.influences[k])
        areas = position.pairing.areas
        return Facing(
            upward=normals[rows, 2],
            by_pressure=np.einsum("ilb,lb->il", lifted, normals[rows]),
            by_friction=np.einsum("ilb,lb->il", lifted, frictions[rows]),
            by_stuck=np.einsum("ilb,lb->i", lifted, stuck[rows]),
            lift=weights * np.stack([normals[rows, 2], frictions[rows, 2]]),
            pull=weights * np.stack([normals[rows, 0], frictions[rows, 0]]),
            stuck_lift=float(areas @ stuck[:, 2]),
            stuck_pull=float(areas @ stuck[:, 0]),
            normals=normals,
            frictions=frictions,
            stuck=stuck,
        )


def frames(slope: Array) -> tuple[Array, Array]:
    """Unit normals (k, 3) of surfaces of slope (k, 2), and two tangents (k, 2, 3), the first along the motion."""
    normal = np.column_stack([-slope, np.ones(len(slope))])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first = np.zeros_like(normal)
    first[:, 0] = 1.0
    first -= normal[:, :1] * normal
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return normal, np.stack([first, np.cross(normal, first)], axis=1)


def slip_lengths(positions: Sequence[Position], orbits: Orbits, stretch: tuple[Array, Array]) -> Array:
    """Slip (N,) in mm that each unknown's pressure stands for: half of that before and half of that after it.

    stretch: (positions,) factors on the slip before and after each position.
    """
    slips = [
        0.5 * (stretch[0][k] * position.before + stretch[1][k] * position.after)[rows]
        for k, (position, rows) in enumerate(zip(positions, orbits.rows, strict=True))
    ]
    return np.concatenate(slips)
