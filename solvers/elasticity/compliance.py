"""Compliance of two bodies as their paired contact nodes see it."""

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.elasticity.nodal_transfer import NodalTransfer, loaded_nodes
from solvers.elasticity.pairing import Pairing
from solvers.elasticity.placement import PlacedBody
from solvers.jit_cache import compiled, inlined

#: Factors of a vector's components by the mirror across the motion.
ACROSS = np.array([1.0, -1.0, 1.0])


class Block:
    """The part of a body's compliance that an increment needs: what unit forces on u nodes that carry load do to w.

    nodes: (w,), increasing.  place, row: (n,) which of the w each node of the patch is, and which of the u, or -1.
    rows: (3 u, 3 w) and room for more, mm/N.
    """

    def __init__(self, body: PlacedBody, nodes: IntArray) -> None:
        """Nothing is known yet; what loads do is gathered as they become known."""
        self._folded, self.nodes, self._known = body.folded, nodes, 0
        self.row, self.place = np.full((2, body.patch.size), -1)
        self.place[nodes] = np.arange(len(nodes))
        self.rows = np.empty((0, 3 * len(nodes)))
        self._displaced: list[tuple[Array, Array]] = []

    def know(self, missing: IntArray) -> None:
        """Gather what forces on more nodes do."""
        if not len(missing):
            return
        self.row[missing] = self._known + np.arange(len(missing))
        begin, self._known = 3 * self._known, self._known + len(missing)
        if 3 * self._known > len(self.rows):
            grown = np.empty((max(3 * self._known, 2 * len(self.rows)), 3 * len(self.nodes)))
            grown[:begin] = self.rows[:begin]
            self.rows = grown
        self._folded.between(missing, self.nodes, out=self.rows[begin : 3 * self._known])

    def displaced(self, force: Array) -> Array:
        """Displacement (w, 3) under forces (n, 3) in N on the patch's nodes; kept, for an increment ends with the
        forces with which the next one starts.
        """
        for known, moved in self._displaced:
            if known is force:
                return moved
        forces, complete = _on_known(force, self.row, self._known)
        if not complete:
            loaded = loaded_nodes(force)
            self.know(loaded[self.row[loaded] < 0])
            forces, _ = _on_known(force, self.row, self._known)
        moved = np.asarray((forces @ self.rows[: len(forces)]).reshape(-1, 3))
        self._displaced = [*self._displaced[-1:], (force, moved)]
        return moved


def _block_between(body: PlacedBody, now: NodalTransfer, before: NodalTransfer) -> Block:
    """A block that holds the nodes which transfers reach: the body's latest, if it does, for an increment mostly needs
    what the one before did.
    """
    latest = body.latest_block
    reached, held = _reached(latest[0].place if latest else np.full(body.patch.size, -1), now.columns, before.columns)
    if not held:
        latest[:] = [Block(body, reached)]
    block: Block = latest[0]
    return block


