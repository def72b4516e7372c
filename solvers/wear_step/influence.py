"""What tractions on paired nodes do to both bodies: displacements at some of them, with all three components."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled
from solvers.pairing import Pairing
from solvers.placement import PlacedBody

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# What a mirror across the motion leaves of a vector's components in world axes.
_ACROSS = np.array([1.0, -1.0, 1.0])


def displaced(body: PlacedBody, nodes: IntArray, forces: Array) -> Array:
    """Displacements (c, k, 3) of patch nodes (k,) in mm under c fields of forces (c, n, 3) in N on all of them."""
    loaded = np.flatnonzero(forces.any(axis=(0, 2)))
    moved = forces[:, loaded].reshape(len(forces), -1) @ body.folded.between(loaded, nodes)
    return moved.reshape(len(forces), -1, 3)


class Influence:
    """Relative displacement of r paired nodes by unit tractions on the same nodes and their images, which is worked out
    for tractions on nodes that come into contact.

    matrix: (r, 3, r, 3), mm/MPa, zero for others. The second axis is the displacement's, the last the traction's
    component, in world axes.
    """

    def __init__(
        self, primary: PlacedBody, secondary: PlacedBody, pairing: Pairing, rows: IntArray, images: IntArray
    ) -> None:
        """Nothing is known yet.

        rows: (r,) of the pairing's nodes.  images: (r,) their mirror images across the motion, which carry mirrored
        tractions; a node that is its own image has none besides.
        """
        self._bodies, self._pairing, self._rows, self._images = (primary, secondary), pairing, rows, images
        # The mirror images are loaded, but what they do is asked for at the rows alone.
        self._asked, self._asked_place = _numbered(pairing.opposite.faced_by(rows), pairing.opposite.size)
        self._known = np.zeros(len(rows), dtype=bool)
        self.matrix = np.zeros((len(rows), 3, len(rows), 3))

    def of(self, on: IntArray) -> Array:
        """The matrix, with what tractions on some of the rows (a,) do."""
        missing = on[~self._known[on]]
        if len(missing):
            self._known[missing] = True
            self._add(missing)
        return self.matrix

    def _add(self, missing: IntArray) -> None:
        pairing, transfer = self._pairing, self._pairing.opposite
        (primary, secondary), loaded = self._bodies, np.stack([self._rows[missing], self._images[missing]], axis=1)
        needed, column = _numbered(loaded.ravel(), len(pairing.nodes))
        faced, place = _numbered(transfer.faced_by(needed), transfer.size)
        _add_influence(
            self.matrix,
            missing,
            primary.folded.between(pairing.nodes[self._rows], pairing.nodes[needed]),
            secondary.folded.between(self._asked, faced),
            pairing.areas,
            self._rows,
            loaded,
            column,
            _ACROSS,
            transfer.first,
            self._asked_place[transfer.columns],
            place[transfer.columns],
            transfer.weights,
        )


def _numbered(nodes: IntArray, size: int) -> tuple[IntArray, IntArray]:
    """Some of so many nodes, each once and increasing, and every node's number among them, -1 of others, (size,)."""
    among = np.zeros(size, dtype=bool)
    among[nodes] = True
    return np.flatnonzero(among), np.where(among, np.cumsum(among) - 1, -1)


@compiled
def _add_influence(
    matrix: Array,
    missing: IntArray,
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
    loaded: (m, 2) the nodes of the missing rows (m,), and their images.
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
            for j in range(len(missing)):
                target = matrix[i, a, missing[j]]
                for side in range(2):
                    node = loaded[j, side]
                    if side == 1 and node == loaded[j, 0]:
                        continue
                    k = 3 * column[node]
                    # Three sums at once, which stay in registers: this is a run's innermost loop.
                    x, y, z = direct[k] * areas[node], direct[k + 1] * areas[node], direct[k + 2] * areas[node]
                    for entry in range(first[node], first[node + 1]):
                        weight, k = weights[entry], 3 * columns[entry]
                        x += weight * moved[k]
                        y += weight * moved[k + 1]
                        z += weight * moved[k + 2]
                    if side == 1:
                        x, y, z = signs[0] * x, signs[1] * y, signs[2] * z
                    target[0] += x
                    target[1] += y
                    target[2] += z
