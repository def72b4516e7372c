"""The unknowns of a cycle, one for each set of nodes that its symmetries make alike, and how they share the wear."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix, vstack

from geometry.arrays import Array, BoolArray, IntArray
from solvers.contact import ContactProblem
from solvers.kept_code import compiled
from solvers.wear_step.positions import Position
from solvers.wear_step.symmetry import Mirror, Symmetry

_ON_THE_PLANE = 1e-10  # Nodes nearer than this to the plane of symmetry lie on it, mm.


@dataclass(frozen=True)
class Orbits:
    """N unknown pressures: of each position's nodes on one side of the plane across which it is mirrored.

    rows: for each position, which of its nodes are unknowns.  images: for each position, which of its nodes are the
    mirror images of those, the node itself where it lies on the plane.  twice: (N,) 2 where there is an image, else 1.
    start: (positions + 1,) where each position's unknowns begin.  areas: (N,), mm².
    primary, secondary: (N, n) sparse, by how much one traction loads nodes of either patch, areas for the secondary, 1
    for the primary.  all_primary, all_secondary: the same of all nodes, in both halves of the cycle, that are alike.
    """

    rows: tuple[IntArray, ...]
    images: tuple[IntArray, ...]
    twice: Array
    start: IntArray
    areas: Array
    primary: csr_matrix
    secondary: csr_matrix
    all_primary: csr_matrix
    all_secondary: csr_matrix
    secondary_areas: Array
    _openings: dict[tuple[float, float], csr_matrix] = field(default_factory=dict, init=False, repr=False)

    @property
    def count(self) -> int:
        """Number N of unknown pressures."""
        return int(self.start[-1])

    @cached_property
    def position(self) -> IntArray:
        """The position (N,) that each unknown belongs to."""
        return np.repeat(np.arange(len(self.rows)), np.diff(self.start))

    @cached_property
    def _alike(self) -> tuple[csc_matrix, csc_matrix]:
        """Transposes (n, N) of `all_primary` and `all_secondary`."""
        return self.all_primary.T, self.all_secondary.T

    @cached_property
    def _opened_by_own(self) -> csr_matrix:
        """(N, N) depth of the primary at each unknown by unit work per area at all places alike to another."""
        return (self.primary @ self._alike[0]).tocsr()

    @cached_property
    def _opened_by_other(self) -> csr_matrix:
        """(N, N) mean depth of the secondary facing each unknown by unit work per area alike to another."""
        mean = _scaled_rows(self.secondary, 1.0 / self.areas)
        return (_scaled_columns(mean, 1.0 / self.secondary_areas) @ self._alike[1]).tocsr()

    def opening_by(self, rates: tuple[float, float]) -> csr_matrix:
        """(N, N) gap along z that opens at each unknown by unit work per area at all places alike to another, mm.

        rates: wear coefficients of the primary and the secondary.
        """
        if rates not in self._openings:
            self._openings[rates] = (rates[0] * self._opened_by_own + rates[1] * self._opened_by_other).tocsr()
        return self._openings[rates]

    def deposited(self, work: Array) -> tuple[Array, Array]:
        """Work per area (n,) on the nodes of the primary and the secondary by work per area at the unknowns (N,)."""
        primary, secondary = self._alike
        return primary @ work, (secondary @ work) / self.secondary_areas

    def opening(self, primary_depth: Array, secondary_depth: Array) -> Array:
        """By how much depths of both bodies, each of its patch's shape, open the gap along z at the unknowns, (N,)."""
        return np.asarray(
            self.primary @ primary_depth.ravel() + (self.secondary @ secondary_depth.ravel()) / self.areas
        )