class PairedCompliance:
    """Mean displacement of the upper against the lower body at k paired nodes under tractions there; world axes.

    matrix: (3 k, 3 k) in mm per MPa, filled in its first 3 m columns for the m nodes that have carried tractions.
    place: (k,) where a node's columns stand, or -1.
    old: (k, 3) displacement by the forces before the increment where the nodes are now; old_before: (l, 3) the same
    where the nodes loaded before were then.  layer: compliance of an elastic layer between the bodies, the same in all
    directions, mm per MPa.
    """

    def __init__(
        self,
        pairing: Pairing,
        before: Pairing,
        bodies: tuple[PlacedBody, PlacedBody],
        old_forces: tuple[Array, Array],
        layer: float = 0.0,
    ) -> None:
        """Of the primary and the secondary.

        before: pairing of the l nodes that were loaded before the increment, as the bodies stood then.
        old_forces: (n, 3) nodal forces on each body's patch before it, with the sign of the force on the upper body;
        they do not act through the layer.
        """
        self._pairing, self._before, self.layer = pairing, before, layer
        primary, secondary = bodies
        self._blocks = (
            _block_between(primary, pairing.own, before.own),
            _block_between(secondary, pairing.opposite, before.opposite),
        )
        self.old, self.old_before = self._mean(pairing, old_forces), self._mean(before, old_forces)
        self.place, self.known = np.full(len(pairing.nodes), -1), 0
        self.matrix = np.empty((3 * len(pairing.nodes), 3 * len(pairing.nodes)))
        self._latest, self._facing = primary.latest_compliance, secondary
        self.taken_over: PairedCompliance | None = None  #: That of an increment before, whose matrix it is.
        self.mirrored: MirroredCompliance | None = None  #: For tractions that are their own mirror image, if they are.

    def faces_as(self, pairing: Pairing) -> bool:
        """Whether another pairing of the same bodies is that of the same nodes at the same place."""
        own = self._pairing
        pairs = zip((own.nodes, *own.opposite[:3]), (pairing.nodes, *pairing.opposite[:3]), strict=True)
        return all(np.array_equal(one, other) for one, other in pairs)

    def know(self, loaded: IntArray) -> None:
        """Make sure that the responses to tractions on nodes (l,) are known."""
        missing, pairing = loaded[self.place[loaded] < 0], self._pairing
        if not len(missing):
            return
        latest = [] if self.known else [own for body, own in self._latest if body is self._facing]
        self._latest[:] = [(self._facing, self)]
        if latest and latest[0].faces_as(pairing) and latest[0].known_first(missing):
            # Where a contact sticks, the bodies go on facing each other as they did.
            self.matrix, self.known, self.taken_over = latest[0].matrix, len(missing), latest[0]
            self.place[missing] = np.arange(len(missing))
            return
        begin, self.known = 3 * self.known, self.known + len(missing)
        self.place[missing] = begin // 3 + np.arange(len(missing))
        self.matrix[:, begin : 3 * self.known] = 0.0
        for block, transfer in zip(self._blocks, (pairing.own, pairing.opposite), strict=True):
            block.know(_unknown(block.row, transfer, missing))
            _add_responses(self.matrix, begin, block.rows, block.row, block.place, missing, pairing.areas, transfer)

    def known_first(self, nodes: IntArray) -> bool:
        """Whether the nodes (l,) became known first, in this order."""
        return len(nodes) <= self.known and np.array_equal(self.place[nodes], np.arange(len(nodes)))

    def displacement(self, traction: Array) -> Array:
        """Displacement of the surfaces in mm under tractions (k, 3) in MPa, shape (k, 3)."""
        if self.mirrored is not None:
            return self.mirrored.displacement(traction)
        return self.displaced(self.in_order(traction))

    def in_order(self, traction: Array) -> Array:
        """Tractions (k, 3) as `displaced` takes them, whose responses are then known."""
        force, complete = _on_known(traction, self.place, self.known)
        if not complete:
            self.know(loaded_nodes(traction))
            force, _ = _on_known(traction, self.place, self.known)
        return force

    def displaced(self, force: Array) -> Array:
        """Displacements (k, 3) by forces (3 m,) on the m known nodes, in the order in which they became so."""
        return np.asarray((self.matrix[:, : len(force)] @ force).reshape(-1, 3))

    def moved(self, traction: Array, forces: tuple[Array, Array]) -> tuple[Array, Array]:
        """Motion of the upper against the lower body's material points over the increment by tractions (k, 3): of those
        that face each other at its end at the k nodes, and at its start at the l nodes then loaded, (k, 3) and (l, 3)
        in mm.

        forces: (n, 3) the tractions as nodal forces on each patch.
        """
        return self.displacement(traction) - self.old, self._mean(self._before, forces) - self.old_before

    def _mean(self, pairing: Pairing, forces: tuple[Array, Array]) -> Array:
        """Mean displacement (k, 3) of the upper against the lower body at a pairing's nodes, by forces on both."""
        (own, other), (own_place, other_place) = self._blocks, (block.place for block in self._blocks)
        fields = own.displaced(forces[0]), other.displaced(forces[1])
        return _mean(pairing.opposite, other_place, fields[1], pairing.own, own_place, fields[0], pairing.areas)


