"""Compliance of two bodies as their paired contact nodes see it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from solvers.pairing import Pairing
from solvers.placement import PlacedBody

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Three doubles moved as one item: blocks of a large matrix are gathered faster this way.
_TRIPLE = np.dtype("V24")


@dataclass(frozen=True)
class _Share:
    """One body's part: its compliance between the w patch nodes that matter, (3 w, 3 w), and the transfer (k, w)."""

    block: Array
    transfer: csr_matrix


@dataclass(frozen=True)
class PairedCompliance:
    """Mean displacement of the upper against the lower body at k paired nodes under tractions there; world axes.

    In gross slip only its normal rows are needed, so the whole (3 k, 3 k) matrix is never formed.
    areas: (k,), mm².  layer: compliance of an elastic layer between the bodies, the same in all directions, mm per MPa.
    """

    areas: Array
    shares: tuple[_Share, _Share]
    layer: float = 0.0

    def displacement(self, traction: Array) -> Array:
        """Displacement in mm under tractions (k, 3) in MPa, shape (k, 3)."""
        first, second = (_moved(share, share.transfer.T @ traction) for share in self.shares)
        return np.asarray((first + second) / self.areas[:, None] + self.layer * traction)

    def rows(self, nodes: IntArray, directions: Array) -> Array:
        """Displacement of m nodes, each along its direction (m, 3), by unit tractions on all nodes, (m, k, 3)."""
        first, second = (self._rows_of(share, nodes, directions) for share in self.shares)
        first += second
        first[np.arange(len(nodes)), nodes] += self.layer * directions
        return first

    def _rows_of(self, share: _Share, nodes: IntArray, directions: Array) -> Array:
        m, k, w = len(nodes), len(self.areas), share.transfer.shape[1]
        chosen = share.transfer[nodes]
        repeats = np.diff(chosen.indptr)
        scaled = directions / self.areas[nodes, None]
        directed = csr_matrix(
            (
                (chosen.data[:, None] * np.repeat(scaled, repeats, axis=0)).ravel(),
                (3 * chosen.indices[:, None] + np.arange(3)).ravel(),
                3 * chosen.indptr,
            ),
            shape=(m, 3 * w),
        )
        moved = (directed @ share.block).reshape(m, w, 3)
        result = np.empty((m, k, 3))
        for c in range(3):
            result[:, :, c] = (share.transfer @ np.ascontiguousarray(moved[:, :, c].T)).T
        return result


def paired_compliance(
    pairing: Pairing, primary: PlacedBody, secondary: PlacedBody, old_forces: tuple[Array, Array], layer: float = 0.0
) -> tuple[PairedCompliance, Array]:
    """Compliance of both bodies at k paired nodes, and the displacement (k, 3) in mm that old forces cause there.

    old_forces: (n, 3) nodal forces on each body's patch, with the sign of the force on the upper body; they do not
    act through the layer.
    """
    first, moved_first = _share(primary, pairing.primary, old_forces[0])
    second, moved_second = _share(secondary, pairing.secondary, old_forces[1])
    return PairedCompliance(pairing.areas, (first, second), layer), (moved_first + moved_second) / pairing.areas[
        :, None
    ]


def _share(body: PlacedBody, operator: csr_matrix, old_force: Array) -> tuple[_Share, Array]:
    """A body's share between the nodes that its operator (k, n) reaches, and its area-weighted old displacement."""
    used = np.union1d(operator.indices, np.flatnonzero(old_force.any(axis=1))).astype(np.int64)
    position = np.full(operator.shape[1], -1, dtype=np.int64)
    position[used] = np.arange(len(used))
    transfer = csr_matrix(
        (operator.data, position[operator.indices], operator.indptr), shape=(operator.shape[0], len(used))
    )
    share = _Share(_block(body, used), transfer)
    return share, _moved(share, old_force[used])


def _moved(share: _Share, force: Array) -> Array:
    """Area-weighted displacement (k, 3) under nodal forces (w, 3)."""
    return np.asarray(share.transfer @ (share.block @ force.ravel()).reshape(-1, 3))


def _block(body: PlacedBody, nodes: IntArray) -> Array:
    """The body's compliance between some patch nodes, (3 w, 3 w)."""
    unknowns = (3 * nodes[:, None] + np.arange(3)).ravel()
    triples = body.compliance.reshape(-1, body.patch.size, 3).view(_TRIPLE)[..., 0]
    gathered: Array = triples[np.ix_(unknowns, nodes)].view(np.float64)
    return gathered.reshape(len(unknowns), len(unknowns))
