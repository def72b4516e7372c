"""Compliance of two bodies as their paired contact nodes see it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from solvers.pairing import Pairing
from solvers.placement import PlacedBody

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Three doubles moved as one item: blocks of a large matrix are gathered faster this way.
_TRIPLE = np.dtype("V24")


def paired_compliance(
    pairing: Pairing, primary: PlacedBody, secondary: PlacedBody, old_forces: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Mean displacement of the upper against the lower body at k paired nodes, in world axes.

    old_forces: (n, 3) nodal forces on each body's patch, with the sign of the force on the upper body.
    Returns the compliance (3 k, 3 k) in mm per MPa and the displacement (k, 3) in mm that the old forces cause at the
    nodes as they are paired now.
    """
    inverse_area = 1.0 / pairing.areas
    first, moved_first = _transferred(primary, pairing.primary, old_forces[0])
    second, moved_second = _transferred(secondary, pairing.secondary, old_forces[1])
    first += second
    first *= inverse_area[:, None, None, None]
    k = len(pairing.nodes)
    return first.reshape(3 * k, 3 * k), inverse_area[:, None] * (moved_first + moved_second)


def _transferred(body: PlacedBody, operator: csr_matrix, old_force: Array) -> tuple[Array, Array]:
    """Operator C operator^T per pair of directions, (k, 3, k, 3), and operator C old_force, (k, 3)."""
    k = operator.shape[0]
    used = np.union1d(operator.indices, np.flatnonzero(old_force.any(axis=1))).astype(np.int64)
    w = len(used)
    block = _block(body, used)
    position = np.full(operator.shape[1], -1, dtype=np.int64)
    position[used] = np.arange(w)
    columns = position[operator.indices]
    if operator.nnz == k:
        # Lumped: one weight per node. Only the loaded nodes' rows and columns are picked and scaled.
        weights = operator.data
        blocks = block.reshape(w, 3, w, 3)
        if k < w:
            blocks = blocks[columns][:, :, columns]
        paired = blocks * weights[None, None, :, None]
        paired *= weights[:, None, None, None]
        return paired, weights[:, None] * (block @ old_force[used].ravel()).reshape(-1, 3)[columns]
    local = csr_matrix((operator.data, columns, operator.indptr), shape=(k, w))
    moved = local @ (block @ old_force[used].ravel()).reshape(-1, 3)
    # The block is symmetric, so transforming its rows, transposing and transforming again does both sides.
    half = (local @ block.reshape(w, 9 * w)).reshape(k, 3, w, 3)
    turned = np.ascontiguousarray(half.transpose(2, 3, 0, 1)).reshape(w, 9 * k)
    return np.asarray(local @ turned).reshape(k, 3, k, 3), moved


def _block(body: PlacedBody, nodes: IntArray) -> Array:
    """The body's compliance between some patch nodes, (3 w, 3 w)."""
    unknowns = (3 * nodes[:, None] + np.arange(3)).ravel()
    triples = body.compliance.reshape(-1, body.patch.size, 3).view(_TRIPLE)[..., 0]
    gathered: Array = triples[np.ix_(unknowns, nodes)].view(np.float64)
    return gathered.reshape(len(unknowns), len(unknowns))
