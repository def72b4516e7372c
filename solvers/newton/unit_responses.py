"""Displacements of contact nodes along their normals and tangents by unit tractions, fetched as they are needed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers.newton.system import Linearisation

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


class _KnownResponse:
    """Displacement of some of k nodes along a direction by unit tractions on all, as far as it has been needed."""

    def __init__(self, count: int) -> None:
        self.place = np.full(count, -1)
        self.columns = 0
        self.response = np.empty((3, count, 0))

    def append(self, nodes: IntArray, response: Array) -> None:
        """Add the response (3, k, m) of further nodes (m,)."""
        self.place[nodes] = self.columns + np.arange(len(nodes))
        self.columns += len(nodes)
        self.response = np.concatenate([self.response, response], axis=2) if self.response.size else response

    def under(self, nodes: IntArray, loaded: IntArray, vectors: Array) -> Array:
        """Displacement of `nodes` by tractions on each loaded node along its vector (l, 3), shape (nodes, l)."""
        total: Array = vectors[:, :1] * self.response[0, loaded]
        for c in (1, 2):
            total += vectors[:, c : c + 1] * self.response[c, loaded]
        chosen = self.place[nodes]
        if len(chosen) != self.columns or np.any(np.diff(chosen) != 1):
            total = total[:, chosen]
        return total.T


class UnitResponses:
    """The responses of one pairing, shared by all iterations on it."""

    def __init__(self, system: Linearisation) -> None:
        """Know nothing yet of the pairing's k nodes."""
        self._system = system
        self._known: dict[int, _KnownResponse] = {}

    def along(self, axis: int, nodes: IntArray, loaded: IntArray, vectors: Array) -> Array:
        """Displacement of `nodes` along their normal (axis 0) or a tangent by unit tractions along vectors (l, 3).

        The (nodes, l) result is in Fortran order.
        """
        frames = self._system.pairing.frames
        if axis not in self._known:
            self._known[axis] = _KnownResponse(len(frames))
        known = self._known[axis]
        missing = nodes[known.place[nodes] < 0]
        if len(missing):
            known.append(missing, self._system.compliance.by_unit_tractions(missing, frames[missing, axis, :]))
        return known.under(nodes, loaded, vectors)
