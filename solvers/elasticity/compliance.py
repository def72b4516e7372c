"""Compliance of two bodies between their paired contact nodes, gathered column by column as nodes become loaded.

A node is known once the displacements by unit forces or tractions on it are stored. Nodes keep the order in which they
became known: `place` and `row` hold a node's number in such an order, -1 where it is not known.
"""

from functools import cached_property
from weakref import proxy

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.elasticity.nodal_transfer import NodalTransfer, loaded_nodes
from solvers.elasticity.pairing import Pairing
from solvers.elasticity.placement import PlacedBody
from solvers.jit_cache import compiled, inlined

#: Factors of a vector's components by the mirror across the motion.
ACROSS = np.array([1.0, -1.0, 1.0])


class Block:
    """The part of one body's compliance that an increment needs: displacements of w nodes by forces on u known ones, of
    n nodes of the patch.

    nodes: (w,) increasing. place: (n,) number among the w nodes of each patch node, or -1. row: (n,) number among the u
    known ones, or -1. rows: (3 u or more, 3 w) in mm/N, displacements by unit forces, one row a force.
    """

    def __init__(self, body: PlacedBody, nodes: IntArray) -> None:
        """A block for the displacements of `nodes` (w,), without any known node."""
        self._folded, self.nodes, self._known = body.folded, nodes, 0
        self.row, self.place = np.full((2, body.patch.size), -1)
        self.place[nodes] = np.arange(len(nodes))
        self.rows = np.empty((0, 3 * len(nodes)))
        self._displaced: list[tuple[Array, Array]] = []

    def know(self, missing: IntArray) -> None:
        """Gather the displacements by unit forces on the patch nodes `missing`, all of which must be unknown as yet."""
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
        """Displacement (w, 3) in mm under forces (n, 3) in N on the patch's nodes.

        The last two results are kept: an increment ends with the forces with which the next one starts.
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
    """A block that holds all nodes of the body that the transfers `now` and `before` reach.

    It is the body's latest block where that holds them, since an increment mostly needs what the one before did.
    """
    latest = body.latest_block
    reached, held = _reached(latest[0].place if latest else np.full(body.patch.size, -1), now.columns, before.columns)
    if not held:
        latest[:] = [Block(body, reached)]
    block: Block = latest[0]
    return block


class PairedCompliance:
    """Mean displacement of the upper relative to the lower body at k paired nodes by tractions there, in world axes.

    matrix: (3 k, 3 k) in mm per MPa, of which the first 3 m columns are filled, for the m nodes known. known: m. place:
    (k,) a node's number i among the known ones, whose columns begin at 3 i, or -1. old, old_before: displacement in mm
    by the forces before the increment, (k, 3) at the nodes' present positions, and (l, 3) at the nodes loaded before,
    in their earlier positions. layer: compliance of an elastic layer between the bodies, equal in all directions, mm
    per MPa; displacements are without it.
    """

    def __init__(
        self,
        pairing: Pairing,
        before: Pairing,
        bodies: tuple[PlacedBody, PlacedBody],
        old_forces: tuple[Array, Array],
        layer: float = 0.0,
        still: tuple[IntArray, Array] | None = None,
    ) -> None:
        """bodies: primary and secondary. before: pairing of the l nodes that were loaded before the increment, as the
        bodies stood then. old_forces: (n, 3) nodal forces in N on each body's patch before it, with the sign of the
        force on the upper body. layer: mm per MPa, 0 for none. still: if the bodies go on facing each other as they did
        then, (l,) indices of these nodes among the pairing's, and tractions (k, 3) in MPa then; None if they do not.
        """
        self._pairing, self._before, self.layer, self._bodies = pairing, before, layer, bodies
        self._still = None if still is None else still[0]
        self.place, self.known = np.full(len(pairing.nodes), -1), 0
        self.matrix = np.empty((3 * len(pairing.nodes), 3 * len(pairing.nodes)))
        self.taken_over: PairedCompliance | None = None  #: An earlier increment's, whose matrix this one uses.
        self.mirrored: MirroredCompliance | None = None  #: For tractions that are their own mirror image, if they are.
        self.latest: tuple[Array, Array] | None = None  #: The tractions seen last, and the displacements by them.
        alike = self._alike() if still is not None else None
        known = None if alike is None else alike.latest
        if still is not None and known is not None and np.array_equal(known[0], still[1]):
            self.old, self.old_before = known[1], known[1][still[0]]
        else:
            self.old, self.old_before = self._mean(pairing, old_forces), self._mean(before, old_forces)

    @cached_property
    def _blocks(self) -> tuple[Block, Block]:
        (primary, secondary), now, before = self._bodies, self._pairing, self._before
        return _block_between(primary, now.own, before.own), _block_between(secondary, now.opposite, before.opposite)

    def _alike(self) -> "PairedCompliance | None":
        """The latest compliance of the two bodies if they faced each other in it as they do here."""
        latest = [own for body, own in self._bodies[0].latest_compliance if body is self._bodies[1]]
        return latest[0] if latest and latest[0]._pairing.faces_as(self._pairing) else None  # noqa: SLF001 - its own

    def know(self, loaded: IntArray) -> None:
        """Gather the displacements by unit tractions on the nodes of index `loaded` (l,) that are not yet known."""
        if not self.known and len(loaded):
            alike = self._alike()
            self._bodies[0].latest_compliance[:] = [(self._bodies[1], self)]
            if alike is not None:
                # Where a contact sticks, the bodies go on facing each other as they did.
                self.matrix, self.known, self.taken_over = alike.matrix, alike.known, alike
                alike.taken_over = None  # Else no increment's matrices would ever be given back.
                self.place[:] = alike.place
        missing, pairing = loaded[self.place[loaded] < 0], self._pairing
        if not len(missing):
            return
        begin, self.known = 3 * self.known, self.known + len(missing)
        self.place[missing] = begin // 3 + np.arange(len(missing))
        self.matrix[:, begin : 3 * self.known] = 0.0
        for block, transfer in zip(self._blocks, (pairing.own, pairing.opposite), strict=True):
            block.know(_unknown(block.row, transfer, missing))
            _add_responses(self.matrix, begin, block.rows, block.row, block.place, missing, pairing.areas, transfer)

    def displacement(self, traction: Array) -> Array:
        """Displacement (k, 3) in mm of the upper relative to the lower body under tractions (k, 3) in MPa."""
        side = self.mirrored
        moved = self.displaced(self.in_order(traction)) if side is None else side.displacement(traction)
        self.latest = traction, moved
        return moved

    def in_order(self, traction: Array) -> Array:
        """Tractions (k, 3) in MPa as (3 m,), node by node in the order in which the m nodes became known; 0 for those
        without traction. Nodes under traction that are not known yet are made known before.
        """
        force, complete = _on_known(traction, self.place, self.known)
        if not complete:
            self.know(loaded_nodes(traction))
            force, _ = _on_known(traction, self.place, self.known)
        return force

    def displaced(self, force: Array) -> Array:
        """Displacement (k, 3) in mm of the upper relative to the lower body by tractions (3 m,) in MPa on the first m
        known nodes.
        """
        return np.asarray((self.matrix[:, : len(force)] @ force).reshape(-1, 3))

    def moved(self, traction: Array, forces: tuple[Array, Array]) -> tuple[Array, Array]:
        """Elastic motion in mm of the upper relative to the lower body over the increment: (k, 3) of the points that
        face each other at the k nodes at its end, and (l, 3) of those at the l nodes loaded at its start.

        traction: (k, 3) in MPa at its end. forces: (n, 3) the same as nodal forces in N on (primary, secondary).
        """
        moved = self.displacement(traction) - self.old
        still = self._still
        return moved, self._mean(self._before, forces) - self.old_before if still is None else moved[still]

    def _mean(self, pairing: Pairing, forces: tuple[Array, Array]) -> Array:
        """Mean displacement (k, 3) of the upper relative to the lower body at a pairing's nodes, by nodal forces on
        each patch.
        """
        (own, other), (own_place, other_place) = self._blocks, (block.place for block in self._blocks)
        fields = own.displaced(forces[0]), other.displaced(forces[1])
        return _mean(pairing.opposite, other_place, fields[1], pairing.own, own_place, fields[0], pairing.areas)


class MirroredCompliance:
    """A paired compliance for tractions that are their own mirror image about the plane y = 0, along the motion.

    It holds the r of the k nodes with y >= 0; tractions on them act on the mirror images, too. Methods and attributes
    are those of `PairedCompliance` that an algorithm of contact uses, for these r nodes.
    """

    def __init__(self, whole: PairedCompliance, kept: IntArray, images: IntArray) -> None:
        """kept: (r,) indices of the held nodes among the k. images: (k,) index of each node's mirror image."""
        # The whole keeps this one: kept by it in turn, both would hold their matrices until garbage is collected.
        self._whole = proxy(whole)
        self.kept, self._images, self.layer = kept, images[kept], whole.layer
        self.place, self.known = np.full(len(kept), -1), 0
        self.matrix = np.empty((3 * len(kept), 3 * len(kept)))
        whole.mirrored = self

    def know(self, loaded: IntArray) -> None:
        missing = loaded[self.place[loaded] < 0]
        if not len(missing):
            return
        whole, first, before = self._whole, self.known, None
        whole.know(self.kept[missing])
        if first == 0 and whole.taken_over is not None:
            before = whole.taken_over.mirrored
        if before is not None and np.array_equal(before.kept, self.kept):
            self.matrix, self.known = before.matrix, before.known
            self.place[:] = before.place
            first, missing = self.known, missing[self.place[missing] < 0]
            if not len(missing):
                return
        self.place[missing] = first + np.arange(len(missing))
        self.known = first + len(missing)
        columns, alone = whole.place[self.kept[missing]], self._images[missing] == self.kept[missing]
        _fold(self.matrix, first, whole.matrix, self.kept, self._images, columns, alone)

    def displacement(self, traction: Array) -> Array:
        """Displacement (k, 3) in mm at all nodes under tractions (k, 3) in MPa that are their own mirror image."""
        side = self.displaced(self.in_order(traction[self.kept]))
        result = np.empty((len(traction), 3))
        result[self._images], result[self.kept] = side * ACROSS, side
        return result

    def in_order(self, traction: Array) -> Array:
        self.know(loaded_nodes(traction))
        force = np.zeros((self.known, 3))
        there = self.place >= 0
        force[self.place[there]] = traction[there]
        return force.ravel()

    def displaced(self, force: Array) -> Array:
        return np.asarray((self.matrix[:, : len(force)] @ force).reshape(-1, 3))


