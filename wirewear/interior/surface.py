"""Stress histories at a wire's material points: nodes, corrected on the surface, and where the contact ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from solvers.surface_stress import SurfaceStress
from wirewear.interior.bodies import BodyState, WornBody

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class MaterialPoints:
    """Points (k, 3) of a body in mm, stresses over a cycle (s, k, 6) in MPa, the node that shows each (k,)."""

    points_mm: Array
    history: Array
    node: IntArray

    def largest_at_nodes(self, values: Array, size: int, by: Array | None = None) -> Array:
        """Of a value of each point (k, ...), that of the point where it, or `by`, is largest, at so many nodes."""
        result = np.zeros((size, *values.shape[1:]))
        order = np.argsort(values if by is None else by, kind="stable")
        result[self.node[order]] = values[order]
        return result


def surface_of(body: WornBody) -> SurfaceStress:
    """The contact surface of a wire, for corrections of the stresses at it."""
    geometry = body.wire.geometry
    finest = min(float(axis.half_lines()[1]) for axis in (geometry.axial, geometry.transverse))
    layers = geometry.layering.first * finest, geometry.layering.growth
    return SurfaceStress(body.wire.mesh, body.wire.patch, body.material, layers)


def material_points(states: Sequence[BodyState], nodes: IntArray, *, corrected: bool = True) -> MaterialPoints:
    """Stresses of a body over a cycle at nodes (k,) of its mesh, and at points of its surface.

    corrected: stresses at the surface are those of `solvers.surface_stress`, and to the nodes come the points where the
    contact ends at any of the positions.
    """
    body = states[0].body
    mesh, patch = body.wire.mesh, body.wire.patch
    history = np.array([state.stress[nodes] for state in states])
    if not corrected:
        return MaterialPoints(mesh.points[nodes], history, nodes)
    surface = surface_of(body)
    loaded = [surface.under(_patch_forces(state)) for state in states]
    places = np.full(len(mesh.points), -1)
    places[patch.nodes.ravel()] = np.arange(patch.size)
    on_surface = np.flatnonzero(places[nodes] >= 0)
    grid = patch.grid()[places[nodes[on_surface]]]
    for k, one in enumerate(loaded):
        history[k, on_surface] += one.correction(grid)
    edges = np.vstack([one.edge() for one in loaded])
    at_edges = np.array(
        [_elements_stress(state, edges) + one.correction(edges) for state, one in zip(states, loaded, strict=True)]
    )
    heights = patch.height(edges)
    nearest = cKDTree(grid).query(edges)[1]
    return MaterialPoints(
        np.vstack([mesh.points[nodes], np.column_stack([edges, heights])]),
        np.concatenate([history, at_edges], axis=1),
        np.concatenate([nodes, nodes[on_surface[nearest]]]),
    )


def _patch_forces(state: BodyState) -> Array:
    return state.applied_N[state.body.patch_nodes]


def _elements_stress(state: BodyState, plane_mm: Array) -> Array:
    """The projected stress at points (k, 2) of the patch, (k, 6)."""
    nodes, weights, _ = state.body.wire.patch.locate(plane_mm)
    return np.asarray(np.einsum("kc,kcs->ks", weights, state.stress[state.body.patch_nodes[nodes]]))
