"""Compliance of two bodies as their paired contact nodes see it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.kept_code import compiled
from solvers.nodal_transfer import NodalTransfer, loaded_nodes
from solvers.pairing import Pairing
from solvers.placement import PlacedBody


class Block:
    """The part of a body's compliance that an increment needs: between w nodes of its patch and those that carry load.

    nodes: (w,).  places: (n,) of the patch's nodes among them.
    """

    def __init__(self, body: PlacedBody, nodes: IntArray) -> None:
        """Of nodes (w,), increasing; those that carry load are gathered as they become known."""
        self.nodes = nodes
        self.places = np.full(body.patch.size, -1)
        self.places[nodes] = np.arange(len(nodes))
        self._folded = body.folded
        self._row = np.full(body.patch.size, -1)
        self._rows = np.empty((0, 3 * len(nodes)))
        self._known = 0
        self._displaced: list[tuple[Array, Array]] = []

    def rows(self, loaded: IntArray) -> tuple[Array, IntArray]:
        """Displacement of the nodes by unit forces on others, (3 u, 3 w), and which rows are those of `loaded` (l,)."""
        missing = loaded[self._row[loaded] < 0]
        if len(missing):
            missing = np.unique(missing)
            self._row[missing] = self._known + np.arange(len(missing))
            begin, self._known = 3 * self._known, self._known + len(missing)
            if 3 * self._known > len(self._rows):
                grown = np.empty((max(3 * self._known, 2 * len(self._rows)), 3 * len(self.nodes)))
                grown[:begin] = self._rows[:begin]
                self._rows = grown
            self._folded.between(missing, self.nodes, out=self._rows[begin : 3 * self._known])
        return self._rows[: 3 * self._known], self._row[loaded]

    def displaced(self, force: Array) -> Array:
        """Displacement (w, 3) under forces (n, 3) in N on the patch's nodes; kept, for an increment ends with the
        forces with which the next one starts.
        """
        for known, moved in self._displaced:
            if known is force:
                return moved
        loaded = loaded_nodes(force)
        rows, place = self.rows(loaded)
        all_forces = np.zeros((len(rows) // 3, 3))
        all_forces[place] = force[loaded]
        moved = np.asarray((all_forces.ravel() @ rows).reshape(-1, 3))
        self._displaced = [*self._displaced[-1:], (force, moved)]
        return moved


def _block_between(body: PlacedBody, nodes: IntArray) -> Block:
    """A block that holds these nodes (w,): the body's latest, if it does, for an increment mostly needs what the one
    before did.
    """
    latest = body.latest_block
    if not latest or (latest[0].places[nodes] < 0).any():
        latest[:] = [Block(body, nodes)]
    block: Block = latest[0]
    return block


@dataclass(frozen=True)
class Share:
    """One body's part in a pairing: its block, and the transfers of the k nodes of now and the l loaded ones of before
    from the block's nodes.
    """

    block: Block
    now: NodalTransfer
    before: NodalTransfer

    @classmethod
    def of(cls, body: PlacedBody, now: NodalTransfer, before: NodalTransfer) -> "Share":
        """That of a body with transfers from its whole patch."""
        reached = np.zeros(body.patch.size, dtype=bool)
        reached[now.columns] = True
        reached[before.columns] = True
        block = _block_between(body, np.flatnonzero(reached))
        return cls(block, now.among(block.nodes, block.places), before.among(block.nodes, block.places))

    def add_responses(self, matrix: Array, first_column: int, loaded: IntArray, areas: Array) -> None:
        """Add displacements of the k nodes by unit tractions on nodes (l,) to columns of a matrix (3 k, 3 k)."""
        entries = self.now.faced_by(loaded)
        rows, place = self.block.rows(self.block.nodes[entries])
        row_of = np.full(len(self.block.nodes), -1)
        row_of[entries] = place
        _add_responses(
            matrix, first_column, rows, row_of, loaded, areas, self.now.first, self.now.columns, self.now.weights
        )


class Responses:
    """Displacement of the upper against the lower body at k nodes by unit tractions on those that have carried any.

    matrix: (3 k, 3 k), filled in its first 3 m columns for m nodes.  place: (k,) where a node's columns stand, or -1.
    """

    def __init__(self, shares: tuple[Share, Share], areas: Array) -> None:
        """Nothing is known yet."""
        self._shares, self._areas = shares, areas
        self.place = np.full(len(areas), -1)
        self.known = 0
        self._asked: IntArray | None = None
        self.matrix = np.empty((3 * len(areas), 3 * len(areas)))

    def know(self, loaded: IntArray) -> None:
        """Make sure that the responses to tractions on nodes (l,) are known."""
        if loaded is self._asked:
            return
        self._asked = loaded
        missing = loaded[self.place[loaded] < 0]
        if not len(missing):
            return
        self.place[missing] = self.known + np.arange(len(missing))
        self.matrix[:, 3 * self.known : 3 * (self.known + len(missing))] = 0.0
        for share in self._shares:
            share.add_responses(self.matrix, 3 * self.known, missing, self._areas)
        self.known += len(missing)


@dataclass(frozen=True)
class PairedCompliance:
    """Mean displacement of the upper against the lower body at k paired nodes under tractions there; world axes.

    Responses to tractions are put together for nodes that come to carry any.
    old: (k, 3) displacement by the forces before the increment where the nodes are now; old_before: (l, 3) the same
    where the nodes loaded before were then.  layer: compliance of an elastic layer between the bodies, the same in all
    directions, mm per MPa.
    """

    pairing: Pairing
    before: Pairing
    shares: tuple[Share, Share]
    old: Array
    old_before: Array
    layer: float = 0.0
    responses: Responses = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "responses", Responses(self.shares, self.pairing.areas))

    def displacement(self, traction: Array) -> Array:
        """Displacement in mm under tractions (k, 3) in MPa, shape (k, 3)."""
        responses = self.responses
        force, known = _on_known(traction, responses.place, responses.known)
        if not known:
            responses.know(loaded_nodes(traction))
            force, _ = _on_known(traction, responses.place, responses.known)
        moved = (responses.matrix[:, : len(force)] @ force).reshape(-1, 3)
        return moved + self.layer * traction if self.layer else np.asarray(moved)

    def moved(self, traction: Array, forces: tuple[Array, Array]) -> tuple[Array, Array]:
        """Motion of the upper against the lower body's material points over the increment by tractions (k, 3), the
        layer apart: of those that face each other at its end at the k nodes, and at its start at the l nodes then
        loaded, (k, 3) and (l, 3) in mm.

        forces: (n, 3) the tractions as nodal forces on each patch.
        """
        end = self.displacement(traction) - self.layer * traction - self.old
        fields = [share.block.displaced(force) for share, force in zip(self.shares, forces, strict=True)]
        return end, _mean([share.before for share in self.shares], fields, self.before.areas) - self.old_before


def paired_compliance(
    pairing: Pairing,
    before: Pairing,
    old_opposite: NodalTransfer,
    primary: PlacedBody,
    secondary: PlacedBody,
    old_forces: tuple[Array, Array],
    layer: float = 0.0,
) -> tuple[PairedCompliance, Array]:
    """Compliance of both bodies at k paired nodes, and the displacement (k, 3) in mm that old forces cause there.

    before: pairing of the l nodes that were loaded before the increment, as the bodies stood then.
    old_opposite: (k, n) transfer that averages the secondary's displacement under the old forces, from nodes that the
    pairing or the one before reaches.
    old_forces: (n, 3) nodal forces on each body's patch, with the sign of the force on the upper body; they do not
    act through the layer.
    """
    own = Share.of(primary, pairing.own, before.own)
    other = Share.of(secondary, pairing.opposite, before.opposite)
    shares = (own, other)
    fields = [share.block.displaced(force) for share, force in zip(shares, old_forces, strict=True)]
    now = _mean([share.now for share in shares], fields, pairing.areas)
    then = _mean([own.now, old_opposite.among(other.block.nodes, other.block.places)], fields, pairing.areas)
    old_before = _mean([share.before for share in shares], fields, before.areas)
    return PairedCompliance(pairing, before, shares, now, old_before, layer), then


def displacement_at(pairing: Pairing, primary: PlacedBody, secondary: PlacedBody, forces: tuple[Array, Array]) -> Array:
    """Displacement (k, 3) in mm of the upper against the lower body at a pairing's nodes, by nodal forces (n, 3) on
    each patch with the sign of the force on the upper body.
    """
    nowhere = NodalTransfer.single(pairing.nodes[:0], pairing.areas[:0], pairing.own.size)
    own = Share.of(primary, pairing.own, nowhere)
    other = Share.of(secondary, pairing.opposite, nowhere)
    fields = [share.block.displaced(force) for share, force in zip((own, other), forces, strict=True)]
    return _mean([own.now, other.now], fields, pairing.areas)


def _mean(transfers: Sequence[NodalTransfer], fields: Sequence[Array], areas: Array) -> Array:
    """Mean displacement (k, 3) of the upper against the lower body, of fields (w, 3) on the nodes of either."""
    first, second = (transfer.averaged(field) for transfer, field in zip(transfers, fields, strict=True))
    return np.asarray((first + second) / areas[:, None])


@compiled
def _on_known(traction: Array, place: IntArray, known: int) -> tuple[Array, bool]:
    """Tractions (k, 3) in the order in which nodes became known, (3 known,), and whether all loaded ones are known."""
    force, complete = np.zeros(3 * known), True
    for k in range(len(traction)):
        for c in range(3):
            if traction[k, c] != 0.0:
                complete &= place[k] >= 0
                if place[k] >= 0:
                    force[3 * place[k] + c] = traction[k, c]
    return force, complete


@compiled
def _add_responses(
    matrix: Array,
    first_column: int,
    rows: Array,
    row_of: IntArray,
    loaded: IntArray,
    areas: Array,
    first: IntArray,
    columns: IntArray,
    weights: Array,
) -> None:
    moved, row = np.zeros((3 * len(loaded), rows.shape[1])), 3 * row_of[columns]
    for j in range(len(loaded)):
        for b in range(3):
            _add_weighted(moved[3 * j + b], rows, row, b, weights, 1.0, first[loaded[j]], first[loaded[j] + 1])
    by_row, row = np.ascontiguousarray(moved.T), 3 * columns
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