def orbits_of(problem: ContactProblem, positions: Sequence[Position], symmetry: Symmetry) -> Orbits:
    """The unknowns of the positions of a cycle, of its first half where it has a `half_cycle` symmetry."""
    across, later = symmetry.across, symmetry.half_cycle
    side = problem.primary.node_positions[:, 1]
    n = problem.primary.patch.size
    rows, images, twice = [], [], []
    own, other, worn = [], [], []
    kept = ~_faces_core(problem, positions, later)
    for position in positions:
        nodes = position.nodes
        chosen = np.flatnonzero(side[nodes] > -_ON_THE_PLANE) if across else np.arange(len(nodes))
        place = np.zeros(n, dtype=np.int64)
        place[nodes] = np.arange(len(nodes))
        rows.append(chosen)
        images.append(place[across.primary[nodes[chosen]]] if across else chosen)
        twice.append(np.where(side[nodes[chosen]] > _ON_THE_PLANE, 2.0, 1.0) if across else np.ones(len(chosen)))
        count = len(chosen)
        own.append(csr_matrix((np.ones(count), nodes[chosen], np.arange(count + 1)), shape=(count, n)))
        faced = position.pairing.depths.sparse[chosen]
        other.append(faced)
        worn.append(_among(faced, kept))
    factor = np.concatenate(twice)
    primary, secondary = vstack(own).tocsr(), vstack(other).tocsr()
    all_primary, all_secondary = primary, vstack(worn).tocsr()
    for mirror, image in ((across, factor - 1.0), (later, np.ones(len(factor)))):
        if mirror:
            all_primary = _with_images(all_primary, mirror.primary, image)
            all_secondary = _with_images(all_secondary, mirror.secondary, image)
    return Orbits(
        rows=tuple(rows),
        images=tuple(images),
        twice=factor,
        start=np.concatenate([[0], np.cumsum([len(chosen) for chosen in rows])]),
        areas=np.concatenate([p.pairing.areas[chosen] for p, chosen in zip(positions, rows, strict=True)]),
        primary=primary,
        secondary=secondary,
        all_primary=all_primary,
        all_secondary=all_secondary,
        secondary_areas=problem.secondary.patch.node_areas(),
    )


def _faces_core(problem: ContactProblem, positions: Sequence[Position], later: Mirror | None) -> BoolArray:
    """Which of the secondary's nodes (n,) are those that nodes face which stick throughout the cycle.

    They stick as well: work at the edge of the sticking core, spread over a node's support, must not wear into it.
    """
    core, others = positions[-1].state.core, problem.secondary.patch.size
    if later:
        core = core & core[later.primary]
    if not core.any():
        return np.zeros(others, dtype=bool)
    faced_by_core = np.zeros(others)
    for position in positions:
        faced_by_core += position.pairing.depths.spread(core[position.nodes].astype(float))
    return np.asarray(faced_by_core > 0.0)


def _among(matrix: csr_matrix, kept: BoolArray) -> csr_matrix:
    """The matrix with its weights on some columns only, each row with its sum; rows that have none there stay."""
    if kept.all():
        return matrix
    masked = csr_matrix((matrix.data * kept[matrix.indices], matrix.indices, matrix.indptr), shape=matrix.shape)
    whole, left = np.asarray(matrix.sum(axis=1)).ravel(), np.asarray(masked.sum(axis=1)).ravel()
    lost = left <= 0.0
    if lost.any():
        keep = np.repeat(lost, np.diff(matrix.indptr)) | kept[matrix.indices]
        masked = csr_matrix((matrix.data * keep, matrix.indices, matrix.indptr), shape=matrix.shape)
        left = np.where(lost, whole, left)
    return _scaled_rows(masked, whole / left)


def _with_images(matrix: csr_matrix, images: IntArray, factors: Array) -> csr_matrix:
    """The matrix with its weights on the columns' images (n,) as well, there times a factor for each row (N,).

    Columns may stand in a row twice, and in any order.
    """
    first, columns, weights = _entries_with_images(matrix.indptr, matrix.indices, matrix.data, images, factors)
    return csr_matrix((weights, columns, first), shape=matrix.shape)


@compiled
def _entries_with_images(
    first: IntArray, columns: IntArray, weights: Array, images: IntArray, factors: Array
) -> tuple[IntArray, IntArray, Array]:
    starts = np.zeros_like(first)
    for row in range(len(factors)):
        count = first[row + 1] - first[row]
        starts[row + 1] = starts[row] + (count if factors[row] == 0.0 else 2 * count)
    found, values = np.empty(starts[-1], dtype=columns.dtype), np.empty(starts[-1])
    for row in range(len(factors)):
        used = starts[row]
        for entry in range(first[row], first[row + 1]):
            found[used], values[used] = columns[entry], weights[entry]
            used += 1
        if factors[row] != 0.0:
            for entry in range(first[row], first[row + 1]):
                found[used], values[used] = images[columns[entry]], factors[row] * weights[entry]
                used += 1
    return starts, found, values


def _scaled_rows(matrix: csr_matrix, factors: Array) -> csr_matrix:
    return csr_matrix(
        (matrix.data * np.repeat(factors, np.diff(matrix.indptr)), matrix.indices, matrix.indptr), matrix.shape
    )


def _scaled_columns(matrix: csr_matrix, factors: Array) -> csr_matrix:
    return csr_matrix((matrix.data * factors[matrix.indices], matrix.indices, matrix.indptr), matrix.shape)
