"""What tractions on paired nodes do to both bodies: displacements at some of them, with all three components."""

from collections.abc import Sequence

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from solvers.kept_code import compiled
from solvers.pairing import Pairing
from solvers.placement import PlacedBody

_ACROSS = np.array([1.0, -1.0, 1.0])  # What a mirror across the motion leaves of a vector's components in world axes.


_AT_ONCE = 64  # Loaded nodes whose compliances are gathered together: those of some hundred nodes fit into a cache.


def displaced(body: PlacedBody, nodes: IntArray, forces: Array) -> Array:
    """Displacements (c, n, 3) in mm of patch nodes (k,), zero of others, under c fields of forces (c, n, 3) in N."""
    loaded, everywhere = np.flatnonzero(forces.any(axis=(0, 2))), np.zeros_like(forces)
    moved = np.zeros((len(forces), 3 * len(nodes)))
    for begin in range(0, len(loaded), _AT_ONCE):
        some = loaded[begin : begin + _AT_ONCE]
        moved += forces[:, some].reshape(len(forces), -1) @ body.folded.between(some, nodes)
    everywhere[:, nodes] = moved.reshape(len(forces), -1, 3)
    return everywhere


class Influences:
    """Relative displacement of the nodes of each position of a cycle by unit tractions on one of them and its image,
    worked out when it is first asked for; N unknowns of all positions one after another.

    store: those known, one block after another: (u, 3, 3) mm/MPa of the u unknowns at the loaded one's position, by
    component of displacement and traction in world axes.  at: (N,) where the block of each begins, or -1.
    """

    def __init__(
        self,
        bodies: tuple[PlacedBody, PlacedBody],
        pairings: Sequence[Pairing],
        nodes: Sequence[tuple[IntArray, IntArray]],
    ) -> None:
        """Nothing is known yet.

        bodies: primary and secondary.  nodes: for each position, (u,) its unknowns among the pairing's nodes, and their
        mirror images across the motion, which carry mirrored tractions; a node that is its own image has none besides.
        """
        self._bodies, self._pairings, self._nodes = bodies, pairings, nodes
        self._start = np.concatenate([[0], np.cumsum([len(rows) for rows, _ in nodes])])
        self.at, self.store, self._used = np.full(self._start[-1], -1), np.empty(0), 0

    def know(self, loaded: BoolArray) -> None:
        """Work out what tractions on loaded ones of the unknowns (N,) do."""
        missing = np.flatnonzero(loaded & (self.at < 0))
        for k in np.unique(np.searchsorted(self._start, missing, side="right") - 1):
            begin, end = self._start[k], self._start[k + 1]
            self._add(k, missing[(missing >= begin) & (missing < end)] - begin)

    def dense(self, k: int) -> Array:
        """Those at one position, (u, 3, u, 3) with the traction's unknown and component last, zero where not known."""
        begin, end = self._start[k], self._start[k + 1]
        matrix, known = np.zeros((end - begin, 3, end - begin, 3)), begin + np.flatnonzero(self.at[begin:end] >= 0)
        for j in known:
            block = self.store[self.at[j] : self.at[j] + 9 * (end - begin)]
            matrix[:, :, j - begin] = block.reshape(-1, 3, 3)
        return matrix

    def _add(self, k: int, missing: IntArray) -> None:
        pairing, (rows, images) = self._pairings[k], self._nodes[k]
        transfer, (primary, secondary) = pairing.opposite, self._bodies
        begin, size = self._used, 9 * len(rows)
        self._used += len(missing) * size
        if self._used > len(self.store):
            self.store = np.concatenate([self.store[:begin], np.empty(max(self._used - begin, begin))])
        self.at[self._start[k] + missing] = begin + size * np.arange(len(missing))
        # The mirror images are loaded, but what they do is asked for at the rows alone.
        loaded = np.stack([rows[missing], images[missing]], axis=1)
        needed, column = _numbered(loaded.ravel(), len(pairing.nodes))
        asked, asked_place = _numbered(transfer.faced_by(rows), transfer.size)
        faced, place = _numbered(transfer.faced_by(needed), transfer.size)
        _influence(
            self.store[begin : self._used].reshape(len(missing), len(rows), 3, 3),
            primary.folded.between(pairing.nodes[rows], pairing.nodes[needed]),
            secondary.folded.between(asked, faced),
            *(pairing.areas, rows, loaded, column, _ACROSS, transfer.first),
            *(asked_place[transfer.columns], place[transfer.columns], transfer.weights),
        )


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
    column: IntArray,
    signs: Array,
    first: IntArray,
    asked: IntArray,
    columns: IntArray,
    weights: Array,
) -> None:
    """own: (3 r, 3 c) of the primary's rows; column: of each of its nodes among the c.  other: (3 e, 3 f) of the
    secondary's nodes that the rows face, to which `asked` refers, and of all that are faced, to which columns refer.
    blocks: (m, r, 3, 3) to be written.  loaded: (m, 2) the loaded nodes and their images.
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
                target = blocks[j, i, a]
                for side in range(1 if loaded[j, 1] == loaded[j, 0] else 2):
                    node = loaded[j, side]
                    k = 3 * column[node]
                    # Three sums at once, which stay in registers: this is a run's innermost loop.
                    x, y, z = direct[k] * areas[node], direct[k + 1] * areas[node], direct[k + 2] * areas[node]
                    for entry in range(first[node], first[node + 1]):
                        weight, k = weights[entry], 3 * columns[entry]
                        x += weight * moved[k]
                        y += weight * moved[k + 1]
                        z += weight * moved[k + 2]
                    if side == 0:
                        target[0], target[1], target[2] = x, y, z
                    else:
                        target[0] += signs[0] * x
                        target[1] += signs[1] * y
                        target[2] += signs[2] * z
