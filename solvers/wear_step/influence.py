"""What tractions on paired nodes do to both bodies: displacements at some of them, with all three components."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers.pairing import Pairing
from solvers.placement import PlacedBody

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Three doubles moved as one item: blocks of a large matrix are gathered faster this way.
_TRIPLE = np.dtype("V24")


def displaced(body: PlacedBody, nodes: IntArray, force: Array) -> Array:
    """Displacement (k, 3) of patch nodes (k,) in mm under forces (n, 3) in N on all of them."""
    loaded = np.flatnonzero(force.any(axis=1))
    return np.asarray((_between(body, nodes, loaded) @ force[loaded].ravel()).reshape(-1, 3))


def influence(primary: PlacedBody, secondary: PlacedBody, pairing: Pairing, rows: IntArray) -> Array:
    """Relative displacement of the k paired nodes' `rows` (r,) by unit tractions on all, (r, 3, k, 3), mm per MPa.

    The second axis is the displacement's, the last the traction's component, in world axes.
    """
    nodes, areas = pairing.nodes, pairing.areas
    r, k = len(rows), len(nodes)
    own = _between(primary, nodes[rows], nodes).reshape(r, 3, k, 3) * areas[:, None]
    faced = np.unique(pairing.secondary.indices)
    transfer = pairing.secondary[:, faced].toarray()
    f = len(faced)
    moved = transfer[rows] @ _between(secondary, faced, faced).reshape(f, 9 * f)
    moved = np.ascontiguousarray(moved.reshape(3 * r, f, 3).transpose(0, 2, 1)).reshape(9 * r, f) @ transfer.T
    own += moved.reshape(r, 3, 3, k).transpose(0, 1, 3, 2) / areas[rows, None, None, None]
    return np.asarray(own)


def _between(body: PlacedBody, nodes: IntArray, loaded: IntArray) -> Array:
    """The body's compliance from loaded patch nodes (l,) to nodes (k,), (3 k, 3 l), mm per N."""
    triples = body.compliance.reshape(-1, body.patch.size, 3).view(_TRIPLE)[..., 0]
    unknowns = (3 * nodes[:, None] + np.arange(3)).ravel()
    gathered: Array = triples[np.ix_(unknowns, loaded)].view(np.float64)
    return gathered.reshape(len(unknowns), 3 * len(loaded))