class MirroredCompliance:
    """A paired compliance at r of its k nodes, on one side of the plane along the motion and on it, by tractions on
    these and their mirror images; as a contact algorithm asks for it, see `PairedCompliance`.
    """

    def __init__(self, whole: PairedCompliance, kept: IntArray, images: IntArray) -> None:
        """kept: (r,) the nodes' numbers among the k.  images: (k,) those of mirror images."""
        self._whole, self.kept, self._images, self.layer = whole, kept, images[kept], whole.layer
        self.place, self.known = np.full(len(kept), -1), 0
        self.matrix = np.empty((3 * len(kept), 3 * len(kept)))
        whole.mirrored = self

    def know(self, loaded: IntArray) -> None:
        """Make sure that the responses to tractions on nodes (l,) of the r are known."""
        missing = loaded[self.place[loaded] < 0]
        if not len(missing):
            return
        whole, first, before = self._whole, self.known, None
        whole.know(self.kept[missing])
        self.place[missing] = first + np.arange(len(missing))
        self.known = first + len(missing)
        if first == 0 and whole.taken_over is not None:
            before = whole.taken_over.mirrored
        if before is not None and np.array_equal(before.kept, self.kept) and before.known >= self.known:
            # What became known first on the whole did so on the side.
            self.matrix = before.matrix
            return
        columns, alone = whole.place[self.kept[missing]], self._images[missing] == self.kept[missing]
        _fold(self.matrix, first, whole.matrix, self.kept, self._images, columns, alone)

    def displacement(self, traction: Array) -> Array:
        """Displacement (k, 3) in mm at all nodes under tractions (k, 3) in MPa that are their own mirror image."""
        side = self.displaced(self.in_order(traction[self.kept]))
        result = np.empty((len(traction), 3))
        result[self._images], result[self.kept] = side * ACROSS, side
        return result

    def in_order(self, traction: Array) -> Array:
        """Tractions (r, 3) as `displaced` takes them, whose responses are then known."""
        self.know(loaded_nodes(traction))
        force = np.zeros((self.known, 3))
        there = self.place >= 0
        force[self.place[there]] = traction[there]
        return force.ravel()

    def displaced(self, force: Array) -> Array:
        """Displacement (r, 3) under tractions (3 m,) on the m nodes that are known, in the order they became so."""
        return np.asarray((self.matrix[:, : len(force)] @ force).reshape(-1, 3))


def displacement_at(pairing: Pairing, primary: PlacedBody, secondary: PlacedBody, forces: tuple[Array, Array]) -> Array:
    """Displacement (k, 3) in mm of the upper against the lower body at a pairing's nodes, by nodal forces (n, 3) on
    each patch with the sign of the force on the upper body.
    """
    return PairedCompliance(pairing, pairing, (primary, secondary), forces).old


@compiled
def _reached(place: IntArray, now: IntArray, before: IntArray) -> tuple[IntArray, bool]:
    """Nodes (w,), increasing, that are among those of now or before, and whether all have a place."""
    reached, found = np.zeros(len(place), np.bool_), np.empty(len(place), np.int64)
    for node in now:
        reached[node] = True
    for node in before:
        reached[node] = True
    held, used = True, 0
    for node in range(len(place)):
        if reached[node]:
            held &= place[node] >= 0
            found[used] = node
            used += 1
    return found[:used].copy(), held


@compiled
def _unknown(row: IntArray, transfer: NodalTransfer, loaded: IntArray) -> IntArray:
    """Nodes without a row, increasing, that the rows (l,) of a transfer reach."""
    reached, found, used = np.zeros(len(row), np.bool_), np.empty(len(row), np.int64), 0
    for k in loaded:
        for entry in range(transfer.first[k], transfer.first[k + 1]):
            reached[transfer.columns[entry]] = True
    for node in range(len(row)):
        if reached[node] and row[node] < 0:
            found[used] = node
            used += 1
    return found[:used].copy()


