"""Displacements by tractions on paired nodes of both bodies, all three components in world axes.

An unknown is the traction at a node of one position of a cycle; with a mirror plane y = 0 it stands for the mirrored
traction at the node's image, too. N counts the unknowns of all positions, one position after another.
"""

from collections.abc import Sequence

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity.pairing import Pairing
from solvers.elasticity.placement import PlacedBody
from solvers.jit_cache import compiled
from solvers.wear_step.symmetry import Mirror

_AT_ONCE = 64  # Loaded nodes whose compliances are gathered together: those of some hundred nodes fit into a cache.


def displaced(body: PlacedBody, nodes: IntArray, forces: Array) -> Array:
    """Displacements (c, n, 3) in mm of a patch's nodes under c fields of nodal forces (c, n, 3) in N. Those of `nodes`
    (k,) alone are computed; all others are returned as 0.
    """
    loaded, everywhere = np.flatnonzero(forces.any(axis=(0, 2))), np.zeros_like(forces)
    moved = np.zeros((len(forces), 3 * len(nodes)))
    for begin in range(0, len(loaded), _AT_ONCE):
        some = loaded[begin : begin + _AT_ONCE]
        moved += forces[:, some].reshape(len(forces), -1) @ body.folded.between(some, nodes)
    everywhere[:, nodes] = moved.reshape(len(forces), -1, 3)
    return everywhere


class Influences:
    """Displacement of the upper relative to the lower body at all unknowns of a position, averaged over what faces
    them, by a unit traction on one of them and its image. Computed on demand, by `know`.

    store: blocks one after another, each (u, 3, 3) in mm/MPa, flat: at the u unknowns of its position, by component of
    displacement and of traction. at: (N,) index in `store` of the block of each loaded unknown, -1 if not yet computed.
    """

    def __init__(
        self,
        bodies: tuple[PlacedBody, PlacedBody],
        pairings: Sequence[Pairing],
        rows: Sequence[IntArray],
        across: Mirror | None,
    ) -> None:
        """Without any influence yet.

        bodies: primary and secondary. pairings: one for each position. rows: for each position, (u,) which of the
        pairing's nodes are unknowns. across: the mirror y -> -y, whose images carry mirrored tractions; None without
        symmetry.
        """
        self._bodies, self._pairings, self._rows, self.across = bodies, pairings, rows, across
        self._start = np.concatenate([[0], np.cumsum([len(own) for own in rows])])
        self.at, self.store, self._used = np.full(self._start[-1], -1), np.empty(0), 0
        self._dense: tuple[int, int, Array] | None = None  #: The latest of `dense`: of what it is, and itself.
        #: For each position, the first one at which the bodies face each other alike, as they do around a core.
        self._like = [
            next(k for k in range(index + 1) if pairings[k].faces_as(own) and np.array_equal(rows[k], rows[index]))
            for index, own in enumerate(pairings)
        ]

    def know(self, loaded: BoolArray) -> None:
        """Compute and keep the influences, not yet known, of tractions on the unknowns marked in `loaded` (N,)."""
        missing = np.flatnonzero(loaded & (self.at < 0))
        for k in np.unique(np.searchsorted(self._start, missing, side="right") - 1):
            begin, end, first = self._start[k], self._start[k + 1], self._start[self._like[k]]
            own = missing[(missing >= begin) & (missing < end)] - begin
            new = own[self.at[first + own] < 0]
            if len(new):
                self._add(self._like[k], new)
            self.at[begin + own] = self.at[first + own]

    def dense(self, k: int) -> Array:
        """Influences at the position of index k as (u, 3, u, 3) in mm/MPa: [i, a, j, b] is displacement a at unknown i
        by traction b on unknown j; 0 where they are not yet known.
        """
        k = self._like[k]
        if self._dense is not None and self._dense[:2] == (k, self._used):
            return self._dense[2]
        begin, end = self._start[k], self._start[k + 1]
        matrix, known = np.zeros((end - begin, 3, end - begin, 3)), begin + np.flatnonzero(self.at[begin:end] >= 0)
        for j in known:
            block = self.store[self.at[j] : self.at[j] + 9 * (end - begin)]
            matrix[:, :, j - begin] = block.reshape(-1, 3, 3)
        self._dense = k, self._used, matrix
        return matrix

    def _add(self, k: int, missing: IntArray) -> None:
        pairing, rows = self._pairings[k], self._rows[k]
        transfer, own, loaded, shares = pairing.opposite, pairing.nodes, rows[missing], np.ones(len(missing))
        begin, size = self._used, 9 * len(rows)
        self._used += len(missing) * size
        if self._used > len(self.store):
            self.store = np.concatenate([self.store[:begin], np.empty(max(self._used - begin, begin))])
        self.at[self._start[k] + missing] = begin + size * np.arange(len(missing))
        if self.across:
            # What lies on the plane is loaded as often as what lies beside it and its images are together.
            shares[self.across.primary[own[loaded]] == own[loaded]] = 0.5
        asked, asked_place = _numbered(transfer.faced_by(rows), transfer.size)
        faced, place = _numbered(transfer.faced_by(loaded), transfer.size)
        _influence(
            self.store[begin : self._used].reshape(len(missing), len(rows), 3, 3),
            self._moved(0, own[rows], own[loaded]),
            self._moved(1, asked, faced),
            *(pairing.areas, rows, loaded, shares, transfer.first),
            *(asked_place[transfer.columns], place[transfer.columns], transfer.weights),
        )

    def _moved(self, body: int, nodes: IntArray, loaded: IntArray) -> Array:
        """Displacements of a body's nodes (3 r, 3 c) by unit forces on others and mirrored ones on their images."""
        between = self._bodies[body].folded.between
        moved = between(nodes, loaded)
        if self.across:
            images = (self.across.primary, self.across.secondary)[body]
            between(nodes, images[loaded], out=moved, add=self.across.signs)
        return moved


