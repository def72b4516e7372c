"""Compliance of two bodies as their paired contact nodes see it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas
from scipy.sparse import csr_matrix

from solvers.pairing import Pairing
from solvers.placement import PlacedBody

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Three doubles moved as one item: blocks of a large matrix are gathered faster this way.
_TRIPLE = np.dtype("V24")


@dataclass(frozen=True)
class _Share:
    """One body's part: its symmetric compliance between the w patch nodes that matter, (3 w, 3 w), and the transfer
    (k, w).

    before: transfer (l, w) of the nodes that were loaded before the increment, as they were paired then.
    old_displacement: (w, 3) under the forces before the increment.
    weights, columns: (k,), the transfer's only entry in each row, where it has no others.
    """

    block: Array
    transfer: csr_matrix
    before: csr_matrix
    old_displacement: Array
    weights: Array | None
    columns: IntArray

    def displaced(self, force: Array) -> Array:
        """Displacement (w, 3) of the patch nodes under forces (w, 3) on them."""
        return _displaced(self.block, force)

    def under(self, traction: Array) -> Array:
        """Area-weighted displacement (k, 3) under tractions (k, 3)."""
        displacement = self.displaced(self.transfer.T @ traction)
        if self.weights is not None:
            return np.asarray(self.weights[:, None] * displacement[self.columns])
        return np.asarray(self.transfer @ displacement)

    def moved(self, traction: Array) -> tuple[Array, Array]:
        """Area-weighted change of displacement from before the increment to under tractions (k, 3): of the nodes'
        material points (k, 3), and of those that the nodes loaded before faced then (l, 3).
        """
        change = self.displaced(self.transfer.T @ traction) - self.old_displacement
        return np.asarray(self.transfer @ change), np.asarray(self.before @ change)

    def by_unit_tractions(self, nodes: IntArray, directions: Array) -> Array:
        """Area-weighted displacement of m nodes, each along its direction (m, 3), by unit tractions on all nodes:
        (3, k, m), first the traction's world axis.
        """
        m, w = len(nodes), self.transfer.shape[1]
        if self.weights is not None:
            chosen = self.block.reshape(w, 3, 3 * w)[self.columns[nodes]]
            scaled = self.weights[nodes, None] * directions
            moved = np.matmul(scaled[:, None, :], chosen).reshape(m, w, 3)
            return np.asarray(moved.transpose(2, 1, 0)[:, self.columns] * self.weights[:, None])
        part = self.transfer[nodes]
        repeats = np.diff(part.indptr)
        directed = csr_matrix(
            (
                (part.data[:, None] * np.repeat(directions, repeats, axis=0)).ravel(),
                (3 * part.indices[:, None] + np.arange(3)).ravel(),
                3 * part.indptr,
            ),
            shape=(m, 3 * w),
        )
        moved = np.ascontiguousarray((directed @ self.block).reshape(m, w, 3).transpose(2, 1, 0))
        return np.stack([self.transfer @ moved[c] for c in range(3)])


@dataclass(frozen=True)
class PairedCompliance:
    """Mean displacement of the upper against the lower body at k paired nodes under tractions there; world axes.

    In gross slip only its normal rows are needed, so the whole (3 k, 3 k) matrix is never formed.
    areas: (k,), mm².  areas_before: (l,) of the nodes loaded before the increment.  layer: compliance of an elastic
    layer between the bodies, the same in all directions, mm per MPa.
    """

    areas: Array
    areas_before: Array
    shares: tuple[_Share, _Share]
    layer: float = 0.0

    def displacement(self, traction: Array) -> Array:
        """Displacement in mm under tractions (k, 3) in MPa, shape (k, 3)."""
        first, second = (share.under(traction) for share in self.shares)
        return np.asarray((first + second) / self.areas[:, None] + self.layer * traction)

    def moved(self, traction: Array) -> tuple[Array, Array]:
        """Motion of the upper against the lower body's material points over the increment by tractions (k, 3), the
        layer apart: of those that face each other at its end at the k nodes, and at its start at the l nodes then
        loaded, (k, 3) and (l, 3) in mm.
        """
        (first, first_before), (second, second_before) = (share.moved(traction) for share in self.shares)
        return (first + second) / self.areas[:, None], (first_before + second_before) / self.areas_before[:, None]

    def by_unit_tractions(self, nodes: IntArray, directions: Array) -> Array:
        """Displacement of m nodes, each along its direction (m, 3), by unit tractions on all nodes: (3, k, m), first
        the traction's world axis.
        """
        scaled = directions / self.areas[nodes, None]
        first, second = (share.by_unit_tractions(nodes, scaled) for share in self.shares)
        first += second
        if self.layer:
            first[:, nodes, np.arange(len(nodes))] += self.layer * directions.T
        return first


def paired_compliance(
    pairing: Pairing,
    before: Pairing,
    old_secondary: csr_matrix,
    primary: PlacedBody,
    secondary: PlacedBody,
    old_forces: tuple[Array, Array],
    layer: float = 0.0,
) -> tuple[PairedCompliance, Array]:
    """Compliance of both bodies at k paired nodes, and the displacement (k, 3) in mm that old forces cause there.

    before: pairing of the l nodes that were loaded before the increment, as the bodies stood then.
    old_secondary: (k, n) transfer that averages the secondary's displacement under the old forces.
    old_forces: (n, 3) nodal forces on each body's patch, with the sign of the force on the upper body; they do not
    act through the layer.
    """
    first, moved_first = _share(primary, pairing.primary, before.primary, pairing.primary, old_forces[0])
    second, moved_second = _share(secondary, pairing.secondary, before.secondary, old_secondary, old_forces[1])
    moved = (moved_first + moved_second) / pairing.areas[:, None]
    return PairedCompliance(pairing.areas, before.areas, (first, second), layer), moved


def _share(
    body: PlacedBody, operator: csr_matrix, before: csr_matrix, old_operator: csr_matrix, old_force: Array
) -> tuple[_Share, Array]:
    """A body's share between the nodes that its operators reach, and its area-weighted old displacement (k, 3)."""
    reached = np.asarray(old_force.any(axis=1))
    for transfer in (operator, before, old_operator):
        reached[transfer.indices] = True
    used = np.flatnonzero(reached)
    position = np.cumsum(reached) - 1

    def among_used(transfer: csr_matrix) -> csr_matrix:
        shape = (transfer.shape[0], len(used))
        return csr_matrix((transfer.data, position[transfer.indices], transfer.indptr), shape=shape)

    single = len(operator.indices) == operator.shape[0] and bool((np.diff(operator.indptr) == 1).all())
    block = _block(body, used)
    old_displacement = _displaced(block, old_force[used])
    share = _Share(
        block,
        among_used(operator),
        among_used(before),
        old_displacement,
        operator.data if single else None,
        position[operator.indices],
    )
    return share, np.asarray(among_used(old_operator) @ old_displacement)


def _displaced(block: Array, force: Array) -> Array:
    # Reads one triangle only, half the memory; the transpose is how LAPACK sees the block.
    return np.asarray(blas.dsymv(1.0, block.T, force.ravel(), lower=1).reshape(-1, 3))


def _block(body: PlacedBody, nodes: IntArray) -> Array:
    """The body's compliance between some patch nodes, (3 w, 3 w)."""
    unknowns = (3 * nodes[:, None] + np.arange(3)).ravel()
    gathered: Array = _triples(body)[np.ix_(unknowns, nodes)].view(np.float64)
    return gathered.reshape(len(unknowns), len(unknowns))


def _triples(body: PlacedBody) -> NDArray[np.void]:
    """The compliance as (3 n, n) items of three doubles."""
    return np.asarray(body.compliance.reshape(-1, body.patch.size, 3).view(_TRIPLE)[..., 0])
