"""Facets of a wire's mesh as they are drawn: round where their corners lie on the wire, with their edges as curves.

A facet is a Coons patch: its points are bilinear between the corners, moved as its edges are (S. A. Coons, MIT Project
MAC report TR-41, 1967).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
IntArray = NDArray[np.int_]

#: Parts into which each edge is divided.
PARTS = 6

#: A corner this close to the wire's surface, as a share of its radius, lies on it.
ON_SURFACE = 1e-6


def round_facets(points_mm: Array, facets: IntArray, radius_mm: float) -> tuple[Array, IntArray, IntArray]:
    """Finer points (m, 3), quads (k·PARTS², 4) of them, and the facets' edges (4k, PARTS + 1) as rows of points.

    The wire's axis is x, its crown the origin, its material below; facets (k, 4) name their corners in order.
    """
    corners = points_mm[facets]
    u, v = np.meshgrid(*2 * [np.linspace(0.0, 1.0, PARTS + 1)], indexing="ij")
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=-1)
    finer = np.einsum("uvc,kcd->kuvd", weights, corners)
    along = np.linspace(0.0, 1.0, PARTS + 1)
    # Edge from the first to the second corner at v = 0, and so on around the facet; each with the blend to its middle.
    for start, end, blend, varies in ((0, 1, 1 - v, u), (3, 2, v, u), (0, 3, 1 - u, v), (1, 2, u, v)):
        moved = _bulge(corners[:, start], corners[:, end], along, radius_mm)
        place = np.round(varies * PARTS).astype(int)
        finer += blend[None, ..., None] * moved[:, place]
    n = (PARTS + 1) ** 2
    index = np.arange(n).reshape(PARTS + 1, PARTS + 1)
    quad = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    rim = np.stack([index[:, 0], index[:, -1], index[0], index[-1]])
    first = n * np.arange(len(facets))
    return (
        finer.reshape(-1, 3),
        (first[:, None, None] + quad).reshape(-1, 4),
        (first[:, None, None] + rim).reshape(-1, PARTS + 1),
    )


def _bulge(start: Array, end: Array, along: Array, radius_mm: float) -> Array:
    """How far the points of edges (k, n, 3) are from the straight lines between their ends (k, 3): onto the wire."""
    straight = start[:, None] + along[None, :, None] * (end - start)[:, None]
    centre = np.array([0.0, 0.0, -radius_mm])
    across = (straight - centre) * np.array([0.0, 1.0, 1.0])
    distance = np.linalg.norm(across, axis=-1, keepdims=True)
    on_surface = (np.abs(distance[:, [0, -1]] - radius_mm) < ON_SURFACE * radius_mm).all(axis=1)[:, None]
    outward = across * (radius_mm / np.maximum(distance, ON_SURFACE * radius_mm) - 1.0)
    return np.asarray(np.where(on_surface, outward, 0.0))