@compiled
def _mean(
    other: NodalTransfer,
    other_place: IntArray,
    other_field: Array,
    own: NodalTransfer,
    own_place: IntArray,
    own_field: Array,
    areas: Array,
) -> Array:
    """Sum over the areas of two transfers' averages of fields (w, 3), each on nodes at their places."""
    result = np.zeros((len(areas), 3))
    _add_averaged(result, other, other_place, other_field)
    _add_averaged(result, own, own_place, own_field)
    for k in range(len(areas)):
        for c in range(3):
            result[k, c] /= areas[k]
    return result


@inlined
def _add_averaged(result: Array, transfer: NodalTransfer, place: IntArray, field: Array) -> None:
    for k in range(len(result)):
        for entry in range(transfer.first[k], transfer.first[k + 1]):
            for c in range(3):
                result[k, c] += transfer.weights[entry] * field[place[transfer.columns[entry]], c]


@compiled
def _on_known(field: Array, place: IntArray, known: int) -> tuple[Array, bool]:
    """A field (k, 3) in the order in which nodes became known, (3 known,), and whether all loaded ones are known."""
    force, complete = np.zeros(3 * known), True
    for k in range(len(field)):
        for c in range(3):
            if field[k, c] != 0.0:
                complete &= place[k] >= 0
                if place[k] >= 0:
                    force[3 * place[k] + c] = field[k, c]
    return force, complete


@compiled
def _add_responses(
    matrix: Array,
    first_column: int,
    rows: Array,
    row_of: IntArray,
    place: IntArray,
    loaded: IntArray,
    areas: Array,
    transfer: NodalTransfer,
) -> None:
    """Add a body's displacements at the k nodes by unit tractions on nodes (l,) to columns of a matrix (3 k, 3 k).

    rows, row_of, place: of a block.  transfer: from the patch to the k nodes.
    """
    first, weights = transfer.first, transfer.weights
    moved, row = np.zeros((3 * len(loaded), rows.shape[1])), 3 * row_of[transfer.columns]
    for j in range(len(loaded)):
        for b in range(3):
            _add_weighted(moved[3 * j + b], rows, row, b, weights, 1.0, first[loaded[j]], first[loaded[j] + 1])
    by_row, row = np.ascontiguousarray(moved.T), 3 * place[transfer.columns]
    last_column = first_column + by_row.shape[1]
    for i in range(len(first) - 1):
        for a in range(3):
            target = matrix[3 * i + a, first_column:last_column]
            _add_weighted(target, by_row, row, a, weights, areas[i], first[i], first[i + 1])


@compiled
def _add_weighted(
    target: Array, rows: Array, row: IntArray, shift: int, weights: Array, area: float, begin: int, end: int
) -> None:
    """Add rows of a matrix, shifted, each times its weight over an area; four at a time, which spares passes over the
    target.
    """
    whole = end - (end - begin) % 4
    for e in range(begin, whole, 4):
        w, x, y, z = weights[e] / area, weights[e + 1] / area, weights[e + 2] / area, weights[e + 3] / area
        first, second = rows[row[e] + shift], rows[row[e + 1] + shift]
        third, fourth = rows[row[e + 2] + shift], rows[row[e + 3] + shift]
        for c in range(len(target)):
            target[c] = target[c] + w * first[c] + x * second[c] + y * third[c] + z * fourth[c]
    for e in range(whole, end):
        weight, only = weights[e] / area, rows[row[e] + shift]
        for c in range(len(target)):
            target[c] += weight * only[c]


@compiled
def _fold(
    matrix: Array, first: int, whole: Array, kept: IntArray, images: IntArray, columns: IntArray, alone: Array
) -> None:
    """Write columns from the first on: displacements of kept nodes by unit tractions on nodes and on their images,
    which are what those on the nodes do at the images, mirrored.
    """
    for i in range(len(kept)):
        for a in range(3):
            own, other = whole[3 * kept[i] + a], whole[3 * images[i] + a]
            sign, target = -1.0 if a == 1 else 1.0, matrix[3 * i + a]
            for j in range(len(columns)):
                source, place = 3 * columns[j], 3 * (first + j)
                share = 0.0 if alone[j] else sign
                for b in range(3):
                    target[place + b] = own[source + b] + share * other[source + b]
