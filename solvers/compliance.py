"""Compliance of two bodies as their paired contact nodes see it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from solvers.pairing import Pairing
from solvers.placement import PlacedBody

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def paired_compliance(
    pairing: Pairing, primary: PlacedBody, secondary: PlacedBody, old_forces: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Mean displacement of the upper against the lower body at k paired nodes, in world axes.

    old_forces: (n, 3) nodal forces on each body's patch, with the sign of the force on the upper body.
    Returns the compliance (3 k, 3 k) in mm per MPa and the displacement (k, 3) in mm that the old forces cause at the
    nodes as they are paired now.
    """
    k = len(pairing.nodes)
    inverse_area = 1.0 / pairing.areas
    total = np.zeros((k, 3, k, 3))
    displacement = np.zeros((k, 3))
    for body, operator, force in (
        (primary, pairing.primary, old_forces[0]),
        (secondary, pairing.secondary, old_forces[1]),
    ):
        used = np.unique(operator.indices)
        loaded = np.flatnonzero(force.any(axis=1))
        position = np.full(operator.shape[1], -1, dtype=np.int64)
        position[used] = np.arange(len(used))
        local = csr_matrix((operator.data, position[operator.indices], operator.indptr), shape=(k, len(used)))
        total += _transferred(local, _block(body, used, used))
        if len(loaded):
            moved = (_block(body, used, loaded) @ force[loaded].ravel()).reshape(-1, 3)
            displacement += inverse_area[:, None] * (local @ moved)
    total *= inverse_area[:, None, None, None]
    return total.reshape(3 * k, 3 * k), displacement


def _block(body: PlacedBody, rows: IntArray, columns: IntArray) -> Array:
    axes = np.arange(3)
    chosen = np.ix_((3 * rows[:, None] + axes).ravel(), (3 * columns[:, None] + axes).ravel())
    return np.asarray(body.compliance[chosen])


def _transferred(operator: csr_matrix, block: Array) -> Array:
    """Operator block operator^T for each pair of directions, shape (k, 3, k, 3)."""
    k, w = operator.shape
    # The block is symmetric, so transforming its rows, transposing and transforming again does both sides.
    half = (operator @ block.reshape(w, 9 * w)).reshape(k, 3, w, 3)
    turned = np.ascontiguousarray(half.transpose(2, 3, 0, 1)).reshape(w, 9 * k)
    return np.asarray(operator @ turned).reshape(k, 3, k, 3)
