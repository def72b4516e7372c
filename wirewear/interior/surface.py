"""Stress histories at a body's material points: nodes, corrected on the surface, and where the contact ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from wirewear.interior.state import InnerState

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


def material_points(states: Sequence[InnerState[Any, Any]], nodes: IntArray) -> MaterialPoints:
    """Stresses of a body over a cycle at nodes (k,) of its mesh, corrected on the surface, and at points of its edges.

    To the nodes come the points where the contact ends at any of the positions.
    """
    body, places = states[0].body, states[0].places_mm
    patch, on_patch = body.patch, states[0].patch_nodes
    loaded = [body.surface.under(state.applied[on_patch]) for state in states]
    number = np.full(len(places), -1)
    number[on_patch] = np.arange(patch.size)
    on_surface = np.flatnonzero(number[nodes] >= 0)
    grid = patch.grid()[number[nodes[on_surface]]]
    history = np.array([state.stress[nodes] for state in states])
    for k, one in enumerate(loaded):
        history[k, on_surface] += one.correction(grid)
    edges = np.vstack([one.edge() for one in loaded])
    at_edges = np.array(
        [_elements_stress(state, edges) + one.correction(edges) for state, one in zip(states, loaded, strict=True)]
    )
    nearest = cKDTree(grid).query(edges)[1]
    return MaterialPoints(
        np.vstack([places[nodes], np.column_stack([edges, patch.height(edges)])]),
        np.concatenate([history, at_edges], axis=1),
        np.concatenate([nodes, nodes[on_surface[nearest]]]),
    )


def _elements_stress(state: InnerState[Any, Any], plane_mm: Array) -> Array:
    """The projected stress at points (k, 2) of the patch, (k, 6)."""
    nodes, weights, _ = state.body.patch.locate(plane_mm)
    return np.asarray(np.einsum("kc,kcs->ks", weights, state.stress[state.patch_nodes[nodes]]))