def _numbered(nodes: IntArray, size: int) -> tuple[IntArray, IntArray]:
    """Some of so many nodes, each once and increasing, and every node's number among them, -1 of others, (size,)."""
    among = np.zeros(size, dtype=bool)
    among[nodes] = True
    return np.flatnonzero(among), np.where(among, np.cumsum(among) - 1, -1)


@compiled
def _influence(
    blocks: Array,
    own: Array,
    other: Array,
    areas: Array,
    rows: IntArray,
    loaded: IntArray,
    shares: Array,
    first: IntArray,
    asked: IntArray,
    columns: IntArray,
    weights: Array,
) -> None:
    """own: (3 r, 3 m) of the primary's rows by the loaded nodes.  other: (3 e, 3 f) of the secondary's nodes that the
    rows face, to which `asked` refers, by those that are faced by what is loaded, to which columns refer.
    blocks: (m, r, 3, 3) to be written.  loaded: (m,) nodes.  shares: (m,) of what they do that counts.
    """
    moved = np.empty(other.shape[1])
    for i in range(len(rows)):
        row = rows[i]
        for a in range(3):
            # Displacement of the row's node, averaged over the secondary nodes that it faces, by forces on all faced.
            moved[:] = 0.0
            for entry in range(first[row], first[row + 1]):
                source, weight = other[3 * asked[entry] + a], weights[entry] / areas[row]
                for c in range(len(moved)):
                    moved[c] += weight * source[c]
            direct = own[3 * i + a]
            for j in range(len(loaded)):
                node, target = loaded[j], blocks[j, i, a]
                # Three sums at once, which stay in registers: this is a run's innermost loop.
                x, y, z = direct[3 * j] * areas[node], direct[3 * j + 1] * areas[node], direct[3 * j + 2] * areas[node]
                for entry in range(first[node], first[node + 1]):
                    weight, k = weights[entry], 3 * columns[entry]
                    x += weight * moved[k]
                    y += weight * moved[k + 1]
                    z += weight * moved[k + 2]
                target[0], target[1], target[2] = shares[j] * x, shares[j] * y, shares[j] * z
