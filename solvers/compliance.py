"""Products with the dense compliances of two bodies, restricted to the part of their patches that matters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_matrix, csr_matrix

from solvers.placement import PlacedBody

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Grid lines that a window keeps around the nodes it is made for, so that it need not follow every increment.
_MARGIN = 2


class ComplianceWindow:
    """A rectangular window of a body's patch and its block of the compliance, kept until the contact leaves it."""

    def __init__(self, body: PlacedBody) -> None:
        """Start with an empty window on the patch of `body`."""
        self._body = body
        self._box = (0, 0, 0, 0)
        self._block = np.empty((0, 0))
        self.nodes: IntArray = np.empty(0, dtype=np.int64)
        self.position: IntArray = np.full(body.patch.size, -1, dtype=np.int64)

    def cover(self, nodes: IntArray) -> Array:
        """Compliance block (3 w, 3 w) of a window that contains all these nodes; `self.nodes` (w,) are its nodes."""
        n_a, n_t = self._body.patch.shape
        i, j = np.divmod(nodes, n_t)
        i0, i1, j0, j1 = self._box
        if i.min() < i0 or i.max() >= i1 or j.min() < j0 or j.max() >= j1 or self._far_too_large(len(nodes)):
            i0, i1 = max(int(i.min()) - _MARGIN, 0), min(int(i.max()) + _MARGIN + 1, n_a)
            j0, j1 = max(int(j.min()) - _MARGIN, 0), min(int(j.max()) + _MARGIN + 1, n_t)
            self._box = (i0, i1, j0, j1)
            self.nodes = (np.arange(i0, i1)[:, None] * n_t + np.arange(j0, j1)).ravel()
            self.position = np.full(self._body.patch.size, -1, dtype=np.int64)
            self.position[self.nodes] = np.arange(len(self.nodes))
            full = self._body.compliance.reshape(n_a, n_t, 3, n_a, n_t, 3)
            size = 3 * len(self.nodes)
            self._block = full[i0:i1, j0:j1, :, i0:i1, j0:j1, :].reshape(size, size)
        return self._block

    def _far_too_large(self, count: int) -> bool:
        return len(self.nodes) > 6 * count + 200


def directed(operator: csr_matrix, vectors: Array) -> bsr_matrix:
    """Rows of a transfer operator (k, w) projected on one direction each, vectors (k, 3).

    Returns (k, 3 w): row j maps displacements of w nodes to the weighted displacement of node j along its vector.
    """
    rows = np.repeat(np.arange(operator.shape[0]), np.diff(operator.indptr))
    data = (operator.data[:, None] * vectors[rows])[:, None, :]
    shape = (operator.shape[0], 3 * operator.shape[1])
    return bsr_matrix((data, operator.indices, operator.indptr), shape=shape, blocksize=(1, 3))