def displacement_at(pairing: Pairing, primary: PlacedBody, secondary: PlacedBody, forces: tuple[Array, Array]) -> Array:
    """Displacement (k, 3) in mm of the upper relative to the lower body, in world axes: means over what each of the
    pairing's k nodes stands for. forces: (n, 3) in N on each patch's own n nodes, signed as those on the upper body.
    """
    return PairedCompliance(pairing, pairing, (primary, secondary), forces).old


@compiled
def _reached(place: IntArray, now: IntArray, before: IntArray) -> tuple[IntArray, bool]:
    """Nodes (w,), increasing, that occur in `now` or `before`, and whether all of them have a place (>= 0)."""
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
    """Nodes of the patch, increasing, that contribute to the contact nodes `loaded` (l,) of a transfer and have no row
    yet.
    """
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
    """Sum of two transfers' weighted averages of fields (w, 3), over the areas (k,): (k, 3).

    other_place, own_place: (n,) index of a patch node in its field.
    """
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
    """A field (k, 3) as (3 known,) in the order of the known nodes, and whether all nodes with a non-zero value are
    known.
    """
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
    """Add a body's displacements at the k nodes by unit tractions on nodes (l,) to columns of a matrix (3 k, 3 k), in
    place.

    rows, row_of, place: `Block.rows`, `row` and `place`.  transfer: from the patch to the k nodes.
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
    """Add the rows row[e] + shift of a matrix, times weights[e] / area, to the target for e from `begin` to before
    `end`.

    Four rows at a time, which saves passes over the target.
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
    """Write the columns of `matrix` from node `first` on: displacements of kept nodes by unit tractions on a node and
    its image.

    Those by a traction on the image are those by the traction on the node, taken at the images and mirrored. columns:
    (l,) places of the nodes in `whole`.  alone: (l,) True for nodes that are their own image.
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
